"""How far places scatter about a path: whatever the speed of the camera, and however long errors last."""

import numpy as np
import pytest

from tracking.scatter import path_scatter


def fall(fps: float) -> np.ndarray:
    """Places of a ball that falls for a third of a second, px."""
    time = np.arange(0, 0.33, 1 / fps)
    return np.column_stack((np.zeros(len(time)), 4000 * time**2))


@pytest.mark.parametrize("fps", [120, 240, 1000])
def test_places_that_err_each_for_itself_scatter_as_they_err(fps: float) -> None:
    path = fall(fps)
    found = [
        path_scatter(np.arange(len(path)), path + np.random.default_rng(seed).normal(0, 0.1, path.shape))
        for seed in range(40)
    ]
    assert np.sqrt(np.mean(np.square(found))) == pytest.approx(0.1, rel=0.25)


@pytest.mark.parametrize("fps", [480, 1000])
def test_errors_that_last_until_the_ball_has_moved_on_are_seen(fps: float) -> None:
    path = fall(fps)
    found = []
    for seed in range(40):
        by_place = np.random.default_rng(seed).normal(0, 0.1, (1000, 2))  # anew every two pixels of its way
        found.append(path_scatter(np.arange(len(path)), path + by_place[(path[:, 1] // 2).astype(int)]))
    assert np.sqrt(np.mean(np.square(found))) == pytest.approx(0.1, rel=0.3)


def test_a_path_without_errors_does_not_scatter() -> None:
    path = fall(240)
    assert path_scatter(np.arange(len(path)), path) == pytest.approx(0, abs=1e-9)
    assert path_scatter(np.arange(3), path[:3]) == pytest.approx(0)

"""Motion in depth: seen in the size of a ball, undone in its path."""

import numpy as np
import pytest

from tracking.depth import motion_in_depth, undone
from tracking.track import Track

TIME = np.arange(120) / 120


def seen(size: np.ndarray, noise: float = 0.1, blur: float = 0.0) -> Track:
    """A ball of 20 px that bounces about the middle (300, 400) of a picture, `size` times as large."""
    height = 150 * np.abs(np.sin(7 * TIME))
    speed = np.abs(np.gradient(height, TIME))
    rng = np.random.default_rng(1)
    ones = np.ones(len(TIME))
    return Track(
        ball="upper",
        unit="px",
        frame=np.arange(len(TIME)),
        time=TIME,
        x=300 + 40 * size,
        y=400 - height * size,
        x_sd=0.1 * ones,
        y_sd=0.1 * ones,
        arc=6 * ones,
        radius=20.0,
        radius_sd=0.02,
        sizes=20 * size + noise * rng.standard_normal(len(TIME)) + blur * speed / speed.max(),
    )


@pytest.mark.parametrize("change", [-0.08, 0.05])
def test_a_ball_that_comes_or_goes_is_put_back_where_it_would_be(change: float) -> None:
    track = seen(1 + change * (TIME - 0.5))
    depth = motion_in_depth(track)
    assert depth.is_certain
    assert depth.change == pytest.approx(change, abs=3 * depth.change_sd + 0.003)
    assert undone(track, depth, (300, 400)).y == pytest.approx(seen(np.ones(120)).y, abs=0.6)


def test_blur_of_fast_frames_is_no_motion_in_depth() -> None:
    assert not motion_in_depth(seen(np.ones(120), blur=1.5)).is_certain


def test_sizes_that_scatter_and_too_few_frames_tell_nothing() -> None:
    assert not motion_in_depth(seen(np.ones(120), noise=1.5)).is_certain
    lonely = Track(
        ball="upper", unit="px", radius=1.0, radius_sd=1.0, frame=np.arange(3), time=TIME[:3],
        x=TIME[:3], y=TIME[:3], x_sd=TIME[:3], y_sd=TIME[:3], arc=TIME[:3],
    )  # fmt: skip
    assert not motion_in_depth(lonely).is_certain

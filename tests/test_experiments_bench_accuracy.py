"""The bench of accuracy: its bound is the true one, and what it films is what its scenes show."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from experiments.bench import Measured
from experiments.bench_accuracy import CRF, RADII_PX, drop, over_bound
from experiments.bench_bound import bound_of, centre_bounds, slopes
from experiments.bench_clips import Filmed, film, first_impact, pulled
from experiments.bench_velocity import biased, times
from tracking.render import DropScene, frames, write_recording
from tracking.render_stage import build_stage
from tracking.video import open_recording, read_frames

SMALL = drop(8, 1, shading=0.0)
FALLING = np.array([30])


def resting(radius: int, noise: float) -> DropScene:
    """A ball that is filmed without blur."""
    scene = drop(radius, 1, shading=0.0)
    return replace(scene, drop_height=0.06, camera=replace(scene.camera, exposure=0.0, noise=noise))


@pytest.fixture(scope="module")
def small() -> Filmed:
    return film(SMALL, None)


def test_least_squares_reach_the_bound_and_no_other_estimate_beats_it() -> None:
    rng = np.random.default_rng(5)
    slope = slopes(build_stage(SMALL, np.random.default_rng(SMALL.seed)), 30)
    noise = rng.normal(0, 2, (400, slope.shape[1]))
    best = noise @ np.linalg.pinv(slope)
    signs = noise @ (np.sign(slope) / np.abs(slope).sum(axis=1, keepdims=True)).T
    assert best.std(axis=0) == pytest.approx(bound_of(slope, 4.0), rel=0.12)
    assert np.all(signs.std(axis=0) > bound_of(slope, 4.0))


def test_bound_grows_with_noise_and_shrinks_with_the_root_of_the_radius() -> None:
    quiet, loud, larger = (
        centre_bounds(resting(radius, noise), FALLING) for radius, noise in ((8, 5.0), (8, 10.0), (32, 5.0))
    )
    assert loud / quiet == pytest.approx(np.full((1, 2), 2), rel=0.01)
    assert quiet / larger == pytest.approx(np.full((1, 2), 2), rel=0.15)


def test_recording_that_is_not_compressed_keeps_every_level(tmp_path: Path) -> None:
    write_recording(SMALL, tmp_path / "exact.mp4", crf=None)
    stored = [frame.image for frame in read_frames(open_recording(tmp_path / "exact.mp4"))]
    for ours, shown in zip(stored, frames(SMALL), strict=True):
        assert np.array_equal(ours, shown)


def test_colours_of_a_compressed_recording_lie_where_they_were(tmp_path: Path) -> None:
    write_recording(SMALL, tmp_path / "colour.mp4", crf=0)
    seen = [frame.image.astype(float) for frame in read_frames(open_recording(tmp_path / "colour.mp4"))][30]
    shown = list(frames(SMALL))[30].astype(float)
    off = {
        shift: np.abs(seen - np.roll(shown, shift, axis=(0, 1)))[8:-8, 8:-8].mean()
        for shift in ((0, 0), (1, 1), (-1, -1))
    }
    assert off[1, 1] == pytest.approx(off[-1, -1], rel=0.1)
    assert off[0, 0] < off[1, 1] / 2


def test_small_ball_is_located_within_twice_the_bound(small: Filmed) -> None:
    assert over_bound([small]) < 2
    assert len(small.errors) > 20
    assert pulled([small.errors], [10 * small.sd]) == pytest.approx(pulled([small.errors], [small.sd]) / 100)


def test_velocities_are_compared_with_those_of_the_scene(small: Filmed) -> None:
    impact, true = first_impact(small)
    assert impact.velocities[:2] == pytest.approx(true, rel=0.01)


def test_uneven_time_stamps_are_read_to_a_hundredth_of_a_millisecond() -> None:
    (row,) = times()
    assert 1e-4 < row.value <= 0.01
    assert row.met


def test_bias_is_told_with_its_standard_error() -> None:
    row = biased("velocity", np.array([0.001, 0.003]), 0.3)
    assert row == Measured(quantity="velocity (± 0.1)", value=pytest.approx(0.2), unit="%", most=0.3)


def test_a_small_ball_before_a_wall_of_its_hue_keeps_its_size() -> None:
    filmed = film(drop(8, 20_086), 23)
    assert filmed.track.radius == pytest.approx(8, rel=0.05)
    assert len(filmed.track.frame) > 60


@pytest.mark.slow
@pytest.mark.parametrize("radius", RADII_PX)
def test_in_scenes_that_nothing_was_tuned_to_no_ball_is_lost_or_taken_for_something_else(radius: int) -> None:
    for seed in range(34_000, 34_020):
        filmed = film(drop(radius, seed), CRF)
        assert filmed.track.radius == pytest.approx(radius, rel=0.05), seed
        assert np.median(np.abs(filmed.errors)) < 0.25, seed

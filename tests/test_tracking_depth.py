"""Motion in depth: seen in the size of a ball, undone in its path."""

from dataclasses import replace

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
    assert (depth.drifts, depth.tilts) == (True, False)
    assert depth.drift == pytest.approx(change, abs=3 * depth.drift_sd + 0.003)
    assert undone(track, depth, (300, 400)).y == pytest.approx(seen(np.ones(120)).y, abs=0.6)


@pytest.mark.parametrize(("tilt", "drift"), [(-0.1, 0.0), (0.06, 0.0), (-0.1, 0.05)])
def test_before_a_camera_that_is_not_level_a_ball_is_put_back_as_well(tilt: float, drift: float) -> None:
    high = np.abs(np.sin(7 * TIME))
    track = seen(1 + tilt * (0.5 - high) + drift * (TIME - 0.5))
    depth = motion_in_depth(track)
    assert (depth.drifts, depth.tilts) == (drift != 0, True)
    assert depth.tilt == pytest.approx(tilt, abs=3 * depth.tilt_sd + 0.003)
    assert undone(track, depth, (300, 400)).y == pytest.approx(seen(np.ones(120)).y, abs=0.8)


def test_sizes_that_go_astray_for_a_while_are_no_tilt() -> None:
    astray = 0.02 * np.convolve(np.random.default_rng(4).standard_normal(139), np.ones(20), "valid") / 4.5
    assert not motion_in_depth(seen(1 + astray)).tilts


@pytest.mark.parametrize(("hidden", "told"), [(0.1, True), (0.4, False)])
def test_motion_in_depth_is_told_where_most_frames_show_a_size(hidden: float, told: bool) -> None:
    track = seen(1 - 0.08 * (TIME - 0.5))
    sizes = np.where(np.random.default_rng(5).random(len(TIME)) < hidden, np.nan, track.sizes)
    assert is_told(replace(track, sizes=sizes)) == told


def test_blur_of_fast_frames_is_no_motion_in_depth() -> None:
    assert not is_told(seen(np.ones(120), blur=1.5))


def test_sizes_that_scatter_and_too_few_frames_tell_nothing() -> None:
    assert not is_told(seen(np.ones(120), noise=1.5))
    lonely = Track(
        ball="upper", unit="px", radius=1.0, radius_sd=1.0, frame=np.arange(3), time=TIME[:3],
        x=TIME[:3], y=TIME[:3], x_sd=TIME[:3], y_sd=TIME[:3], arc=TIME[:3],
    )  # fmt: skip
    assert not is_told(lonely)


def is_told(track: Track) -> bool:
    """Whether the sizes of a ball tell of any motion in depth."""
    depth = motion_in_depth(track)
    return depth.drifts or depth.tilts

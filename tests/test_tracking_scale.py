"""Pixels to metres: the four ways to tell a scale agree, and what tells none is refused."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from clips import Clip
from hypothesis import given, settings
from hypothesis import strategies as st

from tracking.scale import (
    Scale,
    apply,
    local_scale,
    scale_from_ball,
    scale_from_corners,
    scale_from_metres_per_pixel,
    scale_from_points,
    to_metres,
)
from tracking.track import Track, track_balls
from tracking.video import open_recording

CORNERS = [[100.0, 500.0], [600.0, 500.0], [600.0, 250.0], [100.0, 250.0]]  # 0.8 mm/px


@pytest.fixture(scope="module")
def track(plate_clip: Clip) -> Track:
    return track_balls(open_recording(plate_clip.path))[0]


def length(scale: Scale, first: tuple[float, float], second: tuple[float, float]) -> float:
    x, y = apply(scale, *np.array([first, second]).T)
    return float(np.hypot(x[1] - x[0], y[1] - y[0]))


@settings(max_examples=30)
@given(st.floats(0, 700), st.floats(0, 500), st.floats(0, 700), st.floats(0, 500))
def test_all_ways_to_tell_a_scale_agree(x: float, y: float, u: float, v: float) -> None:
    given_one = scale_from_metres_per_pixel(0.0008)
    clicked = scale_from_points((215, 40), (215, 415), 0.3)
    cornered = scale_from_corners(CORNERS, 0.4, 0.2)
    true = 0.0008 * np.hypot(u - x, v - y)
    for scale in (given_one, clicked, cornered):
        assert length(scale, (x, y), (u, v)) == pytest.approx(true, abs=1e-6)
    assert apply(cornered, np.array([x]), np.array([y]))[1] == pytest.approx(0.0008 * (500 - y), abs=1e-6)


def test_up_is_positive_whatever_tells_the_scale(track: Track) -> None:
    for scale in (
        scale_from_metres_per_pixel(0.0008),
        scale_from_ball(track, 0.04),
        scale_from_corners(CORNERS, 1, 1),
    ):
        _, (low, high) = apply(scale, np.array([300.0, 300.0]), np.array([400.0, 300.0]))
        assert high > low


def test_ball_tells_the_scale_within_its_uncertainty(track: Track) -> None:
    scale = scale_from_ball(track, 0.04)
    assert scale.matrix[0, 0] == pytest.approx(0.0008, rel=0.015)
    assert 0 < scale.relative_sd < 0.02
    assert scale.source.startswith("upper ball, 40 mm wide, ")


def test_track_in_metres_keeps_its_shape(track: Track) -> None:
    metres = to_metres(track, scale_from_metres_per_pixel(0.0008))
    assert metres.unit == "m"
    assert np.ptp(metres.y) == pytest.approx(0.0008 * np.ptp(track.y))
    assert metres.y_sd == pytest.approx(0.0008 * track.y_sd)
    assert metres.radius == pytest.approx(0.02, rel=0.02)
    assert np.array_equal(metres.frame, track.frame)


def test_plane_seen_at_an_angle_is_measured_in_its_own_metres() -> None:
    seen = [[100.0, 480.0], [620.0, 470.0], [540.0, 120.0], [160.0, 130.0]]
    scale = scale_from_corners(seen, 2.54, 1.27)
    x, y = apply(scale, *np.array(seen).T)
    assert np.column_stack((x, y)) == pytest.approx(
        np.array([[0, 0], [2.54, 0], [2.54, 1.27], [0, 1.27]]), abs=1e-5
    )
    near, far = local_scale(scale, np.array([360.0, 350.0]), np.array([475.0, 125.0]))
    assert far > 1.2 * near


def test_local_scale_is_the_root_of_the_magnification_of_areas() -> None:
    scale = scale_from_corners([[100, 480], [620, 470], [540, 120], [160, 130]], 2.54, 1.27)
    x, y = apply(scale, np.array([300.0, 300.1, 300.0]), np.array([300.0, 300.0, 300.1]))
    area = abs((x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0])) / 0.01
    assert local_scale(scale, np.array([300.0]), np.array([300.0]))[0] == pytest.approx(
        np.sqrt(area), rel=1e-3
    )


def test_farther_marks_tell_the_scale_better() -> None:
    near, far = (scale_from_points((0, 0), (0, span), 0.3).relative_sd for span in (50, 500))
    assert 0 < far < near < 0.05


NAN = float("nan")


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: scale_from_metres_per_pixel(0), "metres_per_pixel must be positive, got 0"),
        (lambda: scale_from_metres_per_pixel(NAN), "metres_per_pixel must be positive, got nan"),
        (lambda: scale_from_points((0, 0), (0, 100), -1), "distance must be positive, got -1"),
        (lambda: scale_from_points((0, 0), (3, 4), 1), "points_px must lie at least 10 px apart, got 5 px"),
        (lambda: scale_from_points((0, 0), (NAN, 4), 1), "points_px must lie at least 10 px apart, got nan"),
        (
            lambda: scale_from_corners(CORNERS[:3], 1, 1),
            r"four points \[x, y\], got an array of shape \(3, 2\)",
        ),
        (lambda: scale_from_corners(CORNERS, 0, 1), "width must be positive, got 0"),
        (lambda: scale_from_corners([CORNERS[i] for i in (0, 2, 1, 3)], 1, 1), "two of them are swapped"),
        (lambda: scale_from_corners([CORNERS[0]] * 4, 1, 1), "two of them are swapped or in line"),
        (lambda: scale_from_corners(CORNERS[::-1], 1, 1), "go round as lower left, lower right, upper right"),
    ],
)
def test_what_tells_no_scale_is_refused(make: Callable[[], Scale], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        make()


@pytest.mark.parametrize("diameter", [0, -0.04, NAN])
def test_ball_without_a_size_tells_no_scale(track: Track, diameter: float) -> None:
    with pytest.raises(ValueError, match="ball_diameter must be positive, got"):
        scale_from_ball(track, diameter)
    assert scale_from_ball(replace(track, radius=10.0), 0.04).matrix[0, 0] == pytest.approx(0.002)

"""A ball part of which looks like the wall behind it is seen all the same."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from clips import film
from hypothesis import given
from hypothesis import strategies as st

from tracking.blob import Blob
from tracking.flight import Air, flight_of_ball
from tracking.median import weighted_median
from tracking.partial import exceeds, lacks, started
from tracking.patch import part_of
from tracking.render import Camera, DropScene, ball_centres
from tracking.scale import scale_from_ball, scale_from_metres_per_pixel, to_metres
from tracking.sighting import Cutting, together
from tracking.track import track_balls
from tracking.velocity import measure_impacts
from tracking.video import open_recording

WHITE, GREY = (235.0, 238.0, 240.0), (215.0, 220.0, 225.0)
NUMBERS = st.lists(st.floats(-1e3, 1e3), min_size=1, max_size=30)


def blob(width: float, height: float) -> Blob:
    return Blob(
        x=0.0,
        y=0.0,
        width=width,
        height=height,
        area=width * height,
        hull=width * height,
        contrast=50.0,
        ghost=False,
        colour=(0, 0, 0),
        at_border=False,
    )


@pytest.mark.parametrize(("colour", "seed"), [(WHITE, 10), (WHITE, 17), (GREY, 5)])
def test_white_ball_whose_dark_side_is_as_grey_as_the_wall_is_measured(
    colour: tuple[float, float, float], seed: int, tmp_path: Path
) -> None:
    camera = Camera(width_px=320)
    scene = DropScene(
        kind="plate", drop_height=0.2, after=0.4, camera=camera, seed=seed, colours=(colour, colour)
    )
    clip = film(scene, tmp_path / "white.mp4")
    (ball,) = track_balls(open_recording(clip.path))
    centres = ball_centres(scene, 0, ball.time + camera.exposure / 2)
    off = np.hypot(ball.x - centres[:, 0], ball.y - centres[:, 1])
    assert np.median(off) < 0.6
    assert off.max() < 2.0
    assert ball.radius == pytest.approx(25.0, rel=0.025)
    assert ball.offset_sd > 0.15  # its light moves the rim by 1.7 px, and is not known better than that
    event = clip.truth["events"][0]
    flight = flight_of_ball(0.0027, 0.020, Air())
    known = scale_from_metres_per_pixel(camera.metres_per_pixel)
    told = measure_impacts(to_metres(ball, known), flight)[0]
    assert told.velocities[:2] == pytest.approx((event["v0"][0], event["v1"][0]), rel=0.002)
    by_ball = measure_impacts(to_metres(ball, scale_from_ball(ball, 0.040)), flight)[0]
    assert by_ball.velocities[:2] == pytest.approx((event["v0"][0], event["v1"][0]), rel=0.02)


@pytest.mark.parametrize("told", [12.5, None])
def test_small_white_ball_is_not_left_for_its_mirror_image_in_the_plate(
    told: float | None, tmp_path: Path
) -> None:
    camera = Camera(width_px=240, metres_per_pixel=0.0016)
    scene = DropScene(
        kind="plate", drop_height=0.25, after=0.4, camera=camera, seed=30, colours=(WHITE, WHITE)
    )
    clip = film(scene, tmp_path / "small.mp4")
    (ball,) = track_balls(open_recording(clip.path), radius=told)
    centres = ball_centres(scene, 0, ball.time + camera.exposure / 2)
    assert len(ball.frame) > 0.85 * (clip.truth["frames"] - 18)  # a hand holds it first
    assert np.hypot(ball.x - centres[:, 0], ball.y - centres[:, 1]).max() < 1.0
    assert ball.radius == pytest.approx(12.5, rel=0.025)


@pytest.mark.parametrize(
    ("aside", "width"), [((4.0, 0.0), 40), ((-3.0, -4.0), 40), ((0.0, 5.0), 40), ((-7.0, -10.0), 28)]
)
def test_a_ball_is_found_from_a_patch_that_lies_aside(aside: tuple[float, float], width: float) -> None:
    picture = np.full((120, 120, 3), 90, np.uint8)
    cv2.circle(picture, (60, 58), 24, (200, 200, 200), -1, cv2.LINE_AA)
    cv2.circle(picture, (50, 48), 9, (250, 250, 250), -1, cv2.LINE_AA)  # a highlight on its lit side
    guess = (60 + aside[0], 58 + aside[1], 24.0)
    cuttings = together([Cutting(frame=0, time=0.0, patch=part_of(picture, (60, 60), 55))])
    ((x, y, radius),) = started(cuttings, [guess], np.zeros(1), {0: blob(width, width)})
    assert np.hypot(x - 60, y - 58) < 0.3
    assert radius == 24.0
    assert started(cuttings, [guess], np.zeros(1), {}) == [guess]


def test_patches_are_too_small_or_too_large_for_a_ball_and_motion_blur_is_neither() -> None:
    assert [lacks(blob(*size), 25.0) for size in ((50, 50), (48, 60), (46, 50), (50, 30))] == [
        False,
        False,
        True,
        True,
    ]
    assert [exceeds(blob(*size), 25.0) for size in ((50, 50), (54, 80), (58, 58))] == [False, False, True]
    assert not lacks(blob(14.5, 15), 8.0)  # of a small ball a pixel at each side is no part


@given(NUMBERS)
def test_a_median_of_equal_weights_is_the_median(values: list[float]) -> None:
    assert weighted_median(values, np.ones(len(values))) == pytest.approx(np.median(values), abs=1e-9)


@given(NUMBERS, st.floats(-1e3, 1e3))
def test_a_value_that_outweighs_all_others_is_the_median(values: list[float], heavy: float) -> None:
    weights = [1e-6] * len(values) + [1e6]
    assert weighted_median([*values, heavy], weights) == pytest.approx(heavy, abs=1e-6)


def test_medians_are_taken_along_the_last_axis() -> None:
    values = np.random.default_rng(2).random((4, 9))
    np.testing.assert_allclose(weighted_median(values, np.ones((4, 9))), np.median(values, axis=1))

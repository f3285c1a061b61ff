"""The limb of a ball: no shading moves its centre, and its stated errors are true."""

import cv2
import numpy as np
import pytest

from tracking.circle import Circle, locate_circle
from tracking.limb import Limb, measure_limb, sharpen
from tracking.planes import Image
from tracking.render import Look, render_ball

PLACE, RADIUS, NOISE = (30.3, 29.6), 15.0, 3.0


def pictures(shading: float, count: int) -> list[Image]:
    rng = np.random.default_rng(7)
    wall = np.full((60, 60, 3), (120, 110, 90), np.float32)
    render_ball(wall, PLACE, RADIUS, Look(colour=(60, 140, 235), shading=shading))
    noisy = (wall + rng.normal(0, NOISE, wall.shape) for _ in range(count))
    return [np.clip(picture + 0.5, 0, 255).astype(np.uint8) for picture in noisy]


def edges(images: list[Image]) -> list[Circle]:
    found = [locate_circle(image, (30.0, 30.0, RADIUS), reach=4, free_radius=True) for image in images]
    return [circle for circle in found if circle is not None]


def by_limb(images: list[Image]) -> tuple[Limb, list[Circle]]:
    first, still = edges(images), np.zeros(len(images))
    limb = measure_limb(images[:8], first[:8], still[:8])
    _, circles = sharpen(images, first, still, limb)
    return limb, [circle for circle in circles if circle is not None]


def with_less_colour(image: Image) -> Image:
    """Keep one colour of four pixels, as recordings do."""
    brightness, *colours = cv2.split(cv2.cvtColor(image, cv2.COLOR_BGR2YCrCb))
    few = [cv2.resize(colour, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA) for colour in colours]
    again = [cv2.resize(colour, brightness.shape[::-1], interpolation=cv2.INTER_LINEAR) for colour in few]
    return np.asarray(cv2.cvtColor(cv2.merge((brightness, *again)), cv2.COLOR_YCrCb2BGR), np.uint8)


def off(circles: list[Circle]) -> np.ndarray:
    return np.array([(circle.x, circle.y) for circle in circles]) - PLACE


def test_flat_ball_has_no_shading_and_the_blur_it_was_drawn_with() -> None:
    limb, _ = by_limb(pictures(0.0, 8))
    assert limb.shading < 0.05
    assert 0.5 < limb.blur < 0.75


def test_shading_moves_edges_but_not_the_limb() -> None:
    images = pictures(1.0, 12)
    limb, circles = by_limb(images)
    assert np.hypot(*off(edges(images)).mean(axis=0)) > 0.08
    assert np.hypot(*off(circles).mean(axis=0)) < 0.05
    assert limb.shading > 0.3


@pytest.mark.parametrize("shading", [0.0, 1.0])
def test_recordings_that_keep_a_quarter_of_the_colour_soften_its_edges_and_move_none(shading: float) -> None:
    whole, _ = by_limb(pictures(shading, 12))
    limb, circles = by_limb([with_less_colour(image) for image in pictures(shading, 12)])
    assert limb.blur == pytest.approx(whole.blur, abs=0.05)
    assert limb.colour_blur > whole.colour_blur + 0.4
    assert np.abs(off(circles).mean(axis=0)).max() < 0.015


def test_ball_as_grey_as_its_wall_tells_no_blur_of_colour_and_is_seen_all_the_same() -> None:
    grey = [np.repeat(image[..., :1], 3, axis=2) for image in pictures(0.0, 8)]
    limb, circles = by_limb(grey)
    assert 0.5 < limb.blur < 0.75
    assert np.abs(off(circles)).max() < 0.05


@pytest.mark.parametrize("shading", [0.0, 1.0])
def test_stated_error_of_a_centre_is_what_noise_does(shading: float) -> None:
    _, circles = by_limb(pictures(shading, 60))
    stated = np.array([(circle.x_sd, circle.y_sd) for circle in circles])
    assert np.mean(off(circles).var(axis=0) / np.mean(stated**2, axis=0)) == pytest.approx(1, abs=0.3)
    assert np.median(stated) < 0.02


def test_ball_that_leaves_the_picture_is_seen_by_the_rays_that_stay() -> None:
    images = [np.ascontiguousarray(image[:, 19:]) for image in pictures(0.0, 4)]
    circle = Circle(x=11.3, y=29.6, radius=15, x_sd=1, y_sd=1, inliers=1, arc=6)
    _, circles = sharpen(images, [circle] * 4, np.zeros(4), Limb(blur=0.6, shading=0.0))
    found = [one for one in circles if one is not None]
    assert np.abs(off(found) + np.array((19, 0))).max() < 0.1

"""Pictures cut into patches, and many patches gone through at once: nothing is seen otherwise than alone."""

import numpy as np
import pytest

from tracking.circle import Circle, find_rims, fit_circle, fit_circles, locate_circle, places_of
from tracking.limb import Limb, sharpen
from tracking.patch import Patches, laid_out, part_of
from tracking.planes import Image
from tracking.render import Look, render_ball
from tracking.sight import sight_once
from tracking.sighting import together

RADIUS, MANY = 12.0, 70  # more pictures than one strand takes


def balls() -> tuple[list[Image], list[tuple[float, float]]]:
    """Draw a ball in pictures of different sizes."""
    rng = np.random.default_rng(11)
    images, places = [], []
    for _ in range(MANY):
        height, width = (int(side) for side in rng.integers(50, 70, 2))
        place = (float(rng.uniform(22, width - 22)), float(rng.uniform(22, height - 22)))
        wall = np.full((height, width, 3), (90, 100, 110), np.float32)
        render_ball(wall, place, RADIUS, Look(colour=(40, 120, 230), shading=0.5))
        images.append((wall + rng.normal(0, 2, wall.shape)).clip(0, 255).astype(np.uint8))
        places.append(place)
    return images, places


def guesses(places: list[tuple[float, float]]) -> list[tuple[float, float, float]]:
    return [(x + 0.8, y - 0.6, RADIUS) for x, y in places]


def found(circles: list[Circle | None]) -> np.ndarray:
    return places_of([circle for circle in circles if circle is not None])


def test_many_pictures_at_once_show_what_each_shows_alone() -> None:
    images, places = balls()
    rims = find_rims(images, guesses(places), reach=4.0)
    alone = [
        find_rims([image], [guess], reach=4.0)[0]
        for image, guess in zip(images, guesses(places), strict=True)
    ]
    for rim, other in zip(rims, alone, strict=True):
        np.testing.assert_array_equal(rim.points, other.points)
    at_once = fit_circles(rims, guesses(places), free_radius=True)
    one_by_one = [
        fit_circle(rim, guess, free_radius=True) for rim, guess in zip(rims, guesses(places), strict=True)
    ]
    assert at_once == one_by_one
    assert np.abs(found(at_once)[:, :2] - places).max() < 0.3


def test_limbs_of_taken_patches_are_those_of_their_own_pictures() -> None:
    images, places = balls()
    circles = [Circle(x=x, y=y, radius=RADIUS, x_sd=0.1, y_sd=0.1, inliers=1, arc=6) for x, y in places]
    which = [5, 3, 5, 60]
    some, still = [circles[i] for i in which], np.zeros(len(which))
    taken = sharpen(laid_out(images).take(which), some, still, Limb())[1]
    assert taken == sharpen([images[i] for i in which], some, still, Limb())[1]
    assert taken[0] == taken[2]


def test_a_part_of_a_picture_shows_the_same_circle_as_all_of_it() -> None:
    images, places = balls()
    large = np.full((300, 400, 3), (90, 100, 110), np.uint8)
    large[200 : 200 + len(images[0]), 310 : 310 + images[0].shape[1]] = images[0]
    guess = (places[0][0] + 310.4, places[0][1] + 199.7, RADIUS)
    whole = fit_circles(find_rims([large], [guess], reach=4.0), [guess], free_radius=True)[0]
    assert whole is not None
    part = locate_circle(large, guess, reach=4.0, free_radius=True)
    np.testing.assert_allclose(found([part]), found([whole]), rtol=1e-12)


@pytest.mark.parametrize("place", [(0.0, 0.0), (49.0, 39.0), (25.0, -30.0), (200.0, 500.0)])
def test_a_part_at_or_beyond_a_border_is_what_lies_in_the_picture(place: tuple[float, float]) -> None:
    image = np.arange(40 * 50 * 3, dtype=np.uint8).reshape(40, 50, 3)
    part, (left, top, _) = part_of(image, place, 8.0)
    rows, columns = int(top) + np.arange(len(part)), int(left) + np.arange(part.shape[1])
    assert part.size > 0
    np.testing.assert_array_equal(part, image[np.ix_(rows, columns)])


def test_no_pictures_show_nothing() -> None:
    none = laid_out([])
    assert len(none) == 0
    assert isinstance(none, Patches)
    assert find_rims(none, [], reach=4.0) == []
    assert sharpen(none, [], np.zeros(0), Limb()) == ([], [])
    assert sight_once(together([]), [], np.zeros(0)) == []

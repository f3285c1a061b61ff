"""What pictures show alike of an outline moves none of their places more than another."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from tracking.alike import fit_alike
from tracking.circle import Circle, Rim, fit_circles
from tracking.rim_kernel import ANGLES

RADIUS, COUNT = 15.0, 40
DIRECTIONS = np.column_stack((np.cos(ANGLES), np.sin(ANGLES)))


def rims(habit: np.ndarray, noise: float, seed: int) -> tuple[list[Rim], np.ndarray]:
    """Rims of one ball at some places; some parts are seen well in one picture and badly in another."""
    rng = np.random.default_rng(seed)
    places = rng.uniform(20, 60, (COUNT, 2))
    distance = RADIUS + habit + rng.normal(0, noise, (COUNT, len(ANGLES)))
    points = places[:, None] + DIRECTIONS * distance[..., None]
    weights = rng.uniform(0.1, 1.9, distance.shape)
    return [Rim(points=own, weights=w) for own, w in zip(points, weights, strict=True)], places


def fitted(seen: list[Rim], places: np.ndarray) -> list[Circle | None]:
    return fit_circles(seen, [(*place, RADIUS) for place in places], free_radius=False)


def errors(circles: list[Circle | None], places: np.ndarray) -> np.ndarray:
    return np.array([(c.x, c.y) for c in circles if c is not None]) - places


@settings(deadline=None, max_examples=40)
@given(st.integers(2, 6), st.floats(0, 2 * np.pi), st.integers(0, 99))
def test_places_scatter_less_without_what_all_rims_have_in_common(waves: int, turn: float, seed: int) -> None:
    seen, places = rims(0.3 * np.cos(waves * ANGLES + turn), 0.02, seed)
    first = fitted(seen, places)
    before, after = (errors(circles, places).std(axis=0) for circles in (first, fit_alike(seen, first)))
    assert (after < 0.5 * before).all()


@settings(deadline=None, max_examples=40)
@given(st.integers(0, 99))
def test_where_rims_have_nothing_in_common_places_stay(seed: int) -> None:
    seen, places = rims(np.zeros(len(ANGLES)), 0.05, seed)
    first = fitted(seen, places)
    moved = errors(fit_alike(seen, first), places) - errors(first, places)
    assert np.abs(moved).max() < 0.01


def test_picture_without_a_circle_gets_none() -> None:
    seen, places = rims(np.zeros(len(ANGLES)), 0.05, 1)
    first = fitted(seen, places)
    first[3] = None
    assert [circle is None for circle in fit_alike(seen, first)] == [i == 3 for i in range(COUNT)]
    assert fit_alike(seen[:2], [None, None]) == [None, None]


def test_part_of_a_rim_that_no_picture_shows_is_no_hindrance() -> None:
    seen, places = rims(0.2 * np.cos(3 * ANGLES), 0.02, 2)
    hidden = [rim.without(np.pi / 2, np.pi / 8) for rim in seen]
    assert np.abs(errors(fit_alike(hidden, fitted(hidden, places)), places)).max() < 0.15

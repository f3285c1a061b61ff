"""Circles that many points of a rim agree on, however strong the edges of shading and highlights are.

A robust fit starts from all points and is caught between two circles if half of the points lie on either.
Here circles through three points are tried (random sample consensus: Fischler & Bolles,
doi:10.1145/358669.358692), and the votes of all others counted.
"""

import numpy as np
import numpy.typing as npt

from tracking.circle import Guess
from tracking.rim_kernel import RAYS

FloatArray = npt.NDArray[np.float64]

TRIPLES = 300
APART = 7  # rays between any two of three: nearer ones tell no radius
AGREEING_PX = 0.3  # a point that lies further off a circle does not vote for it
FEWEST_VOTES = 8.0
MOST_CIRCLES = 4
OTHER = 0.04  # circles whose radii differ by less are one
SIZES = (0.5, 2.5)  # times the radius at which the rim was sought


def _triples() -> npt.NDArray[np.int64]:
    """Draw rays, three at a time, the same ones always."""
    drawn = np.argsort(np.random.default_rng(0).random((10 * TRIPLES, RAYS)), axis=1)[:, :3]
    gaps = np.abs(drawn - np.roll(drawn, 1, axis=1))
    apart = np.minimum(gaps, RAYS - gaps).min(axis=1) >= APART
    return np.asarray(drawn[apart][:TRIPLES])


_TRIPLES = _triples()


def agreed_circles(points: FloatArray, radius: float) -> list[Guess]:
    """Give a few circles of different size that most points of a rim agree on, the best first.

    Parameters
    ----------
    points : (rays, 2) array
        As a `Rim` has them, px; NaN where no edge is.
    radius : float
        Around which the rim was sought, px.
    """
    chosen = _TRIPLES[np.isfinite(points[_TRIPLES, 0]).all(axis=1)]
    circles = _through(points[chosen])
    fits = (circles[:, 2] > SIZES[0] * radius) & (circles[:, 2] < SIZES[1] * radius)
    circles = circles[fits]
    away = points - circles[:, None, :2]
    off = np.hypot(away[..., 0], away[..., 1]) - circles[:, 2:]
    votes = np.nansum(np.maximum(1 - (off / AGREEING_PX) ** 2, 0.0), axis=1)
    best: list[Guess] = []
    for index in np.argsort(-votes):
        x, y, size = circles[index].tolist()
        if votes[index] < FEWEST_VOTES or len(best) == MOST_CIRCLES:
            break
        if all(abs(size - other[2]) > OTHER * size for other in best):
            best.append((x, y, size))
    return best


def _through(three: FloatArray) -> FloatArray:
    """Give the circles (n, 3) through three points each (n, 3, 2); those in line give none."""
    origin = three[:, 0]
    sides = three[:, 1:] - origin[:, None]
    doubled = 2 * (sides[:, 0, 0] * sides[:, 1, 1] - sides[:, 0, 1] * sides[:, 1, 0])
    sides, origin = sides[doubled != 0], origin[doubled != 0]
    squares = (sides**2).sum(axis=2)
    x = sides[:, 1, 1] * squares[:, 0] - sides[:, 0, 1] * squares[:, 1]
    y = sides[:, 0, 0] * squares[:, 1] - sides[:, 1, 0] * squares[:, 0]
    centre = np.column_stack((x, y)) / doubled[doubled != 0][:, None]
    return np.column_stack((origin + centre, np.hypot(centre[:, 0], centre[:, 1])))

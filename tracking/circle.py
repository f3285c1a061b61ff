"""The rim of a ball to a fraction of a pixel: local edges on rays, then a robust circle.

Shading makes one global grey level useless (it is off by several pixels on a ball with a dark lower limb);
an edge found on each ray by itself, in whatever colour the ball differs from what is behind it *there*,
is not fooled. A pixel's centre has whole-number coordinates; x runs to the right and y down. Many pictures
are gone through at once: one by one takes ten times as long.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
import numpy.typing as npt

from tracking.patch import Patch, Patches, laid_out, part_of
from tracking.planes import Image
from tracking.rim_kernel import ANGLES, MINIMUM_INLIERS, RAYS, fit_rims, see_rims
from tracking.strands import side_by_side

FloatArray = npt.NDArray[np.float64]
Guess = tuple[float, float, float]
"""x, y and radius of a circle, px."""

MARGIN_PX = 2.5  # a rim is blurred, and a guess is off, by less
BEYOND_PX = 2.0  # levels are interpolated so far beyond what is looked at
MINIMUM_ARC = np.deg2rad(120)
INLIER = 0.1  # of a full weight
ALIKE_PX = 1.8  # rays that meet the rim closer to each other see the same noise
SECTOR = np.deg2rad(15)  # of a rim counts as seen where one of its rays meets an edge
_IN_SECTOR = (ANGLES // SECTOR).astype(int)[:, None] == np.arange(round(2 * np.pi / SECTOR))


@dataclass(frozen=True, slots=True, kw_only=True)
class Circle:
    """A ball's outline in pixels; `x_sd`, `y_sd` from the scatter of the rim points, `arc` in rad."""

    x: float
    y: float
    radius: float
    x_sd: float
    y_sd: float
    inliers: float
    arc: float

    @property
    def vagueness(self) -> float:
        """How far the points of the rim scatter, px; more if many lie off it."""
        return self.y_sd / self.inliers


@dataclass(frozen=True, slots=True, kw_only=True)
class Rim:
    """Edge points on the rays from a guessed centre: (rays, 2) px, NaN where no edge is.

    `weights` (rays,) tell how much each point counts, on average 1.
    """

    points: FloatArray
    weights: FloatArray = field(default_factory=lambda: np.ones(RAYS))

    def without(self, direction: float, half_angle: float) -> "Rim":
        """Leave out what lies around a direction, rad from x to y down, and opposite."""
        apart = np.abs((ANGLES - direction + np.pi / 2) % np.pi - np.pi / 2)
        points = np.where((apart > half_angle)[:, None], self.points, np.nan)
        return replace(self, points=points)


def places_of(circles: Sequence[Circle]) -> FloatArray:
    """Give x, y and radius of circles, (n, 3)."""
    return np.array([(circle.x, circle.y, circle.radius) for circle in circles]).reshape(-1, 3)


def find_rims(
    images: Sequence[Image | Patch] | Patches,
    guesses: Sequence[Guess] | FloatArray,
    *,
    reach: FloatArray | float,
    blur: FloatArray | float = 0.0,
) -> list[Rim]:
    """Look for the rim of one ball in each of several pictures, on rays from a guessed centre.

    Parameters
    ----------
    images : sequence of (height, width, 3) arrays, or of patches
    guesses : (n, 3) array_like
        x, y and radius in each picture, px.
    reach : (n,) array or float
        The rim is searched within radius ± reach, px.
    blur : (n,) array or float
        How far the ball moves up or down during the exposure, px.
    """
    circles = np.array(guesses, dtype=np.float64).reshape(-1, 3)
    points = np.empty((len(circles), RAYS, 2))
    ways = np.array([np.broadcast_to(value, len(circles)) for value in (reach, blur)], dtype=np.float64)
    patches = laid_out(images)
    pictures = patches.levels, patches.places
    side_by_side(partial(see_rims, pictures, circles, ways, points), len(circles))
    return [Rim(points=place) for place in points]


def fit_circles(
    rims: Sequence[Rim], guesses: Sequence[Guess] | FloatArray, *, free_radius: bool
) -> list[Circle | None]:
    """Fit a circle to each rim, its radius free or as guessed; None where less than 120° of a rim agree."""
    circles = np.array(guesses, dtype=np.float64).reshape(-1, 3)
    points = np.array([rim.points for rim in rims]).reshape(-1, RAYS, 2)
    weights = np.array([rim.weights for rim in rims]).reshape(-1, RAYS)
    agreement, variances = np.empty(weights.shape), np.empty((len(rims), 2))
    free, told = 3 if free_radius else 2, (agreement, variances)
    side_by_side(partial(fit_rims, (points, weights), circles, free, told), len(rims))
    inlying = agreement > INLIER
    share = inlying.sum(axis=1) / RAYS
    arc = (inlying @ _IN_SECTOR).sum(axis=1) * SECTOR
    alike = np.maximum(ALIKE_PX * RAYS / (2 * np.pi * np.maximum(circles[:, 2:], 1)), 1)
    sd = np.sqrt(variances * alike)
    good = (share >= MINIMUM_INLIERS) & (arc >= MINIMUM_ARC) & np.isfinite(circles).all(axis=1)
    found = np.column_stack((circles, sd, share, arc)).tolist()
    return [
        Circle(x=x, y=y, radius=radius, x_sd=x_sd, y_sd=y_sd, inliers=inliers, arc=seen) if right else None
        for right, (x, y, radius, x_sd, y_sd, inliers, seen) in zip(good.tolist(), found, strict=True)
    ]


def find_rim(image: Image, guess: Guess, *, reach: float) -> Rim:
    """Look for the rim of a ball in one picture, as `find_rims` does."""
    return find_rims([part_of(image, guess[:2], guess[2] + reach + BEYOND_PX)], [guess], reach=reach)[0]


def fit_circle(rim: Rim, guess: Guess, *, free_radius: bool) -> Circle | None:
    """Fit a circle to one rim, as `fit_circles` does."""
    return fit_circles([rim], [guess], free_radius=free_radius)[0]


def locate_circle(image: Image, guess: Guess, *, reach: float, free_radius: bool = False) -> Circle | None:
    """Find a ball's outline near a guess (x, y, radius in px) in one picture; None if it is not seen."""
    return fit_circle(find_rim(image, guess, reach=reach), guess, free_radius=free_radius)

"""The rim of a ball to a fraction of a pixel: local edges on rays, then a robust circle.

Shading makes one global grey level useless (it is off by several pixels on a ball with a dark lower limb);
an edge found on each ray by itself, in whatever colour the ball differs from what is behind it *there*,
is not fooled. A pixel's centre has whole-number coordinates; x runs to the right and y down. Many pictures
are gone through at once: one by one takes ten times as long.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import cv2
import numpy as np
import numpy.typing as npt

from tracking.planes import Image

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]
Guess = tuple[float, float, float]
"""x, y and radius of a circle, px."""

RAYS = 64
STEP_PX = 0.5  # along a ray
MARGIN_PX = 2.5  # a rim is blurred, and a guess is off, by less
PEAK_PX = 2.0  # a sharp rim is this wide to each side of its steepest place
FLANK = 0.25  # gradients below this share of the steepest are shading or texture, not rim
MINIMUM_STEEPNESS = 2.0  # grey levels a step: less is no edge
TUKEY = 4.685  # standard deviations at which a point no longer counts
MAXIMUM_ITERATIONS = 12
SETTLED_PX = 2e-3
MINIMUM_ARC = np.deg2rad(120)
MINIMUM_INLIERS = 0.4
ALIKE_PX = 1.8  # rays that meet the rim closer to each other see the same noise
SECTOR = np.deg2rad(15)  # of a rim counts as seen where one of its rays meets an edge
_ANGLES: FloatArray = np.arange(RAYS, dtype=np.float64) * (2 * np.pi / RAYS)
_DIRECTIONS = np.column_stack((np.cos(_ANGLES), np.sin(_ANGLES)))
_IN_SECTOR = (_ANGLES // SECTOR).astype(int)[:, None] == np.arange(round(2 * np.pi / SECTOR))


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
    contrast: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Rim:
    """Edge points on the rays from a guessed centre: (rays, 2) px, NaN where no edge is; contrast, levels.

    `weights` (rays,) tell how much each point counts, on average 1.
    """

    points: FloatArray
    contrast: float
    weights: FloatArray = field(default_factory=lambda: np.ones(RAYS))

    def without(self, direction: float, half_angle: float) -> "Rim":
        """Leave out what lies around a direction, rad from x to y down, and opposite."""
        apart = np.abs((_ANGLES - direction + np.pi / 2) % np.pi - np.pi / 2)
        points = np.where((apart > half_angle)[:, None], self.points, np.nan)
        return replace(self, points=points)


def find_rims(
    images: Sequence[Image],
    guesses: Sequence[Guess] | FloatArray,
    *,
    reach: FloatArray | float,
    blur: FloatArray | float = 0.0,
) -> list[Rim]:
    """Look for the rim of one ball in each of several pictures, on rays from a guessed centre.

    Parameters
    ----------
    images : sequence of (height, width, 3) arrays
    guesses : (n, 3) array_like
        x, y and radius in each picture, px.
    reach : (n,) array or float
        The rim is searched within radius ± reach, px.
    blur : (n,) array or float
        How far the ball moves up or down during the exposure, px.
    """
    if not len(images):
        return []
    guess = np.asarray(guesses, dtype=np.float64)
    reach, blur = (np.broadcast_to(value, len(guess))[:, None] for value in (reach, blur))
    radius = guess[:, 2:]
    inner = np.maximum(radius - reach, 0.3 * radius)
    steps = np.ceil((radius + reach + STEP_PX - inner) / STEP_PX).astype(int)
    distances = inner + STEP_PX * np.arange(steps.max())
    levels, outside = _levels(images, guess, distances, steps)
    middles = distances[:, :-1] + STEP_PX / 2
    expected = np.exp(-0.5 * ((middles - radius) / (0.7 * reach)) ** 2)
    expected[np.arange(1, distances.shape[1]) >= steps] = 0.0
    change = np.diff(levels, axis=2)  # whatever the colour, brighter or darker
    steepness = np.sqrt(np.einsum("nrsc,nrsc->nrs", change, change)) * (expected > 0)[:, None]
    half_width = PEAK_PX + blur / 2 * np.abs(_DIRECTIONS[:, 1])
    seen = ~outside & (steepness.max(axis=2) >= MINIMUM_STEEPNESS)
    rim = np.where(seen, _steepest(steepness * expected[:, None], middles, half_width), np.nan)
    last = np.take_along_axis(levels, (steps - 1)[:, :, None, None], axis=2)[:, :, 0]
    contrast = np.linalg.norm(last - levels[:, :, 0], axis=2)
    points = guess[:, None, :2] + _DIRECTIONS * rim[:, :, None]
    return [
        Rim(points=point, contrast=float(own))
        for point, own in zip(points, _middle(contrast, seen), strict=True)
    ]


def fit_circles(
    rims: Sequence[Rim], guesses: Sequence[Guess] | FloatArray, *, free_radius: bool
) -> list[Circle | None]:
    """Fit a circle to each rim, its radius free or as guessed; None where less than 120° of a rim agree."""
    if not len(rims):
        return []
    points = np.array([rim.points for rim in rims])
    known = np.array([rim.weights for rim in rims])
    circles, agreement, covariance = _robust_circles(
        points, known, np.array(guesses, dtype=np.float64), free_radius
    )
    inlying = agreement > 0.1
    share = inlying.sum(axis=1) / RAYS
    arc = (inlying @ _IN_SECTOR).sum(axis=1) * SECTOR
    alike = np.maximum(ALIKE_PX * RAYS / (2 * np.pi * np.maximum(circles[:, 2:], 1)), 1)
    sd = np.sqrt(np.einsum("nii->ni", covariance)[:, :2] * alike)
    good = (share >= MINIMUM_INLIERS) & (arc >= MINIMUM_ARC) & np.isfinite(circles).all(axis=1)
    return [
        Circle(
            x=float(circles[i, 0]),
            y=float(circles[i, 1]),
            radius=float(circles[i, 2]),
            x_sd=float(sd[i, 0]),
            y_sd=float(sd[i, 1]),
            inliers=float(share[i]),
            arc=float(arc[i]),
            contrast=rim.contrast,
        )
        if good[i]
        else None
        for i, rim in enumerate(rims)
    ]


def find_rim(image: Image, guess: Guess, *, reach: float) -> Rim:
    """Look for the rim of a ball in one picture, as `find_rims` does."""
    return find_rims([image], [guess], reach=reach)[0]


def fit_circle(rim: Rim, guess: Guess, *, free_radius: bool) -> Circle | None:
    """Fit a circle to one rim, as `fit_circles` does."""
    return fit_circles([rim], [guess], free_radius=free_radius)[0]


def locate_circle(image: Image, guess: Guess, *, reach: float, free_radius: bool = False) -> Circle | None:
    """Find a ball's outline near a guess (x, y, radius in px) in one picture; None if it is not seen."""
    return fit_circle(find_rim(image, guess, reach=reach), guess, free_radius=free_radius)


def _levels(
    images: Sequence[Image], guess: FloatArray, distances: FloatArray, steps: npt.NDArray[np.int64]
) -> tuple[npt.NDArray[np.float32], BoolArray]:
    """Levels (n, rays, distances, colours) along the rays, and which rays (n, rays) leave the picture."""
    x, y = (
        (guess[:, axis, None, None] + _DIRECTIONS[:, axis, None] * distances[:, None]).astype(np.float32)
        for axis in (0, 1)
    )
    furthest = np.take_along_axis(distances, steps - 1, axis=1)
    ends = guess[:, None, :2] + _DIRECTIONS * furthest[:, :, None]
    borders = np.array([(image.shape[1] - 1, image.shape[0] - 1) for image in images])
    outside = np.asarray(((ends < 0) | (ends > borders[:, None])).any(axis=2))
    border = cv2.BORDER_REPLICATE
    levels = [
        cv2.remap(image, x[i], y[i], cv2.INTER_LINEAR, borderMode=border) for i, image in enumerate(images)
    ]
    return np.array(levels, dtype=np.float32), outside


def _steepest(steepness: FloatArray, distances: FloatArray, half_width: FloatArray) -> FloatArray:
    """Centroid of the steepest part of each ray; what is flat beside it is shading or texture."""
    peak = np.take_along_axis(distances, steepness.argmax(axis=2), axis=1)
    near = np.abs(distances[:, None] - peak[:, :, None]) <= half_width[:, :, None]
    weight = np.maximum(steepness - FLANK * steepness.max(axis=2, keepdims=True), 0.0) * near
    return np.asarray((weight * distances[:, None]).sum(axis=2) / np.maximum(weight.sum(axis=2), 1e-9))


def _robust_circles(
    points: FloatArray, known: FloatArray, circles: FloatArray, free_radius: bool
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Fit circles by Gauss-Newton with Tukey weights times what is `known` of each point, (n, rays).

    Returns (n, 3) circles, (n, rays) Tukey weights, and covariances (n, 2 or 3, ...).
    """
    count, free = len(points), 3 if free_radius else 2
    seen = np.isfinite(points[:, :, 0])
    points = np.where(seen[:, :, None], points, 0.0)
    agreement, residual = np.zeros((2, count, RAYS))
    normal = np.tile(np.eye(free), (count, 1, 1))
    going = np.flatnonzero(seen.sum(axis=1) >= MINIMUM_INLIERS * RAYS)
    for _ in range(MAXIMUM_ITERATIONS):
        if not going.size:
            break
        slope, residual[going] = _apart(points[going], circles[going])
        agreement[going] = _tukey(residual[going], seen[going])
        weighted = slope[:, :, :free] * (agreement * known)[going, :, None]
        normal[going] = np.swapaxes(weighted, 1, 2) @ slope[:, :, :free] + 1e-9 * np.eye(free)
        right = np.swapaxes(weighted, 1, 2) @ residual[going, :, None]
        step = np.linalg.solve(normal[going], right)[:, :, 0]
        circles[going, :free] += step
        going = going[np.abs(step).max(axis=1) >= SETTLED_PX]
    freedom = np.maximum(agreement.sum(axis=1) - free, 1.0)
    variance = (agreement * known * residual**2).sum(axis=1) / freedom
    return circles, agreement, np.linalg.inv(normal) * variance[:, None, None]


def _apart(points: FloatArray, circles: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Slopes (n, rays, 3) of the points' distances by centre and radius, and how far outside they lie."""
    offset = points - circles[:, None, :2]
    distance = np.maximum(np.hypot(offset[:, :, 0], offset[:, :, 1]), 1e-9)
    slope = np.concatenate((offset / distance[:, :, None], np.ones((*distance.shape, 1))), axis=2)
    return slope, distance - circles[:, 2:]


def _tukey(residual: FloatArray, seen: BoolArray) -> FloatArray:
    """Weights that fall to nothing at `TUKEY` robust standard deviations."""
    scale = np.maximum(1.4826 * _middle(np.abs(residual), seen), 0.05)[:, None]
    return np.asarray(np.maximum(1 - (residual / (TUKEY * scale)) ** 2, 0.0) ** 2 * seen)


def _middle(values: FloatArray, seen: BoolArray) -> FloatArray:
    """Median (the upper one) of the values (n, rays) that are seen; infinite where none is."""
    ordered = np.sort(np.where(seen, values, np.inf), axis=1)
    half = np.minimum(seen.sum(axis=1, keepdims=True) // 2, values.shape[1] - 1)
    return np.take_along_axis(ordered, half, axis=1)[:, 0]

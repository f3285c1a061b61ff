"""The rim of one ball to a fraction of a pixel: local edges on rays, then a robust circle.

Shading makes one global grey level useless (it is off by several pixels on a ball with a dark lower limb);
an edge found on each ray by itself, in whatever colour the ball differs from what is behind it *there*,
is not fooled. A pixel's centre has whole-number coordinates; x runs to the right and y down.
"""

from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
Image = npt.NDArray[np.uint8]

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
_ANGLES: FloatArray = np.arange(RAYS, dtype=np.float64) * (2 * np.pi / RAYS)
_DIRECTIONS = np.column_stack((np.cos(_ANGLES), np.sin(_ANGLES)))


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
    """Edge points seen on rays around a guess: (n, 2) px; the rays' angles, rad; contrast, grey levels."""

    points: FloatArray
    angles: FloatArray
    contrast: float


def find_rim(
    image: Image, guess: tuple[float, float, float], *, reach: float, blur: float = 0.0
) -> Rim | None:
    """Look for the rim of a ball on rays from a guessed centre.

    Parameters
    ----------
    image : (height, width, 3) array
    guess : x, y and radius in pixels
    reach : float
        The rim is searched within radius ± reach, px.
    blur : float
        How far the ball moves up or down during the exposure, px.

    Returns
    -------
    Rim or None
        None where too few rays meet an edge.
    """
    x, y, _ = guess
    distance, contrast = _edges(image, guess, reach, blur)
    seen = np.isfinite(distance)
    if seen.sum() < MINIMUM_INLIERS * RAYS:
        return None
    points = np.array((x, y)) + _DIRECTIONS[seen] * distance[seen, None]
    return Rim(points=points, angles=_ANGLES[seen], contrast=float(np.median(contrast[seen])))


def fit_circle(rim: Rim, guess: tuple[float, float, float], *, free_radius: bool) -> Circle | None:
    """Fit a circle to a rim, its radius free or as guessed; None where less than 120° of a rim agree."""
    fit = _robust_circle(rim.points, guess, free_radius=free_radius)
    if fit is None:
        return None
    (x, y), radius, weights, covariance = fit
    inlying = weights > 0.1
    arc = _arc(rim.angles[inlying])
    share = float(inlying.sum() / RAYS)
    if share < MINIMUM_INLIERS or arc < MINIMUM_ARC:
        return None
    return Circle(
        x=float(x),
        y=float(y),
        radius=radius,
        x_sd=float(np.sqrt(covariance[0, 0])),
        y_sd=float(np.sqrt(covariance[1, 1])),
        inliers=share,
        arc=arc,
        contrast=rim.contrast,
    )


def locate_circle(
    image: Image, guess: tuple[float, float, float], *, reach: float, free_radius: bool = False
) -> Circle | None:
    """Find a ball's outline near a guess (x, y, radius in px) in one picture; None if it is not seen."""
    rim = find_rim(image, guess, reach=reach)
    return None if rim is None else fit_circle(rim, guess, free_radius=free_radius)


def _edges(
    image: Image, guess: tuple[float, float, float], reach: float, blur: float
) -> tuple[FloatArray, FloatArray]:
    """Find on each ray the distance of the rim from the guessed centre (NaN: none seen), and its contrast."""
    x, y, radius = guess
    inner = max(radius - reach, 0.3 * radius)
    distances = np.arange(inner, radius + reach + STEP_PX, STEP_PX)
    ray_x = x + _DIRECTIONS[:, :1] * distances
    ray_y = y + _DIRECTIONS[:, 1:] * distances
    height, width = image.shape[:2]
    outside = (ray_x < 0) | (ray_y < 0) | (ray_x > width - 1) | (ray_y > height - 1)
    levels = cv2.remap(
        image,
        ray_x.astype(np.float32),
        ray_y.astype(np.float32),
        cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_REPLICATE,
    ).astype(np.float64)
    steepness = np.linalg.norm(np.diff(levels, axis=1), axis=2)  # whatever the colour, brighter or darker
    middles = distances[:-1] + STEP_PX / 2
    expected = np.exp(-0.5 * ((middles - radius) / (0.7 * reach)) ** 2)
    rim = _steepest(steepness * expected, middles, PEAK_PX + blur / 2 * np.abs(_DIRECTIONS[:, 1]))
    contrast = np.linalg.norm(levels[:, -1] - levels[:, 0], axis=1)
    rim[(steepness.max(axis=1) < MINIMUM_STEEPNESS) | outside.any(axis=1)] = np.nan
    return rim, contrast


def _steepest(steepness: FloatArray, distances: FloatArray, half_width: FloatArray) -> FloatArray:
    """Centroid of the steepest part of each ray; what is flat beside it is shading or texture."""
    peak = distances[steepness.argmax(axis=1)]
    near = np.abs(distances[None, :] - peak[:, None]) <= half_width[:, None]
    weight = np.maximum(steepness - FLANK * steepness.max(axis=1, keepdims=True), 0.0) * near
    return np.asarray((weight * distances).sum(axis=1) / np.maximum(weight.sum(axis=1), 1e-9))


def _robust_circle(
    points: FloatArray, guess: tuple[float, float, float], *, free_radius: bool
) -> tuple[FloatArray, float, FloatArray, FloatArray] | None:
    """Fit a circle by Gauss-Newton with Tukey weights: centre, radius, weights, covariance."""
    circle = np.array(guess)
    free = 3 if free_radius else 2
    slope = np.ones((len(points), 3))
    for _ in range(MAXIMUM_ITERATIONS):
        offset = points - circle[:2]
        distance = np.maximum(np.hypot(offset[:, 0], offset[:, 1]), 1e-9)
        residual = distance - circle[2]
        apart = np.abs(residual)
        scale = max(1.4826 * float(np.partition(apart, len(apart) // 2)[len(apart) // 2]), 0.05)
        weights = np.maximum(1 - (residual / (TUKEY * scale)) ** 2, 0.0) ** 2
        slope[:, :2] = offset / distance[:, None]
        weighted = slope[:, :free] * weights[:, None]
        normal = weighted.T @ slope[:, :free]
        try:
            step = np.linalg.solve(normal, weighted.T @ residual)
        except np.linalg.LinAlgError:
            return None
        circle[:free] += step
        if np.abs(step).max() < SETTLED_PX:
            break
    freedom = max(float(weights.sum()) - free, 1.0)
    covariance = np.linalg.pinv(normal) * float(weights @ residual**2) / freedom
    return circle[:2], float(circle[2]), weights, covariance


def _arc(angles: FloatArray) -> float:
    """Sum up how much of the full turn the rim points cover, in sectors of 15°, rad."""
    sector = np.deg2rad(15)
    return float(len(np.unique((angles // sector).astype(int))) * sector)

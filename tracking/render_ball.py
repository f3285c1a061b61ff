"""A shaded ball with exact sub-pixel place, blurred by its motion."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tracking.render_scene import Colour, require

Image = NDArray[np.float32]

EDGE_WIDTH = 2.5
"""Pixels over which the outline fades, as a pixel's square and a lens do together.

With this width and a smooth step the samples alias least: a flat ball's centroid is its centre within
0.002 px, against 0.02 px with a linear step over one pixel."""
LIGHT = np.array([-0.45, -0.65, 0.61], dtype=np.float32)
"""Unit vector towards the lamp: x right, y down, z to the camera; from the upper left."""
HALFWAY = np.array([*LIGHT[:2], LIGHT[2] + 1], np.float32) / np.sqrt(2 * (1 + LIGHT[2]))


@dataclass(frozen=True, slots=True, kw_only=True)
class Look:
    """How a ball looks.

    Attributes
    ----------
    colour : tuple of (blue, green, red)
        0 to 255.
    shading : float
        0 is a flat disc of that colour, 1 is full light and shade (Lambert, dark limb, highlight).
    opacity : float
        1 hides what is behind; less is for mirror images.
    """

    colour: Colour
    shading: float = 1.0
    opacity: float = 1.0

    def __post_init__(self) -> None:
        for name in ("shading", "opacity"):
            require(0 <= getattr(self, name) <= 1, name, "be within [0, 1]", getattr(self, name))


def render_ball(image: Image, centres: ArrayLike, radius: float, look: Look) -> None:
    """Draw a ball into `image`; nothing outside the pixels it covers is touched.

    Parameters
    ----------
    image : ndarray of float32, shape (rows, columns, 3)
        Grey levels, blue, green, red; changed in place.
    centres : array_like, shape (2,), (n, 2) or (n, rows, 2)
        Centre (x, y) in pixels; pixel centres are at whole numbers: (0, 0) is the middle of the first.
        Several centres are instants of one exposure, and the picture is their mean; a centre for each row
        is a rolling shutter.
    radius : float
        Radius in pixels: at this distance from the centre a pixel is half the ball's, half the wall's.
    look : Look
        Colour and shading.

    Raises
    ------
    ValueError
        If the radius is not positive.

    Examples
    --------
    >>> patch = np.zeros((21, 21, 3), np.float32)
    >>> render_ball(patch, (10.25, 9.5), 6.0, Look(colour=(200, 200, 200), shading=0))
    >>> weights = patch[:, :, 0] / patch[:, :, 0].sum()
    >>> print(f"{(weights.sum(0) * np.arange(21)).sum():.2f} {(weights.sum(1) * np.arange(21)).sum():.2f}")
    10.25 9.50
    """
    require(radius > 0, "radius", "be positive", radius)
    places = (
        np.asarray(centres, np.float32).reshape(-1, 1, 2) if np.ndim(centres) < 3 else np.asarray(centres)
    )
    rows, columns = (slice(*_reach(places[..., axis], radius, image.shape[1 - axis])) for axis in (1, 0))
    if rows.stop <= rows.start or columns.stop <= columns.start:
        return
    if places.shape[1] > 1:
        places = places[:, rows]
    grid_x, grid_y = np.arange(columns.start, columns.stop), np.arange(rows.start, rows.stop)
    right = (grid_x - places[..., :1]).astype(np.float32) / np.float32(radius)
    down = (grid_y - places[..., 1]).astype(np.float32)[..., np.newaxis] / np.float32(radius)
    cover, lit, glare = (field.mean(axis=0)[..., np.newaxis] for field in _light(right, down, radius, look))
    patch = image[rows, columns]
    patch *= 1 - look.opacity * cover
    patch += look.opacity * (lit * np.array(look.colour, np.float32) + 255 * glare)
    np.minimum(patch, 255, out=patch)


def _reach(places: NDArray[np.float32], radius: float, size: int) -> tuple[int, int]:
    """First pixel that a ball can cover and the one behind the last, within the picture."""
    return max(int(places.min() - radius - 2), 0), min(int(places.max() + radius + 3), size)


def _light(right: Image, down: Image, radius: float, look: Look) -> tuple[Image, Image, Image]:
    """Share of each pixel covered, and that share times diffuse light and times highlight.

    `right` and `down` are distances from the centre over the radius, shapes (n, 1 or rows, columns) and
    (n, rows, 1).
    """
    squared = right * right + down * down
    step = np.clip((1 - np.sqrt(squared)) * np.float32(radius / EDGE_WIDTH) + np.float32(0.5), 0, 1)
    cover = step * step * (3 - 2 * step)
    if look.shading == 0:
        return cover, cover, np.zeros_like(cover)
    towards = np.sqrt(np.maximum(1 - squared, 0))
    lambert = np.maximum(right * LIGHT[0] + down * LIGHT[1] + towards * LIGHT[2], 0)
    light = (np.float32(0.42) + np.float32(0.62) * lambert) * (np.float32(0.82) + np.float32(0.18) * towards)
    mirror = np.maximum(right * HALFWAY[0] + down * HALFWAY[1] + towards * HALFWAY[2], 0)
    for _ in range(5):  # to the 32nd power
        mirror *= mirror
    shading = np.float32(look.shading)
    lit = cover * (1 - shading + shading * light)
    return cover, lit, cover * mirror * (np.float32(0.35) * shading)


def darken(image: Image, centre: ArrayLike, spread: tuple[float, float], depth: float) -> None:
    """Darken a Gaussian spot (standard deviations across and down, px) in place."""
    if depth < 0.02:
        return
    windows, weights = [], []
    for middle, sigma, size in zip(np.asarray(centre), spread, image.shape[1::-1], strict=True):
        start = min(max(int(middle - 2.7 * sigma), 0), size)
        stop = min(max(int(middle + 2.7 * sigma) + 1, start), size)
        windows.append(slice(start, stop))
        weights.append(np.exp(-(((np.arange(start, stop) - middle) / sigma) ** 2) / 2).astype(np.float32))
    (columns, rows), (across, down) = windows, weights
    image[rows, columns] *= 1 - np.float32(depth) * np.outer(down, across)[..., np.newaxis]

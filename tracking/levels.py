"""Levels: what surrounds a ball, as the compiled search for its rim reads it.

(height, width, 4) arrays of blue, green, red and nothing, so that the colours of a pixel lie in one place.
"""

from typing import NamedTuple

import cv2
import numpy as np
import numpy.typing as npt

from tracking.kernel import compiled
from tracking.planes import Image, Planes

Levels = npt.NDArray[np.float32]

BLUE_SHARE, RED_SHARE = 1.773, 1.403  # of a difference of colour, in that colour (JPEG)
BLUE_IN_GREEN, RED_IN_GREEN = 0.344, 0.714
GREY = np.float32(128)  # no difference of colour


class Patch(NamedTuple):
    """Levels of a part of a picture, and x, y and 0 of their upper left pixel, px."""

    levels: Levels
    corner: npt.NDArray[np.float64]


def patch_of(seen: Planes, left: int, top: int) -> Patch:
    """Make a patch of planes cut out at a place; no level is cut off at what a screen can show."""
    brightness, blue, red = (np.ascontiguousarray(plane) for plane in seen)
    return Patch(_mixed(brightness, blue, red), np.array((left, top, 0.0)))


def patch_around(image: Image | Patch, x: float, y: float, half: float) -> Patch:
    """Make a patch of what is around a place in a (height, width, 3) picture; a patch stays as it is."""
    if isinstance(image, Patch):
        return image
    height, width = image.shape[:2]
    left, top = max(0, min(int(x - half), width - 1)), max(0, min(int(y - half), height - 1))
    window = image[top : max(top + 1, int(y + half) + 2), left : max(left + 1, int(x + half) + 2)]
    levels = np.asarray(cv2.cvtColor(window, cv2.COLOR_BGR2BGRA), dtype=np.float32)
    return Patch(levels, np.array((left, top, 0.0)))


@compiled
def _mixed(brightness: Image, blue: Image, red: Image) -> Levels:
    """Lay colour over brightness; where there is less of it, it is interpolated."""
    height, width = brightness.shape
    levels = np.zeros((height, width, 4), dtype=np.float32)
    bluish, reddish = np.empty((2, 2 * width), dtype=np.float32)
    for row in range(height):
        _spread(blue, row, brightness.shape, bluish)
        _spread(red, row, brightness.shape, reddish)
        for column in range(width):
            level, b, r = np.float32(brightness[row, column]), bluish[column], reddish[column]
            levels[row, column, 0] = level + np.float32(BLUE_SHARE) * b
            levels[row, column, 1] = level - np.float32(BLUE_IN_GREEN) * b - np.float32(RED_IN_GREEN) * r
            levels[row, column, 2] = level + np.float32(RED_SHARE) * r
    return levels


@compiled
def _spread(plane: Image, row: int, shape: tuple[int, int], spread: Levels) -> None:
    """Give one row of a plane of colour, about grey, as many pixels as the brightness has."""
    rows, columns = plane.shape
    near = far = row
    if rows < shape[0]:
        near = row // 2
        far = min(max(near - 1 + 2 * (row % 2), 0), rows - 1)
    most, least = np.float32(0.75), np.float32(0.25)  # a pixel lies nearer to one of colour than to the next
    if columns == shape[1]:
        for k in range(columns):
            spread[k] = most * plane[near, k] + least * plane[far, k] - GREY
        return
    blended = np.empty(columns + 2, dtype=np.float32)
    for k in range(columns):
        blended[k + 1] = most * plane[near, k] + least * plane[far, k] - GREY
    blended[0], blended[columns + 1] = blended[1], blended[columns]
    for k in range(columns):
        spread[2 * k] = most * blended[k + 1] + least * blended[k]
        spread[2 * k + 1] = most * blended[k + 1] + least * blended[k + 2]

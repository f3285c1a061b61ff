"""The median of some pictures, compiled."""

import numpy as np

from tracking.kernel import compiled, part
from tracking.planes import Image


@compiled
def median_of(pictures: Image) -> Image:
    """Median over pictures (n, height, width), pixel by pixel; the lower one of an even number.

    In each row of all of them the brightest level rises to the last, the next to the last but one, until the
    middle one is found. That compares many pixels at once; sorting each by itself takes far longer.
    """
    count, height, width = pictures.shape
    median, rows = np.empty((height, width), dtype=np.uint8), np.empty((count, width), dtype=np.uint8)
    for row in range(height):
        for k in range(count):
            _copy(pictures[k, row], rows[k])
        for risen in range(count // 2 + 1):
            for k in range(count - 1 - risen):
                _in_order(rows[k], rows[k + 1])
        _copy(rows[count - 1 - count // 2], median[row])
    return median


@part
def _copy(one: Image, other: Image) -> None:
    """Copy a row."""
    for column in range(len(one)):
        other[column] = one[column]


@part
def _in_order(one: Image, other: Image) -> None:
    """Put the darker of two levels first, in every column."""
    for column in range(len(one)):
        darker, brighter = min(one[column], other[column]), max(one[column], other[column])
        one[column], other[column] = darker, brighter

"""Medians: of some numbers, of some pictures, and of numbers that do not count alike."""

import numpy as np
import numpy.typing as npt

from tracking.kernel import compiled, part
from tracking.planes import Image


@part
def upper_median(values: npt.NDArray[np.float64]) -> float:
    """Select the middle value, the upper one of an even number; the values change their order."""
    low, high, wanted = 0, len(values) - 1, len(values) // 2
    while low < high:
        pivot, i, j = values[(low + high) // 2], low, high
        while i <= j:
            while values[i] < pivot:
                i += 1
            while values[j] > pivot:
                j -= 1
            if i <= j:
                values[i], values[j] = values[j], values[i]
                i, j = i + 1, j - 1
        if wanted > j and wanted < i:
            break
        low, high = (low, j) if wanted <= j else (i, high)
    return float(values[wanted])


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


def weighted_median(values: npt.ArrayLike, weights: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Take the middle of values (..., n), at least one, of which each counts as much as its weight."""
    values, weights = np.asarray(values, dtype=np.float64), np.asarray(weights, dtype=np.float64)
    order = np.argsort(values, axis=-1)
    values, weights = np.take_along_axis(values, order, -1), np.take_along_axis(weights, order, -1)
    summed = np.cumsum(weights, axis=-1)
    below, half = summed - weights / 2, summed[..., -1:] / 2
    after = np.argmax(below >= half, axis=-1)[..., None]
    before = np.maximum(after - 1, 0)
    (low, high), (least, most) = (
        [np.take_along_axis(of, place, -1) for place in (before, after)] for of in (below, values)
    )
    share = np.clip(np.divide(half - low, high - low, out=np.ones_like(low), where=high > low), 0.0, 1.0)
    return np.asarray((least + share * (most - least))[..., 0])

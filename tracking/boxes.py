"""Where a picture differs: boxes about all that is marked on a coarse look at it."""

import numpy as np
import numpy.typing as npt

from tracking.coarse import COARSE
from tracking.kernel import compiled, part
from tracking.planes import Image, Window

IntArray = npt.NDArray[np.int64]

MOST_BOXES = 1000
AT_ONCE = 4  # rows laid over each other


def boxes(marks: Image, beside: int, shape: tuple[int, ...]) -> tuple[Window, ...]:
    """Windows, in pixels of a picture of some `shape`, around all that is set in marks on its coarse look."""
    found, count = _boxes(marks, beside)
    return tuple(
        (
            slice(COARSE * max(top, 0), min(COARSE * bottom, shape[0])),
            slice(COARSE * max(left, 0), min(COARSE * right, shape[1])),
        )
        for top, bottom, left, right in found[:count].tolist()
    )


@compiled
def _boxes(marks: Image, beside: int) -> tuple[IntArray, int]:
    """Boxes (top, bottom, left, right) about all that is set, and so much beside it; and how many there are.

    None overlap.
    """
    found, count = np.empty((MOST_BOXES, 4), dtype=np.int64), 0
    laid_over = np.empty(marks.shape[1], dtype=np.uint8)
    for first in range(0, len(marks), AT_ONCE):
        last = min(first + AT_ONCE, len(marks))
        if _lay_over(marks, first, last, laid_over):
            count = _add_runs(marks, (first, last, beside), laid_over, found, count)
    return found, count


@part
def _lay_over(marks: Image, first: int, last: int, laid_over: Image) -> bool:
    """Lay some rows over each other; tell whether anything is set."""
    any_set = np.uint8(0)
    for column in range(len(laid_over)):
        laid_over[column] = 0
    for row in range(first, last):
        line = marks[row]
        for column in range(len(line)):
            laid_over[column] |= line[column]
    for column in range(len(laid_over)):
        any_set = max(any_set, laid_over[column])
    return bool(any_set > 0)


@part
def _add_runs(marks: Image, rows: tuple[int, int, int], laid_over: Image, found: IntArray, count: int) -> int:
    """Add boxes about all runs in rows (first, last, how many beside) laid over each other to those found.

    Returns how many there are.
    """
    first, last, beside = rows
    column = 0
    while column < len(laid_over):
        start = column
        while column < len(laid_over) and laid_over[column]:
            column += 1
        if column > start:  # a pixel of colour is two of brightness
            upper, lower = first, last
            while not _any_set(marks[upper, start:column]):
                upper += 1
            while not _any_set(marks[lower - 1, start:column]):
                lower -= 1
            top, left = (upper - beside) // 2 * 2, (start - beside) // 2 * 2
            count = _join(found, count, (top, lower + beside, left, column + beside))
        column += 1
    return count


@part
def _any_set(line: Image) -> bool:
    """Tell whether anything is set in a part of a row."""
    most = np.uint8(0)
    for column in range(len(line)):
        most = max(most, line[column])
    return bool(most > 0)


@part
def _join(found: IntArray, count: int, box: tuple[int, int, int, int]) -> int:
    """Add a box to others that do not overlap; those that do become one. Returns how many there are."""
    top, bottom, left, right = box
    k = 0
    while k < count:
        overlap = top < found[k, 1] and found[k, 0] < bottom and left < found[k, 3] and found[k, 2] < right
        if overlap or count == len(found):  # so many are noise
            top, bottom = min(top, found[k, 0]), max(bottom, found[k, 1])
            left, right = min(left, found[k, 2]), max(right, found[k, 3])
            count -= 1
            for side in range(4):
                found[k, side] = found[count, side]
            k = 0
        else:
            k += 1
    found[count, 0], found[count, 1], found[count, 2], found[count, 3] = top, bottom, left, right
    return count + 1

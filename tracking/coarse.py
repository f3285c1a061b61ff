"""A look at few pixels of a picture, evenly spread: what changed, where, and by how much.

Most pictures show little that is new. Sixteen times fewer pixels tell where to look at all of them.
"""

import cv2
import numpy as np

from tracking.kernel import compiled, part
from tracking.planes import Image, Planes, Window, fewer

COARSE = 4  # pixels from one that is looked at to the next
COLOUR_SHARE = 0.6  # compression rounds colour more than brightness
SAME_GAIN = 0.004  # brightness that differs by less than this share is left alone
GAIN_RANGE = (0.5, 2.0)
NINTH, HALF = np.uint32(7282), np.uint32(32768)  # of 2**16
CHANGED_RANK = 8  # coarse pixels that must have changed by so much: one may be noise


def coarsely(seen: Planes) -> Planes:
    """Look at a few pixels only, evenly spread; brightness averaged over three rows and columns."""
    down, right = (2 * COARSE // times for times in fewer(seen))
    blue, red = (np.ascontiguousarray(plane[::down, ::right]) for plane in seen[1:])
    return _averaged(seen[0]), blue, red


@compiled
def _averaged(plane: Image) -> Image:
    """Look at every `COARSE`th pixel, averaged over three rows and columns of them."""
    few = np.empty((-(-plane.shape[0] // COARSE), -(-plane.shape[1] // COARSE)), dtype=np.uint8)
    height, width = few.shape
    line, across = np.empty(plane.shape[1], dtype=np.uint8), np.empty(width + 2, dtype=np.uint16)
    for row in range(height):
        for column in range(len(line)):  # all of it: memory gives what lies side by side far sooner
            line[column] = plane[COARSE * row, column]
        for column in range(width):
            few[row, column] = line[COARSE * column]
    averaged = np.empty_like(few)
    for row in range(height):
        above, own, below = few[max(row - 1, 0)], few[row], few[min(row + 1, height - 1)]
        for column in range(width):
            across[column + 1] = np.uint16(above[column]) + np.uint16(own[column]) + np.uint16(below[column])
        across[0], across[width + 1] = across[1], across[width]
        for column in range(width):
            nine = across[column] + across[column + 1] + across[column + 2]
            averaged[row, column] = (nine * NINTH + HALF) >> 16
    return averaged


def gain_between(image: Image, reference: Image) -> float:
    """How much brighter a picture is than another: flicker."""
    few = (slice(None, None, 8), slice(None, None, 8))
    ratio = ((image[few] + np.float32(1)) / (reference[few] + np.float32(1))).ravel()
    least, most = GAIN_RANGE
    return min(max(float(np.partition(ratio, ratio.size // 2)[ratio.size // 2]), least), most)


def brightened(image: Image, gain: float) -> Image:
    """Make a picture brighter or darker, unless hardly."""
    if abs(gain - 1) < SAME_GAIN:
        return image
    return np.asarray(cv2.convertScaleAbs(image, alpha=gain), dtype=np.uint8)


def mark_changes(
    coarse: Planes, reference: Planes, change: tuple[float, float], marks: Image, lasting: int = 1
) -> None:
    """Mark where coarse looks differ; marks that are there already count down.

    Parameters
    ----------
    coarse, reference : planes
    change : two floats
        How much brighter than the reference the whole picture is, and the least difference, grey levels.
    marks : (height, width) array
        Altered: `lasting` where brightness or colour differs, one less than before elsewhere.
    lasting : int, optional
    """
    gain, least = change
    dim, blue, red = map(np.ascontiguousarray, (brightened(reference[0], gain), *reference[1:]))
    levels = np.array((least, least / COLOUR_SHARE), dtype=np.uint8)
    _mark(coarse, (dim, blue, red), levels, marks, lasting)


@compiled
def _mark(coarse: Planes, reference: Planes, levels: Image, marks: Image, lasting: int) -> None:
    """Mark what differs by more than a level of brightness or one of colour."""
    coloured = np.zeros(2 * coarse[1].shape[1], dtype=np.uint8)
    for row in range(len(marks)):
        _mark_coloured(coarse, reference, levels[1], row // 2, coloured)
        own, seen, other = marks[row], coarse[0][row], reference[0][row]
        for column in range(len(own)):
            apart = max(seen[column], other[column]) - min(seen[column], other[column])
            own[column] = max(own[column], np.uint8(1)) - 1
            if apart > levels[0] or coloured[column]:
                own[column] = lasting


@part
def _mark_coloured(coarse: Planes, reference: Planes, level: int, row: int, coloured: Image) -> None:
    """Mark where colour differs in a row; one pixel of colour is two of brightness."""
    blue, other_blue, red, other_red = coarse[1][row], reference[1][row], coarse[2][row], reference[2][row]
    for column in range(len(blue)):
        bluer = max(blue[column], other_blue[column]) - min(blue[column], other_blue[column])
        redder = max(red[column], other_red[column]) - min(red[column], other_red[column])
        coloured[2 * column] = coloured[2 * column + 1] = max(bluer, redder) > level


@compiled
def largest_change(before: Image, after: Image) -> float:
    """Tell by how much at least the `CHANGED_RANK` most changed places of two pictures differ, levels."""
    largest = np.zeros(CHANGED_RANK, dtype=np.int64)  # in order, the least of them first
    apart = np.empty(before.shape[1], dtype=np.uint8)
    for row in range(len(before)):
        one, other, most = before[row], after[row], 0
        for column in range(len(apart)):
            apart[column] = max(one[column], other[column]) - min(one[column], other[column])
        for column in range(len(apart)):
            most = max(most, apart[column])
        for column in range(len(apart) if most > largest[0] else 0):
            if apart[column] > largest[0]:
                rank = 0
                while rank + 1 < CHANGED_RANK and largest[rank + 1] < apart[column]:
                    largest[rank] = largest[rank + 1]
                    rank += 1
                largest[rank] = apart[column]
    return float(largest[0])


def boxes(marks: Image, beside: int, shape: tuple[int, ...]) -> tuple[Window, ...]:
    """Windows, in pixels of a picture of some `shape`, around all that is set in marks on its coarse look."""
    outlines, _ = cv2.findContours(marks, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    found: list[tuple[int, int, int, int]] = []
    for outline in outlines:
        left, top, width, height = cv2.boundingRect(outline)
        first = (top - beside) // 2 * 2, (left - beside) // 2 * 2  # a pixel of colour is two of brightness
        found = _joined(found, (first[0], top + height + beside, first[1], left + width + beside))
    return tuple(
        (
            slice(COARSE * max(top, 0), min(COARSE * bottom, shape[0])),
            slice(COARSE * max(left, 0), min(COARSE * right, shape[1])),
        )
        for top, bottom, left, right in found
    )


def _joined(
    apart: list[tuple[int, int, int, int]], box: tuple[int, int, int, int]
) -> list[tuple[int, int, int, int]]:
    """Add a box (top, bottom, left, right) to boxes that do not overlap; those that do become one."""
    top, bottom, left, right = box
    for other in apart:
        if top < other[1] and other[0] < bottom and left < other[3] and other[2] < right:
            rest = [one for one in apart if one is not other]
            both = min(top, other[0]), max(bottom, other[1]), min(left, other[2]), max(right, other[3])
            return _joined(rest, both)
    return [*apart, box]

"""A look at few pixels of a picture, evenly spread: what changed, where, and by how much.

Most pictures show little that is new. Sixteen times fewer pixels tell where to look at all of them.
"""

import numpy as np
import numpy.typing as npt

from tracking.kernel import compiled, fetch, part
from tracking.median import upper_median
from tracking.planes import Image, Planes

IntArray = npt.NDArray[np.int64]

COARSE = 4  # pixels from one that is looked at to the next
COLOUR_SHARE = 0.6  # compression rounds colour more than brightness
SAME_GAIN = 0.004  # brightness that differs by less than this share is left alone
LEAST_GAIN, MOST_GAIN = 0.5, 2.0
AHEAD = 4  # rows that are asked for before they are looked at
LINE = 64  # bytes that memory gives at a time
SPARSE = 12  # coarse pixels from one that tells of flicker or noise to the next
MOVING = 10.0  # levels: what differs by more moves
TO_SD = float(np.sqrt(np.pi / 2))  # standard deviation over mean absolute one
NINTH, SIXTEEN = np.array((7282, 16), dtype=np.uint32)  # a ninth of two to the sixteenth
ROUNDING, NO_COLOUR, DARKEST, BRIGHTEST = np.array((0.5, 128, 0, 255), dtype=np.float32)
CHANGED_RANK = 8  # coarse pixels that must have changed by so much: one may be noise


@compiled
def coarsely(seen: Planes) -> Planes:
    """Look at a few pixels only, evenly spread; brightness averaged over three rows and columns."""
    down = 2 * COARSE // -(-seen[0].shape[0] // seen[1].shape[0])  # there may be less of colour
    right = 2 * COARSE // -(-seen[0].shape[1] // seen[1].shape[1])
    return (
        _averaged(_every(seen[0], COARSE, COARSE)),
        _every(seen[1], down, right),
        _every(seen[2], down, right),
    )


@part
def _every(plane: Image, down: int, right: int) -> Image:
    """Look at some rows and columns only."""
    few = np.empty((-(-plane.shape[0] // down), -(-plane.shape[1] // right)), dtype=np.uint8)
    line, side_by_side = np.empty(COARSE * few.shape[1], dtype=np.uint8), plane.strides[1] == 1
    for row in range(few.shape[0]):
        own = few[row]
        if side_by_side and right == COARSE:
            soon = plane[min(down * (row + AHEAD), len(plane) - 1)]
            for column in range(0, len(soon), LINE):
                fetch(soon, column)
            for column in range(plane.shape[1]):  # all of it: so memory gives it far sooner
                line[column] = plane[down * row, column]
            for column in range(len(own)):  # a step known beforehand is many columns at once
                own[column] = line[COARSE * column]
        else:
            for column in range(len(own)):
                own[column] = plane[down * row, right * column]
    return few


@part
def _averaged(few: Image) -> Image:
    """Average over three rows and columns."""
    height, width = few.shape
    across, averaged = np.empty(width + 2, dtype=np.uint16), np.empty_like(few)
    for row in range(height):
        above, own, below = few[max(row - 1, 0)], few[row], few[min(row + 1, height - 1)]
        for column in range(width):
            across[column + 1] = np.uint16(above[column]) + np.uint16(own[column]) + np.uint16(below[column])
        across[0], across[width + 1] = across[1], across[width]
        nine = averaged[row]
        for column in range(width):
            summed = np.uint16(across[column] + across[column + 1] + across[column + 2] + 4)
            nine[column] = np.uint8((np.uint32(summed) * NINTH) >> SIXTEEN)
    return averaged


def brightened(planes: Planes, gain: float) -> Planes:
    """Show planes as another exposure would, brightness and colour, unless it is hardly another."""
    return planes if abs(gain - 1) < SAME_GAIN else _exposed(planes, gain)


@compiled
def _exposed(planes: Planes, gain: float) -> Planes:
    """Scale brightness, and by how much colours differ from grey."""
    times = np.float32(gain)
    return (
        _scaled(planes[0], times, ROUNDING),
        _scaled(planes[1], times, ROUNDING + NO_COLOUR * (np.float32(1) - times)),
        _scaled(planes[2], times, ROUNDING + NO_COLOUR * (np.float32(1) - times)),
    )


@part
def _scaled(plane: Image, times: np.float32, more: np.float32) -> Image:
    """Multiply all levels and add to them."""
    scaled = np.empty_like(plane)
    for row in range(len(plane)):
        for column in range(plane.shape[1]):
            level = np.float32(plane[row, column]) * times + more
            scaled[row, column] = np.uint8(min(max(level, DARKEST), BRIGHTEST))
    return scaled


@compiled
def gain_between(image: Image, reference: Image) -> float:
    """How much brighter a picture is than another: flicker. Few of its pixels tell."""
    ratios = np.empty(-(-image.shape[0] // SPARSE) * -(-image.shape[1] // SPARSE))
    number = 0
    for row in range(0, image.shape[0], SPARSE):
        for column in range(0, image.shape[1], SPARSE):
            ratios[number] = (image[row, column] + 1) / (reference[row, column] + 1)
            number += 1
    return min(max(upper_median(ratios), LEAST_GAIN), MOST_GAIN)


@compiled
def noise_between(image: Image, reference: Image, gain: float) -> float:
    """Tell by what standard deviation few pixels of two pictures differ; what moves counts little."""
    summed, number = 0.0, 0
    for row in range(0, image.shape[0], SPARSE):
        for column in range(0, image.shape[1], SPARSE):
            summed += min(abs(image[row, column] - gain * reference[row, column]), MOVING)
            number += 1
    return TO_SD * summed / number


@compiled
def mark_changes(
    coarse: Planes, reference: Planes, least: float, marks: Image, lasting: int, corner: tuple[int, int]
) -> None:
    """Mark where coarse looks differ; marks that are there already count down.

    Parameters
    ----------
    coarse, reference : planes
    least : float
        Least difference that is a change, grey levels.
    marks : (height, width) array
        Altered: `lasting` where brightness or colour differs, one less than before elsewhere.
    lasting : int
    corner : two int
        Even row and column of the reference at which the other look begins.
    """
    _mark(coarse[0], reference[0], np.uint8(least), marks, np.uint8(lasting), corner)
    level = np.uint8(least / COLOUR_SHARE)
    _mark_coloured(coarse, reference, level, marks, np.uint8(lasting), (corner[0] // 2, corner[1] // 2))


@part
def _mark(
    seen: Image, reference: Image, level: np.uint8, marks: Image, lasting: np.uint8, corner: tuple[int, int]
) -> None:
    """Mark where brightness differs by more than a level; other marks count down."""
    for row in range(len(marks)):
        own, one, other = marks[row], seen[row], reference[corner[0] + row, corner[1] :]
        for column in range(len(own)):
            apart = np.uint8(max(one[column], other[column]) - min(one[column], other[column]))
            left = np.uint8(max(own[column], np.uint8(1)) - np.uint8(1))
            own[column] = max(left, np.uint8(np.uint8(apart > level) * lasting))


@part
def _mark_coloured(
    coarse: Planes,
    reference: Planes,
    level: np.uint8,
    marks: Image,
    lasting: np.uint8,
    corner: tuple[int, int],
) -> None:
    """Mark where colour differs by more than a level; one pixel of colour is two of brightness."""
    apart = np.empty(coarse[1].shape[1], dtype=np.uint8)
    for row in range(len(coarse[1])):
        blue, other_blue = coarse[1][row], reference[1][corner[0] + row, corner[1] :]
        red, other_red = coarse[2][row], reference[2][corner[0] + row, corner[1] :]
        most = np.uint8(0)
        for column in range(len(apart)):
            bluer = np.uint8(max(blue[column], other_blue[column]) - min(blue[column], other_blue[column]))
            redder = np.uint8(max(red[column], other_red[column]) - min(red[column], other_red[column]))
            apart[column] = max(bluer, redder)
            most = max(most, apart[column])
        for column in range(len(apart) if most > level else 0):
            if apart[column] > level:
                marks[2 * row : 2 * row + 2, 2 * column : 2 * column + 2] = lasting


@compiled
def largest_change(before: Image, after: Image) -> float:
    """Tell by how much at least the `CHANGED_RANK` most changed places of two pictures differ, levels."""
    counts, largest = np.zeros(256, dtype=np.int64), np.uint8(0)
    for row in range(len(before)):
        one, other, most = before[row], after[row], np.uint8(0)
        for column in range(len(one)):
            most = max(most, np.uint8(max(one[column], other[column]) - min(one[column], other[column])))
        if most > largest:
            for column in range(len(one)):
                counts[max(one[column], other[column]) - min(one[column], other[column])] += 1
            largest = _ranked(counts, largest)
    return float(largest)


@part
def _ranked(counts: IntArray, least: np.uint8) -> np.uint8:
    """Highest level that `CHANGED_RANK` places reach, or the least if none above it is."""
    level, above = 255, counts[255]
    while level > least and above < CHANGED_RANK:
        level -= 1
        above += counts[level]
    return np.uint8(level)

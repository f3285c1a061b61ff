"""The compiled part of `detect` and `blob`: what differs from the background, and what a patch of it is like."""

import numpy as np
import numpy.typing as npt

from tracking.coarse import SAME_GAIN
from tracking.kernel import compiled, part
from tracking.planes import Image, Planes

IntArray = npt.NDArray[np.int32]
Box = tuple[int, int, int, int]
"""Left, top, width and height, px."""

COLOUR_WEIGHT = np.float32(1.5)  # a difference of colour spans fewer levels than one of brightness
BRIGHTEST = np.float32(255)
NINTH, SIXTEEN = np.array((7282, 16), dtype=np.uint32)  # a ninth of two to the sixteenth
GAP = 2  # pixels on each side over which a mask is closed
BESIDE_SHARE = 4  # of a patch's width, from its edge to what is beside it


@compiled
def median_of(pictures: Image) -> Image:
    """Median over pictures (n, height, width), pixel by pixel; the lower one of an even number.

    In each row of all of them the brightest level rises to the last, the next to the last but one, until the
    middle one is found. That compares many pixels at once; sorting each by itself takes far longer.
    """
    count, height, width = pictures.shape
    median, rows = np.empty((height, width), dtype=np.uint8), np.empty((count, width), dtype=np.uint8)
    for row in range(height):
        rows[:] = pictures[:, row]
        for risen in range(count // 2 + 1):
            for k in range(count - 1 - risen):
                _in_order(rows[k], rows[k + 1])
        median[row] = rows[count - 1 - count // 2]
    return median


@part
def _in_order(one: Image, other: Image) -> None:
    """Put the darker of two levels first, in every column."""
    for column in range(len(one)):
        darker, brighter = min(one[column], other[column]), max(one[column], other[column])
        one[column], other[column] = darker, brighter


@compiled
def difference(seen: Planes, background: Planes, gain: float) -> Image:
    """Find the largest difference over the planes, averaged over three rows and columns.

    Parameters
    ----------
    seen, background : planes
    gain : float
        How much brighter than the background the picture is.
    """
    height, width = seen[0].shape
    down, right = -(-height // len(seen[1])), -(-width // seen[1].shape[1])  # there may be less of colour
    apart, twice = np.empty((height, width), dtype=np.uint8), np.empty(seen[1].shape[1], dtype=np.uint16)
    dim, coloured = np.empty(width, dtype=np.uint8), np.empty(right * len(twice), dtype=np.uint8)
    for row in range(height):
        if row % down == 0:
            _coloured(seen, background, row // down, twice)
            for column in range(len(twice)):
                for k in range(right):
                    coloured[right * column + k] = twice[column]
        _brighten(background[0][row], gain, dim)
        own, one = apart[row], seen[0][row]
        for column in range(width):
            own[column] = max(
                np.uint8(max(one[column], dim[column]) - min(one[column], dim[column])), coloured[column]
            )
    return _averaged(apart)


@part
def _brighten(line: Image, gain: float, brighter: Image) -> None:
    """Make a row brighter or darker, unless hardly."""
    if abs(gain - 1) < SAME_GAIN:
        for column in range(len(line)):
            brighter[column] = line[column]
    else:
        times = np.float32(gain)
        for column in range(len(line)):
            brighter[column] = np.uint8(min(np.rint(np.float32(line[column]) * times), BRIGHTEST))


@part
def _coloured(seen: Planes, background: Planes, row: int, coloured: Image) -> None:
    """Find by how much colour differs in a row of it, as heavy as brightness."""
    blue, other_blue, red, other_red = seen[1][row], background[1][row], seen[2][row], background[2][row]
    for column in range(len(coloured)):
        bluer = np.uint8(max(blue[column], other_blue[column]) - min(blue[column], other_blue[column]))
        redder = np.uint8(max(red[column], other_red[column]) - min(red[column], other_red[column]))
        coloured[column] = np.uint8(min(np.rint(np.float32(max(bluer, redder)) * COLOUR_WEIGHT), BRIGHTEST))


@part
def _averaged(levels: Image) -> Image:
    """Average over three rows and columns; beyond an edge lies what is as far on this side of it."""
    height, width = levels.shape
    across, averaged = np.empty(width + 2, dtype=np.uint16), np.empty_like(levels)
    for row in range(height):
        above, own, below = levels[abs(row - 1)], levels[row], levels[min(row + 1, 2 * height - 3 - row)]
        for column in range(width):
            across[column + 1] = np.uint16(above[column]) + np.uint16(own[column]) + np.uint16(below[column])
        across[0], across[width + 1] = across[2], across[width - 1]
        nine = averaged[row]
        for column in range(width):
            summed = np.uint16(across[column] + across[column + 1] + across[column + 2] + 4)
            nine[column] = np.uint8((np.uint32(summed) * NINTH) >> SIXTEEN)
    return averaged


@compiled
def closed(apart: Image, threshold: float) -> Image:
    """Mark with 1 what differs by more than a threshold; gaps of a few pixels are closed."""
    marks, level = np.empty_like(apart), np.uint8(min(threshold, 255.0))
    for row in range(len(apart)):
        for column in range(apart.shape[1]):
            marks[row, column] = apart[row, column] > level
    return _others(_grown(_others(_grown(marks))))


@part
def _others(marks: Image) -> Image:
    """Mark what is not marked."""
    for row in range(len(marks)):
        for column in range(marks.shape[1]):
            marks[row, column] ^= 1
    return marks


@part
def _grown(marks: Image) -> Image:
    """Mark what is near to what is marked."""
    height, width = marks.shape
    line, near, grown = np.zeros(width + 2 * GAP, dtype=np.uint8), np.empty(width, dtype=np.uint8), np.zeros_like(marks)
    for row in range(height):
        own = marks[row]
        for column in range(width):
            line[column + GAP] = own[column]
        for column in range(width):
            near[column] = line[column] | line[column + 1] | line[column + 2] | line[column + 3] | line[column + 4]
        for other in range(max(row - GAP, 0), min(row + GAP + 1, height)):
            own = grown[other]
            for column in range(width):
                own[column] |= near[column]
    return grown


@compiled
def sharp_part(apart: Image, marks: Image, box: Box) -> tuple[float, int, Image]:
    """Tell the level that a tenth of a patch exceeds, and mark and count what exceeds half of it."""
    left, top, width, height = box
    levels, counts = np.empty((height, width), dtype=np.uint8), np.zeros(256, dtype=np.int64)
    for row in range(height):
        for column in range(width):
            levels[row, column] = apart[top + row, left + column] * marks[top + row, left + column]
            counts[levels[row, column]] += 1
    rank, level = int(0.9 * (counts[1:].sum() - 1)), 1
    while level < 255 and rank >= counts[level]:
        rank -= counts[level]
        level += 1
    core = 0
    for row in range(height):
        for column in range(width):
            levels[row, column] = levels[row, column] > level // 2
            core += levels[row, column]
    return float(level), core, levels


@compiled
def measured(outline: IntArray) -> tuple[Box, float, float]:
    """Measure an outline (points, 1, 2) px: its box, its area, and its area once bays are filled.

    Both areas are those of all pixels on and within the line, by Pick's theorem.
    """
    count = len(outline)
    left = right = outline[0, 0, 0]
    top = bottom = outline[0, 0, 1]
    twice = 0
    for k in range(count):
        x, y = outline[k, 0]
        before_x, before_y = outline[k - 1, 0]
        twice += before_x * y - x * before_y
        left, right, top, bottom = min(left, x), max(right, x), min(top, y), max(bottom, y)
    box = left, top, right - left + 1, bottom - top + 1
    return box, abs(twice) / 2 + count / 2 + 1, _spanned(outline, top, bottom - top + 1)


@part
def _spanned(outline: IntArray, top: int, height: int) -> float:
    """Area of all pixels on and within the convex hull of an outline."""
    ends = np.empty((2, height), dtype=np.int64)  # of each row, left and right
    ends[0], ends[1] = np.iinfo(np.int32).max, np.iinfo(np.int32).min
    for k in range(len(outline)):
        x, row = outline[k, 0, 0], outline[k, 0, 1] - top
        ends[0, row], ends[1, row] = min(ends[0, row], x), max(ends[1, row], x)
    twice, around = 0.0, 0.0
    hull = np.empty((height, 2), dtype=np.int64)
    for side in range(2):
        outwards, kept = 2 * side - 1, 0
        for row in range(height):
            x = ends[side, row]
            while kept > 1 and outwards * (
                (hull[kept - 1, 0] - hull[kept - 2, 0]) * (row - hull[kept - 2, 1])
                - (x - hull[kept - 2, 0]) * (hull[kept - 1, 1] - hull[kept - 2, 1])
            ) <= 0:
                kept -= 1
            hull[kept] = x, row
            kept += 1
        for k in range(1, kept):
            across, down = hull[k, 0] - hull[k - 1, 0], hull[k, 1] - hull[k - 1, 1]
            twice += outwards * (hull[k, 0] + hull[k - 1, 0]) * down
            around += np.sqrt(across**2 + down**2)
    around += ends[1, 0] - ends[0, 0] + ends[1, height - 1] - ends[0, height - 1]
    return twice / 2 + around / 2 + 1


@compiled
def look_about(seen: Planes, background: Planes, box: Box) -> tuple[int, int, int, int, int]:
    """Tell brightness and two differences of colour in the middle of a box, and how much both it and the
    background there stand out from what is left and right of it, levels.
    """
    left, top, width, height = box
    row, middle = top + height // 2, left + width // 2
    brightness, blue, red = _colour(seen, row, middle)
    return brightness, blue, red, _stands_out(seen, row, box), _stands_out(background, row, box)


@part
def _stands_out(planes: Planes, row: int, box: Box) -> int:
    """How much the middle of a row in a box differs from what is left and right of it."""
    left, _, width, _ = box
    before, after = (
        _colour(planes, row, left - width // BESIDE_SHARE),
        _colour(planes, row, left + width + width // BESIDE_SHARE),
    )
    inside, most = _colour(planes, row, left + width // 2), 0
    for k in range(3):
        most = max(most, abs(2 * inside[k] - before[k] - after[k]))
    return most


@part
def _colour(planes: Planes, row: int, column: int) -> tuple[int, int, int]:
    """Brightness and two differences of colour at a place; at the side, of what lies beyond it."""
    height, width = planes[0].shape
    rows, columns = planes[1].shape
    down, right = -(-height // rows), -(-width // columns)
    column = max(column, 0)
    own, fewer = min(column, width - 1), min(column // right, columns - 1)
    return int(planes[0][row, own]), int(planes[1][row // down, fewer]), int(planes[2][row // down, fewer])

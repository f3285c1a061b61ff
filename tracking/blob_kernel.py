"""The compiled part of `blob`: what a patch that differs from the background is like."""

import numpy as np
import numpy.typing as npt

from tracking.kernel import compiled, part
from tracking.planes import Image, Planes

IntArray = npt.NDArray[np.int32]
LongArray = npt.NDArray[np.int64]
Box = tuple[int, int, int, int]
"""Left, top, width and height, px."""

MOST = 2**31  # more than any picture is wide
BESIDE_SHARE = 4  # of a patch's width, from its edge to what is beside it


@compiled
def sharp_part(apart: Image, marks: Image, box: Box) -> tuple[float, int, Image]:
    """Tell the level that a tenth of a patch exceeds, and mark and count what exceeds half of it."""
    left, top, width, height = box
    levels, counts = np.empty((height, width), dtype=np.uint8), np.zeros((4, 256), dtype=np.int32)
    for row in range(height):
        own, seen = levels[row], apart[top + row, left : left + width]
        marked = marks[top + row, left : left + width]
        for column in range(width):
            own[column] = seen[column] * marked[column]
        for column in range(width):  # neighbours are alike, and one count would wait for the other
            counts[column & 3, own[column]] += 1
    level, rank = 1, 0
    for other in range(1, 256):
        counts[0, other] += counts[1, other] + counts[2, other] + counts[3, other]
        rank += counts[0, other]
    rank = int(0.9 * (rank - 1))
    while level < 255 and rank >= counts[0, level]:
        rank -= counts[0, level]
        level += 1
    core, half = 0, np.uint8(level // 2)
    for row in range(height):
        own, many = levels[row], np.int32(0)
        for column in range(width):
            own[column] = own[column] > half
            many += np.int32(own[column])
        core += int(many)
    return float(level), core, levels


@compiled
def measured(outline: IntArray) -> tuple[Box, float, float]:
    """Measure an outline (points, 1, 2) px: its box, its area, and its area once bays are filled.

    Both areas are those of all pixels on and within the line, by Pick's theorem.
    """
    count = len(outline)
    left, right, top, bottom = outline[0, 0, 0], outline[0, 0, 0], outline[0, 0, 1], outline[0, 0, 1]
    twice = 0
    for k in range(count):
        x, y = outline[k, 0, 0], outline[k, 0, 1]
        twice += outline[k - 1, 0, 0] * y - x * outline[k - 1, 0, 1]
        left, right, top, bottom = min(left, x), max(right, x), min(top, y), max(bottom, y)
    box = left, top, right - left + 1, bottom - top + 1
    return box, abs(twice) / 2 + count / 2 + 1, _spanned(outline, top, bottom - top + 1)


@part
def _spanned(outline: IntArray, top: int, height: int) -> float:
    """Area of all pixels on and within the convex hull of an outline."""
    leftmost, rightmost = np.full(height, MOST), np.full(height, -MOST)
    for k in range(len(outline)):
        x, row = outline[k, 0, 0], outline[k, 0, 1] - top
        leftmost[row], rightmost[row] = min(leftmost[row], x), max(rightmost[row], x)
    left, left_length = _side(leftmost, -1)
    right, right_length = _side(rightmost, 1)
    ends = rightmost[0] - leftmost[0] + rightmost[height - 1] - leftmost[height - 1]
    return float((left + right) / 2 + (left_length + right_length + ends) / 2 + 1)


@part
def _side(places: LongArray, outwards: int) -> tuple[float, float]:
    """Twice the area between one side of a convex hull and the axis, and its length, from one place a row."""
    rows, kept = np.empty(len(places), dtype=np.int64), 0
    for row in range(len(places)):
        while kept > 1 and outwards * _turn(places, rows[kept - 2], rows[kept - 1], row) <= 0:
            kept -= 1
        rows[kept] = row
        kept += 1
    twice, length = 0.0, 0.0
    for k in range(1, kept):
        one, other = rows[k - 1], rows[k]
        twice += outwards * (places[one] + places[other]) * (other - one)
        length += np.sqrt((places[other] - places[one]) ** 2 + (other - one) ** 2)
    return twice, length


@part
def _turn(places: LongArray, first: int, second: int, third: int) -> int:
    """Tell to which side the way through places in three rows turns: positive to the left."""
    across, further = places[second] - places[first], places[third] - places[first]
    return int(across * (third - first) - further * (second - first))


@compiled
def look_about(seen: Planes, background: Planes, box: Box) -> tuple[int, int, int, int, int]:
    """Tell brightness and two differences of colour in the middle of a box; and how much it stands out there.

    The last two are how much picture and background differ from what is left and right of the box, levels.
    """
    left, top, width, height = box
    row, middle = top + height // 2, left + width // 2
    brightness, blue, red = _colour(seen, row, middle)
    return brightness, blue, red, _stands_out(seen, row, box), _stands_out(background, row, box)


@part
def _stands_out(planes: Planes, row: int, box: Box) -> int:
    """How much the middle of a row in a box differs from what is left and right of it."""
    left, _, width, _ = box
    beside, most = width // BESIDE_SHARE, 0
    before, after = _colour(planes, row, left - beside), _colour(planes, row, left + width + beside)
    inside = _colour(planes, row, left + width // 2)
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

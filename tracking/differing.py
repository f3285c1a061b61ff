"""The compiled part of `detect`: how much each pixel differs from the background, and which do."""

import numpy as np

from tracking.kernel import compiled, part
from tracking.planes import Image, Planes

WIDEST = np.uint16(255)
ONE, THREE, FOUR = np.array((1, 3, 4), dtype=np.uint16)  # of half precision, or all would be double
NINTH, SIXTEEN = np.array((7282, 16), dtype=np.uint32)  # a ninth of two to the sixteenth
MARKED = np.uint8(1)
GAP = 2  # pixels on each side over which a mask is closed


@compiled
def difference(
    seen: Planes, background: Planes, box: tuple[int, int, int, int], corner: tuple[int, int]
) -> Image:
    """Find the largest difference over the planes in a box, averaged over three rows and columns.

    Parameters
    ----------
    seen, background : planes
    box : four int
        First and last row, first and last column; the first ones even, the last ones not in it.
    corner : two int
        Even row and column of the background at which the picture begins.
    """
    top, bottom, left, right = box
    finer = -(-seen[0].shape[0] // len(seen[1])), -(-seen[0].shape[1] // seen[1].shape[1])
    apart = np.empty((bottom - top, right - left), dtype=np.uint8)
    coloured = np.empty(finer[1] * (-(-right // finer[1]) - left // finer[1]), dtype=np.uint8)
    for row in range(top, bottom):
        if (row - top) % finer[0] == 0:
            _colour(seen, background, (row // finer[0], left // finer[1]), finer, corner, coloured)
        own, one = apart[row - top], seen[0][row, left:right]
        other = background[0][corner[0] + row, corner[1] + left : corner[1] + right]
        for column in range(len(own)):
            least, most = min(one[column], other[column]), max(one[column], other[column])
            own[column] = max(np.uint8(most - least), coloured[column])
    return _averaged(apart)


@part
def _colour(
    seen: Planes,
    background: Planes,
    start: tuple[int, int],
    finer: tuple[int, int],
    corner: tuple[int, int],
    coloured: Image,
) -> None:
    """Find by how much colour differs in a row of it from its start on.

    It counts half as much again as brightness, of which it spans fewer levels, and is given as many pixels.
    """
    row, left = start
    many = len(coloured) // finer[1]
    far, side = corner[0] // finer[0] + row, corner[1] // finer[1] + left
    blue, red = seen[1][row, left : left + many], seen[2][row, left : left + many]
    other_blue, other_red = background[1][far, side : side + many], background[2][far, side : side + many]
    for column in range(many):
        bluer = np.uint8(max(blue[column], other_blue[column]) - min(blue[column], other_blue[column]))
        redder = np.uint8(max(red[column], other_red[column]) - min(red[column], other_red[column]))
        thrice = np.uint16(THREE * max(bluer, redder))
        half = np.uint16(thrice >> ONE)
        apart = np.uint8(min(np.uint16(half + (thrice & half & ONE)), WIDEST))  # halves to the even
        if finer[1] == 1:
            coloured[column] = apart
        else:
            coloured[2 * column] = apart
            coloured[2 * column + 1] = apart


@part
def _averaged(levels: Image) -> Image:
    """Average over three rows and columns; beyond an edge lies what is as far on this side of it."""
    height, width = levels.shape
    across, averaged = np.empty(width + 2, dtype=np.uint16), np.empty_like(levels)
    for row in range(height):
        above = levels[min(abs(row - 1), height - 1)]
        own, below = levels[row], levels[max(min(row + 1, 2 * height - 3 - row), 0)]
        for column in range(width):
            across[column + 1] = np.uint16(above[column]) + np.uint16(own[column]) + np.uint16(below[column])
        across[0], across[width + 1] = across[min(2, width)], across[max(width - 1, 1)]
        nine = averaged[row]
        for column in range(width):
            summed = np.uint16(across[column] + across[column + 1] + across[column + 2] + FOUR)
            nine[column] = np.uint8((np.uint32(summed) * NINTH) >> SIXTEEN)
    return averaged


@compiled
def closed(apart: Image, threshold: float) -> Image:
    """Mark with 1 what differs by more than a threshold; gaps of a few pixels are closed."""
    marks, level = np.empty_like(apart), np.uint8(min(threshold, 255.0))
    for row in range(len(apart)):
        own, levels = marks[row], apart[row]
        for column in range(len(own)):
            own[column] = levels[column] > level
    return _far(_far(marks))


@part
def _far(marks: Image) -> Image:
    """Mark what is not near to anything marked."""
    height, width = marks.shape
    near, far = np.zeros((height + 2 * GAP, width), dtype=np.uint8), np.empty_like(marks)
    line = np.zeros(width + 2 * GAP, dtype=np.uint8)
    for row in range(height):
        own, beside = marks[row], near[row + GAP]
        for column in range(width):
            line[column + GAP] = own[column]
        for column in range(width):
            beside[column] = (
                line[column] | line[column + 1] | line[column + 2] | line[column + 3] | line[column + 4]
            )
    for row in range(height):
        own, one, two, three = far[row], near[row], near[row + 1], near[row + 2]
        four, five = near[row + 3], near[row + 4]
        for column in range(width):
            own[column] = MARKED ^ (one[column] | two[column] | three[column] | four[column] | five[column])
    return far

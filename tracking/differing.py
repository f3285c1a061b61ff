"""The compiled part of `detect`: how much each pixel differs from the background, and which do."""

import numpy as np

from tracking.coarse import SAME_GAIN
from tracking.kernel import compiled, part
from tracking.planes import Image, Planes

COLOUR_WEIGHT = np.float32(1.5)  # a difference of colour spans fewer levels than one of brightness
BRIGHTEST = np.float32(255)
NINTH, SIXTEEN = np.array((7282, 16), dtype=np.uint32)  # a ninth of two to the sixteenth
GAP = 2  # pixels on each side over which a mask is closed


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
    apart, dim = np.empty((height, width), dtype=np.uint8), np.empty(width, dtype=np.uint8)
    coloured = np.empty(right * seen[1].shape[1], dtype=np.uint8)
    for row in range(height):
        if row % down == 0:
            _colour(seen, background, row // down, coloured)
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
def _colour(seen: Planes, background: Planes, row: int, coloured: Image) -> None:
    """Find by how much colour differs in a row of it, as heavy as brightness and with as many pixels."""
    blue, other_blue, red, other_red = seen[1][row], background[1][row], seen[2][row], background[2][row]
    right = len(coloured) // len(blue)
    for column in range(len(blue)):
        bluer = np.uint8(max(blue[column], other_blue[column]) - min(blue[column], other_blue[column]))
        redder = np.uint8(max(red[column], other_red[column]) - min(red[column], other_red[column]))
        apart = np.uint8(min(np.rint(np.float32(max(bluer, redder)) * COLOUR_WEIGHT), BRIGHTEST))
        for k in range(right * column, right * column + right):
            coloured[k] = apart


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
    line, near = np.zeros(width + 2 * GAP, dtype=np.uint8), np.empty(width, dtype=np.uint8)
    grown = np.zeros_like(marks)
    for row in range(height):
        own = marks[row]
        for column in range(width):
            line[column + GAP] = own[column]
        for column in range(width):
            near[column] = (
                line[column] | line[column + 1] | line[column + 2] | line[column + 3] | line[column + 4]
            )
        for other in range(max(row - GAP, 0), min(row + GAP + 1, height)):
            own = grown[other]
            for column in range(width):
                own[column] |= near[column]
    return grown

"""Which patch of each picture is the ball: one path through the candidates of all frames."""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from tracking.blob import Blob
from tracking.kernel import compiled, part

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

MISSING = -1
MISSING_COST = 6.0
SIZE_SPREAD = 0.18  # a ball's width varies by this share (blur, shading, cut at half contrast)
FILL_SPREAD = 0.15
BAY_COST = 2.0  # a ball lit from one side may be seen as a crescent, where it is as bright as the wall
GHOST_COST = 8.0  # where a ball was that has left
BORDER_COST = 4.0  # hands and cues come in from the border; a ball that touches it is not whole
COLOUR_COST = 6.0  # at most: a ball keeps its colour, but may have a pattern
COLOUR_SPREAD = 15.0  # levels
BRIGHTNESS_SPREAD = 60.0  # levels: a ball that turns or falls into the shade changes more
STILL_COST = 0.5  # a frame; what rests is rather a ball that waits, or its ghost in the background
STILL = 0.02  # radii a frame
FALL_COST = 0.1  # a radius up or down in a frame
LEAP_COST = 0.03  # its square: to another ball and back costs more than the way of one
JUMP = 2.0  # radii: a thing at rest that is this far away in the next frame was not the ball
RESTING = 3  # frames in one place
LONGEST_GAP = 12  # frames a path may skip
QUANTILES = (1 / 6, 1 / 2, 5 / 6)  # of all votes for a size
OTHER_SIZE = 0.25  # of the logarithm, from which two sizes are not one
CLEARLY = 0.8  # of the cost with the middle size: another one that costs more is not believed
GOES = 0.3  # of the way of the one that goes furthest: what goes less is no ball
LONGEST_STEP = 16.0  # radii a frame: what is further away is another thing


def sharper(path: Mapping[int, Blob], count: int) -> set[int]:
    """Choose some frames of a path, all along it, from the half in which the ball is smeared less.

    The sharpest of all would be those in which a hand still holds it.
    """
    half = sorted(sorted(path, key=lambda number: path[number].blur)[: len(path) // 2 + 1])
    return {half[i] for i in np.linspace(0, len(half) - 1, count).astype(int)}


def guess_radius(frames: Sequence[Sequence[Blob]]) -> float | None:
    """Guess the ball's radius in px from what is round, distinct and moves; None if nothing is.

    Each round patch votes with its contrast times the way to the nearest patch like it in the next frame. The
    middle vote tells, unless many are for quite another size: then that size of which a ball goes through the
    recording at the least cost. Pieces of a hand may be round, but do not go far.
    """
    widths, votes = [], []
    for now, after in pairwise(frames):
        for blob in filter(_round, now):
            alike = [
                np.hypot(blob.x - other.x, blob.y - other.y)
                for other in after
                if _round(other) and abs(np.log(other.width / blob.width)) < SIZE_SPREAD
            ]
            way = min(alike, default=0.0)
            if 0.5 < way < 8 * blob.width:
                widths.append(blob.width)
                votes.append(blob.contrast * way)
    if len(widths) < 5:
        return None
    order = np.argsort(widths)
    share = np.cumsum(np.asarray(votes)[order]) / np.sum(votes)
    told = np.asarray(widths)[order][np.searchsorted(share, QUANTILES)] / 2
    middle = told[len(told) // 2]
    others = told[np.abs(np.log(told / middle)) > OTHER_SIZE]
    return float(middle) if not others.size else _cheaper(_joined(frames), [middle, *others])


def _round(blob: Blob) -> bool:
    """Tell whether a patch could be a ball, sharp or smeared upright."""
    return not blob.at_border and 0.8 < blob.fill < 1.15 and 0.75 < blob.height / blob.width < 2.5


def best_path(frames: Sequence[Sequence[Blob]], radius: float) -> list[int]:
    """Choose at most one candidate a frame: the cheapest path (dynamic programming).

    Parameters
    ----------
    frames : candidates of each frame
    radius : the ball's radius, px

    Returns
    -------
    list of int
        Index into each frame's candidates, or MISSING.
    """
    joined = _joined(frames)
    total, came = _paths(joined, radius)
    places = [MISSING] * len(frames)
    for index in _walk_back(total, came):
        places[joined.number[index]] = int(index - joined.first[joined.number[index]])
    return _without_ghosts(places, frames, radius)


class _Joined(NamedTuple):
    """Candidates of all frames: a table (12, n), the frame of each (n,), and the first of each frame."""

    table: FloatArray
    number: IntArray
    first: IntArray


def _joined(frames: Sequence[Sequence[Blob]]) -> _Joined:
    """Put the candidates of all frames in one table."""
    number = np.repeat(np.arange(len(frames)), [len(blobs) for blobs in frames])
    first = np.searchsorted(number, np.arange(len(frames) + 1))
    return _Joined(_table([blob for blobs in frames for blob in blobs]), number, first)


def _paths(joined: _Joined, radius: float) -> tuple[FloatArray, IntArray]:
    """Cost of the cheapest path that ends at each patch, and which patch is before it."""
    total, came = _cheapest(joined.table, _misfit(joined.table, radius), joined.first, float(radius))
    return total + MISSING_COST * (len(joined.first) - 2 - joined.number), came


def _cheaper(joined: _Joined, sizes: Sequence[float]) -> float:
    """Choose the radius with which a ball goes far at the least cost; the first unless another is cheaper."""
    costs, ways = [], []
    for radius in sizes:
        total, came = _paths(joined, radius)
        costs.append(float(total.min()))
        ways.append(float(np.ptp(joined.table[:2, _walk_back(total, came)], axis=1).max()))
    going = [k for k, way in enumerate(ways) if way >= GOES * max(ways)]
    best = min(going, key=costs.__getitem__)
    if 0 in going and costs[best] > CLEARLY * costs[0]:
        best = 0
    return float(sizes[best])


def _table(blobs: Sequence[Blob]) -> FloatArray:
    """Rows of place, size, fill, contrast, border, fill with bays, ghost, colour: (12, n) for n patches."""
    rows = [
        (b.x, b.y, b.width, b.height, b.fill, b.contrast, b.at_border, b.spanned, b.ghost, *b.colour)
        for b in blobs
    ]
    return np.array(rows, dtype=np.float64).reshape(-1, 12).T


def _misfit(table: FloatArray, radius: float) -> FloatArray:
    """Cost of taking each patch for the ball: wrong width, not round, smeared."""
    _, _, width, height, fill, _, at_border, spanned, ghost, *_ = table
    size = np.log(width / (2 * radius)) / SIZE_SPREAD
    roundness, as_crescent = ((np.log(share) / FILL_SPREAD) ** 2 for share in (fill, spanned))
    stretch = np.maximum(0.0, np.abs(np.log(height / width)) - 0.25)
    shape = np.minimum(roundness, as_crescent + BAY_COST) + 2 * stretch
    return np.asarray(size**2 + shape + BORDER_COST * at_border + GHOST_COST * ghost)


@compiled
def _cheapest(
    table: FloatArray, own: FloatArray, first: IntArray, radius: float
) -> tuple[FloatArray, IntArray]:
    """Cost of the cheapest path to each patch, and which patch is before it; `first` patch of each frame."""
    total, came = np.empty(len(own)), np.full(len(own), MISSING)
    for frame in range(len(first) - 1):
        for here in range(first[frame], first[frame + 1]):
            total[here] = own[here] + MISSING_COST * frame
            for earlier in range(max(0, frame - LONGEST_GAP), frame):
                skipped = MISSING_COST * (frame - earlier - 1)
                for there in range(first[earlier], first[earlier + 1]):
                    step = _step_cost(table[:, there], table[:, here], radius, frame - earlier)
                    if total[there] + step + skipped + own[here] < total[here]:
                        total[here], came[here] = total[there] + step + skipped + own[here], there
    return total, came


@part
def _step_cost(before: FloatArray, after: FloatArray, radius: float, gap: int) -> float:
    """Cost of going from a candidate to a later one: sideways is dear, up and down is cheap."""
    across = (before[0] - after[0]) / (radius * gap)
    along = abs(before[1] - after[1]) / (radius * gap)
    if along * gap > LONGEST_STEP * min(gap, 3):
        return np.inf
    fade = np.log(before[5] / after[5])
    still = STILL_COST if across**2 + along**2 < STILL**2 else 0.0
    hue = ((before[10] - after[10]) ** 2 + (before[11] - after[11]) ** 2) / COLOUR_SPREAD**2
    colour = min(hue + ((before[9] - after[9]) / BRIGHTNESS_SPREAD) ** 2, COLOUR_COST)
    return float(colour + across**2 + FALL_COST * along + LEAP_COST * along**2 + fade**2 + still)


def _walk_back(total: FloatArray, came: IntArray) -> list[int]:
    """Follow the cheapest path from its end to its start."""
    chosen = []
    here = int(total.argmin()) if total.size else MISSING
    while here != MISSING:
        chosen.append(here)
        here = int(came[here])
    return chosen


def _without_ghosts(chosen: list[int], frames: Sequence[Sequence[Blob]], radius: float) -> list[int]:
    """Cut off what rests at either end of a path and is left by a jump: another ball, or a ghost."""
    seen = [number for number, index in enumerate(chosen) if index != MISSING]
    for order in (seen, seen[::-1]):
        height = np.array([frames[number][chosen[number]].y for number in order])
        way = np.abs(height - height[:1])
        rested = np.count_nonzero(np.maximum.accumulate(way) <= radius / 2)
        if RESTING <= rested < len(way) and _jumps(way[rested : rested + RESTING], radius):
            half_way = int(way[rested] <= JUMP * radius)
            for number in order[: rested + half_way]:
                chosen[number] = MISSING
    return chosen


def _jumps(way: FloatArray, radius: float) -> bool:
    """Tell a jump, at once or in ever shorter steps, from a fall, by the way from rest in the next places."""
    slower = len(way) > 1 and way[-1] - way[-2] < way[0]
    return bool(way[0] > JUMP * radius or (slower and way[-1] > JUMP * radius))

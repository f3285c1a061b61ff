"""Which patch of each picture is the ball: one path through the candidates of all frames."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from tracking.detect import Blob

MISSING = -1
MISSING_COST = 6.0
SIZE_SPREAD = 0.18  # a ball's width varies by this share (blur, shading, cut at half contrast)
FILL_SPREAD = 0.15
BORDER_COST = 4.0  # hands and cues come in from the border; a ball that touches it is not whole
STILL_COST = 0.5  # a frame; what rests is rather a ball that waits, or its ghost in the background
STILL = 0.02  # radii a frame
JUMP = 2.0  # radii: a thing at rest that is this far away in the next frame was not the ball
RESTING = 3  # frames in one place
LONGEST_GAP = 12  # frames a path may skip
LONGEST_STEP = 16.0  # radii a frame: what is further away is another thing


def guess_radius(frames: Sequence[Sequence[Blob]]) -> float | None:
    """Guess the ball's radius in px from what is round, distinct and moves; None if nothing is.

    Each round patch votes with its contrast times the way to the nearest patch like it in the next frame.
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
    return float(np.asarray(widths)[order][np.searchsorted(share, 0.5)]) / 2


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
    cost: list[np.ndarray] = []
    origin: list[list[tuple[int, int] | None]] = []
    for number, blobs in enumerate(frames):
        own = np.array([_misfit(blob, radius) for blob in blobs])
        total = own + MISSING_COST * number
        came: list[tuple[int, int] | None] = [None] * len(blobs)
        for gap in range(1, min(LONGEST_GAP, number) + 1):
            before = frames[number - gap]
            if not before or not blobs:
                continue
            step = _step_costs(before, blobs, radius, gap)
            reach = cost[number - gap][:, None] + step + MISSING_COST * (gap - 1) + own[None, :]
            best = reach.argmin(axis=0)
            for index, row in enumerate(best):
                if reach[row, index] < total[index]:
                    total[index] = reach[row, index]
                    came[index] = (number - gap, int(row))
        cost.append(total)
        origin.append(came)
    return _without_ghosts(_walk_back(cost, origin), frames, radius)


def _misfit(blob: Blob, radius: float) -> float:
    """Cost of taking a patch for the ball: wrong width, not round, smeared."""
    size = np.log(blob.width / (2 * radius)) / SIZE_SPREAD
    fill = np.log(blob.fill) / FILL_SPREAD
    stretch = max(0.0, abs(np.log(blob.height / blob.width)) - 0.25)
    return float(size**2 + fill**2 + 2 * stretch + BORDER_COST * blob.at_border)


def _step_costs(before: Sequence[Blob], after: Sequence[Blob], radius: float, gap: int) -> np.ndarray:
    """Cost of going from each candidate to each later one: sideways is dear, up and down is cheap."""
    across = np.subtract.outer([b.x for b in before], [b.x for b in after]) / (radius * gap)
    along = np.subtract.outer([b.y for b in before], [b.y for b in after]) / (radius * gap)
    fade = np.log(np.divide.outer([b.contrast for b in before], [b.contrast for b in after]))
    still = STILL_COST * (np.hypot(across, along) < STILL)
    cost = across**2 + 0.1 * np.abs(along) + fade**2 + still
    return np.asarray(np.where(np.abs(along) * gap > LONGEST_STEP * min(gap, 3), np.inf, cost))


def _walk_back(cost: list[np.ndarray], origin: list[list[tuple[int, int] | None]]) -> list[int]:
    """Follow the cheapest path from its end to its start."""
    frames = len(cost)
    chosen = [MISSING] * frames
    ends = [
        (float(total.min()) + MISSING_COST * (frames - 1 - number), number, int(total.argmin()))
        for number, total in enumerate(cost)
        if total.size
    ]
    here: tuple[int, int] | None = min(ends)[1:] if ends else None
    while here is not None:
        number, index = here
        chosen[number] = index
        here = origin[number][index]
    return chosen


def _without_ghosts(chosen: list[int], frames: Sequence[Sequence[Blob]], radius: float) -> list[int]:
    """Cut off what rests at either end of a path and is left by a jump: another ball, or a ghost."""
    seen = [number for number, index in enumerate(chosen) if index != MISSING]
    for order in (seen, seen[::-1]):
        height = np.array([frames[number][chosen[number]].y for number in order])
        rested = np.flatnonzero(np.abs(height - height[:1]) > radius / 2)
        if rested.size and rested[0] >= RESTING and abs(height[rested[0]] - height[0]) > JUMP * radius:
            for number in order[: rested[0]]:
                chosen[number] = MISSING
    return chosen

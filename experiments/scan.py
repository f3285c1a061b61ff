"""Outcome and states of a two-ball drop over the stiffness ratio: where they change, and where they jump."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from experiments import paper
from impact import TwoBallDrop, collide, collide_many

Array = NDArray[np.float64]

RATIOS = np.geomspace(1e-3, 1e3, 1801)
_HALVINGS = 40  # of an interval between two ratios, until its ends are next to each other
_LEAST_JUMP = 0.002  # of a velocity over the approach speed


@dataclass(frozen=True, slots=True, kw_only=True)
class Change:
    """A stiffness ratio k2/k1 at which the order of states changes, and the orders on either side."""

    ratio: float
    below: str
    above: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Jump:
    """Where the outcome jumps.

    Attributes
    ----------
    ratio : float
        k2/k1.
    step : ndarray (2,)
        By how much v1 and v2 over the approach speed change there.
    below, above : str
        States with their events on either side, as ``S1[C1-R1] S2[C2-R2]``.
    """

    ratio: float
    step: Array
    below: str
    above: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Scan:
    """Outcomes over the stiffness ratio.

    Attributes
    ----------
    ratios : ndarray (N,)
        k2/k1.
    velocities : ndarray (N, 2)
        v1 and v2 over the approach speed.
    states : tuple of N str
        Order of states.
    changes : tuple of Change
        Of the order of states, from low to high ratios.
    jumps : tuple of Jump
        From low to high ratios. Most changes are none: a state begins with length zero. And some jumps are
        no change: only the order of events within S1 is another.
    """

    ratios: Array
    velocities: Array
    states: tuple[str, ...]
    changes: tuple[Change, ...]
    jumps: tuple[Jump, ...]


def compute(drop: TwoBallDrop = paper.FIG5_DROP, ratios: Array = RATIOS) -> Scan:
    """Scan the ratio; halve every interval in which the order of states changes or a velocity may jump.

    Parameters
    ----------
    drop : TwoBallDrop
        Whose ratio is varied.
    ratios : ndarray (N,)
        Rising. Two changes between neighbours that undo each other are not seen.

    Raises
    ------
    ConvergenceError
        If a collision does not end.
    """
    velocities, states = _outcomes(drop, ratios)
    return Scan(
        ratios=ratios,
        velocities=velocities,
        states=tuple(states.tolist()),
        changes=tuple(sorted(_changes(drop, ratios, states), key=lambda change: change.ratio)),
        jumps=tuple(_jumps(drop, ratios, velocities)),
    )


def _changes(drop: TwoBallDrop, ratios: Array, states: NDArray[np.str_]) -> Iterator[Change]:
    """Find the changes in each interval of the scan one after the other, in all intervals at once."""
    different = np.flatnonzero(states[:-1] != states[1:])
    low, last = ratios[different], ratios[different + 1]
    while len(low):
        before, high = _outcomes(drop, low)[1], last
        for _ in range(_HALVINGS):
            middle = np.sqrt(low * high)
            same = _outcomes(drop, middle)[1] == before
            low, high = np.where(same, middle, low), np.where(same, high, middle)
        after = _outcomes(drop, high)[1]
        for ratio, below, above in zip(high, before, after, strict=True):
            yield Change(ratio=float(ratio), below=str(below), above=str(above))
        unfinished = after != _outcomes(drop, last)[1]
        low, last = high[unfinished], last[unfinished]


def _jumps(drop: TwoBallDrop, ratios: Array, velocities: Array) -> Iterator[Jump]:
    """Follow the larger part of each change of velocity; what does not shrink with the interval is a jump."""
    pairs = np.stack([ratios[:-1], ratios[1:]], axis=1)
    ends = np.stack([velocities[:-1], velocities[1:]], axis=1)
    for _ in range(_HALVINGS):
        large = np.abs(ends[:, 1] - ends[:, 0]).max(axis=1) > _LEAST_JUMP
        if not large.any():
            return
        pairs, ends = pairs[large], ends[large]
        middle = np.sqrt(pairs.prod(axis=1))
        between = _outcomes(drop, middle)[0]
        parts = [np.abs(between - ends[:, side]).max(axis=1) for side in (0, 1)]
        upper = parts[1] > parts[0]
        rows = np.arange(len(pairs))
        pairs[rows, np.where(upper, 0, 1)] = middle
        ends[rows, np.where(upper, 0, 1)] = between
    for (low, high), (before, after) in zip(pairs, ends, strict=True):
        yield Jump(
            ratio=float(high), step=after - before, below=_events(drop, low), above=_events(drop, high)
        )


def _events(drop: TwoBallDrop, ratio: float) -> str:
    stiffness = ratio * drop.ball_ball.stiffness
    collision = collide(replace(drop, ball_table=replace(drop.ball_table, stiffness=stiffness)))
    return " ".join(f"{segment.state}[{segment.events}]" for segment in collision.segments)


def _outcomes(drop: TwoBallDrop, ratios: Array) -> tuple[Array, NDArray[np.str_]]:
    """Velocities over the approach speed, and the order of states, for each ratio."""
    many = collide_many(drop, stiffness_ratio=ratios)
    return many.velocities / -drop.approach_velocity, np.array([" ".join(states) for states in many.states])

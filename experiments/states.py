"""Not in the paper: outcome and states of a two-ball drop over the stiffness ratio, and where they jump."""

import csv
import io
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import NullLocator
from numpy.typing import NDArray

from calibrate.files import write_whole
from experiments import paper
from experiments.drawing import LOWER, QUIET, SEGMENTS, UPPER, label, new_figure, save_both
from impact import TwoBallDrop, collide, collide_many

Array = NDArray[np.float64]

RATIOS = np.geomspace(1e-3, 1e3, 1801)
_HALVINGS = 40  # of an interval between two ratios, until its ends are next to each other
_LEAST_JUMP = 0.002  # of a velocity over the approach speed
_COLORS = {"S1": SEGMENTS[4], "S2": SEGMENTS[1], "S3": SEGMENTS[2]}
_MEANING = {"S1": "S₁ both contacts active", "S2": "S₂ only ball-table", "S3": "S₃ only ball-ball"}
_APART = 1.27  # ratio of one labelled jump to the one before
_TICKS = (1, 2, 3, 4, 6, 10, 20, 30)


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


def draw(scan: Scan) -> Figure:
    """Draw the velocities, and below them the states in their order."""
    figure, ((top,), (bottom,)) = new_figure(9.0, 7.0, 2, 1)
    _draw_velocities(top, scan)
    _draw_states(bottom, scan)
    for axes in (top, bottom):
        axes.set_xscale("log")
        axes.set_xlim(scan.ratios[0], scan.ratios[-1])
    return figure


def _draw_velocities(axes: Axes, scan: Scan) -> None:
    jumps = [jump.ratio for jump in scan.jumps]
    pieces = np.split(np.arange(len(scan.ratios)), np.searchsorted(scan.ratios, jumps))
    for ball, (color, name) in enumerate(((UPPER, "v₁, upper ball"), (LOWER, "v₂, lower ball"))):
        for piece in pieces:
            axes.plot(scan.ratios[piece], scan.velocities[piece, ball], color=color, linewidth=1.8)
        place = (1.0, float(np.interp(1.0, scan.ratios, scan.velocities[:, ball])))
        axes.annotate(name, place, (0, 6 - 20 * ball), textcoords="offset points", color=color, ha="center")
    for before, ratio in zip([0.0, *jumps], jumps, strict=False):
        axes.axvline(ratio, color=QUIET, linewidth=0.8, linestyle=":")
        if ratio > _APART * before:
            axes.annotate(f"{ratio:.4g}", (ratio, 0.45), rotation=90, fontsize=8, ha="right", va="center")
    axes.set_ylim(0.0, 0.9)
    label(axes, ("", "velocity after / approach speed", _title()))


def _title() -> str:
    first, second = paper.BALL_BALL.mean, paper.BALL_TABLE.mean
    return f"equal balls, e₁ = {first:.4g}, e₂ = {second:.4g}; dotted: the outcome jumps"


def _draw_states(axes: Axes, scan: Scan) -> None:
    """Stack the states in their order, the first at the bottom."""
    edges = [scan.ratios[0], *(change.ratio for change in scan.changes), scan.ratios[-1]]
    orders = [scan.states[0], *(change.above for change in scan.changes)]
    for low, high, order in zip(edges[:-1], edges[1:], orders, strict=True):
        for number, state in enumerate(order.split(), start=1):
            axes.fill_between([low, high], number, number + 1, color=_COLORS[state], linewidth=0.0)
            if high > 1.9 * low and number <= 4:
                axes.annotate(
                    state, (np.sqrt(low * high), np.sqrt(number * (number + 1))), ha="center", va="center"
                )
    axes.set_yscale("log")
    axes.set_ylim(1.0, 1.0 + max(len(order.split()) for order in orders))
    axes.set_yticks([np.sqrt(tick * (tick + 1)) for tick in _TICKS], [str(tick) for tick in _TICKS])
    axes.yaxis.set_minor_locator(NullLocator())
    handles = [Patch(color=color, label=_MEANING[state]) for state, color in _COLORS.items()]
    axes.legend(handles=handles, loc="upper right", frameon=False)
    label(axes, ("k₂/k₁, ball-table over ball-ball stiffness", "first, second, ... state", "order of states"))


def main(out: Path) -> str:
    """Write ``states.svg``, ``states.png`` and ``states.csv``; return the jumps."""
    scan = compute()
    save_both(draw(scan), out, "states")
    write_whole(out / "states.csv", _table(scan))
    return _text(scan)


def _text(scan: Scan) -> str:
    lines = [f"{'jumps at k2/k1':>14} {'v1/|v0|':>9} {'v2/|v0|':>9}  states and events"]
    for jump in scan.jumps:
        lines += [
            f"{jump.ratio:14.7g} {jump.step[0]:>+9.4f} {jump.step[1]:>+9.4f}  below: {jump.below}",
            f"{'':34}  above: {jump.above}",
        ]
    return "\n".join(lines)


def _table(scan: Scan) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["stiffness_ratio", "v1", "v2", "states"])
    for ratio, velocities, states in zip(scan.ratios, scan.velocities, scan.states, strict=True):
        writer.writerow([f"{ratio:.8g}", *(f"{velocity:.8g}" for velocity in velocities), states])
    return text.getvalue()

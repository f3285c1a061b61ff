"""Not in the paper: how outcome and order of states depend on the stiffness ratio, and where they jump."""

import csv
import io
from collections.abc import Iterator
from itertools import groupby
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
from experiments.scan import Scan, compute

Array = NDArray[np.float64]

_COLORS = {"S1": SEGMENTS[4], "S2": SEGMENTS[1], "S3": SEGMENTS[2]}
_MEANING = {"S1": "S₁ both contacts active", "S2": "S₂ only ball-table", "S3": "S₃ only ball-ball"}
_APART = 1.27  # ratio of one labelled jump to the one before
_NAMED_FROM = 1.5  # upper over lower end of a field that is named
_TICKS = (1, 2, 3, 4, 6, 10, 20, 30)


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
    most = max(len(states.split()) for states in scan.states)
    for number in range(1, most + 1):
        for state, low, high in _runs(scan, number):
            axes.fill_between([low, high], number, number + 1, color=_COLORS[state], linewidth=0.0)
            if high > _NAMED_FROM * low and number <= 4:
                axes.annotate(
                    state, (_middle(low, high), _middle(number, number + 1)), ha="center", va="center"
                )
    axes.set_yscale("log")
    axes.set_ylim(1.0, 1.0 + most)
    ticks = [tick for tick in _TICKS if tick <= most]
    axes.set_yticks([_middle(tick, tick + 1) for tick in ticks], [str(tick) for tick in ticks])
    axes.yaxis.set_minor_locator(NullLocator())
    handles = [Patch(color=color, label=_MEANING[state]) for state, color in _COLORS.items()]
    axes.legend(handles=handles, loc="upper right", frameon=False)
    label(axes, ("k₂/k₁, ball-table over ball-ball stiffness", "first, second, ... state", "order of states"))


def _runs(scan: Scan, number: int) -> Iterator[tuple[str, float, float]]:
    """Stretches of ratios over which the state of this number in the order (from 1) is the same."""
    edges = [scan.ratios[0], *(change.ratio for change in scan.changes), scan.ratios[-1]]
    orders = [scan.states[0], *(change.above for change in scan.changes)]
    pieces = zip(orders, edges[:-1], edges[1:], strict=True)
    for state, run in groupby(pieces, key=lambda piece: "".join(piece[0].split()[number - 1 : number])):
        parts = list(run)
        if state:
            yield state, parts[0][1], parts[-1][2]


def _middle(low: float, high: float) -> float:
    return float(np.sqrt(low * high))


def main(out: Path) -> str:
    """Write ``states.svg``, ``states.png`` and ``states.csv``; return the jumps."""
    scan = compute()
    save_both(draw(scan), out, "states")
    write_whole(out / "states.csv", _table(scan))
    return _text(scan)


def _text(scan: Scan) -> str:
    lines = [f"{'jumps at k2/k1':>14} {'v1/|v0|':>9} {'v2/|v0|':>9}  states and events"]
    for jump in scan.jumps:
        first, second = jump.step.round(4) + 0.0  # no minus before nothing
        lines += [
            f"{jump.ratio:14.7g} {first:>+9.4f} {second:>+9.4f}  below: {jump.below}",
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

"""Expected profiles of a plan: a strip a candidate, what lies below the line cannot be excluded."""

import csv
import io
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FormatStrFormatter
from numpy.typing import NDArray

from calibrate.expectation import Expectation
from calibrate.files import write_whole
from calibrate.landscape import Landscape
from calibrate.plan import Plan
from experiments.drawing import DARK, LOWER, QUIET, UPPER, new_figure, save_both

Array = NDArray[np.float64]

_HIGHEST = 2.0  # chi-square over its limit up to which the strips reach
_MARGIN = 3.0  # factor shown beyond the lowest and highest ratio that matters


def draw(view: Landscape, asked: Plan, better: Plan | None) -> Figure:
    """Draw a strip for each candidate: the design asked about, and dashed the one with added trials."""
    rows = len(asked.expectations)
    figure, grid = new_figure(7.2, 0.9 + 0.75 * rows, rows, 1)
    ratio = np.exp(view.log_ratio)
    low = min(pair[0] for each in asked.expectations for pair in each.intervals) / _MARGIN
    high = max(pair[1] for each in asked.expectations for pair in each.intervals) * _MARGIN
    for row, (axes,) in enumerate(grid):
        _draw_strip(axes, ratio, asked.expectations[row], better.expectations[row] if better else None)
        axes.set_xlim(max(low, ratio[0]), min(high, ratio[-1]))
        axes.tick_params(labelbottom=row == rows - 1)
    grid[-1][0].set_xlabel("k₂/k₁, ball-table over ball-ball stiffness")
    figure.supylabel("expected χ² over the largest that is not excluded (95 %)", fontsize=8.5)
    handles, names = grid[0][0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside upper center", ncols=3, frameon=False, fontsize=8)
    return figure


def main(out: Path, view: Landscape, asked: Plan, better: Plan | None) -> None:
    """Write ``plan.svg``, ``plan.png`` and ``plan.csv``."""
    save_both(draw(view, asked, better), out, "plan")
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["plan", "stiffness_ratio", "verdict", "low", "high"])
    for name, plan in (("asked", asked), ("with_added", better)):
        for each in plan.expectations if plan else ():
            for low, high in each.intervals:
                writer.writerow([name, f"{each.truth:g}", each.verdict, f"{low:.4g}", f"{high:.4g}"])
    write_whole(out / "plan.csv", text.getvalue())


def _draw_strip(axes: Axes, ratio: Array, asked: Expectation, better: Expectation | None) -> None:
    height = np.minimum(asked.chi_square / asked.limit, 2 * _HIGHEST)
    axes.fill_between(
        ratio, 0.0, 1.0, where=height <= 1.0, step="mid", color=UPPER, alpha=0.3, label="not excluded"
    )
    axes.plot(ratio, height, color=DARK, linewidth=1.0, label="as asked")
    if better:
        added = np.minimum(better.chi_square / better.limit, 2 * _HIGHEST)
        axes.plot(ratio, added, "--", color=LOWER, linewidth=1.0, label="with the added trials")
    axes.axhline(1.0, color=QUIET, linewidth=0.7)
    axes.axvline(asked.truth, color=QUIET, linewidth=0.7, linestyle=":")
    axes.set_xscale("log")
    axes.set_ylim(0.0, _HIGHEST)
    axes.set_yticks([0, 1, 2])
    axes.xaxis.set_major_formatter(FormatStrFormatter("%g"))
    axes.text(1.01, 0.5, f"truth\n{asked.truth:g}", transform=axes.transAxes, fontsize=8.5, va="center")

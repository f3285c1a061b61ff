"""Restitution over approach speed, a panel a ball: readings, and the line or constant that describes them."""

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from calibrate.files import write_whole
from calibrate.speed import SpeedLaw
from experiments.drawing import LOWER, UPPER, label, new_figure, save_both
from experiments.rebounds import HEIGHTS, INTERVALS, UNTOLD, BallResult

_STYLES = {HEIGHTS: (UPPER, "o", "-"), INTERVALS: (LOWER, "s", "--")}


def draw(found: Sequence[BallResult]) -> Figure:
    """Draw one panel a ball."""
    figure, grid = new_figure(0.8 + 3.7 * len(found), 3.6, 1, len(found))
    for axes, result in zip(grid[0], found, strict=True):
        _draw_ball(axes, result)
    return figure


def main(out: Path, found: Sequence[BallResult]) -> None:
    """Write ``restitution.svg``, ``.png``, ``.csv`` (points) and ``.json`` (lines)."""
    save_both(draw(found), out, "restitution")
    tables = [result.points.assign(ball=result.ball).to_csv(index=False) for result in found]
    header = tables[0].split("\n", 1)[0] + "\n"
    write_whole(out / "restitution.csv", header + "".join(table.split("\n", 1)[1] for table in tables))
    laws = {
        result.ball: {"in_air": result.in_air, **{name: asdict(law) for name, law in result.laws.items()}}
        for result in found
    }
    write_whole(out / "restitution.json", json.dumps(laws, indent=1, ensure_ascii=False) + "\n")


def _draw_ball(axes: Axes, result: BallResult) -> None:
    for method, rows in result.points.groupby("method", sort=False):
        color, marker, _ = _STYLES[str(method)]
        axes.errorbar(
            rows["speed"],
            rows["restitution"],
            yerr=rows["restitution_sd"],
            fmt=marker,
            color=color,
            markersize=4.0,
            elinewidth=0.8,
            alpha=0.75,
            label=str(method),
        )
    for method, law in result.laws.items():
        _draw_law(axes, method, law)
    air = "air allowed for" if result.in_air else "no air"
    label(axes, ("approach speed [m/s]", "restitution e", f"{result.ball.replace('_', ' ')}, {air}"))
    if result.points.empty:
        axes.text(0.5, 0.5, UNTOLD.replace(": ", ":\n"), ha="center", transform=axes.transAxes, fontsize=8)
    else:
        axes.legend(frameon=False, fontsize=7.5)


def _draw_law(axes: Axes, method: str, law: SpeedLaw) -> None:
    color, _, dashes = _STYLES[method]
    speed = np.linspace(*law.speeds, 50)
    value, sd = np.array([law.at(each) for each in speed]).T
    axes.plot(speed, value, dashes, color=color, linewidth=1.5)
    axes.fill_between(speed, value - 2 * sd, value + 2 * sd, color=color, alpha=0.13, linewidth=0.0)

"""Contours of chi-square over stiffness ratio and ball-ball restitution."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FormatStrFormatter, MaxNLocator, NullLocator
from scipy import stats

from calibrate.contours import Contours
from calibrate.estimate import Calibration
from experiments.drawing import DARK, LOWER, UPPER, label, new_figure, save_both

_LEVELS = (0.68, 0.95)


def draw(surface: Contours, calibration: Calibration) -> Figure:
    """Draw the joint 68 % and 95 % regions, and the ends of the local fits."""
    figure, ((axes,),) = new_figure(6.8, 4.2)
    smallest = min(float(surface.chi_square.min()), calibration.chi_square)
    rise = surface.chi_square - smallest
    heights = [float(stats.chi2.ppf(level, 2)) for level in _LEVELS]
    grid = (surface.stiffness_ratio, surface.ball_ball)
    axes.contourf(*grid, rise, levels=[-1.0, *heights], colors=[UPPER, UPPER], alpha=0.3)
    axes.contourf(*grid, rise, levels=[-1.0, heights[0]], colors=[UPPER], alpha=0.3)
    axes.contour(*grid, rise, levels=heights, colors=[UPPER], linewidths=(1.4, 0.8))
    for number, valley in enumerate(calibration.valleys):
        if grid[0][0] <= valley.stiffness_ratio <= grid[0][-1]:
            axes.plot(
                valley.stiffness_ratio,
                valley.restitutions[0],
                "+" if number else "*",
                color=DARK if number else LOWER,
                markersize=6 if number else 10,
                label=("best fit", "ends of other local fits")[min(number, 1)] if number < 2 else None,
            )
    axes.set_xscale("log")
    if grid[0][-1] / grid[0][0] < 30:
        axes.xaxis.set_major_locator(MaxNLocator(8))
        axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter(FormatStrFormatter("%g"))
    title = "joint regions, 68 % (dark) and 95 %: χ² 2.3 and 6.0 above its minimum"
    label(axes, ("k₂/k₁, ball-table over ball-ball stiffness", "ball-ball restitution e₁", title))
    axes.set_xlim(grid[0][0], grid[0][-1])
    axes.set_ylim(np.min(grid[1]), np.max(grid[1]))
    axes.legend(frameon=False, fontsize=8)
    return figure


def main(out: Path, surface: Contours, calibration: Calibration) -> None:
    """Write ``contours.svg`` and ``contours.png``."""
    save_both(draw(surface, calibration), out, "contours")

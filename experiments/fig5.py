"""Fig. 5: rebound velocities over approach speed, model against trials."""

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from calibrate.estimate import Calibration, MassPair
from calibrate.files import write_whole
from calibrate.intervals import Interval
from calibrate.model import rebound_ratios
from calibrate.observed import mass_ratio_groups, usable_two_ball_trials
from experiments import paper
from experiments.comparison import Compared, comparison_text
from experiments.drawing import LOWER, QUIET, UPPER, label, new_figure, save_both

Array = NDArray[np.float64]

_VELOCITIES = ("upper_rebound_velocity", "lower_rebound_velocity")
_MOST_COLUMNS = 3


@dataclass(frozen=True, slots=True, kw_only=True)
class Line:
    """A rebound velocity that is a multiple of the approach speed: its slope, and the slopes of its band."""

    slope: float
    band: Interval | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Panel:
    """One mass pair.

    Attributes
    ----------
    mass_ratio : float
        Upper over lower.
    speeds : ndarray (2,)
        Ends of the approach speeds shown, m/s.
    fitted : tuple of Line
        Upper and lower ball by the fit; empty where there is no fit.
    printed : tuple of Line
        The same by the paper's parameters.
    dots : ndarray (N, 6)
        Approach speed, v1, v2 of each trial, and their standard deviations (NaN where unknown), m/s.
    """

    mass_ratio: float
    speeds: Array
    fitted: tuple[Line, ...]
    printed: tuple[Line, ...]
    dots: Array


def compute(trials: pd.DataFrame | None = None, calibration: Calibration | None = None) -> list[Panel]:
    """Collect what the figure shows: the paper's own lines, or with trials a panel for each mass pair.

    Parameters
    ----------
    trials : pandas.DataFrame, optional
        As `read_trials` returns it.
    calibration : Calibration, optional
        The fit to these trials.

    Returns
    -------
    list of Panel
        In order of the mass ratio.

    Examples
    --------
    >>> [round(line.slope, 4) for line in compute()[0].printed]
    [0.7794, 0.1866]
    """
    if trials is None or calibration is None:
        speeds = -np.array(paper.APPROACH_VELOCITIES)
        return [Panel(mass_ratio=1.0, speeds=speeds, fitted=(), printed=_printed(1.0), dots=np.empty((0, 6)))]
    rows = usable_two_ball_trials(trials)
    groups = mass_ratio_groups(rows)
    return [_panel(rows[groups == number], pair) for number, pair in enumerate(calibration.pairs)]


def _panel(rows: pd.DataFrame, pair: MassPair) -> Panel:
    dots = rows[["approach_velocity", *_VELOCITIES]].to_numpy() * [-1, 1, 1]
    deviations = rows[[f"{column}_sd" for column in ("approach_velocity", *_VELOCITIES)]].to_numpy()
    return Panel(
        mass_ratio=pair.mass_ratio,
        speeds=np.array([0.94, 1.06]) * [dots[:, 0].min(), dots[:, 0].max()],
        fitted=tuple(
            Line(slope=slope, band=band) for slope, band in zip(pair.fitted, pair.fitted_95, strict=True)
        ),
        printed=_printed(pair.mass_ratio),
        dots=np.concatenate([dots, deviations], axis=1),
    )


def _printed(mass_ratio: float) -> tuple[Line, ...]:
    restitutions = [[paper.BALL_BALL.mean, paper.BALL_TABLE.mean]]
    slopes = rebound_ratios([paper.STIFFNESS_RATIO], restitutions, [mass_ratio])[0]
    return tuple(Line(slope=float(slope)) for slope in slopes)


def draw(panels: Sequence[Panel]) -> Figure:
    """Draw one panel a mass pair, all with the same scales; under a fit its residuals."""
    columns = min(len(panels), _MOST_COLUMNS)
    rows = -(-len(panels) // columns)
    parts = 2 if panels[0].fitted else 1
    height, shares = (4.3, (1.0,)) if parts == 1 else (5.5, (3.0, 1.0))
    figure, grid = new_figure(1.6 + 3.9 * columns, height * rows, parts * rows, columns, shares=shares * rows)
    places = [axes for row in grid[::parts] for axes in row]
    below = [axes for row in grid[1::2] for axes in row] if parts == 2 else []
    for axes in (*places[len(panels) :], *below[len(panels) :]):
        axes.set_axis_off()
    highest = max(_highest(panel) for panel in panels)
    slowest, fastest = min(panel.speeds[0] for panel in panels), max(panel.speeds[1] for panel in panels)
    for axes, panel in zip(places, panels, strict=False):
        _draw_panel(axes, panel)
        axes.set_ylim(0.0, 1.08 * highest)
        axes.set_xlim(slowest, fastest)
    farthest = max((_farthest_residual(panel) for panel in panels), default=0.0)
    for axes, panel in zip(below, panels, strict=False):
        _draw_residuals(axes, panel)
        axes.set_ylim(-1.1 * farthest, 1.1 * farthest)
        axes.set_xlim(slowest, fastest)
    handles, names = places[0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=3, frameon=False, fontsize=8)
    return figure


def _residuals(panel: Panel, ball: int) -> Array:
    """Measured less fitted velocity ratio of each trial, in percent of the approach speed."""
    speed = panel.dots[:, 0]
    return np.asarray(100 * (panel.dots[:, 1 + ball] / speed - panel.fitted[ball].slope))


def _farthest_residual(panel: Panel) -> float:
    if not panel.fitted or not len(panel.dots):
        return 0.1
    return float(max(0.1, *((np.abs(_residuals(panel, i)) + _residual_sd(panel, i)).max() for i in range(2))))


def _residual_sd(panel: Panel, ball: int) -> Array:
    """Give the standard deviation of each measured ratio; zero where the table states none."""
    return np.asarray(np.nan_to_num(100 * panel.dots[:, 4 + ball] / panel.dots[:, 0]))


def _draw_residuals(axes: Axes, panel: Panel) -> None:
    axes.axhline(0.0, color=QUIET, linewidth=0.8)
    for ball, (color, marker) in enumerate(((UPPER, "o"), (LOWER, "s"))):
        speed, residuals = panel.dots[:, 0], _residuals(panel, ball)
        axes.errorbar(
            speed,
            residuals,
            yerr=_residual_sd(panel, ball),
            fmt=marker,
            color=color,
            markersize=3.5,
            elinewidth=0.8,
        )
    label(axes, ("approach speed |v₀| [m/s]", "measured - fit\n[% of |v₀|]", ""))


def _draw_panel(axes: Axes, panel: Panel) -> None:
    for ball, color in enumerate((UPPER, LOWER)):
        name = ("v₁, upper ball", "v₂, lower ball")[ball]
        printed = panel.printed[ball].slope * panel.speeds
        if panel.fitted:
            _draw_fit(axes, panel, ball)
            axes.plot(panel.speeds, printed, "--", color=color, linewidth=1.0, label=f"{name}: paper's model")
        else:
            axes.plot(panel.speeds, printed, color=color, linewidth=1.8, label=f"{name}: paper's model")
    across = "" if panel.fitted else "approach speed |v₀| [m/s]"
    label(axes, (across, "rebound velocity [m/s]", f"m₁/m₂ = {panel.mass_ratio:.3g}"))


def _draw_fit(axes: Axes, panel: Panel, ball: int) -> None:
    color, marker = ((UPPER, "o"), (LOWER, "s"))[ball]
    name, line = ("v₁", "v₂")[ball], panel.fitted[ball]
    axes.errorbar(
        panel.dots[:, 0],
        panel.dots[:, 1 + ball],
        xerr=panel.dots[:, 3],
        yerr=panel.dots[:, 4 + ball],
        fmt=marker,
        color=color,
        markersize=4.5,
        markeredgecolor="white",
        markeredgewidth=0.5,
        elinewidth=1.0,
        label=f"{name}, trials",
    )
    axes.plot(
        panel.speeds, line.slope * panel.speeds, color=color, linewidth=1.5, label=f"{name}, fit, 95 % band"
    )
    if line.band:
        low, high = (end * panel.speeds for end in line.band)
        axes.fill_between(panel.speeds, low, high, color=color, alpha=0.2, linewidth=0.0)


def _highest(panel: Panel) -> float:
    lines = [line.slope * panel.speeds.max() for line in (*panel.fitted, *panel.printed)]
    return float(max([*lines, *panel.dots[:, 1]]))


def compare(panels: Sequence[Panel]) -> list[Compared]:
    """Set the slopes for equal masses by the paper's parameters beside the lines of its figure."""
    slopes = next((panel.printed for panel in panels if abs(panel.mass_ratio - 1) < 0.005), _printed(1.0))
    return [
        Compared(quantity=f"{name}/|v0| (reference)", ours=line.slope, printed=reference)
        for name, line, reference in zip(("v1", "v2"), slopes, paper.FIG5_REFERENCE_SLOPES, strict=True)
    ]


def main(out: Path, trials: pd.DataFrame | None = None, calibration: Calibration | None = None) -> str:
    """Write ``fig5.svg``, ``fig5.png`` and ``fig5.csv``; return the comparison with the paper."""
    panels = compute(trials, calibration)
    save_both(draw(panels), out, "fig5")
    write_whole(out / "fig5.csv", _table(panels))
    return comparison_text("Fig. 5", compare(panels))


def _table(panels: Sequence[Panel]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(
        ["mass_ratio", "what", "approach_speed", "v1", "v2", "approach_speed_sd", "v1_sd", "v2_sd"]
    )
    for panel in panels:
        for what, lines in (("fit", panel.fitted), ("paper", panel.printed)):
            for speed in panel.speeds if lines else ():
                velocities = [f"{line.slope * speed:.6g}" for line in lines]
                writer.writerow([f"{panel.mass_ratio:.6g}", what, f"{speed:.6g}", *velocities, "", "", ""])
        for dot in panel.dots:
            numbers = ["" if np.isnan(value) else f"{value:.6g}" for value in dot]
            writer.writerow([f"{panel.mass_ratio:.6g}", "trial", *numbers])
    return text.getvalue()

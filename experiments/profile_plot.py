"""Chi-square over the stiffness ratio: what the data say, and what they leave open."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FormatStrFormatter, MaxNLocator, NullLocator
from numpy.typing import NDArray

from calibrate.estimate import Calibration, Estimate
from calibrate.intervals import Interval
from calibrate.profile import RATIO_LIMITS
from calibrate.report import interval_text, rounded
from experiments.drawing import DARK, QUIET, UPPER, label, new_figure, save_both

Array = NDArray[np.float64]

_MOST_INTERVALS = 4  # named in the title
_HIGHEST = 14.0  # rise of chi-square up to which the plot reaches: what lies above is excluded anyway


@dataclass(frozen=True, slots=True, kw_only=True)
class ProfilePlot:
    """What the plot shows.

    Attributes
    ----------
    stiffness_ratio, rise : ndarray (G,)
        Chi-square above its minimum.
    limits : tuple of (name, rise)
        Largest rise not excluded at each confidence level.
    intervals_68, intervals_95 : tuple of (low, high)
        Confidence sets.
    title : str
        The verdict.
    """

    stiffness_ratio: Array
    rise: Array
    limits: tuple[tuple[str, float], ...]
    intervals_68: tuple[Interval, ...]
    intervals_95: tuple[Interval, ...]
    title: str


def compute(calibration: Calibration) -> ProfilePlot:
    """Collect what the plot shows.

    Raises
    ------
    ValueError
        If the calibration has no profile because there were no two-ball trials.
    """
    if not calibration.profile.chi_square:
        raise ValueError("there is no profile to plot: the table holds no two-ball trial")
    chi_square = np.array(calibration.profile.chi_square)
    estimate = calibration.stiffness_ratio
    return ProfilePlot(
        stiffness_ratio=np.array(calibration.profile.stiffness_ratio),
        rise=chi_square - chi_square.min(),
        limits=(
            ("68 %", calibration.profile.limit_68 - chi_square.min()),
            ("95 %", calibration.profile.limit_95 - chi_square.min()),
        ),
        intervals_68=estimate.intervals_68,
        intervals_95=estimate.intervals_95,
        title=_title(estimate),
    )


def draw(plot: ProfilePlot) -> Figure:
    """Draw the whole range, and below it the part that matters."""
    figure, axes = new_figure(7.0, 6.4, 2, 1)
    (whole,), (near,) = axes
    for part in (whole, near):
        _draw_profile(part, plot)
    whole.set_xlim(*RATIO_LIMITS)
    near.set_xlim(plot.intervals_95[0][0] / 1.35, plot.intervals_95[-1][1] * 1.35)
    label(whole, ("", "χ² above its minimum", plot.title))
    label(near, ("k₂/k₁, ball-table over ball-ball stiffness", "χ² above its minimum", ""))
    caption = "shaded: the 68 % and 95 % sets, everything below the dashed lines"
    near.text(0.01, 1.02, caption, transform=near.transAxes, fontsize=7.5, color=QUIET)
    _mark_plainly(near)
    return figure


def main(out: Path, calibration: Calibration) -> None:
    """Write ``profile.svg`` and ``profile.png``."""
    save_both(draw(compute(calibration)), out, "profile")


def _draw_profile(axes: Axes, plot: ProfilePlot) -> None:
    _shade(axes, plot.intervals_95, 0.14)
    _shade(axes, plot.intervals_68, 0.22)
    for name, rise in plot.limits:
        axes.axhline(rise, color=QUIET, linewidth=0.8, linestyle="--")
        axes.text(
            1.005, rise, name, transform=axes.get_yaxis_transform(), fontsize=8, va="center", color=QUIET
        )
    axes.plot(plot.stiffness_ratio, np.minimum(plot.rise, 2 * _HIGHEST), color=DARK, linewidth=1.2)
    axes.set_xscale("log")
    axes.set_ylim(0.0, _HIGHEST)


def _shade(axes: Axes, intervals: Sequence[Interval], alpha: float) -> None:
    for low, high in intervals:
        axes.axvspan(low, high, color=UPPER, alpha=alpha, linewidth=0.0)


def _mark_plainly(axes: Axes) -> None:
    """Label a log axis with plain numbers where it spans too little for powers of ten."""
    low, high = axes.get_xlim()
    if high / low < 30:
        axes.xaxis.set_major_locator(MaxNLocator(8))
        axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter(FormatStrFormatter("%g"))


def _title(estimate: Estimate) -> str:
    shown = estimate.intervals_95[:_MOST_INTERVALS]
    reach = " or ".join(interval_text(interval) for interval in shown)
    more = len(estimate.intervals_95) - len(shown)
    value = f" = {rounded(estimate.value, estimate.sd)}" if estimate.value and estimate.sd else ""
    others = f" or {more} more" if more else ""
    return f"{estimate.verdict}: stiffness ratio k₂/k₁{value}\n95 %: {reach}{others}"

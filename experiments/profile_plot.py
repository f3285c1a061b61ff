"""Chi-square over the stiffness ratio: what the data say, and what they leave open."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FormatStrFormatter, MaxNLocator, NullLocator
from numpy.typing import NDArray

from calibrate.estimate import Calibration, Estimate, Valley
from calibrate.intervals import Interval
from calibrate.profile import RATIO_LIMITS
from calibrate.report import interval_text, rounded
from experiments.drawing import DARK, QUIET, SEGMENTS, UPPER, label, new_figure, save_both

Array = NDArray[np.float64]

_MOST_INTERVALS = 4  # named in the title
_HIGHEST = 14.0  # rise of chi-square up to which it is drawn closely: what lies above is excluded anyway


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
    states : tuple of str
        Sequence of states at each ratio; empty if not kept.
    valleys : tuple of Valley
        Local fits, best first.
    """

    stiffness_ratio: Array
    rise: Array
    limits: tuple[tuple[str, float], ...]
    intervals_68: tuple[Interval, ...]
    intervals_95: tuple[Interval, ...]
    title: str
    states: tuple[str, ...] = ()
    valleys: tuple[Valley, ...] = ()


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
        title=_title(estimate) + calibration.caveat.replace(", but", "\nbut"),
        states=calibration.profile.states,
        valleys=calibration.valleys,
    )


def draw(plot: ProfilePlot) -> Figure:
    """Draw the whole range, below it the part that matters, and the states the collision goes through."""
    rows = 3 if plot.states else 2
    figure, axes = new_figure(7.0, 6.0 + 1.3 * (rows - 2), rows, 1, shares=(1.0, 1.0, 0.16)[:rows])
    whole, near = axes[0][0], axes[1][0]
    for part in (whole, near):
        _draw_profile(part, plot)
    whole.set_xlim(*RATIO_LIMITS)
    whole.set_yscale("symlog", linthresh=_HIGHEST, linscale=2.0)
    whole.set_ylim(0.0, 1.3 * max(float(plot.rise.max()), _HIGHEST))
    whole.axhline(_HIGHEST, color=QUIET, linewidth=0.5, linestyle=":")
    whole.yaxis.set_major_locator(FixedLocator([0, 5, 10, 30, 100, 1000, 10000]))
    whole.yaxis.set_major_formatter(FormatStrFormatter("%g"))
    near.set_ylim(0.0, _HIGHEST)
    near.set_xlim(plot.intervals_95[0][0] / 1.35, plot.intervals_95[-1][1] * 1.35)
    label(whole, ("", "χ² above its minimum", plot.title))
    label(near, ("k₂/k₁, ball-table over ball-ball stiffness", "χ² above its minimum", ""))
    caption = "shaded: the 68 % and 95 % sets, everything below the dashed lines"
    near.text(0.01, 1.02, caption, transform=near.transAxes, fontsize=7.5, color=QUIET)
    note = "logarithmic above the dotted line"
    beside = whole.get_yaxis_transform()
    whole.text(0.01, 1.02 * _HIGHEST, note, transform=beside, va="bottom", fontsize=7.5, color=QUIET)
    _mark_plainly(near)
    if plot.states:
        _draw_states(axes[2][0], plot, near.get_xlim())
    return figure


def draw_convergence(valleys: Sequence[Valley]) -> Figure:
    """Draw how each local fit came down, up to the six best."""
    figure, ((axes,),) = new_figure(6.4, 3.6)
    best = min(valley.chi_square for valley in valleys)
    for valley, color in zip(valleys, SEGMENTS, strict=False):
        rise = np.minimum.accumulate(np.array(valley.history or (valley.chi_square,))) - best
        name = f"{valley.stiffness_ratio:.4g}, ends {valley.chi_square - best:.2g} above"
        axes.plot(1 + np.arange(len(rise)), rise, color=color, linewidth=1.3, marker=".", label=name)
    axes.set_yscale("symlog", linthresh=0.1)
    axes.set_ylim(bottom=0.0)
    label(
        axes, ("evaluations of the model", "lowest χ² so far above the best", "Convergence of the local fits")
    )
    axes.legend(title="valley at k₂/k₁", frameon=False, fontsize=7.5, title_fontsize=8)
    return figure


def main(out: Path, calibration: Calibration) -> None:
    """Write ``profile`` and ``convergence``, each as SVG and PNG."""
    plot = compute(calibration)
    save_both(draw(plot), out, "profile")
    if plot.valleys:
        save_both(draw_convergence(plot.valleys), out, "convergence")


def _draw_profile(axes: Axes, plot: ProfilePlot) -> None:
    _shade(axes, plot.intervals_95, 0.14)
    _shade(axes, plot.intervals_68, 0.22)
    for name, rise in plot.limits:
        axes.axhline(rise, color=QUIET, linewidth=0.8, linestyle="--")
        axes.text(
            1.005, rise, name, transform=axes.get_yaxis_transform(), fontsize=8, va="center", color=QUIET
        )
    axes.plot(plot.stiffness_ratio, plot.rise, color=DARK, linewidth=1.2)
    axes.set_xscale("log")


def _draw_states(axes: Axes, plot: ProfilePlot, limits: tuple[float, float]) -> None:
    """Colour the ratios by the sequence of states the best collision there goes through."""
    borders = np.sqrt(plot.stiffness_ratio[1:] * plot.stiffness_ratio[:-1])
    edges = np.concatenate([plot.stiffness_ratio[:1], borders, plot.stiffness_ratio[-1:]])
    shown = (edges[1:] > limits[0]) & (edges[:-1] < limits[1])
    names = list(dict.fromkeys(np.array(plot.states)[shown].tolist()))
    named: set[str] = set()
    for name, run in groupby(np.flatnonzero(shown).tolist(), key=lambda index: plot.states[index]):
        indices = list(run)
        place = names.index(name)
        axes.axvspan(
            edges[indices[0]],
            edges[indices[-1] + 1],
            color=SEGMENTS[place % len(SEGMENTS)],
            hatch=("", "///", "...")[place // len(SEGMENTS) % 3],
            alpha=0.75,
            linewidth=0.0,
            label=None if name in named else name,
        )
        named.add(name)
    axes.set_xscale("log")
    axes.set_xlim(*limits)
    axes.set_yticks([])
    axes.tick_params(labelbottom=False, which="both", bottom=False)
    axes.legend(
        loc="upper center", bbox_to_anchor=(0.5, -0.1), ncols=2, frameon=False, fontsize=7, title="states"
    )


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

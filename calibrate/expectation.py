"""What an experiment would find if one stiffness ratio were the truth: the expected profile.

That is chi-square of noise-free data against every other ratio, with the restitutions refitted there.
Refitting is taken linearly. Noise-free data stay below the limit at more ratios than most noisy ones would,
so that a plan that suffices here seldom disappoints.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibrate.intervals import Interval, joined, verdict
from calibrate.landscape import Landscape
from calibrate.limits import limit
from calibrate.repeats import ASSUMED_SCATTER, Repeats
from calibrate.setup import Setup
from calibrate.simulate import Design

Array = NDArray[np.float64]

_SAME_INTERVAL = 0.03  # gaps narrower than this (relative) are not seen on the landscape's grid
_WIDEST_RATIO = 4.0  # as in a fit


@dataclass(frozen=True, slots=True, kw_only=True)
class Expectation:
    """What an experiment would find if one ratio were the truth.

    Attributes
    ----------
    truth : float
        The stiffness ratio.
    chi_square : ndarray (G,)
        Expected profile over the landscape's ratios.
    limit : float
        Largest chi-square not excluded with 95 % confidence.
    intervals : tuple of (low, high)
        The expected 95 % set.
    verdict : str
        As for a fit.
    """

    truth: float
    chi_square: Array
    limit: float
    intervals: tuple[Interval, ...]
    verdict: str

    @property
    def confusions(self) -> tuple[Interval, ...]:
        """Intervals of the expected set that do not hold the truth."""
        return tuple(pair for pair in self.intervals if not pair[0] <= self.truth <= pair[1])


def expectation(view: Landscape, setup: Setup, design: Design, truth: float) -> Expectation:
    """Tell what a design would find if `truth` were the ratio; arguments as for `calibrate.plan.expected`."""
    there = int(np.argmin(np.abs(view.log_ratio - np.log(truth))))
    used = [view.mass_ratios.index(ratio) for ratio, count in design.two.items() if count]
    rebounds = _rebounds(view.rebounds[there, used], setup, [count for count in design.two.values() if count])
    drops = [
        _drops(restitution, setup, count)
        for restitution, count in zip(view.restitutions, (design.held, design.plate), strict=True)
    ]
    chi_square = linear_profile(view, used, rebounds, drops)
    freedom = rebounds.means.size + sum(each is not None for each in drops) - 3
    highest = limit(float(chi_square.min()), freedom, 0.95)
    intervals = _intervals(view.log_ratio, chi_square <= highest)
    edges = (float(view.log_ratio[0]), float(view.log_ratio[-1]))
    return Expectation(
        truth=truth,
        chi_square=chi_square,
        limit=highest,
        intervals=tuple((float(np.exp(low)), float(np.exp(high))) for low, high in intervals),
        verdict=verdict(intervals, edges, float(np.log(_WIDEST_RATIO))),
    )


def linear_profile(
    view: Landscape, used: Sequence[int], rebounds: Repeats, drops: Sequence[Repeats | None]
) -> Array:
    """Chi-square at each ratio (G,), after one Gauss-Newton step over the restitutions.

    Parameters
    ----------
    view : Landscape
        The model around plausible restitutions.
    used : sequence of int
        Mass pairs measured, as columns of the landscape.
    rebounds : Repeats
        Of these pairs.
    drops : (Repeats or None, Repeats or None)
        Ball-ball and ball-table restitution from their own drops.
    """
    off = rebounds.whitened(view.rebounds[:, used] - rebounds.means)
    slopes = np.moveaxis(rebounds.whitened(np.moveaxis(view.slopes[:, used], 3, 0)), 0, 3)
    known = [0.0 if each is None else 1 / each.mean_sd() ** 2 for each in drops]
    apart = [
        0.0 if each is None else at - float(each.means[0, 0])
        for at, each in zip(view.restitutions, drops, strict=True)
    ]
    normal = np.einsum("gpik,gpil->gkl", slopes, slopes) + np.diag(known)
    ridge = 1e-9 * (1.0 + np.trace(normal, axis1=1, axis2=2))  # slopes across a jump are huge
    normal += ridge[:, None, None] * np.eye(2)
    uphill = np.einsum("gpik,gpi->gk", slopes, off) + np.multiply(known, apart)
    step = -np.linalg.solve(normal, uphill[..., None])[..., 0]
    step = np.clip(step, -np.array(view.restitutions), 1 - np.array(view.restitutions))
    refitted = view.rebounds[:, used] + np.einsum("gpik,gk->gpi", view.slopes[:, used], step)
    total = np.sum(rebounds.distances(refitted) ** 2, axis=-1)
    for column, each in enumerate(drops):
        if each is not None:
            at = (view.restitutions[column] + step[:, column])[:, None, None]
            total = total + np.sum(each.distances(at) ** 2, axis=-1)
    return np.asarray(total)


def _rebounds(means: Array, setup: Setup, counts: Sequence[int]) -> Repeats:
    """Repeats as these trials would show them."""
    weights = np.array(counts, dtype=float)
    scatter = np.array([setup.rebound_scatter(pair) for pair in means])
    freedom = float(weights.sum() - len(weights))
    if freedom < means.shape[1]:
        scatter, freedom = np.hypot(scatter, ASSUMED_SCATTER * means), np.inf
    return Repeats(
        means=means,
        weights=weights,
        spread=np.eye(means.shape[1]),
        degrees_of_freedom=freedom,
        scale=scatter,
    )


def _drops(restitution: float, setup: Setup, count: int) -> Repeats | None:
    if not count:
        return None
    variance, freedom = setup.restitution_scatter(restitution) ** 2, float(count - 1)
    if count == 1:
        variance, freedom = variance + (ASSUMED_SCATTER * restitution) ** 2, np.inf
    return Repeats(
        means=np.array([[restitution]]),
        weights=np.array([float(count)]),
        spread=np.array([[variance]]),
        degrees_of_freedom=freedom,
    )


def _intervals(log_ratio: Array, inside: NDArray[np.bool_]) -> tuple[Interval, ...]:
    """Unite the points inside; each stands for the ratios half way to its neighbours."""
    borders = np.concatenate([log_ratio[:1], (log_ratio[1:] + log_ratio[:-1]) / 2, log_ratio[-1:]])
    walled = np.concatenate([[False], inside, [False]])
    starts, ends = borders[:-1][inside & ~walled[:-2]], borders[1:][inside & ~walled[2:]]
    return joined(list(zip(starts.tolist(), ends.tolist(), strict=True)), _SAME_INTERVAL)

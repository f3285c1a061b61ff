"""The profile likelihood over the stiffness ratio: chi-square with the restitutions refitted at every ratio.

One least-squares call will not do: chi-square has many local minima over the ratio and jumps where the order
of events changes. So every ratio of a grid gets its own search over the restitutions, every basin is refined,
and the confidence set is whatever lies below the limit (see `calibrate.limits`): a union of intervals.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibrate.basins import Basin, refined_basins
from calibrate.descent import Trace, descend, jacobian, over_the_edge, promising, search, search_from_each
from calibrate.intervals import Interval, joined
from calibrate.limits import limit
from calibrate.misfit import Misfit

Array = NDArray[np.float64]

LEVELS = (0.68, 0.95)
RATIO_LIMITS = (1e-3, 1e3)
_GRID_POINTS = 200
_MOST_ROUNDS = 10
_CLIFF = 5.0  # difference of chi-square between neighbours which may be no slope
_WORTHWHILE = 0.02  # improvement of chi-square for which a search is repeated
_ELSEWHERE = 2e-3  # restitutions farther apart than this belong to different searches
_WORTH_A_LOOK = 12.0  # how far above the smallest chi-square the profile is still followed closely
_FINEST_SPACING = 0.02  # of the profile as a curve, in the logarithm
_STEEP = 2.0  # change of chi-square from point to point above which that is not fine enough
_EDGE_PRECISION = 5e-4  # of an interval's edge, relative
_SAME_INTERVAL = 0.02  # intervals closer than this (relative) are one: no experiment tells them apart


@dataclass(frozen=True, slots=True, kw_only=True)
class Profile:
    """Chi-square over the stiffness ratio.

    Attributes
    ----------
    trace : Trace
        Best restitutions and chi-square at each ratio, closely spaced where chi-square is small.
    basins : tuple of Basin
        Local minima, best first.
    degrees_of_freedom : int
        Of the best fit.
    """

    trace: Trace
    basins: tuple[Basin, ...]
    degrees_of_freedom: int

    def intervals(self, level: float) -> tuple[Interval, ...]:
        """Stiffness ratios not excluded at a confidence level, as a union of intervals."""
        inside, log_ratio = self.inside(level), self.trace.log_ratio
        walled = np.concatenate([[False], inside, [False]])
        before = np.concatenate([log_ratio[:1], log_ratio[:-1]])  # the nearest excluded on each side, or
        after = np.concatenate([log_ratio[1:], log_ratio[-1:]])  # precise data would lose half their set
        starts, ends = before[inside & ~walled[:-2]].tolist(), after[inside & ~walled[2:]].tolist()
        logs = joined(list(zip(starts, ends, strict=True)), _SAME_INTERVAL)
        return tuple((float(np.exp(low)), float(np.exp(high))) for low, high in logs)

    def inside(self, level: float) -> NDArray[np.bool_]:
        """Tell which points of the trace a confidence level does not exclude, (G,)."""
        return np.asarray(self.trace.chi_square <= self.limit(level))

    def limit(self, level: float) -> float:
        """Largest chi-square a confidence level does not exclude."""
        return limit(float(self.trace.chi_square.min()), self.degrees_of_freedom, level)


def trace_profile(misfit: Misfit) -> Profile:
    """Compute the profile from 1e-3 to 1e3, finer where it matters.

    Parameters
    ----------
    misfit : Misfit
        Everything measured.

    Returns
    -------
    Profile
        With the edges of its 68 % and 95 % sets located to five parts in ten thousand, outwards.
    """
    trace = _spread(misfit, search(misfit, starting_grid()))
    while (hopeful := _wide(misfit, trace)).any():
        trace = _finer(misfit, trace, hopeful)
    for _ in range(_MOST_ROUNDS // 2):
        trace = _finer(misfit, trace, _beside_minima(misfit, trace))
    trace = _spread(misfit, trace)
    for _ in range(_MOST_ROUNDS // 2):
        trace = _finer(misfit, trace, _coarse(trace))
    trace = _spread(misfit, trace)
    basins = refined_basins(misfit, trace, _WORTH_A_LOOK)
    trace = trace.merged(_as_trace(basins))
    for level in LEVELS:
        trace = _with_edges(misfit, trace, level)
    return Profile(trace=trace, basins=tuple(basins), degrees_of_freedom=misfit.degrees_of_freedom)


def propagate(
    misfit: Misfit, profile: Profile, level: float, quantity: Callable[[Array, Array], Array]
) -> tuple[Array, Array]:
    """Confidence intervals of anything computed from the parameters.

    At each ratio inside the set the restitutions may still stray as far as the rest of the threshold allows;
    how far that moves the quantity is taken linearly.

    Parameters
    ----------
    misfit, profile
        The fit.
    level : float
        Of confidence.
    quantity : callable
        Maps log ratios (N,) and restitutions (N, 2) to values (N, Q).

    Returns
    -------
    low, high : ndarray (N, Q)
        One interval for each point of the trace inside the set; their union is the confidence set.
    """
    inside = profile.inside(level)
    log_ratio, at = profile.trace.log_ratio[inside], profile.trace.restitutions[inside]
    room = profile.limit(level) - profile.trace.chi_square[inside]
    slopes = jacobian(misfit, log_ratio, at, misfit.residuals(log_ratio, at))
    covariance = np.linalg.inv(np.swapaxes(slopes, 1, 2) @ slopes + 1e-9 * np.eye(2))
    value = quantity(log_ratio, at)
    gradient = _gradient(quantity, log_ratio, at, value)
    reach = np.sqrt(np.einsum("nqi,nij,nqj->nq", gradient, covariance, gradient) * room[:, None])
    return value - reach, value + reach


def _gradient(quantity: Callable[[Array, Array], Array], log_ratio: Array, at: Array, value: Array) -> Array:
    columns = []
    for column in range(2):
        moved = at.copy()
        moved[:, column] += np.where(at[:, column] > 0.5, -1e-5, 1e-5)
        columns.append((quantity(log_ratio, moved) - value) / (moved - at)[:, [column]])
    return np.stack(columns, axis=2)


def starting_grid() -> Array:
    """Log ratios spaced evenly, and again evenly in the root and the inverse root of the ratio.

    The number of vibrations the lower ball makes during the collision, and with it the number of basins,
    grows with the root of the ratio (with the inverse root when the ball-ball contact is the stiffer one).
    """
    low, high = np.log(RATIO_LIMITS)
    even_in_root = 2 * np.arcsinh(np.linspace(np.sinh(low / 2), np.sinh(high / 2), _GRID_POINTS))
    return np.unique(np.concatenate([np.linspace(low, high, _GRID_POINTS), even_in_root]))


def _spread(misfit: Misfit, trace: Trace) -> Trace:
    """Let ratios try where better neighbours ended, until a basin once found is followed to its end."""
    hopeful = trace.chi_square.min() + misfit.out_of_reach / 2
    for _ in range(_MOST_ROUNDS):
        before = trace.chi_square
        for shift in (1, -1):
            neighbour = np.roll(trace.restitutions, shift, axis=0)
            better = np.roll(trace.chi_square, shift) < np.minimum(trace.chi_square, hopeful)
            elsewhere = np.abs(neighbour - trace.restitutions).max(axis=1) > _ELSEWHERE
            asked = np.flatnonzero(better & elsewhere)
            if asked.size:
                start = neighbour[asked]
                cliff = trace.chi_square[asked] > np.roll(trace.chi_square, shift)[asked] + _CLIFF
                start[cliff] = over_the_edge(misfit, trace.log_ratio[asked[cliff]], start[cliff])
                ceiling = trace.chi_square[asked] - _WORTHWHILE
                trace = trace.improved(asked, descend(misfit, trace.log_ratio[asked], start, ceiling))
        if np.all(trace.chi_square > before - _WORTHWHILE):
            break
    return trace


def _wide(misfit: Misfit, trace: Trace) -> NDArray[np.bool_]:
    """Gaps beside ratios within reach, wide enough to hide a valley: precise data make valleys narrow."""
    lower = np.minimum(trace.chi_square[:-1], trace.chi_square[1:])
    within = lower < trace.chi_square.min() + misfit.out_of_reach
    return np.asarray(within & (np.diff(trace.log_ratio) > _FINEST_SPACING))


def _beside_minima(misfit: Misfit, trace: Trace) -> NDArray[np.bool_]:
    """Gaps on both sides of a local minimum, which may be far deeper than the grid has seen."""
    walled = np.concatenate([[np.inf], trace.chi_square, [np.inf]])
    lowest = (trace.chi_square <= walled[:-2]) & (trace.chi_square <= walled[2:])
    lowest &= trace.chi_square < trace.chi_square.min() + misfit.out_of_reach
    return np.asarray((lowest[:-1] | lowest[1:]) & (np.diff(trace.log_ratio) > _EDGE_PRECISION))


def _coarse(trace: Trace) -> NDArray[np.bool_]:
    """Gaps near the bottom across which chi-square changes too much, or which are too wide, for a curve."""
    near = np.minimum(trace.chi_square[:-1], trace.chi_square[1:]) < trace.chi_square.min() + _WORTH_A_LOOK
    gap = np.diff(trace.log_ratio)
    steep = (np.abs(np.diff(trace.chi_square)) > _STEEP) & (gap > _EDGE_PRECISION)
    return np.asarray(near & (steep | (gap > _FINEST_SPACING)))


def _finer(misfit: Misfit, trace: Trace, gaps: NDArray[np.bool_]) -> Trace:
    """Add the middle of the chosen gaps."""
    left = np.flatnonzero(gaps)
    if not left.size:
        return trace
    middle = (trace.log_ratio[left] + trace.log_ratio[left + 1]) / 2
    starts = [trace.restitutions[left], trace.restitutions[left + 1]]
    if misfit.ball_ball and misfit.ball_table:
        starts.append(promising(misfit, middle))
    return trace.merged(search_from_each(misfit, middle, starts))


def _with_edges(misfit: Misfit, trace: Trace, level: float) -> Trace:
    """Locate by bisection where the profile crosses its limit, and make sure that it does so there."""
    for _ in range(_MOST_ROUNDS):
        while (crossing := _crossing(misfit, trace, level)).any():
            trace = _finer(misfit, trace, crossing)
        before, trace = trace, _spread(misfit, trace)
        if np.all(trace.chi_square > before.chi_square - _WORTHWHILE):
            break
    return trace


def _crossing(misfit: Misfit, trace: Trace, level: float) -> NDArray[np.bool_]:
    """Gaps, wider than the precision wanted, in which the profile crosses its limit."""
    inside = trace.chi_square <= limit(float(trace.chi_square.min()), misfit.degrees_of_freedom, level)
    return np.asarray((inside[1:] != inside[:-1]) & (np.diff(trace.log_ratio) > _EDGE_PRECISION))


def _as_trace(basins: list[Basin]) -> Trace:
    return Trace(
        log_ratio=np.log([basin.stiffness_ratio for basin in basins]),
        restitutions=np.array([basin.restitutions for basin in basins]),
        chi_square=np.array([basin.chi_square for basin in basins]),
    )

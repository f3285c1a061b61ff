"""Least squares over a few bounded parameters, from many starts side by side, and a profile over each."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibrate.intervals import Interval

Array = NDArray[np.float64]

_ROUNDS = 8
_ARRIVED = 0.02  # promised gain of chi-square below which a search has arrived
_STEP = 1e-5  # of a parameter's range, for slopes
_WIDE_POINTS = 9  # of a profile, over the whole range
_NEAR_POINTS = 9  # and around the best value
_NEAR = 5.0  # standard deviations to each side
_STUCK = 1e3  # damping at which a search stands at a jump
_HALVINGS = 3  # of the gaps in which a profile crosses a limit
_NEARBY, _TRIES = 60, 2  # places seen that count as near to a value, and how many of these are tried
_WORTH_A_LOOK = 30.0  # how far above the best fit a profile is still followed


@dataclass(frozen=True, slots=True, kw_only=True)
class Box:
    """What to make small, and where.

    Attributes
    ----------
    low, high : ndarray (P,)
        Bounds of the parameters.
    free : tuple of int
        Columns that may move.
    residuals : callable
        Maps parameters (N, P) to standardized residuals (N, R).
    """

    low: Array
    high: Array
    free: tuple[int, ...]
    residuals: Callable[[Array], Array]

    def chi_square(self, points: Array) -> Array:
        """Sum of squared residuals, (N,)."""
        return np.asarray(np.sum(self.residuals(points) ** 2, axis=1))


@dataclass(frozen=True, slots=True, kw_only=True)
class Curve:
    """Chi-square (G,) over the values (G,) of one parameter, the others refitted; in rising order."""

    value: Array
    chi_square: Array

    def below(self, limit: float) -> tuple[Interval, ...]:
        """Give the intervals in which the curve lies below a limit, ends interpolated."""
        inside = self.chi_square <= limit
        intervals: list[Interval] = []
        for first in np.flatnonzero(inside & ~np.concatenate([[False], inside[:-1]])).tolist():
            last = first + int(np.argmin(np.concatenate([inside[first:], [False]]))) - 1
            intervals.append((self._edge(first, first - 1, limit), self._edge(last, last + 1, limit)))
        return tuple(intervals)

    def _edge(self, inner: int, outer: int, limit: float) -> float:
        """Find where a parabola-like flank crosses the limit: linear in the root of chi-square's rise."""
        if not 0 <= outer < len(self.value):
            return float(self.value[inner])
        base = float(self.chi_square.min())
        roots = np.sqrt(np.maximum(self.chi_square[[inner, outer]] - base, 0.0))
        share = (np.sqrt(max(limit - base, 0.0)) - roots[0]) / max(roots[1] - roots[0], 1e-12)
        return float(self.value[inner] + np.clip(share, 0, 1) * (self.value[outer] - self.value[inner]))


def descend(box: Box, start: Array, held: int | None = None, ceiling: float = np.inf) -> tuple[Array, Array]:
    """Go downhill from each start by damped Gauss-Newton.

    Parameters
    ----------
    box : Box
        What to make small.
    start : ndarray (N, P)
        Within the bounds.
    held : int, optional
        A free column that is to stay where it is.
    ceiling : float
        A search that does not promise to get below this chi-square is given up.

    Returns
    -------
    ends : ndarray (N, P)
        Where each search ended.
    chi_square : ndarray (N,)
        There.
    """
    free = [column for column in box.free if column != held]
    if not len(start):
        return start, np.empty(0)
    at, residuals = start.copy(), box.residuals(start)
    if not free:
        return at, np.asarray(np.sum(residuals**2, axis=1))
    damping, going = np.full(len(at), 1e-3), np.arange(len(at))
    slopes = _slopes(box, at, residuals, free)
    for _ in range(_ROUNDS):
        step, promised = _step(slopes[going], residuals[going], damping[going])
        before = np.sum(residuals[going] ** 2, axis=1)
        worth = (promised > _ARRIVED) & (before - promised < ceiling) & (damping[going] < _STUCK)
        going, step, before = going[worth], step[worth], before[worth]
        if not going.size:
            break
        trial = at[going].copy()
        trial[:, free] = np.clip(trial[:, free] + step, box.low[free], box.high[free])
        after = box.residuals(trial)
        better = np.sum(after**2, axis=1) < before
        moved = going[better]
        at[moved], residuals[moved] = trial[better], after[better]
        if moved.size:
            slopes[moved] = _slopes(box, at[moved], residuals[moved], free)
        damping[going] *= np.where(better, 0.1, 20.0)
    return at, np.asarray(np.sum(residuals**2, axis=1))


def profile(box: Box, column: int, best: Array, seen: Array, limits: Sequence[float]) -> Curve:
    """Refit all other parameters at many values of one.

    Parameters
    ----------
    box : Box
        What to make small.
    column : int
        Of the parameter.
    best : ndarray (P,)
        The best fit.
    seen : ndarray (N, P)
        Other places to start from, best first: the first few near to each value are tried.
    limits : sequence of float
        Rises of chi-square whose places are wanted closely.
    """
    ceiling = float(box.chi_square(best[None])[0]) + _WORTH_A_LOOK
    starts = _beginnings(_values(box, column, best), column, best, seen)
    ends, heights = _best_ends(column, *descend(box, starts, held=column, ceiling=ceiling))
    ends, heights = _shared(box, column, (ends, heights), ceiling)
    for _ in range(_HALVINGS):
        above = heights[:, None] > heights.min() + np.array(limits)
        gaps = np.flatnonzero((above[1:] != above[:-1]).any(axis=1))
        middle = (ends[gaps, column] + ends[gaps + 1, column]) / 2
        beside = np.concatenate([ends[gaps], ends[gaps + 1]])
        beside[:, column] = np.tile(middle, 2)
        starts = np.concatenate([beside, _beginnings(middle, column, best, seen)])
        found, lowest = descend(box, starts, held=column, ceiling=ceiling)
        ends, heights = _best_ends(column, np.concatenate([ends, found]), np.concatenate([heights, lowest]))
    return Curve(value=ends[:, column], chi_square=heights)


def _beginnings(value: Array, column: int, best: Array, seen: Array) -> Array:
    """Places to start from at each value of a column: the best fit, and the first seen of those nearby."""
    apart = np.abs(seen[:, column] - value[:, None])
    nearby = np.sort(np.argsort(apart, axis=1, kind="stable")[:, :_NEARBY], axis=1)[:, :_TRIES]
    starts = np.concatenate([np.tile(best, (len(value), 1)), seen[nearby.T.ravel()]])
    starts[:, column] = np.tile(value, 1 + nearby.shape[1])
    return starts


def _shared(box: Box, column: int, found: tuple[Array, Array], ceiling: float) -> tuple[Array, Array]:
    """Try the end at each value of a column at its neighbours, too."""
    ends, heights = found
    for shift in (1, -1, 1, -1):
        rows = np.flatnonzero(np.roll(heights, shift) < np.minimum(heights, ceiling))
        neighbours = np.roll(ends, shift, axis=0)[rows]
        neighbours[:, column] = ends[rows, column]
        tried, lowest = descend(box, neighbours, held=column, ceiling=ceiling)
        ends, heights = _best_ends(column, np.concatenate([ends, tried]), np.concatenate([heights, lowest]))
    return ends, heights


def _best_ends(column: int, ends: Array, heights: Array) -> tuple[Array, Array]:
    order = np.lexsort((heights, ends[:, column]))
    _, first = np.unique(ends[order, column], return_index=True)
    return ends[order[first]], heights[order[first]]


def _values(box: Box, column: int, best: Array) -> Array:
    """Spread values over the whole range, and closely over a few standard deviations around the best."""
    low, high = float(box.low[column]), float(box.high[column])
    slopes = _slopes(box, best[None], box.residuals(best[None]), list(box.free))[0]
    covariance = np.linalg.pinv(slopes.T @ slopes, hermitian=True)
    place = box.free.index(column)
    reach = min(_NEAR * float(np.sqrt(max(covariance[place, place], 1e-12))), (high - low) / 4)
    near = best[column] + reach * np.linspace(-1, 1, _NEAR_POINTS)
    return np.unique(np.concatenate([np.linspace(low, high, _WIDE_POINTS), np.clip(near, low, high)]))


def _slopes(box: Box, at: Array, residuals: Array, columns: list[int]) -> Array:
    """Differentiate residuals (N, R) by some parameters, (N, R, C), towards the middle of the box."""
    middle, width = (box.high + box.low) / 2, box.high - box.low
    moved = np.repeat(at[None], len(columns), axis=0)
    for index, column in enumerate(columns):
        moved[index, :, column] += np.where(at[:, column] > middle[column], -_STEP, _STEP) * width[column]
    after = box.residuals(moved.reshape(-1, at.shape[1])).reshape(len(columns), *residuals.shape)
    steps = np.stack([moved[index, :, column] - at[:, column] for index, column in enumerate(columns)])
    return np.moveaxis((after - residuals) / steps[..., None], 0, 2)


def _step(slopes: Array, residuals: Array, damping: Array) -> tuple[Array, Array]:
    """Levenberg-Marquardt steps and the gain of chi-square that the undamped ones promise."""
    normal = np.swapaxes(slopes, 1, 2) @ slopes
    scale = np.einsum("nii->ni", normal) + 1e-9
    eye = np.eye(slopes.shape[2])
    downhill = -np.einsum("nri,nr->ni", slopes, residuals)
    damped = normal + (1e-9 + damping[:, None] * scale)[..., None] * eye
    full = np.linalg.solve(normal + 1e-9 * scale[..., None] * eye + 1e-12 * eye, downhill[..., None])[..., 0]
    return (
        np.linalg.solve(damped, downhill[..., None])[..., 0],
        np.einsum("ni,ni->n", downhill, full),
    )

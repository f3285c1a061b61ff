"""Least squares over a few bounded parameters, from many starts side by side, and a profile over each."""

from collections.abc import Callable
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
_STUCK = 1e6  # damping at which a search stands at a jump
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
    at, residuals = start.copy(), box.residuals(start)
    damping, going = np.full(len(at), 1e-3), np.arange(len(at))
    for _ in range(_ROUNDS if free else 0):
        if not going.size:
            break
        slopes = _slopes(box, at[going], residuals[going], free)
        step, promised = _step(slopes, residuals[going], damping[going])
        before = np.sum(residuals[going] ** 2, axis=1)
        worth = (promised > _ARRIVED) & (before - promised < ceiling) & (damping[going] < _STUCK)
        going, step, before = going[worth], step[worth], before[worth]
        trial = at[going].copy()
        trial[:, free] = np.clip(trial[:, free] + step, box.low[free], box.high[free])
        after = box.residuals(trial) if going.size else residuals[going]
        better = np.sum(after**2, axis=1) < before
        at[going[better]], residuals[going[better]] = trial[better], after[better]
        damping[going] *= np.where(better, 0.1, 20.0)
    return at, np.asarray(np.sum(residuals**2, axis=1))


def profile(box: Box, column: int, best: Array, starts: Array) -> Curve:
    """Refit all other parameters at many values of one.

    Parameters
    ----------
    box : Box
        What to make small.
    column : int
        Of the parameter.
    best : ndarray (P,)
        The best fit.
    starts : ndarray (N, P)
        Other places to start from; the one nearest to each value is tried.
    """
    value = _values(box, column, best)
    ceiling = float(box.chi_square(best[None])[0]) + _WORTH_A_LOOK
    nearest = starts[np.argmin(np.abs(starts[None, :, column] - value[:, None]), axis=1)]
    tries = np.concatenate([np.tile(best, (len(value), 1)), nearest])
    tries[:, column] = np.tile(value, 2)
    both, heights = descend(box, tries, held=column, ceiling=ceiling)
    second = heights[len(value) :] < heights[: len(value)]
    ends = np.where(second[:, None], both[len(value) :], both[: len(value)])
    chi_square = np.minimum(heights[: len(value)], heights[len(value) :])
    for shift in (1, -1):
        rows = np.flatnonzero(np.roll(chi_square, shift) < np.minimum(chi_square, ceiling))
        if rows.size:
            neighbours = np.roll(ends, shift, axis=0)[rows]
            neighbours[:, column] = value[rows]
            tried, found = descend(box, neighbours, held=column, ceiling=ceiling)
            lower = found < chi_square[rows]
            ends[rows[lower]], chi_square[rows[lower]] = tried[lower], found[lower]
    return Curve(value=value, chi_square=chi_square)


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

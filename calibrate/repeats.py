"""Repeated measurements of the same numbers: their means, their spread, how far a prediction is from them.

By Theorem 4 neither a restitution nor the two velocity ratios of a mass pair depend on the drop height.
Trials at any heights are therefore repeats of one measurement, and their spread around their own mean tells
without any model how much trials really scatter. What hands do differently from trial to trial moves a fast
ball more than a slow one: so the spread that groups have in common is relative to their `scale`. Few repeats
know their spread badly; `Repeats.distances` allows for that exactly (Wilks' lambda with Rao's F, of which
Student's t is the simplest case).
"""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import stats

from calibrate.shared import softened
from calibrate.small_sample import at_least, equivalent_chi_square

Array = NDArray[np.float64]

ASSUMED_SCATTER = 0.02
"""Relative scatter of a trial where too few repeats show it; two heights read by eye give about that."""
FINEST_SCATTER = 0.001
"""Relative; no speed ratio is believed to repeat better, however well a few trials happen to agree."""

_SLOWEST = 0.02  # speed ratio below which scatter falls no further: cameras see slow balls no better


@dataclass(frozen=True, slots=True, kw_only=True)
class Repeats:
    """Means of J groups of repeated measurements of p numbers, with a relative spread common to all groups.

    Attributes
    ----------
    means : ndarray (J, p)
        Weighted mean of each group.
    weights : ndarray (J,)
        Number of trials in each group, less where some are worth less than the average trial.
    spread : ndarray (p, p)
        Covariance of one average trial, its numbers taken relative to the scale of its group.
    degrees_of_freedom : float
        How many repeats the spread rests on; infinite if it is known or assumed.
    deviations : ndarray (N,)
        Standardized distance of each trial from the mean of its group, in the order of the trials.
    too_alike : bool
        Whether they agreed better than they state (or than `FINEST_SCATTER`), so that the spread was raised.
    shared : ndarray (K, J, p)
        What one standard deviation of each of the K errors common to all trials does to the means.
    scale : ndarray (J, p)
        What the scatter of each number of each group is proportional to.
    """

    means: Array
    weights: Array
    spread: Array
    degrees_of_freedom: float
    deviations: Array = field(default_factory=lambda: np.empty(0))
    too_alike: bool = False
    shared: Array = field(default_factory=lambda: np.empty((0, 1, 1)))
    scale: Array = field(default_factory=lambda: np.ones((1, 1)))

    def distances(self, predicted: ArrayLike) -> Array:
        """Whiten the distance from predictions to the means.

        Parameters
        ----------
        predicted : array_like (..., J, p)
            What a model says the means should be.

        Returns
        -------
        ndarray (..., J p)
            Numbers whose sum of squares follows, for the true model, the chi-square law of J p degrees of
            freedom exactly, however few the repeats (homogeneous normal scatter assumed).
        """
        white = self.whitened(np.asarray(predicted, dtype=float) - self.means)
        flat = white.reshape(*white.shape[:-2], self.means.size)
        if self.shared.size:
            common = self.whitened(self.shared)
            flat = softened(flat, common.reshape(len(common), self.means.size))
            white = flat.reshape(white.shape)
        if not np.isfinite(self.degrees_of_freedom):
            return flat
        plain = np.sum(flat**2, axis=-1)
        scale = np.sqrt(equivalent_chi_square(white, self.degrees_of_freedom) / np.maximum(plain, 1e-300))
        return np.asarray(flat * scale[..., None])

    def whitened(self, off: Array) -> Array:
        """Turn differences from the means (..., J, p) into independent ones of standard deviation one."""
        root = np.linalg.cholesky(self.spread)
        white = np.linalg.solve(root, (off / self.scale)[..., None])[..., 0]
        return np.asarray(np.sqrt(self.weights)[:, None] * white)

    def covariance(self, group: int = 0) -> Array:
        """Covariance (p, p) of one average trial of a group."""
        scale = np.broadcast_to(self.scale, self.means.shape)[group]
        return np.asarray(self.spread * np.outer(scale, scale))

    def mean_sd(self, group: int = 0, channel: int = 0) -> float:
        """Estimate the standard deviation of one mean; few repeats know it badly."""
        return float(np.hypot(self._scatter(group, channel), self._common(group, channel)))

    def interval(self, level: float) -> tuple[float, float]:
        """Confidence interval of the first mean by Student's t."""
        upper = 0.5 + level / 2
        reach = np.hypot(
            stats.t.ppf(upper, self.degrees_of_freedom) * self._scatter(),
            stats.norm.ppf(upper) * self._common(),
        )
        return float(self.means[0, 0] - reach), float(self.means[0, 0] + reach)

    def chi_square_at(self, distance: float) -> float:
        """Chi-square that a mean so many standard deviations off amounts to, the fewer repeats the less."""
        if not np.isfinite(self.degrees_of_freedom):
            return distance**2
        off = np.zeros(self.means.shape)
        off[0, 0] = distance
        return float(equivalent_chi_square(off, self.degrees_of_freedom))

    def _scatter(self, group: int = 0, channel: int = 0) -> float:
        return float(np.sqrt(self.covariance(group)[channel, channel] / self.weights[group]))

    def _common(self, group: int = 0, channel: int = 0) -> float:
        return float(np.linalg.norm(self.shared[:, group, channel])) if self.shared.size else 0.0


def known(mean: float, sd: float) -> Repeats:
    """Take a restitution known from elsewhere, with a normal uncertainty.

    Raises
    ------
    ValueError
        If it is no restitution, or its standard deviation is not positive.
    """
    if not 0 <= mean <= 1:
        raise ValueError(f"restitution must be within [0, 1], got {mean:g}")
    if not 0 < sd < np.inf:
        raise ValueError(f"the standard deviation of a restitution must be positive, got {sd:g}")
    return Repeats(
        means=np.array([[mean]]), weights=np.ones(1), spread=np.array([[sd**2]]), degrees_of_freedom=np.inf
    )


def repeats_of(
    values: Array, stated: Array, groups: NDArray[np.int64], shared: Array | None = None
) -> Repeats:
    """Condense repeated measurements.

    Parameters
    ----------
    values : ndarray (N, p)
        Measured numbers, p = 1 or 2, one row a trial.
    stated : ndarray (N, p, p)
        Covariance each trial states for itself; NaN where it states none.
    groups : ndarray (N,)
        0 … J-1, which trials repeat each other.
    shared : ndarray (N, K, p), optional
        What one standard deviation of each of K errors common to all trials does to each number.

    Returns
    -------
    Repeats
        With fewer spare repeats than numbers the spread is what the trials state plus `ASSUMED_SCATTER` of
        their values, and `degrees_of_freedom` is infinite.
    """
    count, channels = values.shape
    freedom = count - len(np.unique(groups))
    weights = np.ones(count)
    scale = np.hypot(_group_means(values, weights, groups), _SLOWEST)
    values, stated = values / scale[groups], _complete(stated, scale[groups])
    shared = None if shared is None else shared / scale[groups][:, None]
    if freedom < channels:
        spread = stated.mean(axis=0) + np.diag((ASSUMED_SCATTER * np.abs(values).mean(axis=0)) ** 2)
        spread = at_least(spread, np.full(channels, FINEST_SCATTER**2))
        return _in_scale(_condensed((values, shared), weights, groups, spread, np.inf), scale)
    rough = _pooled(values, weights, groups, freedom)
    beyond = np.maximum(np.diagonal(rough) - np.diagonal(stated.mean(axis=0)), 0.0)
    variances = beyond + np.diagonal(stated, axis1=1, axis2=2) + FINEST_SCATTER**2
    weights = np.mean(variances.mean(axis=0) / variances, axis=1)
    floor = np.maximum(
        np.average(np.diagonal(stated, axis1=1, axis2=2), axis=0, weights=weights), FINEST_SCATTER**2
    )
    pooled = _pooled(values, weights, groups, freedom)
    condensed = _condensed((values, shared), weights, groups, at_least(pooled, floor), float(freedom))
    alike = bool((np.diagonal(pooled) < floor).any())
    return replace(_in_scale(condensed, scale), too_alike=alike)


def _in_scale(repeats: Repeats, scale: Array) -> Repeats:
    """Undo that values were taken relative to the scale of their group."""
    return replace(
        repeats,
        means=repeats.means * scale,
        shared=repeats.shared * scale if repeats.shared.size else repeats.shared,
        scale=scale,
    )


def _condensed(
    measured: tuple[Array, Array | None],
    weights: Array,
    groups: NDArray[np.int64],
    spread: Array,
    freedom: float,
) -> Repeats:
    values, shared = measured
    effects = np.empty((len(values), 0, values.shape[1])) if shared is None else shared
    means = _group_means(values, weights, groups)
    off = np.linalg.solve(np.linalg.cholesky(spread), (values - means[groups]).T)
    share = np.bincount(groups)[groups]
    common = np.array([_group_means(effect, weights, groups) for effect in np.moveaxis(effects, 1, 0)])
    deviations = np.sqrt(np.sum(off**2, axis=0) * weights * share / np.maximum(share - 1, 1))
    return Repeats(
        means=means,
        weights=np.asarray(np.bincount(groups, weights=weights), dtype=float),
        spread=spread,
        degrees_of_freedom=freedom,
        deviations=deviations,
        shared=common[common.any(axis=(1, 2))] if common.size else common,
    )


def _group_means(values: Array, weights: Array, groups: NDArray[np.int64]) -> Array:
    total = np.bincount(groups, weights=weights)
    sums = [np.bincount(groups, weights=weights * channel) for channel in values.T]
    return np.stack(sums, axis=1) / total[:, None]


def _pooled(values: Array, weights: Array, groups: NDArray[np.int64], freedom: int) -> Array:
    off = values - _group_means(values, weights, groups)[groups]
    return np.asarray((off * weights[:, None]).T @ off / freedom)


def _complete(stated: Array, scale: Array) -> Array:
    """Take covariances relative to a scale; trials that state none are as good as the others on average."""
    stated = stated / (scale[:, :, None] * scale[:, None, :])
    silent = np.asarray(np.isnan(stated).any(axis=(1, 2)))
    average = stated[~silent].mean(axis=0) if not silent.all() else np.zeros(stated.shape[1:])
    return np.where(silent[:, None, None], average, stated)

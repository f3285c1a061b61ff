"""Search for the restitutions that fit best at each of many fixed stiffness ratios, side by side.

Chi-square jumps where the order of events changes, also over the restitutions. A search therefore goes
downhill by damped Gauss-Newton while there is a slope to follow, and along a jump by compass search.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibrate.misfit import Misfit

Array = NDArray[np.float64]

_ROUNDS = 8
_STUCK = 1.0  # damping after three steps that led nowhere: from far above nothing more is expected then
_ARRIVED = 1e-3  # a search has arrived when its next step promises less gain of chi-square than this
_STRIDES = (0.002, 0.006, 0.018)  # in restitution, when looking for the other side of a jump
_COMPASS = np.stack([np.cos(np.arange(8) * np.pi / 4), np.sin(np.arange(8) * np.pi / 4)], axis=1)


@dataclass(frozen=True, slots=True, kw_only=True)
class Trace:
    """Best restitutions found at each stiffness ratio.

    Attributes
    ----------
    log_ratio : ndarray (G,)
        Natural logarithm of the stiffness ratio.
    restitutions : ndarray (G, 2)
        Ball-ball and ball-table.
    chi_square : ndarray (G,)
        At these parameters.
    """

    log_ratio: Array
    restitutions: Array
    chi_square: Array

    def merged(self, other: "Trace") -> "Trace":
        """Join two traces in rising order of the ratio."""
        log_ratio = np.concatenate([self.log_ratio, other.log_ratio])
        order = np.argsort(log_ratio, kind="stable")
        return Trace(
            log_ratio=log_ratio[order],
            restitutions=np.concatenate([self.restitutions, other.restitutions])[order],
            chi_square=np.concatenate([self.chi_square, other.chi_square])[order],
        )

    def improved(self, rows: NDArray[np.int64], other: "Trace") -> "Trace":
        """Replace those of some rows that another search over the same ratios did better."""
        better = other.chi_square < self.chi_square[rows]
        restitutions, chi_square = self.restitutions.copy(), self.chi_square.copy()
        restitutions[rows[better]], chi_square[rows[better]] = (
            other.restitutions[better],
            other.chi_square[better],
        )
        return Trace(log_ratio=self.log_ratio, restitutions=restitutions, chi_square=chi_square)


def search(misfit: Misfit, log_ratio: Array, ceiling: Array | float = np.inf) -> Trace:
    """Descend, at every ratio, from the most plausible restitutions; `ceiling` as for `descend`."""
    return descend(misfit, log_ratio, promising(misfit, log_ratio), ceiling)


def promising(misfit: Misfit, log_ratio: Array) -> Array:
    """Pick, for each ratio, the best of the plausible restitutions, (G, 2)."""
    seeds = misfit.likely_restitutions()
    net = misfit.chi_square(np.repeat(log_ratio, len(seeds)), np.tile(seeds, (len(log_ratio), 1)))
    return np.asarray(seeds[np.argmin(net.reshape(len(log_ratio), len(seeds)), axis=1)])


def search_from_each(misfit: Misfit, log_ratio: Array, starts: Sequence[Array]) -> Trace:
    """Descend from several starts (G, 2) at each of G ratios, all side by side, and keep the best ends."""
    found = descend(misfit, np.tile(log_ratio, len(starts)), np.concatenate(starts))
    heights = found.chi_square.reshape(len(starts), len(log_ratio))
    winner = np.argmin(heights, axis=0) * len(log_ratio) + np.arange(len(log_ratio))
    return Trace(
        log_ratio=log_ratio,
        restitutions=found.restitutions[winner],
        chi_square=found.chi_square[winner],
    )


def descend(misfit: Misfit, log_ratio: Array, start: Array, ceiling: Array | float = np.inf) -> Trace:
    """Go downhill over the restitutions from a start at each of several fixed ratios.

    Parameters
    ----------
    misfit : Misfit
        What to make small.
    log_ratio : ndarray (G,)
        Fixed, natural logarithm.
    start : ndarray (G, 2)
        Ball-ball and ball-table restitution; kept within [0, 1] throughout.
    ceiling : ndarray (G,) or float
        Chi-square already found elsewhere; a search that does not promise to get below is given up.

    Returns
    -------
    Trace
        Where each search ended. Those far above the best of them are given up, too.
    """
    at = np.clip(start, 0.0, 1.0)
    residuals = misfit.residuals(log_ratio, at)
    ceiling = np.broadcast_to(ceiling, len(at))
    out_of_reach = misfit.out_of_reach
    damping = np.full(len(at), 1e-3)
    going = np.arange(len(at))
    for _ in range(_ROUNDS):
        if not going.size:
            break
        slopes = jacobian(misfit, log_ratio[going], at[going], residuals[going])
        step, promised = _step(slopes, residuals[going], damping[going])
        expected = _squared(residuals[going]) - promised
        worth = (promised > _ARRIVED) & (expected < ceiling[going])
        worth &= expected < expected.min(initial=np.inf) + out_of_reach
        going, step = going[worth], step[worth]
        trial = np.clip(at[going] + step, 0.0, 1.0)
        after = misfit.residuals(log_ratio[going], trial)
        better = _squared(after) < _squared(residuals[going])
        at[going[better]], residuals[going[better]] = trial[better], after[better]
        damping[going] *= np.where(better, 0.1, 30.0)
        chi_square = _squared(residuals)
        hopeless = chi_square[going] > chi_square.min() + out_of_reach
        going = going[~(hopeless & (damping[going] > _STUCK))]
    trace = Trace(log_ratio=log_ratio, restitutions=at, chi_square=_squared(residuals))
    return _along_jumps(misfit, trace, going)


def over_the_edge(misfit: Misfit, log_ratio: Array, start: Array) -> Array:
    """Look around each start, (G, 2), for the other side of a jump; the best place found, (G, 2)."""
    steps = np.concatenate([np.zeros((1, 2)), *(radius * _COMPASS for radius in _STRIDES)])
    tries = np.clip(start[:, None, :] + steps, 0.0, 1.0)
    chi_square = misfit.chi_square(np.repeat(log_ratio, len(steps)), tries.reshape(-1, 2))
    return np.asarray(
        tries[np.arange(len(start)), np.argmin(chi_square.reshape(len(start), len(steps)), axis=1)]
    )


def jacobian(misfit: Misfit, log_ratio: Array, restitutions: Array, residuals: Array) -> Array:
    """Differentiate the residuals (N, R) by the restitutions; (N, R, 2), by differences towards 0.5."""
    moved = restitutions[None] + np.where(restitutions > 0.5, -1e-5, 1e-5) * np.eye(2)[:, None]
    after = misfit.residuals(np.tile(log_ratio, 2), moved.reshape(-1, 2)).reshape(2, *residuals.shape)
    steps = np.stack([(moved - restitutions)[column, :, column] for column in range(2)])
    return np.moveaxis((after - residuals) / steps[..., None], 0, 2)


def _step(slopes: Array, residuals: Array, damping: Array) -> tuple[Array, Array]:
    """Levenberg-Marquardt step (N, 2) and the gain of chi-square (N,) the undamped one promises."""
    normal = np.swapaxes(slopes, 1, 2) @ slopes + 1e-9 * np.eye(2)
    downhill = -np.einsum("nri,nr->ni", slopes, residuals)
    full = np.linalg.solve(normal, downhill[..., None])[..., 0]
    damped = normal * (1 + damping[:, None, None] * np.eye(2))
    return np.linalg.solve(damped, downhill[..., None])[..., 0], np.einsum("ni,ni->n", downhill, full)


def _along_jumps(misfit: Misfit, trace: Trace, rows: NDArray[np.int64]) -> Trace:
    """Compass search for those that did not arrive: they stand at a jump, where no slope leads on."""
    rows = rows[trace.chi_square[rows] < trace.chi_square.min() + misfit.out_of_reach]
    if not rows.size:
        return trace
    at, lowest = trace.restitutions[rows], trace.chi_square[rows]
    log_ratio = np.repeat(trace.log_ratio[rows], len(_COMPASS))
    radius = np.full((len(rows), 1, 1), 0.004)
    for _ in range(_ROUNDS):
        tries = np.clip(at[:, None, :] + radius * _COMPASS, 0.0, 1.0)
        chi_square = misfit.chi_square(log_ratio, tries.reshape(-1, 2)).reshape(len(rows), -1)
        choice = np.argmin(chi_square, axis=1)
        better = chi_square.min(axis=1) < lowest
        at = np.where(better[:, None], tries[np.arange(len(rows)), choice], at)
        lowest = np.minimum(lowest, chi_square.min(axis=1))
        radius *= np.where(better, 1.5, 0.4)[:, None, None]
    return trace.improved(rows, Trace(log_ratio=trace.log_ratio[rows], restitutions=at, chi_square=lowest))


def _squared(residuals: Array) -> Array:
    return np.asarray(np.sum(residuals**2, axis=1))

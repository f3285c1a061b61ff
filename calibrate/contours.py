"""Chi-square over two parameters: the stiffness ratio and the ball-ball restitution, the third refitted."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibrate.estimate import Calibration, Estimate
from calibrate.misfit import Misfit

Array = NDArray[np.float64]

_RATIOS, _RESTITUTIONS, _NET = 120, 41, 25
_ROUNDS = 4
_MARGIN = 1.15  # factor beyond the 95 % set of the ratio
_STEP = 1e-5
_BREADTH = 1.8  # half width in restitution, in those of its 95 % set


@dataclass(frozen=True, slots=True, kw_only=True)
class Contours:
    """A surface of chi-square.

    Attributes
    ----------
    stiffness_ratio : ndarray (G,)
        In rising order.
    ball_ball : ndarray (H,)
        Restitution, in rising order.
    chi_square : ndarray (H, G)
        With the ball-table restitution refitted.
    """

    stiffness_ratio: Array
    ball_ball: Array
    chi_square: Array


def contours(misfit: Misfit, calibration: Calibration) -> Contours:
    """Compute chi-square over ratio and ball-ball restitution, around the 95 % sets of a fit.

    Parameters
    ----------
    misfit : Misfit
        Everything measured, as `calibrate.fit.misfit_of` makes it.
    calibration : Calibration
        The fit to it.
    """
    ratio = _ratios(calibration)
    ball_ball = np.linspace(*_reach(calibration.restitution_ball_ball), _RESTITUTIONS)
    log_ratio, first = (values.ravel() for values in np.meshgrid(np.log(ratio), ball_ball))
    low, high = _reach(calibration.restitution_ball_table)
    net = np.concatenate(
        [np.linspace(low, high, _NET), [valley.restitutions[1] for valley in calibration.valleys]]
    )
    start = _from_net(misfit, (log_ratio, first), net, (len(ball_ball), len(ratio)))
    surface = _refitted(misfit, log_ratio, first, start)
    return Contours(
        stiffness_ratio=ratio, ball_ball=ball_ball, chi_square=surface.reshape(len(ball_ball), len(ratio))
    )


def _reach(restitution: Estimate) -> tuple[float, float]:
    """Restitutions worth a look: its 95 % set and somewhat more."""
    sets = restitution.intervals_95
    middle, reach = (sets[0][0] + sets[-1][1]) / 2, _BREADTH * (sets[-1][1] - sets[0][0]) / 2
    return max(middle - reach, 0.0), min(middle + reach, 1.0)


def _ratios(calibration: Calibration) -> Array:
    """Ratios of the profile around its 95 % set, thinned where they are many."""
    sets = calibration.stiffness_ratio.intervals_95
    ratio = np.array(calibration.profile.stiffness_ratio)
    near = ratio[(ratio > sets[0][0] / _MARGIN) & (ratio < sets[-1][1] * _MARGIN)]
    even = np.geomspace(near[0], near[-1], _RATIOS // 2)
    return np.unique(np.concatenate([near[:: max(1, len(near) * 2 // _RATIOS)], even]))


def _from_net(misfit: Misfit, grid: tuple[Array, Array], net: Array, shape: tuple[int, int]) -> Array:
    """Pick the best of a net of ball-table restitutions, then of the neighbours' choices: there are jumps."""
    log_ratio, first = grid

    def heights(second: Array) -> Array:
        return misfit.chi_square(log_ratio, np.stack([first, second], axis=1))

    seen = [heights(np.full(len(first), value)) for value in net]
    second, lowest = net[np.argmin(seen, axis=0)], np.min(seen, axis=0)
    for axis, shift in [(0, 1), (0, -1), (1, 1), (1, -1)] * _ROUNDS:
        beside = np.roll(second.reshape(shape), shift, axis).ravel()
        found = heights(beside)
        second, lowest = np.where(found < lowest, beside, second), np.minimum(found, lowest)
    return np.asarray(second)


def _refitted(misfit: Misfit, log_ratio: Array, first: Array, second: Array) -> Array:
    """Descend over the ball-table restitution alone."""
    residuals = misfit.residuals(log_ratio, np.stack([first, second], axis=1))
    share = np.ones(len(first))  # of the step: beyond a jump the whole one leads up
    for _ in range(2 * _ROUNDS):
        step = np.where(second > 0.5, -_STEP, _STEP)
        moved = misfit.residuals(log_ratio, np.stack([first, second + step], axis=1))
        slope = (moved - residuals) / step[:, None]
        change = -np.sum(slope * residuals, axis=1) / np.maximum(np.sum(slope**2, axis=1), 1e-9)
        tried = np.clip(second + share * change, 0.0, 1.0)
        after = misfit.residuals(log_ratio, np.stack([first, tried], axis=1))
        better = np.sum(after**2, axis=1) < np.sum(residuals**2, axis=1)
        share = np.where(better, 1.0, share / 3)
        second, residuals = np.where(better, tried, second), np.where(better[:, None], after, residuals)
    return np.asarray(np.sum(residuals**2, axis=1))

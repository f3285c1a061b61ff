"""Chi-square over two parameters: the stiffness ratio and the ball-ball restitution, the third refitted."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibrate.estimate import Calibration
from calibrate.misfit import Misfit

Array = NDArray[np.float64]

_RATIOS, _RESTITUTIONS = 120, 41
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
    sets = calibration.restitution_ball_ball.intervals_95
    middle, reach = (sets[0][0] + sets[-1][1]) / 2, _BREADTH * (sets[-1][1] - sets[0][0]) / 2
    ball_ball = np.linspace(max(middle - reach, 0.0), min(middle + reach, 1.0), _RESTITUTIONS)
    log_ratio, first = (values.ravel() for values in np.meshgrid(np.log(ratio), ball_ball))
    starts = np.unique([valley.restitutions[1] for valley in calibration.valleys])[:3]
    surface = np.min([_refitted(misfit, log_ratio, first, float(start)) for start in starts], axis=0)
    return Contours(
        stiffness_ratio=ratio, ball_ball=ball_ball, chi_square=surface.reshape(len(ball_ball), len(ratio))
    )


def _ratios(calibration: Calibration) -> Array:
    """Ratios of the profile around its 95 % set, thinned where they are many."""
    sets = calibration.stiffness_ratio.intervals_95
    ratio = np.array(calibration.profile.stiffness_ratio)
    near = ratio[(ratio > sets[0][0] / _MARGIN) & (ratio < sets[-1][1] * _MARGIN)]
    even = np.geomspace(near[0], near[-1], _RATIOS // 2)
    return np.unique(np.concatenate([near[:: max(1, len(near) * 2 // _RATIOS)], even]))


def _refitted(misfit: Misfit, log_ratio: Array, first: Array, start: float) -> Array:
    """Descend over the ball-table restitution alone, from one start everywhere."""
    second = np.full(len(first), start)
    residuals = misfit.residuals(log_ratio, np.stack([first, second], axis=1))
    for _ in range(_ROUNDS):
        step = np.where(second > 0.5, -_STEP, _STEP)
        moved = misfit.residuals(log_ratio, np.stack([first, second + step], axis=1))
        slope = (moved - residuals) / step[:, None]
        change = -np.sum(slope * residuals, axis=1) / np.maximum(np.sum(slope**2, axis=1), 1e-9)
        tried = np.clip(second + change, 0.0, 1.0)
        after = misfit.residuals(log_ratio, np.stack([first, tried], axis=1))
        better = np.sum(after**2, axis=1) < np.sum(residuals**2, axis=1)
        second, residuals = np.where(better, tried, second), np.where(better[:, None], after, residuals)
    return np.asarray(np.sum(residuals**2, axis=1))

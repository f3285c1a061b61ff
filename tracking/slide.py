"""The path of a struck ball, fitted as one: rest, sliding parabola, straight roll.

Unknown are the place of rest, the moment of the strike, the launch velocity, the velocity that friction takes
away while the ball slides (two sevenths of its slip over the cloth: direction and size), how long that takes,
and the slow deceleration of rolling. Without sliding the last two but one mean nothing; without an end of
sliding only their ratio, the deceleration, does.
"""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
import numpy.typing as npt
from scipy.optimize import least_squares

from tracking.cloth import Cloth, cloth_position
from tracking.joint import OUTLIER
from tracking.least import honest_covariance

FloatArray = npt.NDArray[np.float64]

ROLLING_RESISTANCE = 0.01
"""Of billiard cloths 0.005 to 0.015; short paths hardly tell it, so it is expected here ± as much again."""
LARGEST_RESISTANCE = 0.04
USUAL_FRICTION = 0.2
"""Of billiard cloths, within a factor of two; it matters only for slides too short to tell it."""
SLIDE_SHARES = (0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.65, 0.8, 0.95)
NO_FRICTION = 1e-9
RIM_ERROR = 1.0  # standard deviations of one frame that light and cloth shift a rim (rendered shots)
RIM_REACH = 4.0  # radii over which they do so alike
RAYLEIGH_MEDIAN = 1.1774  # of the distance in the plane, in standard deviations of a coordinate


class Q(IntEnum):
    """Places in the vector of parameters."""

    X = 0
    Y = 1
    STRIKE = 2
    VELOCITY_X = 3
    VELOCITY_Y = 4
    LOSS_X = 5
    LOSS_Y = 6
    SLIDING = 7
    RESISTANCE = 8


ROLLING_ONLY = [Q.X, Q.Y, Q.STRIKE, Q.VELOCITY_X, Q.VELOCITY_Y, Q.RESISTANCE]
SLIDING_ONLY = [Q.X, Q.Y, Q.STRIKE, Q.VELOCITY_X, Q.VELOCITY_Y, Q.LOSS_X, Q.LOSS_Y]
LINEAR = [Q.X, Q.Y, Q.VELOCITY_X, Q.VELOCITY_Y, Q.LOSS_X, Q.LOSS_Y]


@dataclass(frozen=True, slots=True, kw_only=True)
class Seen:
    """What the fit sees: (n,) times in s, (n, 2) places, their standard deviations; radius and gravity."""

    time: FloatArray
    place: FloatArray
    sd: FloatArray
    radius: float
    gravity: float


@dataclass(frozen=True, slots=True, kw_only=True)
class PathFit:
    """Fitted parameters (indexed by `Q`), their covariance (0 where held), misfit, RMS distance, frames used.

    `chi_square` is in units of the scatter the frames really have.
    """

    parameters: FloatArray
    covariance: FloatArray
    chi_square: float
    residual: float
    used: npt.NDArray[np.bool_]


def path(parameters: FloatArray, time: FloatArray, gravity: float) -> FloatArray:
    """Places (n, 2) that the parameters predict."""
    loss = parameters[[Q.LOSS_X, Q.LOSS_Y]]
    cloth = Cloth(
        friction=max(sliding_friction(parameters, gravity), NO_FRICTION),
        rolling_resistance=max(float(parameters[Q.RESISTANCE]), 0.0),
        gravity=gravity,
    )
    since = np.maximum(time - parameters[Q.STRIKE], 0.0)
    velocity = parameters[[Q.VELOCITY_X, Q.VELOCITY_Y]]
    return np.asarray(parameters[[Q.X, Q.Y]] + cloth_position(cloth, velocity, 3.5 * loss, since))


def sliding_friction(parameters: FloatArray, gravity: float) -> float:
    """Friction coefficient that takes away the velocity lost in the time that sliding lasts."""
    lost = float(np.hypot(parameters[Q.LOSS_X], parameters[Q.LOSS_Y]))
    return lost / (gravity * max(float(parameters[Q.SLIDING]), NO_FRICTION))


def first_guess(seen: Seen, strike: float) -> FloatArray:
    """Try several durations of sliding; for each the rest is a linear problem. Take the best."""
    best, least = np.zeros(len(Q)), np.inf
    total = float(seen.time[-1] - strike)
    since = np.maximum(seen.time - strike, 0.0)
    for share in SLIDE_SHARES:
        sliding = share * total
        during = np.minimum(since, sliding)
        lost = -(during**2 / (2 * sliding) + since - during)
        design = np.column_stack((np.ones_like(since), since, lost))
        solution, *_ = np.linalg.lstsq(design, seen.place, rcond=None)
        misfit = float(np.sum((design @ solution - seen.place) ** 2))
        if misfit < least:
            least = misfit
            best[LINEAR] = solution.ravel()
            best[Q.STRIKE], best[Q.SLIDING] = strike, sliding
    best[Q.RESISTANCE] = ROLLING_RESISTANCE
    return best


def fit_path(seen: Seen, start: FloatArray, free: list[Q]) -> PathFit:
    """Fit the `free` parameters robustly, drop the frames that lie off, and fit again.

    The covariance is widened where the frames scatter more than their rims tell and where neighbouring frames
    err alike; it is never narrowed.
    """
    everything = np.ones(len(seen.time), dtype=bool)
    rough = _solve(seen, start, free, used=everything, robust=True)
    distance = np.hypot(*((seen.place - path(rough, seen.time, seen.gravity)) / seen.sd).T)
    used = distance < OUTLIER * max(1.0, float(np.median(distance)) / RAYLEIGH_MEDIAN)
    parameters = _solve(seen, rough, free, used=used, robust=False)
    return _graded(seen, parameters, free, used)


def _solve(
    seen: Seen, start: FloatArray, free: list[Q], *, used: npt.NDArray[np.bool_], robust: bool
) -> FloatArray:
    """Least squares within what is possible: no negative resistance, no sliding beyond the last frame."""
    longest = float(seen.time[-1] - seen.time[0])
    lower, upper = np.full(len(Q), -np.inf), np.full(len(Q), np.inf)
    lower[[Q.SLIDING, Q.RESISTANCE]], upper[Q.SLIDING], upper[Q.RESISTANCE] = 0, longest, LARGEST_RESISTANCE
    fit = least_squares(
        lambda values: _residuals(seen, _with(start, free, values), used),
        np.clip(start[free], lower[free] + 1e-9, upper[free] - 1e-9),
        bounds=(lower[free], upper[free]),
        loss="soft_l1" if robust else "linear",
        x_scale="jac",
    )
    return _with(start, free, fit.x)


def _with(start: FloatArray, free: list[Q], values: FloatArray) -> FloatArray:
    """Put values into a copy of the parameters."""
    parameters = start.copy()
    parameters[free] = values
    return parameters


def _residuals(seen: Seen, parameters: FloatArray, used: npt.NDArray[np.bool_]) -> FloatArray:
    """Distances from the path, and of both resistances from what cloths have, in standard deviations."""
    apart = (seen.place[used] - path(parameters, seen.time[used], seen.gravity)) / seen.sd[used]
    rolling = (parameters[Q.RESISTANCE] - ROLLING_RESISTANCE) / ROLLING_RESISTANCE
    friction = sliding_friction(parameters, seen.gravity)
    sliding = np.log2(max(friction, NO_FRICTION) / USUAL_FRICTION) if friction > 0 else 0.0
    return np.concatenate((apart.ravel(), [rolling, sliding]))


def _shared(seen: Seen, used: npt.NDArray[np.bool_]) -> FloatArray:
    """Covariance of what light and cloth do to the rim: alike for places a few radii apart."""
    place, sd = seen.place[used], seen.sd[used].mean(axis=1)
    apart = np.hypot(*(place[:, None] - place[None, :]).transpose(2, 0, 1))
    size = RIM_ERROR * float(np.median(seen.sd)) / sd
    return np.asarray(np.outer(size, size) * np.exp(-apart / (RIM_REACH * seen.radius)))


def _graded(seen: Seen, parameters: FloatArray, free: list[Q], used: npt.NDArray[np.bool_]) -> PathFit:
    """Judge a fit by its residuals."""

    def residuals(values: FloatArray) -> FloatArray:
        return _residuals(seen, _with(parameters, free, values), used)

    covariance = np.zeros((len(Q), len(Q)))
    covariance[np.ix_(free, free)] = honest_covariance(
        residuals, parameters[free], int(used.sum()), shared=_shared(seen, used)
    )
    distance = seen.place[used] - path(parameters, seen.time[used], seen.gravity)
    return PathFit(
        parameters=parameters,
        covariance=covariance,
        chi_square=float(np.sum(residuals(parameters[free]) ** 2)),
        residual=float(np.sqrt(np.mean(np.sum(distance**2, axis=1)))),
        used=used,
    )

"""What the path of a struck ball tells of the strike, and what it does not.

The velocity lost while sliding is two sevenths of the slip u of the lowest point over the cloth, and
u = v + r z x w gives the spin: w_x = (u_y - v_y) / r, w_y = (v_x - u_x) / r (solid ball, y up).
"""

from dataclasses import dataclass, replace
from enum import Enum, IntEnum

import numpy as np
import numpy.typing as npt

from tracking.least import slopes
from tracking.slide import (
    ROLLING_ONLY,
    SLIDING_ONLY,
    USUAL_FRICTION,
    PathFit,
    Q,
    Seen,
    first_guess,
    fit_path,
    path,
    sliding_friction,
)

FloatArray = npt.NDArray[np.float64]

SLIDES = 16.0  # gain in chi-square that shows sliding (three parameters more)
ROLLS = 9.0  # gain in chi-square that shows the end of sliding (one parameter more)
LEAST_FRICTION = 0.06  # billiard cloths have 0.1 to 0.4; what slows a ball less than this is rolling


class Stage(Enum):
    """Which part of the motion the recording shows; the value is what that leaves open."""

    SLIDES_THEN_ROLLS = ""
    ROLLS_AT_ONCE = "no sliding is seen, so the cloth's friction cannot be told; the spin is that of rolling"
    SLIDES_THROUGHOUT = (
        "the ball still slides when last seen, so its spin cannot be told; film a longer part of its way"
    )


class V(IntEnum):
    """Places in the vector of values."""

    VELOCITY_X = 0
    VELOCITY_Y = 1
    SPIN_X = 2
    SPIN_Y = 3
    FRICTION = 4
    STRIKE = 5
    ROLLING_TIME = 6
    ROLLING_X = 7
    ROLLING_Y = 8


UNTOLD = {
    Stage.SLIDES_THEN_ROLLS: [],
    Stage.ROLLS_AT_ONCE: [V.FRICTION],
    Stage.SLIDES_THROUGHOUT: [V.SPIN_X, V.SPIN_Y, V.ROLLING_TIME, V.ROLLING_X, V.ROLLING_Y],
}
BY_RADIUS = [V.SPIN_X, V.SPIN_Y, V.FRICTION]
SCALED = [V.VELOCITY_X, V.VELOCITY_Y, *BY_RADIUS]


@dataclass(frozen=True, slots=True, kw_only=True)
class PathValues:
    """Values (indexed by `V`), their covariance (NaN where untold), the stage seen, and the fit."""

    values: FloatArray
    covariance: FloatArray
    stage: Stage
    fit: PathFit


def read_path(
    seen: Seen, strike: float, radius: float, *, scale_sd: float = 0.0, radius_sd: float = 0.0
) -> PathValues:
    """Fit the path and read from it what it tells.

    Parameters
    ----------
    seen : Seen
        Frames from rest to the end of the free motion, y up.
    strike : float
        First guess of the moment of the strike, s.
    radius : float
        Of the ball, in the unit of `seen`.
    scale_sd : float
        Relative standard uncertainty of lengths.
    radius_sd : float
        Relative standard uncertainty of the radius, where the unit itself comes from it.

    Examples
    --------
    A ball struck at its centre slides without spin at first:

    >>> from tracking.cloth import Cloth, cloth_position
    >>> time = np.arange(120) / 120
    >>> cloth = Cloth(friction=0.2, rolling_resistance=0.01)
    >>> place = cloth_position(cloth, (1.5, 0.0), (1.5, 0.0), np.maximum(time - 0.1, 0.0))
    >>> seen = Seen(time=time, place=place, sd=np.full((120, 2), 1e-4), radius=0.0286, gravity=9.80665)
    >>> told = read_path(seen, 0.1, 0.0286)
    >>> print(told.stage.name, f"{told.values[V.VELOCITY_X]:.3f} m/s, {abs(told.values[V.SPIN_Y]):.1f} rad/s")
    SLIDES_THEN_ROLLS 1.500 m/s, 0.0 rad/s
    """
    stage, fit = _best_stage(seen, first_guess(seen, strike))
    values = _values(fit.parameters, seen.gravity, radius)
    slope = slopes(lambda parameters: _values(parameters, seen.gravity, radius), fit.parameters)
    slope = np.nan_to_num(slope)
    covariance = slope @ fit.covariance @ slope.T
    if stage is Stage.ROLLS_AT_ONCE:  # a slide shorter than a frame would not be seen
        hidden = USUAL_FRICTION * seen.gravity * float(np.median(np.diff(seen.time))) * 3.5 / radius
        covariance[[V.SPIN_X, V.SPIN_Y], [V.SPIN_X, V.SPIN_Y]] += hidden**2
    for share, which in ((scale_sd, SCALED), (radius_sd, BY_RADIUS)):
        common = np.zeros(len(V))
        common[which] = values[which] * share
        covariance += np.outer(common, common)
    # a stamp marks the start of an exposure of unknown length, so all moments may be late by half a frame
    moments = [V.STRIKE, V.ROLLING_TIME]
    covariance[np.ix_(moments, moments)] += float(np.median(np.diff(seen.time))) ** 2 / 12
    untold = UNTOLD[stage]
    values[untold] = np.nan
    covariance[untold, :] = np.nan
    covariance[:, untold] = np.nan
    return PathValues(values=values, covariance=covariance, stage=stage, fit=fit)


def _best_stage(seen: Seen, start: FloatArray) -> tuple[Stage, PathFit]:
    """Take the fullest description that the path calls for."""
    full = fit_path(seen, start, list(Q))
    rolling = start.copy()
    rolling[[Q.LOSS_X, Q.LOSS_Y]] = 0
    if sliding_friction(full.parameters, seen.gravity) < LEAST_FRICTION:
        return Stage.ROLLS_AT_ONCE, fit_path(seen, rolling, ROLLING_ONLY)
    kept = replace(seen, time=seen.time[full.used], place=seen.place[full.used], sd=seen.sd[full.used])
    scale = max(1.0, full.chi_square / max(2 * len(kept.time) - len(Q), 1))
    rolls = fit_path(kept, rolling, ROLLING_ONLY)
    if rolls.used.all() and (rolls.chi_square - full.chi_square) / scale < SLIDES:
        return Stage.ROLLS_AT_ONCE, replace(rolls, used=full.used)
    slides = fit_path(kept, _never_rolling(seen, full.parameters), SLIDING_ONLY)
    if slides.used.all() and (slides.chi_square - full.chi_square) / scale < ROLLS:
        return Stage.SLIDES_THROUGHOUT, replace(slides, used=full.used)
    return Stage.SLIDES_THEN_ROLLS, full


def _never_rolling(seen: Seen, parameters: FloatArray) -> FloatArray:
    """Let the sliding go on beyond the last frame, with the same deceleration."""
    longer = parameters.copy()
    longer[Q.SLIDING] = 2 * (seen.time[-1] - parameters[Q.STRIKE])
    longer[[Q.LOSS_X, Q.LOSS_Y]] *= longer[Q.SLIDING] / max(float(parameters[Q.SLIDING]), 1e-3)
    return longer


def _values(parameters: FloatArray, gravity: float, radius: float) -> FloatArray:
    """Turn the parameters of the path into what a player asks for."""
    velocity, loss = parameters[[Q.VELOCITY_X, Q.VELOCITY_Y]], parameters[[Q.LOSS_X, Q.LOSS_Y]]
    sliding = float(parameters[Q.SLIDING]) if np.any(loss) else 0.0
    slip = 3.5 * loss
    values = np.full(len(V), np.nan)
    values[[V.VELOCITY_X, V.VELOCITY_Y]] = velocity
    values[[V.SPIN_X, V.SPIN_Y]] = (slip[1] - velocity[1]) / radius, (velocity[0] - slip[0]) / radius
    values[V.FRICTION] = sliding_friction(parameters, gravity) if sliding else np.nan
    values[V.STRIKE] = parameters[Q.STRIKE]
    values[V.ROLLING_TIME] = parameters[Q.STRIKE] + sliding
    values[[V.ROLLING_X, V.ROLLING_Y]] = path(parameters, values[[V.ROLLING_TIME]], gravity)[0]
    return values

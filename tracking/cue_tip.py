"""How fast and where the cue's tip arrives at the ball."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tracking.track import Track

FloatArray = npt.NDArray[np.float64]

LAST_SECONDS = 0.1  # of the approach, within which the cue's acceleration is steady
LAST_FRAMES = 5.5  # at least, if frames are few
CURVED_FROM = 4  # frames from which the acceleration is looked for
CERTAIN = 3.0  # standard deviations
LINE_ERROR = 2.0  # standard deviations of a place that all frames of one line share


@dataclass(frozen=True, slots=True, kw_only=True)
class CueTip:
    """The cue's tip just before the strike, in the unit of its track, x to the right and y up.

    Attributes
    ----------
    velocity, velocity_sd : (2,) arrays
        Velocity at the moment of the strike.
    offset, offset_sd : float
        How far beside the ball's centre its line passes, in radii of the ball; positive to the right of the
        shot, which gives right english. The height of the contact cannot be seen from above.
    frames : int
        Frames that were used.
    """

    velocity: FloatArray
    velocity_sd: FloatArray
    offset: float
    offset_sd: float
    frames: int


def measure_tip(tip: Track, strike_time: float, place: FloatArray, radius: float) -> CueTip | None:
    """Extrapolate the tip's way to the strike.

    Parameters
    ----------
    tip : Track
        y up; its last frame may already show the strike and is left out then.
    strike_time : float
        s.
    place : (2,) array
        Centre of the resting ball.
    radius : float
        Of the ball, in the unit of the track.

    Returns
    -------
    CueTip or None
        None if fewer than three frames show the tip before the strike.
    """
    interval = float(np.median(np.diff(tip.time)))
    used = tip.time < strike_time - interval / 2
    used &= tip.time > strike_time - max(LAST_SECONDS, LAST_FRAMES * interval)
    if used.sum() < 3:
        return None
    since = tip.time[used] - strike_time
    places = np.column_stack((tip.x, tip.y))[used]
    velocity, velocity_sd = _velocity_at_strike(since, places, float(np.median(tip.x_sd)))
    direction = velocity / max(float(np.hypot(*velocity)), 1e-30)
    right = np.array([direction[1], -direction[0]])
    beside = (places - place) @ right / radius
    scatter = float(np.std(beside, ddof=1)) / float(np.sqrt(used.sum()))
    return CueTip(
        velocity=velocity,
        velocity_sd=velocity_sd,
        offset=float(np.mean(beside)),
        offset_sd=float(np.hypot(scatter, LINE_ERROR * float(np.median(tip.x_sd)) / radius)),
        frames=int(used.sum()),
    )


def _velocity_at_strike(since: FloatArray, places: FloatArray, sd: float) -> tuple[FloatArray, FloatArray]:
    """Slope at time 0 of a line, or of a parabola where the cue accelerates, and its uncertainty."""
    line = _fit(since, places, 1, sd)
    if len(since) < CURVED_FROM:
        return line[0][1], line[1][1]
    curve, curve_sd = _fit(since, places, 2, sd)
    curved = bool(np.any(np.abs(curve[2]) > CERTAIN * curve_sd[2]))
    return (curve[1], curve_sd[1]) if curved else (line[0][1], line[1][1])


def _fit(since: FloatArray, places: FloatArray, degree: int, sd: float) -> tuple[FloatArray, FloatArray]:
    """Fit polynomials to both coordinates: coefficients from the constant up, and their sd."""
    powers = np.vander(since, degree + 1, increasing=True)
    inverse = np.linalg.pinv(powers)
    solution = inverse @ places
    freedom = max(len(since) - degree - 1, 1)
    scatter = np.sqrt(np.sum((places - powers @ solution) ** 2, axis=0) / freedom)
    return solution, np.linalg.norm(inverse, axis=1)[:, None] * np.maximum(scatter, sd)

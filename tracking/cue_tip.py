"""How fast and where the cue's tip arrives at the ball."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tracking.track import Track

FloatArray = npt.NDArray[np.float64]

LAST_SECONDS = 0.1  # of the approach, within which the cue's acceleration is steady
CURVED_FROM = 7  # frames from which the acceleration is fitted too


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
    used &= tip.time > strike_time - max(LAST_SECONDS, 4.5 * interval)
    if used.sum() < 3:
        return None
    since = tip.time[used] - strike_time
    places = np.column_stack((tip.x, tip.y))[used]
    velocity, velocity_sd = _velocity_at_strike(since, places, float(np.median(tip.x_sd)))
    direction = velocity / max(float(np.hypot(*velocity)), 1e-30)
    right = np.array([direction[1], -direction[0]])
    beside = (places - place) @ right / radius
    scatter = max(float(np.std(beside, ddof=1)), float(np.median(tip.x_sd)) / radius)
    return CueTip(
        velocity=velocity,
        velocity_sd=velocity_sd,
        offset=float(np.mean(beside)),
        offset_sd=scatter / float(np.sqrt(used.sum())),
        frames=int(used.sum()),
    )


def _velocity_at_strike(since: FloatArray, places: FloatArray, sd: float) -> tuple[FloatArray, FloatArray]:
    """Slope at time 0 of a line, or of a parabola where there are frames enough, and its uncertainty."""
    degree = 2 if len(since) >= CURVED_FROM else 1
    powers = np.vander(since, degree + 1, increasing=True)
    inverse = np.linalg.pinv(powers)
    solution = inverse @ places
    apart = places - powers @ solution
    scatter = np.sqrt(np.sum(apart**2, axis=0) / max(len(since) - degree - 1, 1))
    gain = float(np.linalg.norm(inverse[1]))
    return solution[1], np.maximum(scatter, sd) * gain

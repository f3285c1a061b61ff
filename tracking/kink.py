"""Where the free motion of a ball ends: it meets another ball or a cushion, and its velocity jumps."""

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]

BEFORE = 10  # frames from which the next ones are foretold
FEWEST_BEFORE = 5
AFTER = 3
AFTER_SECONDS = 0.02
PLAUSIBLE_FRICTION = 0.25
"""Over a few frames the deceleration may change by this times gravity: sliding ends."""
CERTAIN = 5.0  # standard deviations
THIRD_DIFFERENCE = 20**0.5  # 1 + 9 + 9 + 1: its standard deviation over that of a place


def first_kink(time: FloatArray, place: FloatArray, sd: float, gravity: float) -> int | None:
    """Find the first frame after a jump of the velocity, in free motion that has already begun.

    Parameters
    ----------
    time : (n,) array
        s.
    place : (n, 2) array
        Any unit of length.
    sd : float
        Standard deviation of a coordinate, same unit; more if the frames scatter more.
    gravity : float
        Same unit over s².

    Returns
    -------
    int or None
        Index of the frame; None if the ball never meets anything.

    Examples
    --------
    >>> time = np.arange(20) / 100
    >>> place = np.column_stack((np.abs(time - 0.095), 0 * time))
    >>> first_kink(time, place, 1e-4, 9.8)
    10
    """
    after = max(AFTER, round(AFTER_SECONDS / float(np.median(np.diff(time))))) if len(time) > 1 else AFTER
    sd = max(sd, _scatter(place))
    for index in range(FEWEST_BEFORE, len(time) - after + 1):
        earlier = slice(max(0, index - BEFORE), index)
        later = slice(index, index + after)
        ahead = time[later] - time[index - 1]
        foretold, spread = _extrapolated(time[earlier], place[earlier], time[later])
        apart = np.hypot(*(place[later] - foretold).T)
        if np.all(apart > CERTAIN * sd * spread + PLAUSIBLE_FRICTION * gravity / 2 * ahead**2):
            return index
    return None


def _scatter(place: FloatArray) -> float:
    """Noise of a coordinate, from third differences: no smooth motion shows in them, and few jumps."""
    if len(place) < 4:
        return 0.0
    third = np.diff(place, 3, axis=0)
    return 1.4826 * float(np.median(np.abs(third))) / THIRD_DIFFERENCE


def _extrapolated(time: FloatArray, place: FloatArray, later: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Continue a parabola; with how many times the noise of one frame it errs there."""
    origin, span = time[-1], time[-1] - time[0]
    powers = np.vander((time - origin) / span, 3)
    ahead = np.vander((later - origin) / span, 3)
    inverse = np.linalg.pinv(powers)
    gain = ahead @ inverse
    return gain @ place, np.asarray(np.sqrt(1 + np.sum(gain**2, axis=1)))


def meeting_time(before: FloatArray, time: FloatArray, place: FloatArray, interval: float) -> float:
    """Moment at which the straight way after a kink leaves the path before it.

    Parameters
    ----------
    before : (2, 2) array
        Place and velocity with which the earlier path arrives at ``time[0]``.
    time, place : (n,) and (n, 2) arrays
        First frames after the kink.
    interval : float
        Time between frames, s: the meeting is looked for this long before the first of them, and a half.
    """
    since = time - time[0]
    slope, start = np.polyfit(since, place, 1)
    apart, closing = start - before[0], slope - before[1]
    moment = -float(apart @ closing) / max(float(closing @ closing), 1e-30)
    return float(time[0] + np.clip(moment, -1.5 * interval, 0.5 * interval))

"""Which frames show a struck ball at rest and then moving by itself, and when it meets something."""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from tracking.errors import RecordingError
from tracking.kink import first_kink, meeting_time
from tracking.slide import Seen, path
from tracking.strike import start_index
from tracking.track import Track

FloatArray = npt.NDArray[np.float64]

FEWEST_FRAMES = 8
MOST_REST = 60  # frames of rest that take part
MEETING_FRAMES = 5
MOMENT = 1e-4  # s, short against all that happens


@dataclass(frozen=True, slots=True, kw_only=True)
class FreeMotion:
    """First frame in which the ball has left its place, first frame after a later kink, what lies between.

    `seen` starts with the rest before; `last_rest` is the time of its last frame.
    """

    start: int
    kink: int | None
    last_rest: float
    seen: Seen


def upright(track: Track) -> Track:
    """Turn pixels so that y goes up."""
    return track if track.unit == "m" else replace(track, y=-track.y)


def free_motion(track: Track, gravity: float) -> FreeMotion:
    """Find the free motion of a struck ball.

    Parameters
    ----------
    track : Track
        y up.
    gravity : float
        In the unit of the track, over s².

    Raises
    ------
    RecordingError
        If the ball is not seen at rest, or in too few frames after the strike.
    """
    start = start_index(track.x, track.y, track.radius)
    if start is None:
        raise RecordingError(
            "the ball is not seen at rest before the strike; start the recording while it is at rest"
        )
    place = np.column_stack((track.x, track.y))
    kink = first_kink(track.time[start:], place[start:], float(np.median(track.x_sd)), gravity)
    end = len(place) if kink is None else start + kink - 1
    if end - start < FEWEST_FRAMES:
        raise RecordingError(
            f"the ball moves freely in {end - start} frames only before it meets something or leaves the "
            f"picture, but {FEWEST_FRAMES} are needed; record more frames a second or show more of the table"
        )
    first = max(0, start - MOST_REST)
    window = slice(first, end)
    sd = np.column_stack((track.x_sd, track.y_sd))
    sd[first:start] *= np.sqrt(start - first)  # the same picture again and again tells the place only once
    return FreeMotion(
        start=start,
        kink=None if kink is None else start + kink,
        last_rest=float(track.time[start - 1]),
        seen=Seen(
            time=track.time[window],
            place=place[window],
            sd=sd[window],
            radius=track.radius,
            gravity=gravity,
        ),
    )


def meeting(track: Track, motion: FreeMotion, parameters: FloatArray) -> float:
    """Moment at which the ball leaves the fitted path, s; NaN if it never does."""
    if motion.kink is None:
        return np.nan
    after = slice(motion.kink, motion.kink + MEETING_FRAMES)
    time = track.time[after]
    first, second = path(parameters, time[0] + np.array([-MOMENT, MOMENT]), motion.seen.gravity)
    arrival = np.array([(first + second) / 2, (second - first) / (2 * MOMENT)])
    interval = float(np.median(np.diff(track.time)))
    return meeting_time(arrival, time, np.column_stack((track.x, track.y))[after], interval)

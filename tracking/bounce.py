"""Where in a track the impacts lie, and which frames belong to the flight before and after each."""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
from scipy.signal import find_peaks

from tracking.track import Track

FloatArray = npt.NDArray[np.float64]
IndexArray = npt.NDArray[np.int64]

WINDOW = 0.12  # s of flight used on each side of an impact
FEWEST_WINDOW_FRAMES = 7  # ... or at least this many frames, where the camera is slow
FEWEST_FRAMES = 4  # a side with fewer cannot be fitted
PROMINENCE = 0.15  # of the ball's radius: a lower hop is not called a bounce


@dataclass(frozen=True, slots=True, kw_only=True)
class Bounce:
    """Indices into a track: the frames of the flights before and after one impact, in order of time."""

    before: IndexArray
    after: IndexArray


def find_bounces(track: Track) -> list[Bounce]:
    """Split a track (metres) at its lowest points; each must be followed by a rise one can see.

    Returns
    -------
    list of Bounce
        In order of time; empty if the ball never turns.
    """
    lowest = turns(track)
    edges = np.concatenate(([_release(track)], lowest, [len(track.y)]))
    bounces = []
    for number, turn in enumerate(lowest):
        before = np.arange(edges[number] + (number > 0), turn + 1)
        after = np.arange(turn, edges[number + 2])
        bounce = _split_at_impact(track, before, after)
        if bounce is not None:
            bounces.append(bounce)
    return bounces


def turns(track: Track) -> IndexArray:
    """Find the frames in which a ball (track in metres) is lowest, one for each bounce that one can see."""
    prominence = max(6 * float(np.median(track.y_sd)), PROMINENCE * track.radius)
    lowest, _ = find_peaks(-track.y, prominence=prominence)
    return np.asarray(lowest, dtype=np.int64)


def _release(track: Track) -> int:
    """First frame in which the ball has left the place where it was held."""
    turn = int(np.argmin(track.y[: max(2, _first_turn(track))]))
    held = float(track.y[: turn + 1].max())
    fallen = np.flatnonzero(
        track.y[: turn + 1] < held - max(5 * float(np.median(track.y_sd)), 0.1 * track.radius)
    )
    resting = np.flatnonzero(track.y[: turn + 1] == held)
    fallen = fallen[fallen > resting[-1]]
    return int(fallen[0]) if fallen.size else 0


def _first_turn(track: Track) -> int:
    """Index just behind the first lowest point of a fall."""
    lowest, _ = find_peaks(-track.y, prominence=PROMINENCE * track.radius)
    return int(lowest[0]) + 1 if lowest.size else len(track.y)


def _split_at_impact(track: Track, before: IndexArray, after: IndexArray) -> Bounce | None:
    """Keep the frames near the impact and give the lowest one to the side whose flight it lies on."""
    interval = float(np.median(np.diff(track.time)))
    impact = track.time[before[-1]]
    window = max(WINDOW, FEWEST_WINDOW_FRAMES * interval) + interval
    before = before[track.time[before] >= impact - window]
    after = after[track.time[after] <= impact + window]
    if len(before) < FEWEST_FRAMES + 1 or len(after) < FEWEST_FRAMES + 1:
        return None
    fall, rise = before[:-1], after[1:]
    impact = crossing(track, fall, rise)
    return Bounce(
        before=before[track.time[before] < impact - interval / 2],
        after=after[track.time[after] > impact + interval / 2],
    )


def until_next_meeting(bounce: Bounce, upper: Track, lower: Track) -> Bounce:
    """Leave out the frames after a falling ball has met the one below again.

    Neither flight nor a bounce of the lower ball on the plate makes a shrinking distance between them grow.
    """
    apart = upper.y[bounce.after] - np.interp(upper.time[bounce.after], lower.time, lower.y)
    noise = float(np.hypot(np.median(upper.y_sd), np.median(lower.y_sd)))
    nearest, _ = find_peaks(-apart, prominence=6 * noise)
    later = nearest[nearest >= FEWEST_FRAMES]  # where they have hardly parted, rims are misread
    return replace(bounce, after=bounce.after[: later[0]]) if later.size else bounce


def crossing(track: Track, fall: IndexArray, rise: IndexArray) -> float:
    """Time at which the paths before and after meet, from a parabola through the nearest frames of each."""
    origin = float(track.time[fall[-1]])
    falling = np.polynomial.Polynomial.fit(track.time[fall[-6:]] - origin, track.y[fall[-6:]], _degree(fall))
    rising = np.polynomial.Polynomial.fit(track.time[rise[:6]] - origin, track.y[rise[:6]], _degree(rise))
    roots = (falling.convert() - rising.convert()).roots()
    real = roots[np.abs(roots.imag) < 1e-9].real
    low, high = 0.0, float(track.time[rise[0]]) - origin
    inside = real[(real >= low - high) & (real <= 2 * high)]
    middle = high / 2
    return origin + (float(inside[np.argmin(np.abs(inside - middle))]) if inside.size else middle)


def _degree(side: IndexArray) -> int:
    """Curvature needs five frames."""
    return 2 if len(side) >= 5 else 1

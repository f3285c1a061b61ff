"""Two discs or balls seen from above that meet: find and track both."""

from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from tracking.errors import RecordingError
from tracking.follow import moving_balls
from tracking.outline import trace_outlines
from tracking.scale import Scale, to_metres
from tracking.track import Track
from tracking.video import Recording

TOUCHING = 1.25  # sums of radii at which two discs are taken to meet
SPEED_FRAMES = 6


@dataclass(frozen=True, slots=True, kw_only=True)
class PairTrack:
    """The disc that comes faster, and the one it meets."""

    striker: Track
    struck: Track


def track_pair(recording: Recording) -> PairTrack:
    """Track the two discs that meet.

    Raises
    ------
    RecordingError
        If fewer than two discs move, or no two of them meet.
    """
    balls = moving_balls(recording)
    name = recording.path.name
    if len(balls) < 2:
        raise RecordingError(
            f"{name}: {'only one disc moves' if balls else 'no disc moves'}, but an impact of two needs two "
            "that go further than their own width; film from above, both discs whole and in focus"
        )
    tracks = [trace_outlines("disc", ball).track for ball in balls]
    meeting = [pair for pair in combinations(tracks, 2) if closeness(*pair)[0] < TOUCHING]
    if not meeting:
        raise RecordingError(
            f"{name}: no two of the moving discs meet; check that the impact is in the picture"
        )
    first, second = min(meeting, key=lambda pair: closeness(*pair)[1])
    moment = closeness(first, second)[1]
    striker, struck = sorted((first, second), key=lambda track: -_speed_before(track, moment))
    return PairTrack(striker=replace(striker, ball="striker"), struck=replace(struck, ball="struck"))


def pair_to_metres(pair: PairTrack, scale: Scale) -> PairTrack:
    """Give both tracks in metres, y up."""
    return PairTrack(striker=to_metres(pair.striker, scale), struck=to_metres(pair.struck, scale))


def closeness(first: Track, second: Track) -> tuple[float, float]:
    """Smallest distance of two discs over the sum of their radii, and the moment of it."""
    common, one, other = np.intersect1d(first.frame, second.frame, return_indices=True)
    if not common.size:
        return np.inf, np.inf
    distance = np.hypot(first.x[one] - second.x[other], first.y[one] - second.y[other])
    index = int(np.argmin(distance))
    return float(distance[index] / (first.radius + second.radius)), float(first.time[one][index])


def _speed_before(track: Track, moment: float) -> float:
    """Speed of a disc shortly before a moment."""
    chosen = np.flatnonzero(track.time < moment)[-SPEED_FRAMES:]
    if len(chosen) < 2:
        return 0.0
    way = np.hypot(np.ptp(track.x[chosen]), np.ptp(track.y[chosen]))
    return float(way / np.ptp(track.time[chosen]))

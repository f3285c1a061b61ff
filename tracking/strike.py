"""A cue shot seen from above or at an angle: find the ball that is struck and track it, and the cue's tip."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from tracking.errors import RecordingError
from tracking.follow import Sighting, moving_balls
from tracking.outline import Outlines, trace_outlines
from tracking.rivals import CLICK_SHARE
from tracking.scale import Scale, to_metres
from tracking.tip import track_tip
from tracking.track import Track
from tracking.video import Recording

FloatArray = npt.NDArray[np.float64]

STARTED = 0.25  # radii from its place of rest: the ball has been struck
REST_FRAMES = 3
GONE_FRAMES = 3  # after the start, when the ball's direction shows
TOGETHER = 2.5  # frames within which two balls start together


@dataclass(frozen=True, slots=True, kw_only=True)
class ShotTrack:
    """What is seen of a shot.

    Attributes
    ----------
    ball : Track
        The cue ball, from rest.
    tip : Track or None
        The tip of the cue on its way to the ball, where it is seen.
    missing_tip : str
        Why it is not.
    lift : (n,) array
        Apparent radius in each of the ball's frames over what its place on the plane asks for, less 1: a
        ball that rises towards the camera looks larger.
    expected_radius : (n,) array
        Radius that its place on the plane asks for, px.
    perspective : float
        Change of the apparent radius that its way over the plane asks for, as a share.
    """

    ball: Track
    tip: Track | None
    missing_tip: str
    lift: FloatArray
    expected_radius: FloatArray
    perspective: float


def track_shot(recording: Recording, *, start_px: Sequence[float] | None = None) -> ShotTrack:
    """Track the ball at rest that starts to move first, and the cue's tip before.

    Parameters
    ----------
    recording : as `open_recording` gives it
    start_px : two floats, optional
        Where the struck ball rests (x, y in px), if several start to move.

    Returns
    -------
    ShotTrack
        In pixels, y down.

    Raises
    ------
    RecordingError
        If no ball starts to move (or none near `start_px`), if it moves already at the beginning, or if two
        start together.
    """
    balls = moving_balls(recording)
    name = recording.path.name
    if not balls:
        raise RecordingError(
            f"{name}: no ball found that starts to move; film the cloth from above with the ball whole, in "
            "focus and at least 10 px wide, and with more frames a second if it goes further than twice its "
            "width from one to the next"
        )
    struck = {start: ball for ball in balls if (start := _start(ball)) is not None}
    if not struck:
        raise RecordingError(
            f"{name}: no strike in the clip, the ball moves already in its first frame; start the recording "
            "while the ball is at rest"
        )
    ball = struck[_choose(struck, recording, start_px)]
    outlines = trace_outlines("cue ball", ball, hidden=_cue_side(ball))
    tip, reason = track_tip(recording, outlines.track, _started_frame(outlines))
    return ShotTrack(
        ball=outlines.track,
        tip=tip,
        missing_tip=reason,
        lift=outlines.seen_radius / outlines.expected_radius - 1,
        expected_radius=outlines.expected_radius,
        perspective=float(np.ptp(outlines.expected_radius)) / outlines.track.radius,
    )


def shot_to_metres(shot: ShotTrack, scale: Scale) -> ShotTrack:
    """Give the tracks of a shot in metres, y up.

    A ball's centre is one radius above the cloth. A scale marked on the cloth makes its lengths too large by
    the radius over the camera's height (1 to 2 %); marks at the noses of the cushions lie almost right.
    """
    tip = None if shot.tip is None else to_metres(shot.tip, scale)
    return replace(shot, ball=to_metres(shot.ball, scale), tip=tip)


def start_index(x: FloatArray, y: FloatArray, radius: float) -> int | None:
    """Find the first frame in which a ball has left its place of rest; None if it does not begin at rest."""
    rest = np.median(x[:REST_FRAMES]), np.median(y[:REST_FRAMES])
    away = np.hypot(x - rest[0], y - rest[1]) > STARTED * radius
    moved = np.flatnonzero(away)
    if not moved.size or moved[0] < REST_FRAMES:
        return None
    return int(moved[0])


def _start(ball: Sequence[Sighting]) -> int | None:
    """Give the number of the frame in which a ball starts to move."""
    x, y = np.array([(s.circle.x, s.circle.y) for s in ball]).T
    index = start_index(x, y, ball[0].circle.radius)
    return None if index is None else ball[index].frame


def _choose(struck: dict[int, list[Sighting]], recording: Recording, start_px: Sequence[float] | None) -> int:
    """Give the start of the ball that moves first, or of the one that was named."""
    places = {start: (ball[0].circle.x, ball[0].circle.y) for start, ball in struck.items()}
    if start_px is not None:
        return _nearest(places, recording, start_px)
    first, *later = sorted(places)
    if later and later[0] - first < TOGETHER:
        at = " and ".join(f"({places[s][0]:.0f}, {places[s][1]:.0f})" for s in (first, later[0]))
        raise RecordingError(
            f"{recording.path.name}: two balls start to move together, at {at} px; say with start_px where "
            "the struck one rests, or film one ball alone"
        )
    return first


def _nearest(places: dict[int, tuple[float, float]], recording: Recording, start_px: Sequence[float]) -> int:
    """Give the start of the ball that rests where a person says."""
    distance = {start: np.hypot(x - start_px[0], y - start_px[1]) for start, (x, y) in places.items()}
    nearest = min(distance, key=lambda start: distance[start])
    if distance[nearest] > CLICK_SHARE * max(recording.size):
        at = ", ".join(f"({x:.0f}, {y:.0f})" for x, y in places.values())
        raise RecordingError(
            f"{recording.path.name}: no ball starts to move near start_px "
            f"({start_px[0]:g}, {start_px[1]:g}); those that do rest at {at} px"
        )
    return nearest


def _cue_side(ball: Sequence[Sighting]) -> float:
    """Direction from the ball to the cue, rad from x to y down: the ball goes the other way."""
    circles = [sighting.circle for sighting in ball]
    start = start_index(np.array([c.x for c in circles]), np.array([c.y for c in circles]), circles[0].radius)
    rest, gone = circles[0], circles[min((start or 0) + GONE_FRAMES, len(circles) - 1)]
    return float(np.arctan2(rest.y - gone.y, rest.x - gone.x))


def _started_frame(outlines: Outlines) -> int:
    """Give the number of the frame in which the traced ball has left its place."""
    track = outlines.track
    index = start_index(track.x, track.y, track.radius)
    return int(track.frame[index if index is not None else 0])

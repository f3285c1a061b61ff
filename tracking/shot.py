"""`ShotTrack` → what the strike did: launch velocity, spin, cloth friction, and when the ball rolls.

What a path seen from above can tell, and what not: the velocity, and the slip of the lowest point over the
cloth, from what sliding takes from the velocity (two sevenths of the slip); with the velocity the slip gives
the spin about both horizontal axes. The spin about the vertical axis leaves no trace. If the ball rolls at
once there is no sliding to tell the friction; if it still slides at the end, only the friction is told.
"""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from tracking.cue_tip import CueTip, measure_tip
from tracking.errors import RecordingError
from tracking.flight import STANDARD_GRAVITY
from tracking.kink import first_kink, meeting_time
from tracking.slide import Q, Seen, path
from tracking.spin import PathValues, V, read_path
from tracking.strike import ShotTrack, start_index
from tracking.track import Track

FloatArray = npt.NDArray[np.float64]

FEWEST_FRAMES = 8
MOST_REST = 60  # frames of rest that take part
MEETING_FRAMES = 5
LIFTED = 0.025  # share by which a ball looks larger that leaves the cloth
PERSPECTIVE = 0.04  # change of the apparent radius along the path: not seen straight from above
POOR = 0.1  # radii that the frames lie off the path, from which it is not the path of a ball on cloth


@dataclass(frozen=True, slots=True, kw_only=True)
class Shot:
    """A cue shot as measured; what the recording does not tell is NaN, and a note says why.

    Lengths are in `unit` ("m", or "px" for a recording without a scale), x to the right and y up.

    Attributes
    ----------
    strike_time, strike_time_sd : float
        Moment of the strike, s.
    place : (2,) array
        Where the ball rested.
    velocity, angular_velocity : (2,) arrays
        Just after the strike, (x, y); angular velocity in rad/s.
    covariance : (4, 4) array
        Of the velocity and the angular velocity.
    friction, friction_sd : float
        Sliding friction coefficient of the cloth.
    rolling_time, rolling_time_sd : float
        Moment from which the ball rolls, s.
    rolling_place, rolling_place_sd : (2,) arrays
        Where it is then.
    meeting_time : float
        When it meets another ball or a cushion, s; the fit ends there. NaN if it does not.
    tip : CueTip or None
        Velocity and offset of the cue's tip at the strike.
    lift : float
        Largest share by which the ball looks larger than a ball on the cloth.
    jumps : bool
        Whether it leaves the cloth: the values then do not hold.
    frames : int
        Frames of the moving ball that were used.
    residual : float
        Root mean square distance of the frames from the path.
    notes : tuple of str
        What is missing or doubtful, and why.
    """

    unit: str
    strike_time: float
    strike_time_sd: float
    place: FloatArray
    velocity: FloatArray
    angular_velocity: FloatArray
    covariance: FloatArray
    friction: float
    friction_sd: float
    rolling_time: float
    rolling_time_sd: float
    rolling_place: FloatArray
    rolling_place_sd: FloatArray
    meeting_time: float
    tip: CueTip | None
    lift: float
    jumps: bool
    frames: int
    residual: float
    notes: tuple[str, ...]

    @property
    def velocity_sd(self) -> FloatArray:
        """Standard deviations of the velocity."""
        return np.asarray(np.sqrt(np.diag(self.covariance)[:2]))

    @property
    def angular_velocity_sd(self) -> FloatArray:
        """Standard deviations of the angular velocity, rad/s."""
        return np.asarray(np.sqrt(np.diag(self.covariance)[2:]))


def measure_shot(shot: ShotTrack, radius: float, *, scale_sd: float = 0.0) -> Shot:
    """Measure a shot by one fit to the ball's path from rest through sliding to rolling.

    Parameters
    ----------
    shot : ShotTrack
        In metres; in pixels all lengths stay in pixels, and gravity in pixels comes from the ball's radius.
    radius : float
        Radius of the ball, m.
    scale_sd : float
        Relative standard uncertainty of the scale.

    Raises
    ------
    RecordingError
        If the ball is not seen at rest, or in too few frames after the strike.
    """
    track = _upright(shot.ball)
    own_radius = radius if track.unit == "m" else track.radius
    gravity = STANDARD_GRAVITY * own_radius / radius
    start, kink = _free_motion(track, gravity)
    seen = _seen(track, slice(max(0, start - MOST_REST), None if kink is None else kink - 1), gravity)
    told = read_path(seen, float(track.time[start - 1]), own_radius, scale_sd=scale_sd)
    told = _without_perspective(told) if _at_an_angle(shot) else told
    values, sd = told.values, np.sqrt(np.diag(told.covariance))
    strike = float(values[V.STRIKE])
    place = told.fit.parameters[[Q.X, Q.Y]]
    tip = None if shot.tip is None else measure_tip(_upright(shot.tip), strike, place, own_radius)
    lift = _lift(shot, start, kink)
    velocity, spin = [V.VELOCITY_X, V.VELOCITY_Y], [V.SPIN_X, V.SPIN_Y]
    rolling = [V.ROLLING_X, V.ROLLING_Y]
    return Shot(
        unit=track.unit,
        strike_time=strike,
        strike_time_sd=float(sd[V.STRIKE]),
        place=place,
        velocity=values[velocity],
        angular_velocity=values[spin],
        covariance=told.covariance[np.ix_(velocity + spin, velocity + spin)],
        friction=float(values[V.FRICTION]),
        friction_sd=float(sd[V.FRICTION]),
        rolling_time=float(values[V.ROLLING_TIME]),
        rolling_time_sd=float(sd[V.ROLLING_TIME]),
        rolling_place=values[rolling],
        rolling_place_sd=sd[rolling],
        meeting_time=np.nan if kink is None else _meeting(track, kink, told, gravity),
        tip=tip,
        lift=lift,
        jumps=lift > LIFTED,
        frames=int(np.sum(told.fit.used & (seen.time > strike))),
        residual=told.fit.residual,
        notes=_notes(shot, told, tip, lift, own_radius),
    )


def _upright(track: Track) -> Track:
    """Turn pixels so that y goes up."""
    return track if track.unit == "m" else replace(track, y=-track.y)


def _free_motion(track: Track, gravity: float) -> tuple[int, int | None]:
    """Index of the first frame after the strike, and of the first after a later kink."""
    start = start_index(track.x, track.y, track.radius)
    if start is None:
        raise RecordingError(
            "the ball is not seen at rest before the strike; start the recording while it is at rest"
        )
    moving = slice(start, None)
    place = np.column_stack((track.x, track.y))[moving]
    kink = first_kink(track.time[moving], place, float(np.median(track.x_sd)), gravity)
    free = len(place) if kink is None else kink - 1
    if free < FEWEST_FRAMES:
        raise RecordingError(
            f"the ball rolls freely in {free} frames only before it meets something or leaves the picture, "
            f"but {FEWEST_FRAMES} are needed; record more frames a second or show more of the table"
        )
    return start, None if kink is None else start + kink


def _seen(track: Track, window: slice, gravity: float) -> Seen:
    """Take the frames of a window."""
    return Seen(
        time=track.time[window],
        place=np.column_stack((track.x, track.y))[window],
        sd=np.column_stack((track.x_sd, track.y_sd))[window],
        gravity=gravity,
    )


def _meeting(track: Track, kink: int, told: PathValues, gravity: float) -> float:
    """Moment at which the ball leaves the fitted path."""
    after = slice(kink, kink + MEETING_FRAMES)
    time = track.time[after]
    ends = path(told.fit.parameters, time[0] + np.array([-1e-4, 1e-4]), gravity)
    arrival = np.array([ends.mean(axis=0), (ends[1] - ends[0]) / 2e-4])
    interval = float(np.median(np.diff(track.time)))
    return meeting_time(arrival, time, np.column_stack((track.x, track.y))[after], interval)


def _lift(shot: ShotTrack, start: int, kink: int | None) -> float:
    """Largest share by which the ball looks larger than on the cloth, over a few frames in a row."""
    lift = shot.lift[start:kink]
    runs = np.lib.stride_tricks.sliding_window_view(lift, min(5, len(lift)))
    return float(np.median(runs, axis=1).max())


def _at_an_angle(shot: ShotTrack) -> bool:
    """Tell whether lengths in pixels mean different things along the path."""
    return shot.ball.unit == "px" and shot.perspective > PERSPECTIVE


def _without_perspective(told: PathValues) -> PathValues:
    """Keep the velocity in pixels only: the rest needs the plane."""
    values, covariance = told.values.copy(), told.covariance.copy()
    lost = [V.SPIN_X, V.SPIN_Y, V.FRICTION]
    values[lost] = np.nan
    covariance[lost, :] = np.nan
    covariance[:, lost] = np.nan
    return replace(told, values=values, covariance=covariance)


def _notes(
    shot: ShotTrack, told: PathValues, tip: CueTip | None, lift: float, radius: float
) -> tuple[str, ...]:
    """Say what is missing or doubtful, and why."""
    too_late = "the cue's tip is seen in too few frames before the strike; record more frames a second"
    notes = [
        (_at_an_angle(shot), "filmed at an angle: give four corners of the cloth for spin and friction"),
        (bool(told.stage.value), told.stage.value),
        (shot.tip is None, shot.missing_tip),
        (shot.tip is not None and tip is None, too_late),
        (lift > LIFTED, f"the ball leaves the cloth (it looks {lift:.1%} larger): a jump shot, not to be trusted"),
        (told.fit.residual > POOR * radius, "the path is not that of a ball on cloth; check camera and scale"),
    ]
    return tuple(note for applies, note in notes if applies)

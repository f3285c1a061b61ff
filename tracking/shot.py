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
from tracking.flight import STANDARD_GRAVITY
from tracking.free_motion import FreeMotion, free_motion, meeting, upright
from tracking.slide import Q, Seen, first_guess, fit_path, path
from tracking.spin import PathValues, V, read_path
from tracking.strike import ShotTrack

FloatArray = npt.NDArray[np.float64]

LIFT_FRAMES = 5
LIFTED = 0.025  # share by which a ball looks larger that leaves the cloth
PERSPECTIVE = 0.04  # change of the apparent radius along the path: not seen straight from above
OUTLINE_SD = 0.02  # an outline tells the radius no better than this share
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
    fitted : (m, 3) array
        Time and place (t, x, y) on the fitted path, in every frame from the strike to the end of the fit.
    notes : tuple of str
        What is missing or doubtful, and why.
    doubts : tuple of str
        Those of the notes for which the values are not to be trusted.
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
    fitted: FloatArray
    notes: tuple[str, ...]
    doubts: tuple[str, ...]

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
    track = upright(shot.ball)
    own_radius = radius if track.unit == "m" else track.radius
    gravity = STANDARD_GRAVITY * own_radius / radius
    motion = free_motion(track, gravity)
    told = _told_by_path(shot, motion, own_radius, scale_sd)
    values, sd = told.values, np.sqrt(np.diag(told.covariance))
    strike = float(values[V.STRIKE])
    place = told.fit.parameters[[Q.X, Q.Y]]
    tip = _tip(shot, strike, place, own_radius)
    lift = _lift(shot.lift[motion.start : motion.kink])
    doubts = _doubts(told, lift, own_radius)
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
        meeting_time=meeting(track, motion, told.fit.parameters),
        tip=tip,
        lift=lift,
        jumps=lift > LIFTED,
        frames=int(np.sum(told.fit.used & (motion.seen.time > strike))),
        residual=told.fit.residual,
        fitted=_fitted(motion.seen, told, strike),
        notes=(*_gaps(shot, told, tip), *doubts),
        doubts=doubts,
    )


def _told_by_path(shot: ShotTrack, motion: FreeMotion, radius: float, scale_sd: float) -> PathValues:
    """Read the shot from the ball's path; in pixels seen at an angle, its velocity only."""
    radius_sd = 0.0 if shot.ball.unit == "m" else OUTLINE_SD
    told = read_path(motion.seen, motion.last_rest, radius, scale_sd=scale_sd, radius_sd=radius_sd)
    return _in_perspective(motion.seen, told) if _at_an_angle(shot) else told


def _fitted(seen: Seen, told: PathValues, strike: float) -> FloatArray:
    """Sample the fitted path at the strike and in every later frame."""
    time = np.concatenate(([strike], seen.time[seen.time > strike]))
    return np.column_stack((time, path(told.fit.parameters, time, seen.gravity)))


def _tip(shot: ShotTrack, strike: float, place: FloatArray, radius: float) -> CueTip | None:
    """Measure the cue's tip; seen at an angle its offset could as well be height."""
    tip = None if shot.tip is None else measure_tip(upright(shot.tip), strike, place, radius)
    if tip is None or shot.perspective <= PERSPECTIVE:
        return tip
    return replace(tip, offset=np.nan, offset_sd=np.nan)


def _lift(lift: FloatArray) -> float:
    """Largest share by which the ball looks larger than on the cloth, over a few frames in a row."""
    runs = np.lib.stride_tricks.sliding_window_view(lift, min(LIFT_FRAMES, len(lift)))
    return float(np.median(runs, axis=1).max())


def _at_an_angle(shot: ShotTrack) -> bool:
    """Tell whether lengths in pixels mean different things along the path."""
    return shot.ball.unit == "px" and shot.perspective > PERSPECTIVE


def _in_perspective(seen: Seen, told: PathValues) -> PathValues:
    """Keep the velocity in pixels, from whatever parabola and line are seen: the rest needs the plane."""
    fit = fit_path(seen, first_guess(seen, float(told.values[V.STRIKE])), list(Q))
    kept = [V.STRIKE, V.VELOCITY_X, V.VELOCITY_Y]
    behind = [Q.STRIKE, Q.VELOCITY_X, Q.VELOCITY_Y]
    values, covariance = np.full(len(V), np.nan), np.full((len(V), len(V)), np.nan)
    values[kept] = fit.parameters[behind]
    covariance[np.ix_(kept, kept)] = fit.covariance[np.ix_(behind, behind)]
    return replace(told, values=values, covariance=covariance, fit=fit)


def _gaps(shot: ShotTrack, told: PathValues, tip: CueTip | None) -> tuple[str, ...]:
    """Say what is missing, and why."""
    too_late = "the cue's tip is seen in too few frames before the strike; record more frames a second"
    gaps = [
        (_at_an_angle(shot), "filmed at an angle: give four corners of the cloth for spin and friction"),
        (bool(told.stage.value) and not _at_an_angle(shot), told.stage.value),
        (shot.tip is None, shot.missing_tip),
        (shot.tip is not None and tip is None, too_late),
        (
            tip is not None and np.isnan(tip.offset),
            "filmed at an angle: height and side of the cue's contact look alike, so no offset is given",
        ),
    ]
    return tuple(gap for applies, gap in gaps if applies)


def _doubts(told: PathValues, lift: float, radius: float) -> tuple[str, ...]:
    """Say why the values are not to be trusted."""
    doubts = [
        (
            lift > LIFTED,
            f"the ball leaves the cloth (it looks {lift:.1%} larger): a jump shot, not to be trusted",
        ),
        (
            told.fit.residual > POOR * radius,
            "the path is not that of a ball on cloth; check camera and scale",
        ),
    ]
    return tuple(doubt for applies, doubt in doubts if applies)

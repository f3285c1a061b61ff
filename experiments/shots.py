"""Cue shots: recording → one row of the trial table."""

import itertools
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from calibrate.rows import correlation_column
from experiments.doubt import find_shot_doubt
from experiments.measured import Fit, Measured, only_seen
from experiments.rows import cells, empty_row, judgement
from experiments.scales import PIXELS, told_scale
from experiments.trial import Trial
from tracking.cue_tip import CueTip
from tracking.overlay import Moment, Scene, outline_of
from tracking.scale import Scale, scale_from_ball, to_pixels
from tracking.shot import PERSPECTIVE, Shot, measure_shot
from tracking.shutter import with_row_times
from tracking.strike import ShotTrack, shot_to_metres, track_shot
from tracking.video import Recording

FloatArray = npt.NDArray[np.float64]

POOL_BALL = 0.0286  # m, radius; taken where neither a diameter nor a scale is told
RADIUS_TOLERANCE = 0.1  # share by which outline and diameter may differ


def measure_shot_trial(measured: Measured, recording: Recording) -> None:
    """Track, scale and fit the recording of a cue shot."""
    trial = measured.trial
    seen = track_shot(recording, start_px=trial.start_px)
    tips = () if seen.tip is None else (outline_of(seen.tip),)
    measured.overlay = only_seen(outline_of(seen.ball, seen.expected_radius), *tips)
    scene = measure_seen(measured, _with_row_times(seen, recording, trial.camera.row_time))
    measured.overlay = replace(measured.overlay, scenes=(scene,))


def measure_seen(measured: Measured, seen: ShotTrack) -> Scene:
    """Scale and fit what is seen of a shot; give what the overlay tells of it."""
    trial = measured.trial
    scale, no_scale = _scale(trial, seen)
    scaled = seen if scale is None else shot_to_metres(seen, scale)
    measured.tracks = [track for track in (scaled.ball, scaled.tip) if track is not None]
    if scale is not None and not trial.camera.scale:
        measured.remarks.append(f"scale: {scale.source}")
    radius = _radius(measured, scaled)
    shot = measure_shot(scaled, radius, scale_sd=0.0 if scale is None else scale.relative_sd)
    if np.isfinite(shot.meeting_time):
        measured.remarks.append(
            f"the ball meets another ball or a cushion at {shot.meeting_time:.3f} s; the fit ends there"
        )
    measured.remarks += [note for note in shot.notes if note not in shot.doubts]
    reasons = [no_scale, _wrong_size(trial, seen, scaled, radius), *shot.doubts, find_shot_doubt(shot)]
    measured.rows = [_row(trial, shot, "; ".join(filter(None, reasons)))]
    measured.fits = [Fit(ball=scaled.ball.ball, path=shot.fitted)]
    return _scene(shot, scale or PIXELS)


def _with_row_times(seen: ShotTrack, recording: Recording, readout: float) -> ShotTrack:
    """Undo a rolling shutter."""
    tip = None if seen.tip is None else with_row_times(seen.tip, recording, readout)
    return replace(seen, ball=with_row_times(seen.ball, recording, readout), tip=tip)


def _scale(trial: Trial, seen: ShotTrack) -> tuple[Scale | None, str]:
    """Give the scale; or None, for a shot that stays in pixels, and why it does."""
    diameter = trial.body("ball").diameter
    scale = told_scale(trial) or (None if diameter is None else scale_from_ball(seen.ball, diameter))
    if seen.perspective > PERSPECTIVE and "corners_px" not in trial.camera.scale:
        return None, (
            f"lengths are in pixels, because the table is filmed at an angle (the ball's outline changes by "
            f"{seen.perspective:.0%} on its way), where one scale does not serve; give four corners of the "
            "cloth in an experiment.toml: corners_px, width, height"
        )
    if scale is None:
        return None, (
            "lengths are in pixels, because no scale is told; give --ball-diameter, --metres-per-pixel, or "
            "four corners of the cloth in an experiment.toml"
        )
    return scale, ""


def _radius(measured: Measured, scaled: ShotTrack) -> float:
    """Radius of the ball, m: told, or that of its outline, or a pool ball's."""
    diameter = measured.trial.body("ball").diameter
    if diameter is not None:
        return diameter / 2
    if scaled.ball.unit == "m" and scaled.perspective <= PERSPECTIVE:
        measured.remarks.append(
            f"the ball's diameter is not told; its outline is {2e3 * scaled.ball.radius:.1f} mm wide"
        )
        return scaled.ball.radius
    measured.remarks.append(
        f"the ball's diameter is not told; that of a pool ball, {2e3 * POOL_BALL:g} mm, is taken"
    )
    return POOL_BALL


def _wrong_size(trial: Trial, seen: ShotTrack, scaled: ShotTrack, radius: float) -> str:
    """Say that outline and diameter disagree; seen at an angle an outline is no length in the plane."""
    if scaled.ball.unit == "px" or seen.perspective > PERSPECTIVE or "corners_px" in trial.camera.scale:
        return ""
    if abs(scaled.ball.radius / radius - 1) <= RADIUS_TOLERANCE:
        return ""
    return (
        f"the ball looks {2e3 * scaled.ball.radius:.1f} mm wide but its diameter is told as "
        f"{2e3 * radius:.1f} mm; check the scale and the diameter"
    )


def _row(trial: Trial, shot: Shot, reason: str) -> dict[str, Any]:
    """One row of the trial table."""
    velocities = ("velocity_x", "velocity_y", "angular_velocity_x", "angular_velocity_y")
    return {
        **empty_row(trial),
        **judgement(reason),
        "impact": 1,
        "time": shot.strike_time,
        "time_sd": shot.strike_time_sd,
        "unit": shot.unit,
        **cells(
            velocities,
            [*shot.velocity, *shot.angular_velocity],
            [*shot.velocity_sd, *shot.angular_velocity_sd],
        ),
        **_correlations(velocities, shot.covariance),
        **({} if shot.tip is None else _tip_cells(shot.tip)),
        **cells(["friction"], [shot.friction], [shot.friction_sd]),
        "meeting_time": shot.meeting_time,
        **cells(["rolling_time"], [shot.rolling_time], [shot.rolling_time_sd]),
        **cells(["rolling_x", "rolling_y"], list(shot.rolling_place), list(shot.rolling_place_sd)),
        "start_x": shot.place[0],
        "start_y": shot.place[1],
        "lift": shot.lift,
        "frames_after": shot.frames,
        "residual": shot.residual,
    }


def _correlations(names: Sequence[str], covariance: FloatArray) -> dict[str, float]:
    """Tell how the errors of velocity and spin hang together: spin is read from how the velocity changes."""
    sd = np.sqrt(np.diag(covariance))
    return {
        correlation_column(names[one], names[other]): float(covariance[one, other] / (sd[one] * sd[other]))
        for one, other in itertools.combinations(range(len(names)), 2)
    }


def _tip_cells(tip: CueTip) -> dict[str, float]:
    """Tell what is seen of the cue: speed along its way, its direction (rad from x to y), contact offset."""
    speed = float(np.hypot(*tip.velocity))
    sd = float(np.hypot(*(tip.velocity * tip.velocity_sd)) / speed)
    return {
        **cells(["approach_velocity", "contact_offset"], [speed, tip.offset], [sd, tip.offset_sd]),
        "approach_direction": float(np.arctan2(tip.velocity[1], tip.velocity[0])),
    }


def _scene(shot: Shot, scale: Scale) -> Scene:
    """Tell the overlay the fitted path, and where the ball is struck, rolls and meets something."""
    path = to_pixels(scale, shot.fitted[:, 1:])
    places = {"strike": (shot.strike_time, shot.place), "meets": (shot.meeting_time, _place_of_meeting(shot))}
    if shot.rolling_time > shot.strike_time:
        places["rolls"] = (shot.rolling_time, shot.rolling_place)
    moments = tuple(
        Moment(
            time=time, place=to_pixels(scale, place[np.newaxis])[0], words=words, is_impact=words != "rolls"
        )
        for words, (time, place) in places.items()
        if np.isfinite(time)
    )
    return Scene(lines=tuple(_lines(shot)), curves=(path,), moments=moments)


def _place_of_meeting(shot: Shot) -> FloatArray:
    """Where the fitted path has led at the meeting, which may lie a little behind its last frame."""
    (earlier, *before), (last, *after) = shot.fitted[-2:]
    velocity = np.subtract(after, before) / (last - earlier)
    return np.asarray(after + velocity * (shot.meeting_time - last))


def _lines(shot: Shot) -> list[str]:
    """Results in words."""
    places = 4 if shot.unit == "m" else 0
    lines = [f"velocity {_pair(shot.velocity, shot.velocity_sd, places)} {shot.unit}/s, x right, y up"]
    if np.isfinite(shot.angular_velocity).all():
        lines.append(f"spin {_pair(shot.angular_velocity, shot.angular_velocity_sd, 2)} rad/s")
    events = [f"struck at {shot.strike_time:.3f} s"]
    if shot.rolling_time > shot.strike_time:
        events.append(f"rolls from {shot.rolling_time:.3f} s")
    if np.isfinite(shot.meeting_time):
        events.append(f"meets something at {shot.meeting_time:.3f} s")
    return [*lines, ", ".join(events)]


def _pair(values: Sequence[float] | FloatArray, sd: Sequence[float] | FloatArray, places: int) -> str:
    """Write a vector with its uncertainty."""
    numbers, deviations = (", ".join(f"{value:.{places}f}" for value in pair) for pair in (values, sd))
    return f"({numbers}) +/- ({deviations})"

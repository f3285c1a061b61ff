"""What is known of a trial besides its pictures, and how well: scale, air, rate, readout."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from experiments.scales import told_scale
from experiments.trial import Body, Trial
from tracking.budget import READOUT_SD, Budget
from tracking.depth import motion_in_depth, undone
from tracking.flight import STANDARD_GRAVITY, Air, Flight, flight_of_ball
from tracking.scale import Scale, local_scale, rescaled, scale_from_ball
from tracking.track import Track
from tracking.video import Recording

AIR = Air()
LIGHTEST = 80.0  # kg/m³, a ping-pong ball: air acts less on anything else that people drop
LIKE_THE_WALL = "part of the ball's rim is as bright as the wall"
PART_SEEN = f"in many frames {LIKE_THE_WALL}, so its size, which is the scale, is not seen well"
TELL_SCALE = (
    "tell the scale (--metres-per-pixel, or a ruler in experiment.toml), or film against another colour"
)
SCALES_AGREE = 0.03  # two scales further apart mean that ball and ruler are not equally far away
PART_AGREES = 0.08  # ... of which one is the size of a ball that is seen in part


def given_scale(trial: Trial) -> Scale | None:
    """Scale that does not need the ball; None if the ball is to tell it, which then has a diameter.

    Raises
    ------
    ValueError
        If nothing tells a scale.
    """
    scale = told_scale(trial)
    if scale is None and trial.body("upper").diameter is None:
        raise ValueError(
            f"{trial.video.name}: nothing tells how large a pixel is; give --ball-diameter or "
            "--metres-per-pixel"
        )
    return scale


def chosen_scale(trial: Trial, ball: Track) -> tuple[Scale, list[str]]:
    """Scale to use, the one given if there is one, and what to say about it.

    Parameters
    ----------
    trial : Trial
    ball : Track
        The upper ball, px.
    """
    given, diameter = given_scale(trial), trial.body("upper").diameter
    if given is None:
        seen = scale_from_ball(ball, diameter or 0.0)
        remarks = [f"scale: {seen.source}"]
        return seen, remarks if ball.shows_size else [*remarks, f"scale: {PART_SEEN}; {TELL_SCALE}"]
    if diameter is None:
        return given, []
    seen = scale_from_ball(ball, diameter)
    larger = float(diameter / 2 / ball.radius / np.median(local_scale(given, ball.x, ball.y))) - 1
    agree = SCALES_AGREE if ball.shows_size else PART_AGREES
    if abs(larger) <= max(agree, 2 * float(np.hypot(seen.relative_sd, given.relative_sd))):
        return given, []
    where = "behind" if larger < 0 else "before"
    remark = (
        f"two scales differ by {abs(larger):.1%}: {given.source}, but {seen.source}: what gave the scale "
        f"seems to be {where} the ball"
    )
    if not ball.shows_size:
        return given, [f"{remark}, or {LIKE_THE_WALL}; what was given is used"]
    if "metres_per_pixel" in trial.camera.scale:
        return given, [f"{remark}, or the diameter is wrong; check both"]
    seen = replace(rescaled(given, 1 + larger), relative_sd=seen.relative_sd)
    return seen, [f"{remark}; the ball's own size is used; put the ruler where the ball falls"]


def without_depth(ball: Track, recording: Recording) -> tuple[Track, list[str]]:
    """Undo a ball's motion towards the camera or away from it, and say so; `ball` in px."""
    depth = motion_in_depth(ball)
    remarks = []
    if depth.drifts:
        grows = depth.drift > 0
        verb, where = ("grows", "towards the camera") if grows else ("shrinks", "away from the camera")
        remarks.append(
            f"the {ball.ball} ball {verb} by {abs(depth.drift):.1%} ± {depth.drift_sd:.1%} along its path: "
            f"it moves {where}; its velocities are corrected for that"
        )
    if depth.tilts:
        larger = "larger" if depth.tilt > 0 else "smaller"
        remarks.append(
            f"the {ball.ball} ball looks {abs(depth.tilt):.0%} ± {depth.tilt_sd:.0%} {larger} at the bottom "
            "of its path than at the top: the camera is tilted; velocities are corrected for that, but a "
            "level camera needs no correction"
        )
    height, width = recording.size
    return undone(ball, depth, (width / 2, height / 2)) if remarks else ball, remarks


def flight_of(ball: Body, track: Track) -> tuple[Flight, list[str]]:
    """How a ball flies, through air if its mass is known, and what to say about it."""
    if ball.mass is None:
        remark = (
            f"the {track.ball} ball's mass is not told, so air is left out: "
            "a light ball's restitution reads low"
        )
        return Flight(gravity=STANDARD_GRAVITY), [remark]
    return flight_of_ball(ball.mass, _radius(ball, track), AIR), []


def untold_shutter(trial: Trial, change: float, scale: Scale, recording: Recording) -> list[str]:
    """Say what a rolling shutter of which nothing was told does; `change`: of velocity at the impact, m/s."""
    share = abs(1e-3 * change * _rows_a_metre(scale, recording))
    if trial.camera.readout is not None or share == 0:
        return []
    return [
        "nothing tells of a rolling shutter, so it is left out: each millisecond of --readout would change "
        f"the restitution by {share:.1%} (0 if the camera has none)"
    ]


def budget_of(trial: Trial, balls: Sequence[Track], scale: Scale, recording: Recording) -> Budget:
    """How well scale, rate, readout and air are known; `balls` in metres, upper first."""
    upper = trial.body("upper")
    radius = _radius(upper, balls[0])
    lightest = flight_of_ball(LIGHTEST * 4 / 3 * math.pi * radius**3, radius, AIR)
    return Budget(
        drag=AIR.drag_coefficient_sd / AIR.drag_coefficient,
        air=lightest if upper.mass is None else None,
        scale=scale.relative_sd,
        rate=recording.rate_sd,
        readout=READOUT_SD * trial.camera.row_time * _rows_a_metre(scale, recording),
    )


def _rows_a_metre(scale: Scale, recording: Recording) -> float:
    """Share of the picture's rows in a metre downwards; 0 where rows stand upright, in a turned picture."""
    height, width = recording.size
    size = height * float(local_scale(scale, np.array([width / 2]), np.array([height / 2]))[0])
    return float((1, 0, -1, 0)[recording.quarter_turns] / size)


def _radius(ball: Body, track: Track) -> float:
    """Radius as told, or as seen."""
    return ball.diameter / 2 if ball.diameter else track.radius

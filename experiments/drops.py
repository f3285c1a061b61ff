"""Drops on the plate, on a held ball, on a ball at rest: recording → rows of the trial table."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from calibrate.rows import VELOCITIES
from experiments.doubt import find_doubt, find_rest_doubt, find_size_doubt, gravity_is_wrong
from experiments.known import (
    SCALES_AGREE,
    budget_of,
    chosen_scale,
    flight_of,
    given_scale,
    untold_shutter,
    without_depth,
)
from experiments.measured import Fit, Measured, only_seen
from experiments.rates import likely_rate
from experiments.rows import cells, empty_row, judgement
from experiments.trial import Body, Trial
from tracking.bounce import turns
from tracking.budget import Budget
from tracking.errors import RecordingError
from tracking.flight import Flight, apex, position
from tracking.overlay import Moment, Scene, outline_of
from tracking.scale import Scale, local_scale, to_metres, to_pixels
from tracking.shutter import with_row_times
from tracking.track import Track, track_balls
from tracking.velocity import Impact, measure_impacts, measure_two_ball_impact
from tracking.video import Recording

FloatArray = npt.NDArray[np.float64]


def measure_drop(measured: Measured, recording: Recording) -> None:
    """Track, scale and fit the recording of a drop."""
    trial = measured.trial
    upper, lower = trial.body("upper"), trial.body("lower")
    expected = _expected_radius(given_scale(trial), upper, recording)
    lower_ratio, start_px = _lower_ratio(trial), trial.start_px
    tracks = track_balls(recording, radius=expected, lower=lower_ratio, start_px=start_px)
    if expected and abs(tracks[0].radius / expected - 1) > SCALES_AGREE:  # the ruler is nearer or farther
        tracks = track_balls(recording, lower=lower_ratio, start_px=start_px)
    measured.overlay = only_seen(*map(outline_of, tracks))
    swelling = find_size_doubt(tracks[0])
    tracks[0], remarks = without_depth(tracks[0], recording)
    scale, more_remarks = chosen_scale(trial, tracks[0])
    measured.remarks += remarks + more_remarks
    timed = [with_row_times(track, recording, trial.camera.row_time) for track in tracks]
    measured.tracks = [to_metres(track, scale) for track in timed]
    known = [flight_of(body, track) for body, track in zip((upper, lower), measured.tracks, strict=False)]
    measured.remarks += [remark for _, remarks in known for remark in remarks]
    flights = [flight for flight, _ in known]
    impacts = _impacts(trial, measured.tracks, flights, budget_of(trial, measured.tracks, scale, recording))
    measured.remarks += [] if trial.kind == "two" else _unmeasured(measured.tracks[0], impacts)
    change = float(np.ptp(impacts[0].velocities[:2]))
    measured.remarks += untold_shutter(trial, change, scale, recording)
    believed = recording.capture_fps
    wrong = any(map(gravity_is_wrong, impacts))
    likely = likely_rate(measured.tracks[0], flights[0], believed) if wrong else None
    unseen = given_scale(trial) is None and not tracks[0].shows_size
    doubts = [find_doubt(impact, believed, likely, unseen_scale=unseen) or swelling for impact in impacts]
    restless = find_rest_doubt(measured.tracks[1], impacts[0]) if trial.kind == "two" else ""
    measured.rows = [
        _row(trial, impact, restless or doubt, number)
        for number, (impact, doubt) in enumerate(zip(impacts, doubts, strict=True), start=1)
    ]
    fits = [_fits(impact, measured.tracks, flights) for impact in impacts]
    measured.fits = [fit for impact in fits for fit in impact]
    scenes = _scenes(measured, impacts, fits, scale)
    measured.overlay = replace(measured.overlay, scenes=scenes)


def _expected_radius(scale: Scale | None, ball: Body, recording: Recording) -> float | None:
    """Radius of the ball in px, where scale and diameter tell it."""
    if scale is None or ball.diameter is None:
        return None
    height, width = recording.size
    metres_per_pixel = local_scale(scale, np.array([width / 2]), np.array([height / 2]))
    return ball.diameter / 2 / float(metres_per_pixel[0])


def _lower_ratio(trial: Trial) -> float | None:
    """Radius of the lower ball over that of the upper one, for trials in which it moves."""
    if trial.kind != "two":
        return None
    upper, lower = trial.body("upper").diameter, trial.body("lower").diameter
    return lower / upper if upper and lower else 1.0


def _impacts(
    trial: Trial, tracks: Sequence[Track], flights: Sequence[Flight], budget: Budget
) -> list[Impact]:
    """Measure the impacts that the model speaks of: all bounces of one ball, the first of two."""
    if trial.kind == "two":
        impact = measure_two_ball_impact(tracks[0], tracks[1], flights, budget)
        impacts = [] if impact is None else [impact]
    else:
        impacts = measure_impacts(tracks[0], flights[0], budget)
    if not impacts:
        raise RecordingError(
            f"{trial.video.name}: the ball is seen but no impact: film until the ball has rebounded, with at "
            "least five frames before and after the impact (a higher frame rate helps)"
        )
    return impacts


def _unmeasured(track: Track, impacts: Sequence[Impact]) -> list[str]:
    """Tell the bounces that are seen but not measured; when the ball trembles at last, none is."""
    near = 1.5 * float(np.median(np.diff(track.time)))
    missed = [
        f"{time:.3f} s"
        for time in track.time[turns(track)]
        if time < impacts[-1].time and all(abs(time - impact.time) > near for impact in impacts)
    ]
    if not missed:
        return []
    return [
        f"the ball bounces at {', '.join(missed)} as well, but too little of its flight is seen for a "
        "velocity: drop it from higher, or record more frames a second"
    ]


def _restitution(impact: Impact) -> tuple[float, float]:
    """Give the coefficient of restitution on what does not move, and its standard deviation."""
    approach, rebound = impact.velocities[:2]
    slope = np.array([rebound / approach**2, -1 / approach])
    return float(-rebound / approach), float(np.sqrt(slope @ impact.covariance[:2, :2] @ slope))


def _row(trial: Trial, impact: Impact, doubt: str, number: int) -> dict[str, Any]:
    """One row of the trial table."""
    shared = {
        f"{name}_{source}": float(effect)
        for source, effects in impact.shared.items()
        for name, effect in zip(VELOCITIES, effects, strict=True)
    }
    return {
        **empty_row(trial),
        **judgement(doubt),
        "impact": number,
        "time": impact.time,
        **cells(VELOCITIES, list(impact.velocities), list(impact.sd)),
        **({} if trial.kind == "two" else cells(["restitution"], *zip(_restitution(impact), strict=True))),
        "gravity_check": impact.gravity_check,
        "gravity_check_sd": impact.gravity_check_sd,
        **cells([f"{name}_free" for name in VELOCITIES], list(impact.free_velocities), list(impact.free_sd)),
        "sideways_before": impact.sideways[0],
        "sideways_after": impact.sideways[1],
        "frames_before": impact.frames[0],
        "frames_after": impact.frames[1],
        "residual": impact.residual,
        **shared,
    }


def _scenes(
    measured: Measured, impacts: Sequence[Impact], fits: Sequence[Sequence[Fit]], scale: Scale
) -> tuple[Scene, ...]:
    """Tell the overlay one scene an impact, changing midway between two."""
    upper = measured.tracks[0]
    times = [impact.time for impact in impacts]
    starts = [-np.inf, *((before + after) / 2 for before, after in pairwise(times))]
    return tuple(
        Scene(
            since=start,
            lines=(
                f"impact {number} of {len(impacts)} at {impact.time:.4f} s",
                *_lines(impact, measured.rows[number - 1]),
            ),
            curves=tuple(to_pixels(scale, fit.path[:, 1:]) for fit in fits[number - 1]),
            moments=(_moment(impact, upper, scale, number),),
        )
        for number, (impact, start) in enumerate(zip(impacts, starts, strict=True), start=1)
    )


def _lines(impact: Impact, row: Mapping[str, Any]) -> list[str]:
    """Velocities in words, and restitution where the row has one."""
    names = ("before", "after", "lower ball after")
    told = zip(names, impact.velocities, impact.sd, strict=True)
    lines = [f"{name} {value:.4f} +/- {sd:.4f} m/s" for name, value, sd in told if np.isfinite(value)]
    if "restitution" in row:
        lines.append(f"restitution {row['restitution']:.3f} +/- {row['restitution_sd']:.3f}")
    return lines


def _moment(impact: Impact, upper: Track, scale: Scale, number: int) -> Moment:
    """Mark the impact where the falling ball touches what is below."""
    x = float(np.interp(impact.time, upper.time, upper.x))
    place = to_pixels(scale, np.array([[x, impact.height - upper.radius]]))[0]
    return Moment(time=impact.time, place=place, words=f"impact {number}")


def _fits(impact: Impact, tracks: Sequence[Track], flights: Sequence[Flight]) -> list[Fit]:
    """Give the fitted flights, m: fall, rebound, hop of the lower ball; sideways as it was seen."""
    upper, moment = tracks[0], np.array([impact.time])
    before = np.append(upper.time[upper.time < moment][-impact.frames[0] :], moment)
    after = np.append(moment, upper.time[upper.time > moment][: impact.frames[1]])
    parts = [(upper, before, 0, impact.height), (upper, after, 1, impact.height)]
    if len(tracks) > 1:
        lower = tracks[1]
        landing = impact.time + 2 * apex(flights[1], impact.velocities[2])[0]
        hop = np.union1d(after[after < landing], min(landing, after[-1]))
        parts.append((lower, hop, 2, float(np.median(lower.y[lower.time < moment]))))
    fits = []
    for track, time, which, height in parts:
        flight = flights[0 if track is upper else 1]
        rise = position(flight, impact.velocities[which], time - impact.time)
        path = np.column_stack((time, np.interp(time, track.time, track.x), height + rise))
        fits.append(Fit(ball=track.ball, path=path))
    return fits

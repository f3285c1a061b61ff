"""Recordings → trials.csv: the one place that joins tracking and calibrate."""

import csv
import io
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from joblib import Parallel, delayed

from calibrate.files import write_whole
from calibrate.rows import VELOCITIES, checked_row
from calibrate.trials import check_trials, write_trials
from experiments.doubt import find_doubt
from experiments.experiment import ExperimentError
from experiments.known import SCALES_AGREE, budget_of, chosen_scale, flight_of, given_scale, without_depth
from experiments.trial import Body, Trial
from tracking.budget import Budget
from tracking.errors import RecordingError
from tracking.flight import Flight
from tracking.scale import Scale, local_scale, to_metres
from tracking.shutter import with_row_times
from tracking.steady import steadied
from tracking.track import Track, track_balls
from tracking.velocity import Impact, measure_impacts, measure_two_ball_impact
from tracking.video import Recording, open_recording


@dataclass(slots=True, kw_only=True)
class Measured:
    """What became of one trial: rows for the trial table, tracks in metres, remarks for the person."""

    trial: Trial
    rows: list[dict[str, Any]] = field(default_factory=list)
    tracks: list[Track] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)


def process(trials: Sequence[Trial], out: Path, *, workers: int) -> Iterator[Measured]:
    """Measure all trials, yield each as it is done (in input order), then write `out`/trials.csv.

    Parameters
    ----------
    trials : the recordings
    out : folder for trials.csv and tracks/NAME.csv; made if missing
    workers : processes that work side by side

    Raises
    ------
    ExperimentError
        If `workers` is below 1, or `out` cannot be made.
    """
    if workers < 1:
        raise ExperimentError(f"workers must be at least 1, got {workers}")
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ExperimentError(f"{out}: cannot be made a folder for the results: {error.strerror}") from error
    table = []
    parallel = Parallel(n_jobs=min(workers, len(trials)), return_as="generator")
    for measured in parallel(delayed(measure)(trial) for trial in trials):
        if measured.tracks:
            write_whole(out / "tracks" / f"{measured.trial.name}.csv", _track_table(measured.tracks))
        table += measured.rows
        yield measured
    write_trials(check_trials(pd.DataFrame(table)), out / "trials.csv")


def measure(trial: Trial) -> Measured:
    """Measure one trial; whatever is wrong with it becomes a failed row that says why.

    Examples
    --------
    >>> measure(Trial(name="drop", video=Path("drop.mp4"), kind="plate")).rows[0]["reason"]
    'drop.mp4: no such file; check the spelling and the folder'
    """
    measured = Measured(trial=trial)
    try:
        _measure_into(measured)
    except (RecordingError, ValueError) as error:
        measured.rows = [_failed(trial, str(error))]
    except Exception as error:  # a fault of ours in one trial must not cost the others
        measured.rows = [_failed(trial, f"unexpected {type(error).__name__}: {error}; please report it")]
    measured.rows = [_judged(row) for row in measured.rows]
    return measured


def _measure_into(measured: Measured) -> None:
    """Track, scale and fit one recording."""
    trial = measured.trial
    if trial.kind not in ("plate", "held", "two"):
        raise ValueError(
            f"{trial.video.name}: kind {trial.kind!r} cannot be measured yet; plate, held and two can"
        )
    recording = steadied(open_recording(trial.video, capture_fps=trial.camera.capture_fps))
    measured.remarks += recording.notes
    upper, lower = trial.body("upper"), trial.body("lower")
    expected = _expected_radius(given_scale(trial), upper, recording)
    tracks = track_balls(recording, radius=expected, lower=_lower_ratio(trial))
    if expected and abs(tracks[0].radius / expected - 1) > SCALES_AGREE:  # a ruler nearer or farther
        tracks = track_balls(recording, lower=_lower_ratio(trial))
    tracks[0], remarks = without_depth(tracks[0], recording)
    scale, more_remarks = chosen_scale(trial, tracks[0])
    measured.remarks += remarks + more_remarks
    timed = [with_row_times(track, recording, trial.camera.readout) for track in tracks]
    measured.tracks = [to_metres(track, scale) for track in timed]
    known = [flight_of(body, track) for body, track in zip((upper, lower), measured.tracks, strict=False)]
    measured.remarks += [remark for _, remarks in known for remark in remarks]
    flights = [flight for flight, _ in known]
    impacts = _impacts(trial, measured.tracks, flights, budget_of(trial, measured.tracks, scale, recording))
    measured.rows = [_row(trial, impact, number, recording) for number, impact in enumerate(impacts, start=1)]


def _expected_radius(scale: Scale | None, ball: Body, recording: Recording) -> float | None:
    """Radius of the ball in px, where scale and diameter tell it."""
    if scale is None or ball.diameter is None:
        return None
    height, width = recording.samples[0].shape[:2]
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


def _row(trial: Trial, impact: Impact, number: int, recording: Recording) -> dict[str, Any]:
    """One row of the trial table."""
    reason = find_doubt(impact, recording.capture_fps)
    row = _empty_row(trial) | {
        "status": "suspect" if reason else "ok",
        "reason": reason,
        "impact": number,
        "time": impact.time,
        "gravity_check": impact.gravity_check,
        "gravity_check_sd": impact.gravity_check_sd,
        "sideways_before": impact.sideways[0],
        "sideways_after": impact.sideways[1],
        "frames_before": impact.frames[0],
        "frames_after": impact.frames[1],
        "residual": impact.residual,
    }
    for name, value, sd in zip(VELOCITIES, impact.velocities, impact.sd, strict=True):
        row |= {name: value, f"{name}_sd": sd}
    for source, effects in impact.shared.items():
        row |= {f"{name}_{source}": effect for name, effect in zip(VELOCITIES, effects, strict=True)}
    return row


def _judged(row: dict[str, Any]) -> dict[str, Any]:
    """Hold a row against the rules of the trial table here, where the others do not depend on it."""
    judged = checked_row(row, f"{row['trial']}, impact {row['impact']}")
    reasons = dict.fromkeys(filter(None, (judged["reason"], row["reason"])))
    return row | {"status": judged["status"], "reason": "; ".join(reasons)}


def _failed(trial: Trial, reason: str) -> dict[str, Any]:
    """Give the row of a trial that could not be measured."""
    return _empty_row(trial) | {"status": "failed", "reason": reason, "impact": 1}


def _empty_row(trial: Trial) -> dict[str, Any]:
    """Write down what is known of a trial before it is measured."""
    masses = (trial.body("upper").mass, trial.body("lower").mass if trial.kind != "plate" else None)
    velocities = {f"{name}{suffix}": None for name in VELOCITIES for suffix in ("", "_sd")}
    return {
        "trial": trial.name,
        "kind": trial.kind,
        "upper_mass": masses[0],
        "lower_mass": masses[1],
        **velocities,
    }


def _track_table(tracks: Sequence[Track]) -> str:
    """One line a frame and ball, in metres."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["frame", "time", "ball", "x", "y", "x_sd", "y_sd", "radius"])
    for track in tracks:
        for frame, time, *numbers in zip(
            track.frame, track.time, track.x, track.y, track.x_sd, track.y_sd, strict=True
        ):
            cells = [f"{number:.6g}" for number in (*numbers, track.radius)]
            writer.writerow([int(frame), f"{time:.6f}", track.ball, *cells])
    return text.getvalue()

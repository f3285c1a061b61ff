"""Recordings → trials.csv: the one place that joins tracking and calibrate."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd
from joblib import Parallel, delayed

from calibrate.files import write_whole
from calibrate.rows import checked_row
from calibrate.trials import check_trials, write_trials
from experiments.drops import measure_drop
from experiments.experiment import ExperimentError
from experiments.measured import DROPS, Measured, failed_row
from experiments.overlays import write_overlays
from experiments.pairs import measure_pair_trial
from experiments.shots import measure_shot_trial
from experiments.track_table import track_table
from experiments.trial import Trial
from tracking.errors import RecordingError
from tracking.steady import steadied
from tracking.video import open_recording

__all__ = ["Measured", "measure", "process"]

MEASURES = {**dict.fromkeys(DROPS, measure_drop), "shot": measure_shot_trial, "pair": measure_pair_trial}


def process(trials: Sequence[Trial], out: Path, *, workers: int, overlays: bool = True) -> Iterator[Measured]:
    """Measure all trials, yield each as it is done (in input order), then write `out`/trials.csv.

    Parameters
    ----------
    trials : the recordings
    out : folder for trials.csv, tracks/NAME.csv, overlays/NAME.mp4 and .png; made if missing
    workers : processes that work side by side
    overlays : whether to draw what was found on the recordings, which decodes them once more

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
    folder = out / "overlays" if overlays else None
    for measured in parallel(delayed(_measure_and_draw)(trial, folder) for trial in trials):
        if measured.tracks:
            write_whole(out / "tracks" / f"{measured.trial.name}.csv", track_table(measured.tracks))
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
        recording = steadied(open_recording(trial.video, capture_fps=trial.camera.capture_fps))
        measured.recording = recording
        measured.remarks += recording.notes
        MEASURES[trial.kind](measured, recording)
    except (RecordingError, ValueError) as error:
        measured.rows = [failed_row(trial, _named(trial, str(error)))]
    except Exception as error:  # a fault of ours in one trial must not cost the others
        reason = f"{trial.video.name}: unexpected {type(error).__name__}: {error}; please report it"
        measured.rows = [failed_row(trial, reason)]
    measured.rows = [_judged(row) for row in measured.rows]
    return measured


def _measure_and_draw(trial: Trial, folder: Path | None) -> Measured:
    """Measure one trial and write its overlays into `folder`; what cannot be drawn is a remark."""
    measured = measure(trial)
    if folder is not None and measured.recording is not None and measured.overlay is not None:
        try:
            write_overlays(measured.recording, measured.overlay, folder / trial.name)
        except Exception as error:  # what was measured holds without a picture of it
            measured.remarks.append(f"no overlay could be written: {type(error).__name__}: {error}")
    return replace(measured, recording=None)


def _named(trial: Trial, reason: str) -> str:
    """Begin a reason with the file it is about."""
    return reason if trial.video.name in reason else f"{trial.video.name}: {reason}"


def _judged(row: dict[str, Any]) -> dict[str, Any]:
    """Hold a row against the rules of the trial table here, where the others do not depend on it."""
    judged = checked_row(row, f"{row['trial']}, impact {row['impact']}")
    reasons = dict.fromkeys(filter(None, (judged["reason"], row["reason"])))
    return row | {"status": judged["status"], "reason": "; ".join(reasons)}

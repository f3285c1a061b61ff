"""One recording → what is kept of it: the one place that joins tracking and calibrate."""

import ctypes
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from calibrate.files import write_whole
from calibrate.rows import checked_row
from experiments.drops import measure_drop
from experiments.measured import Measured
from experiments.overlays import write_overlays
from experiments.pairs import measure_pair_trial
from experiments.record import Record, plain_fit, write_record
from experiments.rows import DROPS, failed_row
from experiments.shots import measure_shot_trial
from experiments.track_table import track_table
from experiments.trial import Trial
from tracking.errors import RecordingError
from tracking.steady import steadied
from tracking.video import open_recording

__all__ = ["Measured", "measure", "process"]

MEASURES = {**dict.fromkeys(DROPS, measure_drop), "shot": measure_shot_trial, "pair": measure_pair_trial}


def process(trial: Trial, told: dict[str, Any], out: Path) -> Record:
    """Measure one trial, write its track and overlay, and when all is there its record.

    Parameters
    ----------
    trial : Trial
    told : dict
        All that the results depend on, as `record.told_of` gives it.
    out : Path
        Folder of the run.
    """
    measured = measure(trial)
    files = []
    if measured.tracks:
        files.append(f"tracks/{trial.name}.csv")
        write_whole(out / files[0], track_table(measured.tracks))
    if told.get("overlays"):
        files += _draw(measured, out)
    record = Record(
        name=trial.name,
        kind=trial.kind,
        told=told,
        rows=measured.rows,
        remarks=measured.remarks,
        files=files,
        fits=[plain_fit(fit) for fit in measured.fits],
    )
    return write_record(record, out)


def measure(trial: Trial) -> Measured:
    """Measure one trial; whatever is wrong with it becomes a failed row that says why.

    Examples
    --------
    >>> measure(Trial(name="drop", video=Path("drop.mp4"), kind="plate")).rows[0]["reason"]
    'drop.mp4: no such file; check the spelling and the folder'
    """
    measured = Measured(trial=trial)
    try:
        recording = open_recording(trial.video, capture_fps=trial.camera.capture_fps)
        _give_memory_back()
        recording = steadied(recording)
        measured.recording = replace(recording, looks={}, pictures=(), kept=())  # drawing reads it again
        measured.remarks += recording.notes
        MEASURES[trial.kind](measured, recording)
    except MemoryError:
        raise  # for whoever set the limit
    except (RecordingError, ValueError) as error:
        measured.rows = [failed_row(trial, _named(trial, str(error)))]
    except Exception as error:  # a fault of ours in one trial must not cost the others
        reason = f"{trial.video.name}: unexpected {type(error).__name__}: {error}; please report it"
        measured.rows = [failed_row(trial, reason)]
    measured.rows = [_judged(row) for row in measured.rows]
    return measured


def _draw(measured: Measured, out: Path) -> list[str]:
    """Write the overlays, give their names in `out`; what cannot be drawn is a remark."""
    if measured.recording is None or measured.overlay is None:
        return []
    stem = f"overlays/{measured.trial.name}"
    _give_memory_back()
    try:
        endings = write_overlays(measured.recording, measured.overlay, out / stem)
    except Exception as error:  # what was measured holds without a picture of it
        measured.remarks.append(f"no overlay could be written: {type(error).__name__}: {error}")
        return []
    return [f"{stem}.{ending}" for ending in endings]


def _give_memory_back() -> None:
    """Give the system what was let go of; the C library of most Linux systems keeps it else."""
    with suppress(AttributeError, OSError, TypeError):  # others do so by themselves
        ctypes.CDLL(None).malloc_trim(0)


def _named(trial: Trial, reason: str) -> str:
    """Begin a reason with the file it is about."""
    return reason if trial.video.name in reason else f"{trial.video.name}: {reason}"


def _judged(row: dict[str, Any]) -> dict[str, Any]:
    """Hold a row against the rules of the trial table here, where the others do not depend on it."""
    judged = checked_row(row, f"{row['trial']}, impact {row['impact']}")
    reasons = dict.fromkeys(filter(None, (judged["reason"], row["reason"])))
    return row | {"status": judged["status"], "reason": "; ".join(reasons)}

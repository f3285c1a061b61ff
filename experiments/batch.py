"""Many trials: side by side none at the cost of another, and none done twice."""

from collections.abc import Generator, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import pandas as pd
from joblib import Parallel, delayed

from calibrate.trials import check_trials, write_trials
from experiments.apart import Limits, LostError, apart, end_helpers
from experiments.cluster import connected
from experiments.experiment import ExperimentError
from experiments.record import Record, finished_record, forget, lost_record, refuse_links, sweep, told_of
from experiments.trial import Trial


@dataclass(frozen=True, slots=True, kw_only=True)
class Batch:
    """How trials are processed.

    Attributes
    ----------
    out : Path
        Folder for trials.csv, trials/, tracks/, overlays/; made when missing.
    workers : int
        Trials measured side by side on this machine.
    overlays : bool
        Whether to draw what was found on the recordings, which decodes them once more.
    resume : bool
        Whether to keep what is finished already of the same recordings with the same options.
    limits : Limits
        What one trial may take.
    cluster : str or None
        Address of a Dask scheduler, ``tcp://host:port``, whose workers do the work instead; recordings and
        `out` must lie where all of them find them under the same path.

    Raises
    ------
    ExperimentError
        If `workers` is below 1.
    """

    out: Path
    workers: int = 1
    overlays: bool = True
    resume: bool = False
    limits: Limits = field(default_factory=Limits)
    cluster: str | None = None

    def __post_init__(self) -> None:
        if self.workers < 1:
            raise ExperimentError(f"workers must be at least 1, got {self.workers}")


def process_all(trials: Sequence[Trial], batch: Batch) -> Generator[Record, None, None]:
    """Process all trials, yield each as it is done, then write trials.csv in the order of the trials.

    The table is written as well if the work is interrupted: it then holds what was yielded until then.

    Parameters
    ----------
    trials : sequence of Trial
        Each with a name of its own.
    batch : Batch

    Raises
    ------
    ExperimentError
        If `out` cannot be made, or the cluster does not answer.
    ValueError
        If a folder in `out` is a link that leads elsewhere.
    """
    try:
        batch.out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ExperimentError(
            f"{batch.out}: cannot be made a folder for the results: {error.strerror}"
        ) from error
    refuse_links(batch.out)
    names = [trial.name for trial in trials]
    sweep(batch.out, names)
    done: dict[str, Record] = {}
    try:
        for record in _side_by_side(trials, batch):
            done[record.name] = record
            yield record
    finally:
        end_helpers(busy=len(done) < len(trials))
        sweep(batch.out, names)
        _write_table([done[name] for name in names if name in done], batch.out)


def in_order(records: Iterable[Record], trials: Sequence[Trial]) -> Iterator[Record]:
    """Hold records back until all trials before theirs are there."""
    waiting: dict[str, Record] = {}
    names = iter([trial.name for trial in trials])
    wanted = next(names, None)
    for record in records:
        waiting[record.name] = record
        while wanted in waiting:
            yield waiting.pop(wanted)
            wanted = next(names, None)


def process_one(trial: Trial, batch: Batch) -> Record:
    """Keep what is finished, or have one trial processed apart; whatever happens there becomes its row."""
    try:
        told = told_of(trial, overlays=batch.overlays)
        kept = finished_record(batch.out, trial.name, told) if batch.resume else None
        if kept is not None:
            return replace(kept, kept=True)
        forget(batch.out, trial.name)
        record: Record = apart("experiments.process:process", trial, told, batch.out, limits=batch.limits)
        return record
    except (LostError, OSError) as error:
        return lost_record(trial, f"{trial.video.name}: {error}")


def _side_by_side(trials: Sequence[Trial], batch: Batch) -> Iterator[Record]:
    """Do all trials, in any order; threads are enough, each waits for the process that does the work."""
    batch = replace(batch, out=batch.out.absolute())
    tasks = [delayed(process_one)(replace(trial, video=trial.video.absolute()), batch) for trial in trials]
    how: dict[str, Any] = {"return_as": "generator_unordered", "batch_size": 1}
    if batch.cluster is None:
        yield from Parallel(min(batch.workers, len(trials)), backend="threading", **how)(tasks)
        return
    with connected(batch.cluster):
        yield from Parallel(-1, **how)(tasks)


def _write_table(records: Iterable[Record], out: Path) -> None:
    """Write trials.csv, if there is anything to write."""
    rows = [row for record in records for row in record.rows]
    if rows:
        write_trials(check_trials(pd.DataFrame(rows)), out / "trials.csv")

"""What a run keeps of each finished trial: a small file, written last, by which it can go on after a stop."""

import hashlib
import json
import math
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import asdict, dataclass
from importlib.metadata import version
from numbers import Integral
from pathlib import Path
from typing import TYPE_CHECKING, Any

from calibrate.files import write_whole
from experiments.provenance import code_digest
from experiments.rows import failed_row
from experiments.trial import Trial

if TYPE_CHECKING:
    from experiments.measured import Fit

FOLDER = "trials"
FOLDERS = (FOLDER, "tracks", "overlays")
LEFT_OVER = re.compile(r"\.(?P<stem>.+)\.[a-z0-9_]{8}\.(json|csv|mp4|png)")
"""Names of files that `write_whole` had begun when its process was killed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Record:
    """One finished trial.

    Attributes
    ----------
    name, kind : str
        Of the trial.
    told : mapping
        All that its results depend on: version and code, SHA-256 of the recording, every option. None of it
        is told where the work was lost, so that it is done again.
    rows : list of dict
        For the trial table, one an impact.
    remarks : list of str
        For the person who made the recording.
    files : list of str
        What was written besides, relative to the folder of the run.
    fits : list of dict
        What was fitted to the tracks: `ball`, and columns `time`, `x`, `y`.
    kept : bool
        Whether it was measured by an earlier run; that is not written down.
    """

    name: str
    kind: str
    told: Mapping[str, Any]
    rows: Sequence[Mapping[str, Any]]
    remarks: Sequence[str] = ()
    files: Sequence[str] = ()
    fits: Sequence[Mapping[str, Any]] = ()
    kept: bool = False


def told_of(trial: Trial, *, overlays: bool) -> dict[str, Any]:
    """Collect all that the results of a trial depend on, as JSON knows it; empty without its recording."""
    if not trial.video.is_file():  # to open a pipe would wait for ever
        return {}
    try:
        with trial.video.open("rb") as file:
            content = hashlib.file_digest(file, "sha256").hexdigest()
    except OSError:
        return {}
    known = asdict(trial) | {"video": trial.video.name, "sha256": content, "overlays": overlays}
    known |= {"version": version("impactlab"), "code": code_digest()}
    return dict(json.loads(json.dumps(known, sort_keys=True)))


def lost_record(trial: Trial, reason: str) -> Record:
    """Give the record of a trial whose work was lost."""
    return Record(name=trial.name, kind=trial.kind, told={}, rows=plain([failed_row(trial, reason)]))


def write_record(record: Record, out: Path) -> Record:
    """Write a record to its place in `out`, and give it as it will be read again."""
    known = asdict(record)
    del known["kept"]
    text = json.dumps(plain(known), indent=1, ensure_ascii=False, allow_nan=False)
    write_whole(_place(out, record.name), text + "\n")
    return Record(**json.loads(text))


def read_record(out: Path, name: str) -> Record | None:
    """Read what is kept of a trial; None if there is nothing, or nothing this version can read."""
    try:
        return Record(**json.loads(_place(out, name).read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError):
        return None


def finished_record(out: Path, name: str, told: Mapping[str, Any]) -> Record | None:
    """Read what is kept of a trial if it was told the same and all its files are there."""
    record = read_record(out, name)
    if record is None or not told or record.told != told:
        return None
    return record if all((out / file).is_file() for file in record.files) else None


def forget(out: Path, name: str) -> None:
    """Remove the record of a trial that begins anew: its files are about to change."""
    _place(out, name).unlink(missing_ok=True)


def refuse_links(out: Path) -> None:
    """Make sure that results stay in `out`: what was unpacked there by somebody else may hold links.

    Raises
    ------
    ValueError
        If a folder of results is a link that leads elsewhere, or no folder.
    """
    home = out.resolve()
    for folder in (out / name for name in FOLDERS):
        if folder.is_symlink() and home not in folder.resolve().parents:
            raise ValueError(
                f"{folder} must lie in {out}, but is a link to {folder.resolve()}; remove the link, or give "
                "another --out"
            )
        if folder.exists() and not folder.is_dir():
            raise ValueError(f"{folder} must be a folder, but is a file; remove it, or give another --out")


def sweep(out: Path, names: Collection[str]) -> None:
    """Remove files of these trials that were begun by a process which was then killed."""
    for folder in FOLDERS:
        for path in (out / folder).glob(".*"):
            found = LEFT_OVER.fullmatch(path.name)
            if found and found["stem"] in names:
                path.unlink(missing_ok=True)


def plain_fit(fit: "Fit") -> dict[str, Any]:
    """Give a fit as columns; six digits are finer than any picture."""
    columns = ([float(f"{number:.6g}") for number in column] for column in fit.path.T)
    return {"ball": fit.ball, **dict(zip(("time", "x", "y"), columns, strict=True))}


def _place(out: Path, name: str) -> Path:
    return out / FOLDER / f"{name}.json"


def plain(value: Any) -> Any:
    """Turn numbers of any make into those of JSON, which has no NaN."""
    if isinstance(value, Mapping):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if value is None or isinstance(value, (str, bool)):
        return value
    if isinstance(value, Integral):
        return int(value)
    return float(value) if math.isfinite(value) else None

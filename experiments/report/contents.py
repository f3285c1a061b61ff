"""The folder of a run → what its page shows."""

import base64
import json
from collections.abc import Iterator, Mapping, Sequence
from importlib.metadata import version
from itertools import groupby
from pathlib import Path
from typing import Any
from urllib.parse import quote

import pandas as pd

from calibrate.estimate import Calibration, Estimate
from calibrate.report import rounded
from calibrate.rows import STATUSES
from calibrate.trials import read_trials
from experiments.console import columns_of
from experiments.experiment import ExperimentError
from experiments.provenance import read_commands, sha256
from experiments.record import Record, plain, read_record
from experiments.report.chart import Chart, chart_of
from experiments.report.numbers import numbers_of
from experiments.report.views import Contents, Fitted, Impact, Table, TrialView

FIGURES = {
    "fig5": "Rebound velocities over approach speed: dots are trials, lines and bands the fit, dashed lines "
    "the paper's model (its Fig. 5).",
    "profile": "Chi-square over the stiffness ratio; shaded are the 68 % and 95 % sets.",
    "contours": "Chi-square over stiffness ratio and ball-ball restitution.",
    "restitution": "Restitution over approach speed.",
}
DROP_PARAMETERS = {
    "stiffness_ratio": "stiffness ratio k₂/k₁ (ball-table over ball-ball)",
    "restitution_ball_ball": "restitution e₁, ball on ball",
    "restitution_ball_table": "restitution e₂, ball on table",
}


def contents_of(out: Path) -> Contents:
    """Collect what lies in a folder.

    Raises
    ------
    ExperimentError
        If there is nothing to report.
    """
    fits = [*_drop_fit(out), *_shot_fit(out)]
    figures = [(_embedded(out / f"{name}.svg"), words) for name, words in FIGURES.items() if _has(out, name)]
    tables = _tables(out) if (out / "trials.csv").is_file() else []
    if not (fits or figures or tables):
        raise ExperimentError(f"{out}: holds no results; name the folder that process or fit wrote to")
    return Contents(
        version=version("impactlab"),
        fits=fits,
        figures=figures,
        tables=tables,
        commands=read_commands(out),
    )


def _has(out: Path, figure: str) -> bool:
    return (out / f"{figure}.svg").is_file()


def _embedded(picture: Path) -> str:
    """Give a drawing as an address that holds all of it."""
    return f"data:image/svg+xml;base64,{base64.b64encode(picture.read_bytes()).decode()}"


def _drop_fit(out: Path) -> Iterator[Fitted]:
    """Read fit.json, if it is there."""
    if not (out / "fit.json").is_file():
        return
    calibration = Calibration.from_json((out / "fit.json").read_text(encoding="utf-8"))
    made_from = calibration.provenance.get("inputs", {})
    now = sha256(out / "trials.csv") if (out / "trials.csv").is_file() else ""
    stale = bool(now) and made_from.get("trials.csv", now) != now
    fit = f"chi-square {calibration.chi_square:.1f} for {calibration.degrees_of_freedom} degrees of freedom"
    yield Fitted(
        headline=_headline(calibration.stiffness_ratio) + calibration.caveat,
        estimates=[(words, str(getattr(calibration, name))) for name, words in DROP_PARAMETERS.items()],
        notes=[*([fit] if calibration.degrees_of_freedom > 0 else []), *calibration.notes],
        warning="this fit was made from another trials.csv; run impactlab fit again" if stale else "",
        made_from=calibration.provenance,
    )


def _headline(ratio: Estimate) -> str:
    """Give the verdict on the stiffness ratio in a line."""
    if ratio.value is None or ratio.sd is None:
        return f"Stiffness ratio k₂/k₁: {ratio.verdict}"
    return f"Stiffness ratio k₂/k₁ = {rounded(ratio.value, ratio.sd)}: {ratio.verdict}"


def _shot_fit(out: Path) -> Iterator[Fitted]:
    """Read shot_fit.json, if it is there."""
    if not (out / "shot_fit.json").is_file():
        return
    told = json.loads((out / "shot_fit.json").read_text(encoding="utf-8"))
    estimates = [(name.replace("_", " "), str(Estimate(**one))) for name, one in told["estimates"].items()]
    fixed = [(name.replace("_", " "), f"fixed at {value:g}") for name, value in told["fixed"].items()]
    yield Fitted(
        headline=f"Contacts of {told['shots']} cue shots", estimates=[*estimates, *fixed], notes=told["notes"]
    )


def _tables(out: Path) -> list[Table]:
    """Read trials.csv and what is kept of its trials; a table for each set of columns."""
    rows = plain(read_trials(out / "trials.csv").to_dict("records"))
    tables: dict[Sequence[str], list[TrialView]] = {}
    for number, (_, group) in enumerate(groupby(rows, key=lambda row: row["trial"])):
        impacts = list(group)
        heads, _ = columns_of(impacts[0]["kind"])
        tables.setdefault(heads, []).append(_trial(f"trial-{number}", impacts, out))
    return [Table(heads=heads, trials=trials) for heads, trials in tables.items()]


def _trial(anchor: str, rows: Sequence[Mapping[str, Any]], out: Path) -> TrialView:
    """Join the rows of a trial with its record, if that holds the same rows."""
    name, kind, statuses = str(rows[0]["trial"]), rows[0]["kind"], [row["status"] for row in rows]
    record = read_record(out, name)
    if record is None or [row["status"] for row in record.rows] != statuses:
        record = Record(name=name, kind=kind, told={}, rows=[])  # it is lost, or of another run
    told = {key: value for key, value in record.told.items() if key not in ("sha256", "name")}
    return TrialView(
        anchor=anchor,
        name=name,
        kind=kind,
        status=max(statuses, key=STATUSES.index),
        impacts=[_impact(row) for row in rows],
        remarks=record.remarks,
        chart=_chart(record, out),
        film=_link(record, "overlays/", ".mp4"),
        sheet=_link(record, "overlays/", ".png"),
        track=_link(record, "tracks/", ".csv"),
        told=json.dumps(told, indent=1, ensure_ascii=False) if told else "",
        sha256=record.told.get("sha256", ""),
    )


def _impact(row: Mapping[str, Any]) -> Impact:
    _, cells_of = columns_of(row["kind"])
    failed = row["status"] == "failed"
    return Impact(
        number=int(row["impact"]),
        status=row["status"],
        reason=row["reason"],
        cells=cells_of(row),
        numbers=[] if failed else list(numbers_of(row)),
    )


def _link(record: Record, folder: str, ending: str) -> str:
    """Give the address of a file, from the page; nothing that leads elsewhere."""
    wanted = f"{folder}{record.name}{ending}"
    return quote(wanted) if wanted in record.files else ""


def _chart(record: Record, out: Path) -> Chart | None:
    """Draw a track that is there."""
    track = out / "tracks" / f"{record.name}.csv"
    if not _link(record, "tracks/", ".csv") or not track.is_file():
        return None
    return chart_of(pd.read_csv(track), record.fits, record.kind)

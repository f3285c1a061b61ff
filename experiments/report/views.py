"""What the page of a run shows, ready to be printed."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from experiments.report.chart import Chart


@dataclass(frozen=True, slots=True, kw_only=True)
class Fitted:
    """What a fit says: (name, estimate in words) a parameter, notes, a warning if the trials are others."""

    headline: str
    estimates: Sequence[tuple[str, str]]
    notes: Sequence[str]
    warning: str = ""
    made_from: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class Impact:
    """One row of the table: cells as on the console, all numbers, status and reason."""

    number: int
    status: str
    reason: str
    cells: Sequence[str]
    numbers: Sequence[tuple[str, str]]


@dataclass(frozen=True, slots=True, kw_only=True)
class TrialView:
    """One trial: impacts, remarks, drawings, where its film and its sheet are, what it was told.

    `anchor` names its place on the page, which its own name could not.
    """

    anchor: str
    name: str
    kind: str
    status: str
    impacts: Sequence[Impact]
    remarks: Sequence[str] = ()
    chart: Chart | None = None
    film: str = ""
    sheet: str = ""
    track: str = ""
    told: str = ""
    sha256: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """Trials with the same columns."""

    heads: Sequence[str]
    trials: Sequence[TrialView]


@dataclass(frozen=True, slots=True, kw_only=True)
class Contents:
    """All a page shows; `figures` are (address, caption), `commands` what was called, by verb."""

    version: str
    fits: Sequence[Fitted]
    figures: Sequence[tuple[str, str]]
    tables: Sequence[Table]
    commands: Mapping[str, Mapping[str, Any]]

    @property
    def trials(self) -> list[TrialView]:
        """All trials."""
        return [trial for table in self.tables for trial in table.trials]

    def count(self, status: str) -> int:
        """Count the trials of a status."""
        return sum(trial.status == status for trial in self.trials)

"""What a person at a terminal sees while recordings are processed: progress, remarks, one line an impact."""

import sys
from collections.abc import Iterable, Iterator
from typing import TypeVar

from experiments.process import Measured

Item = TypeVar("Item")


def header(names: Iterable[str]) -> tuple[str, int]:
    """Headline of the table of impacts, and the width of its first column."""
    width = max(map(len, (*names, "trial")))
    columns = f"{'kind':<6} {'n':>2}  {'before':>9} {'after':>9} {'lower':>9}  {'gravity':>7}  status"
    return f"{'trial':<{width}}  {columns}", width


def progress(items: Iterable[Item], total: int, what: str, *, quiet: bool) -> Iterator[Item]:
    """Pass items through and draw a bar on stderr; silent when asked to be, or when nobody watches."""
    if quiet or not sys.stderr.isatty():
        yield from items
        return
    from rich.console import Console
    from rich.progress import track

    yield from track(items, description=what, total=total, console=Console(stderr=True), transient=True)


def impact_lines(measured: Measured, width: int) -> Iterator[str]:
    """Give one line for each impact of a trial: velocities in m/s, gravity check, status."""
    for row in measured.rows:
        names = ("approach", "upper_rebound", "lower_rebound")
        velocities = " ".join(f"{_number(row.get(f'{name}_velocity')):>9}" for name in names)
        trial, check = measured.trial, _number(row.get("gravity_check"))
        start = f"{trial.name:<{width}}  {trial.kind:<6} {row['impact']:>2}"
        yield f"{start}  {velocities}  {check:>7}  {row['status']}"


def complaints(measured: Measured) -> Iterator[str]:
    """Remarks on a recording, and the reason of each impact that is not ok."""
    yield from (f"{measured.trial.name}: {remark}" for remark in measured.remarks)
    for row in measured.rows:
        if row["status"] != "ok":
            yield f"{measured.trial.name}, impact {row['impact']}: {row['status']}: {row['reason']}"


def _number(value: float | None) -> str:
    """Four decimals are more than a camera tells; nothing where nothing was measured."""
    return "" if value is None or value != value else f"{value:.4f}"

"""Restitution measured without a camera: tables of rebound heights, or of times between bounces.

Quantities carry their unit in the column's name, ``h0_cm`` or ``dt_ms``:

=============================  ===========================================================
`h0`, `drop_height`            height the ball was let go from: m, cm, mm
`h1`, `rebound_height`         height it came back to: m, cm, mm
`dt`, `interval`               time between two bounces that follow each other: s, ms
`ball`, `ball_surface`         which ball on what; one of each kind is fitted by itself
`interval_no`                  number of the interval within its launch, 1 for the first
`launch`, `repeat`             tell launches and repeated readings apart
=============================  ===========================================================
"""

import math
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from calibrate.cells import read_cells
from calibrate.rows import TrialTableError

_UNITS = {"length": {"m": 1.0, "cm": 0.01, "mm": 0.001}, "time": {"s": 1.0, "ms": 0.001}}
_QUANTITIES = {
    "h0": ("drop_height", "length"),
    "drop_height": ("drop_height", "length"),
    "h1": ("rebound_height", "length"),
    "rebound_height": ("rebound_height", "length"),
    "dt": ("interval", "time"),
    "interval": ("interval", "time"),
}
_LABELS = {
    "ball": "ball",
    "ball_surface": "ball",
    "interval_no": "number",
    "launch": "launch",
    "repeat": "launch",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Readings:
    """One table, understood.

    Attributes
    ----------
    heights : pandas.DataFrame
        `ball`, `drop_height`, `rebound_height` (m); empty if the table holds intervals.
    intervals : pandas.DataFrame
        `ball`, `drop_height` (m, NaN where not told), `launch`, `number`, `interval` (s).
    failed : tuple of str
        A sentence for each line that could not be used.
    """

    heights: pd.DataFrame
    intervals: pd.DataFrame
    failed: tuple[str, ...]


def holds_readings(path: str | Path) -> bool:
    """Whether a file is a table of rebound heights or bounce intervals rather than of trials."""
    header = read_cells(path).columns
    return "kind" not in header and any(
        column == name or column.startswith(f"{name}_")
        for column in header
        for name, (quantity, _) in _QUANTITIES.items()
        if quantity != "drop_height" and column not in _LABELS
    )


def read_readings(path: str | Path) -> Readings:
    r"""Read rebound heights or bounce intervals.

    Parameters
    ----------
    path : str or Path
        CSV with a header line; see the table of columns above.

    Raises
    ------
    TrialTableError
        If a quantity's unit is missing or unknown, a needed column is missing, or no line is usable.

    Examples
    --------
    >>> import tempfile
    >>> path = Path(tempfile.mkdtemp()) / "heights.csv"
    >>> _ = path.write_text("ball,h0_cm,h1_cm\nred,50,42\nred,50,60\n")
    >>> readings = read_readings(path)
    >>> readings.heights.rebound_height.tolist()
    [0.42]
    >>> print(readings.failed[0])
    heights.csv, line 3: rebound height 0.6 m is above drop height 0.5 m
    """
    path = Path(path)
    cells = read_cells(path)
    columns = {column: _understood(path.name, column) for column in cells}
    needed = _needed(path.name, {name for name, _ in columns.values()})
    rows, failed = [], []
    for line, row in zip(cells.index, cells.to_dict("records"), strict=True):
        reading = {name: _value(row[column], factor) for column, (name, factor) in columns.items() if name}
        broken = _broken_rule(reading, needed)
        if broken:
            failed.append(f"{path.name}, line {line}: {broken}")
        else:
            rows.append(reading)
    if not rows:
        raise TrialTableError(failed[0] if failed else f"{path.name} holds no reading")
    table = pd.DataFrame(rows).reindex(
        columns=["ball", "drop_height", "rebound_height", "launch", "number", "interval"]
    )
    table["ball"] = table["ball"].fillna("ball")
    empty = table.iloc[:0]
    of_heights = "rebound_height" in needed
    return Readings(
        heights=table if of_heights else empty, intervals=empty if of_heights else table, failed=tuple(failed)
    )


def _understood(file: str, column: str) -> tuple[str, float]:
    """Name of what a column holds and the factor to SI (0 for text); an empty name if it is nothing known."""
    if column in _LABELS:
        return _LABELS[column], 0.0
    for name, (quantity, dimension) in _QUANTITIES.items():
        units = _UNITS[dimension]
        known = ", ".join(units)
        if column == name:
            raise TrialTableError(
                f"{file}: column {column!r} must say its unit, such as {name}_{known.split(', ')[-1]}"
            )
        if column.startswith(f"{name}_"):
            unit = column.removeprefix(f"{name}_")
            if unit not in units:
                raise TrialTableError(f"{file}: unit in {column!r} must be one of {known}, got {unit!r}")
            return quantity, units[unit]
    return "", 0.0


def _needed(file: str, there: set[str]) -> tuple[str, ...]:
    needed = ("drop_height", "rebound_height") if "rebound_height" in there else ("number", "interval")
    for name in needed:
        if name not in there:
            spelled = [column for column, (quantity, _) in _QUANTITIES.items() if quantity == name]
            example = f"{spelled[0]}_cm" if spelled else "interval_no"
            raise TrialTableError(f"{file} has no column of {name.replace('_', ' ')}, such as {example}")
    return needed


def _value(cell: str, factor: float) -> str | float:
    """Text as it is, a number in SI; NaN for a cell that is none."""
    if not factor:
        return cell.strip()
    try:
        return float(cell) * factor
    except ValueError:
        return math.nan


def _broken_rule(reading: dict[str, str | float], needed: tuple[str, ...]) -> str:
    for name in needed:
        value, words = reading[name], name.replace("_", " ")
        if name == "number":
            if not str(value).isdigit():
                return f"interval_no must be a whole number, got {value!r}"
            reading[name] = int(value)
        elif not (isinstance(value, float) and 0 < value < math.inf):
            return f"{words} must be a number above zero"
    if "rebound_height" in needed and float(reading["rebound_height"]) > float(reading["drop_height"]):
        heights = f"{reading['rebound_height']:g} m is above drop height {reading['drop_height']:g} m"
        return f"rebound height {heights}"
    return ""

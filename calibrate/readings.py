"""Restitution measured without a camera: tables of rebound heights, or of times between bounces.

Quantities carry their unit in the column's name, ``h0_cm``, ``h0 [cm]`` or ``h0 (cm)``:

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
from calibrate.rows import TrialTableError, number_of

_NUMBERS = ("drop_height", "rebound_height", "interval")
_NAMES = ("ball", "drop_height", "rebound_height", "launch", "number", "interval")
_UNTOLD: dict[str, str | float] = {"ball": "ball", "launch": "", "drop_height": math.nan}
_EXAMPLES = {
    "drop_height": "h0_cm",
    "rebound_height": "h1_cm",
    "number": "interval_no",
    "interval": "dt_s",
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
    header = set(read_cells(path))
    return "kind" not in header and bool(header & {"rebound_height", "interval"})


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
    needed = _needed(path.name, set(cells))
    rows, failed = [], []
    for line, cell in zip(cells.index, cells.to_dict("records"), strict=True):
        reading = _UNTOLD | {
            name: _number(cell[name]) if name in _NUMBERS else cell[name] for name in _NAMES if name in cell
        }
        broken = _broken_rule(reading, needed)
        if broken:
            failed.append(f"{path.name}, line {line}: {broken}")
        else:
            rows.append(reading)
    if not rows:
        raise TrialTableError(failed[0] if failed else f"{path.name} holds no reading")
    table = pd.DataFrame(rows).reindex(columns=_NAMES)
    empty = table.iloc[:0]
    of_heights = "rebound_height" in needed
    return Readings(
        heights=table if of_heights else empty, intervals=empty if of_heights else table, failed=tuple(failed)
    )


def _needed(file: str, there: set[str]) -> tuple[str, ...]:
    needed = ("drop_height", "rebound_height") if "rebound_height" in there else ("number", "interval")
    for name in needed:
        if name not in there:
            raise TrialTableError(
                f"{file} has no column of {name.replace('_', ' ')}, such as {_EXAMPLES[name]}"
            )
    return needed


def _number(cell: str) -> float:
    """Give a number; NaN for a cell that is none."""
    try:
        return number_of(cell)
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

"""The trial table: one row an impact, read, checked and written as CSV.

What a row means depends on its ``kind`` (velocities in m/s, up positive, so a falling ball approaches with a
negative velocity; masses in kg):

=======  =======================================================================================
`plate`  a ball on the bare plate: ball-table restitution = -upper_rebound_velocity / approach_velocity
`held`   a ball on a lower ball held still: ball-ball restitution, the same way
`two`    a ball on a second ball that rests on the plate: both rebound velocities and both masses
`shot`   a cue ball struck by a cue; its own columns (see `calibrate.shot_table`)
`pair`   two bodies that meet in free motion
=======  =======================================================================================

A velocity's ``_sd`` is its whole standard deviation. Where a table also says how much of it all trials have
in common (``approach_velocity_scale``, …; see `calibrate.shared`) that part is not averaged away by repeats.
"""

from collections.abc import Iterable
from pathlib import Path

import pandas as pd

from calibrate.cells import read_cells
from calibrate.files import write_whole
from calibrate.rows import NUMBER_COLUMNS, REQUIRED_COLUMNS, TEXT_COLUMNS, TrialTableError, checked_row

COLUMNS = (
    *("trial", "kind", "status", "reason", "impact", "time"),
    *("approach_velocity", "approach_velocity_sd", "upper_rebound_velocity", "upper_rebound_velocity_sd"),
    *("lower_rebound_velocity", "lower_rebound_velocity_sd", "upper_mass", "lower_mass", "gravity_check"),
)
"""Columns every checked table has, in this order; quality columns of any name may follow."""


def read_trials(paths: str | Path | Iterable[str | Path]) -> pd.DataFrame:
    r"""Read one trial table or several into one.

    Comma, semicolon or tab between cells, decimal commas, the encodings of spreadsheets (see `cells`) and
    units behind the names of columns, as in ``v0 [cm/s]`` (see `units`), are all understood; what may mean
    two things is refused. Workbooks (.xlsx) are not read: save them as CSV. Only `kind`,
    `approach_velocity`, `upper_rebound_velocity` (and for kind ``two`` `lower_rebound_velocity`,
    `upper_mass`, `lower_mass`) must be there.

    Parameters
    ----------
    paths : path or iterable of paths
        CSV files with a header line.

    Returns
    -------
    pandas.DataFrame
        As `check_trials` returns it, rows in the order of the files.

    Raises
    ------
    TrialTableError
        If a file cannot be read as a table, a column is missing, or no row is usable. A single bad row is no
        error: its status becomes ``failed`` and its reason says file, line, column, value and rule.

    Examples
    --------
    >>> import tempfile
    >>> path = tempfile.mkdtemp() + "/typed.csv"
    >>> header = "kind;approach_velocity;upper_rebound_velocity"
    >>> _ = write_whole(path, f"{header}\nplate;-2,0;1,7\nplate;-2,4;2,0")
    >>> read_trials(path)[["trial", "status", "approach_velocity", "upper_rebound_velocity"]]
          trial status  approach_velocity  upper_rebound_velocity
    0  typed-02     ok               -2.0                     1.7
    1  typed-03     ok               -2.4                     2.0
    """
    paths = [paths] if isinstance(paths, (str, Path)) else list(paths)
    if not paths:
        raise TrialTableError("no trial table given: name at least one CSV file")
    return pd.concat([_read_one(Path(path)) for path in paths], ignore_index=True)


def check_trials(table: pd.DataFrame, source: str = "row") -> pd.DataFrame:
    """Complete a trial table and judge each of its rows.

    Parameters
    ----------
    table : pandas.DataFrame
        At least the columns its kinds need; cells may be numbers or text. The index names the rows in
        reasons.
    source : str
        What the reasons call a row's place, followed by its index: ``"drops.csv, line"``.

    Returns
    -------
    pandas.DataFrame
        A new table with all of `COLUMNS` first and every other column after them. Missing numbers are NaN,
        missing status is ``ok``; a row that breaks a rule has status ``failed`` and a sentence as `reason`.

    Raises
    ------
    TrialTableError
        If the table is empty, a needed column is missing, or every row breaks a rule.

    Examples
    --------
    >>> checked = check_trials(pd.DataFrame({"kind": ["plate", "plate"], "approach_velocity": [-2, 2.5],
    ...                                      "upper_rebound_velocity": [1.7, 2.0]}))
    >>> print(checked.reason[1])
    row 1: approach_velocity must be below zero (up is positive), got 2.5
    """
    if table.empty:
        raise TrialTableError(f"{_place(source)} holds no trial")
    _require_columns(table, source)
    labels = [f"{source} {label}" for label in table.index]
    rows = [checked_row(row, place) for row, place in zip(_cells(table), labels, strict=True)]
    checked = _typed(pd.DataFrame(rows))
    if (checked["status"] == "failed").all() and not _all_came_failed(table):
        first = checked["reason"].iloc[0]
        raise TrialTableError(f"no usable trial in {_place(source)}; the first reason is: {first}")
    return checked


def write_trials(table: pd.DataFrame, path: str | Path) -> Path:
    """Write a trial table as CSV, whole or not at all, six significant digits a number.

    Parameters
    ----------
    table : pandas.DataFrame
        As `check_trials` returns it.
    path : str or Path
        Usually ``trials.csv``.

    Returns
    -------
    Path
        The file written.

    Examples
    --------
    >>> import tempfile
    >>> trials = check_trials(pd.DataFrame({"kind": ["plate"], "approach_velocity": [-2.0],
    ...                                     "upper_rebound_velocity": [1.7]}))
    >>> path = write_trials(trials, tempfile.mkdtemp() + "/trials.csv")
    >>> bool(read_trials(path).upper_rebound_velocity[0] == 1.7)
    True
    """
    return write_whole(path, table.to_csv(index=False, float_format="%.6g", lineterminator="\n"))


def _read_one(path: Path) -> pd.DataFrame:
    table = read_cells(path)
    if "trial" not in table:
        table.insert(0, "trial", [f"{path.stem}-{number:02d}" for number in table.index])
    return check_trials(table, source=f"{path.name}, line")


def _require_columns(table: pd.DataFrame, source: str) -> None:
    if "kind" not in table:
        raise TrialTableError(f"{_place(source)} has no column 'kind' (plate, held, two, shot or pair)")
    kinds = set(table["kind"].astype(str).str.strip().str.lower())
    for kind in kinds & set(REQUIRED_COLUMNS):
        for column in REQUIRED_COLUMNS[kind]:
            if column not in table:
                raise TrialTableError(
                    f"{_place(source)} has no column {column!r}, which trials of kind {kind!r} need"
                )


def _place(source: str) -> str:
    return source.removesuffix(", line") if source.endswith(", line") else "the table"


def _cells(table: pd.DataFrame) -> list[dict[str, object]]:
    records: list[dict[str, object]] = table.astype(object).where(table.notna(), None).to_dict("records")
    for position, record in enumerate(records, start=1):
        record.setdefault("trial", f"{position:02d}")
    return records


def _all_came_failed(table: pd.DataFrame) -> bool:
    return "status" in table and bool((table["status"].astype(str).str.strip().str.lower() == "failed").all())


def _typed(table: pd.DataFrame) -> pd.DataFrame:
    others = [column for column in table if column not in COLUMNS]
    table = table.reindex(columns=[*COLUMNS, *others])
    for column in NUMBER_COLUMNS:
        table[column] = table[column].astype(float)
    for column in TEXT_COLUMNS:
        table[column] = table[column].astype(object).where(table[column].notna(), "").astype(str)
    for column in others:
        table[column] = _numbers_if_all_are(table[column])
    table["impact"] = table["impact"].fillna(1).astype(int)
    return table


def _numbers_if_all_are(cells: pd.Series) -> pd.Series:
    try:
        return pd.to_numeric(cells)
    except (ValueError, TypeError):
        return cells

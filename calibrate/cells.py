"""A table typed in by hand or saved by a spreadsheet, as text cells with the line each stood in."""

import csv
import io
import re
from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from calibrate.rows import TrialTableError


def read_cells(path: str | Path) -> pd.DataFrame:
    """Read a CSV file; comma, semicolon or tab between cells, decimal comma where that is no separator.

    Parameters
    ----------
    path : str or Path
        UTF-8 text with a header line, with or without a byte-order mark.

    Returns
    -------
    pandas.DataFrame
        Text cells; the index holds the lines' numbers in the file. Empty lines are left out.

    Raises
    ------
    TrialTableError
        If it is no text, empty, has a column twice, or a line with another number of cells.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise TrialTableError(f"{path.name} is not UTF-8 text: save it as 'CSV UTF-8'") from error
    lines = [line for line in _lines(text) if any(cell.strip() for cell in line[1])]
    if not lines:
        raise TrialTableError(f"{path.name} is empty: a header line and one line a trial are expected")
    header = [cell.strip() for cell in lines[0][1]]
    _check_shape(path.name, header, lines[1:])
    numbers, rows = [number for number, _ in lines[1:]], [row for _, row in lines[1:]]
    return pd.DataFrame(rows, columns=header, index=numbers)


def _lines(text: str) -> list[tuple[int, list[str]]]:
    """Split into lines: each one's number in the file and its cells."""
    first = text.split("\n", 1)[0]
    separator = max(";\t,", key=first.count)
    reader = csv.reader(io.StringIO(text), delimiter=separator)
    return [(reader.line_num, [_decimal_point(cell) for cell in cells]) for cells in reader]


def _decimal_point(cell: str) -> str:
    """Make a decimal comma a point; a cell can hold one only where commas do not separate the cells."""
    return re.sub(r"^(\s*[+-]?\d*),(\d+\s*)$", r"\1.\2", cell)


def _check_shape(name: str, header: Sequence[str], lines: Sequence[tuple[int, list[str]]]) -> None:
    twice = {column for column in header if header.count(column) > 1}
    if twice:
        raise TrialTableError(f"{name}: column {sorted(twice)[0]!r} appears twice")
    for number, cells in lines:
        if len(cells) != len(header):
            raise TrialTableError(
                f"{name}, line {number}: {len(cells)} cells where the header has {len(header)}"
                " (with decimal commas, separate the cells by semicolons)"
            )

"""A table typed in by hand or saved by a spreadsheet, as text cells in SI with the line each stood in."""

import csv
import io
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from reprlib import repr as shown
from typing import TypeAlias

import pandas as pd

from calibrate.plain_text import read_text
from calibrate.rows import TrialTableError, number_of
from calibrate.units import Column, is_known, understood

Lines: TypeAlias = list[tuple[int, list[str]]]
"""Number of each line in the file, and its cells."""

SEPARATORS = {",": "comma", ";": "semicolon", "\t": "tab"}
_TOLD_SEPARATOR = re.compile(r"sep=([,;\t])\n")
_COMMA = re.compile(r"([+-]?\d*),(\d+(?:[eE][+-]?\d+)?)")
_POINT = re.compile(r"[+-]?\d*\.\d+(?:[eE][+-]?\d+)?")
_THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2}(,\d{3})+")


def read_cells(path: str | Path) -> pd.DataFrame:
    r"""Read a table: comma, semicolon or tab between cells, decimal point or comma, units in column names.

    Parameters
    ----------
    path : str or Path
        A text file with a header line, in an encoding that spreadsheets write; see `plain_text`.

    Returns
    -------
    pandas.DataFrame
        Text cells with decimal points, in SI, columns by the names of their quantities (see `units`); the
        index holds the lines' numbers in the file. Empty lines and empty columns are left out.

    Raises
    ------
    TrialTableError
        If it is no text, empty, has a column twice or with an unknown unit, a line with another number of
        cells, or may be read in two ways; the message names them.

    Examples
    --------
    >>> import tempfile
    >>> path = Path(tempfile.mkdtemp()) / "typed.csv"
    >>> _ = path.write_text("kind;v0 [cm/s];note\nplate;-2,5;warm\n")
    >>> read_cells(path)
        kind approach_velocity  note
    2  plate            -0.025  warm
    """
    path = Path(path)
    text = read_text(path)
    told = _TOLD_SEPARATOR.match(text)
    text = text[told.end(1) :] if told else text  # what is left of that line counts as an empty one
    separator = told[1] if told else _separator(path.name, text)
    lines = _lines(path.name, text, separator)
    header, rows = lines[0][1], [cells for _, cells in lines[1:]]
    columns = understood(path.name, header)
    table = pd.DataFrame(rows, columns=header, index=[number for number, _ in lines[1:]], dtype=object)
    _refuse_two_readings(path.name, table, columns, separator)
    for name, column in zip(header, columns, strict=True):
        if column.dimension != "text":
            table[name] = [_in_si(cell, column.per_si) for cell in table[name]]
    return table.set_axis([column.name for column in columns], axis="columns")


def _separator(file: str, text: str) -> str:
    """Find what separates the cells: what gives a table, or else what the header has most of."""
    possible = {separator: header for separator in SEPARATORS if (header := _header(file, text, separator))}
    if len(possible) > 1:
        ways = " or ".join(
            f"with a {SEPARATORS[separator]} between cells (columns {', '.join(map(shown, header))})"
            for separator, header in possible.items()
        )
        raise TrialTableError(f"{file} can be read {ways}: use one of them only, even within cells")
    return next(iter(possible), "") or max(SEPARATORS, key=text.lstrip().split("\n", 1)[0].count)


def _header(file: str, text: str, separator: str) -> list[str]:
    """Give the header if there are several columns, one of them known, and each line has as many cells."""
    try:
        header = _lines(file, text, separator)[0][1]
    except TrialTableError:
        return []
    return header if len(header) > 1 and any(map(is_known, header)) else []


def _lines(file: str, text: str, separator: str) -> Lines:
    """Split into lines and cells, without empty lines and columns; all others have a name."""
    lines = _split(file, text, separator)
    if not lines:
        raise TrialTableError(f"{file} is empty: a header line and one line a trial are expected")
    width = len(lines[0][1])
    for number, cells in lines:
        too_long = len(cells) > width if separator == "," else any(cells[width:])
        if len(cells) < width or too_long:
            raise TrialTableError(
                f"{file}, line {number}: {len(cells)} cells where the header has {width}"
                " (with decimal commas, separate the cells by semicolons)"
            )
    kept = [column for column in range(width) if any(cells[column] for _, cells in lines)]
    for column in kept:
        if not lines[0][1][column]:
            number = next(number for number, cells in lines if cells[column])
            raise TrialTableError(
                f"{file}, line {number}: column {column + 1} must have a name in the header, but has none"
                " (with decimal commas, separate the cells by semicolons)"
            )
    return [(number, [cells[column] for column in kept]) for number, cells in lines]


def _split(file: str, text: str, separator: str) -> Lines:
    """Split into lines that hold anything; a quotation mark never closed would swallow the rest."""
    reader = csv.reader(io.StringIO(text), delimiter=separator, strict=True)
    try:
        lines = [(reader.line_num, [cell.strip() for cell in cells]) for cells in reader]
    except csv.Error as error:
        raise TrialTableError(
            f"{file}, line {reader.line_num}: cannot be split into cells ({error}); check its quotation marks"
        ) from error
    return [(number, cells) for number, cells in lines if any(cells)]


def _refuse_two_readings(file: str, table: pd.DataFrame, columns: Sequence[Column], separator: str) -> None:
    """Refuse a comma in numbers that may be a decimal comma or stand between thousands."""
    commas, points = (list(_matching(table, columns, shape)) for shape in (_COMMA, _POINT))
    if commas and points:
        (line, comma), (other, point) = commas[0], points[0]
        raise TrialTableError(
            f"{file}: numbers are written with a decimal comma ({comma!r}, line {line}) and with a decimal "
            f"point ({point!r}, line {other}), so that either may stand between thousands; write all one way"
        )
    if commas and separator != ";" and all(_THOUSANDS.fullmatch(cell) for _, cell in commas):
        line, cell = commas[0]
        raise TrialTableError(
            f"{file}, line {line}: {cell!r} may be {cell.replace(',', '.')} (decimal comma) or "
            f"{cell.replace(',', '')} (comma between thousands); write numbers with a decimal point"
        )


def _matching(
    table: pd.DataFrame, columns: Sequence[Column], shape: re.Pattern[str]
) -> Iterator[tuple[int, str]]:
    """Line and text of the cells of known numbers that look like this."""
    for place, column in enumerate(columns):
        if column.is_number:
            for line, cell in table.iloc[:, place].items():
                if shape.fullmatch(cell):
                    yield int(str(line)), cell


def _in_si(cell: str, per_si: float) -> str:
    """Give a number with a decimal point and in SI; a cell that is none stays as it is, for its row's reason.

    Examples
    --------
    >>> _in_si("-2,5", 100.0), _in_si("fast", 100.0), _in_si("7", 1.0)
    ('-0.025', 'fast', '7')
    """
    cell = _COMMA.sub(r"\1.\2", cell) if _COMMA.fullmatch(cell) else cell
    if per_si == 1.0 or not cell:
        return cell
    try:
        return repr(number_of(cell) / per_si)
    except ValueError:
        return cell

"""A file from anybody's spreadsheet → its text, or a sentence that says what it is instead."""

import codecs
import re
from pathlib import Path

from calibrate.rows import TrialTableError

LARGEST = 50e6
"""Bytes: a table of a million trials is smaller, and all of it is held in memory."""
_AS_CSV = "open it in the program that made it and save it as 'CSV UTF-8'"
_SIGNATURES = {
    b"PK": "a workbook (.xlsx, .ods) or a zip archive",
    b"\xd0\xcf\x11\xe0": "a workbook of an old Excel (.xls)",
    b"\x1f\x8b": "a compressed file (gzip)",
    b"BZh": "a compressed file (bzip2)",
    b"\xfd7zXZ": "a compressed file (xz)",
    b"7z\xbc\xaf": "a 7-Zip archive",
    b"Rar!": "a RAR archive",
    b"SQLite format": "a data base",
    b"%PDF": "a PDF document",
}
_CODES = {codecs.BOM_UTF8: "utf-8-sig", codecs.BOM_UTF16_LE: "utf-16", codecs.BOM_UTF16_BE: "utf-16"}
_NO_TEXT = re.compile(r"[\x00-\x08\x0e-\x1f]")


def read_text(path: Path) -> str:
    """Read UTF-8, UTF-16 with its byte-order mark, or Windows-1252, as spreadsheets write them.

    Parameters
    ----------
    path : Path
        An ordinary file of at most `LARGEST` bytes.

    Returns
    -------
    str
        Without a byte-order mark, every line ended by a line feed.

    Raises
    ------
    TrialTableError
        If it is something else than text, or too large.
    OSError
        If it cannot be read.
    """
    if path.exists() and not path.is_file():
        raise TrialTableError(f"{path.name} is no file: name the table itself, saved as CSV")
    if (size := path.stat().st_size) > LARGEST:
        raise TrialTableError(
            f"{path.name} must have at most {LARGEST / 1e6:g} MB, got {size / 1e6:.0f} MB: "
            "keep only the columns and lines of trials"
        )
    content = path.read_bytes()
    for signature, what in _SIGNATURES.items():
        if content.startswith(signature):
            raise TrialTableError(f"{path.name} must be a CSV file, but is {what}: {_AS_CSV}")
    text = _decoded(content)
    if text is None or _NO_TEXT.search(text):
        raise TrialTableError(f"{path.name} is not UTF-8 text, nor any that a spreadsheet writes: {_AS_CSV}")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _decoded(content: bytes) -> str | None:
    """Decode by the byte-order mark, else UTF-8, else Windows-1252: they differ in letters only."""
    told = [code for mark, code in _CODES.items() if content.startswith(mark)]
    for code in told or ["utf-8", "cp1252"]:
        try:
            return content.decode(code)
        except UnicodeDecodeError:
            continue
    return None

"""Columns of the trial table as words, values and units."""

from collections.abc import Iterator, Mapping
from typing import Any

from calibrate.report import rounded
from calibrate.rows import TEXT_COLUMNS, VELOCITIES

MILLIMETRES = 1000.0
WORDS = {
    "approach_velocity": "speed of the cue's tip",
    "approach_direction": "direction of the cue's tip",
    "lift": "largest apparent growth",
}
HIDDEN = (*TEXT_COLUMNS, "impact", "unit")


def numbers_of(row: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Give the numbers of one impact as (what, value with unit); what all trials share stays in the table.

    Examples
    --------
    >>> list(numbers_of({"approach_velocity": -1.687, "approach_velocity_sd": 0.0142, "residual": 2e-5}))
    [('approach velocity', '-1.687 ± 0.014 m/s'), ('residual', '0.02 mm')]
    """
    length, words = row.get("unit") or "m", WORDS if row.get("kind") == "shot" else {}
    for name, value in row.items():
        if name in HIDDEN or name.endswith("_sd") or _is_detail(name) or not isinstance(value, (int, float)):
            continue
        unit, factor = _unit(name, length)
        sd = row.get(f"{name}_sd") or 0.0
        number = rounded(value * factor, sd * factor) if sd > 0 else f"{value * factor:.3g}"
        yield words.get(name, name.replace("_", " ")), f"{number} {unit}".rstrip()


def _is_detail(name: str) -> bool:
    """Tell the columns that say how a velocity's uncertainty came about, or measure it a second time."""
    return any(name.startswith(f"{velocity}_") for velocity in VELOCITIES)


def _unit(name: str, length: str) -> tuple[str, float]:
    """Give the unit in which a column is shown, and the factor to it."""
    if name.endswith("_correlation"):
        return "", 1.0
    if name == "lift":
        return "%", 100.0
    if name.startswith("angular_velocity"):
        return "rad/s", 1.0
    if "velocity" in name or name.startswith(("striker_", "struck_", "sideways_")):
        return f"{length}/s", 1.0
    if name == "residual":
        return ("mm", MILLIMETRES) if length == "m" else (length, 1.0)
    if name.endswith("time"):
        return "s", 1.0
    if name.endswith("mass"):
        return "kg", 1.0
    if name == "approach_direction":
        return "rad", 1.0
    return (length, 1.0) if name.startswith(("start_", "rolling_")) else ("", 1.0)

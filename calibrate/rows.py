"""The rules one row of the trial table obeys."""

import math
from collections.abc import Callable, Mapping
from itertools import chain
from reprlib import repr as shown

TEXT_COLUMNS = ("trial", "kind", "status", "reason")
VELOCITIES = ("approach_velocity", "upper_rebound_velocity", "lower_rebound_velocity")
MASSES = ("upper_mass", "lower_mass")
NUMBER_COLUMNS = (
    *("time", "gravity_check", *MASSES),
    *chain.from_iterable((velocity, f"{velocity}_sd") for velocity in VELOCITIES),
)
STATUSES = ("ok", "suspect", "failed")
REQUIRED_COLUMNS: dict[str, tuple[str, ...]] = {
    "plate": VELOCITIES[:2],
    "held": VELOCITIES[:2],
    "two": (*VELOCITIES, *MASSES),
    "shot": (),
    "pair": (),
}
_SURE = 3.0  # standard deviations by which a measurement must break a law of mechanics before we believe it


class TrialTableError(ValueError):
    """A trial table that cannot be used; the message says where and why."""


class _RuleBrokenError(Exception):
    """One row breaks one rule; becomes the row's reason."""


def correlation_column(one: str, other: str) -> str:
    """Name the column that tells how the errors of two measured columns are correlated."""
    return f"{one}_{other}_correlation"


def checked_row(row: Mapping[str, object], place: str) -> dict[str, object]:
    """Judge one row of a trial table.

    Parameters
    ----------
    row : mapping of str to object
        Cells by column; None or an empty text is a missing value.
    place : str
        Where the row stands, for its reason: ``"drops.csv, line 5"``.

    Returns
    -------
    dict of str to object
        The row with numbers as floats; where it breaks a rule, with status ``failed`` and a `reason`.

    Examples
    --------
    >>> row = {"kind": "plate", "approach_velocity": "fast", "upper_rebound_velocity": "2.0"}
    >>> checked_row(row, "drops.csv, line 5")["reason"]
    "drops.csv, line 5: approach_velocity must be a number, got 'fast'"
    """
    judged = {column: cell.strip() if isinstance(cell, str) else cell for column, cell in row.items()}
    for column in ("kind", "status"):
        judged[column] = str(judged.get(column) or "").lower()
    judged["status"] = judged["status"] or "ok"
    broken = _first_broken_rule(judged)
    if broken:
        judged["status"], judged["reason"] = "failed", f"{place}: {broken}"
    return judged


def number_of(cell: object) -> float:
    """Understand a number as people write it; Python's own ``1_5`` for 15 is no such number.

    Raises
    ------
    ValueError
        If it is none.

    Examples
    --------
    >>> number_of("\u22122.5")
    -2.5
    """
    text = str(cell).replace("\u2212", "-")  # the minus sign of word processors
    if "_" in text:
        raise ValueError(f"a number must be digits, sign, point and exponent, got {shown(cell)}")
    return float(text)


def _first_broken_rule(row: dict[str, object]) -> str:
    """Turn the row's cells into numbers, in place, and say which rule it breaks first; empty if none."""
    broken = [sentence for column in (*NUMBER_COLUMNS, "impact") if (sentence := _make_number(row, column))]
    if row["status"] == "failed":
        return ""
    if broken:
        return broken[0]
    try:
        for rule in _RULES:
            rule(row)
    except _RuleBrokenError as error:
        return str(error)
    return ""


def _make_number(row: dict[str, object], column: str) -> str:
    cell = row.get(column)
    row[column] = None
    if cell is None or cell == "":
        return ""
    try:
        value = number_of(cell)
    except ValueError:
        return f"{column} must be a number, got {shown(cell)}"
    if math.isnan(value):
        return ""
    if math.isinf(value):
        return f"{column} must be finite, got {cell!r}"
    row[column] = value
    return ""


def _kind_is_known(row: Mapping[str, object]) -> None:
    if row["kind"] not in REQUIRED_COLUMNS:
        raise _RuleBrokenError(f"kind must be one of {', '.join(REQUIRED_COLUMNS)}, got {row['kind']!r}")


def _status_is_known(row: Mapping[str, object]) -> None:
    if row["status"] not in STATUSES:
        raise _RuleBrokenError(f"status must be one of {', '.join(STATUSES)}, got {row['status']!r}")


def _nothing_is_missing(row: Mapping[str, object]) -> None:
    for column in REQUIRED_COLUMNS[str(row["kind"])]:
        if row.get(column) is None:
            raise _RuleBrokenError(f"{column} is missing, trials of kind {row['kind']!r} need it")


def _sizes_make_sense(row: Mapping[str, object]) -> None:
    for column in MASSES:
        mass = _number(row, column)
        if mass <= 0:
            raise _RuleBrokenError(f"{column} must be above zero, got {mass:g}")
    for column in (f"{velocity}_sd" for velocity in VELOCITIES):
        deviation = _number(row, column)
        if deviation < 0:
            raise _RuleBrokenError(f"{column} must not be negative, got {deviation:g}")
    impact = _number(row, "impact")
    if impact < 1 or impact % 1 > 0:
        raise _RuleBrokenError(f"impact must be a whole number from 1 on, got {impact:g}")


def _ball_falls_and_rebounds(row: Mapping[str, object]) -> None:
    if row["kind"] not in ("plate", "held", "two"):
        return
    approach, upper = _number(row, "approach_velocity"), _number(row, "upper_rebound_velocity")
    if approach >= 0:
        raise _RuleBrokenError(f"approach_velocity must be below zero (up is positive), got {approach:g}")
    if row["kind"] != "two" and upper < -_slack(row, "upper_rebound_velocity"):
        raise _RuleBrokenError(f"upper_rebound_velocity must not be negative (up is positive), got {upper:g}")
    if upper > -approach + _slack(row, "approach_velocity", "upper_rebound_velocity"):
        raise _RuleBrokenError(
            f"the rebound ({upper:g} m/s) is faster than the approach ({-approach:g} m/s):"
            " restitution must be within [0, 1]"
        )


def _two_balls_obey_mechanics(row: Mapping[str, object]) -> None:
    """End of Theorem 3 (v1 >= v2 >= 0) and the energy balance."""
    if row["kind"] != "two":
        return
    approach, upper, lower = (_number(row, velocity) for velocity in VELOCITIES)
    if lower < -_slack(row, "lower_rebound_velocity"):
        raise _RuleBrokenError(f"lower_rebound_velocity must not be negative (up is positive), got {lower:g}")
    if upper < lower - _slack(row, "upper_rebound_velocity", "lower_rebound_velocity"):
        raise _RuleBrokenError(
            f"the upper ball ({upper:g} m/s) must rebound at least as fast as the lower ({lower:g} m/s);"
            " are the two columns swapped?"
        )
    ratio = _number(row, "lower_mass") / _number(row, "upper_mass")
    if math.hypot(upper, math.sqrt(ratio) * lower) > -approach + _slack(row, *VELOCITIES):
        raise _RuleBrokenError("the two balls leave with more energy than the upper one brought")


def _number(row: Mapping[str, object], column: str) -> float:
    """Cell as a number; NaN, with which every comparison is false, when it is missing."""
    value = row.get(column)
    return value if isinstance(value, float) else math.nan


def _slack(row: Mapping[str, object], *columns: str) -> float:
    deviations = [_number(row, f"{column}_sd") for column in columns]
    return _SURE * math.hypot(*(deviation for deviation in deviations if deviation > 0))


_RULES: tuple[Callable[[Mapping[str, object]], None], ...] = (
    _kind_is_known,
    _status_is_known,
    _nothing_is_missing,
    _sizes_make_sense,
    _ball_falls_and_rebounds,
    _two_balls_obey_mechanics,
)

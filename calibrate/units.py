"""Which quantity a column of a typed-in table holds, and in which unit: by its name, never by its values.

A unit stands behind the name, as in ``v0 [m/s]``, ``upper_mass (g)`` or ``h0_cm``. Trial tables need none:
without it a quantity is in SI. Tables of rebound heights and intervals must say it.
"""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import chain, product

from calibrate.rows import MASSES, TEXT_COLUMNS, VELOCITIES, TrialTableError
from calibrate.shared import SOURCES

UNITS: Mapping[str, Mapping[str, float]] = {
    "length": {"m": 1.0, "cm": 100.0, "mm": 1000.0},
    "time": {"s": 1.0, "ms": 1000.0},
    "velocity": {"m/s": 1.0, "cm/s": 100.0, "mm/s": 1000.0, "km/h": 3.6},
    "mass": {"kg": 1.0, "g": 1000.0},
    "angle": {"rad": 1.0, "deg": 180 / math.pi, "°": 180 / math.pi},
    "spin": {"rad/s": 1.0, "deg/s": 180 / math.pi, "°/s": 180 / math.pi, "rpm": 30 / math.pi},
    "radii": {"radii": 1.0, "R": 1.0, "1": 1.0, "-": 1.0},
    "number": {"1": 1.0, "-": 1.0},
    "text": {},
}
"""How many of each unit make one of SI."""

_MEASURED = {
    **dict.fromkeys((*VELOCITIES, "velocity_x", "velocity_y"), "velocity"),
    **dict.fromkeys(("angular_velocity_x", "angular_velocity_y"), "spin"),
    **dict.fromkeys(("approach_direction", "cue_elevation"), "angle"),
    **dict.fromkeys(("contact_offset", "contact_height"), "radii"),
    **dict.fromkeys(("friction", "gravity_check"), "number"),
    "time": "time",
}
_TRIALS = {
    **_MEASURED,
    **{f"{name}_sd": dimension for name, dimension in _MEASURED.items()},
    **{f"{velocity}_{source}": "velocity" for velocity, source in product(VELOCITIES, SOURCES)},
    **dict.fromkeys(MASSES, "mass"),
    **dict.fromkeys((*TEXT_COLUMNS, "unit"), "text"),
    "impact": "number",
}
_READINGS = {
    "drop_height": "length",
    "rebound_height": "length",
    "interval": "time",
    "number": "number",
    "ball": "text",
    "launch": "text",
}
_TRIAL_ALIASES = {
    **dict(zip(("v0", "v1", "v2"), VELOCITIES, strict=True)),
    **{f"v{index}_sd": f"{velocity}_sd" for index, velocity in enumerate(VELOCITIES)},
    **dict(zip(("m1", "m2"), MASSES, strict=True)),
}
_READING_ALIASES = {
    **{"h0": "drop_height", "h1": "rebound_height", "dt": "interval"},
    **{"ball_surface": "ball", "interval_no": "number", "repeat": "launch"},
}
_SEVERAL = {
    "mass": MASSES,
    "velocity": VELOCITIES,
    "rebound_velocity": VELOCITIES[1:],
    "height": ("drop_height", "rebound_height"),
}
_BRACKETED = re.compile(r"(?P<name>.*?)\s*(\[(?P<square>[^][]*)\]|\((?P<round>[^()]*)\))")


@dataclass(frozen=True, slots=True, kw_only=True)
class Column:
    """What a column holds.

    Attributes
    ----------
    name : str
        The quantity's own name; of a column that is none the one in the file.
    dimension : str
        Key of `UNITS`; empty for a column that is no known quantity.
    per_si : float
        How many of the column's unit make one of SI.
    """

    name: str
    dimension: str = ""
    per_si: float = 1.0

    @property
    def is_number(self) -> bool:
        """Whether its cells are known to be numbers."""
        return self.dimension not in ("", "text")


def understood(file: str, header: Sequence[str]) -> list[Column]:
    """Understand the header of a table.

    Raises
    ------
    TrialTableError
        If a unit is missing, unknown or belongs to another quantity, a name may mean several quantities, or
        two columns hold the same.

    Examples
    --------
    >>> [column.name for column in understood("typed.csv", ["Kind", "v0 [cm/s]", "room"])]
    ['kind', 'approach_velocity', 'room']
    >>> understood("typed.csv", ["kind", "m1 [oz]"])
    Traceback (most recent call last):
    calibrate.rows.TrialTableError: typed.csv: unit in 'm1 [oz]' must be one of kg, g, got 'oz'
    """
    of_trials = any(_plain(_split(name)[0]) == "kind" for name in header)
    columns = [_trial_column(file, name) if of_trials else _reading_column(file, name) for name in header]
    for number, column in enumerate(columns):
        for other, told in zip(columns[:number], header, strict=False):
            if column.name == other.name:
                both = "" if told == header[number] else f", as {told!r} and as {header[number]!r}"
                raise TrialTableError(f"{file}: column {column.name!r} appears twice{both}; remove one")
    return columns


def is_known(name: str) -> bool:
    """Whether a column's name, with or without a unit, is that of a quantity of any table."""
    plain = _plain(_split(name)[0])
    every = chain(_TRIALS, _TRIAL_ALIASES, _READINGS, _READING_ALIASES, _SEVERAL)
    return any(plain == known or plain.startswith(f"{known}_") for known in every)


def _trial_column(file: str, told: str) -> Column:
    """In SI where no unit is told; a column that is no known quantity stays what it is."""
    name, unit = _split(told)
    plain = _plain(name)
    known = _TRIAL_ALIASES.get(plain, plain)
    if unit is None:
        known, unit = _with_suffix(known)
    if plain in _SEVERAL and plain != "height":
        raise _several(file, told, plain)
    if known not in _TRIALS:
        return Column(name=told)
    dimension = _TRIALS[known]
    return Column(name=known, dimension=dimension, per_si=_per_si(file, told, unit, dimension))


def _with_suffix(name: str) -> tuple[str, str | None]:
    """Split off a unit behind an underscore: ``upper_mass_g``."""
    for known, quantity in (*_TRIAL_ALIASES.items(), *zip(_TRIALS, _TRIALS, strict=True)):
        unit = name.removeprefix(f"{known}_")
        if name != unit and unit in UNITS[_TRIALS[quantity]]:
            return quantity, unit
    return name, None


def _reading_column(file: str, told: str) -> Column:
    """Heights and times must say their unit: people read them in centimetres as well as in metres."""
    name, unit = _split(told)
    plain = _plain(name)
    if plain.split("_")[0] == "height":
        raise _several(file, told, "height")
    for alias, known in (*_READING_ALIASES.items(), *zip(_READINGS, _READINGS, strict=True)):
        dimension = _READINGS[known]
        if dimension in ("length", "time") and unit is None and plain.startswith(f"{alias}_"):
            unit = name.strip()[len(alias) + 1 :]
            plain = alias
        if plain == alias:
            if dimension in ("length", "time") and unit is None:
                example = f"{alias}_{list(UNITS[dimension])[-1]}"
                raise TrialTableError(f"{file}: column {told!r} must say its unit, such as {example}")
            return Column(name=known, dimension=dimension, per_si=_per_si(file, told, unit, dimension))
    return Column(name=told)


def _split(told: str) -> tuple[str, str | None]:
    """Part a name from the unit in brackets behind it."""
    found = _BRACKETED.fullmatch(told.strip())
    if not found:
        return told, None
    unit = found["square"] if found["round"] is None else found["round"]
    return found["name"], unit.strip()


def _plain(name: str) -> str:
    """Give a name as tables write it: small letters, underscores."""
    return "_".join(name.lower().split())


def _per_si(file: str, told: str, unit: str | None, dimension: str) -> float:
    units = UNITS[dimension]
    if unit is None:
        return 1.0
    if unit not in units:
        rule = f"must be one of {', '.join(units)}" if units else "must not be there, it holds text"
        raise TrialTableError(f"{file}: unit in {told!r} {rule}, got {unit!r}")
    return units[unit]


def _several(file: str, told: str, name: str) -> TrialTableError:
    meanings = " or ".join(_SEVERAL[name])
    return TrialTableError(f"{file}: column {told!r} may be {meanings}; name it so")

"""What a person at a terminal sees while recordings are processed: progress, remarks, one line an impact."""

import sys
from collections import Counter
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from math import atan2, degrees, hypot
from typing import Any, TypeVar

from calibrate.rows import VELOCITIES
from experiments.record import Record

Item = TypeVar("Item")
Row = Mapping[str, Any]

BOUNCE_HEADS = ("before m/s", "after m/s", "restitution", "gravity")
DROP_HEADS = ("before m/s", "after m/s", "lower m/s", "gravity")
SHOT_HEADS = ("speed", "direction", "spin x", "spin y", "friction", "unit")
PAIR_HEADS = ("striker", "after", "struck", "after", "restit.", "gap %", "unit")


def headline(kind: str, width: int) -> str:
    """Headline of the lines of one kind of trial, which begin with a name `width` wide."""
    heads, _ = columns_of(kind)
    return f"{'trial':<{width}}  {'kind':<6} {'n':>2}  {_columns(heads)}  status"


def columns_of(kind: str) -> tuple[Sequence[str], Callable[[Row], list[str]]]:
    """Give the headings of one kind's columns, and what writes a row's cells."""
    others = {
        "two": (DROP_HEADS, _drop_columns),
        "shot": (SHOT_HEADS, _shot_columns),
        "pair": (PAIR_HEADS, _pair_columns),
    }
    return others.get(kind, (BOUNCE_HEADS, _bounce_columns))


def name_width(names: Iterable[str]) -> int:
    """Width of the first column."""
    return max(map(len, (*names, "trial")))


def progress(items: Iterable[Item], total: int, what: str, *, quiet: bool) -> Generator[Item, None, None]:
    """Pass items through and draw a bar on stderr; silent when asked to be, or when nobody watches."""
    if quiet or not sys.stderr.isatty():
        yield from items
        return
    from rich import progress as rich
    from rich.console import Console

    columns = (rich.TextColumn("{task.description}"), rich.BarColumn(), rich.MofNCompleteColumn())
    times = (rich.TimeElapsedColumn(), rich.TextColumn("left"), rich.TimeRemainingColumn())
    screen = Console(stderr=True)
    together = sys.stdout.isatty()  # results in a file or a pipe must not be drawn above the bar
    with rich.Progress(*columns, *times, console=screen, transient=True, redirect_stdout=together) as bar:
        yield from bar.track(items, total=total, description=what)


def impact_lines(record: Record, width: int) -> Iterator[str]:
    """Give one line for each impact of a trial, in the columns of its kind's `headline`."""
    _, columns = columns_of(record.kind)
    for row in record.rows:
        start = f"{record.name:<{width}}  {record.kind:<6} {row['impact']:>2}"
        yield f"{start}  {_columns(columns(row))}  {row['status']}"


def complaints(record: Record, said: Counter[str]) -> Iterator[str]:
    """Remarks on a recording, and the reason of each impact that is not ok.

    What begins as a remark on another recording did is only counted in `said`.
    """
    for remark in record.remarks:
        said[_opening(remark)] += 1
        if said[_opening(remark)] == 1:
            yield f"{record.name}: {remark}"
    for row in record.rows:
        if row["status"] != "ok":
            yield f"{record.name}, impact {row['impact']}: {row['status']}: {row['reason']}"


def said_again(said: Mapping[str, int]) -> Iterator[str]:
    """Tell on how many more recordings remarks began alike."""
    for opening, times in said.items():
        if times > 1:
            yield f"on {times - 1} more: {opening} …"


def _opening(remark: str) -> str:
    """Give the words of a remark before its first comma."""
    return remark.partition(",")[0]


def _bounce_columns(row: Row) -> list[str]:
    """Velocities, restitution on what does not move, and gravity as a check."""
    velocities = [_number(row.get(name)) for name in VELOCITIES[:2]]
    return [*velocities, _with_sd(row, "restitution"), _with_sd(row, "gravity_check")]


def _drop_columns(row: Row) -> list[str]:
    """Velocities of both balls, and gravity as a check."""
    return [*(_number(row.get(name)) for name in VELOCITIES), _with_sd(row, "gravity_check")]


def _shot_columns(row: Row) -> list[str]:
    """Launch as speed and direction (degrees from x to y), spin in rad/s, friction of the cloth."""
    speed, direction = _polar(row, "velocity")
    spin = [_number(row.get(f"angular_velocity_{axis}"), 2) for axis in "xy"]
    return [speed, direction, *spin, _number(row.get("friction")), _per_second(row)]


def _pair_columns(row: Row) -> list[str]:
    """Speeds of both discs before and after, restitution, change of momentum."""
    names = ("striker_before", "striker_after", "struck_before", "struck_after")
    gap = None
    if row.get("momentum_gap_along") is not None:
        gap = 100 * hypot(row["momentum_gap_along"], row["momentum_gap_across"])
    speeds = [_polar(row, name)[0] for name in names]
    return [*speeds, _number(row.get("restitution")), _number(gap, 2), _per_second(row)]


def _polar(row: Row, name: str) -> tuple[str, str]:
    """Size and direction in degrees of a vector NAME_x, NAME_y."""
    if row.get(f"{name}_x") is None:
        return "", ""
    x, y = row[f"{name}_x"], row[f"{name}_y"]
    return _number(hypot(x, y), 4 if row.get("unit", "m") == "m" else 1), f"{degrees(atan2(y, x)):.2f}°"


def _per_second(row: Row) -> str:
    """Give the unit of the velocities."""
    return f"{row['unit']}/s" if "unit" in row else ""


def _with_sd(row: Row, name: str) -> str:
    """Give a value with its standard deviation, if that is known."""
    value, sd = _number(row.get(name), 3), _number(row.get(f"{name}_sd"), 3)
    return f"{value}±{sd}" if sd else value


def _columns(texts: Iterable[str]) -> str:
    """Right-aligned columns."""
    return " ".join(f"{text:>11}" for text in texts)


def _number(value: float | None, places: int = 4) -> str:
    """Four decimals are more than a camera tells; nothing where nothing was record."""
    return "" if value is None or value != value else f"{value:.{places}f}"

"""A track with its fit, and below it what is left between them, as drawings of fixed size."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from experiments.report.axis import Array, Axis, axis_around, widened

WIDTH, LEFT, RIGHT, TOP, BOTTOM = 440.0, 62.0, 10.0, 8.0, 36.0
HEIGHTS = (200.0, 130.0)
MOST_DOTS = 300
MILLIMETRES = 1000.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Panel:
    """One pair of axes: titles, ticks as (place, text), dots as (number of the ball, SVG path), lines."""

    height: float
    titles: tuple[str, str]
    ticks: tuple[Sequence[tuple[float, str]], Sequence[tuple[float, str]]]
    dots: Sequence[tuple[int, str]]
    lines: Sequence[str]


@dataclass(frozen=True, slots=True, kw_only=True)
class Chart:
    """The panels of one trial, and the names of its balls."""

    balls: Sequence[str]
    panels: Sequence[Panel]
    width: float = WIDTH
    left: float = LEFT
    right: float = WIDTH - RIGHT
    top: float = TOP
    bottom: float = BOTTOM


def chart_of(track: pd.DataFrame, fits: Sequence[Mapping[str, Any]], kind: str) -> Chart:
    """Draw height over time for a drop, the path as seen from above for what moves on a table.

    Parameters
    ----------
    track : pandas.DataFrame
        As in tracks/NAME.csv.
    fits : sequence of mappings
        As a record holds them.
    kind : str
        Of the trial.
    """
    unit = "px" if "x_px" in track else "m"
    track = track.rename(columns={"x_px": "x", "y_px": "y"})
    balls = list(dict.fromkeys(track["ball"]))
    seen = [track.loc[track["ball"] == ball, ["time", "x", "y"]].to_numpy(float) for ball in balls]
    curves = [(balls.index(fit["ball"]), _curve(fit)) for fit in fits if fit["ball"] in balls]
    on_table = kind in ("shot", "pair")
    columns, titles = ([0, 2], ("time [s]", f"y, upwards [{unit}]"))
    if on_table:
        columns, titles = [1, 2], (f"x [{unit}]", f"y [{unit}]")
    dots = [one[:, columns] for one in seen]
    lines = [curve[:, columns] for _, curve in curves]
    panels = [_panel(titles, dots, lines, HEIGHTS[0], equal=on_table)]
    left = [_left_between(one, [c for ball, c in curves if ball == i]) for i, one in enumerate(seen)]
    if sum(map(len, left)):
        times = np.concatenate([one[:, 0] for one in seen])
        panels.append(_residual_panel(left, times, unit, on_table=on_table))
    return Chart(balls=balls, panels=panels)


def _curve(fit: Mapping[str, Any]) -> Array:
    return np.column_stack([fit[name] for name in ("time", "x", "y")]).astype(float)


def _left_between(seen: Array, curves: Sequence[Array]) -> Array:
    """Give time and (x, y) seen less fitted, for each frame within a fit."""
    parts = [np.empty((0, 3))]
    for curve in curves:
        within = seen[(seen[:, 0] >= curve[0, 0]) & (seen[:, 0] <= curve[-1, 0])] if len(curve) else seen[:0]
        fitted = [np.interp(within[:, 0], curve[:, 0], curve[:, axis]) for axis in (1, 2)]
        parts.append(within - np.column_stack((np.zeros(len(within)), *fitted)))
    return np.concatenate(parts)


def _residual_panel(left: Sequence[Array], times: Array, unit: str, *, on_table: bool) -> Panel:
    """Draw what is left in height, or on a table the distance, over all times in which the balls are seen."""
    small, factor = ("mm", MILLIMETRES) if unit == "m" else (unit, 1.0)
    sizes = [np.hypot(one[:, 1], one[:, 2]) if on_table else one[:, 2] for one in left]
    dots = [np.column_stack((one[:, 0], factor * size)) for one, size in zip(left, sizes, strict=True)]
    what = f"off the fit [{small}]" if on_table else f"seen - fit [{small}]"
    zero = np.column_stack(([times.min(), times.max()], [0.0, 0.0]))
    return _panel(("time [s]", what), dots, [zero], HEIGHTS[1])


def _panel(
    titles: tuple[str, str],
    dots: Sequence[Array],
    lines: Sequence[Array],
    height: float,
    *,
    equal: bool = False,
) -> Panel:
    """Lay out one pair of axes around everything it shows."""
    every = np.concatenate([*dots, *lines])
    across = axis_around(every[:, 0], LEFT, WIDTH - RIGHT)
    up = axis_around(every[:, 1], height - BOTTOM, TOP)
    if equal:
        span = max(across.span, up.span)
        across, up = widened(across, span), widened(up, span)
    return Panel(
        height=height,
        titles=titles,
        ticks=(across.ticks(), up.ticks()),
        dots=[
            (ball, _path(one[:: 1 + len(one) // MOST_DOTS], (across, up), "h0M"))
            for ball, one in enumerate(dots)
        ],
        lines=[_path(line, (across, up), "L") for line in lines],
    )


def _path(points: Array, axes: tuple[Axis, Axis], between: str) -> str:
    """Write an SVG path; strokes of no length with broad ends are dots."""
    if not len(points):
        return ""
    places = zip(*(axis.places(points[:, number]).tolist() for number, axis in enumerate(axes)), strict=True)
    path = "M" + between.join(f"{x:.1f} {y:.1f}" for x, y in places)
    return path + "h0" if between.startswith("h") else path

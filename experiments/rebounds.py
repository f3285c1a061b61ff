"""Restitution from rebound heights and from bounce intervals, through air, and how it depends on speed."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.optimize import brentq

from calibrate.readings import Readings
from calibrate.report import rounded
from calibrate.speed import SpeedLaw, fit_speed_law, tells_about_speed
from tracking.flight import Air, Flight, apex, fall_time, flight_of_ball
from tracking.flight import velocity as velocity_after

Array = NDArray[np.float64]

HEIGHTS, INTERVALS = "rebound heights", "bounce intervals"
UNTOLD = "nothing to compare: no two intervals of a launch follow each other"
VACUUM_FLIGHT = Flight(gravity=9.80665)
_FASTEST = 100.0  # m/s: no ball that anybody drops rebounds faster
_PRIOR_READINGS = 4.0  # how far the scatter of few readings is drawn to that of all


@dataclass(frozen=True, slots=True, kw_only=True)
class BallResult:
    """What the tables tell of one ball.

    Attributes
    ----------
    ball : str
        Its name in the tables.
    points : pandas.DataFrame
        `method`, `speed` (m/s), `restitution`, `restitution_sd`, `readings`: one row a drop height, or a
        drop height and number of the bounce.
    laws : mapping of str to SpeedLaw
        For each method that saw speeds different enough.
    in_air : bool
        Whether mass and diameter were told, so that drag and buoyancy are allowed for.
    """

    ball: str
    points: pd.DataFrame
    laws: Mapping[str, SpeedLaw]
    in_air: bool


def results(readings: Sequence[Readings], bodies: Mapping[str, tuple[float, float]]) -> list[BallResult]:
    """Fit each ball by itself.

    Parameters
    ----------
    readings : sequence of Readings
        As `read_readings` returns them, one a table.
    bodies : mapping of str to (mass, diameter)
        kg and m, by the ball's name; balls not in it fly as in vacuum.

    Raises
    ------
    ValueError
        If a body names no ball of the tables, or is none.
    """
    tables_of_balls = [part.ball for each in readings for part in (each.heights, each.intervals)]
    balls = list(dict.fromkeys(pd.concat(tables_of_balls)))
    for name in bodies:
        if name not in balls:
            raise ValueError(f"ball must be one of {', '.join(balls)}, got {name!r}")
    return [_result(ball, readings, bodies.get(ball)) for ball in balls]


def results_text(found: Sequence[BallResult]) -> str:
    """Print what was found, a ball a paragraph."""
    return "\n".join(line for result in found for line in _lines(result))


def points_from_heights(heights: pd.DataFrame, flight: Flight) -> pd.DataFrame:
    """Average repeated rebounds of each drop height: they share the error of its mark.

    Examples
    --------
    >>> heights = pd.DataFrame({"drop_height": [0.5, 0.5], "rebound_height": [0.405, 0.405]})
    >>> points_from_heights(heights, VACUUM_FLIGHT)[["speed", "restitution"]].round(3).values.tolist()
    [[3.132, 0.9]]
    """
    speed = _landing_speed(flight, heights["drop_height"].to_numpy())
    leaving = _each(heights["rebound_height"], lambda height: _leaving_speed_to(flight, height))
    rows = pd.DataFrame({"speed": speed, "restitution": leaving / speed})
    return _averaged(rows, [heights["drop_height"].to_numpy()])


def points_from_intervals(intervals: pd.DataFrame, flight: Flight) -> pd.DataFrame:
    """Compare each interval with the next of its launch: the ball leaves, flies, lands, and leaves again.

    Examples
    --------
    >>> intervals = pd.DataFrame({"launch": ["1", "1"], "drop_height": np.nan, "number": [1, 2],
    ...                           "interval": [0.5, 0.45]})
    >>> points_from_intervals(intervals, VACUUM_FLIGHT)[["speed", "restitution"]].round(3).values.tolist()
    [[2.452, 0.9]]
    """
    launch = ["drop_height", "launch"]
    ordered = intervals.sort_values([*launch, "number"])
    leaving = _each(ordered["interval"], lambda interval: _leaving_speed_for(flight, interval))
    landing = _landing_speed(flight, np.array([apex(flight, speed)[1] for speed in leaving]))
    series = ordered.fillna({"launch": ""}).groupby(launch, dropna=False, sort=False)
    after = pd.Series(leaving, index=ordered.index).groupby(series.ngroup()).shift(-1).to_numpy()
    follows = series["number"].shift(-1).to_numpy() == ordered["number"].to_numpy() + 1
    rows = pd.DataFrame({"speed": landing, "restitution": after / landing})[follows]
    where = ordered[follows]
    return _averaged(rows, [where["drop_height"].fillna(-1.0).to_numpy(), where["number"].to_numpy()])


def _result(ball: str, readings: Sequence[Readings], body: tuple[float, float] | None) -> BallResult:
    flight = VACUUM_FLIGHT if body is None else flight_of_ball(body[0], body[1] / 2, Air())
    tables = []
    for each in readings:
        heights, intervals = (part[part.ball == ball] for part in (each.heights, each.intervals))
        if len(heights):
            tables.append(points_from_heights(heights, flight).assign(method=HEIGHTS))
        if len(intervals):
            tables.append(points_from_intervals(intervals, flight).assign(method=INTERVALS))
    points = pd.concat(tables, ignore_index=True)
    laws = {
        str(method): fit_speed_law(rows["speed"], rows["restitution"], rows["restitution_sd"])
        for method, rows in points.groupby("method", sort=False)
        if tells_about_speed(rows["speed"])
    }
    return BallResult(ball=ball, points=points, laws=laws, in_air=body is not None)


def _lines(result: BallResult) -> list[str]:
    air = "through air" if result.in_air else "as in vacuum: tell its mass and diameter to allow for air"
    lines = [f"{result.ball}, {air}"]
    for method, law in result.laws.items():
        lines.append(f"    {method}: {law}")
    for method in result.points["method"].unique():
        if method not in result.laws:
            lines.append(f"    {method}: too few or too similar speeds to see a dependence on them")
    if result.points.empty:
        lines.append(f"    {UNTOLD}")
    if HEIGHTS in result.laws and INTERVALS in result.laws:
        lines.append(f"    {_agreement(result.laws[HEIGHTS], result.laws[INTERVALS])}")
    return lines


def _agreement(heights: SpeedLaw, intervals: SpeedLaw) -> str:
    """Compare two methods at the middle of the speeds they share."""
    low = max(heights.speeds[0], intervals.speeds[0])
    high = min(heights.speeds[1], intervals.speeds[1])
    if low > high:
        return "the two methods share no speed at which to compare them"
    speed = (low + high) / 2
    (one, one_sd), (other, other_sd) = heights.at(speed), intervals.at(speed)
    sd = float(np.hypot(one_sd, other_sd))
    word = "agree" if abs(one - other) < 2 * sd else "disagree"
    return f"at {speed:.2f} m/s heights less intervals are {rounded(one - other, sd)}: they {word}"


def _averaged(rows: pd.DataFrame, groups: list[Array]) -> pd.DataFrame:
    """Average readings group by group; scatter of few readings is drawn to that of all groups."""
    grouped = rows.groupby(groups, sort=True)
    mean, count = grouped.mean(), grouped.size()
    squares = grouped["restitution"].var(ddof=0) * count
    freedom = count - 1
    pooled = squares.sum() / max(int(freedom.sum()), 1)
    variance = (squares + _PRIOR_READINGS * pooled) / (freedom + _PRIOR_READINGS)
    sd = np.sqrt(variance / count) if pooled > 0 else 1 / np.sqrt(count)
    return mean.assign(restitution_sd=sd, readings=count).reset_index(drop=True)


def _each(values: pd.Series, function: Callable[[float], float]) -> Array:
    """Apply a function to each different value once."""
    known = {value: function(value) for value in values.unique()}
    return np.asarray(values.map(known), dtype=float)


def _landing_speed(flight: Flight, height: Array) -> Array:
    return -velocity_after(flight, 0.0, fall_time(flight, height))


def _leaving_speed_to(flight: Flight, height: float) -> float:
    return float(brentq(lambda speed: apex(flight, speed)[1] - height, 1e-6, _FASTEST))


def _leaving_speed_for(flight: Flight, interval: float) -> float:
    def time_in_air(speed: float) -> float:
        up, height = apex(flight, speed)
        return up + float(fall_time(flight, height))

    return float(brentq(lambda speed: time_in_air(speed) - interval, 1e-6, _FASTEST))

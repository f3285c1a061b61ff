"""Where the balls of a drop are at any time: flights in air, joined at the impacts."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from tracking.flight import Flight, Floats, apex, fall_time, flight_of_ball, position, velocity
from tracking.render_scene import DropScene

REST_SPEED = 0.01
"""Slower than this (m/s) a ball stays on the plate; balls part at no less. A hop of it is 5 micrometres."""
SEARCH_STEP = 2e-4
"""Spacing of the times at which balls are checked for a meeting, s."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Stretch:
    """A ball from one impact to the next: time (s), height of the centre (m) and velocity (m/s) at its start.

    `flight` is None for a ball at rest.
    """

    time: float
    height: float
    velocity: float = 0.0
    flight: Flight | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Impact:
    """One impact: its time (s), velocities of all balls just before and just after (m/s, upper first)."""

    time: float
    before: tuple[float, ...]
    after: tuple[float, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Drop:
    """All that happens in a scene: the stretches of each ball, upper first, and the impacts; times in s."""

    paths: tuple[tuple[Stretch, ...], ...]
    impacts: tuple[Impact, ...]
    release: float
    end: float


def heights(path: tuple[Stretch, ...], time: ArrayLike) -> Floats:
    """Heights of a ball's centre above the plate (m) at any times (s)."""
    time = np.asarray(time, float)
    result = np.full(time.shape, path[0].height)
    for stretch in path:
        now = time >= stretch.time
        result[now] = _height(stretch, time[now])
    return result


def _height(stretch: Stretch, time: ArrayLike) -> Floats:
    time = np.asarray(time, float)
    if stretch.flight is None:
        return np.full(time.shape, stretch.height)
    return stretch.height + position(stretch.flight, stretch.velocity, time - stretch.time)


def _velocity(stretch: Stretch, time: float) -> float:
    if stretch.flight is None:
        return 0.0
    return float(velocity(stretch.flight, stretch.velocity, time - stretch.time))


def play(scene: DropScene) -> Drop:
    """Let the ball of `scene` go, and follow it to the end of the recording.

    Examples
    --------
    >>> first = play(DropScene(kind="plate", drop_height=0.25)).impacts[0]
    >>> print(f"{first.time:.4f} s: {first.before[0]:.3f} m/s, then {first.after[0]:.3f} m/s")
    0.2895 s: -2.156 m/s, then 1.833 m/s
    """
    balls = zip(scene.masses, scene.radii, strict=True)
    flights = [flight_of_ball(mass, radius, scene.air, scene.gravity) for mass, radius in balls]
    top = scene.contact_height + scene.drop_height
    paths = [[Stretch(time=0, height=top), Stretch(time=scene.hold, height=top, flight=flights[0])]]
    if scene.kind != "plate":
        paths.append([Stretch(time=0, height=scene.radii[1])])
    time, meeting = scene.hold + float(fall_time(flights[0], scene.drop_height)), scene.kind == "two"
    end = time + scene.after
    impacts: list[Impact] = []
    filmed = end + 2 / scene.camera.fps  # the last exposure goes on after the end
    while time <= filmed:
        before = tuple(_velocity(path[-1], time) for path in paths)
        after = _respond(scene, before, meeting=meeting, first=not impacts)
        impacts.append(Impact(time=time, before=before, after=after))
        for path, flight, old, new in zip(paths, flights, before, after, strict=False):
            if new != old:
                height = float(_height(path[-1], time))
                path.append(Stretch(time=time, height=height, velocity=new, flight=flight if new else None))
        time, meeting = _next_impact(scene, paths, time, filmed)
    return Drop(paths=tuple(map(tuple, paths)), impacts=tuple(impacts), release=scene.hold, end=end)


def _respond(scene: DropScene, before: tuple[float, ...], *, meeting: bool, first: bool) -> tuple[float, ...]:
    """Velocities after an impact: the balls meet, or the ball that has a floor bounces on it."""
    if meeting and first and scene.first_rebound is not None:
        return tuple(-before[0] * ratio for ratio in scene.first_rebound)
    if meeting:
        return _part(scene, before)
    restitution = scene.restitution_balls if scene.kind == "held" else scene.restitution_plate
    faller = _faller(scene)
    rebound = -restitution * before[faller]
    return (*before[:faller], rebound if rebound > REST_SPEED else 0.0, *before[faller + 1 :])


def _part(scene: DropScene, before: tuple[float, ...]) -> tuple[float, float]:
    """Velocities after two balls in free flight have met, by momentum and restitution."""
    (upper, lower), (upper_mass, lower_mass) = before, scene.masses
    total = upper_mass + lower_mass
    common = (upper_mass * upper + lower_mass * lower) / total
    opening = max(scene.restitution_balls * (lower - upper), REST_SPEED)
    return common + lower_mass / total * opening, common - upper_mass / total * opening


def _faller(scene: DropScene) -> int:
    """Index of the ball that has a floor under it, which may be the held ball."""
    return 1 if scene.kind == "two" else 0


def _next_impact(scene: DropScene, paths: list[list[Stretch]], time: float, end: float) -> tuple[float, bool]:
    """Time of the next impact (infinite: none), and whether the balls meet in it."""
    floor = scene.radii[1] if scene.kind == "two" else scene.contact_height
    landing = max(_landing(paths[_faller(scene)][-1], floor), time)
    meeting = math.inf
    if scene.kind == "two":
        upper, lower = (path[-1] for path in paths)
        meeting = _meeting(upper, lower, sum(scene.radii), (time, min(landing, end)))
    return min(landing, meeting), meeting < landing


def _landing(ball: Stretch, floor: float) -> float:
    """Time at which a ball comes down on its floor."""
    if ball.flight is None:
        return math.inf
    since, rise = apex(ball.flight, ball.velocity)
    # a ball that starts on its floor may lie a rounding error below it
    return ball.time + since + float(fall_time(ball.flight, max(ball.height + rise - floor, 0.0)))


def _meeting(upper: Stretch, lower: Stretch, reach: float, window: tuple[float, float]) -> float:
    """First time within the window at which the centres are `reach` apart and approach; infinite if never."""

    def gap(time: ArrayLike) -> Floats:
        return _height(upper, time) - _height(lower, time) - reach

    start, stop = window
    if gap(start) < 1e-9 and _velocity(upper, start) <= _velocity(lower, start):
        return start
    times = np.append(np.arange(start, stop, SEARCH_STEP), stop)
    closed = np.flatnonzero(gap(times[1:]) < 0)
    if not closed.size:
        return math.inf
    return float(brentq(gap, times[closed[0]], times[closed[0] + 1], xtol=1e-14))

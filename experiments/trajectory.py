"""The way of a ball after a shot, seen from above, with the cue that struck it."""

from dataclasses import dataclass
from itertools import groupby

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.patches import Circle

from experiments.drawing import DARK, QUIET, SEGMENTS
from impact import Ball, Cloth, CueShot, Motion, Path, Stretch, roll

Array = npt.NDArray[np.float64]

GREEN, RED = SEGMENTS[2], SEGMENTS[5]  # the paper's green and red, in shades that all can tell apart
_DOT = "sliding turns to rolling"
_POINTS = 60  # along a slide
_ROLLED_AT_LEAST = 10  # radii of rolling that are drawn
_STICK = 0.3  # length of the cue over the size of the picture


@dataclass(frozen=True, slots=True, kw_only=True)
class Pen:
    """How a way is drawn, and what the legend calls it."""

    name: str
    color: str
    width: float = 1.8
    style: str = "-"


@dataclass(frozen=True, slots=True, kw_only=True)
class Trajectory:
    """A way in the plane of the table.

    Attributes
    ----------
    legs : tuple of (Motion, ndarray (N, 2))
        In order, m; flights and bounces as one, rolling only as far as the ball had come until then (or 10
        radii).
    rolling_starts : ndarray (2,) or None
        Where sliding turns to rolling, m.
    path : Path
        What it was taken from, until the ball rests.
    """

    legs: tuple[tuple[Motion, Array], ...]
    rolling_starts: Array | None
    path: Path


def trajectory(
    ball: Ball, velocity: npt.ArrayLike, angular_velocity: npt.ArrayLike, cloth: Cloth
) -> Trajectory:
    """Follow a ball from where it was struck.

    Parameters
    ----------
    ball : Ball
        The ball.
    velocity, angular_velocity : (3,) vectors
        After the shot, m/s and rad/s. A ball that is thrown up flies and bounces first.
    cloth : Cloth
        The table.

    Examples
    --------
    >>> cloth = Cloth(friction=0.2, restitution=0.5, gravity=9.8)
    >>> way = trajectory(Ball(mass=0.17, radius=0.0286), (1, 0, 0), (0, 0, 0), cloth)
    >>> way.rolling_starts.round(4).tolist()
    [0.1249, 0.0]
    """
    path = roll(ball, velocity, angular_velocity, cloth)
    legs: list[tuple[Motion, Array]] = []
    rolling_starts = None
    for motion, run in groupby(path.stretches, key=lambda stretch: stretch.motion):
        points = np.concatenate([_points(stretch) for stretch in run])
        if motion is Motion.ROLLING:
            rolling_starts = points[0]
            gone = sum(_length(leg) for _, leg in legs)
            points = _first_part(points, max(gone, _ROLLED_AT_LEAST * ball.radius))
        if motion is not Motion.SPINNING:
            legs.append((motion, points))
    return Trajectory(legs=tuple(legs), rolling_starts=rolling_starts, path=path)


def _points(stretch: Stretch) -> Array:
    """Places along a stretch; seen from above only sliding goes in a curve."""
    count = _POINTS if stretch.motion is Motion.SLIDING else 2
    times = np.linspace(stretch.start, stretch.end, count)
    return np.array([stretch.state_at(float(time))[0][:2] for time in times])


def _length(points: Array) -> float:
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def _first_part(straight: Array, length: float) -> Array:
    """Shorten a straight way to a length."""
    share = min(length / _length(straight), 1.0)
    return np.stack([straight[0], straight[0] + share * (straight[-1] - straight[0])])


def draw_trajectory(axes: Axes, way: Trajectory, pen: Pen) -> None:
    """Draw a way: flight dotted, the rest in one line, a dot where rolling starts."""
    for number, (motion, points) in enumerate(way.legs):
        style = ":" if motion is Motion.FLYING else pen.style
        axes.plot(*points.T, style, color=pen.color, linewidth=pen.width, label=None if number else pen.name)
    if way.rolling_starts is not None:
        named = _DOT in axes.get_legend_handles_labels()[1]
        axes.plot(
            *way.rolling_starts,
            "o",
            color=RED,
            markersize=6,
            markeredgecolor=pen.color,
            label=None if named else _DOT,
            zorder=4,
        )


def draw_stage(axes: Axes, shot: CueShot) -> None:
    """Draw the ball where it lay and the cue that strikes it, from above; call it when all ways are drawn."""
    radius = shot.ball.radius
    axes.add_patch(Circle((0.0, 0.0), radius, fill=False, edgecolor=QUIET, linewidth=1.0))
    normal, cue = np.asarray(shot.normal, dtype=float), np.asarray(shot.cue_velocity, dtype=float)
    tip = radius * normal[:2] / np.linalg.norm(normal)
    low, high = axes.dataLim.get_points()
    size = float(max(*(high - low), 4.0 * radius))
    butt = tip - _STICK * size * cue[:2] / np.linalg.norm(cue)
    axes.plot(
        *np.stack([tip, butt]).T,
        color=GREEN,
        linewidth=4.0,
        solid_capstyle="butt",
        label="cue, seen from above",
    )
    axes.plot(*tip, "s", color=GREEN, markersize=5, markeredgecolor=DARK, zorder=5, label="its tip")
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.08)

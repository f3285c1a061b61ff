"""One cue shot: what it prints, and its impulses, energies and trajectory as a figure."""

from dataclasses import dataclass
from itertools import groupby

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from experiments.drawing import LOWER, QUIET, UPPER, label, new_figure
from experiments.trajectory import Pen, Trajectory, draw_stage, draw_trajectory, trajectory
from impact import Cloth, CueShot, RestitutionLaw, ShotOutcome, collide

Array = NDArray[np.float64]

_CONTACTS = (("tip-ball", UPPER), ("ball-table", LOWER))
_ROOM_FOR_LEGEND = 1.35
_NAMED_FROM = 0.04  # share of the picture that a state must fill to be named
_MOST_LINES = 24  # of states; a cue that jams the ball may take a thousand
_ROUNDING = 1e-9  # share of a vector's largest part that is nothing but rounding error


@dataclass(frozen=True, slots=True, kw_only=True)
class Shot:
    """A shot and what followed.

    Attributes
    ----------
    shot : CueShot
        Who struck what, and where.
    law : RestitutionLaw
        When restitution ended.
    outcome : ShotOutcome
        The impact.
    way : Trajectory or None
        Of the ball afterwards; none where it would bounce or slide for ever.
    """

    shot: CueShot
    law: RestitutionLaw
    outcome: ShotOutcome
    way: Trajectory | None


def compute(shot: CueShot, law: RestitutionLaw = RestitutionLaw.ENERGY) -> Shot:
    """Run the shot and follow the ball.

    Raises
    ------
    ConvergenceError
        If the collision does not end.
    """
    outcome = collide(shot, law=law)
    return Shot(shot=shot, law=law, outcome=outcome, way=_way(shot, outcome))


def _way(shot: CueShot, outcome: ShotOutcome) -> Trajectory | None:
    """Follow the ball on the table of the shot, if it ever comes to rest there."""
    table = shot.ball_table
    if table.friction == 0.0:
        return None
    cloth = Cloth(friction=table.friction, restitution=table.restitution)
    if table.restitution == 1.0 and outcome.velocity[2] > cloth.smallest_bounce:
        return None
    return trajectory(shot.ball, outcome.velocity, outcome.angular_velocity, cloth)


def describe(done: Shot) -> str:
    """Print a shot: a line a state, then velocities, cue, loss and way."""
    outcome = done.outcome
    segments = outcome.segments
    lines = [f"{'':>4} {'state':5} {'events':14} {'I_tip [N s]':>12} {'I_table [N s]':>13}"]
    for number, segment in enumerate(segments[:_MOST_LINES], start=1):
        tip, table = segment.impulses[-1]
        lines.append(f"{number:>4} {segment.state:5} {segment.events:14} {tip:12.6g} {table:13.6g}")
    if len(segments) > _MOST_LINES:
        lines.append(f"     ... and {len(segments) - _MOST_LINES} more states")
    before = float(np.linalg.norm(done.shot.cue_velocity))
    lines += [
        f"ball velocity: {_vector(outcome.velocity)} m/s (z up)",
        f"angular velocity: {_vector(outcome.angular_velocity)} rad/s",
        f"cue speed: {before:.6g} m/s before, {outcome.cue_speed:.6g} m/s after, along its direction",
        f"energy lost: {outcome.energy_loss:.6g} J, law of restitution: {done.law.value}",
    ]
    borrowed = outcome.collision.energy_borrowed
    if borrowed > _ROUNDING * outcome.energy_loss:
        lines.append(f"the law took {borrowed:.6g} J that no contact had stored")
    return "\n".join(lines + _way_lines(done.way))


def _vector(vector: Array) -> str:
    plain = np.where(np.abs(vector) < _ROUNDING * np.abs(vector).max(), 0.0, vector)
    return "(" + ", ".join(f"{part:.6g}" for part in plain) + ")"


def _way_lines(way: Trajectory | None) -> list[str]:
    if way is None:
        return ["then the ball never comes to rest: on such a table it bounces or slides for ever"]
    lines = []
    for motion, run in groupby(way.path.stretches, key=lambda stretch: stretch.motion):
        stretches = list(run)
        end = stretches[-1].end
        x, y, _ = stretches[-1].state_at(end)[0]
        bounces = f" with {len(stretches) - 1} bounces" if len(stretches) > 1 else ""
        lines.append(f"then {motion.value}{bounces} until {end:.4g} s, to ({x:.4g}, {y:.4g}) m")
    return lines


def draw(done: Shot) -> Figure:
    """Draw impulses and energies as they grow, and the way of the ball."""
    figure, ((impulses, energies, table),) = new_figure(12.0, 4.6, 1, 3)
    progress = np.concatenate([segment.impulses.sum(axis=1) for segment in done.outcome.segments])
    _draw_impulses(impulses, done, progress)
    _draw_energies(energies, done, progress)
    _draw_way(table, done)
    for axes in (impulses, energies, table):
        axes.set_title(axes.get_title(loc="left"), loc="left", pad=16)  # above the names of the states
    for axes in (impulses, energies):
        _mark_states(axes, done)
        axes.set_xlim(0.0, progress[-1])
        axes.set_ylim(0.0, _ROOM_FOR_LEGEND * axes.dataLim.ymax)
        axes.set_xlabel("sum of the normal impulses [N s]")
        axes.legend(loc="upper left", edgecolor="none", framealpha=0.9, fontsize=8)
    return figure


def _draw_impulses(axes: Axes, done: Shot, progress: Array) -> None:
    normal = np.concatenate([segment.impulses for segment in done.outcome.segments])
    friction = np.concatenate([segment.tangential_impulses for segment in done.outcome.segments])
    for contact, (name, color) in enumerate(_CONTACTS):
        axes.plot(progress, normal[:, contact], color=color, linewidth=1.8, label=f"{name}, normal")
        size = np.linalg.norm(friction[:, contact], axis=1)
        axes.plot(progress, size, "--", color=color, linewidth=1.2, label=f"{name}, friction")
    label(axes, ("", "impulse so far [N s]", "(a) impulses"))


def _draw_energies(axes: Axes, done: Shot, progress: Array) -> None:
    energy = np.concatenate([segment.elastic_energies for segment in done.outcome.segments])
    for contact, (name, color) in enumerate(_CONTACTS):
        axes.plot(progress, energy[:, contact], color=color, linewidth=1.8, label=name)
    label(axes, ("", "elastic energy [J]", "(b) energy stored in the contacts"))


def _mark_states(axes: Axes, done: Shot) -> None:
    """Part the picture by states, and name those that are wide enough."""
    ends = [float(segment.impulses[-1].sum()) for segment in done.outcome.segments]
    for start, end, state in zip([0.0, *ends], ends, done.outcome.states, strict=False):
        axes.axvline(end, color=QUIET, linewidth=0.8, linestyle=":")
        if end - start > _NAMED_FROM * ends[-1]:
            place = ((start + end) / 2, 1.01)
            axes.annotate(state, place, xycoords=axes.get_xaxis_transform(), ha="center", fontsize=8)


def _draw_way(axes: Axes, done: Shot) -> None:
    if done.way is not None:
        draw_trajectory(axes, done.way, Pen(name="ball (dotted: flying)", color=UPPER))
    draw_stage(axes, done.shot)
    axes.legend(loc="upper left", bbox_to_anchor=(0.0, -0.12), ncols=2, frameon=False, fontsize=8)
    label(axes, ("x [m]", "y [m]", "(c) trajectory, from above"))

"""Table 1: four shots, by two laws of restitution and two readings of the stiffness ratio, and their ways."""

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from calibrate.files import write_whole
from experiments import paper
from experiments.drawing import DARK, SEGMENTS, UPPER, label, new_figure, save_both
from experiments.trajectory import Pen, Trajectory, draw_stage, draw_trajectory, trajectory
from impact import Cloth, RestitutionLaw, ShotOutcome, collide

Array = NDArray[np.float64]

QUANTITIES = ("vx [m/s]", "vy [m/s]", "vz [m/s]", "ωx [rad/s]", "ωy [rad/s]", "ωz [rad/s]")
_DRAWN = ("vertical", "horizontal", "masse")  # (a), (b), (c) of the paper
_CLOTH = Cloth(friction=paper.SHOT_TABLE_FRICTION, restitution=paper.SHOT_TABLE_RESTITUTION)
_PENS = ((SEGMENTS[4], 5.0), (UPPER, 2.2))  # wide below narrow: ways that coincide stay visible
_PRINTED = Pen(name="from the printed velocities", color=DARK, width=1.2, style="--")
_LEVEL = np.array([1.0, 1.0, 0.0])  # the paper's trajectories leave out flight and bounces (footnote 7)


@dataclass(frozen=True, slots=True, kw_only=True)
class Variant:
    """One way to read the model: a law of restitution, and which stiffness is 1.5 times the other."""

    name: str
    law: RestitutionLaw
    stiffness_ratio: float  # k_bt/k_cb


@dataclass(frozen=True, slots=True, kw_only=True)
class Result:
    """One shot by one variant.

    Attributes
    ----------
    variant : Variant
        Law and ratio.
    motion : ndarray (6,)
        Velocity and angular velocity afterwards, m/s and rad/s.
    states : tuple of str
        In order.
    on_the_way : ndarray (states, 6)
        The motion at the end of each state.
    """

    variant: Variant
    motion: Array
    states: tuple[str, ...]
    on_the_way: Array


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """One row of the table: the printed motion (6,) and ours by each variant."""

    shot: str
    printed: Array
    results: tuple[Result, ...]


VARIANTS = tuple(
    Variant(name=f"{name}, {reading} = 1.5", law=law, stiffness_ratio=ratio)
    for reading, ratio in (
        ("k_cb/k_bt", paper.SHOT_STIFFNESS_RATIO),
        ("k_bt/k_cb", 1 / paper.SHOT_STIFFNESS_RATIO),
    )
    for name, law in (("energy", RestitutionLaw.ENERGY), ("Poisson", RestitutionLaw.POISSON))
)


def compute() -> list[Row]:
    """Run every shot by every variant.

    Examples
    --------
    >>> [row.shot for row in compute()]
    ['vertical', 'horizontal', 'jump', 'masse']
    """
    return [
        Row(
            shot=name,
            printed=np.array([*shot.velocity, *shot.angular_velocity]),
            results=tuple(_result(shot, variant) for variant in VARIANTS),
        )
        for name, shot in paper.SHOTS.items()
    ]


def _result(shot: paper.Shot, variant: Variant) -> Result:
    outcome = collide(paper.cue_shot(shot, variant.stiffness_ratio), law=variant.law)
    return Result(
        variant=variant,
        motion=_plain(np.concatenate([outcome.velocity, outcome.angular_velocity])),
        states=outcome.states,
        on_the_way=_on_the_way(outcome),
    )


def _plain(motion: Array) -> Array:
    """Turn rounding errors into plain zeros."""
    return np.where(np.abs(motion) < 1e-9 * np.abs(motion).max(), 0.0, motion)


def _on_the_way(outcome: ShotOutcome) -> Array:
    """Motion of the ball once the impulses of each state have acted: v = M⁻¹ Jᵀ p, (16) and (17)."""
    system = outcome.collision.system
    ends = [
        np.column_stack([segment.impulses[-1], segment.tangential_impulses[-1]]).ravel()
        for segment in outcome.segments
    ]
    jacobian = system.jacobian.reshape(-1, system.velocity.size)
    motion: Array = (np.array(ends) @ jacobian @ system.inverse_mass)[:, 1:]
    return motion


def off_by(motion: Array, printed: Array) -> float:
    """Difference over the printed size, of the velocity or of the angular velocity, whichever is larger."""
    parts = (slice(0, 3), slice(3, 6))
    return max(
        float(np.linalg.norm((motion - printed)[part]) / np.linalg.norm(printed[part])) for part in parts
    )


def nearest(row: Row) -> str:
    """Say which variant comes nearest to the print, and whether only on the way, before its last state."""
    _, number, result = min(
        (
            (off_by(motion, row.printed), number, result)
            for result in row.results
            for number, motion in enumerate(result.on_the_way, start=1)
        ),
        key=lambda candidate: candidate[0],
    )
    error = off_by(result.on_the_way[number - 1], row.printed)
    states = f"after {' '.join(result.states[:number])}"
    if number < len(result.states):
        states += f", before {' '.join(result.states[number:])}"
    return f"nearest to the print: {result.variant.name}, {states}: off by {error:.2%}"


def draw(rows: Sequence[Row]) -> Figure:
    """Draw the ways of the three shots of which the paper draws them."""
    figure, (places,) = new_figure(11.0, 4.8, 1, 3)
    for axes, letter, name in zip(places, "abc", _DRAWN, strict=True):
        row = next(row for row in rows if row.shot == name)
        energy = [result for result in row.results if result.variant.law is RestitutionLaw.ENERGY]
        for (color, width), result in zip(_PENS, energy, strict=True):
            draw_trajectory(axes, way(result.motion), Pen(name=result.variant.name, color=color, width=width))
        draw_trajectory(axes, way(row.printed), _PRINTED)
        draw_stage(axes, paper.cue_shot(paper.SHOTS[name], paper.SHOT_STIFFNESS_RATIO))
        label(axes, ("x [m]", "y [m]", f"({letter}) {title(name)}"))
    figure.suptitle(
        "shots of Table 1 without flight, as in the paper; of the rolling only the beginning", size=9
    )
    handles, names = places[0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=3, frameon=False)
    return figure


def title(shot: str) -> str:
    """Name of a shot as it is written."""
    return {"masse": "massé"}.get(shot, shot)


def way(motion: Array) -> Trajectory:
    """Follow the ball as the paper does, as if it stayed on the table."""
    return trajectory(paper.SHOT_BALL, motion[:3] * _LEVEL, motion[3:], _CLOTH)


def main(out: Path) -> str:
    """Write ``table1.svg``, ``table1.png`` and ``table1.csv``; return the table as text."""
    rows = compute()
    save_both(draw(rows), out, "table1")
    write_whole(out / "table1.csv", _table(rows))
    return "\n\n".join(describe(row) for row in rows)


def describe(row: Row) -> str:
    """Print a shot: the motion by each variant, its difference from the print, and which comes nearest."""
    lines = [
        f"{'Table 1, ' + title(row.shot):25}" + "".join(f"{name:>11}" for name in QUANTITIES) + "  off by"
    ]
    lines.append(_line("printed", row.printed))
    for result in row.results:
        difference = off_by(result.motion, row.printed)
        lines.append(
            f"{_line(result.variant.name, result.motion)}  {difference:6.1%}  {' '.join(result.states)}"
        )
        lines.append(_line("  difference", result.motion - row.printed))
    return "\n".join([*lines, nearest(row)])


def _line(name: str, motion: Array) -> str:
    return f"{name:25}" + "".join(f"{value:>11.4g}" for value in motion)


def _table(rows: Sequence[Row]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    names = [variant.name for variant in VARIANTS]
    columns = [column for name in names for column in (name, f"difference ({name})")]
    writer.writerow(["shot", "quantity", "printed", *columns])
    for row in rows:
        for index, quantity in enumerate(QUANTITIES):
            printed = row.printed[index]
            pairs = [(result.motion[index], result.motion[index] - printed) for result in row.results]
            numbers = [f"{value:.6g}" for pair in pairs for value in pair]
            writer.writerow([row.shot, quantity, f"{printed:.6g}", *numbers])
    return text.getvalue()

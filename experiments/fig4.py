"""Fig. 4: the impulse curve of one two-ball collision, its states, and the elastic energies along it."""

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from calibrate.files import write_whole
from experiments import paper
from experiments.comparison import Compared, comparison_text
from experiments.drawing import DARK, QUIET, SEGMENTS, label, new_figure, save_both
from impact import TwoBallDrop, collide

Array = NDArray[np.float64]

_MOST_ROWS = 9  # of the table; a collapse onto the table may take hundreds of states


@dataclass(frozen=True, slots=True, kw_only=True)
class Stretch:
    """What happens inside one state.

    Attributes
    ----------
    state, events : str
        Such as ``S1`` and ``C2-C1-R2``.
    impulses : ndarray (samples, 2)
        I1 and I2 since the start of the collision, N s.
    energies : ndarray (samples, 2)
        E1 and E2, J.
    velocities : ndarray (2,)
        Of upper and lower ball at the end, m/s.
    """

    state: str
    events: str
    impulses: Array
    energies: Array
    velocities: Array


@dataclass(frozen=True, slots=True, kw_only=True)
class ImpulseCurve:
    """One collision in the plane of impulses.

    Attributes
    ----------
    stretches : tuple of Stretch
        In order.
    ellipse : ndarray (N, 2)
        The bound (15).
    compression_lines : ndarray (2, 2, 2)
        Two points on each of the lines (12): ball-ball, ball-table.
    velocities : ndarray (2,)
        Afterwards, m/s.
    energy_loss : float
        J.
    """

    stretches: tuple[Stretch, ...]
    ellipse: Array
    compression_lines: Array
    velocities: Array
    energy_loss: float


def compute(drop: TwoBallDrop = paper.FIG4_DROP) -> ImpulseCurve:
    """Run the collision and collect what the figure shows.

    Examples
    --------
    >>> [f"{stretch.state} {stretch.events}" for stretch in compute().stretches]
    ['S1 C2-C1-R2', 'S3 A2', 'S1 R1', 'S2 C2-R2']
    """
    collision = collide(drop)
    ellipse = drop.bounding_ellipse()
    return ImpulseCurve(
        stretches=tuple(
            Stretch(
                state=segment.state,
                events=segment.events,
                impulses=segment.impulses,
                energies=segment.elastic_energies,
                velocities=_velocities(drop, segment.impulses[-1]),
            )
            for segment in collision.segments
        ),
        ellipse=ellipse,
        compression_lines=np.stack([_across(line, ellipse) for line in drop.compression_lines()]),
        velocities=collision.velocities,
        energy_loss=collision.energy_loss,
    )


def _velocities(drop: TwoBallDrop, impulses: Array) -> Array:
    """Velocities of both balls once these impulses have acted (13)."""
    first, second = impulses
    return np.array([drop.approach_velocity + first / drop.upper.mass, (second - first) / drop.lower.mass])


def _across(line: Array, ellipse: Array) -> Array:
    """Cut the line ``a I1 + b I2 + c = 0`` (b is never zero) to the width of the ellipse."""
    a, b, c = line
    first = np.array([0.0, ellipse[:, 0].max()])
    return np.stack([first, -(a * first + c) / b], axis=1)


def draw(curve: ImpulseCurve) -> Figure:
    """Draw impulse curve, table of states, and the energy of each contact."""
    figure, axes = new_figure(10.0, 6.6, 2, 2)
    _draw_impulses(axes[0][0], curve)
    _draw_table(axes[0][1], curve)
    for contact in range(2):
        _draw_energies(axes[1][contact], curve.stretches, contact)
    return figure


def _draw_impulses(axes: Axes, curve: ImpulseCurve) -> None:
    axes.plot(*curve.ellipse.T, color=QUIET, linewidth=1.0, label="bound (15)")
    for line, style, name in zip(curve.compression_lines, ("--", ":"), ("ℓ₁", "ℓ₂"), strict=True):
        axes.plot(*line.T, style, color=DARK, linewidth=1.0, label=f"compression line {name}")
    for number, stretch in enumerate(curve.stretches, start=1):
        axes.plot(*stretch.impulses.T, color=_color(number), linewidth=2.2)
        axes.plot(*stretch.impulses[-1], "o", color=DARK, markersize=4)
        if number <= _MOST_ROWS:
            start, end = stretch.impulses[[0, -1]]
            middle = stretch.impulses[
                np.argmin(np.abs(stretch.impulses.sum(axis=1) - (start + end).sum() / 2))
            ]
            axes.annotate(str(number), middle, (6, -12), textcoords="offset points", color=_color(number))
    low, high = curve.ellipse.min(axis=0), curve.ellipse.max(axis=0)
    margin = 0.06 * (high - low)
    axes.set_xlim(low[0] - margin[0], high[0] + margin[0])
    axes.set_ylim(low[1] - margin[1], high[1] + margin[1])
    axes.legend(loc="lower right", fontsize=7.5, frameon=False)
    label(axes, ("I₁, ball-ball [N s]", "I₂, ball-table [N s]", "(a) impulse curve"))


def _draw_table(axes: Axes, curve: ImpulseCurve) -> None:
    axes.set_axis_off()
    axes.set_title("(b) at the end of each state", loc="left")
    shown = curve.stretches[:_MOST_ROWS]
    head = ("", "state", "events", "I₁ [N s]", "I₂ [N s]", "v₁ [m/s]", "v₂ [m/s]")
    cells = [[str(number), *_cells(stretch)] for number, stretch in enumerate(shown, start=1)]
    table = axes.table(cellText=cells, colLabels=head, loc="upper left", cellLoc="center", edges="horizontal")
    table.auto_set_font_size(False)
    table.set_fontsize(8.5)
    table.auto_set_column_width(list(range(len(head))))
    table.scale(1.0, 1.45)
    for number in range(1, len(shown) + 1):
        table[number, 0].set_text_props(color=_color(number), weight="bold")
    more = len(curve.stretches) - len(shown)
    lines = [f"… and {more} more states"] if more else []
    lines += [
        "C compression ends, R restitution ends, A active again",
        f"energy lost: {curve.energy_loss:.4f} J",
    ]
    axes.text(0.0, 0.02, "\n".join(lines), transform=axes.transAxes, fontsize=8.5, va="bottom")


def _cells(stretch: Stretch) -> list[str]:
    numbers = (*stretch.impulses[-1], *stretch.velocities)
    return [
        stretch.state,
        stretch.events,
        *(f"{value:.4f}".replace("-0.0000", "0.0000") for value in numbers),
    ]


def _draw_energies(axes: Axes, stretches: Sequence[Stretch], contact: int) -> None:
    for number, stretch in enumerate(stretches, start=1):
        impulse, energy = stretch.impulses[:, contact], stretch.energies[:, contact]
        axes.plot(impulse, energy, color=_color(number), linewidth=2.0)
        if f"R{contact + 1}" in stretch.events:
            axes.plot(impulse[[-1, -1]], [energy[-1], 0.0], ":", color=DARK, linewidth=1.0)
            axes.annotate("lost ", (impulse[-1], energy[-1] / 2), fontsize=7.5, ha="right", va="center")
    axes.set_ylim(bottom=0.0)
    index, name, letter = (("₁", "ball-ball", "c"), ("₂", "ball-table", "d"))[contact]
    label(axes, (f"I{index} [N s]", f"E{index} [J]", f"({letter}) elastic energy, {name}"))


def _color(number: int) -> str:
    return SEGMENTS[(number - 1) % len(SEGMENTS)]


def describe(curve: ImpulseCurve) -> str:
    """Print a collision: a line a state, then velocities and loss."""
    lines = [f"{'':>3} {'state':5} {'events':12} {'I1 [N s]':>12} {'I2 [N s]':>12}"]
    for number, stretch in enumerate(curve.stretches, start=1):
        first, second = stretch.impulses[-1]
        lines.append(f"{number:>3} {stretch.state:5} {stretch.events:12} {first:12.6g} {second:12.6g}")
    upper, lower = curve.velocities
    lines.append(f"velocities after: upper {upper:.6g} m/s, lower {lower:.6g} m/s (up positive)")
    lines.append(f"energy lost: {curve.energy_loss:.6g} J")
    return "\n".join(lines)


def compare(curve: ImpulseCurve) -> list[Compared]:
    """Set the collision of Fig. 4 beside the paper's numbers."""
    rows = [Compared(quantity="energy loss [J]", ours=curve.energy_loss, printed=paper.FIG4_ENERGY_LOSS)]
    for name, ours, printed in zip(
        ("v1", "v2"), curve.velocities, paper.FIG4_REFERENCE_VELOCITIES, strict=True
    ):
        rows.append(Compared(quantity=f"{name} [m/s] (reference)", ours=float(ours), printed=printed))
    ends = zip(curve.stretches, paper.FIG4_REFERENCE_IMPULSES, strict=True)
    for number, (stretch, reference) in enumerate(ends, start=1):
        for index in range(2):
            quantity = f"I{index + 1} after state {number} (reference)"
            rows.append(
                Compared(quantity=quantity, ours=float(stretch.impulses[-1, index]), printed=reference[index])
            )
    return rows


def main(out: Path) -> str:
    """Write ``fig4.svg``, ``fig4.png`` and ``fig4.csv``; return the comparison with the paper."""
    curve = compute()
    save_both(draw(curve), out, "fig4")
    write_whole(out / "fig4.csv", _table(curve))
    states = " ".join(stretch.state for stretch in curve.stretches)
    text = comparison_text("Fig. 4", compare(curve))
    return f"{text}\nstates: {states}, printed {' '.join(paper.FIG4_STATES)}"


def _table(curve: ImpulseCurve) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["segment", "state", "I1", "I2", "E1", "E2"])
    for number, stretch in enumerate(curve.stretches, start=1):
        for impulses, energies in zip(stretch.impulses, stretch.energies, strict=True):
            numbers = [f"{value:.8g}" for value in (*impulses, *energies)]
            writer.writerow([number, stretch.state, *numbers])
    return text.getvalue()

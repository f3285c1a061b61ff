"""Fig. 3: the ellipse no impulse curve leaves, and the regions into which the compression lines divide it."""

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
from experiments.drawing import DARK, QUIET, SEGMENTS, UPPER, label, new_figure, save_both
from impact import TwoBallDrop, collide

Array = NDArray[np.float64]

_POINTS = 2001  # of the ellipse: its ends lie on every eighth of the way round
# ball-ball, ball-table: does the contact still compress? The text fixes I and IV, the order between is ours
_REGIONS = {"I": (True, True), "II": (False, True), "III": (True, False), "IV": (False, False)}
_LEGEND = """ℓ₁  ball-ball turns to restitution (12)
ℓ₂  ball-table turns to restitution (12)

I    both contacts compress
II   only the ball-table contact compresses
III  only the ball-ball contact compresses
IV  both are past compression:
      here the collision ends"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Ellipse:
    """The feasible impulses of a drop.

    Attributes
    ----------
    outline : ndarray (N, 2)
        I1 and I2 on the bound (15), N s, once around from the origin.
    lines : ndarray (2, 2, 2)
        The chords that the compression lines (12) cut: ends (I1, I2) on ℓ1, then ℓ2.
    regions : dict of str to ndarray (M, 2)
        Outline of each region.
    curve : ndarray (K, 2)
        The impulse curve of Fig. 4.
    angle : float
        From the I1 axis to the nearer axis of the ellipse, rad.
    centre : ndarray (2,)
        N s.
    """

    outline: Array
    lines: Array
    regions: dict[str, Array]
    curve: Array
    angle: float
    centre: Array


def compute(drop: TwoBallDrop = paper.FIG4_DROP) -> Ellipse:
    """Find outline, axes and regions from the equations of ellipse and lines, not from the printed formulas.

    Examples
    --------
    >>> compute().centre.round(6).tolist()
    [3.0, 3.0]
    """
    outline = drop.bounding_ellipse(_POINTS)
    lines = drop.compression_lines()
    centre = outline[:-1].mean(axis=0)
    axes = np.linalg.eigh(np.cov(outline[:-1].T)).eigenvectors
    flattest = axes[:, np.argmax(np.abs(axes[0]))]
    return Ellipse(
        outline=outline,
        lines=np.stack([_chord(outline, line) for line in lines]),
        regions={name: _region(outline, lines, kept) for name, kept in _REGIONS.items()},
        curve=np.concatenate([segment.impulses for segment in collide(drop).segments]),
        angle=float(np.arctan(flattest[1] / flattest[0])),
        centre=centre,
    )


def _region(outline: Array, lines: Array, compressing: Sequence[bool]) -> Array:
    """Part of the ellipse in which each contact compresses or not: normal velocities (12) below or above 0.

    The second of (12) is written as I1 - I2 = 0, which is the velocity with its sign turned.
    """
    region = outline
    for line, sign, compresses in zip(lines, (1.0, -1.0), compressing, strict=True):
        region = _cut(region, sign * line * (-1.0 if compresses else 1.0))
    return region


def _cut(polygon: Array, line: Array) -> Array:
    """Keep of a convex polygon what lies where ``a I1 + b I2 + c >= 0``."""
    side = polygon @ line[:2] + line[2]
    kept = []
    for start, end, here, there in zip(polygon[:-1], polygon[1:], side[:-1], side[1:], strict=True):
        if here >= 0.0:
            kept.append(start)
        if here * there < 0.0:
            kept.append(start + (end - start) * here / (here - there))
    return np.array([*kept, kept[0]])


def _chord(outline: Array, line: Array) -> Array:
    """Give the ends of the part of a line within the ellipse."""
    on_line = _cut(outline, line)
    return on_line[np.argsort(np.abs(on_line @ line[:2] + line[2]))[:2]]


def draw(ellipse: Ellipse) -> Figure:
    """Draw the ellipse with its regions, compression lines, axis and the impulse curve of Fig. 4."""
    figure, ((axes,),) = new_figure(8.0, 6.2)
    for color, (name, region) in zip(SEGMENTS, ellipse.regions.items(), strict=False):
        axes.fill(*region.T, color=color, alpha=0.22, linewidth=0.0)
        axes.annotate(name, tuple(_middle(region)), ha="center", va="center", fontsize=15)
    axes.plot(*ellipse.outline.T, color=DARK, linewidth=1.6, label="bound (15)")
    for line, style, name in zip(ellipse.lines, ("--", ":"), ("ℓ₁", "ℓ₂"), strict=True):
        axes.plot(*line.T, style, color=DARK, linewidth=1.2)
        axes.annotate(name, line[1], (6, 4), textcoords="offset points", fontsize=11)
    axes.plot(*ellipse.curve.T, color=UPPER, linewidth=2.0)
    axes.annotate(
        "impulse curve\nof Fig. 4",
        ellipse.curve[len(ellipse.curve) // 4],
        (5.4, 0.6),
        color=UPPER,
        ha="center",
        arrowprops={"arrowstyle": "-", "color": UPPER, "linewidth": 0.7},
    )
    _draw_axis(axes, ellipse)
    axes.set_aspect("equal", anchor="W")
    axes.text(1.06, 0.5, _LEGEND, transform=axes.transAxes, va="center", linespacing=1.5, fontsize=8.5)
    label(axes, ("I₁, ball-ball [N s]", "I₂, ball-table [N s]", "feasible impulses of the drop in Fig. 4"))
    return figure


def _draw_axis(axes: Axes, ellipse: Ellipse) -> None:
    """Mark the centre and the axis that is turned by θ."""
    way = np.array([np.cos(ellipse.angle), np.sin(ellipse.angle)])
    reach = np.abs((ellipse.outline - ellipse.centre) @ way).max()
    ends = ellipse.centre + reach * np.outer([-1.0, 1.0], way)
    axes.plot(*ends.T, color=QUIET, linewidth=1.0)
    axes.plot(*ellipse.centre, "o", color=DARK, markersize=4)
    axes.annotate(
        f"axis, θ = {np.degrees(ellipse.angle):.1f}°".replace("-", "−"),
        ends[1],
        (6, -4),
        textcoords="offset points",
        fontsize=8,
        va="top",
    )


def _middle(polygon: Array) -> Array:
    """Centre of area of a closed polygon."""
    start, end = polygon[:-1], polygon[1:]
    twice = start[:, 0] * end[:, 1] - end[:, 0] * start[:, 1]
    middle: Array = ((start + end) * twice[:, np.newaxis]).sum(axis=0) / (3.0 * twice.sum())
    return middle


def compare(ellipse: Ellipse, drop: TwoBallDrop = paper.FIG4_DROP) -> list[Compared]:
    """Set the ellipse beside what the text says of it."""
    along = np.array([np.cos(ellipse.angle), np.sin(ellipse.angle)])
    across = np.array([-along[1], along[0]])
    ends = [ellipse.outline[np.argmax(ellipse.outline @ way)] for way in ((1, 0), (0, 1), (0, -1))]
    ours = [
        ellipse.angle,
        *(ellipse.centre @ along, ellipse.centre @ across, np.linalg.norm(ellipse.centre)),
        *ends[0],
        *ends[1][::-1],
        *ends[2][::-1],
    ]
    return [
        Compared(quantity=quantity, ours=float(value), printed=printed)
        for (quantity, printed), value in zip(paper.printed_ellipse(drop).items(), ours, strict=True)
    ]


def main(out: Path) -> str:
    """Write ``fig3.svg``, ``fig3.png`` and ``fig3.csv``; return the comparison with the paper."""
    ellipse = compute()
    save_both(draw(ellipse), out, "fig3")
    write_whole(out / "fig3.csv", _table(ellipse))
    return comparison_text("Fig. 3", compare(ellipse))


def _table(ellipse: Ellipse) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["what", "I1", "I2"])
    lines = {"compression line 1": ellipse.lines[0], "compression line 2": ellipse.lines[1]}
    for what, points in {"ellipse": ellipse.outline, **lines, "impulse curve": ellipse.curve}.items():
        for first, second in points:
            writer.writerow([what, f"{first:.8g}", f"{second:.8g}"])
    return text.getvalue()

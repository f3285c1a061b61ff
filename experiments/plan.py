"""The verb `plan`: which trials would settle the stiffness ratio with a stated camera and stated balls."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from experiments.verbs import announce_compilation, verb

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from calibrate.plan import Plan
    from calibrate.setup import Setup

EPILOG = "Example: impactlab plan --mass 0.0027 --mass 0.0054 --fps 240 --two 10 --held 8 --plate 8"


@verb
def plan(
    out: Annotated[Path, typer.Option(help="Folder to write to; made when missing.")] = Path("plan"),
    fps: Annotated[float, typer.Option(help="Frames captured a second.")] = 240.0,
    pixels: Annotated[float, typer.Option(help="Of the picture, along the fall.")] = 1080.0,
    field_of_view: Annotated[float, typer.Option(help="Height of the picture, m.")] = 1.0,
    noise_px: Annotated[float, typer.Option(help="Scatter of a ball's place in a frame, pixels.")] = 0.2,
    height: Annotated[list[float], typer.Option(help="Drop height, m; name several.")] = [0.3, 0.5, 0.7],  # noqa: B006
    repeatability: Annotated[
        float, typer.Option(help="Relative scatter of rebounds from trial to trial.")
    ] = 0.02,
    mass: Annotated[
        list[float], typer.Option(help="Of a ball at hand, kg; name several: each is paired with each.")
    ] = [0.0027],  # noqa: B006
    two: Annotated[int, typer.Option(help="Two-ball trials with the first mass on its like.")] = 10,
    held: Annotated[int, typer.Option(help="Drops on a held ball.")] = 8,
    plate: Annotated[int, typer.Option(help="Drops on the plate.")] = 8,
    ball_ball: Annotated[float, typer.Option(help="Ball-ball restitution expected.")] = 0.81,
    ball_table: Annotated[float, typer.Option(help="Ball-table restitution expected.")] = 0.85,
    ratio: Annotated[
        list[float] | None, typer.Option(help="Candidate k2/k1; name several. Else 0.5 to 50.")
    ] = None,
    exponent: Annotated[float, typer.Option(help="Of the force law: 1 linear, 1.5 Hertz.")] = 1.0,
) -> None:
    """Tell which stiffness ratios an experiment could not tell apart, and the fewest trials that would."""
    announce_compilation()
    from calibrate.landscape import landscape
    from calibrate.plan import CANDIDATES, expected, smallest_addition
    from calibrate.setup import Setup
    from calibrate.simulate import Design
    from experiments import plan_plot

    setup = Setup(
        fps=fps,
        pixels=pixels,
        field_of_view=field_of_view,
        noise_px=noise_px,
        heights=tuple(height),
        repeatability=repeatability,
    )
    pairs, candidates = mass_pairs(mass), tuple(ratio or CANDIDATES)
    view = landscape(tuple(pairs), (ball_ball, ball_table), candidates, exponent)
    design = Design(plate=plate, held=held, two={1.0: two})
    asked = expected(view, setup, design, candidates)
    better = None if asked.settles else smallest_addition(view, setup, design, candidates)
    plan_plot.main(out, view, asked, better)
    typer.echo(plan_text(setup, pairs, asked, better))


def mass_pairs(masses: "Sequence[float]") -> dict[float, tuple[float, float]]:
    """Pair every mass with every other and with its like: mass ratio to (upper, lower), kg.

    Examples
    --------
    >>> mass_pairs([0.0027, 0.0054])
    {1.0: (0.0027, 0.0027), 0.5: (0.0027, 0.0054), 2.0: (0.0054, 0.0027)}
    """
    for mass in masses:
        if not 0 < mass < float("inf"):
            raise ValueError(f"mass must be above zero and finite, got {mass}")
    pairs: dict[float, tuple[float, float]] = {}
    for upper in masses:
        for lower in masses:
            pairs.setdefault(float(f"{upper / lower:.6g}"), (upper, lower))
    return pairs


def plan_text(
    setup: "Setup", pairs: "Mapping[float, tuple[float, float]]", asked: "Plan", better: "Plan | None"
) -> str:
    """Print what to expect: precision of a trial, a line a candidate, and the addition that helps."""
    design = asked.design
    rebounds = setup.rebound_scatter((0.8, 0.2)) / (0.8, 0.2)
    lines = [
        f"a trial tells v1/|v0| to {rebounds[0]:.1%} and v2/|v0| to {rebounds[1]:.1%} (at 0.8 and 0.2),"
        f" {setup.repeatability:.1%} of it not the camera's",
        f"asked about: {_count(sum(design.two.values()))} of two equal balls, {_count(design.held)} on a held"
        f" ball, {_count(design.plate)} on the plate",
        *_table(asked),
    ]
    if asked.settles:
        return "\n".join([*lines, "every candidate would come out as one value: nothing to add"])
    if better is None:
        return "\n".join([*lines, f"no addition of at most 20 trials a kind helps{_hint(pairs)}"])
    words = " and ".join(_addition(kind, count, pairs) for kind, count in better.added.items())
    left = (
        "every candidate comes out as one value"
        if better.settles
        else f"of {_number(asked.unsettled)} left open {_number(better.unsettled)} stay so{_hint(pairs)}"
    )
    return "\n".join([*lines, f"fewest trials that help: add {words}; {left}", *_table(better)])


def _table(plan: "Plan") -> list[str]:
    from calibrate.report import interval_text

    lines = [f"{'k2/k1':>8}  {'expected verdict':<20}  95 % set expected"]
    for each in plan.expectations:
        sets = " or ".join(interval_text(pair) for pair in each.intervals)
        lines.append(f"{each.truth:>8g}  {each.verdict:<20}  {sets}")
    return lines


def _addition(kind: str | float, count: int, pairs: "Mapping[float, tuple[float, float]]") -> str:
    if isinstance(kind, str):
        return f"{_count(count)} of kind {kind}"
    upper, lower = pairs[kind]
    return f"{_count(count)} of {upper:g} kg on {lower:g} kg"


def _hint(pairs: "Mapping[float, tuple[float, float]]") -> str:
    return "; a ball of another mass might (--mass)" if len(pairs) == 1 else ""


def _count(trials: int) -> str:
    return "1 trial" if trials == 1 else f"{trials} trials"


def _number(candidates: int) -> str:
    return "1 candidate" if candidates == 1 else f"{candidates} candidates"

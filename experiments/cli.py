"""`impactlab`: thin verbs over the rooms. Each imports what it needs when it runs: help comes at once."""

import functools
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ParamSpec

import typer

if TYPE_CHECKING:
    import pandas as pd

Parameters = ParamSpec("Parameters")

SOME_FAILED, WRONG_USE = 1, 2
app = typer.Typer(
    help="Film simultaneous collisions, measure them, and fit the impact model to them.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
simulate = typer.Typer(help="Run one collision from numbers on the command line.", no_args_is_help=True)
app.add_typer(simulate, name="simulate")

FIGURES = ("fig4", "fig5")
Out = Annotated[Path, typer.Option(help="Folder to write to; made when missing.")]


def verb(function: Callable[Parameters, None]) -> Callable[Parameters, None]:
    """Turn what a user can put right into one sentence on stderr and exit code 2."""

    @functools.wraps(function)
    def guarded(*args: Parameters.args, **kwargs: Parameters.kwargs) -> None:
        try:
            function(*args, **kwargs)
        except OSError as error:
            fail(f"{error.filename}: {error.strerror}" if error.filename else str(error))
        except (ValueError, RuntimeError) as error:
            fail(str(error))

    return guarded


def fail(sentence: str) -> None:
    """Say what is wrong and end with the exit code for wrong use."""
    typer.echo(f"impactlab: {sentence}", err=True)
    raise typer.Exit(WRONG_USE)


@app.command(epilog="Example: impactlab fit trials.csv --out results")
@verb
def fit(
    trials: Annotated[list[Path], typer.Argument(help="Trial tables, CSV.", metavar="TRIALS.csv...")],
    out: Out = Path("out"),
    exponent: Annotated[float, typer.Option(help="Of the force law: 1 linear, 1.5 Hertz.")] = 1.0,
    ball_ball: Annotated[
        tuple[float, float] | None,
        typer.Option(help="Ball-ball restitution known from elsewhere: value, sd."),
    ] = None,
    ball_table: Annotated[
        tuple[float, float] | None,
        typer.Option(help="Ball-table restitution known from elsewhere: value, sd."),
    ] = None,
) -> None:
    """Fit restitutions and stiffness ratio to trial tables; write fit.json, fig5 and profile."""
    from calibrate.fit import fit_stiffness_ratio
    from calibrate.trials import read_trials
    from experiments import fig5, profile_plot
    from experiments.provenance import provenance

    table = read_trials(trials)
    origin = provenance(trials, {"exponent": exponent, "ball_ball": ball_ball, "ball_table": ball_table})
    calibration = fit_stiffness_ratio(
        table, exponent=exponent, ball_ball=ball_ball, ball_table=ball_table, provenance=origin
    )
    calibration.save(out / "fit.json")
    if calibration.pairs:
        fig5.main(out, table, calibration)
        profile_plot.main(out, calibration)
    typer.echo(str(calibration))
    complain_of_failed(table)


@app.command(epilog="Example: impactlab figures fig4 fig5 --out figures")
@verb
def figures(
    names: Annotated[
        list[str] | None, typer.Argument(help="All without a name.", metavar="[NAME]...")
    ] = None,
    out: Out = Path("figures"),
) -> None:
    """Recreate the paper's figures and tables; print ours, printed, difference."""
    import importlib

    for name in names or FIGURES:
        if name not in FIGURES:
            raise ValueError(f"figure must be one of {', '.join(FIGURES)}, got {name!r}")
        typer.echo(importlib.import_module(f"experiments.{name}").main(out))


@simulate.command(epilog="Example: impactlab simulate drop --stiffness-ratio 10 --approach-velocity -3")
@verb
def drop(
    stiffness_ratio: Annotated[float, typer.Option(help="Ball-table over ball-ball, k2/k1.")] = 10.0,
    ball_ball: Annotated[float, typer.Option(help="Ball-ball restitution.")] = 0.81,
    ball_table: Annotated[float, typer.Option(help="Ball-table restitution.")] = 0.85,
    upper_mass: Annotated[float, typer.Option(help="kg")] = 0.0027,
    lower_mass: Annotated[float, typer.Option(help="kg")] = 0.0027,
    approach_velocity: Annotated[float, typer.Option(help="m/s, up positive.")] = -3.0,
    exponent: Annotated[float, typer.Option(help="Of the force law: 1 linear, 1.5 Hertz.")] = 1.0,
    plot: Annotated[
        Path | None, typer.Option(help="Draw impulse curve and energies: FILE.svg or .png.")
    ] = None,
) -> None:
    """Drop a ball on a ball that rests on a table: states, impulses, velocities."""
    from experiments.drawing import save_figure
    from experiments.fig4 import compute, describe, draw
    from impact import Ball, Contact, TwoBallDrop

    curve = compute(
        TwoBallDrop(
            upper=Ball(mass=upper_mass, radius=0.020),
            lower=Ball(mass=lower_mass, radius=0.020),
            ball_ball=Contact(restitution=ball_ball, stiffness=1.0, exponent=exponent),
            ball_table=Contact(restitution=ball_table, stiffness=stiffness_ratio, exponent=exponent),
            approach_velocity=approach_velocity,
        )
    )
    typer.echo(describe(curve))
    if plot:
        save_figure(draw(curve), plot)


def complain_of_failed(table: "pd.DataFrame") -> None:
    """Name the failed trials on stderr and end with exit code 1 if there are any."""
    failed = table[table["status"] == "failed"]
    for name, reason in zip(failed["trial"], failed["reason"], strict=True):
        typer.echo(f"impactlab: {name} failed: {reason}", err=True)
    if len(failed):
        raise typer.Exit(SOME_FAILED)


def main() -> None:
    """Run the command line."""
    app()

"""The verb `fit`: tables in; restitution, stiffness ratio and figures out."""

import json
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from experiments.fitting import (
    Known,
    calibrated,
    compare_laws,
    draw_again,
    draw_contours,
    failed_trials,
    fit_readings,
    fit_shots,
    hold_readings,
    kinds_in,
)
from experiments.run import Json, leave_report, print_json
from experiments.verbs import SOME_FAILED, announce_compilation, verb

MODELLED = {"two", "shot"}
"""Kinds of trials that are held against the model of two contacts, which has to be compiled."""
EPILOG = "Example: impactlab fit trials.csv --out results"


@verb
def fit(
    tables: Annotated[
        list[Path],
        typer.Argument(
            help="Tables of trials, or of rebound heights and intervals.", metavar="TRIALS.csv..."
        ),
    ],
    out: Annotated[Path, typer.Option(help="Folder to write to; made when missing.")] = Path("out"),
    exponent: Annotated[float, typer.Option(help="Of the force law: 1 linear, 1.5 Hertz.")] = 1.0,
    ball_ball: Annotated[
        Known, typer.Option(help="Ball-ball restitution known from elsewhere: value, sd.")
    ] = None,
    ball_table: Annotated[
        Known, typer.Option(help="Ball-table restitution known from elsewhere: value, sd.")
    ] = None,
    force_law: Annotated[
        bool, typer.Option("--force-law", help="Also compare linear, Hertz and a free exponent.")
    ] = False,
    contours: Annotated[
        bool, typer.Option("--contours", help="Also draw chi-square over k2/k1 and e1.")
    ] = False,
    bootstrap: Annotated[
        int, typer.Option(help="Also draw the trials again so many times, as a second opinion.")
    ] = 0,
    ball: Annotated[
        list[str] | None,
        typer.Option(
            help="For heights and intervals: NAME=MASS,DIAMETER (kg, m) of a ball, to allow for air."
        ),
    ] = None,
    shot_ball: Annotated[
        tuple[float, float], typer.Option(help="For shots: mass and diameter of the cue ball, kg, m.")
    ] = (0.17, 0.05715),
    cue_mass: Annotated[float, typer.Option(help="For shots: of the cue, kg.")] = 0.54,
    fix: Annotated[
        list[str] | None, typer.Option(help="For shots: NAME=VALUE of a parameter not to be fitted.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Fit restitutions and stiffness ratio to tables; write fit.json, figures and report.html.

    Tables of rebound heights or of times between bounces give restitution over speed instead, and shots the
    contacts of tip and cloth.
    """
    from calibrate.rows import TrialTableError

    say = partial(typer.echo, err=as_json)  # JSON stands alone on standard output
    written: list[str] = []
    if hold_readings(tables):
        failed = fit_readings(tables, out, bodies_of(ball or []), say)
        written = ["restitution"]
    else:
        options = {"exponent": exponent, "ball_ball": ball_ball, "ball_table": ball_table}
        there = kinds_in(tables)
        if there & MODELLED:
            announce_compilation()
        failed = failed_trials(tables)
        if "shot" in there:
            try:
                say(fit_shots(tables, out, (*shot_ball, cue_mass), fixed_of(fix or [])))
                written.append("shot_fit")
            except TrialTableError as error:
                if there == {"shot"}:
                    raise
                failed.append(str(error))
        if there - {"shot"}:
            calibration = calibrated(tables, out, options)
            say(calibration)
            written.append("fit")
            if contours and calibration.pairs:
                draw_contours(tables, out, calibration, options)
            if bootstrap and calibration.pairs:
                for opinion in draw_again(tables, calibration, bootstrap, options):
                    say(opinion)
        if force_law:
            say(f"\n{compare_laws(tables, out, ball_ball, ball_table)}")
            written.append("force_law")
    leave_report(out, "fit", quiet=as_json)
    if as_json:
        print_json({name: json.loads((out / f"{name}.json").read_bytes()) for name in written})
    for sentence in failed:
        typer.echo(f"impactlab: {sentence}", err=True)
    if failed:
        raise typer.Exit(SOME_FAILED)


def bodies_of(words: Sequence[str]) -> dict[str, tuple[float, float]]:
    """Understand NAME=MASS,DIAMETER.

    Examples
    --------
    >>> bodies_of(["ping pong=0.0027,0.040"])
    {'ping pong': (0.0027, 0.04)}
    """
    bodies = {}
    for word in words:
        name, _, numbers = word.rpartition("=")
        try:
            mass, diameter = (float(number) for number in numbers.split(","))
        except ValueError:
            raise ValueError(f"ball must be NAME=MASS,DIAMETER in kg and m, got {word!r}") from None
        bodies[name] = (mass, diameter)
    return bodies


def fixed_of(words: Sequence[str]) -> dict[str, float]:
    """Understand NAME=VALUE.

    Examples
    --------
    >>> fixed_of(["tip_ball_friction=0.6"])
    {'tip_ball_friction': 0.6}
    """
    fixed = {}
    for word in words:
        name, _, value = word.partition("=")
        try:
            fixed[name] = float(value)
        except ValueError:
            raise ValueError(f"fix must be NAME=VALUE, got {word!r}") from None
    return fixed

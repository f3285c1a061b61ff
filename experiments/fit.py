"""The verb `fit`: tables in; restitution, stiffness ratio and figures out."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from experiments.verbs import SOME_FAILED, verb

if TYPE_CHECKING:
    from calibrate.estimate import Calibration

EPILOG = "Example: impactlab fit trials.csv --out results"
Known = tuple[float, float] | None


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
) -> None:
    """Fit restitutions and stiffness ratio to tables; write fit.json and figures.

    Tables of rebound heights or of times between bounces give restitution over speed instead, and shots the
    contacts of tip and cloth.
    """
    from calibrate.readings import holds_readings
    from calibrate.rows import TrialTableError

    kinds = {holds_readings(table) for table in tables}
    if kinds == {True, False}:
        raise ValueError("tables of trials and of rebound heights or intervals are fitted one kind at a time")
    if kinds == {True}:
        failed = fit_readings(tables, out, bodies_of(ball or []))
    else:
        options = {"exponent": exponent, "ball_ball": ball_ball, "ball_table": ball_table}
        there = kinds_in(tables)
        failed = failed_trials(tables)
        if "shot" in there:
            try:
                fit_shots(tables, out, (*shot_ball, cue_mass), fixed_of(fix or []))
            except TrialTableError as error:
                if there == {"shot"}:
                    raise
                failed.append(str(error))
        if there - {"shot"}:
            calibration = calibrated(tables, out, options)
            if contours and calibration.pairs:
                draw_contours(tables, out, calibration, options)
            if bootstrap and calibration.pairs:
                draw_again(tables, calibration, bootstrap, options)
        if force_law:
            compare_laws(tables, out, ball_ball, ball_table)
    for sentence in failed:
        typer.echo(f"impactlab: {sentence}", err=True)
    if failed:
        raise typer.Exit(SOME_FAILED)


def calibrated(tables: Sequence[Path], out: Path, options: dict[str, Any]) -> "Calibration":
    """Fit trial tables, write fit.json and the figures, print verdict and values."""
    from calibrate.fit import fit_stiffness_ratio
    from calibrate.trials import read_trials
    from experiments import fig5, profile_plot
    from experiments.provenance import provenance

    table = read_trials(tables)
    calibration = fit_stiffness_ratio(table, **options, provenance=provenance(tables, options))
    calibration.save(out / "fit.json")
    if calibration.pairs:
        fig5.main(out, table, calibration)
        profile_plot.main(out, calibration)
    typer.echo(str(calibration))
    return calibration


def kinds_in(tables: Sequence[Path]) -> set[str]:
    """Kinds of the usable trials; of all of them, if none is usable, so that the fit can say so."""
    from calibrate.trials import read_trials

    trials = read_trials(tables)
    usable = trials[trials["status"] == "ok"]
    return set(usable["kind"]) or set(trials["kind"]) - {"shot"} or {"shot"}


def fit_shots(
    tables: Sequence[Path], out: Path, sizes: tuple[float, float, float], fixed: dict[str, float]
) -> None:
    """Fit the contacts of shots (sizes: mass, diameter, cue mass); print, and write shot_fit.json."""
    from calibrate.shot_fit import fit_shot
    from calibrate.trials import read_trials
    from impact import Ball, Cue

    mass, diameter, cue_mass = sizes
    ball, cue = Ball(mass=mass, radius=diameter / 2), Cue(mass=cue_mass)
    calibration = fit_shot(read_trials(tables), ball=ball, cue=cue, fixed=fixed)
    calibration.save(out / "shot_fit.json")
    typer.echo(str(calibration))


def draw_contours(
    tables: Sequence[Path], out: Path, calibration: "Calibration", options: dict[str, Any]
) -> None:
    """Draw chi-square over the stiffness ratio and the ball-ball restitution."""
    from calibrate.contours import contours
    from calibrate.fit import misfit_of
    from calibrate.trials import read_trials
    from experiments import contour_plot

    surface = contours(misfit_of(read_trials(tables), **options), calibration)
    contour_plot.main(out, surface, calibration)


def draw_again(
    tables: Sequence[Path], calibration: "Calibration", times: int, options: dict[str, Any]
) -> None:
    """Draw the experiment again, by trial and from the fit, and print where the best values fall."""
    import numpy as np

    from calibrate.bootstrap import bootstrap
    from calibrate.trials import read_trials

    known = {name: options[name] for name in ("ball_ball", "ball_table")}
    for opinion in bootstrap(read_trials(tables), calibration, np.random.default_rng(0), times, **known):
        typer.echo(str(opinion))


def compare_laws(tables: Sequence[Path], out: Path, ball_ball: Known, ball_table: Known) -> None:
    """Fit linear, Hertz and every exponent between 1 and 2; print, and write force_law.json."""
    import json
    from dataclasses import asdict

    from calibrate.files import write_whole
    from calibrate.fit import misfit_of
    from calibrate.force_law import compare_force_laws
    from calibrate.trials import read_trials

    laws = compare_force_laws(misfit_of(read_trials(tables), ball_ball=ball_ball, ball_table=ball_table))
    write_whole(out / "force_law.json", json.dumps(asdict(laws), indent=1) + "\n")
    typer.echo(f"\n{laws}")


def fit_readings(tables: Sequence[Path], out: Path, bodies: dict[str, tuple[float, float]]) -> list[str]:
    """Fit rebound heights and bounce intervals, print and draw; a sentence for each line left out."""
    from calibrate.readings import read_readings
    from experiments import speed_plot
    from experiments.rebounds import results, results_text

    readings = [read_readings(table) for table in tables]
    found = results(readings, bodies)
    speed_plot.main(out, found)
    typer.echo(results_text(found))
    return [f"{sentence}; left out" for each in readings for sentence in each.failed]


def failed_trials(tables: Sequence[Path]) -> list[str]:
    """Name the trials that were left out, and why."""
    from calibrate.trials import read_trials

    table = read_trials(tables)
    failed = table[table["status"] == "failed"]
    return [
        f"{name} failed: {reason}" for name, reason in zip(failed["trial"], failed["reason"], strict=True)
    ]


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

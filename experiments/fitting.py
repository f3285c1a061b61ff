"""What the verb `fit` does with its tables, one function a task; each imports what it needs when it runs."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from calibrate.bootstrap import Bootstrap
    from calibrate.estimate import Calibration
    from calibrate.force_law import ForceLaws
    from calibrate.shot_fit import ShotCalibration

Known = tuple[float, float] | None


def hold_readings(tables: Sequence[Path]) -> bool:
    """Tell tables of rebound heights or intervals from tables of trials.

    Raises
    ------
    ValueError
        If there are both.
    """
    from calibrate.readings import holds_readings

    kinds = {holds_readings(table) for table in tables}
    if kinds == {True, False}:
        raise ValueError("tables of trials and of rebound heights or intervals are fitted one kind at a time")
    return kinds == {True}


def calibrated(tables: Sequence[Path], out: Path, options: dict[str, Any]) -> "Calibration":
    """Fit trial tables, write fit.json and the figures."""
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
    return calibration


def kinds_in(tables: Sequence[Path]) -> set[str]:
    """Kinds of the usable trials; of all of them, if none is usable, so that the fit can say so."""
    from calibrate.trials import read_trials

    trials = read_trials(tables)
    usable = trials[trials["status"] == "ok"]
    return set(usable["kind"]) or set(trials["kind"]) - {"shot"} or {"shot"}


def fit_shots(
    tables: Sequence[Path], out: Path, sizes: tuple[float, float, float], fixed: dict[str, float]
) -> "ShotCalibration":
    """Fit the contacts of shots (sizes: mass, diameter, cue mass), and write shot_fit.json."""
    from calibrate.shot_fit import fit_shot
    from calibrate.trials import read_trials
    from impact import Ball, Cue

    mass, diameter, cue_mass = sizes
    ball, cue = Ball(mass=mass, radius=diameter / 2), Cue(mass=cue_mass)
    calibration = fit_shot(read_trials(tables), ball=ball, cue=cue, fixed=fixed)
    calibration.save(out / "shot_fit.json")
    return calibration


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
) -> "Sequence[Bootstrap]":
    """Draw the experiment again, by trial and from the fit: where the best values fall."""
    import numpy as np

    from calibrate.bootstrap import bootstrap
    from calibrate.trials import read_trials

    known = {name: options[name] for name in ("ball_ball", "ball_table")}
    return bootstrap(read_trials(tables), calibration, np.random.default_rng(0), times, **known)


def compare_laws(tables: Sequence[Path], out: Path, ball_ball: Known, ball_table: Known) -> "ForceLaws":
    """Fit linear, Hertz and every exponent between 1 and 2, and write force_law.json."""
    import json
    from dataclasses import asdict

    from calibrate.files import write_whole
    from calibrate.fit import misfit_of
    from calibrate.force_law import compare_force_laws
    from calibrate.trials import read_trials

    laws = compare_force_laws(misfit_of(read_trials(tables), ball_ball=ball_ball, ball_table=ball_table))
    write_whole(out / "force_law.json", json.dumps(asdict(laws), indent=1) + "\n")
    return laws


def fit_readings(
    tables: Sequence[Path],
    out: Path,
    bodies: dict[str, tuple[float, float]],
    say: Callable[[str], None],
) -> list[str]:
    """Fit rebound heights and bounce intervals, say and draw; give a sentence for each line left out."""
    from calibrate.readings import read_readings
    from experiments import speed_plot
    from experiments.rebounds import results, results_text

    readings = [read_readings(table) for table in tables]
    found = results(readings, bodies)
    speed_plot.main(out, found)
    say(results_text(found))
    return [f"{sentence}; left out" for each in readings for sentence in each.failed]


def failed_trials(tables: Sequence[Path]) -> list[str]:
    """Name the trials that were left out, and why."""
    from calibrate.trials import read_trials

    table = read_trials(tables)
    failed = table[table["status"] == "failed"]
    return [
        f"{name} failed: {reason}" for name, reason in zip(failed["trial"], failed["reason"], strict=True)
    ]

"""Cue shots: simulated shots give their truth back, and what they cannot tell is said."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray
from typer.testing import CliRunner

from calibrate import TrialTableError, check_trials, fit_shot
from calibrate.shot_table import observed_shots
from calibrate.shots import AIM
from calibrate.simulate_shots import simulate_shots
from calibrate.trials import write_trials
from experiments.cli import app
from impact import Ball, Cue

BALL, CUE = Ball(mass=0.1673, radius=0.0286), Cue(mass=0.5018)
TRUTH = {
    "tip_ball_restitution": 0.656532,
    "tip_ball_friction": 0.4,
    "stiffness_ratio": 10.0,
    "ball_table_restitution": 0.51625,
    "ball_table_friction": 0.152479,
}


def aims(count: int, generator: np.random.Generator, raised: bool) -> NDArray[np.float64]:
    """Strokes in all directions; raised ones press the ball into the cloth, others are level and low."""
    low, high = (0.3, 1.1) if raised else (0.0, 1e-9)
    above = generator.uniform(-0.3, 0.4, count) if raised else generator.uniform(-0.5, -0.3, count)
    columns = [
        generator.uniform(1.0, 4.0, count),
        generator.uniform(-3.0, 3.0, count),
        generator.uniform(low, high, count),
        generator.uniform(-0.4, 0.4, count),
        above,
    ]
    return np.stack(columns, axis=1)


def shots(count: int, raised: bool, seed: int = 1) -> pd.DataFrame:
    generator = np.random.default_rng(seed)
    return simulate_shots(TRUTH, aims(count, generator, raised), (BALL, CUE), generator)


def test_tip_and_ratio_are_found_where_the_cloth_is_known() -> None:
    cloth = {
        name: TRUTH[name] for name in ("ball_table_restitution", "ball_table_friction", "stiffness_ratio")
    }
    fitted = fit_shot(shots(4, raised=True), ball=BALL, cue=CUE, fixed=cloth)
    assert set(fitted.estimates) == {"tip_ball_restitution", "tip_ball_friction"}
    for name, estimate in fitted.estimates.items():
        assert estimate.verdict == "one value"
        assert any(low <= TRUTH[name] <= high for low, high in estimate.intervals_95)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_raised_shots_give_all_five_parameters_back(seed: int) -> None:
    fitted = fit_shot(shots(12, raised=True, seed=seed), ball=BALL, cue=CUE)
    for name, estimate in fitted.estimates.items():
        assert estimate.verdict == "one value"
        assert any(low <= TRUTH[name] <= high for low, high in estimate.intervals_95)


@pytest.mark.slow
def test_the_95_percent_sets_of_shots_hold_the_truth() -> None:
    correlation = np.eye(4)
    correlation[0, 3] = correlation[3, 0] = 0.6  # spin is read from how the velocity changes
    correlation[1, 2] = correlation[2, 1] = -0.6
    held = []
    for seed in range(20):
        generator = np.random.default_rng(1000 + seed)
        aimed = aims(6, generator, True)
        table = simulate_shots(TRUTH, aimed, (BALL, CUE), generator, correlation=correlation)
        for name, estimate in fit_shot(table, ball=BALL, cue=CUE).estimates.items():
            held.append(any(low <= TRUTH[name] <= high for low, high in estimate.intervals_95))
    assert 0.88 <= np.mean(held) <= 0.99


@pytest.mark.slow
def test_level_low_shots_tell_nothing_of_the_cloth_and_say_so() -> None:
    fitted = fit_shot(shots(8, raised=False), ball=BALL, cue=CUE)
    assert fitted.estimates["tip_ball_restitution"].verdict == "one value"
    assert fitted.estimates["ball_table_restitution"].verdict == "not determined"
    assert "ball table restitution" in str(fitted.notes)
    assert "raised cue" in str(fitted.notes)


def test_friction_told_by_the_paths_counts_with_its_scatter() -> None:
    table = shots(3, raised=True).assign(friction=[0.15, 0.16, 0.17], friction_sd=0.001)
    mean, sd = observed_shots(table, BALL, CUE).cloth or (0.0, 0.0)
    assert mean == pytest.approx(0.16)
    assert sd == pytest.approx(0.01 / np.sqrt(3))


def test_an_unsure_aim_makes_the_outcome_unsure() -> None:
    table = shots(3, raised=True)
    parameters = np.array([0.65, 0.4, np.log(10.0), 0.5, 0.15])
    sure, unsure = (
        observed_shots(each, BALL, CUE).covariance(parameters)
        for each in (table, table.assign(contact_offset_sd=0.02))
    )
    assert np.all(np.diagonal(unsure - sure, axis1=1, axis2=2)[:, :2].sum(axis=1) > 0)


def test_correlated_errors_of_velocity_and_spin_count() -> None:
    correlation = np.eye(4)
    correlation[0, 3] = correlation[3, 0] = 0.9
    generator = np.random.default_rng(1)
    table = simulate_shots(TRUTH, aims(3, generator, True), (BALL, CUE), generator, correlation=correlation)
    observed = observed_shots(table, BALL, CUE)
    covariance = observed.covariance(np.array([0.65, 0.4, np.log(10.0), 0.5, 0.15]))
    sd = observed.measured_sd
    assert covariance[:, 0, 3] == pytest.approx(0.9 * sd[:, 0] * sd[:, 3])
    assert np.all(np.linalg.eigvalsh(covariance) > 0)


def test_correlations_that_contradict_each_other_are_drawn_towards_none() -> None:
    columns = ["velocity_x_velocity_y", "velocity_x_angular_velocity_x", "velocity_y_angular_velocity_x"]
    told = dict(zip((f"{column}_correlation" for column in columns), (1.0, 1.0, -1.0), strict=True))
    observed = observed_shots(shots(3, raised=True).assign(**told), BALL, CUE)
    assert np.all(np.linalg.eigvalsh(observed.correlation) > 0)


def test_what_no_camera_sees_of_the_aim_is_asked_for() -> None:
    tracked = shots(3, raised=True).drop(columns=["cue_elevation", "contact_height"])
    notes = " ".join(observed_shots(tracked, BALL, CUE).notes)
    assert "cue_elevation (the butt's angle above the table, rad) is missing in 3 shots" in notes
    assert "contact_height (where the tip strikes, radii above the middle) is missing" in notes
    assert "contact_offset" not in notes


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"approach_velocity": -2.0}, "approach_velocity must be above zero"),
        ({"contact_offset": 1.2}, "lie outside the ball"),
        ({"velocity_y": np.inf}, "velocity_y is no finite number"),
        ({"unit": "px"}, "its lengths are in pixels"),
        ({"cue_elevation": 30.0}, "cue_elevation must be at most pi/2 (it is in radians), got 30"),
    ],
)
def test_a_shot_that_cannot_be_used_is_left_out_with_a_reason(
    changes: dict[str, float | str], sentence: str
) -> None:
    table = shots(3, raised=True).assign(unit="m")
    for column, value in changes.items():
        table.loc[0, column] = value
    left = observed_shots(table, BALL, CUE)
    assert len(left.names) == 2
    assert sentence in left.notes[0]


def test_a_table_without_shots_is_refused() -> None:
    row = {"kind": "plate", "approach_velocity": -2.0, "upper_rebound_velocity": 1.7}
    with pytest.raises(TrialTableError, match="no usable trial of kind shot"):
        fit_shot(check_trials(pd.DataFrame([row])), ball=BALL, cue=CUE)


@pytest.mark.parametrize(
    ("fixed", "sentence"),
    [
        ({"friction": 0.2}, "fixed parameter must be one of tip_ball_restitution"),
        ({"tip_ball_restitution": 1.2}, r"tip_ball_restitution must be within \[0, 1\], got 1.2"),
        (TRUTH, "all parameters are fixed"),
    ],
)
def test_a_parameter_that_cannot_be_fixed_is_refused(fixed: dict[str, float], sentence: str) -> None:
    with pytest.raises(ValueError, match=sentence):
        fit_shot(shots(2, raised=True), ball=BALL, cue=CUE, fixed=fixed)


def test_a_shot_is_aimed_as_the_model_understands_it() -> None:
    table = shots(2, raised=True)
    observed = observed_shots(table, BALL, CUE)
    assert observed.aim == pytest.approx(table[list(AIM)].to_numpy())
    parameters = [TRUTH[name] for name in TRUTH]
    parameters[2] = np.log(parameters[2])
    off = observed.predicted(np.array([parameters]))[0] - observed.measured
    assert np.all(np.abs(off) < 5 * observed.measured_sd)


def test_the_command_fits_shots_with_what_is_fixed(tmp_path: Path) -> None:
    path = write_trials(shots(4, raised=True), tmp_path / "trials.csv")
    words = ["--shot-ball", "0.1673", "0.0572", "--cue-mass", "0.5018", "--out", str(tmp_path)]
    for name in ("ball_table_restitution", "ball_table_friction", "stiffness_ratio", "tip_ball_friction"):
        words += ["--fix", f"{name}={TRUTH[name]}"]
    done = CliRunner().invoke(app, ["fit", str(path), *words])
    assert done.exit_code == 0
    assert "tip ball restitution: one value: 0.65" in done.stdout
    assert (tmp_path / "shot_fit.json").exists()


def test_shots_without_a_cue_do_not_lose_the_drops_of_the_same_table(tmp_path: Path) -> None:
    drops = pd.DataFrame({"kind": "plate", "approach_velocity": -2.0, "upper_rebound_velocity": [1.7, 1.71]})
    unaimed = shots(2, raised=True).drop(columns="approach_velocity")
    path = write_trials(check_trials(pd.concat([drops, unaimed])), tmp_path / "trials.csv")
    done = CliRunner().invoke(app, ["fit", str(path), "--out", str(tmp_path)])
    assert done.exit_code == 1
    assert "approach_velocity must be above zero, the speed of the tip" in done.stderr
    assert "restitution ball-table e2: one value" in done.stdout

"""Tables that are odd, poor or broken: each gets a clear sentence, and nothing else is lost."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from calibrate import Calibration, check_trials, fit_stiffness_ratio
from calibrate.notes import notes_on_trials
from calibrate.observed import found_in
from calibrate.simulate import Design, Truth, simulate_trials

TRUTH = Truth(stiffness_ratio=10.0, ball_ball=0.81, ball_table=0.85)


def trials(count: int = 3) -> pd.DataFrame:
    design = Design(plate=count, held=count, two={1.0: count, 0.5: count})
    return simulate_trials(TRUTH, design, np.random.default_rng(1))


def notes(table: pd.DataFrame) -> str:
    return " ".join(fit_stiffness_ratio(table).notes)


def holds_the_truth(calibration: Calibration) -> bool:
    return any(low < 10.0 < high for low, high in calibration.stiffness_ratio.intervals_95)


def test_without_two_ball_trials_the_restitutions_are_still_fitted() -> None:
    table = trials()
    calibration = fit_stiffness_ratio(table[table.kind != "two"])
    assert "no two-ball trials: the stiffness ratio cannot be fitted" in calibration.notes
    assert calibration.restitution_ball_ball.verdict == "one value"


@pytest.mark.slow
def test_without_held_drops_the_fit_says_so_and_goes_on() -> None:
    table = trials()
    calibration = fit_stiffness_ratio(table[table.kind != "held"])
    assert "no drops on a held ball: ball-ball restitution has no measurement of its own" in calibration.notes
    assert calibration.restitution_ball_table.verdict == "one value"


@pytest.mark.slow
def test_one_two_ball_trial_alone_determines_nothing() -> None:
    table = trials(1)
    calibration = fit_stiffness_ratio(table[table.kind == "two"].iloc[:1])
    assert calibration.stiffness_ratio.verdict == "not determined"
    assert "too few two-ball trials to see their scatter: 2% assumed" in calibration.notes


def test_one_drop_alone_is_fitted_with_an_assumed_scatter() -> None:
    table = trials(1)
    calibration = fit_stiffness_ratio(table[table.kind == "plate"])
    assert calibration.restitution_ball_table.sd == pytest.approx(0.017, abs=0.001)


def test_a_mass_pair_that_was_filmed_in_vain_is_named_with_the_remedy() -> None:
    table = trials()
    pair = (table.kind == "two") & (table.upper_mass < table.lower_mass)
    table.loc[pair, "status"] = ["suspect", "suspect", "failed"]
    (said,) = (note for note in notes_on_trials(table, found_in(table), (None, None)) if "none of" in note)
    assert said.startswith("none of the 3 two-ball trials of mass ratio 0.5 is usable (")
    assert said.endswith("mend what their reasons name, and run process again with --resume")


def test_a_kind_that_was_filmed_in_vain_is_not_called_missing_only() -> None:
    table = trials()
    table.loc[table.kind == "held", "status"] = "suspect"
    said = notes_on_trials(table, found_in(table), (None, None))
    assert any(note.startswith("none of the 3 drops on a held ball is usable") for note in said)


def test_a_verdict_on_data_that_the_model_misses_says_so_in_its_own_line() -> None:
    calibration = fit_stiffness_ratio(trials().query("kind == 'plate'"))
    missed = replace(calibration, chi_square=25.2, degrees_of_freedom=3)
    assert str(missed).splitlines()[0].endswith(", but the model misses the measurements: do not trust it")
    assert calibration.caveat == replace(missed, chi_square=3.0).caveat == ""


def test_identical_trials_are_doubted() -> None:
    said = notes(pd.concat([trials(1)] * 5, ignore_index=True))
    assert "16 trials repeat others digit for digit" in said
    assert "the two-ball trials agree better than trials can" in said


@pytest.mark.slow
def test_a_standard_deviation_of_zero_is_no_certainty() -> None:
    table = trials()
    stated = table.assign(upper_rebound_velocity_sd=0.0)
    stated.loc[stated.kind == "two", "lower_rebound_velocity_sd"] = 0.0
    calibration = fit_stiffness_ratio(stated)
    assert "standard deviations of zero are taken as not stated: 18 of them" in calibration.notes
    assert calibration.stiffness_ratio == fit_stiffness_ratio(table).stiffness_ratio


def test_masses_typed_as_text_are_understood_and_units_refused() -> None:
    table = trials()
    table["upper_mass"] = [f" {mass} " for mass in table["upper_mass"]]
    table["lower_mass"] = [f"{mass}" for mass in table["lower_mass"]]
    table.loc[6, "lower_mass"] = "0.0027 kg"
    checked = check_trials(table)
    assert checked.reason[6] == "row 6: lower_mass must be a number, got '0.0027 kg'"
    calibration = fit_stiffness_ratio(checked)
    assert "1 failed of 12 trials left out" in calibration.notes
    assert holds_the_truth(calibration)


@pytest.mark.parametrize("cell", [np.inf, -np.inf, np.nan, "nan", None])
def test_a_number_that_is_none_costs_its_own_row_only(cell: object) -> None:
    table = trials().astype({"upper_rebound_velocity": object})
    table.loc[0, "upper_rebound_velocity"] = cell
    checked = check_trials(table)
    assert list(checked.status) == ["failed"] + ["ok"] * 11
    assert "upper_rebound_velocity" in checked.reason[0]


def test_an_impossible_row_costs_its_own_row_only() -> None:
    table = trials()
    table.loc[table.kind == "two", "lower_rebound_velocity"] *= [30.0, 1.0, 1.0, 1.0, 1.0, 1.0]
    checked = check_trials(table)
    assert list(checked.status).count("failed") == 1
    assert holds_the_truth(fit_stiffness_ratio(checked))


def test_a_thousand_rows_are_fitted_all() -> None:
    calibration = fit_stiffness_ratio(trials(250))
    assert sum(pair.trials for pair in calibration.pairs) > 490
    assert calibration.stiffness_ratio.verdict == "one value"
    assert holds_the_truth(calibration)


@pytest.mark.slow
def test_a_fit_that_ends_at_a_bound_names_it() -> None:
    table = trials()
    held = table.kind == "held"
    table.loc[held, "upper_rebound_velocity"] = -table.loc[held, "approach_velocity"]
    calibration = fit_stiffness_ratio(table)
    assert "the best fit has the ball-ball restitution at its bound, 1" in " ".join(calibration.notes)
    assert calibration.restitution_ball_ball.verdict == "bounded on one side"

"""The fit: truth found again, honest sets, and a word for everything that is missing."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from calibrate import Calibration, TrialTableError, check_trials, fit_restitution, fit_stiffness_ratio
from calibrate.model import rebound_ratios
from calibrate.simulate import Design, Truth, simulate_trials
from experiments import paper

TRUTH = Truth(
    stiffness_ratio=10.0,
    ball_ball=paper.BALL_BALL.mean,
    ball_table=paper.BALL_TABLE.mean,
    restitution_scatter=paper.BALL_BALL.sd,
    rebound_scatter=(0.02, 0.02),
)
PAPERS_RESTITUTIONS = {
    "ball_ball": (paper.BALL_BALL.mean, paper.BALL_BALL.sd),
    "ball_table": (paper.BALL_TABLE.mean, paper.BALL_TABLE.sd),
}


def simulated(design: Design, seed: int = 1) -> pd.DataFrame:
    return simulate_trials(TRUTH, design, np.random.default_rng(seed))


def drops(kind: str, ratios: list[float]) -> pd.DataFrame:
    row = {"kind": kind, "approach_velocity": -2.0}
    return check_trials(pd.DataFrame([row | {"upper_rebound_velocity": 2.0 * ratio} for ratio in ratios]))


@pytest.fixture(scope="module")
def two_pair_fit() -> Calibration:
    trials = simulated(Design(plate=0, held=0, two={1.0: 10, 2.0: 10}))
    return fit_stiffness_ratio(trials, **PAPERS_RESTITUTIONS)


@pytest.mark.paper
def test_the_model_gives_the_slopes_of_fig_5() -> None:
    slopes = rebound_ratios([paper.STIFFNESS_RATIO], [[paper.BALL_BALL.mean, paper.BALL_TABLE.mean]], [1.0])[
        0
    ]
    assert slopes == pytest.approx(paper.FIG5_REFERENCE_SLOPES, abs=2e-7)


def test_a_second_mass_pair_settles_the_ratio(two_pair_fit: Calibration) -> None:
    ratio = two_pair_fit.stiffness_ratio
    assert ratio.verdict == "one value"
    ((low, high),) = ratio.intervals_95
    assert 9.4 < low < 10.0 < high < 10.6


def test_the_best_fit_describes_the_measurements(two_pair_fit: Calibration) -> None:
    for pair in two_pair_fit.pairs:
        off = (np.array(pair.fitted) - pair.measured) / pair.measured_sd
        assert np.all(np.abs(off) < 3.5)
        assert all(low < value < high for value, (low, high) in zip(pair.fitted, pair.fitted_95, strict=True))


def test_a_calibration_survives_its_json(two_pair_fit: Calibration, tmp_path: Path) -> None:
    path = two_pair_fit.save(tmp_path / "fit.json")
    assert Calibration.from_json(path.read_text(encoding="utf-8")) == two_pair_fit
    ratio = json.loads(path.read_text(encoding="utf-8"))["stiffness_ratio"]
    assert set(ratio) == {"value", "sd", "intervals_68", "intervals_95", "verdict"}


def test_the_truth_behind_rendered_recordings_is_found(shared_data: Path) -> None:
    calibration = fit_stiffness_ratio(truth_table(shared_data / "rendered" / "drops"))
    ratio = calibration.stiffness_ratio
    assert ratio.verdict == "one value"
    assert any(low < 10.0 < high for low, high in ratio.intervals_95)
    assert calibration.states == ("S1", "S3", "S1", "S2")


def truth_table(folder: Path) -> pd.DataFrame:
    rows = []
    for path in sorted(folder.glob("*-*.json")):
        clip = json.loads(path.read_text(encoding="utf-8"))
        first = clip["events"][0]
        row = {"trial": path.stem, "kind": clip["kind"], "approach_velocity": first["v0"][0]}
        row["upper_rebound_velocity"] = first["v1"][0]
        if clip["kind"] == "two":
            row["lower_rebound_velocity"] = first["v1"][1]
            row["upper_mass"], row["lower_mass"] = clip["masses_kg"]
        rows.append(row)
    return check_trials(pd.DataFrame(rows))


def test_restitution_prints_verdict_value_and_set() -> None:
    text = str(fit_restitution(drops("held", [0.80, 0.81, 0.82, 0.81]), "held"))
    assert text == "one value: 0.8100 ± 0.0041 (95 %: 0.7970 to 0.8230)"


def test_without_two_ball_trials_the_restitutions_are_still_fitted() -> None:
    calibration = fit_stiffness_ratio(drops("plate", [0.84, 0.85, 0.86]))
    assert calibration.restitution_ball_table.verdict == "one value"
    assert calibration.restitution_ball_ball.verdict == "not determined"
    assert calibration.stiffness_ratio.verdict == "not determined"
    assert "no two-ball trials: the stiffness ratio cannot be fitted" in calibration.notes


def test_an_outlier_is_named_and_left_out() -> None:
    trials = drops("plate", [0.84, 0.842, 0.838, 0.841, 0.839, 0.60])
    calibration = fit_stiffness_ratio(trials)
    assert calibration.restitution_ball_table.value == pytest.approx(0.84, abs=1e-9)
    assert "6 stands apart" in " ".join(calibration.notes)


def test_failed_and_suspect_trials_are_left_out_and_counted() -> None:
    trials = drops("plate", [0.84, 0.85, 0.86, 0.2, 0.99])
    trials.loc[3:, "status"] = ["failed", "suspect"]
    calibration = fit_stiffness_ratio(trials)
    assert calibration.restitution_ball_table.value == pytest.approx(0.85)
    assert "1 failed of 5 trials left out" in calibration.notes
    assert "1 suspect of 5 trials left out" in calibration.notes


def test_a_single_drop_is_fitted_with_an_assumed_scatter_and_says_so() -> None:
    calibration = fit_stiffness_ratio(drops("held", [0.8]))
    assert calibration.restitution_ball_ball.sd == pytest.approx(0.016)
    assert "too few drops on a held ball to see their scatter: 2% assumed" in calibration.notes


def test_a_table_without_any_usable_trial_is_refused() -> None:
    trials = drops("plate", [0.84])
    trials["status"] = "suspect"
    with pytest.raises(TrialTableError, match="no usable trial of kind plate, held or two"):
        fit_stiffness_ratio(trials)


def test_pairs_are_said_to_need_no_fit() -> None:
    trials = drops("plate", [0.84]).assign(kind="pair")
    with pytest.raises(TrialTableError, match="kind pair, which needs no fit: each row has its own restitut"):
        fit_stiffness_ratio(trials)


def test_restitution_of_a_kind_that_is_not_there_is_refused() -> None:
    with pytest.raises(ValueError, match="no usable trial of kind 'held'"):
        fit_restitution(drops("plate", [0.84]), "held")


@pytest.mark.slow
def test_without_held_drops_the_ball_ball_restitution_is_found_from_two_ball_trials() -> None:
    calibration = fit_stiffness_ratio(simulated(Design(held=0, plate=16, two={1.0: 10, 2.0: 10})))
    assert any(low < 10.0 < high for low, high in calibration.stiffness_ratio.intervals_95)
    assert any(low < TRUTH.ball_ball < high for low, high in calibration.restitution_ball_ball.intervals_95)
    assert "no drops on a held ball" in " ".join(calibration.notes)


@pytest.mark.slow
def test_three_trials_alone_determine_nothing() -> None:
    calibration = fit_stiffness_ratio(simulated(Design(held=0, plate=0, two={1.0: 3})))
    assert calibration.stiffness_ratio.verdict == "not determined"
    assert calibration.stiffness_ratio.value is None


def test_a_known_restitution_must_be_one() -> None:
    with pytest.raises(ValueError, match=r"ball_ball must be within \[0, 1\], got 1.2"):
        fit_stiffness_ratio(drops("plate", [0.84]), ball_ball=(1.2, 0.1))

"""Confidence sets keep their promise: simulated experiments, fitted one after another."""

from dataclasses import replace

import pytest

from calibrate.coverage import simulated_estimate
from experiments.coverage import DESIGNS, RATIOS, compute

EXPERIMENTS = 200  # of fifty with a true share of 92.5 %, a third would hold fewer than 45


@pytest.mark.slow
@pytest.mark.parametrize("design", DESIGNS)
@pytest.mark.parametrize("ratio", RATIOS)
def test_the_95_percent_set_holds_the_truth_and_one_value_is_hardly_ever_wrong(
    ratio: float, design: str
) -> None:
    (counted,) = compute(design, EXPERIMENTS, workers=2, ratios=[ratio])
    assert counted.held >= 0.9 * EXPERIMENTS
    assert counted.wrong <= 0.05 * EXPERIMENTS


@pytest.mark.slow
def test_an_experiment_is_the_same_again_with_the_same_seed() -> None:
    truth, design = DESIGNS["few repeats of two mass pairs"]
    assert simulated_estimate(truth, design, 3) == simulated_estimate(truth, design, 3)


@pytest.mark.slow
def test_a_valley_that_begins_behind_a_jump_is_found() -> None:
    truth, design = DESIGNS["the paper's design"]
    estimate = simulated_estimate(replace(truth, stiffness_ratio=60.0), design, 28)
    assert any(low < 60.0 < high for low, high in estimate.intervals_95)


@pytest.mark.parametrize("seed", [0, 29])
def test_a_valley_narrower_than_the_grid_is_found(seed: int) -> None:
    truth, design = DESIGNS["few repeats of two mass pairs"]
    (interval,) = simulated_estimate(replace(truth, stiffness_ratio=60.0), design, seed).intervals_95
    assert interval[0] < 60.0 < interval[1]

"""Confidence sets keep their promise: simulated experiments, fitted one after another."""

import numpy as np
import pytest

from calibrate import fit_stiffness_ratio
from calibrate.simulate import Design, Truth, simulate_trials
from experiments import paper

EXPERIMENTS = 50
DESIGNS = {
    "few repeats of two mass pairs": (Design(), 0.004, (0.004, 0.01)),
    "the paper's design": (Design(plate=16, held=8, two={1.0: 10}), paper.BALL_TABLE.sd, (0.02, 0.02)),
}


@pytest.mark.slow
@pytest.mark.parametrize("design", DESIGNS)
@pytest.mark.parametrize("ratio", [0.3, 2.0, 10.0, 60.0])
def test_the_95_percent_set_holds_the_truth_and_one_value_is_hardly_ever_wrong(
    ratio: float, design: str
) -> None:
    trials, restitution_scatter, rebound_scatter = DESIGNS[design]
    truth = Truth(
        stiffness_ratio=ratio,
        ball_ball=paper.BALL_BALL.mean,
        ball_table=paper.BALL_TABLE.mean,
        restitution_scatter=restitution_scatter,
        rebound_scatter=rebound_scatter,
    )
    held = wrong = 0
    for seed in range(EXPERIMENTS):
        fitted = fit_stiffness_ratio(
            simulate_trials(truth, trials, np.random.default_rng(seed))
        ).stiffness_ratio
        inside = any(low <= ratio <= high for low, high in fitted.intervals_95)
        held += inside
        wrong += fitted.verdict == "one value" and not inside
    assert held >= 0.9 * EXPERIMENTS
    assert wrong <= 0.05 * EXPERIMENTS

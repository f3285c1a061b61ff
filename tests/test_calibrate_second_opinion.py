"""Bootstrap and contours agree with the profile they are held against."""

import numpy as np
import pandas as pd
import pytest

from calibrate import Calibration, fit_stiffness_ratio
from calibrate.bootstrap import bootstrap
from calibrate.contours import contours
from calibrate.fit import misfit_of
from calibrate.simulate import Design, Truth, simulate_trials

TRUTH = Truth(
    stiffness_ratio=10.0,
    ball_ball=0.81,
    ball_table=0.85,
    restitution_scatter=0.01,
    rebound_scatter=(0.01, 0.01),
)


@pytest.fixture(scope="module")
def trials() -> pd.DataFrame:
    return simulate_trials(TRUTH, Design(plate=8, held=8, two={1.0: 8, 0.5: 8}), np.random.default_rng(1))


@pytest.fixture(scope="module")
def fitted(trials: pd.DataFrame) -> Calibration:
    return fit_stiffness_ratio(trials)


def test_both_bootstraps_fall_into_the_set_of_the_profile(trials: pd.DataFrame, fitted: Calibration) -> None:
    for opinion in bootstrap(trials, fitted, np.random.default_rng(2), times=20):
        assert opinion.elsewhere < 0.15
        assert f"bootstrap {opinion.how}, 20 times: best value" in str(opinion)


@pytest.mark.slow
def test_a_bootstrap_is_the_same_again_with_the_same_generator(
    trials: pd.DataFrame, fitted: Calibration
) -> None:
    first, second = (bootstrap(trials, fitted, np.random.default_rng(3), times=3) for _ in range(2))
    assert first == second


def test_a_bootstrap_of_no_draws_is_refused(trials: pd.DataFrame, fitted: Calibration) -> None:
    with pytest.raises(ValueError, match="times must be at least 1, got 0"):
        bootstrap(trials, fitted, np.random.default_rng(1), times=0)


def test_the_contours_are_lowest_at_the_best_fit(trials: pd.DataFrame, fitted: Calibration) -> None:
    surface = contours(misfit_of(trials), fitted)
    row, column = np.unravel_index(np.argmin(surface.chi_square), surface.chi_square.shape)
    assert fitted.stiffness_ratio.value is not None
    assert surface.stiffness_ratio[column] == pytest.approx(fitted.stiffness_ratio.value, rel=0.01)
    assert surface.ball_ball[row] == pytest.approx(fitted.valleys[0].restitutions[0], abs=0.005)
    assert surface.chi_square.min() >= fitted.chi_square - 1e-6

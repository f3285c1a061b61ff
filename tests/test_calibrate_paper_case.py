"""The paper's own scatter: ten heights of equal balls leave three stiffness ratios, a second pair one."""

import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray

from calibrate import check_trials, fit_stiffness_ratio
from calibrate.intervals import Interval
from calibrate.model import rebound_ratios
from experiments import paper

HEIGHTS = np.linspace(0.2, 0.8, 10)  # m
NOISE = 0.02
RESTITUTIONS = (paper.BALL_BALL.mean, paper.BALL_TABLE.mean)
OWN_DROPS = {
    "ball_ball": (paper.BALL_BALL.mean, 0.021),
    "ball_table": (paper.BALL_TABLE.mean, 0.021),
}


def typical_noise(seed: int) -> NDArray[np.float64]:
    """Ten pairs of relative errors of mean 0, standard deviation `NOISE` and no correlation, (10, 2)."""
    drawn = np.random.default_rng(seed).normal(size=(len(HEIGHTS), 2))
    drawn -= drawn.mean(axis=0)
    return NOISE * np.linalg.solve(np.linalg.cholesky(np.cov(drawn.T)), drawn.T).T


def two_ball_trials(mass_ratio: float) -> pd.DataFrame:
    speed = np.sqrt(2 * 9.81 * HEIGHTS)
    slopes = rebound_ratios([paper.STIFFNESS_RATIO], [RESTITUTIONS], [mass_ratio])[0]
    rebounds = speed[:, None] * slopes * (1 + typical_noise(seed=int(mass_ratio)))
    columns = {"approach_velocity": -speed, "upper_rebound_velocity": rebounds[:, 0]}
    columns |= {"lower_rebound_velocity": rebounds[:, 1]}
    masses = {"upper_mass": 0.0027 * mass_ratio, "lower_mass": 0.0027}
    return check_trials(pd.DataFrame({"kind": "two", **columns, **masses}))


def test_ten_heights_of_equal_balls_leave_three_sets() -> None:
    calibration = fit_stiffness_ratio(two_ball_trials(1.0), **OWN_DROPS)
    ratio = calibration.stiffness_ratio
    assert ratio.verdict == "several values"
    assert "trials with a second mass pair would" in str(calibration)
    expected: tuple[Interval, ...] = ((4.2, 4.6), (9.5, 12.7), (14.0, 17.8))
    assert len(ratio.intervals_95) == len(expected)
    for found, known in zip(ratio.intervals_95, expected, strict=True):
        assert found == pytest.approx(known, rel=0.08)


def test_trials_with_a_doubled_upper_mass_leave_one() -> None:
    trials = pd.concat([two_ball_trials(1.0), two_ball_trials(2.0)], ignore_index=True)
    ratio = fit_stiffness_ratio(trials, **OWN_DROPS).stiffness_ratio
    assert ratio.verdict == "one value"
    assert ratio.intervals_95[0] == pytest.approx((9.5, 10.5), rel=0.03)

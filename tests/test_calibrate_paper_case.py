"""The paper's own scatter: ten heights of equal balls leave three stiffness ratios, a second pair one."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from calibrate import fit_stiffness_ratio
from calibrate.intervals import Interval
from calibrate.simulate import Truth, typical_trials
from experiments import paper
from experiments.cli import app

TRUTH = Truth(
    stiffness_ratio=paper.STIFFNESS_RATIO,
    ball_ball=paper.BALL_BALL.mean,
    ball_table=paper.BALL_TABLE.mean,
    rebound_scatter=(0.02, 0.02),
)
OWN_DROPS = {
    "ball_ball": (paper.BALL_BALL.mean, 0.021),
    "ball_table": (paper.BALL_TABLE.mean, 0.021),
}


def test_ten_heights_of_equal_balls_leave_three_sets() -> None:
    calibration = fit_stiffness_ratio(typical_trials(TRUTH, {1.0: 10}), **OWN_DROPS)
    ratio = calibration.stiffness_ratio
    assert ratio.verdict == "several values"
    assert "trials with a second mass pair would" in str(calibration)
    expected: tuple[Interval, ...] = ((4.2, 4.6), (9.5, 12.7), (14.0, 17.8))
    assert len(ratio.intervals_95) == len(expected)
    for found, known in zip(ratio.intervals_95, expected, strict=True):
        assert found == pytest.approx(known, rel=0.08)


def test_trials_with_a_doubled_upper_mass_leave_one() -> None:
    trials = typical_trials(TRUTH, {1.0: 10, 2.0: 10})
    ratio = fit_stiffness_ratio(trials, **OWN_DROPS).stiffness_ratio
    assert ratio.verdict == "one value"
    assert ratio.intervals_95[0] == pytest.approx((9.5, 10.5), rel=0.03)


def test_the_command_line_tells_the_same(tmp_path: Path) -> None:
    table, run = tmp_path / "simulated.csv", CliRunner().invoke
    assert run(app, ["simulate", "trials", "--out", str(table)]).stdout.startswith("10 trials in")
    known = ["--ball-ball", "0.807755", "0.021", "--ball-table", "0.846529", "0.021"]
    done = run(app, ["fit", str(table), *known, "--out", str(tmp_path)])
    assert done.stdout.startswith("stiffness ratio k2/k1: several values: best 10")

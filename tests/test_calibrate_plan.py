"""The planner: what it expects is what fits then find, and what it adds settles the ratio."""

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from calibrate import fit_stiffness_ratio
from calibrate.landscape import Landscape, landscape
from calibrate.plan import expected, smallest_addition
from calibrate.setup import Setup
from calibrate.simulate import Design, Truth, simulate_trials
from experiments import paper
from experiments.cli import app

CANDIDATES = (2.0, 10.0)
PAPERS = Design(plate=16, held=8, two={1.0: 10})
SETUP = Setup(repeatability=0.02)


@pytest.fixture(scope="module")
def view() -> Landscape:
    return landscape((1.0, 2.0), (paper.BALL_BALL.mean, paper.BALL_TABLE.mean), CANDIDATES)


def test_the_papers_design_is_expected_to_confuse_ten_with_four(view: Landscape) -> None:
    ten = expected(view, SETUP, PAPERS, CANDIDATES).expectations[1]
    assert ten.verdict == "several values"
    assert any(low < 4.4 < high for low, high in ten.confusions)


def test_the_addition_found_settles_every_candidate_with_fewest_trials(view: Landscape) -> None:
    plan = smallest_addition(view, SETUP, PAPERS, CANDIDATES)
    assert plan is not None
    assert plan.settles
    assert list(plan.added) == [2.0]
    fewer = Design(plate=16, held=8, two={1.0: 10 + sum(plan.added.values())})
    assert not expected(view, SETUP, fewer, CANDIDATES).settles


def test_a_fit_of_the_planned_experiment_finds_the_one_value_expected(view: Landscape) -> None:
    plan = smallest_addition(view, SETUP, PAPERS, CANDIDATES)
    assert plan is not None
    truth = Truth(stiffness_ratio=10.0, ball_ball=paper.BALL_BALL.mean, ball_table=paper.BALL_TABLE.mean)
    scattered = Truth(
        stiffness_ratio=10.0,
        ball_ball=truth.ball_ball,
        ball_table=truth.ball_table,
        restitution_scatter=0.017,
        rebound_scatter=(0.02, 0.02),
    )
    trials = simulate_trials(scattered, plan.design, np.random.default_rng(2))
    ratio = fit_stiffness_ratio(trials).stiffness_ratio
    ((low, high),) = plan.expectations[1].intervals
    assert ratio.verdict == "one value"
    ((found_low, found_high),) = ratio.intervals_95
    assert found_low < 10.0 < found_high
    assert 0.4 < np.log(found_high / found_low) / np.log(high / low) < 2.5


def test_equal_balls_alone_never_settle_two(view: Landscape) -> None:
    equal = landscape((1.0,), view.restitutions, CANDIDATES)
    plan = smallest_addition(equal, SETUP, PAPERS, CANDIDATES)
    assert plan is None or not plan.settles


def test_a_slow_camera_scatters_more() -> None:
    slow, fast = (
        Setup(fps=fps, noise_px=1.0, repeatability=0.001).rebound_scatter((0.8, 0.2)) for fps in (30, 480)
    )
    assert np.all(slow > 1.5 * fast)


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("--fps", "4"), "fps must show 3 frames of the fall from 0.3 m, got 1.0"),
        (("--mass", "-1"), "mass must be above zero and finite, got -1"),
        (("--two", "0"), "a plan needs at least one two-ball trial"),
    ],
)
def test_an_impossible_set_up_is_one_sentence(words: tuple[str, ...], sentence: str, tmp_path: Path) -> None:
    done = CliRunner().invoke(app, ["plan", *words, "--ratio", "2", "--out", str(tmp_path)])
    assert done.exit_code == 2
    assert sentence in done.stderr


def test_plan_prints_its_table_and_draws(tmp_path: Path) -> None:
    words = ["plan", "--mass", "0.0027", "--mass", "0.0054", "--ratio", "10", "--out", str(tmp_path)]
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 0
    assert "fewest trials that help: add" in done.stdout
    assert (tmp_path / "plan.svg").exists()
    assert "asked,10,several values" in (tmp_path / "plan.csv").read_text(encoding="utf-8")

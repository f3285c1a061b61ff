"""Figures of the paper: its numbers come out, and the files are the same every time."""

from pathlib import Path

import numpy as np
import pytest

from calibrate import Calibration, Estimate
from calibrate.estimate import Curve, MassPair
from calibrate.simulate import Design, Truth, simulate_trials
from experiments import fig4, fig5, paper, profile_plot
from experiments.drawing import new_figure, save_figure


def estimate(value: float, low: float, high: float) -> Estimate:
    return Estimate(
        value=value,
        sd=(high - low) / 4,
        intervals_68=((low, high),),
        intervals_95=((low, high),),
        verdict="one value",
    )


@pytest.fixture(scope="module")
def calibration() -> Calibration:
    pair = MassPair(
        mass_ratio=1.0,
        trials=4,
        measured=(0.78, 0.187),
        measured_sd=(0.002, 0.001),
        fitted=(0.779, 0.1866),
        fitted_68=((0.778, 0.780), (0.186, 0.187)),
        fitted_95=((0.777, 0.781), (0.185, 0.188)),
        states=("S1", "S3", "S1", "S2"),
    )
    return Calibration(
        restitution_ball_ball=estimate(0.81, 0.80, 0.82),
        restitution_ball_table=estimate(0.85, 0.84, 0.86),
        stiffness_ratio=estimate(10.0, 9.8, 10.2),
        states=pair.states,
        pairs=(pair,),
        chi_square=1.0,
        degrees_of_freedom=1,
        exponent=1.0,
        notes=(),
        profile=Curve(
            stiffness_ratio=(1e-3, 9.0, 9.8, 10.0, 10.2, 1e3),
            chi_square=(90.0, 20.0, 4.84, 1.0, 4.84, 90.0),
            limit_68=2.0,
            limit_95=4.84,
        ),
    )


@pytest.mark.paper
def test_fig_4_has_the_papers_states_events_and_energy_loss() -> None:
    curve = fig4.compute()
    assert tuple(stretch.state for stretch in curve.stretches) == paper.FIG4_STATES
    assert curve.stretches[0].events == paper.FIG4_FIRST_EVENTS
    assert curve.energy_loss == pytest.approx(paper.FIG4_ENERGY_LOSS, abs=5e-5)
    assert all(abs(row.difference) < 1e-6 for row in fig4.compare(curve)[1:])


def test_the_impulse_curve_stays_inside_its_ellipse() -> None:
    curve = fig4.compute()
    impulses = np.concatenate([stretch.impulses for stretch in curve.stretches])
    assert np.all(impulses.max(axis=0) < curve.ellipse.max(axis=0))
    assert np.all(np.diff(impulses, axis=0) > -1e-9)


@pytest.mark.paper
def test_fig_5_has_the_papers_lines() -> None:
    assert all(abs(row.difference) < 1e-7 for row in fig5.compare(fig5.compute()))


def test_fig_5_shows_every_trial_beside_the_fit(calibration: Calibration) -> None:
    truth = Truth(stiffness_ratio=10.0, ball_ball=0.81, ball_table=0.85)
    trials = simulate_trials(truth, Design(two={1.0: 4}), np.random.default_rng(1))
    (panel,) = fig5.compute(trials, calibration)
    assert len(panel.dots) == 4
    assert [line.slope for line in panel.fitted] == [0.779, 0.1866]
    assert panel.fitted[0].band == (0.777, 0.781)


def test_every_figure_writes_its_files(calibration: Calibration, tmp_path: Path) -> None:
    assert "energy loss [J]" in fig4.main(tmp_path)
    assert "v1/|v0|" in fig5.main(tmp_path)
    profile_plot.main(tmp_path, calibration)
    written = {path.name for path in tmp_path.iterdir()}
    tables = {"fig4.csv", "fig5.csv"}
    assert written == tables | {
        f"{name}.{kind}" for name in ("fig4", "fig5", "profile") for kind in ("svg", "png")
    }


def test_the_same_input_gives_the_same_bytes(tmp_path: Path) -> None:
    for run in ("first", "second"):
        fig5.main(tmp_path / run)
    for path in (tmp_path / "first").iterdir():
        assert path.read_bytes() == (tmp_path / "second" / path.name).read_bytes()


def test_the_profile_plot_says_the_verdict_first(calibration: Calibration) -> None:
    assert profile_plot.compute(calibration).title.startswith(
        "one value: stiffness ratio k₂/k₁ = 10.00 ± 0.10"
    )


def test_a_plot_of_unknown_kind_is_refused(tmp_path: Path) -> None:
    figure, _ = new_figure(1.0, 1.0)
    with pytest.raises(ValueError, match=r"ending in .svg, .png or .pdf, got 'plot.doc'"):
        save_figure(figure, tmp_path / "plot.doc")

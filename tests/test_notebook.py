"""How results show in a notebook: small tables that hold the numbers, and figures."""

from dataclasses import replace
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest
from clips import Clip
from matplotlib.figure import Figure

from calibrate import Estimate, fit_restitution
from calibrate.estimate import Calibration, Curve
from calibrate.shot_fit import ShotCalibration
from calibrate.trials import check_trials
from experiments import figures
from impact import Ball, Contact, TwoBallDrop, collide
from tracking import (
    Air,
    flight_of_ball,
    measure_impacts,
    open_recording,
    scale_from_ball,
    to_metres,
    track_balls,
)

FLIGHT = flight_of_ball(0.0027, 0.020, Air())
RATIO = Estimate(
    value=9.99,
    sd=None,
    intervals_68=((9.9, 10.1),),
    intervals_95=((4.267, 4.424), (9.72, 10.28)),
    verdict="several values",
)
FIT = Calibration(
    restitution_ball_ball=RATIO,
    restitution_ball_table=RATIO,
    stiffness_ratio=RATIO,
    states=("S1",),
    pairs=(),
    chi_square=1.9,
    degrees_of_freedom=3,
    exponent=1.0,
    notes=("drop <b>3</b> & 4 left out",),
    profile=Curve(
        stiffness_ratio=(1.0, 3.0, 10.0, 30.0), chi_square=(9.0, 5.0, 1.9, 9.0), limit_68=3.0, limit_95=6.0
    ),
)


def shown(result: Any) -> str:
    """Text of the table a notebook shows; the table must be well formed."""
    return " ".join(ElementTree.fromstring(result._repr_html_()).itertext())


def test_collision_shows_its_states_and_their_events() -> None:
    ball = Ball(mass=1.0, radius=0.02)
    contact = Contact(restitution=0.9)
    text = shown(
        collide(
            TwoBallDrop(upper=ball, lower=ball, approach_velocity=-1, ball_ball=contact, ball_table=contact)
        )
    )
    assert "S1" in text
    assert "impulses, N s" in text


def test_fit_shows_each_set_and_escapes_names() -> None:
    text = shown(FIT)
    assert "several values" in text
    assert "4.267 to 4.424 or 9.72 to 10.28" in text
    assert "drop <b>3</b> & 4 left out" in text
    assert "<b>" not in FIT._repr_html_()


def test_restitution_shows_value_and_uncertainty() -> None:
    drops = pd.DataFrame(
        {"kind": "plate", "approach_velocity": [-2.0, -4.0], "upper_rebound_velocity": [1.68, 3.44]}
    )
    assert "one value 0.850 ± 0.010" in shown(fit_restitution(check_trials(drops), "plate"))


def test_shot_fit_shows_what_was_held() -> None:
    fit = ShotCalibration(
        estimates={"stiffness_ratio": RATIO},
        fixed={"tip_ball_friction": 0.6},
        shots=3,
        chi_square=4.0,
        degrees_of_freedom=2,
        notes=(),
    )
    assert "tip ball friction fixed 0.6" in shown(fit)


def test_recording_track_and_impact_show_what_was_measured(plate_clip: Clip) -> None:
    recording = open_recording(plate_clip.path)
    (ball,) = track_balls(recording)
    assert "240 captured a second" in shown(recording)
    assert "px" in shown(ball)
    (impact, *_) = measure_impacts(to_metres(ball, scale_from_ball(ball, 0.040)), FLIGHT)
    assert f"{impact.velocities[0]:.4f} ±" in shown(impact)
    assert "lower ball" not in shown(impact)


def test_track_of_no_frame_says_so(plate_clip: Clip) -> None:
    (ball,) = track_balls(open_recording(plate_clip.path))
    nothing = np.empty(0)
    empty = replace(ball, frame=nothing.astype(int), time=nothing, x=nothing, y=nothing)
    assert "no frame" in shown(empty)


def test_recording_with_a_strange_name_is_escaped(plate_clip: Clip) -> None:
    recording = open_recording(plate_clip.path)
    strange = replace(recording, path=recording.path.with_name("<script>.mp4"), notes=("a < b",))
    assert "<script>" not in strange._repr_html_()
    assert "<script>.mp4" in shown(strange)


def test_figures_come_back_as_figures() -> None:
    assert isinstance(figures.fig5(), Figure)
    assert isinstance(figures.profile(FIT), Figure)


def test_profile_without_two_ball_trials_is_refused() -> None:
    with pytest.raises(ValueError, match="no two-ball trial"):
        figures.profile(replace(FIT, profile=Curve()))

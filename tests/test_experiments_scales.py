"""Which of two scales is believed, and what is said of them."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tracks import as_track

from experiments.known import chosen_scale
from experiments.trial import Body, Camera, Trial


def trial_of(camera: Camera) -> Trial:
    bodies = {"upper": Body(mass=0.0027, diameter=0.040)}
    return Trial(name="drop", video=Path("drop.mp4"), kind="plate", bodies=bodies, camera=camera)


def test_a_ruler_is_believed_rather_than_a_ball_whose_rim_is_not_seen() -> None:
    ruler = Camera(scale={"points_px": [[10, 31.5], [10, 331.5]], "distance": 0.24})
    clear = replace(as_track(np.arange(60) / 240, np.linspace(40, 300, 60)), unit="px", radius=21.0)
    clear = replace(clear, radius_sd=0.05, sizes=np.full(60, 21.0))
    hidden = replace(clear, sizes=np.where(np.arange(60) < 30, 21.0, np.nan))
    trial = trial_of(ruler)
    (scale, (said,)), (own, (differs,)) = chosen_scale(trial, hidden), chosen_scale(trial, clear)
    assert said.endswith("part of the ball's rim is as bright as the wall; what was given is used")
    assert chosen_scale(trial, replace(hidden, radius=26.5))[1] == []
    assert scale.matrix[0, 0] == pytest.approx(0.0008)
    assert own.matrix[0, 0] == pytest.approx(0.0400 / 42)
    assert differs.startswith("two scales differ by 19.0%")
    _, remarks = chosen_scale(trial_of(Camera()), hidden)
    assert any(
        "its size, which is the scale, is not seen well; tell the scale" in remark for remark in remarks
    )

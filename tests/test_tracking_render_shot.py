"""Synthetic cue shots: what they show is what their truth says."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tracking.cloth import Cloth
from tracking.render_scene import Camera
from tracking.render_shot import ShotScene, shot_frames, shot_path, shot_truth, write_shot

CAMERA = Camera(fps=120, metres_per_pixel=0.0032, width_px=320, noise=0)
SHOT = ShotScene(
    velocity=(1.0, 0.2),
    angular_velocity=(-8.0, -30.0),
    cloth=Cloth(friction=0.2, rolling_resistance=0.01),
    start=(0.25, 0.25),
    duration=0.4,
    height_px=160,
    camera=CAMERA,
)


def test_shot_agrees_with_recordings_rendered_elsewhere(shared_data: Path) -> None:
    for file in (shared_data / "rendered" / "shots").glob("shot-*.json"):
        theirs = json.loads(file.read_text())
        cloth = Cloth(friction=theirs["mu"], rolling_resistance=theirs["rolling"])
        scene = ShotScene(velocity=theirs["v"], angular_velocity=theirs["w"], cloth=cloth)
        ours = shot_truth(scene)
        time, *place = np.array(theirs["path"]).T
        assert set(theirs) <= set(ours)
        assert ours["roll_t"] == pytest.approx(theirs["roll_t"], abs=1e-3)
        assert shot_path(scene, time + scene.strike) == pytest.approx(np.array(place).T, abs=1e-3)


def test_ball_is_seen_where_the_truth_says() -> None:
    picture = list(shot_frames(SHOT))[40].astype(float)
    white = picture.min(axis=2) > 75
    rows, columns = np.nonzero(white)
    seen = np.ptp(columns) / 2 + columns.min(), np.ptp(rows) / 2 + rows.min()
    x, y = shot_path(SHOT, [40 / 120 + CAMERA.exposure / 2])[0] / 0.0032
    assert seen == pytest.approx((x - 0.5, 159.5 - y), abs=1.5)


def test_ball_rests_until_the_cue_arrives() -> None:
    assert np.ptp(shot_path(SHOT, [0, 0.1, SHOT.strike]), axis=0).max() == 0
    first, before = (picture[60:100, 60:100].astype(int) for picture in list(shot_frames(SHOT))[:17:16])
    assert np.abs(before - first).max() > 50


def test_truth_stands_beside_the_file(tmp_path: Path) -> None:
    shown = write_shot(SHOT, tmp_path / "shot.mp4")
    assert json.loads((tmp_path / "shot.json").read_text()) == shown
    assert shown["frames"] == 48
    assert (tmp_path / "shot.mp4").stat().st_size > 5000


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: replace(SHOT, radius=0.0), "radius must be positive and finite, got 0.0"),
        (lambda: replace(SHOT, duration=0.1), "duration must exceed the strike, 0.15 s, got 0.1"),
        (lambda: replace(SHOT, height_px=101), "height_px must be an even number of at least 64, got 101"),
        (lambda: replace(SHOT, camera=Camera(tilt=0.1)), "camera must have no tilt, drift_px and readout"),
    ],
)
def test_impossible_shots_are_refused_by_name(make: Callable[[], Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        make()

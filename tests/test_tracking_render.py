"""Synthetic recordings: what they show is what their truth says."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracking.render import Camera, DropScene, Look, ball_centres, frames, render_ball, truth, write_recording
from tracking.render_motion import heights, play

PLATE = DropScene(kind="plate", drop_height=0.1)
TWO = DropScene(kind="two", drop_height=0.1, first_rebound=(0.78, 0.19), seed=5)
HELD = DropScene(kind="held", drop_height=0.1, seed=3)
QUIET = Camera(noise=0, flicker=0)


def centroid(picture: np.ndarray, level: float = 0.0) -> tuple[float, float]:
    weight = np.clip(np.asarray(picture, float) - level, 0, None)
    rows, columns = np.indices(weight.shape)
    return (weight * columns).sum() / weight.sum(), (weight * rows).sum() / weight.sum()


@given(st.floats(28, 32), st.floats(28, 32), st.floats(5, 25))
def test_flat_ball_has_its_centroid_at_the_stated_centre(x: float, y: float, radius: float) -> None:
    patch = np.zeros((61, 61, 3), np.float32)
    render_ball(patch, (x, y), radius, Look(colour=(100, 200, 50), shading=0))
    assert centroid(patch[:, :, 1]) == pytest.approx((x, y), abs=0.003)
    assert np.sqrt(patch[:, :, 1].sum() / 200 / np.pi) == pytest.approx(radius, abs=0.2 / radius)


def test_shaded_ball_is_bright_where_the_lamp_is_and_dark_below() -> None:
    patch = np.full((61, 61, 3), 90, np.float32)
    render_ball(patch, (30, 30), 20, Look(colour=(120, 120, 120)))
    assert patch[18, 22].mean() > 120 > 60 > patch[44, 40].mean()


def test_blur_lies_symmetrically_about_the_middle_of_the_exposure() -> None:
    patch = np.zeros((61, 61, 3), np.float32)
    way = np.column_stack([np.full(9, 30.0), np.linspace(26.2, 34.2, 9)])
    render_ball(patch, way, 12, Look(colour=(200, 200, 200), shading=0))
    assert centroid(patch[:, :, 0]) == pytest.approx((30.0, 30.2), abs=0.003)


def test_rows_read_in_turn_stretch_a_ball_that_follows_them() -> None:
    patch = np.zeros((81, 61, 3), np.float32)
    rows = np.arange(81)
    centres = np.stack([np.full(81, 30.0), 30 + 0.2 * (rows - 30)], axis=-1)[np.newaxis]
    render_ball(patch, centres, 12, Look(colour=(200, 200, 200), shading=0))
    assert patch[:, 30, 0].sum() / 200 == pytest.approx(24 / 0.8, abs=0.1)
    assert patch[30, :, 0].sum() / 200 == pytest.approx(24, abs=0.1)


def test_a_ball_outside_the_picture_leaves_it_alone() -> None:
    patch = np.full((20, 20, 3), 7, np.float32)
    render_ball(patch, (-40, 50), 10, Look(colour=(1, 2, 3)))
    assert np.all(patch == 7)


@pytest.mark.parametrize("readout", [0.0, 0.003])
def test_falling_ball_in_a_frame_is_where_the_truth_says(readout: float) -> None:
    scene = replace(PLATE, drop_height=0.3, hold=0.06, camera=replace(QUIET, readout=readout))
    pictures = [picture.astype(float) for picture in frames(scene)]
    frame = 55
    rough = ball_centres(scene, 0, frame / 240)
    row_time = readout * rough[1] / scene.size_px[1]
    x, y = ball_centres(scene, 0, frame / 240 + row_time + scene.camera.exposure / 2)
    left, top = int(x) - 40, int(y) - 40
    blue = np.s_[top : top + 81, left : left + 81, 0]
    covered = (pictures[20] - pictures[frame])[blue] > 50
    seen = [np.flatnonzero(covered.any(axis=axis))[[0, -1]].mean() for axis in (0, 1)]
    assert np.add(seen, (left, top)) == pytest.approx((x, y), abs=0.6)


@pytest.mark.parametrize("scene", [PLATE, HELD, TWO])
def test_as_many_frames_as_the_truth_says(scene: DropScene) -> None:
    pictures = list(frames(scene))
    width, height = scene.size_px
    assert len(pictures) == truth(scene)["frames"] == np.ceil(play(scene).end * 240)
    assert {picture.shape for picture in pictures} == {(height, width, 3)}


def test_same_seed_same_pictures_and_another_seed_another_wall() -> None:
    first, again, other = (next(frames(scene)) for scene in (HELD, HELD, replace(HELD, seed=4)))
    assert np.array_equal(first, again)
    assert np.abs(first.astype(int) - other).mean() > 5


@pytest.mark.parametrize("fps", [240, 60, 29.97])
def test_file_has_the_truth_beside_it_and_exact_time_stamps(tmp_path: Path, fps: float) -> None:
    scene = replace(HELD, camera=Camera(fps=fps, file_fps=None))
    shown = write_recording(scene, tmp_path / "held-01.mp4")
    with av.open(str(tmp_path / "held-01.mp4")) as container:
        times = [float(frame.time) for frame in container.decode(video=0)]
    assert json.loads((tmp_path / "held-01.json").read_text()) == shown
    assert times == pytest.approx(np.arange(shown["frames"]) / fps, rel=1e-5)


@pytest.mark.parametrize("preset", ["ultrafast", "veryfast"])
def test_same_scene_same_file(tmp_path: Path, preset: str) -> None:
    for name in ("one.mp4", "two.mp4"):
        write_recording(PLATE, tmp_path / name, preset=preset)
    assert (tmp_path / "one.mp4").read_bytes() == (tmp_path / "two.mp4").read_bytes()


def test_slow_motion_file_claims_its_own_rate(tmp_path: Path) -> None:
    shown = write_recording(replace(PLATE, camera=Camera(file_fps=30)), tmp_path / "slow.mp4")
    with av.open(str(tmp_path / "slow.mp4")) as container:
        assert container.streams.video[0].average_rate == 30
    assert (shown["fps"], shown["file_fps"]) == (240, 30)


def test_uncompressed_file_keeps_every_brightness(tmp_path: Path) -> None:
    write_recording(PLATE, tmp_path / "exact.mp4", crf=0)
    with av.open(str(tmp_path / "exact.mp4")) as container:
        stored = next(container.decode(video=0)).to_ndarray()[: PLATE.size_px[1]]
    blue, green, red = np.moveaxis(next(frames(PLATE)).astype(float), 2, 0)
    brightness = 16 + (24.966 * blue + 128.553 * green + 65.481 * red) / 255  # ITU-R BT.601
    assert np.abs(stored - brightness).max() <= 1


@pytest.mark.parametrize("scene", [PLATE, HELD, TWO])
def test_velocities_in_the_truth_are_slopes_of_the_path(scene: DropScene) -> None:
    drop = play(scene)
    for event in truth(scene)["events"]:
        for path, before, after in zip(drop.paths, event["v0"], event["v1"], strict=True):
            near = heights(path, event["t"] + np.array([-1e-7, 0, 1e-7]))
            assert np.diff(near) / 1e-7 == pytest.approx([before, after], abs=1e-4)


def test_balls_never_overlap_nor_enter_the_plate() -> None:
    upper, lower = (heights(path, np.linspace(0, play(TWO).end, 20000)) for path in play(TWO).paths)
    assert np.all(upper - lower > 0.04 - 1e-6)
    assert np.all(lower > 0.02 - 1e-6)


def test_first_rebound_is_the_given_one_and_later_ones_keep_momentum() -> None:
    first, *later = truth(TWO)["events"]
    assert first["v1"] == pytest.approx([-0.78 * first["v0"][0], -0.19 * first["v0"][0]])
    assert len(later) >= 1
    for event in later:
        assert sum(event["v1"]) == pytest.approx(sum(event["v0"]))


def test_truth_agrees_with_recordings_rendered_elsewhere(shared_data: Path) -> None:
    for path in (shared_data / "rendered" / "drops").glob("*-[01]?.json"):
        theirs = json.loads(path.read_text())
        first = theirs["events"][0]
        rebound = tuple(v / -first["v0"][0] for v in first["v1"]) if theirs["kind"] == "two" else None
        ours = truth(
            DropScene(
                kind=theirs["kind"],
                drop_height=theirs["drop_height_m"],
                masses=theirs["masses_kg"],
                restitution_balls=theirs["e1"],
                restitution_plate=theirs["e2"],
                first_rebound=rebound,
            )
        )
        # they step through time by 0.05 ms
        assert ours["events"][0]["t"] == pytest.approx(first["t"], abs=1e-4)
        assert ours["events"][0]["v1"] == pytest.approx(first["v1"], abs=1e-3)
        assert set(theirs) <= set(ours)


def test_tilt_sway_and_sideways_flight_move_the_ball_in_the_picture() -> None:
    straight = ball_centres(HELD, 0, [0.0, 0.15])
    swaying = ball_centres(replace(HELD, camera=Camera(drift_px=5)), 0, [0.0, 0.15])
    tilted = ball_centres(replace(HELD, camera=Camera(tilt=0.05)), 0, [0.0, 0.15])
    thrown = ball_centres(replace(HELD, sideways_velocity=0.1), 0, [0.0, 0.15])
    assert np.ptp(straight[:, 0]) == 0
    assert swaying[0] == pytest.approx(straight[0])
    assert swaying[1, 0] - straight[1, 0] == pytest.approx(5 * np.sin(2 * np.pi * 0.6 * 0.15))
    assert np.ptp(tilted[:, 0]) == pytest.approx(np.sin(0.05) * np.ptp(straight[:, 1]))
    assert thrown[1, 0] - straight[1, 0] == pytest.approx(0.1 * (0.15 - HELD.hold) / 0.0008)


def test_every_hand_and_camera_can_be_filmed() -> None:
    camera = Camera(tilt=0.05, drift_px=3, readout=0.003, flicker=0.1, width_px=320)
    for seed in range(4):
        for scene in (PLATE, HELD, TWO):
            picture = next(frames(replace(scene, seed=seed, camera=camera)))
            assert 40 < picture.mean() < 200


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: DropScene(kind="floor", drop_height=1),  # type: ignore[arg-type]
            "kind must be plate, held or two, got 'floor'",
        ),
        (
            lambda: replace(PLATE, masses=(-1.0, 1.0)),
            r"masses must be two positive numbers, got \(-1.0, 1.0\)",
        ),
        (lambda: replace(PLATE, radii=(0.0, 0.02)), r"radii must be two positive numbers, got \(0.0, 0.02\)"),
        (lambda: replace(PLATE, drop_height=-0.1), "drop_height must be positive and finite, got -0.1"),
        (
            lambda: replace(PLATE, restitution_plate=1.2),
            r"restitution_plate must be within \[0, 1\], got 1.2",
        ),
        (lambda: replace(PLATE, hold=0.0), "hold must be at least 0.05 s, got 0.0"),
        (
            lambda: replace(PLATE, first_rebound=(0.5, 0.1)),
            'first_rebound must be given with kind "two" only',
        ),
        (lambda: replace(TWO, first_rebound=None), "first_rebound must be .upper, lower. .*, got None"),
        (
            lambda: replace(TWO, first_rebound=(0.1, 0.5)),
            "first_rebound must be .upper, lower. with 0 <= lower",
        ),
        (lambda: Camera(fps=0), "fps must be positive and finite, got 0"),
        (lambda: Camera(file_fps=-30), "file_fps must be positive, got -30"),
        (lambda: Camera(width_px=361), "width_px must be an even number of at least 64, got 361"),
        (lambda: Camera(exposure=0.1), r"exposure must be within \[0, 0.00416667\] s \(1/fps\), got 0.1"),
        (lambda: Camera(metres_per_pixel=0), "metres_per_pixel must be positive, got 0"),
        (lambda: Look(colour=(0, 0, 0), shading=2), r"shading must be within \[0, 1\], got 2"),
        (
            lambda: render_ball(np.zeros((9, 9, 3), np.float32), (4, 4), 0, Look(colour=(1, 1, 1))),
            "radius must",
        ),
    ],
)
def test_impossible_scenes_are_refused_by_name(make: Callable[[], Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        make()

"""Recordings to a table of trials: right where there is truth, honest where something is wrong."""

import csv
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from clips import SMALL, Clip, film

from calibrate.trials import read_trials
from experiments.batch import Batch, process_all
from experiments.experiment import ExperimentError
from experiments.measured import Measured
from experiments.process import measure
from experiments.trial import Body, Camera, Trial
from tracking.encode import write_video
from tracking.render import DropScene
from tracking.video import open_recording, read_frames

BALL = Body(mass=0.0027, diameter=0.040)
GIVEN = Camera(scale={"metres_per_pixel": 0.0008})
VELOCITIES = ("approach_velocity", "upper_rebound_velocity", "lower_rebound_velocity")
SHORTEST = DropScene(kind="plate", drop_height=0.06, after=0.12, hold=0.05, camera=SMALL)


def trial_of(video: Path, kind: str = "plate", **told: Any) -> Trial:
    told = {"bodies": {"upper": BALL, "lower": BALL}, "camera": GIVEN} | told
    return Trial(name=video.stem, video=video, kind=kind, **told)


def first_row(measured: Measured) -> dict[str, Any]:
    return measured.rows[0]


def assert_true(row: dict[str, Any], truth: dict[str, Any]) -> None:
    """Approach and rebound of the upper ball within 0.5 % of truth, of the lower ball within 2 %."""
    event = truth["events"][0]
    assert row["status"] == "ok", row["reason"]
    assert row["approach_velocity"] == pytest.approx(event["v0"][0], rel=0.005)
    assert row["upper_rebound_velocity"] == pytest.approx(event["v1"][0], rel=0.005)
    assert row["gravity_check"] == pytest.approx(1, abs=0.03)
    if truth["kind"] == "two":
        assert row["lower_rebound_velocity"] == pytest.approx(event["v1"][1], rel=0.02)
    sds = [row[f"{name}_sd"] for name in VELOCITIES[: 3 if truth["kind"] == "two" else 2]]
    assert min(sds) > 0


@pytest.fixture(scope="module")
def plate(plate_clip: Clip) -> Measured:
    return measure(trial_of(plate_clip.path))


def test_ball_on_the_plate(plate: Measured, plate_clip: Clip) -> None:
    assert_true(first_row(plate), plate_clip.truth)
    assert first_row(plate)["lower_mass"] is None


def test_restitution_on_the_plate_stands_in_its_row_as_true_as_the_velocities(
    plate: Measured, plate_clip: Clip
) -> None:
    row, event = first_row(plate), plate_clip.truth["events"][0]
    assert row["restitution"] == -row["upper_rebound_velocity"] / row["approach_velocity"]
    assert row["restitution"] == pytest.approx(
        -event["v1"][0] / event["v0"][0], abs=3 * row["restitution_sd"]
    )
    apart = np.hypot(*(row[f"{name}_sd"] / row[name] for name in VELOCITIES[:2])) * row["restitution"]
    assert 0 < row["restitution_sd"] < 1.1 * apart  # what both velocities share takes nothing from a ratio


def test_a_bounce_of_which_too_little_is_seen_is_said_and_the_next_is_measured(tmp_path: Path) -> None:
    clip = film(replace(SHORTEST, after=0.4), tmp_path / "whole.mp4")
    first, second, *_ = (event["t"] for event in clip.truth["events"])
    fps, frames = SMALL.fps, [frame.image for frame in read_frames(open_recording(clip.path))]
    start = int(first * fps) - 3
    write_video(tmp_path / "late.mp4", frames[start:], fps)
    measured = measure(trial_of(tmp_path / "late.mp4"))
    assert first_row(measured)["time"] == pytest.approx(second - start / fps, abs=0.002)
    (remark,) = (remark for remark in measured.remarks if "bounces at" in remark)
    assert float(remark.split()[4]) == pytest.approx(first - start / fps, abs=1 / fps)
    assert not any("bounces at" in remark for remark in measure(trial_of(clip.path)).remarks)


def test_ball_on_a_ball_at_rest(two_clip: Clip) -> None:
    measured = measure(trial_of(two_clip.path, "two"))
    assert_true(first_row(measured), two_clip.truth)
    hop = measured.fits[-1]
    assert hop.ball == "lower"
    assert np.ptp(hop.path[[0, -1], 2]) < 1e-4 < 1e-3 < np.ptp(hop.path[:, 2])  # it ends at its landing
    assert [track.ball for track in measured.tracks] == ["upper", "lower"]
    assert len(measured.rows) == 1


@pytest.mark.parametrize(
    "scale",
    [
        {"ball_diameter": "upper"},
        {"points_px": [[10, 31.5], [10, 331.5]], "distance": 0.24},
        {"corners_px": [[10, 331.5], [190, 331.5], [190, 31.5], [10, 31.5]], "width": 0.144, "height": 0.24},
    ],
)
def test_every_way_to_tell_the_scale_gives_the_same_velocities(
    plate_clip: Clip, scale: dict[str, Any]
) -> None:
    row = first_row(measure(trial_of(plate_clip.path, camera=Camera(scale=scale))))
    event = plate_clip.truth["events"][0]
    tolerance = 0.015 if "ball_diameter" in scale else 0.005
    assert row["approach_velocity"] == pytest.approx(event["v0"][0], rel=tolerance)
    assert row["upper_rebound_velocity"] == pytest.approx(event["v1"][0], rel=tolerance)


def test_wrong_rate_is_suspect_and_the_right_one_proposed(tmp_path: Path) -> None:
    slow = film(replace(SHORTEST, camera=replace(SMALL, file_fps=30)), tmp_path / "slow.mp4")
    row = first_row(measure(trial_of(slow.path)))
    assert row["status"] == "suspect"
    assert row["reason"].endswith("this looks like 240 fps stored as 30; use --capture-fps 240")
    told = measure(trial_of(slow.path, camera=replace(GIVEN, capture_fps=240)))
    assert_true(first_row(told), slow.truth)
    assert "captured at 240 frames/s (--capture-fps) but stored at 30" in told.remarks


def test_wrong_scale_is_suspect(plate_clip: Clip) -> None:
    row = first_row(measure(trial_of(plate_clip.path, bodies={"upper": Body(diameter=0.1)}, camera=Camera())))
    assert row["status"] == "suspect"
    assert "check the scale (--ball-diameter, --metres-per-pixel) and the rate" in row["reason"]


def test_neglected_air_is_said_and_reads_low(plate: Measured, plate_clip: Clip) -> None:
    unknown = measure(trial_of(plate_clip.path, bodies={}))
    assert any("mass is not told, so air is left out" in remark for remark in unknown.remarks)
    assert not any("air is left out" in remark for remark in plate.remarks)
    without, with_air = (
        -first_row(measured)["upper_rebound_velocity"] / first_row(measured)["approach_velocity"]
        for measured in (unknown, plate)
    )
    assert without < with_air


def test_heavier_upper_ball_rebounds_as_filmed_and_keeps_its_mass(tmp_path: Path) -> None:
    scene = DropScene(
        kind="two",
        drop_height=0.1,
        after=0.1,
        masses=(0.0054, 0.0027),
        first_rebound=(0.55, 0.4),
        camera=SMALL,
    )
    clip = film(scene, tmp_path / "heavy.mp4")
    row = first_row(
        measure(trial_of(clip.path, "two", bodies={"upper": Body(mass=0.0054, diameter=0.04), "lower": BALL}))
    )
    assert_true(row, clip.truth)
    assert (row["upper_mass"], row["lower_mass"]) == (0.0054, 0.0027)


def test_rolling_shutter_is_undone_by_its_readout(tmp_path: Path) -> None:
    clip = film(replace(SHORTEST, camera=replace(SMALL, readout=0.004)), tmp_path / "rolling.mp4")
    event = clip.truth["events"][0]
    true = -event["v1"][0] / event["v0"][0]
    ignored, told = (
        -row["upper_rebound_velocity"] / row["approach_velocity"]
        for row in (
            first_row(measure(trial_of(clip.path, camera=replace(GIVEN, readout=readout))))
            for readout in (0.0, 0.004)
        )
    )
    assert told == pytest.approx(true, rel=0.002)
    assert ignored / true - 1 == pytest.approx(-0.0038, abs=0.001)  # as the true centres give without rows


def test_tracks_hold_what_was_seen_and_nothing_between(plate_clip: Clip, tmp_path: Path) -> None:
    pictures = [frame.image.copy() for frame in read_frames(open_recording(plate_clip.path))]
    wall = np.median(np.stack(pictures[::4]), axis=0).astype(np.uint8)
    for hidden in range(40, 46):
        pictures[hidden][60:] = wall[60:]
    write_video(tmp_path / "hidden.mp4", pictures, 240)
    list(process_all([trial_of(tmp_path / "hidden.mp4")], Batch(out=tmp_path / "out", overlays=False)))
    with (tmp_path / "out" / "tracks" / "hidden.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == ["frame", "time", "ball", "x", "y", "x_sd", "y_sd", "radius"]
    assert not {str(frame) for frame in range(40, 46)} & {row["frame"] for row in rows}
    assert {"39", "46"} <= {row["frame"] for row in rows}
    assert all(all(row.values()) for row in rows)
    assert float(rows[0]["radius"]) == pytest.approx(0.02, rel=0.02)


def test_bad_trials_cost_the_others_nothing(plate_clip: Clip, tmp_path: Path) -> None:
    data = plate_clip.path.read_bytes()
    still = [np.full((64, 64, 3), 90, np.uint8)] * 30
    (tmp_path / "cut.mp4").write_bytes(data[: len(data) // 2])
    (tmp_path / "empty.mp4").touch()
    (tmp_path / "folder.mp4").mkdir()
    (tmp_path / "noise.mp4").write_bytes(np.random.default_rng(1).bytes(20_000))
    write_video(tmp_path / "still.mp4", still, 240)
    write_video(
        tmp_path / "fall.mp4",
        [frame.image for frame in read_frames(open_recording(plate_clip.path))][:55],
        240,
    )
    sentences = {
        "cut": "it is not a video, or it is cut short; copy it again from the camera",
        "empty": "the file is empty; copy it again from the camera",
        "folder": "is a folder; name the video in it",
        "noise": "it is not a video, or it is cut short",
        "still": "no ball found that moves through the picture; film a plain ball",
        "fall": "the ball is seen but no impact: film until the ball has rebounded",
        "gone": "no such file; check the spelling and the folder",
    }
    trials = [trial_of(tmp_path / f"{name}.mp4") for name in sentences]
    trials.insert(3, trial_of(plate_clip.path))
    trials.append(replace(trial_of(tmp_path / "still.mp4", "shot"), name="shot"))
    trials.append(replace(trial_of(plate_clip.path, bodies={"upper": Body(mass=1e-6)}), name="feather"))
    trials.append(replace(trial_of(plate_clip.path, bodies={}, camera=Camera()), name="unscaled"))
    trials.append(replace(trial_of(plate_clip.path, bodies={"upper": Body(diameter=0.5)}), name="giant"))
    records = list(process_all(trials, Batch(out=tmp_path / "out")))
    sentences |= {
        "shot": "still.mp4: no ball found that starts to move; film the cloth from above",
        "feather": "mass must exceed that of the displaced air",
        "unscaled": "nothing tells how large a pixel is; give --ball-diameter or --metres-per-pixel",
        "giant": "the ball would be 625 px wide, but must be between 5 and 200 px; check its diameter",
    }
    assert [record.name for record in records] == [trial.name for trial in trials]
    table = read_trials(tmp_path / "out" / "trials.csv").set_index("trial")
    assert table.loc["plate-00", "status"] == "ok"
    for name, sentence in sentences.items():
        assert table.loc[name, "status"] == "failed"
        assert sentence in table.loc[name, "reason"]
    drawn = {path.name for path in (tmp_path / "out" / "overlays").iterdir()}
    assert drawn == {
        f"{name}.{ending}" for name in ("plate-00", "fall", "feather") for ending in ("mp4", "png")
    }


def test_table_of_failures_only_is_written_with_its_reasons(tmp_path: Path) -> None:
    (record,) = process_all([trial_of(tmp_path / "gone.mp4")], Batch(out=tmp_path / "out", workers=4))
    assert record.rows[0]["status"] == "failed"
    with (tmp_path / "out" / "trials.csv").open() as file:
        (row,) = csv.DictReader(file)
    assert row["status"] == "failed"
    assert "gone.mp4: no such file" in row["reason"]


def test_folder_that_cannot_be_made_is_said_before_the_work(plate_clip: Clip, tmp_path: Path) -> None:
    (tmp_path / "out").touch()
    with pytest.raises(ExperimentError, match="out: cannot be made a folder for the results: "):
        next(process_all([trial_of(plate_clip.path)], Batch(out=tmp_path / "out")))
    with pytest.raises(ExperimentError, match="workers must be at least 1, got 0"):
        Batch(out=tmp_path, workers=0)

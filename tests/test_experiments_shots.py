"""Cue shots from recording to table: values, units, reasons; and what a run over shots and pairs writes."""

import csv
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from film_discs import RESTITUTION, film_impact

from calibrate.observed import found_in
from calibrate.trials import read_trials
from experiments import console, shots
from experiments.batch import Batch, process_all
from experiments.measured import Measured
from experiments.process import measure
from experiments.record import Record
from experiments.trial import Body, Camera, Trial
from tracking.cloth import Cloth
from tracking.render_scene import Camera as SceneCamera
from tracking.render_shot import ShotScene, shot_truth, write_shot
from tracking.strike import ShotTrack, track_shot
from tracking.video import open_recording

SIZE = 0.0032  # m/px
SCENE = ShotScene(
    velocity=(1.2, 0.2),
    angular_velocity=(-8.0, -10.0),
    cloth=Cloth(friction=0.2, rolling_resistance=0.01),
    start=(0.25, 0.25),
    duration=0.5,
    height_px=160,
    camera=SceneCamera(fps=120, metres_per_pixel=SIZE, width_px=320, noise=2),
)
CUE_BALL = {"ball": Body(mass=0.1673, diameter=0.0572)}
GIVEN = Camera(scale={"metres_per_pixel": SIZE})
CORNERS = Camera(
    scale={
        "corners_px": [[20, 140], [300, 140], [300, 20], [20, 20]],
        "width": 280 * SIZE,
        "height": 120 * SIZE,
    }
)


@pytest.fixture(scope="module")
def films(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of shot.mp4 and pair.mp4."""
    folder = tmp_path_factory.mktemp("films")
    write_shot(SCENE, folder / "shot.mp4")
    film_impact(folder / "pair.mp4")
    return folder


@pytest.fixture(scope="module")
def run(films: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[dict[str, Record], Path]:
    """One run over a shot without scale, a pair, and a film that is none of both."""
    trials = [
        Trial(name="shot", video=films / "shot.mp4", kind="shot"),
        Trial(name="pair", video=films / "pair.mp4", kind="pair"),
        Trial(name="neither", video=Path(__file__), kind="pair"),
    ]
    out = tmp_path_factory.mktemp("run")
    return {record.name: record for record in process_all(trials, Batch(out=out))}, out


@pytest.fixture(scope="module")
def shot_seen(films: Path) -> ShotTrack:
    return track_shot(open_recording(films / "shot.mp4"))


def shot_of(seen: ShotTrack, **told: Any) -> Measured:
    """Measure a shot that is tracked already."""
    told = {"bodies": CUE_BALL, "camera": GIVEN} | told
    measured = Measured(trial=Trial(name="shot", video=Path("shot.mp4"), kind="shot", **told))
    shots.measure_seen(measured, seen)
    return measured


@pytest.mark.parametrize(("camera", "tolerance"), [(GIVEN, 0.012), (CORNERS, 0.012), (Camera(), 0.04)])
def test_every_scale_gives_launch_spin_and_friction(
    shot_seen: ShotTrack, camera: Camera, tolerance: float
) -> None:
    (row,) = shot_of(shot_seen, camera=camera).rows
    assert (row["status"], row["unit"]) == ("ok", "m"), row["reason"]
    assert (row["velocity_x"], row["velocity_y"]) == pytest.approx(SCENE.velocity, abs=tolerance)
    spin = row["angular_velocity_x"], row["angular_velocity_y"]
    assert spin == pytest.approx(SCENE.angular_velocity, abs=1.5)
    assert abs(row["friction"] - 0.2) < 4 * row["friction_sd"] < 0.1
    assert row["rolling_time"] == pytest.approx(shot_truth(SCENE)["roll_t"], abs=0.02)
    assert abs(row["time"] - SCENE.strike) < 3 * row["time_sd"]
    assert all(value > 0 for column, value in row.items() if column.endswith("_sd") and value is not None)


def test_the_cue_is_told_by_its_speed_direction_and_offset(shot_seen: ShotTrack) -> None:
    measured = shot_of(shot_seen)
    (row,) = measured.rows
    assert row["approach_velocity"] == pytest.approx(SCENE.cue_speed, abs=4 * row["approach_velocity_sd"])
    assert row["approach_direction"] == pytest.approx(SCENE.cue_direction, abs=0.05)
    assert abs(row["contact_offset"]) < 0.15
    assert [track.ball for track in measured.tracks] == ["cue ball", "tip"]


def test_without_a_scale_a_shot_stays_in_pixels_and_says_so(shot_seen: ShotTrack) -> None:
    measured = shot_of(shot_seen, bodies={}, camera=Camera())
    (row,) = measured.rows
    assert (row["status"], row["unit"]) == ("suspect", "px")
    assert "lengths are in pixels" in row["reason"]
    assert "--metres-per-pixel" in row["reason"]
    assert row["velocity_x"] * SIZE == pytest.approx(SCENE.velocity[0], abs=0.012)
    assert row["angular_velocity_y"] == pytest.approx(SCENE.angular_velocity[1], abs=2)
    assert any("that of a pool ball, 57.2 mm" in remark for remark in measured.remarks)


@pytest.mark.parametrize("camera", [GIVEN, Camera()])
def test_at_an_angle_only_four_corners_give_metres(shot_seen: ShotTrack, camera: Camera) -> None:
    tilted = replace(shot_seen, perspective=0.3)
    (row,) = shot_of(tilted, camera=camera).rows
    assert (row["status"], row["unit"]) == ("suspect", "px")
    assert "give four corners" in row["reason"]
    assert shot_of(tilted, camera=CORNERS).rows[0]["unit"] == "m"


def test_a_jump_shot_is_suspect(shot_seen: ShotTrack) -> None:
    lift = shot_seen.lift.copy()
    lift[25:40] = 0.08
    measured = shot_of(replace(shot_seen, lift=lift))
    assert measured.rows[0]["status"] == "suspect"
    assert "jump shot" in measured.rows[0]["reason"]
    assert not any("jump shot" in remark for remark in measured.remarks)


def test_a_ball_of_another_size_than_told_is_suspect(shot_seen: ShotTrack) -> None:
    (row,) = shot_of(shot_seen, bodies={"ball": Body(diameter=0.07)}).rows
    assert row["status"] == "suspect"
    assert "mm wide but its diameter is told as 70.0 mm; check the scale and the diameter" in row["reason"]


def test_a_cut_cue_is_no_reason_to_lose_the_shot(shot_seen: ShotTrack) -> None:
    measured = shot_of(replace(shot_seen, tip=None, missing_tip="no cue is seen"))
    assert measured.rows[0]["status"] == "ok"
    assert "approach_velocity" in measured.rows[0]
    assert measured.rows[0]["approach_velocity"] is None
    assert "no cue is seen" in measured.remarks


def test_the_overlay_marks_the_strike_and_where_the_ball_rolls(shot_seen: ShotTrack) -> None:
    trial = Trial(name="shot", video=Path("shot.mp4"), kind="shot", bodies=CUE_BALL, camera=CORNERS)
    scene = shots.measure_seen(Measured(trial=trial), shot_seen)
    strike, rolls = scene.moments
    assert (strike.words, strike.is_impact, rolls.words, rolls.is_impact) == ("strike", True, "rolls", False)
    assert strike.place == pytest.approx((0.25 / SIZE - 0.5, 160 - 0.25 / SIZE - 0.5), abs=0.6)
    assert scene.curves[0][0] == pytest.approx(strike.place, abs=0.1)
    assert any(line.startswith("velocity (1.") and "m/s" in line for line in scene.lines)


def test_a_ball_that_meets_another_says_when(shot_seen: ShotTrack) -> None:
    ball = shot_seen.ball
    turned = ball.y + 8.0 * np.maximum(ball.time - 0.4, 0) / SIZE * 0.2
    measured = shot_of(replace(shot_seen, ball=replace(ball, y=turned)))
    assert measured.rows[0]["meeting_time"] == pytest.approx(0.4, abs=0.01)
    assert any("the ball meets another ball or a cushion at 0." in remark for remark in measured.remarks)


def test_a_ball_nobody_struck_fails_with_the_name_of_the_file(films: Path) -> None:
    trial = Trial(name="x", video=films / "shot.mp4", kind="shot", start_px=(300.0, 10.0))
    (row,) = measure(trial).rows
    assert row["status"] == "failed"
    assert row["reason"].startswith("shot.mp4: no ball starts to move near start_px (300, 10)")


def test_a_fit_takes_from_the_table_only_the_rows_it_needs(
    run: tuple[dict[str, Record], Path], tmp_path: Path
) -> None:
    table = read_trials(run[1] / "trials.csv").set_index("trial")
    assert table["kind"].tolist() == ["shot", "pair", "pair"]
    assert table.loc["pair", "restitution"] == pytest.approx(RESTITUTION, abs=0.03)
    assert table.loc["shot", "velocity_x"] * SIZE == pytest.approx(1.2, abs=0.02)
    (tmp_path / "typed.csv").write_text("kind,approach_velocity,upper_rebound_velocity\nplate,-2,1.7\n")
    found = found_in(read_trials([run[1] / "trials.csv", tmp_path / "typed.csv"]))
    assert found.plate is not None
    assert found.plate.trials.tolist() == [1]
    assert (found.held, found.two) == (None, None)


def test_tracks_without_a_scale_name_their_unit(run: tuple[dict[str, Record], Path]) -> None:
    with (run[1] / "tracks" / "shot.csv").open() as file:
        assert next(csv.reader(file))[3:] == ["x_px", "y_px", "x_sd_px", "y_sd_px", "radius_px"]


def test_overlays_show_every_genuine_frame_of_what_was_found(
    run: tuple[dict[str, Record], Path], films: Path
) -> None:
    _, out = run
    assert {path.name for path in (out / "overlays").iterdir()} == {
        *("shot.mp4", "shot.png", "pair.mp4", "pair.png")
    }
    for name in ("shot", "pair"):
        recording = open_recording(films / f"{name}.mp4")
        assert open_recording(out / "overlays" / f"{name}.mp4").times.size == recording.genuine.sum()


def test_fitted_paths_are_kept_with_the_times_they_hold_for(run: tuple[dict[str, Record], Path]) -> None:
    records, _ = run
    assert [fit["ball"] for fit in records["pair"].fits] == ["striker", "striker", "struck", "struck"]
    (fit,) = records["shot"].fits
    speed = (fit["x"][1] - fit["x"][0]) / (fit["time"][1] - fit["time"][0])
    assert speed == pytest.approx(records["shot"].rows[0]["velocity_x"], rel=0.02)
    assert records["neither"].fits == []


def test_the_console_has_columns_for_each_kind(run: tuple[dict[str, Record], Path]) -> None:
    heads = {console.headline(kind, 8) for kind in ("plate", "held", "two", "shot", "pair")}
    assert len(heads) == 4
    for name, words in (("shot", "px/s  suspect"), ("pair", "px/s  ok"), ("neither", "  failed")):
        line = next(console.impact_lines(run[0][name], 8))
        head = console.headline(run[0][name].kind, 8)
        assert line.endswith(words)
        assert line.rindex(words.split()[-1]) == head.rindex("status")


def test_nothing_is_drawn_when_not_asked_for(films: Path, tmp_path: Path) -> None:
    trial = Trial(name="pair", video=films / "pair.mp4", kind="pair")
    list(process_all([trial], Batch(out=tmp_path, overlays=False)))
    assert {path.name for path in tmp_path.iterdir()} == {"trials.csv", "trials", "tracks"}
    assert pd.read_csv(tmp_path / "trials.csv")["status"].tolist() == ["ok"]

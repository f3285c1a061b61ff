"""From pictures to one track a ball: where it is to a fraction of a pixel, and nothing invented."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from clips import Clip, film

from tracking import sight
from tracking.encode import write_video
from tracking.errors import RecordingError
from tracking.render import ball_centres
from tracking.shutter import with_row_times
from tracking.track import Track, track_balls
from tracking.video import open_recording


@pytest.fixture(scope="module")
def plate_track(plate_clip: Clip) -> Track:
    (track,) = track_balls(open_recording(plate_clip.path))
    return track


@pytest.fixture(scope="module")
def two_tracks(two_clip: Clip) -> list[Track]:
    return track_balls(open_recording(two_clip.path), lower=1.0)


@pytest.mark.parametrize("most", [1, 20])
def test_a_ball_is_seen_the_same_however_many_frames_are_looked_at_at_once(
    most: int, plate_clip: Clip, plate_track: Track, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sight, "BATCH", most)
    (found,) = track_balls(open_recording(plate_clip.path))
    _, one, other = np.intersect1d(plate_track.frame, found.frame, return_indices=True)
    assert len(one) > 0.97 * len(plate_track.frame)
    apart = np.hypot(plate_track.x[one] - found.x[other], plate_track.y[one] - found.y[other])
    assert np.median(apart) < 0.02
    assert apart.max() < 0.3


def misses(track: Track, clip: Clip, ball: int) -> np.ndarray:
    """Distance in px from the true centre in the middle of the exposure, frames that straddle impacts out."""
    shown = ball_centres(clip.scene, ball, track.time + clip.truth["exposure"] / 2)
    impacts = np.array([event["t"] for event in clip.truth["events"]])
    clear = np.abs(track.time[:, None] - impacts).min(axis=1) > 1 / 240
    flying = track.time > clip.truth["release_t"] + 0.05
    return (np.column_stack((track.x, track.y)) - shown)[clear & flying]


def test_ball_of_one_colour_is_found_to_a_tenth_of_a_pixel(plate_clip: Clip, tmp_path: Path) -> None:
    dark = film(replace(plate_clip.scene, colours=((30.0, 30.0, 30.0),) * 2), tmp_path / "dark.mp4")
    (track,) = track_balls(open_recording(dark.path))
    apart = misses(track, dark, 0)
    assert len(apart) > 70
    assert np.sqrt(np.mean(apart**2, axis=0)).max() < 0.1
    assert track.radius == pytest.approx(25.0, abs=0.1)


def test_shading_shifts_a_ball_by_the_same_half_pixel_everywhere(
    plate_track: Track, plate_clip: Clip
) -> None:
    apart = misses(plate_track, plate_clip, 0)
    assert len(apart) > 70
    assert np.std(apart, axis=0).max() < 0.15
    assert np.abs(np.median(apart, axis=0)).max() < 0.5


def test_white_ball_is_not_taken_for_its_bright_part(plate_clip: Clip, tmp_path: Path) -> None:
    white = film(replace(plate_clip.scene, colours=((235.0, 235.0, 235.0),) * 2), tmp_path / "white.mp4")
    (track,) = track_balls(open_recording(white.path))
    assert track.radius == pytest.approx(25.0, rel=0.015)
    assert np.abs(np.median(misses(track, white, 0), axis=0)).max() < 0.5


def test_both_balls_are_found_where_they_are(two_tracks: list[Track], two_clip: Clip) -> None:
    assert [track.ball for track in two_tracks] == ["upper", "lower"]
    for ball, track in enumerate(two_tracks):
        apart = misses(track, two_clip, ball)
        assert np.std(apart, axis=0).max() < 0.2
        assert np.abs(np.median(apart, axis=0)).max() < 1.5


def test_radius_is_that_of_the_ball_within_a_few_hundredths(
    plate_track: Track, two_tracks: list[Track]
) -> None:
    for track in (plate_track, *two_tracks):
        assert track.radius == pytest.approx(25.0, rel=0.06)
        assert 0 < track.radius_sd < 0.5


def test_radius_told_beforehand_changes_nothing_much(plate_track: Track, plate_clip: Clip) -> None:
    (told,) = track_balls(open_recording(plate_clip.path), radius=25.0)
    both = np.intersect1d(told.frame, plate_track.frame)
    assert len(both) > 70
    ours, theirs = (track.y[np.isin(track.frame, both)] for track in (told, plate_track))
    assert np.median(np.abs(ours - theirs)) < 0.1


def test_every_place_has_an_uncertainty_a_time_and_enough_rim(plate_track: Track, plate_clip: Clip) -> None:
    assert np.all((plate_track.x_sd > 0) & (plate_track.y_sd > 0) & (plate_track.y_sd < 1))
    assert np.all((plate_track.arc >= np.deg2rad(120)) & (plate_track.arc <= 2 * np.pi + 1e-9))
    assert plate_track.time == pytest.approx(plate_track.frame / 240, abs=1e-4)
    assert np.all(np.diff(plate_track.frame) > 0)
    assert plate_track.unit == "px"


def test_picture_without_motion_holds_no_ball(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    wall = rng.integers(60, 190, (96, 96, 3), dtype=np.uint8)
    noisy = ((wall + rng.normal(0, 3, wall.shape)).clip(0, 255).astype(np.uint8) for _ in range(40))
    for name, pictures in (("same.mp4", [wall] * 40), ("noise.mp4", noisy)):
        write_video(tmp_path / name, pictures, 240)
        with pytest.raises(RecordingError, match=rf"{name}: no ball found that moves .*; film a plain ball"):
            track_balls(open_recording(tmp_path / name))


@pytest.mark.parametrize("radius", [1e-6, 1.0, 150.0, 1e12])
def test_ball_that_does_not_fit_the_picture_is_refused(plate_clip: Clip, radius: float) -> None:
    recording = open_recording(plate_clip.path)
    with pytest.raises(
        RecordingError, match=r"plate-00\.mp4: the ball would be .* px wide, but must be between"
    ):
        track_balls(recording, radius=radius)
    with pytest.raises(RecordingError, match="the lower ball would be"):
        track_balls(recording, radius=25.0, lower=radius / 25)


def test_rows_read_later_show_the_ball_later(plate_track: Track, plate_clip: Clip) -> None:
    recording = open_recording(plate_clip.path)
    timed = with_row_times(plate_track, recording, 0.004)
    last_column, last_row = np.subtract(plate_clip.scene.size_px, 1)
    assert timed.time - plate_track.time == pytest.approx(0.004 * plate_track.y / last_row)
    for turns, share in ((1, plate_track.x / last_column), (2, 1 - plate_track.y / last_row)):
        turned = with_row_times(plate_track, replace(recording, quarter_turns=turns), 0.004)
        assert turned.time - plate_track.time == pytest.approx(0.004 * share)

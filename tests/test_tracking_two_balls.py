"""A ball falls on one at rest that looks like it, before a wall that looks like both."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from clips import film
from tracks import BALL

from experiments.process import measure
from experiments.trial import Body, Trial
from experiments.trial import Camera as Filmed
from tracking.blob import Blob
from tracking.encode import write_video
from tracking.fall import first_fall, goes_on
from tracking.render import Camera, DropScene, ball_centres
from tracking.resting import find_resting
from tracking.track import track_balls
from tracking.video import open_recording, revisit

WHITE, GREY, ORANGE = (235.0, 238.0, 240.0), (215.0, 220.0, 225.0), (40.0, 130.0, 235.0)
VELOCITIES = ("approach_velocity", "upper_rebound_velocity", "lower_rebound_velocity")


def path_of(*parts: np.ndarray) -> dict[int, Blob]:
    """A path through patches at these depths, px, one a frame."""
    return {number: replace(BALL, y=float(y)) for number, y in enumerate(np.concatenate(parts))}


HELD, FALL = np.full(10, 50.0), 50 + 0.15 * np.arange(40) ** 2
RISE = FALL[-1] - 6 * np.arange(1, 20)


BIG_ON_SMALL = DropScene(
    kind="two",
    drop_height=0.2,
    after=0.4,
    radii=(0.030, 0.020),
    masses=(0.008, 0.0027),
    first_rebound=(0.6, 0.5),
    camera=Camera(width_px=320),
    colours=(WHITE, WHITE),
    seed=8,
)
ALIKE = replace(BIG_ON_SMALL, radii=(0.020, 0.020), masses=(0.0027, 0.0027))


@pytest.mark.parametrize(
    "scene",
    [
        BIG_ON_SMALL,
        replace(ALIKE, colours=(GREY, GREY), first_rebound=(0.75, 0.35), seed=0),
        replace(BIG_ON_SMALL, colours=(GREY, GREY)),
        replace(ALIKE, colours=(ORANGE, WHITE), first_rebound=(0.3, 0.25), seed=15),
    ],
)
def test_two_balls_are_measured_before_a_wall_as_bright_as_they(scene: DropScene, tmp_path: Path) -> None:
    clip = film(scene, tmp_path / "two.mp4")
    event = clip.truth["events"][0]
    bodies = {
        name: Body(mass=mass, diameter=2 * radius)
        for name, mass, radius in zip(("upper", "lower"), scene.masses, scene.radii, strict=True)
    }
    for scale, within in (({"metres_per_pixel": 0.0008}, 0.003), ({"ball_diameter": "upper"}, 0.01)):
        trial = Trial(name="two", video=clip.path, kind="two", bodies=bodies, camera=Filmed(scale=scale))
        (row,) = measure(trial).rows
        assert row["status"] == "ok", row["reason"]
        told = [row[name] for name in VELOCITIES]
        assert told == pytest.approx((event["v0"][0], *event["v1"]), rel=within)


def test_a_path_that_leaps_to_another_ball_goes_on_in_fewer_frames() -> None:
    whole = path_of(HELD, FALL, RISE)
    strays = path_of(HELD, FALL, RISE[:4], np.full(8, FALL[-1] + 40), RISE[12:])
    assert goes_on(whole, 20.0) > goes_on(strays, 20.0) > goes_on(path_of(np.full(60, 50.0)), 20.0) == 0
    aside = RISE + np.where((np.arange(19) > 5) & (np.arange(19) < 12), 45.0, 0.0)
    assert goes_on(path_of(HELD, FALL, aside), 20.0) <= goes_on(whole, 20.0) - 10
    assert goes_on({}, 20.0) == 0


@pytest.mark.parametrize("leap", [30.0, 60.0, 300.0])
def test_a_fall_ends_where_the_path_leaps_to_the_ball_below(leap: float) -> None:
    below = np.full(10, FALL[-1] + leap)
    assert first_fall(path_of(HELD, FALL, below), 20.0)[-1] == 49
    assert first_fall(path_of(HELD, FALL, RISE), 20.0)[-1] == 49


@pytest.mark.parametrize("times", [1, 4, 10])
def test_a_fall_is_seen_to_its_end_though_patches_tremble(times: int) -> None:
    """A fast camera's patches are now all of the ball, now its lit side: 8 px higher."""
    depth = np.interp(np.arange(40 * times) / times, np.arange(40), FALL)
    rise = depth[-1] - 6 / times * np.arange(1, 20 * times)
    lit = np.where(np.arange(len(depth) + len(rise)) % 7 < 2, 8.0, 0.0)
    fall = first_fall(path_of(np.concatenate((depth, rise)) - lit), 25.0)
    assert fall[-1] == pytest.approx(40 * times, abs=3 * times)


def test_a_ball_that_a_hand_lowers_does_not_fall() -> None:
    lowered = np.concatenate((50 + 2.0 * np.arange(40), (128.0, 123.0, 120.0, 120.0)))
    fall = first_fall(path_of(lowered, FALL + 70, RISE + 70), 20.0)
    assert fall[0] >= 40
    assert fall[-1] == 83


def test_one_misread_patch_does_not_end_a_fall() -> None:
    depth = FALL.copy()
    depth[25] -= 8
    assert first_fall(path_of(HELD, depth, RISE, RISE[-1] + 0.15 * np.arange(40) ** 2), 20.0)[-1] == 49


@pytest.mark.parametrize("fps", [60, 120])
def test_a_fall_seen_in_few_frames_ends_where_the_path_leaps(fps: float) -> None:
    """Half a metre, in pixels of 0.8 mm; the ball below is 2 radii of 25 px further down."""
    fall = 50 + 9.81 / 2 / 0.0008 * (np.arange(int(0.32 * fps)) / fps) ** 2
    path = path_of(fall, np.full(12, fall[-1] + 50 + 3.1 / fps / 0.0008 / 2))
    assert first_fall(path, 25.0)[-1] == len(fall) - 1


def test_a_short_fall_ends_where_the_ball_turns() -> None:
    assert first_fall(path_of(FALL[:15], FALL[14] - np.arange(1, 9)), 20.0)[-1] == 14


@pytest.mark.parametrize("above", [0.0, 1.0, 2.5])
def test_a_resting_ball_is_not_taken_for_its_mirror_image_in_the_plate(above: float, tmp_path: Path) -> None:
    """It rests so many radii lower than expected: the other's fall was not seen to its end."""
    camera = Camera(width_px=320)
    scene = DropScene(
        kind="two", drop_height=0.2, first_rebound=(0.7, 0.4), camera=camera, seed=9, colours=(WHITE, WHITE)
    )
    clip = film(scene, tmp_path / "rests.mp4")
    recording = open_recording(clip.path)
    x, y = ball_centres(scene, 1, recording.times[:1])[0]
    found = find_resting(recording, 0, (x - 4.0, y - above * 25, 25.0))
    assert found == pytest.approx((x, y, 25.0), abs=1.0)


def test_an_impact_on_a_ball_that_moves_already_is_not_called_ok(tmp_path: Path) -> None:
    """The film begins after their first impact; their second is one of two moving balls."""
    camera = Camera(width_px=320)
    scene = DropScene(
        kind="two",
        drop_height=0.2,
        after=0.5,
        first_rebound=(0.6, 0.4),
        camera=camera,
        colours=(ORANGE, WHITE),
    )
    whole = film(scene, tmp_path / "whole.mp4")
    images = [view.frame().image for view in revisit(open_recording(whole.path))]
    first = whole.truth["events"][0]["t"]
    late = tmp_path / "late.mp4"
    write_video(late, iter(images[int(first * camera.fps) + 3 :]), camera.fps, crf=20)
    bodies = {name: Body(mass=0.0027, diameter=0.040) for name in ("upper", "lower")}
    scale = {"metres_per_pixel": camera.metres_per_pixel}
    trial = Trial(name="late", video=late, kind="two", bodies=bodies, camera=Filmed(scale=scale))
    (row,) = measure(trial).rows
    assert row["status"] != "ok"


def test_a_ball_seen_clearly_shows_its_size_and_one_like_the_wall_does_not(tmp_path: Path) -> None:
    for colour, shown in ((ORANGE, True), (WHITE, False)):
        scene = DropScene(
            kind="plate", drop_height=0.15, camera=Camera(width_px=320), seed=4, colours=(colour, colour)
        )
        (ball,) = track_balls(open_recording(film(scene, tmp_path / "one.mp4").path))
        assert ball.shows_size == shown

"""What is kept of a recording shows every frame again, and a long one is read once."""

from collections.abc import Callable, Sequence
from pathlib import Path

import cv2
import numpy as np
import pytest
from clips import Clip

from tracking import keeper as keeping
from tracking import video
from tracking.encode import write_video
from tracking.keeper import Keeper
from tracking.kept import shown
from tracking.planes import Planes
from tracking.render import Look, render_ball
from tracking.track import track_balls
from tracking.video import open_recording, read_frames

WALL, HEIGHT, WIDTH = 110.0, 240, 400
HELD, FALLING = 12, 180
HAND = slice(0, 120), slice(0, 200)


def scene(x: float, *hands: tuple[slice, slice]) -> Planes:
    """A ball before a wall, and hands in some places."""
    wall = np.full((HEIGHT, WIDTH, 3), WALL, np.float32)
    for place in hands:
        wall[place] = 40.0
    render_ball(wall, (x, 205.0), 8.0, Look(colour=(170, 170, 170), shading=0))
    colour = np.full((HEIGHT // 2, WIDTH // 2), 128, np.uint8)
    return wall[..., 0].astype(np.uint8), colour, colour


def keep(frames: Sequence[Planes]) -> Keeper:
    keeper = Keeper()
    for planes in frames:
        keeper.look(planes)
    return keeper


def again(keeper: Keeper) -> list[np.ndarray]:
    """Brightness of all frames as they are kept."""
    whole = slice(0, HEIGHT), slice(0, WIDTH)
    return [shown(keeper.pictures[frame.picture], frame, whole)[0] for frame in keeper.frames]


def size(keeper: Keeper) -> int:
    return sum(plane.nbytes for frame in keeper.frames for part in frame.parts for plane in part.planes)


def test_ball_that_passes_where_the_kept_picture_shows_one_is_shown_where_it_is() -> None:
    frames = [scene(x) for x in (40.0, 50.0, 60.0, 50.0, 40.5, 30.0)]
    for (brightness, *_), seen in zip(frames, again(keep(frames)), strict=True):
        assert np.abs(brightness.astype(int) - seen).max() <= 1


def test_once_much_is_kept_frames_are_compared_with_what_most_of_them_show(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    places = np.linspace(20.0, 380.0, FALLING)
    frames = [scene(20.0, HAND)] * HELD + [scene(x) for x in places]
    unsettled = keep(frames)
    monkeypatch.setattr(keeping, "MUCH_BYTES", size(unsettled) // 3)
    settled = keep(frames)
    assert size(settled) < size(unsettled) / 2
    np.testing.assert_array_equal(settled.pictures[0][0][:150], WALL)  # no hand
    for (brightness, *_), seen in zip(frames, again(settled), strict=True):
        assert np.abs(brightness.astype(int) - seen).max() <= keeping.LEAST_CHANGE


def test_noise_is_no_change_even_once_frames_are_compared_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(1)

    def noisy(x: float) -> Planes:
        brightness, *colour = scene(x)
        levels = brightness + rng.normal(0, 5, brightness.shape)
        return levels.clip(0, 255).astype(np.uint8), colour[0], colour[1]

    frames = [noisy(x) for x in np.linspace(20.0, 380.0, FALLING)]
    monkeypatch.setattr(keeping, "MUCH_BYTES", 400_000)
    keeper = keep(frames)
    assert len(keeper.pictures) == 1
    assert size(keeper) < 0.15 * FALLING * frames[0][0].size


def test_a_slow_ball_is_shown_where_it_is_after_nearly_everything_changed() -> None:
    most = slice(0, HEIGHT), slice(110, WIDTH)
    frames = [scene(x, most) if x > 60.0 else scene(x) for x in 50.0 + 0.4 * np.arange(60)]
    keeper = keep(frames)
    assert len(keeper.pictures) > 1
    for (brightness, *_), seen in list(zip(frames, again(keeper), strict=True))[HELD:]:
        assert np.abs(brightness.astype(int) - seen).max() <= keeping.LEAST_CHANGE


def test_a_frame_that_differs_nearly_everywhere_from_what_most_show_is_kept_whole(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    frames = [scene(20.0, HAND)] * HELD + [scene(x) for x in np.linspace(20.0, 380.0, FALLING)]
    keeper = keep(frames)
    monkeypatch.setattr(keeping, "NEW_PICTURE_SHARE", 0.2)  # less than the hand
    keeper._settle()
    assert len(keeper.pictures) == 1
    assert again(keeper)[0].min() == pytest.approx(40, abs=1)
    for (brightness, *_), seen in zip(frames, again(keeper), strict=True):
        assert np.abs(brightness.astype(int) - seen).max() <= keeping.LEAST_CHANGE


def test_a_long_recording_is_decoded_once_and_tracked_the_same(
    plate_clip: Clip, monkeypatch: pytest.MonkeyPatch
) -> None:
    (usual,) = track_balls(open_recording(plate_clip.path))
    monkeypatch.setattr(keeping, "MUCH_BYTES", 400_000)
    recording = open_recording(plate_clip.path)
    monkeypatch.delattr(video, "opened")
    (settled,) = track_balls(recording)
    frames, one, other = np.intersect1d(usual.frame, settled.frame, return_indices=True)
    assert len(frames) > 0.97 * len(usual.frame)
    apart = np.hypot(usual.x[one] - settled.x[other], usual.y[one] - settled.y[other])
    assert np.median(apart) < 0.01
    assert apart.max() < 0.1


def test_a_recording_that_cannot_be_kept_is_decoded_twice_and_tracked_the_same(
    plate_clip: Clip, monkeypatch: pytest.MonkeyPatch
) -> None:
    (usual,) = track_balls(open_recording(plate_clip.path))
    decoded, opened = [], video.opened
    monkeypatch.setattr(keeping, "MOST_BYTES", 1000)
    monkeypatch.setattr(video, "opened", lambda path: decoded.append(path) or opened(path))
    (found,) = track_balls(open_recording(plate_clip.path))
    assert len(decoded) == 2
    frames, one, other = np.intersect1d(usual.frame, found.frame, return_indices=True)
    assert len(frames) > 0.97 * len(usual.frame)
    assert np.abs(usual.y[one] - found.y[other]).max() < 0.1


LIGHTS: dict[str, Callable[[int], float]] = {
    "black at first": lambda frame: float(frame > 0),
    "bright at first": lambda frame: 1.1 if frame == 0 else 1.0,
    "fading in": lambda frame: min((frame + 1) / 8, 1.0),
    "lamp on": lambda frame: 1.4 if frame >= 60 else 1.0,
    "lamp off": lambda frame: 0.6 if frame >= 60 else 1.0,
}


@pytest.mark.parametrize("light", LIGHTS.values(), ids=LIGHTS.keys())
def test_a_film_whose_light_changes_is_tracked_the_same(
    light: Callable[[int], float], plate_clip: Clip, tmp_path: Path
) -> None:
    (usual,) = track_balls(open_recording(plate_clip.path))
    frames = read_frames(open_recording(plate_clip.path))
    lit = [cv2.convertScaleAbs(frame.image, alpha=light(frame.index)) for frame in frames]
    write_video(tmp_path / "fade.mp4", lit, plate_clip.scene.camera.fps)
    (found,) = track_balls(open_recording(tmp_path / "fade.mp4"))
    _, one, other = np.intersect1d(usual.frame, found.frame, return_indices=True)
    assert len(one) > 0.9 * len(usual.frame)
    apart = np.hypot(usual.x[one] - found.x[other], usual.y[one] - found.y[other])
    assert np.median(apart) < 0.1
    assert apart.max() < 1.0

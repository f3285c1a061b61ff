"""Two balls in one picture: said, not chosen between in silence; a shadow or a mirror image is no ball."""

from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest

from tracking.blob import Blob
from tracking.encode import write_video
from tracking.errors import RecordingError
from tracking.rivals import acceleration
from tracking.track import track_balls
from tracking.video import open_recording

WHITE, SHADOW = 235, 150
Ball = tuple[int, float, int]
"""Place from the left, px; moment at which it is let go, s; grey level."""


def film(path: Path, *balls: Ball, mirrored: bool = False) -> Path:
    """Balls of 12 px radius that fall from 40 px to 300 px and rebound, at 120 frames a second."""

    def pictures() -> Iterator[np.ndarray]:
        rng = np.random.default_rng(3)
        for number in range(100):
            scene = np.full((340 + 260 * mirrored, 240, 3), 180, np.uint8)
            for x, start, level in balls:
                depth = height(number / 120 - start)
                centres = [(x, depth), (x, 636 - depth)] if mirrored else [(x, depth)]
                for centre in centres:
                    cv2.circle(scene, [round(16 * v) for v in centre], 192, (level,) * 3, -1, cv2.LINE_AA, 4)
            yield (scene + rng.normal(0, 1.5, scene.shape)).clip(0, 255).astype(np.uint8)

    write_video(path, pictures(), 120)
    return path


def height(since: float) -> float:
    fall = 0.5 * 2500 * max(since, 0.0) ** 2
    if fall < 260:
        return 40 + fall
    after = since - np.sqrt(2 * 260 / 2500)
    return 300 - 800 * after + 1250 * after**2


def test_two_balls_that_fall_are_not_chosen_between_in_silence(tmp_path: Path) -> None:
    recording = open_recording(film(tmp_path / "both.mp4", (60, 0.15, WHITE), (170, 0.2, WHITE)))
    with pytest.raises(RecordingError, match=r"both\.mp4: two balls fall, first seen at \(.*\) px; say with"):
        track_balls(recording)


@pytest.mark.parametrize("x", [60, 170])
def test_the_ball_that_a_person_points_at_is_measured(tmp_path: Path, x: int) -> None:
    recording = open_recording(film(tmp_path / "both.mp4", (60, 0.15, WHITE), (170, 0.2, WHITE)))
    (track,) = track_balls(recording, start_px=(x + 5, 45))
    assert np.median(track.x) == pytest.approx(x, abs=0.3)


def test_a_place_where_no_ball_starts_is_refused(tmp_path: Path) -> None:
    recording = open_recording(film(tmp_path / "one.mp4", (60, 0.15, WHITE)))
    with pytest.raises(RecordingError, match=r"no ball starts near start_px \(200, 300\); those that move"):
        track_balls(recording, start_px=(200, 300))


@pytest.mark.parametrize("mirrored", [False, True])
def test_shadow_and_mirror_image_are_no_second_ball(tmp_path: Path, mirrored: bool) -> None:
    balls = [(60, 0.15, WHITE)] if mirrored else [(60, 0.15, WHITE), (130, 0.15, SHADOW)]
    (track,) = track_balls(open_recording(film(tmp_path / "one.mp4", *balls, mirrored=mirrored)))
    assert np.median(track.x) == pytest.approx(60, abs=0.3)


def patch(y: float) -> Blob:
    return Blob(
        x=80, y=y, width=24, height=24, area=452, hull=452, contrast=60, ghost=False, colour=(90, 128, 128),
        at_border=False,
    )  # fmt: skip


def test_what_falls_freely_tells_its_acceleration() -> None:
    assert acceleration({k: patch(20 + 0.5 * k**2) for k in range(24)}, 12) == pytest.approx(1)


def test_a_finger_that_rests_and_a_shadow_far_below_are_no_fall() -> None:
    finger = {number: patch(20 + 0.05 * (number - 20) ** 2) for number in range(20, 28)}
    assert acceleration({**finger, 48: patch(260), 50: patch(222)}, 12) is None

"""Hand-held cameras: slow drift is found and undone, a still camera left alone, a carried one refused."""

from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest

from tracking.encode import write_video
from tracking.errors import RecordingError
from tracking.steady import explains, steadied
from tracking.track import track_balls
from tracking.video import open_recording

FRAMES, WIDTH, HEIGHT = 72, 200, 280


def wall() -> np.ndarray:
    rough = np.random.default_rng(4).integers(60, 130, (26, 20, 3)).astype(np.uint8)
    return cv2.resize(rough, (WIDTH + 200, HEIGHT + 240), interpolation=cv2.INTER_CUBIC)


def film(path: Path, shift: np.ndarray) -> Path:
    """A white ball that falls and rebounds before a rough wall, seen by a camera that shifts, (frames, 2)."""

    def pictures() -> Iterator[np.ndarray]:
        behind = wall()
        for number, (x, y) in enumerate(shift):
            scene = behind.copy()
            time = abs(number - 40) / 120
            centre = (200 * 16, round((330 - 1000 * time + 1400 * time**2) * 16))
            cv2.circle(scene, centre, 12 * 16, (240, 240, 240), -1, cv2.LINE_AA, 4)
            moved = np.float32([[1, 0, x - 100], [0, 1, y - 100]])
            yield cv2.warpAffine(scene, moved, (WIDTH, HEIGHT))

    write_video(path, pictures(), 120, crf=18, preset="ultrafast")
    return path


def test_slow_drift_is_found_and_undone(tmp_path: Path) -> None:
    time = np.linspace(0, 1, FRAMES)
    drift = np.column_stack((6 * np.sin(3 * time), 9 * time))
    shaken = steadied(open_recording(film(tmp_path / "shaken.mp4", drift)))
    (track,) = track_balls(shaken, radius=12)
    (still,) = track_balls(open_recording(film(tmp_path / "still.mp4", np.zeros((FRAMES, 2)))), radius=12)
    common, one, other = np.intersect1d(track.frame, still.frame, return_indices=True)
    assert len(common) > 40
    offset = track.y[one] - still.y[other]
    assert offset - np.median(offset) == pytest.approx(np.zeros(len(common)), abs=0.5)
    assert shaken.notes[0].startswith("the camera drifts by up to ")


def test_camera_that_stands_still_is_left_alone(tmp_path: Path) -> None:
    recording = open_recording(film(tmp_path / "still.mp4", np.zeros((FRAMES, 2))))
    assert steadied(recording) is recording


def test_camera_that_is_carried_about_is_refused(tmp_path: Path) -> None:
    pan = np.column_stack((np.linspace(-90, 90, FRAMES), np.zeros(FRAMES)))
    with pytest.raises(RecordingError, match=r"pan\.mp4: the camera moves .*; put it on a tripod"):
        steadied(open_recording(film(tmp_path / "pan.mp4", pan)))


def test_bare_wall_tells_of_no_drift(tmp_path: Path) -> None:
    write_video(tmp_path / "bare.mp4", (np.full((96, 96, 3), 90, np.uint8) for _ in range(30)), 120)
    recording = open_recording(tmp_path / "bare.mp4")
    assert steadied(recording) is recording


def test_a_motion_that_makes_pictures_less_alike_is_no_drift() -> None:
    reference = np.ascontiguousarray(wall()[:HEIGHT, :WIDTH, 0])
    shifted = np.ascontiguousarray(wall()[:HEIGHT, 3 : WIDTH + 3, 0])
    motion = np.array([[1.0, 0.0, -3.0], [0.0, 1.0, 0.0]])
    assert explains([motion], [shifted], reference)
    assert not explains([motion], [reference], reference)

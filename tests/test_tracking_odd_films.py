"""Films as people have them: other codecs, interlaced, too small, too slow, mostly empty."""

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import av
import cv2
import numpy as np
import pytest

from tracking.encode import write_video
from tracking.errors import RecordingError
from tracking.track import track_balls
from tracking.video import open_recording

WALL = cv2.resize(
    np.random.default_rng(1).integers(70, 110, (20, 16, 3)).astype(np.uint8),
    (160, 200),
    interpolation=cv2.INTER_CUBIC,
)


def fall(frames: int = 60, radius: float = 10, start: int = 0) -> Iterator[np.ndarray]:
    """A ball that falls in and rebounds out of the picture, 120 frames a second, after `start` frames."""
    for number in range(start + frames):
        picture = WALL.copy()
        time = abs(number - start - frames / 2) / 120
        height = round((170 - 900 * time + 1200 * time**2) * 16)
        if number >= start:
            cv2.circle(picture, (80 * 16, height), round(radius * 16), (240, 240, 240), -1, cv2.LINE_AA, 4)
        yield picture


def encode(path: Path, pictures: Iterator[np.ndarray], codec: str, **options: str) -> Path:
    with av.open(str(path), "w") as container:
        stream = container.add_stream(codec, rate=120, options=options)
        stream.height, stream.width, stream.pix_fmt = 200, 160, "yuv420p"
        for picture in pictures:
            container.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="bgr24")))
        container.mux(stream.encode())
    return path


@pytest.mark.skipif("libsvtav1" not in av.codecs_available, reason="this decoder library makes no AV1")
def test_av1_is_read_like_any_other_film(tmp_path: Path) -> None:
    (track,) = track_balls(open_recording(encode(tmp_path / "av1.mp4", fall(), "libsvtav1", preset="10")))
    assert len(track.frame) > 50
    assert track.radius == pytest.approx(10, abs=1)


def test_interlaced_film_is_read_and_the_remedy_told(tmp_path: Path) -> None:
    def woven() -> Iterator[np.ndarray]:
        fields = list(fall())
        for upper, lower in pairwise(fields):
            upper[1::2] = lower[1::2]
            yield upper

    fields = {"x264-params": "tff=1:interlaced=1", "flags": "+ildct+ilme"}
    recording = open_recording(encode(tmp_path / "woven.mp4", woven(), "libx264", **fields))
    assert recording.notes[0].startswith("it is interlaced: each picture mixes two moments")
    assert "ffmpeg -vf bwdif" in recording.notes[0]


def test_ball_too_small_to_have_an_outline_is_refused(tmp_path: Path) -> None:
    write_video(tmp_path / "tiny.mp4", fall(radius=2), 120)
    with pytest.raises(RecordingError, match=r"tiny\.mp4: .*(px wide, but must be at least 5|no ball found)"):
        track_balls(open_recording(tmp_path / "tiny.mp4"))


def test_ball_too_fast_for_the_rate_is_refused(tmp_path: Path) -> None:
    write_video(tmp_path / "slow.mp4", (p for n, p in enumerate(fall()) if n % 12 == 0), 10)
    with pytest.raises(RecordingError, match=r"slow\.mp4: no ball found .* more frames a second if it is"):
        track_balls(open_recording(tmp_path / "slow.mp4"))


@pytest.mark.slow
def test_ball_that_comes_after_nine_thousand_frames_is_found(tmp_path: Path) -> None:
    empty_too = (picture for part in (fall(start=9000), (WALL for _ in range(940))) for picture in part)
    write_video(tmp_path / "late.mp4", empty_too, 120, preset="ultrafast")
    recording = open_recording(tmp_path / "late.mp4")
    assert len(recording.times) == 10_000
    (track,) = track_balls(recording)
    assert 9000 <= track.frame[0] < 9010
    assert track.frame[-1] < 9060
    assert len(track.frame) > 45

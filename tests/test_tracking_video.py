"""Reading recordings: true times, upright pictures, and a sentence for every file that is none."""

import wave
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

import av
import cv2
import numpy as np
import pytest
from clips import Clip

from tracking.cadence import find_genuine
from tracking.encode import write_video
from tracking.errors import RecordingError
from tracking.stamps import fill_stamps, time_factor
from tracking.video import open_recording, read_frames

Picture = np.ndarray
LUMA_RANGE = 219 / 255  # of a file's brightness over a screen's


def pictures(clip: Clip) -> list[Picture]:
    return [frame.image for frame in read_frames(open_recording(clip.path))]


def remux(source: Path, target: Path, movflags: str, **tags: str) -> Path:
    with av.open(str(source)) as old, av.open(str(target), "w", options={"movflags": movflags}) as new:
        new.metadata.update(tags)
        stream = new.add_stream_from_template(old.streams.video[0])
        for packet in old.demux(video=0):
            if packet.dts is not None:
                packet.stream = stream
                new.mux(packet)
    return target


def phone_film(source: Path, target: Path, rate: str) -> Path:
    return remux(source, target, "use_metadata_tags", **{"com.android.capture.fps": rate})


def test_frames_come_once_each_in_order_with_the_times_of_the_file(plate_clip: Clip) -> None:
    frames = list(read_frames(open_recording(plate_clip.path)))
    assert [frame.index for frame in frames] == list(range(plate_clip.truth["frames"]))
    assert [frame.time for frame in frames] == pytest.approx(np.arange(len(frames)) / 240, abs=1e-4)
    assert {frame.image.shape for frame in frames} == {(*plate_clip.scene.size_px[::-1], 3)}


def test_ordinary_recording_needs_no_notes(plate_clip: Clip) -> None:
    recording = open_recording(plate_clip.path)
    assert recording.notes == ()
    assert recording.genuine.all()
    assert recording.capture_fps == pytest.approx(240, rel=1e-3)


def test_tag_of_a_phone_tells_the_rate_of_capture(plate_clip: Clip, tmp_path: Path) -> None:
    slow = write_video(tmp_path / "slow.mp4", pictures(plate_clip)[:40], 30)
    tagged = phone_film(tmp_path / "slow.mp4", tmp_path / "tagged.mp4", "240.0")
    recording = open_recording(tagged)
    assert recording.times == pytest.approx(np.arange(slow) / 240, abs=1e-4)
    assert recording.notes == ("captured at 240 frames/s (a tag in the file) but stored at 30",)


def test_told_rate_comes_before_the_tag(plate_clip: Clip, tmp_path: Path) -> None:
    tagged = phone_film(plate_clip.path, tmp_path / "tagged.mp4", "960")
    recording = open_recording(tagged, capture_fps=480)
    assert recording.times[-1] == pytest.approx((plate_clip.truth["frames"] - 1) / 480, rel=1e-3)
    assert recording.notes == ("captured at 480 frames/s (--capture-fps) but stored at 240",)


@pytest.mark.parametrize("rate", [0, -240, float("nan"), float("inf"), 1e300])
def test_impossible_rates_are_refused(plate_clip: Clip, rate: float) -> None:
    with pytest.raises(ValueError, match="capture_fps must be positive and at most 1e\\+06, got"):
        open_recording(plate_clip.path, capture_fps=rate)


def test_frames_stored_twice_are_left_out_and_said(plate_clip: Clip, tmp_path: Path) -> None:
    twice = [picture for picture in pictures(plate_clip)[30:80] for _ in range(2)]
    write_video(tmp_path / "twice.mp4", twice, 480)
    recording = open_recording(tmp_path / "twice.mp4")
    assert np.flatnonzero(recording.genuine).tolist() == list(range(0, 100, 2))
    assert recording.notes == ("50 of 100 frames store the picture before them again; they were left out",)
    assert recording.capture_fps == pytest.approx(240, rel=1e-3)
    assert len(list(read_frames(recording))) == 50


def test_rate_of_a_film_stored_twice_is_that_of_its_genuine_frames(plate_clip: Clip, tmp_path: Path) -> None:
    twice = [picture for picture in pictures(plate_clip)[30:80] for _ in range(2)]
    write_video(tmp_path / "twice.mp4", twice, 480)
    told = open_recording(tmp_path / "twice.mp4", capture_fps=240)
    assert told.times == pytest.approx(open_recording(tmp_path / "twice.mp4").times)


def test_pictures_that_never_change_are_no_repeats() -> None:
    genuine, rhythm = find_genuine(np.array([np.inf, *np.zeros(50)]))
    assert genuine.all()
    assert rhythm is None


@pytest.mark.parametrize(("captured", "stored"), [(25, 30), (24, 60), (20, 30), (24, 30)])
def test_even_pictures_behind_an_uneven_cadence_get_even_times(
    plate_clip: Clip, tmp_path: Path, captured: int, stored: int
) -> None:
    genuine = pictures(plate_clip)[30:80]
    shown = [genuine[k * captured // stored] for k in range(50 * stored // captured)]
    write_video(tmp_path / "pulled.mp4", shown, stored)
    recording = open_recording(tmp_path / "pulled.mp4")
    assert recording.genuine.sum() == pytest.approx(50, abs=1)
    steps = np.diff(recording.times[recording.genuine])
    assert steps == pytest.approx(np.full(len(steps), 1 / captured), rel=0.01)
    assert "store the picture before them again" in recording.notes[0]


def test_irregular_repeats_are_left_out_and_the_doubt_told(plate_clip: Clip, tmp_path: Path) -> None:
    rng = np.random.default_rng(7)
    shown = [picture for picture in pictures(plate_clip)[30:80] for _ in range(rng.integers(1, 4))]
    write_video(tmp_path / "screen.mp4", shown, 120)
    recording = open_recording(tmp_path / "screen.mp4")
    assert recording.genuine.sum() == 50
    assert "a picture's time may be wrong by 8.33 ms" in recording.notes[0]


def test_slow_motion_of_a_part_is_refused_for_one_rate_cannot_be_true() -> None:
    times = np.cumsum([1 / 30] * 40 + [1 / 4] * 40 + [1 / 30] * 40)
    with pytest.raises(RecordingError, match=r"ramp\.mp4: captured at 240 .* 33\.3 to 250 ms apart"):
        time_factor(times, 240.0, None, "ramp.mp4")
    assert time_factor(times, None, None, "ramp.mp4") == (1.0, [])


def test_frames_that_a_camera_dropped_are_counted(plate_clip: Clip, tmp_path: Path) -> None:
    with av.open(str(tmp_path / "gaps.mkv"), "w") as container:
        stream = container.add_stream("libx264", rate=240)
        stream.width, stream.height, stream.pix_fmt = *plate_clip.scene.size_px, "yuv420p"
        for k, picture in enumerate(pictures(plate_clip)[:60]):
            frame = av.VideoFrame.from_ndarray(picture, format="bgr24")
            frame.pts, frame.time_base = k, Fraction(1, 240)
            if k not in (20, 40, 41):
                container.mux(stream.encode(frame))
        container.mux(stream.encode())
    assert open_recording(tmp_path / "gaps.mkv").notes == (
        "3 frames are missing between the others; nothing was filled in",
    )


def test_missing_stamps_follow_the_regular_interval_at_both_ends() -> None:
    times, notes = fill_stamps([None, None, 0.2, None, 0.4, 0.5, None], "drop.avi")
    assert times == pytest.approx(np.arange(7) / 10)
    assert notes == ["4 frames had no time stamp; filled in from the regular interval"]


@pytest.mark.parametrize(
    ("stamps", "reason"),
    [([0.0, 0.2, 0.1], "do not rise"), ([0.0, 0.0], "do not rise"), ([None, 0.0], "no time")],
)
def test_stamps_that_tell_no_time_are_refused(stamps: list[float | None], reason: str) -> None:
    with pytest.raises(RecordingError, match=rf"drop\.avi: .*{reason}.*; convert it once"):
        fill_stamps(stamps, "drop.avi")


@pytest.mark.parametrize("count", [12, 29, 31, 400])
def test_background_samples_are_spread_over_files_that_hide_their_length(tmp_path: Path, count: int) -> None:
    write_video(
        tmp_path / "ramp.mkv", (np.full((16, 16, 3), 20 + k // 2, np.uint8) for k in range(count)), 30
    )
    looks = open_recording(tmp_path / "ramp.mkv").looks
    assert len(looks) == 11
    assert np.ptp(list(looks)) == pytest.approx(count - 1, rel=0.05)
    steps = np.diff([float(brightness.mean()) for brightness, _, _ in looks.values()]) / LUMA_RANGE
    assert np.sum(steps) == pytest.approx((count - 1) / 2, abs=0.07 * count + 3)
    assert np.diff(list(looks)).max() < 2 * np.diff(list(looks)).min() + 2


def test_wide_pixels_are_made_square(tmp_path: Path) -> None:
    with av.open(str(tmp_path / "dv.mp4"), "w") as container:
        stream = container.add_stream("libx264", rate=25)
        stream.width, stream.height, stream.pix_fmt = 48, 32, "yuv420p"
        stream.codec_context.sample_aspect_ratio = Fraction(4, 3)
        for _ in range(10):
            grey = np.full((32, 48), 99, np.uint8)
            container.mux(stream.encode(av.VideoFrame.from_ndarray(grey, format="gray")))
        container.mux(stream.encode())
    recording = open_recording(tmp_path / "dv.mp4")
    assert {frame.image.shape for frame in read_frames(recording)} == {(32, 64, 3)}
    assert recording.notes == ("its pixels are not square; pictures were made 1.333 times as wide",)


def test_film_that_breaks_off_keeps_what_can_be_read_and_says_so(plate_clip: Clip, tmp_path: Path) -> None:
    whole = remux(plate_clip.path, tmp_path / "whole.mp4", "faststart")
    data = whole.read_bytes()
    (tmp_path / "cut.mp4").write_bytes(data[: int(0.7 * len(data))])
    recording = open_recording(tmp_path / "cut.mp4")
    count = len(list(read_frames(recording)))
    assert 30 < count < plate_clip.truth["frames"]
    assert recording.notes[0].startswith(
        f"the file is damaged or cut short: {count} of 105 frames could be read"
    )


def test_colon_in_a_name_is_no_address(
    plate_clip: Clip, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "10:32.mp4").write_bytes(plate_clip.path.read_bytes())
    monkeypatch.chdir(tmp_path)
    assert len(open_recording("10:32.mp4").times) == plate_clip.truth["frames"]


def cut(folder: Path, clip: Clip) -> None:
    data = clip.path.read_bytes()
    (folder / "bad.mp4").write_bytes(data[: len(data) // 2])


def no_frames(folder: Path, _: Clip) -> None:
    with av.open(str(folder / "bad.mp4"), "w") as container:
        stream = container.add_stream("libx264", rate=25)
        stream.width, stream.height, stream.pix_fmt = 48, 32, "yuv420p"
        container.start_encoding()


def still(folder: Path, clip: Clip) -> None:
    cv2.imwrite(str(folder / "bad.png"), pictures(clip)[0])
    (folder / "bad.png").rename(folder / "bad.mp4")


def sound(folder: Path, _: Clip) -> None:
    with wave.open(str(folder / "bad.mp4"), "wb") as file:
        file.setparams((1, 2, 8000, 0, "NONE", ""))
        file.writeframes(bytes(8000))


def two_sizes(folder: Path, clip: Clip) -> None:
    for name, size in (("a.ts", 64), ("b.ts", 96)):
        write_video(folder / name, (np.full((size, size, 3), k, np.uint8) for k in range(30)), 30)
    (folder / "bad.mp4").write_bytes((folder / "a.ts").read_bytes() + (folder / "b.ts").read_bytes())


@pytest.mark.parametrize(
    ("make", "reason"),
    [
        (lambda folder, _: None, "no such file; check the spelling and the folder"),
        (lambda folder, _: (folder / "bad.mp4").mkdir(), "is a folder; name the video in it"),
        (lambda folder, _: (folder / "bad.mp4").touch(), "the file is empty; copy it again"),
        (lambda folder, _: (folder / "bad.mp4").write_bytes(bytes(5000)), "it is not a video, or it is cut"),
        (lambda folder, _: (folder / "bad.mp4").write_text("time,height\n" * 99), "not a video"),
        (cut, "it is not a video, or it is cut short; copy it again"),
        (still, "is a still picture, not a video; give the video"),
        (sound, "has no picture, only sound or data; give the video"),
        (
            lambda folder, clip: write_video(folder / "bad.mp4", pictures(clip)[:1], 30),
            r"1 frame\(s\) could be",
        ),
        (no_frames, "has no picture, only sound or data"),
        (two_sizes, "its picture changes size midway; convert"),
    ],
)
def test_what_is_no_recording_gets_a_sentence(
    make: Callable[[Path, Clip], object], reason: str, plate_clip: Clip, tmp_path: Path
) -> None:
    make(tmp_path, plate_clip)
    with pytest.raises(RecordingError, match=reason) as refusal:
        open_recording(tmp_path / "bad.mp4")
    assert "bad.mp4: " in str(refusal.value)


def test_text_is_no_video_though_decoders_draw_it(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("dropped from 30 cm\n" * 50)
    with pytest.raises(RecordingError, match=r"notes\.txt: is a text, not a video"):
        open_recording(tmp_path / "notes.txt")


def test_pictures_turned_by_a_tag_come_upright(shared_data: Path) -> None:
    recording = open_recording(shared_data / "real" / "pingpong-table-doubled-frames.mov")
    assert recording.size == (864, 1034)
    assert recording.quarter_turns == 1
    assert recording.notes == ("94 of 188 frames store the picture before them again; they were left out",)


def test_slow_motion_of_a_phone_is_in_the_time_of_capture(shared_data: Path) -> None:
    recording = open_recording(shared_data / "real" / "redball-120fps-tagged-30.mp4")
    assert recording.capture_fps == pytest.approx(120, rel=1e-3)
    assert recording.notes == ("captured at 120 frames/s (a tag in the file) but stored at 30",)
    assert recording.quarter_turns == 3

"""The only file that decodes: frames with true time stamps, upright, in the time of capture.

A file's own rate is often not the rate of capture (slow motion is stored as 30 frames a second), and
screen recorders store frames twice. `open_recording` reads the file once, resolves both and says what it
did in `Recording.notes`; `read_frames` then yields the genuine frames, one at a time.
"""

import os
from collections.abc import Collection, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

import av
import av.error
import numpy as np
import numpy.typing as npt

from tracking import stamps
from tracking.errors import RecordingError
from tracking.recording import Frame, Image, Recording, held_still

__all__ = ["Frame", "Recording", "open_recording", "read_frames"]

FloatArray = npt.NDArray[np.float64]

BACKGROUND_SAMPLES = 15  # at least, and at most twice as many: they are all kept in memory
WHOLE = 0.98  # a file with this share of the frames it announces is not cut short


def open_recording(path: Path | str, *, capture_fps: float | None = None) -> Recording:
    """Read a recording once: time stamps, capture rate, repeated frames, background samples.

    Parameters
    ----------
    path : path of the video file
    capture_fps : float, optional
        Frames captured a second, if the file does not tell; it overrides a tag in the file.

    Raises
    ------
    RecordingError
        If the file is missing, is no video, is empty or cannot be decoded.
    ValueError
        If `capture_fps` is not positive, or faster than any camera.

    Examples
    --------
    >>> open_recording("drop-01.mp4")
    Traceback (most recent call last):
    tracking.errors.RecordingError: drop-01.mp4: no such file; check the spelling and the folder
    """
    path = Path(path)
    if capture_fps is not None and not 0 < capture_fps <= stamps.FASTEST_CAMERA:
        raise ValueError(
            f"capture_fps must be positive and at most {stamps.FASTEST_CAMERA:g}, got {capture_fps:g}"
        )
    if os.path.isdir(path):
        raise RecordingError(f"{path}: is a folder; name the video in it")
    if not os.path.isfile(path):
        raise RecordingError(f"{path}: no such file; check the spelling and the folder")
    scan = _scan(path)
    if len(scan.stamps) < 2:
        raise RecordingError(
            f"{path.name}: {len(scan.stamps)} frame(s) could be read, but a motion needs many; record the "
            "whole drop, or copy the file again from the camera"
        )
    times, stamp_notes = stamps.fill_stamps(scan.stamps, path.name)
    genuine, repeat_notes = stamps.find_genuine(np.asarray(scan.changes))
    factor, rate_notes = stamps.time_factor(times[genuine], scan.tagged_fps, capture_fps)
    return Recording(
        path=path,
        times=times * factor,
        genuine=genuine,
        samples=scan.samples,
        capture_fps=float(1 / np.median(np.diff(times[genuine] * factor))),
        rate_sd=stamps.NOMINAL_RATE_SD if rate_notes else stamps.CLOCK_SD,
        quarter_turns=scan.quarter_turns,
        notes=(*scan.notes, *stamp_notes, *rate_notes, *repeat_notes),
    )


def read_frames(recording: Recording, wanted: Collection[int] | None = None) -> Iterator[Frame]:
    """Yield the genuine frames of a recording in order; stored-twice frames are left out.

    If only some are `wanted`, by their numbers in the file, the others are not even made pictures.
    """
    with _container(recording.path) as container, suppress(av.error.FFmpegError):
        stretch = _stretch(container)
        pictures = container.decode(container.streams.video[0])
        for index, (time, picture) in enumerate(zip(recording.times, pictures, strict=False)):
            if recording.genuine[index] and (wanted is None or index in wanted):
                image = _upright(picture, stretch)
                if recording.drift is not None:
                    image = held_still(image, recording.drift[index])
                yield Frame(index=index, time=float(time), image=image)


@dataclass(slots=True, kw_only=True)
class _Scan:
    """What one pass over the file collects."""

    stretch: float
    tagged_fps: float | None
    stamps: list[float | None] = field(default_factory=list)
    changes: list[float] = field(default_factory=list)
    samples: list[Image] = field(default_factory=list)
    sizes: set[tuple[int, int]] = field(default_factory=set)
    spacing: int = 1
    quarter_turns: int = 0
    interlaced: int = 0
    notes: list[str] = field(default_factory=list)


def _scan(path: Path) -> _Scan:
    """Decode every frame once and keep only what is small."""
    with _container(path) as container:
        stream = container.streams.video[0]
        tags = {**container.metadata, **stream.metadata}
        scan = _Scan(stretch=_stretch(container), tagged_fps=stamps.tagged_fps(tags))
        damaged = False
        try:
            _collect(scan, container.decode(stream), path.name)
        except av.error.FFmpegError:
            damaged = True
        expected = stream.frames
    count = len(scan.stamps)
    if damaged or count < WHOLE * expected:
        of = f" of {expected}" if expected else ""
        scan.notes.append(
            f"the file is damaged or cut short: {count}{of} frames could be read; "
            "copy it again from the camera if the impact is missing"
        )
    if scan.interlaced > count / 2:
        scan.notes.append(
            "it is interlaced: each picture mixes two moments and a moving rim is combed; make each field a "
            "picture with a video tool (ffmpeg -vf bwdif) for sharper results"
        )
    if scan.stretch != 1:
        scan.notes.append(f"its pixels are not square; pictures were made {scan.stretch:.4g} times as wide")
    return scan


def _collect(scan: _Scan, pictures: Iterator[av.VideoFrame], name: str) -> None:
    """Note each picture's time and change; keep some, evenly spread however many there will be."""
    before: FloatArray | None = None
    for index, picture in enumerate(pictures):
        scan.sizes.add((picture.width, picture.height))
        if len(scan.sizes) > 1:
            raise RecordingError(
                f"{name}: its picture changes size midway; convert it once with a video tool"
            )
        scan.quarter_turns = _quarter_turns(picture)
        scan.interlaced += picture.interlaced_frame
        after = stamps.thumbnail(_brightness(picture))
        scan.stamps.append(picture.time)
        scan.changes.append(np.inf if before is None else stamps.change(before, after))
        before = after
        if index % scan.spacing == 0:
            if len(scan.samples) == 2 * BACKGROUND_SAMPLES:
                scan.samples = scan.samples[::2]
                scan.spacing *= 2
            scan.samples.append(_upright(picture, scan.stretch))


def _container(path: Path) -> av.container.InputContainer:
    """Open a file whose first video stream can be decoded, or say why not."""
    again = "copy it again from the camera"
    try:  # the whole path: a name like "10:32.mp4" would pass for an address
        whole = os.path.abspath(path)
        container = av.open(whole, options={"protocol_whitelist": "file"}, metadata_errors="replace")
    except PermissionError as error:
        raise RecordingError(f"{path.name}: may not be read; change its permissions") from error
    except (av.error.FFmpegError, OSError) as error:
        empty = os.path.isfile(path) and os.path.getsize(path) == 0
        reason = "the file is empty" if empty else "it is not a video, or it is cut short"
        raise RecordingError(f"{path.name}: {reason}; {again}") from error
    reason = _no_video(container)
    if reason:
        container.close()
        raise RecordingError(f"{path.name}: {reason}; give the video file itself")
    container.streams.video[0].thread_type = "AUTO"
    return container


def _no_video(container: av.container.InputContainer) -> str:
    """Why a file that can be opened is no recording all the same; empty if it is one."""
    kind = container.format.name
    if kind == "tty":  # decoders draw text files
        return "is a text, not a video"
    if kind.startswith("image2") or kind.endswith("_pipe"):
        return "is a still picture, not a video"
    if not container.streams.video:
        return "has no picture, only sound or data"
    return ""


def _stretch(container: av.container.InputContainer) -> float:
    """Width over height of one pixel."""
    return float(container.streams.video[0].sample_aspect_ratio or 1)


def _upright(picture: av.VideoFrame, stretch: float) -> Image:
    """Give the picture as a person sees it: square pixels, the file's rotation tag applied."""
    image = picture.to_ndarray(format="bgr24", width=round(picture.width * stretch), height=picture.height)
    return np.ascontiguousarray(np.rot90(image, _quarter_turns(picture)), dtype=np.uint8)


def _quarter_turns(picture: av.VideoFrame) -> int:
    """Counter-clockwise turns by 90° that a file asks for, 0 to 3."""
    return round(picture.rotation / 90) % 4


def _brightness(picture: av.VideoFrame) -> Image:
    """Take the brightness of a picture, straight from the decoder's own plane where there is one."""
    direct = picture.format.name.startswith(("yuv4", "yuvj4", "nv12"))
    if not direct or picture.format.components[0].bits != 8:
        return np.asarray(picture.to_ndarray(format="gray"), dtype=np.uint8)
    plane = picture.planes[0]
    lines = np.frombuffer(memoryview(plane), dtype=np.uint8).reshape(-1, plane.line_size)
    return lines[: picture.height, : picture.width]


def decode_only(path: Path | str) -> int:
    """Decode every frame, do nothing with it, and count: no reading of the file can be faster."""
    with _container(Path(path)) as container:
        container.streams.video[0].thread_type = "AUTO"
        return sum(1 for _ in container.decode(video=0))

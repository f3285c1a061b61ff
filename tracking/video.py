"""The only file that decodes: frames with true time stamps, upright, in the time of capture.

A file's own rate is often not the rate of capture (slow motion is stored as 30 frames a second), and
screen recorders store frames twice. `open_recording` reads the file once, resolves both and says what it
did in `Recording.notes`; `read_frames` then yields the genuine frames, one at a time.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import av
import av.error
import numpy as np
import numpy.typing as npt

from tracking.errors import RecordingError

FloatArray = npt.NDArray[np.float64]
Image = npt.NDArray[np.uint8]

CAPTURE_RATE_TAGS = ("com.android.capture.fps", "com.apple.quicktime.capture-fps", "capture_fps")
RATE_TOLERANCE = 0.02  # a tag this close to the file's own rate says nothing new
REPEAT_LEVEL = 2.0  # grey levels: two encodings of one picture differ by less
REPEAT_SHARE = 0.2  # ... and by less than this share of what a genuine neighbour differs by
BACKGROUND_SAMPLES = 25


@dataclass(frozen=True, slots=True, kw_only=True)
class Frame:
    """One picture: its number in the file, its time of capture, s, and its (height, width, 3) BGR levels."""

    index: int
    time: float
    image: Image


@dataclass(frozen=True, slots=True, kw_only=True)
class Recording:
    """What one reading of a file told about it.

    Attributes
    ----------
    path : Path
    times : (n,) array
        Time of capture of every stored frame, s, first frame at its own stamp.
    genuine : (n,) array of bool
        False where a frame stores its predecessor's picture again.
    samples : list of (height, width, 3) arrays
        About 25 pictures spread over the recording, from which the background is made.
    capture_fps : float
        Pictures captured a second.
    notes : tuple of str
        What was found out or assumed, for the person who made the recording.
    """

    path: Path
    times: FloatArray
    genuine: npt.NDArray[np.bool_]
    samples: list[Image]
    capture_fps: float
    notes: tuple[str, ...] = ()

    @property
    def bytes(self) -> int:
        """Memory that all genuine frames take together."""
        return int(self.genuine.sum()) * self.samples[0].nbytes

    @property
    def frame_interval(self) -> float:
        """Median time between genuine frames, s."""
        return float(np.median(np.diff(self.times[self.genuine])))


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
    """
    path = Path(path)
    if capture_fps is not None and not (np.isfinite(capture_fps) and capture_fps > 0):
        raise ValueError(f"capture_fps must be positive, got {capture_fps:g}")
    if not path.is_file():
        raise RecordingError(f"{path}: no such file; check the spelling and the folder")
    scan = _scan(path)
    if len(scan.stamps) < 2:
        raise RecordingError(
            f"{path.name}: holds {len(scan.stamps)} frame(s), but a motion needs many; record the whole drop"
        )
    stamps, stamp_notes = _rising(scan.stamps, path)
    factor, rate_notes = _time_factor(stamps, scan.tagged_fps, capture_fps)
    genuine, repeat_notes = _genuine(np.asarray(scan.changes))
    return Recording(
        path=path,
        times=stamps * factor,
        genuine=genuine,
        samples=scan.samples,
        capture_fps=float(1 / np.median(np.diff(stamps[genuine] * factor))),
        notes=(*scan.notes, *stamp_notes, *rate_notes, *repeat_notes),
    )


def read_frames(recording: Recording) -> Iterator[Frame]:
    """Yield the genuine frames of a recording in order; stored-twice frames are left out."""
    with _container(recording.path) as container:
        for index, picture in enumerate(_pictures(container)):
            if index >= len(recording.times):
                return
            if recording.genuine[index]:
                yield Frame(index=index, time=float(recording.times[index]), image=_upright(picture))


@dataclass(slots=True, kw_only=True)
class _Scan:
    """What one pass over the file collects."""

    stamps: list[float | None]
    changes: list[float]
    samples: list[Image]
    tagged_fps: float | None
    notes: list[str]


def _scan(path: Path) -> _Scan:
    """Decode every frame once and keep only what is small."""
    with _container(path) as container:
        stream = container.streams.video[0]
        expected = stream.frames
        spacing = max(1, expected // BACKGROUND_SAMPLES)
        scan = _Scan(stamps=[], changes=[], samples=[], tagged_fps=_tagged_fps(container), notes=[])
        previous: FloatArray | None = None
        for index, picture in enumerate(_pictures(container)):
            scan.stamps.append(None if picture.pts is None else float(picture.pts * stream.time_base))
            thumbnail = _thumbnail(picture)
            scan.changes.append(np.inf if previous is None else _change(previous, thumbnail))
            previous = thumbnail
            if index % spacing == 0 and len(scan.samples) < 2 * BACKGROUND_SAMPLES:
                scan.samples.append(_upright(picture))
    if expected and len(scan.stamps) < 0.98 * expected:
        scan.notes.append(
            f"the file ends early: {len(scan.stamps)} of {expected} frames could be read; "
            "copy it again from the camera if the impact is missing"
        )
    return scan


def _container(path: Path) -> av.container.InputContainer:
    """Open a file whose first video stream can be decoded, or say why not."""
    try:
        container = av.open(str(path), options={"protocol_whitelist": "file"})
    except (av.error.FFmpegError, OSError) as error:
        size = path.stat().st_size if path.is_file() else 0
        reason = "the file is empty" if size == 0 else "it is not a video, or it is cut short"
        raise RecordingError(f"{path.name}: {reason}; copy it again from the camera") from error
    if not container.streams.video:
        container.close()
        raise RecordingError(f"{path.name}: has no picture, only sound or data; give the video file itself")
    container.streams.video[0].thread_type = "AUTO"
    return container


def _pictures(container: av.container.InputContainer) -> Iterator[av.VideoFrame]:
    """Decode until the end, or until the file turns out to be damaged."""
    try:
        yield from container.decode(container.streams.video[0])
    except av.error.FFmpegError:
        return  # what came before the damage is kept; _scan compares the count with the file's own


def _upright(picture: av.VideoFrame) -> Image:
    """Give the picture as a person sees it: the file's rotation tag applied."""
    image = picture.to_ndarray(format="bgr24")
    return np.ascontiguousarray(np.rot90(image, (picture.rotation // 90) % 4))


def _thumbnail(picture: av.VideoFrame) -> FloatArray:
    """Average the brightness over blocks of 8 x 8 pixels."""
    grey = _brightness(picture)
    height, width = (size // 8 * 8 for size in grey.shape)
    rows = np.add.reduceat(grey[:height, :width], np.arange(0, height, 8), axis=0, dtype=np.uint32)
    return np.asarray(np.add.reduceat(rows, np.arange(0, width, 8), axis=1) / 64.0)


def _brightness(picture: av.VideoFrame) -> Image:
    """Take the brightness of a picture, straight from the decoder's own plane where there is one."""
    if (
        not picture.format.name.startswith(("yuv4", "yuvj4", "nv12"))
        or picture.format.components[0].bits != 8
    ):
        return picture.to_ndarray(format="gray")
    plane = picture.planes[0]
    lines = np.frombuffer(plane, dtype=np.uint8).reshape(-1, plane.line_size)
    return lines[: picture.height, : picture.width]


def _change(before: FloatArray, after: FloatArray) -> float:
    """Measure how much the most changed blocks differ, grey levels."""
    if before.shape != after.shape or before.size == 0:
        return np.inf
    difference = np.abs(after - before).ravel()
    rank = min(8, difference.size)
    return float(np.partition(difference, -rank)[-rank])


def _tagged_fps(container: av.container.InputContainer) -> float | None:
    """Read the capture rate that phones write beside slow motion."""
    tags = {**container.metadata, **container.streams.video[0].metadata}
    for name in CAPTURE_RATE_TAGS:
        try:
            rate = float(tags[name])
        except (KeyError, ValueError):
            continue
        if np.isfinite(rate) and rate > 0:
            return rate
    return None


def _rising(stamps: list[float | None], path: Path) -> tuple[FloatArray, list[str]]:
    """Fill missing stamps from the regular interval; refuse stamps that do not rise."""
    times = np.array([np.nan if stamp is None else stamp for stamp in stamps])
    known = np.isfinite(times)
    if known.sum() < 2:
        raise RecordingError(f"{path.name}: carries no time stamps; convert it once with a video tool")
    index = np.arange(len(times))
    steps = np.diff(times[known]) / np.diff(index[known])
    if np.any(steps <= 0):
        raise RecordingError(f"{path.name}: its time stamps do not rise; convert it once with a video tool")
    notes = []
    if not known.all():
        last = index[known][-1]
        times = np.interp(index, index[known], times[known])
        times[last:] = times[last] + np.median(steps) * (index[last:] - last)
        notes.append(f"{int((~known).sum())} frames had no time stamp; filled in from the regular interval")
    return times, notes


def _time_factor(stamps: FloatArray, tagged: float | None, given: float | None) -> tuple[float, list[str]]:
    """Seconds of capture per second of the file, and what to say about it."""
    file_fps = float(1 / np.median(np.diff(stamps)))
    fps = given if given is not None else tagged
    if fps is None or abs(fps / file_fps - 1) < RATE_TOLERANCE:
        return 1.0, []
    source = "--capture-fps" if given is not None else "a tag in the file"
    return file_fps / fps, [f"captured at {fps:g} frames/s ({source}) but stored at {file_fps:.4g}"]


def _genuine(changes: FloatArray) -> tuple[npt.NDArray[np.bool_], list[str]]:
    """Tell pictures from repeats: a repeat changes nothing while its neighbours change a lot."""
    padded = np.pad(np.where(np.isfinite(changes), changes, 0.0), 3)
    around = np.lib.stride_tricks.sliding_window_view(padded, 7).max(axis=1)
    repeats = (changes < REPEAT_LEVEL) & (changes < REPEAT_SHARE * around) & (around > 4 * REPEAT_LEVEL)
    count = int(repeats.sum())
    if count < max(3, 0.1 * len(changes)):  # at the top of a bounce two pictures may look alike by chance
        return np.ones(len(changes), dtype=bool), []
    return ~repeats, [
        f"{count} of {len(changes)} frames store the picture before them again; they were left out"
    ]

"""The only file that decodes: a video file → its pictures, as they come, and what it says about itself."""

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import av
import av.error
import numpy as np
from av.video.plane import VideoPlane

from tracking.errors import RecordingError
from tracking.planes import Image, Planes

PLANAR = ("yuv420p", "yuvj420p", "yuv422p", "yuvj422p", "yuv444p", "yuvj444p")
OTHERWISE = "yuv444p"
MOST_THREADS = 4  # each of them holds several pictures in memory
ARCHIVES = (
    b"PK\x03\x04",
    b"\x1f\x8b",
    b"BZh",
    b"\xfd7zXZ",
    b"7z\xbc\xaf\x27\x1c",
    b"Rar!",
    b"\x28\xb5\x2f\xfd",
)
LISTS = (b"#EXTM3U", b"ffconcat", b"<?xml", b"<MPD", b"[playlist]", b"v=0")
"""How playlists and descriptions of streams begin."""


@dataclass(frozen=True, slots=True)
class Picture:
    """One picture as the decoder gives it; `stretch` is the width over the height of its pixels."""

    raw: av.VideoFrame
    stretch: float

    @property
    def time(self) -> float | None:
        """Its time stamp, s."""
        return self.raw.time

    @property
    def stored_size(self) -> tuple[int, int]:
        """Width and height before it is turned upright."""
        return self.raw.width, self.raw.height

    @property
    def interlaced(self) -> bool:
        """Whether it mixes two moments."""
        return bool(self.raw.interlaced_frame)

    @property
    def quarter_turns(self) -> int:
        """Counter-clockwise turns by 90° that the file asks for, 0 to 3."""
        return round(self.raw.rotation / 90) % 4

    def upright(self) -> Image:
        """Give (height, width, 3) BGR levels as a person sees them: pixels square, its turn applied."""
        width = round(self.raw.width * self.stretch)
        image = self.raw.to_ndarray(format="bgr24", width=width, height=self.raw.height)
        return np.ascontiguousarray(np.rot90(image, self.quarter_turns), dtype=np.uint8)

    def planes(self) -> Planes:
        """Give the same as planes: views into the decoder's memory where its format allows that."""
        raw = self.raw
        planar = raw.format.name in PLANAR
        if self.stretch != 1 or not planar:
            width = round(raw.width * self.stretch)
            raw = raw.reformat(width=width, format=raw.format.name if planar else OTHERWISE)
        turns = self.quarter_turns
        brightness, blue, red = (_array(plane) for plane in raw.planes)
        if turns:
            brightness, blue, red = (np.rot90(plane, turns) for plane in (brightness, blue, red))
        return brightness, blue, red


@dataclass(slots=True)
class Film:
    """An opened file. `tags` are its own words about itself; `damaged` is known once its end was read."""

    container: av.container.InputContainer
    tags: Mapping[str, str]
    stretch: float
    damaged: bool = False

    @property
    def announced(self) -> int:
        """How many pictures the file says it holds; 0 if it does not say."""
        return self.container.streams.video[0].frames

    def pictures(self) -> Iterator[Picture]:
        """Decode one picture after the other; a file that breaks off ends early."""
        try:
            for raw in self.container.decode(video=0):
                yield Picture(raw, self.stretch)
        except av.error.FFmpegError:
            self.damaged = True


@contextmanager
def opened(path: Path) -> Iterator[Film]:
    """Open a file whose first video stream can be decoded.

    Raises
    ------
    RecordingError
        If there is none.
    """
    with _container(path) as container:
        stream = container.streams.video[0]
        stream.thread_type = "AUTO"
        stream.thread_count = min((os.cpu_count() or 1) + 1, MOST_THREADS)
        tags = {**container.metadata, **stream.metadata}
        yield Film(container, tags, float(stream.sample_aspect_ratio or 1))


def decode_only(path: Path | str) -> int:
    """Decode every picture, do nothing with it, and count: no reading of the file can be faster."""
    with opened(Path(path)) as film:
        return sum(1 for _ in film.container.decode(video=0))


def _container(path: Path) -> av.container.InputContainer:
    """Open a file, or say why it is no recording."""
    again = "copy it again from the camera"
    _refuse_containers_of_files(path)
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
    return container


def _refuse_containers_of_files(path: Path) -> None:
    """Refuse what holds or names other files, before a decoder follows it to any of them."""
    try:
        with path.open("rb") as file:
            start = file.read(64).lstrip(b"\xef\xbb\xbf \t\r\n")
    except OSError:
        return  # the decoder library says why
    if start.startswith(ARCHIVES):
        raise RecordingError(f"{path.name}: is an archive, not a video; unpack it and give the videos in it")
    if start.startswith(LISTS):
        raise RecordingError(
            f"{path.name}: is a list of other files, not a video; give the video file itself"
        )


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


def _array(plane: VideoPlane) -> Image:
    """View one plane as an array."""
    return np.ndarray((plane.height, plane.width), np.uint8, memoryview(plane), 0, (plane.line_size, 1))

"""A file → frames with true time stamps, upright, in the time of capture.

A file's own rate is often not the rate of capture (slow motion is stored as 30 frames a second), and
screen recorders store frames twice. `open_recording` reads the file once, resolves both and says what it
did in `Recording.notes`; `read_frames` then yields the genuine frames, one at a time.
"""

import os
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from tracking import stamps
from tracking.cadence import even_times, find_genuine
from tracking.decode import Picture, opened
from tracking.errors import RecordingError
from tracking.keeper import Keeper
from tracking.kept import SAMPLES
from tracking.planes import Planes
from tracking.recording import Frame, Recording, View, held_still, moved_back

__all__ = ["Frame", "Recording", "open_recording", "read_frames", "revisit"]

FloatArray = npt.NDArray[np.float64]

MOST_HELD = 16  # pictures of which those that tell the background are chosen; more would take memory

WHOLE = 0.98  # a file with this share of the frames it announces is not cut short


def open_recording(path: Path | str, *, capture_fps: float | None = None) -> Recording:
    """Read a recording once: time stamps, capture rate, repeated frames, and what changes in its pictures.

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
    genuine, rhythm = find_genuine(np.asarray(scan.keeper.changes))
    times, repeat_notes = even_times(times, genuine, rhythm)
    factor, rate_notes = stamps.time_factor(times[genuine], scan.tagged_fps, capture_fps, path.name)
    if not repeat_notes:
        repeat_notes = stamps.missing_frames(times)
    return Recording(
        path=path,
        times=times * factor,
        genuine=genuine,
        size=scan.size,
        capture_fps=float(1 / np.median(np.diff(times[genuine] * factor))),
        rate_sd=stamps.NOMINAL_RATE_SD if rate_notes else stamps.CLOCK_SD,
        quarter_turns=scan.quarter_turns,
        notes=(*scan.notes, *stamp_notes, *rate_notes, *repeat_notes),
        looks=scan.spread.few(),
        pictures=tuple(scan.keeper.pictures),
        kept=tuple(scan.keeper.frames),
    )


def read_frames(recording: Recording, wanted: Collection[int] | None = None) -> Iterator[Frame]:
    """Yield the genuine frames of a recording in order; stored-twice frames are left out.

    If only some are `wanted`, by their numbers in the file, the others are not even made pictures.
    """
    for index, time, picture in _decoded(recording, wanted):
        image = picture.upright()
        if recording.drift is not None:
            image = moved_back(image, recording.drift[index])
        yield Frame(index=index, time=time, image=image)


def revisit(recording: Recording, wanted: Collection[int] | None = None) -> Iterator[View]:
    """Yield the genuine frames, or some, for measuring: from memory where they are kept.

    Each view holds until the next is taken.
    """
    seen = _remembered(recording, wanted) if recording.kept else _seen_again(recording, wanted)
    for view in seen:
        yield view if recording.drift is None else _steady(view, recording.drift)


def _decoded(recording: Recording, wanted: Collection[int] | None) -> Iterator[tuple[int, float, Picture]]:
    """Yield number, time and picture of the genuine frames in the file, up to the last that is wanted."""
    count = len(recording.times) if wanted is None else max(wanted, default=-1) + 1
    with opened(recording.path) as film:
        frames = zip(recording.times[:count], film.pictures(), strict=False)
        for index, (time, picture) in enumerate(frames):
            if recording.genuine[index] and (wanted is None or index in wanted):
                yield index, float(time), picture


def _seen_again(recording: Recording, wanted: Collection[int] | None) -> Iterator[View]:
    """Yield views from the file."""
    for index, time, picture in _decoded(recording, wanted):
        yield View(index=index, time=time, picture=picture.planes())


def _remembered(recording: Recording, wanted: Collection[int] | None) -> Iterator[View]:
    """Yield views from memory."""
    genuine = np.flatnonzero(recording.genuine).tolist()
    numbers = genuine if wanted is None else [number for number in genuine if number in wanted]
    one = len(recording.pictures) == 1
    for number in numbers:
        kept = recording.kept[number]
        yield View(
            index=number,
            time=float(recording.times[number]),
            picture=recording.pictures[kept.picture],
            kept=kept,
            changed=kept.parts if one else None,
        )


def _steady(view: View, drift: FloatArray) -> View:
    """Undo the motion of a camera that drifts."""
    return replace(view, picture=held_still(view.planes, drift[view.index]), kept=None, changed=None)


@dataclass(slots=True)
class _Spread:
    """Some pictures as the decoder gave them, by number, evenly spread however many there will be."""

    pictures: dict[int, Picture] = field(default_factory=dict)
    spacing: int = 1

    def add(self, index: int, picture: Picture) -> None:
        """Keep a picture if it is its turn."""
        if index % self.spacing == 0:
            if len(self.pictures) == MOST_HELD:
                self.spacing *= 2
                self.pictures = {k: kept for k, kept in self.pictures.items() if k % self.spacing == 0}
            if index % self.spacing == 0:
                self.pictures[index] = picture

    def few(self) -> dict[int, Planes]:
        """Give at most `SAMPLES` of them."""
        numbers = list(self.pictures)
        chosen = np.linspace(0, len(numbers) - 1, min(SAMPLES, len(numbers))).astype(int)
        return {numbers[k]: self.pictures[numbers[k]].planes() for k in chosen}


@dataclass(slots=True, kw_only=True)
class _Scan:
    """What one pass over the file collects."""

    stamps: list[float | None] = field(default_factory=list)
    keeper: Keeper = field(default_factory=Keeper)
    spread: _Spread = field(default_factory=_Spread)
    stored_size: tuple[int, int] = (0, 0)
    size: tuple[int, int] = (0, 0)
    quarter_turns: int = 0
    interlaced: int = 0
    tagged_fps: float | None = None
    notes: list[str] = field(default_factory=list)


def _scan(path: Path) -> _Scan:
    """Decode every frame once and keep only what is small."""
    scan = _Scan()
    with opened(path) as film:
        scan.tagged_fps = stamps.tagged_fps(film.tags)
        for index, picture in enumerate(film.pictures()):
            _look(scan, index, picture, path.name)
        count, announced = len(scan.stamps), film.announced
        if film.damaged or count < WHOLE * announced:
            of = f" of {announced}" if announced else ""
            scan.notes.append(
                f"the file is damaged or cut short: {count}{of} frames could be read; "
                "copy it again from the camera if the impact is missing"
            )
        if scan.interlaced > count / 2:
            scan.notes.append(
                "it is interlaced: each picture mixes two moments and a moving rim is combed; make each "
                "field a picture with a video tool (ffmpeg -vf bwdif) for sharper results"
            )
        if film.stretch != 1:
            scan.notes.append(
                f"its pixels are not square; pictures were made {film.stretch:.4g} times as wide"
            )
    return scan


def _look(scan: _Scan, index: int, picture: Picture, name: str) -> None:
    """Note a picture's time and what changes in it."""
    if index and picture.stored_size != scan.stored_size:
        raise RecordingError(f"{name}: its picture changes size midway; convert it once with a video tool")
    seen = picture.planes()
    scan.stored_size = picture.stored_size
    scan.size = (seen[0].shape[0], seen[0].shape[1])
    scan.quarter_turns = picture.quarter_turns
    scan.interlaced += picture.interlaced
    scan.stamps.append(picture.time)
    scan.keeper.look(seen)
    scan.spread.add(index, picture)

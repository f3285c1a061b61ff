"""What is kept of a recording in memory: a picture, and of the others only the places that differ from it.

A recording is decoded once. Most of each picture shows what the picture before showed, so what a ball, a
hand or a shadow changed is kept and laid over the first picture again whenever the frame is looked at. When
that becomes much, frames are compared with what most of them show instead, where the hand and the ball of the
first picture are gone.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from tracking.boxes import boxes
from tracking.coarse import (
    COARSE,
    brightened,
    coarsely,
    gain_between,
    largest_change,
    mark_changes,
    noise_between,
)
from tracking.median import median_of
from tracking.planes import Image, Planes, Window, copied, cut, everywhere

MOST_BYTES = 100_000_000  # all of the program then takes less than 500 MB, up to 1080p
MUCH_BYTES = 30_000_000  # from here on frames are compared with what most of them show
LEAST_CHANGE = 5.0  # grey levels: compression changes as much where nothing moves
NOISE_FACTOR = 5.0  # a change this many times the noise, the least between two frames so far, is one
NOISIEST = 3.0  # levels: averaged, no camera is worse; a lamp that comes on is no noise
LINGERING = 16  # frames for which a place that changed is kept: a ball may pass where the picture shows one
BRIEFLY = 4  # ... once the picture shows what most frames do:
BESIDE = 7  # coarse pixels kept around a change: a rim is searched beyond the ball;
CLOSELY = 4  # ... once the picture shows what is beyond it
NEW_PICTURE_SHARE = 0.6  # a frame that changed more than this becomes the picture that others differ from,
# unless one has just become it: frames are kept whole until a slow ball has moved by more than goes unnoticed
AT_ONCE = 128  # rows
SAMPLES = 11  # pictures that tell what most of them show; of an odd number one is in the middle


class Part(NamedTuple):
    """A part of a picture: where it is, its planes, and a look at few of their pixels."""

    window: Window
    planes: Planes
    coarse: Planes


@dataclass(frozen=True, slots=True, kw_only=True)
class Kept:
    """What is kept of one frame: the number of the picture it differs from, and the parts that differ."""

    picture: int
    parts: tuple[Part, ...] = ()

    @property
    def bytes(self) -> int:
        """How much memory it takes."""
        return sum(_size(part.planes) + _size(part.coarse) for part in self.parts)


@dataclass(slots=True, kw_only=True)
class Keeper:
    """Looks at frame after frame, in order, and keeps what changes, unless that is too much.

    Attributes
    ----------
    pictures : list of planes
        From which the frames differ.
    frames : list of Kept
        One for each frame.
    changes : list of float
        How much each frame differs from the one before it, grey levels; the first by infinity.
    overflown : bool
        True once there was too much to keep; pictures and frames are then empty.
    """

    pictures: list[Planes] = field(default_factory=list)
    frames: list[Kept] = field(default_factory=list)
    changes: list[float] = field(default_factory=list)
    overflown: bool = False
    _bytes: int = 0
    _much: int = field(default_factory=lambda: MUCH_BYTES)
    _newest: int = 0  # frame that became the last of the pictures
    _lasting: int = LINGERING
    _beside: int = BESIDE
    _noise: float = NOISIEST
    _reference: Planes | None = None
    _before: Planes | None = None
    _lingering: Image | None = None

    def look(self, seen: Planes) -> None:
        """Keep what changed in the next frame."""
        coarse = coarsely(seen)
        self.changes.append(np.inf if self._before is None else largest_change(self._before[0], coarse[0]))
        self._before = coarse
        if self.overflown:
            return
        gain, windows = 1.0, None
        if self._reference is not None:
            gain = gain_between(coarse[0], self._reference[0])
            self._noise = min(self._noise, noise_between(coarse[0], self._reference[0], gain))
            windows = self._changed(coarse, self._reference, gain, seen[0].shape)
        if windows is None and len(self.pictures) > 1 and len(self.frames) <= self._newest + LINGERING:
            windows, gain = (everywhere(seen[0].shape),), 1.0
        if windows is None:
            self._reference, self._newest = coarse, len(self.frames)
            self.pictures.append(copied(seen))
            self._bytes += _size(seen)
            windows, gain = (), 1.0
        self._keep([_part(cut(seen, window), coarse, window, 1 / gain) for window in windows])
        if self._bytes > self._much:
            self._settle()
        if self._bytes > MOST_BYTES:
            self.overflown = True
            self.pictures.clear()
            self.frames.clear()

    def _keep(self, parts: Sequence[Part]) -> None:
        """Keep what differs in a frame."""
        self.frames.append(Kept(picture=len(self.pictures) - 1, parts=tuple(parts)))
        self._bytes += self.frames[-1].bytes

    def _settle(self) -> None:
        """Let all frames differ from what most of them show, if the camera stands still."""
        if len(self.pictures) == 1 and self._reference is not None:
            (before,), reference, frames = self.pictures, self._reference, self.frames[::-1]
            usual = _usual(before, self.frames)
            self.pictures, self.frames, self._bytes = [usual], [], _size(usual)
            self._reference, self._lingering = coarsely(usual), None
            self._lasting, self._beside = BRIEFLY, CLOSELY
            while frames:
                kept = frames.pop()  # its memory is free at once
                coarse = laid_over(reference, [(_coarsely(part.window), part.coarse) for part in kept.parts])
                windows = self._changed(coarse, self._reference, 1.0, usual[0].shape)
                places = (everywhere(usual[0].shape),) if windows is None else windows
                self._keep([_part(shown(before, kept, window), coarse, window) for window in places])
        self._much = max(2 * self._bytes, MOST_BYTES)  # it would hardly become less before

    def _changed(
        self, coarse: Planes, reference: Planes, gain: float, shape: tuple[int, ...]
    ) -> tuple[Window, ...] | None:
        """Windows around all that differs from the last picture; None if that is nearly everything."""
        least = max(LEAST_CHANGE, NOISE_FACTOR * self._noise)
        if self._lingering is None:
            self._lingering = np.zeros_like(coarse[0])
        lit = brightened(reference, gain)
        mark_changes(coarse, lit, least, self._lingering, self._lasting, (0, 0))
        windows = boxes(self._lingering, self._beside, shape)
        kept = sum((rows.stop - rows.start) * (columns.stop - columns.start) for rows, columns in windows)
        return None if kept > NEW_PICTURE_SHARE * shape[0] * shape[1] else windows


def laid_over(picture: Planes, parts: Iterable[tuple[Window, Planes]]) -> Planes:
    """Copy a picture and lay parts of another over it."""
    whole = copied(picture)
    for window, planes in parts:
        for place, plane in zip(cut(whole, window), planes, strict=True):
            place[:] = plane
    return whole


def shown(picture: Planes, kept: Kept, window: Window) -> Planes:
    """Give a window of a frame again: the picture that it differs from, and over that what was kept of it."""
    for part in kept.parts:
        if _overlap(part.window, window) == window:
            return cut(part.planes, _within(window, part.window))
    common = [(_overlap(part.window, window), part) for part in kept.parts]
    return laid_over(
        cut(picture, window),
        [
            (_within(both, window), cut(part.planes, _within(both, part.window)))
            for both, part in common
            if all(side.start < side.stop for side in both)
        ],
    )


def ever_changed(frames: Iterable[Kept], shape: tuple[int, ...]) -> tuple[Window, ...]:
    """Windows outside of which no frame differs from any other."""
    changed = np.zeros([-(-side // COARSE) for side in shape], dtype=np.uint8)
    for kept in frames:
        for part in kept.parts:
            changed[_coarsely(part.window)] = 1
    return boxes(changed, 1, shape)


def usual_picture(looks: Sequence[Planes]) -> Planes:
    """Median of some pictures, pixel by pixel."""
    brightness, blue, red = (_median(levels) for levels in zip(*looks, strict=True))
    return brightness, blue, red


def _median(levels: Sequence[Image]) -> Image:
    """Median of some planes, some rows at a time: copies of all of them would take much memory."""
    first = range(0, len(levels[0]), AT_ONCE)
    return np.concatenate(
        [median_of(np.stack([own[row : row + AT_ONCE] for own in levels])) for row in first]
    )


def _usual(picture: Planes, frames: Sequence[Kept]) -> Planes:
    """Show what most of some frames show."""
    some = [frames[k] for k in np.linspace(0, len(frames) - 1, SAMPLES).astype(int)]
    windows = ever_changed(frames, picture[0].shape)
    return laid_over(
        picture,
        [(window, usual_picture([shown(picture, kept, window) for kept in some])) for window in windows],
    )


def _part(planes: Planes, coarse: Planes, window: Window, gain: float = 1.0) -> Part:
    """Copy a part of a picture, and of the look at it, made brighter or darker."""
    few = copied(cut(coarse, _coarsely(window)))
    return Part(window, brightened(copied(planes), gain), brightened(few, gain))


def _coarsely(window: Window) -> Window:
    """Turn rows and columns of a picture into those of its coarse look."""
    rows, columns = (slice(side.start // COARSE, -(-side.stop // COARSE)) for side in window)
    return rows, columns


def _overlap(one: Window, other: Window) -> Window:
    """Rows and columns that two windows have in common."""
    rows, columns = (
        slice(max(a.start, b.start), min(a.stop, b.stop)) for a, b in zip(one, other, strict=True)
    )
    return rows, columns


def _within(window: Window, whole: Window) -> Window:
    """Rows and columns of a window as counted in another one that holds it."""
    rows, columns = (slice(a.start - b.start, a.stop - b.start) for a, b in zip(window, whole, strict=True))
    return rows, columns


def _size(planes: Planes) -> int:
    """How much memory planes take, bytes."""
    return sum(plane.nbytes for plane in planes)

"""What is kept of a recording in memory: a picture, and of the others only the places that differ from it.

A recording is decoded once. Most of each picture shows what the picture before showed, so what a ball, a hand
or a shadow changed is kept and laid over the first picture again whenever the frame is looked at.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import cv2
import numpy as np

from tracking.planes import Image, Planes, Window, above, copied, cut, enlarged, fewer

MOST_BYTES = 200_000_000
COARSE = 4  # pixels from one that is looked at to the next
LEAST_CHANGE = 5.0  # grey levels: compression changes as much where nothing moves
COLOUR_SHARE = 0.6  # compression rounds colour more than brightness
NOISE_FACTOR = 5.0  # a change this many times the noise is one
LINGERING = 16  # frames for which a place that changed is kept: a ball may pass where the picture shows one
BESIDE = 7  # coarse pixels kept around a change: a rim is searched beyond the ball
NEW_PICTURE_SHARE = 0.6  # a frame that changed more than this becomes the picture that others differ from
SAME_GAIN = 0.004  # brightness that differs by less than this share is left alone
GAIN_RANGE = (0.5, 2.0)
CHANGED_RANK = 8  # coarse pixels that must have changed by so much: one may be noise


@dataclass(frozen=True, slots=True, kw_only=True)
class Kept:
    """What is kept of one frame: the number of the picture it differs from, where, and how it looks there."""

    picture: int
    windows: tuple[Window, ...] = ()
    patches: tuple[Planes, ...] = ()


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
    _noise: float = np.nan
    _reference: Planes | None = None
    _before: Planes | None = None
    _lingering: Image | None = None

    def look(self, seen: Planes) -> None:
        """Keep what changed in the next frame."""
        coarse = coarsely(seen)
        self.changes.append(np.inf if self._before is None else _change(self._before[0], coarse[0]))
        self._before = coarse
        if self.overflown:
            return
        gain, windows = 1.0, None
        if self._reference is not None:
            gain = gain_between(coarse[0], self._reference[0])
            windows = self._changed(coarse, self._reference, gain, seen[0].shape)
        if windows is None:
            self._reference = coarse
            self.pictures.append(copied(seen))
            self._bytes += sum(plane.nbytes for plane in seen)
            windows, gain = (), 1.0
        patches = tuple(_patch(seen, window, 1 / gain) for window in windows)
        self._bytes += sum(plane.nbytes for patch in patches for plane in patch)
        self.frames.append(Kept(picture=len(self.pictures) - 1, windows=windows, patches=patches))
        if self._bytes > MOST_BYTES:
            self.overflown = True
            self.pictures.clear()
            self.frames.clear()

    def _changed(
        self, coarse: Planes, reference: Planes, gain: float, shape: tuple[int, ...]
    ) -> tuple[Window, ...] | None:
        """Windows around all that differs from the last picture; None if that is nearly everything."""
        if np.isnan(self._noise):
            self._noise = 1.2533 * float(np.minimum(cv2.absdiff(coarse[0], reference[0]), 10).mean())
        least = max(LEAST_CHANGE, NOISE_FACTOR * self._noise)
        apart = coarse_difference(coarse, reference, gain)
        lingering = np.asarray(above(apart, least) * np.uint8(LINGERING), dtype=np.uint8)
        if self._lingering is not None:
            lingering = np.asarray(
                cv2.max(lingering, self._lingering - (self._lingering > 0)), dtype=np.uint8
            )
        self._lingering = lingering
        windows = boxes(above(lingering, 0), BESIDE, shape)
        kept = sum((rows.stop - rows.start) * (columns.stop - columns.start) for rows, columns in windows)
        return None if kept > NEW_PICTURE_SHARE * shape[0] * shape[1] else windows


def relive(pictures: Sequence[Planes], frames: Sequence[Kept], wanted: Sequence[int]) -> Iterator[Planes]:
    """Give some frames in turn, all in one piece of memory: each holds until the next is taken."""
    shown = -1
    changed: tuple[Window, ...] = ()
    for number in wanted:
        kept = frames[number]
        if kept.picture != shown:
            shown, whole = kept.picture, copied(pictures[kept.picture])
        else:
            for window in changed:
                _lay(cut(pictures[shown], window), whole, window)
        for window, patch in zip(kept.windows, kept.patches, strict=True):
            _lay(patch, whole, window)
        changed = kept.windows
        yield whole


def _lay(patch: Planes, whole: Planes, window: Window) -> None:
    """Lay a patch over a picture."""
    place = cut(whole, window)
    place[0][:], place[1][:], place[2][:] = patch


def _patch(seen: Planes, window: Window, gain: float) -> Planes:
    """Copy what is in a window, made as bright as the picture it differs from."""
    brightness, blue, red = copied(cut(seen, window))
    return brightened(brightness, gain), blue, red


def boxes(mask: Image, beside: int, shape: tuple[int, ...]) -> tuple[Window, ...]:
    """Windows, in pixels of a picture of some `shape`, around all that is set in its coarse mask."""
    outlines, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    found: list[tuple[int, int, int, int]] = []
    for outline in outlines:
        left, top, width, height = cv2.boundingRect(outline)
        found = _joined(found, (top - beside, top + height + beside, left - beside, left + width + beside))
    return tuple(
        (
            slice(COARSE * max(top, 0), min(COARSE * bottom, shape[0])),
            slice(COARSE * max(left, 0), min(COARSE * right, shape[1])),
        )
        for top, bottom, left, right in found
    )


def _joined(
    apart: list[tuple[int, int, int, int]], box: tuple[int, int, int, int]
) -> list[tuple[int, int, int, int]]:
    """Add a box (top, bottom, left, right) to boxes that do not overlap; those that do become one."""
    top, bottom, left, right = box
    for other in apart:
        if top < other[1] and other[0] < bottom and left < other[3] and other[2] < right:
            rest = [one for one in apart if one is not other]
            both = min(top, other[0]), max(bottom, other[1]), min(left, other[2]), max(right, other[3])
            return _joined(rest, both)
    return [*apart, box]


def coarsely(seen: Planes) -> Planes:
    """Look at a few pixels only, evenly spread; brightness averaged over three rows and columns."""
    down, right = fewer(seen)
    brightness = cv2.blur(np.ascontiguousarray(seen[0][::COARSE, ::COARSE]), (3, 3))
    blue, red = (
        np.ascontiguousarray(plane[:: 2 * COARSE // down, :: 2 * COARSE // right]) for plane in seen[1:]
    )
    return np.asarray(brightness, dtype=np.uint8), blue, red


def coarse_difference(coarse: Planes, reference: Planes, gain: float) -> Image:
    """How much coarse looks differ, the reference made `gain` times as bright, grey levels."""
    apart = cv2.absdiff(coarse[0], brightened(reference[0], gain))
    colour = cv2.max(cv2.absdiff(coarse[1], reference[1]), cv2.absdiff(coarse[2], reference[2]))
    weak = np.asarray(cv2.convertScaleAbs(colour, alpha=COLOUR_SHARE), dtype=np.uint8)
    large = enlarged(weak, apart.shape, cv2.INTER_NEAREST)
    return np.asarray(cv2.max(apart, large), dtype=np.uint8)


def gain_between(image: Image, reference: Image) -> float:
    """How much brighter a picture is than another: flicker."""
    few = (slice(None, None, 8), slice(None, None, 8))
    ratio = np.sort((image[few] + np.float32(1)) / (reference[few] + np.float32(1)), axis=None)
    return float(np.clip(ratio[len(ratio) // 2], *GAIN_RANGE))


def brightened(image: Image, gain: float) -> Image:
    """Make a picture brighter or darker, unless hardly."""
    if abs(gain - 1) < SAME_GAIN:
        return image
    return np.asarray(cv2.convertScaleAbs(image, alpha=gain), dtype=np.uint8)


def _change(before: Image, after: Image) -> float:
    """Tell by how much the most changed places of two pictures differ, grey levels (bisected bit by bit)."""
    apart = np.asarray(cv2.absdiff(before, after), dtype=np.uint8)
    level = 0
    for bit in (128, 64, 32, 16, 8, 4, 2, 1):
        level += bit * (cv2.countNonZero(above(apart, level + bit - 1)) >= CHANGED_RANK)
    return float(level)

"""What is kept of a recording in memory: a picture, and of the others only the places that differ from it.

A recording is decoded once. Most of each picture shows what the picture before showed, so what a ball, a hand
or a shadow changed is kept and laid over the first picture again whenever the frame is looked at.
"""

from dataclasses import dataclass, field

import cv2
import numpy as np

from tracking.boxes import boxes
from tracking.coarse import brightened, coarsely, gain_between, largest_change, mark_changes
from tracking.planes import Image, Planes, Window, copied, cut

MOST_BYTES = 120_000_000  # all of the program then takes less than 500 MB, up to 1080p
LEAST_CHANGE = 5.0  # grey levels: compression changes as much where nothing moves
NOISE_FACTOR = 5.0  # a change this many times the noise is one
LINGERING = 16  # frames for which a place that changed is kept: a ball may pass where the picture shows one
BESIDE = 7  # coarse pixels kept around a change: a rim is searched beyond the ball
NEW_PICTURE_SHARE = 0.6  # a frame that changed more than this becomes the picture that others differ from


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
        self.changes.append(np.inf if self._before is None else largest_change(self._before[0], coarse[0]))
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
        if self._lingering is None:
            self._lingering = np.zeros_like(coarse[0])
        mark_changes(coarse, reference, (gain, least), self._lingering, LINGERING, (0, 0))
        windows = boxes(self._lingering, BESIDE, shape)
        kept = sum((rows.stop - rows.start) * (columns.stop - columns.start) for rows, columns in windows)
        return None if kept > NEW_PICTURE_SHARE * shape[0] * shape[1] else windows


def laid_over(picture: Planes, kept: Kept) -> Planes:
    """Give a whole frame again: the picture that it differs from, and over that what was kept of it."""
    whole = copied(picture)
    for window, patch in zip(kept.windows, kept.patches, strict=True):
        for place, plane in zip(cut(whole, window), patch, strict=True):
            place[:] = plane
    return whole


def _patch(seen: Planes, window: Window, gain: float) -> Planes:
    """Copy what is in a window, made as bright as the picture it differs from."""
    brightness, blue, red = copied(cut(seen, window))
    return brightened(brightness, gain), blue, red

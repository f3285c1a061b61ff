"""What is kept of a recording in memory: a picture, and of the others only the places that differ from it.

Those places are laid over the picture again whenever a frame is looked at.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tracking.boxes import boxes
from tracking.coarse import COARSE, brightened, gain_between
from tracking.median import median_of
from tracking.planes import Image, Planes, Window, copied, cut

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
        return sum(size_of(part.planes) + size_of(part.coarse) for part in self.parts)


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
            changed[coarse_window(part.window)] = 1
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


def usual_of(pictures: Sequence[Planes], looks: Sequence[Planes], frames: Sequence[Kept]) -> Planes:
    """Show what most of some frames show, as bright as in the middle; `looks` are those at the pictures."""
    some = [frames[k] for k in np.linspace(0, len(frames) - 1, SAMPLES).astype(int)]
    shape, bright = pictures[0][0].shape, [looks[kept.picture][0] for kept in some]
    gains = [gain_between(own, bright[len(some) // 2]) for own in bright]
    windows = ever_changed(frames, shape) if len(pictures) == 1 else _strips(shape)

    def alike(window: Window) -> list[Planes]:
        lit = zip(some, gains, strict=True)
        return [brightened(shown(pictures[kept.picture], kept, window), 1 / gain) for kept, gain in lit]

    return laid_over(pictures[0], [(window, usual_picture(alike(window))) for window in windows])


def _strips(shape: tuple[int, ...]) -> tuple[Window, ...]:
    """Windows that make up a picture, some rows each."""
    height, width = shape
    return tuple(
        (slice(row, min(row + AT_ONCE, height)), slice(0, width)) for row in range(0, height, AT_ONCE)
    )


def part_of(planes: Planes, coarse: Planes, window: Window, gain: float) -> Part:
    """Copy a part of a picture, and of the look at it, made brighter or darker."""
    few = copied(cut(coarse, coarse_window(window)))
    return Part(window, brightened(copied(planes), gain), brightened(few, gain))


def coarse_window(window: Window) -> Window:
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


def size_of(planes: Planes) -> int:
    """How much memory planes take, bytes."""
    return sum(plane.nbytes for plane in planes)

"""Who keeps a recording: looks at its frames in order, each once, and keeps what changes in them.

Most of each picture shows what the picture before showed, so what a ball, a hand or a shadow changed is
kept. When that becomes much, frames are compared with what most of them show instead, where the hand and the
ball of the first picture are gone.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from tracking.boxes import boxes
from tracking.coarse import brightened, coarsely, gain_between, largest_change, mark_changes, noise_between
from tracking.kept import Kept, Part, coarse_window, laid_over, part_of, shown, size_of, usual_of
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


@dataclass(slots=True, kw_only=True)
class _Reference:
    """A coarse look at the picture that frames are compared with, in order; it remembers what differed.

    `marks` count down the frames for which a place is still kept, `lasting` many from its last change on.
    """

    coarse: Planes
    marks: Image
    lasting: int = LINGERING
    beside: int = BESIDE

    def differing(
        self, coarse: Planes, gain: float, least: float, shape: tuple[int, ...]
    ) -> tuple[Window, ...] | None:
        """Windows around all that differs in a frame, or did lately; None if that is nearly everything.

        Parameters
        ----------
        coarse : look at the frame
        gain : float
            How much brighter it is than this one.
        least : float
            Least difference that is a change, grey levels.
        shape : two int
            Height and width of the whole picture, px.
        """
        mark_changes(coarse, brightened(self.coarse, gain), least, self.marks, self.lasting, (0, 0))
        windows = boxes(self.marks, self.beside, shape)
        return None if _area(windows) > NEW_PICTURE_SHARE * shape[0] * shape[1] else windows


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
    _noise: float = NOISIEST
    _before: Planes | None = None
    _reference: _Reference | None = None

    def look(self, seen: Planes) -> None:
        """Keep what changed in the next frame."""
        coarse = coarsely(seen)
        self.changes.append(np.inf if self._before is None else largest_change(self._before[0], coarse[0]))
        self._before = coarse
        if self.overflown:
            return
        gain, windows = 1.0, None
        if self._reference is not None:
            gain = gain_between(coarse[0], self._reference.coarse[0])
            self._noise = min(self._noise, noise_between(coarse[0], self._reference.coarse[0], gain))
            windows = self._reference.differing(coarse, gain, self._least, seen[0].shape)
        if windows is None and len(self.pictures) > 1 and len(self.frames) <= self._newest + LINGERING:
            windows, gain = (everywhere(seen[0].shape),), 1.0
        if windows is None:
            self._renew(seen, coarse)
            windows, gain = (), 1.0
        self._keep([part_of(cut(seen, window), coarse, window, 1 / gain) for window in windows])
        if self._bytes > self._much:
            self._settle()
        if self._bytes > MOST_BYTES:
            self.overflown = True
            self.pictures.clear()
            self.frames.clear()

    @property
    def _least(self) -> float:
        """Least difference that is a change, grey levels."""
        return max(LEAST_CHANGE, NOISE_FACTOR * self._noise)

    def _renew(self, seen: Planes, coarse: Planes) -> None:
        """Let a frame be the picture that the next ones are compared with."""
        marks = np.zeros_like(coarse[0]) if self._reference is None else self._reference.marks
        self._reference, self._newest = _Reference(coarse=coarse, marks=marks), len(self.frames)
        self.pictures.append(copied(seen))
        self._bytes += size_of(seen)

    def _keep(self, parts: Sequence[Part]) -> None:
        """Keep what differs in a frame."""
        self.frames.append(Kept(picture=len(self.pictures) - 1, parts=tuple(parts)))
        self._bytes += self.frames[-1].bytes

    def _settle(self) -> None:
        """Let all frames differ from what most of them show, unless that is no less."""
        before, looks = self.pictures, [coarsely(own) for own in self.pictures]
        usual = usual_of(before, looks, self.frames)
        coarse, shape = coarsely(usual), usual[0].shape
        reference = _Reference(coarse=coarse, marks=np.zeros_like(coarse[0]), lasting=BRIEFLY, beside=CLOSELY)
        changes = [self._change(reference, _look_at(kept, looks), shape) for kept in self.frames]
        taken = sum(_area(windows) for _, windows in changes) / (shape[0] * shape[1])
        if (1 + taken) * size_of(usual) < self._bytes:
            self.pictures, frames, self.frames = [usual], self.frames[::-1], []
            self._reference, self._bytes = reference, size_of(usual)
            for gain, windows in changes:
                kept = frames.pop()  # its memory is free at once
                coarse, picture = _look_at(kept, looks), before[kept.picture]
                self._keep(
                    [part_of(shown(picture, kept, window), coarse, window, 1 / gain) for window in windows]
                )
        self._much = max(2 * self._bytes, MOST_BYTES)  # it would hardly become less before

    def _change(
        self, reference: _Reference, coarse: Planes, shape: tuple[int, ...]
    ) -> tuple[float, tuple[Window, ...]]:
        """How much brighter than another picture a frame is that is kept, and where it differs from it."""
        gain = gain_between(coarse[0], reference.coarse[0])
        windows = reference.differing(coarse, gain, self._least, shape)
        return gain, (everywhere(shape),) if windows is None else windows


def _look_at(kept: Kept, looks: Sequence[Planes]) -> Planes:
    """Give the coarse look at a frame again, by those at the pictures from which frames differ."""
    return laid_over(looks[kept.picture], [(coarse_window(part.window), part.coarse) for part in kept.parts])


def _area(windows: Iterable[Window]) -> int:
    """How many pixels windows hold."""
    return sum((rows.stop - rows.start) * (columns.stop - columns.start) for rows, columns in windows)

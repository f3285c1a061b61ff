"""What is cut out of a frame around a ball, and what is seen of the ball there."""

from collections.abc import Sequence
from dataclasses import dataclass

from tracking.circle import Circle, Rim
from tracking.patch import Patch, Patches, laid_out, patch_of
from tracking.recording import View


@dataclass(frozen=True, slots=True, kw_only=True)
class Sighting:
    """One frame's rim of one ball, the circle first fitted to it, and its way during the exposure, px.

    `shading` is how far (x, y) in px the ball's limb moved the circle that its edges make; `sized` whether
    the circle's radius was seen in this frame, and not told by others.
    """

    frame: int
    time: float
    rim: Rim
    circle: Circle
    blur: float
    shading: tuple[float, float] = (0.0, 0.0)
    sized: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class Cutting:
    """What surrounds a place in a frame."""

    frame: int
    time: float
    patch: Patch


@dataclass(frozen=True, slots=True)
class Cuttings:
    """What surrounds a place in each of some frames: their numbers and times, s, and the patches."""

    frames: tuple[int, ...]
    times: tuple[float, ...]
    patches: Patches

    def take(self, which: Sequence[int]) -> "Cuttings":
        """Give some of them, in any order and as often as wanted."""
        frames, times = tuple(self.frames[i] for i in which), tuple(self.times[i] for i in which)
        return Cuttings(frames, times, self.patches.take(which))


def together(cuttings: Sequence[Cutting]) -> Cuttings:
    """Put cuttings together, to be gone through at once."""
    return Cuttings(
        tuple(cutting.frame for cutting in cuttings),
        tuple(cutting.time for cutting in cuttings),
        laid_out([cutting.patch for cutting in cuttings]),
    )


def cut_out(view: View, place: tuple[float, float], half: float) -> Cutting:
    """Copy what is at most so many pixels above, below or beside a place."""
    left, top = (max(0, int(value - half)) // 2 * 2 for value in place)
    height, width = view.size
    window = (
        slice(top, min(int(place[1] + half) + 2, height)),
        slice(left, min(int(place[0] + half) + 2, width)),
    )
    return Cutting(frame=view.index, time=view.time, patch=patch_of(view.cut(window), left, top))

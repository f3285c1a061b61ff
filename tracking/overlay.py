"""What is drawn on a recording for the eye: outlines as seen, fitted paths, moments, lines of text."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tracking.track import Track

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Outline:
    """One ball as seen: (n,) frame numbers, (n, 2) centres and (n,) radii in px; radius 0 is a point."""

    frame: npt.NDArray[np.int64]
    centre: FloatArray
    radius: FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class Moment:
    """A moment (s) and the place (2,) in px where it happens, in a word or two.

    The contact sheet shows the frames around those that are impacts.
    """

    time: float
    place: FloatArray
    words: str
    is_impact: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class Scene:
    """What is told from `since` (s) to the next scene: lines of text, curves (n, 2) in px, moments."""

    since: float = -np.inf
    lines: tuple[str, ...] = ()
    curves: tuple[FloatArray, ...] = ()
    moments: tuple[Moment, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Overlay:
    """All that is drawn on one recording; `scenes` in order of time."""

    outlines: tuple[Outline, ...]
    scenes: tuple[Scene, ...] = (Scene(),)

    @property
    def impact_times(self) -> list[float]:
        """Times of the impacts, s, in order."""
        return sorted(moment.time for scene in self.scenes for moment in scene.moments if moment.is_impact)

    def scene_at(self, time: float) -> Scene:
        """Give the scene that a frame of this time belongs to."""
        started = [scene for scene in self.scenes if scene.since <= time]
        return started[-1] if started else self.scenes[0]


def outline_of(track: Track, radius: FloatArray | None = None) -> Outline:
    """Take the outlines from a track in pixels, with (n,) radii where they change along the way."""
    return Outline(
        frame=track.frame,
        centre=np.column_stack((track.x, track.y)),
        radius=np.full(len(track.frame), track.radius) if radius is None else radius,
    )

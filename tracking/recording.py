"""What a recording is once its file was read: its frames, their times of capture, what was found out."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt

from tracking.kept import Kept, Part, shown
from tracking.notebook import html_table
from tracking.planes import Image, Planes, Window, colours, cut, enlarged, everywhere
from tracking.stamps import CLOCK_SD

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Frame:
    """One picture: its number in the file, its time of capture, s, and its (height, width, 3) BGR levels."""

    index: int
    time: float
    image: Image


@dataclass(frozen=True, slots=True, kw_only=True)
class View:
    """One picture as it is measured: planes, and what is `kept` of it if they belong to another picture.

    Outside of the parts that `changed` it shows what most of the recording shows; None: nobody looked.
    """

    index: int
    time: float
    picture: Planes
    kept: Kept | None = None
    changed: tuple[Part, ...] | None = None

    @property
    def size(self) -> tuple[int, int]:
        """Height and width, px."""
        height, width = self.picture[0].shape
        return height, width

    @property
    def planes(self) -> Planes:
        """All of the picture."""
        return self.cut(everywhere(self.size))

    def cut(self, window: Window) -> Planes:
        """View a window, whose rows and columns start at even numbers."""
        return cut(self.picture, window) if self.kept is None else shown(self.picture, self.kept, window)

    def frame(self) -> Frame:
        """Make a copy that stays, of all of the picture."""
        return Frame(index=self.index, time=self.time, image=colours(self.planes))


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
    size : two int
        Height and width of the upright picture, px.
    capture_fps : float
        Pictures captured a second.
    rate_sd : float
        Relative standard uncertainty of that rate.
    quarter_turns : int
        Counter-clockwise turns that made the stored pictures upright, 0 to 3.
    notes : tuple of str
        What was found out or assumed, for the person who made the recording.
    looks : mapping of int to planes
        Some pictures spread over the recording, by the number of the frame.
    pictures : tuple of planes
        From which the frames that are `kept` differ.
    kept : tuple of Kept
        What every stored frame shows, if so little changes that it can be kept in memory; else empty.
    drift : (n, 2, 3) array, optional
        Affine map from where the background belongs to where a camera that drifts shows it, for each stored
        frame; frames are given with it undone. None for a camera that stands still.
    """

    path: Path
    times: FloatArray
    genuine: npt.NDArray[np.bool_]
    size: tuple[int, int]
    capture_fps: float
    rate_sd: float = CLOCK_SD
    quarter_turns: int = 0
    notes: tuple[str, ...] = ()
    looks: Mapping[int, Planes] = field(default_factory=dict)
    pictures: tuple[Planes, ...] = ()
    kept: tuple[Kept, ...] = ()
    drift: FloatArray | None = None

    def _repr_html_(self) -> str:
        """Show what the file holds and what was found out about it."""
        height, width = self.size
        rows = [
            (
                "frames",
                f"{int(self.genuine.sum())} pictures in {len(self.times)} frames, {width} × {height} px",
            ),
            ("rate", f"{self.capture_fps:.5g} captured a second, {np.ptp(self.times):.3f} s in all"),
            *(("note", note) for note in self.notes),
        ]
        return html_table(self.path.name, rows)


def held_still(picture: Planes, motion: FloatArray) -> Planes:
    """Undo the motion of a camera, a (2, 3) affine map, in one picture."""
    shape = picture[0].shape
    brightness, blue, red = (
        moved_back(enlarged(plane, shape, cv2.INTER_LINEAR), motion) for plane in picture
    )
    return brightness, blue, red


def moved_back(plane: Image, motion: FloatArray) -> Image:
    """Undo the motion of a camera in one plane, or in all colours."""
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    size = (plane.shape[1], plane.shape[0])
    return np.asarray(
        cv2.warpAffine(plane, motion, size, flags=flags, borderMode=cv2.BORDER_REPLICATE), dtype=np.uint8
    )

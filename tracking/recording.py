"""What a recording is once its file was read: its frames, their times of capture, what was found out."""

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt

from tracking.stamps import CLOCK_SD

FloatArray = npt.NDArray[np.float64]
Image = npt.NDArray[np.uint8]


@dataclass(frozen=True, slots=True, kw_only=True)
class Frame:
    """One picture: its number in the file, its time of capture, s, and its (height, width, 3) BGR levels."""

    index: int
    time: float
    image: Image


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
    samples : list of (height, width, 3) arrays
        At most 30 pictures spread over the recording, from which the background is made.
    capture_fps : float
        Pictures captured a second.
    rate_sd : float
        Relative standard uncertainty of that rate.
    quarter_turns : int
        Counter-clockwise turns that made the stored pictures upright, 0 to 3.
    notes : tuple of str
        What was found out or assumed, for the person who made the recording.
    drift : (n, 2, 3) array, optional
        Affine map from where the background belongs to where a camera that drifts shows it, for each stored
        frame; frames are given with it undone. None for a camera that stands still.
    """

    path: Path
    times: FloatArray
    genuine: npt.NDArray[np.bool_]
    samples: list[Image]
    capture_fps: float
    rate_sd: float = CLOCK_SD
    quarter_turns: int = 0
    notes: tuple[str, ...] = ()
    drift: FloatArray | None = None

    @property
    def bytes(self) -> int:
        """Memory that all genuine frames take together."""
        return int(self.genuine.sum()) * self.samples[0].nbytes


def held_still(picture: Image, motion: FloatArray) -> Image:
    """Undo the motion of a camera, a (2, 3) affine map, in one picture."""
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    size = (picture.shape[1], picture.shape[0])
    return np.asarray(
        cv2.warpAffine(picture, motion, size, flags=flags, borderMode=cv2.BORDER_REPLICATE), dtype=np.uint8
    )

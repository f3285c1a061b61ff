"""Compiled: levels of a patch as numbers of single precision, which a processor reads sooner than bytes."""

import numpy as np
import numpy.typing as npt

from tracking.kernel import part
from tracking.planes import Image


@part
def patch_levels(
    pictures: tuple[Image, npt.NDArray[np.int64]], number: int
) -> tuple[npt.NDArray[np.float32], int, int]:
    """Give levels (height, width, 3) of a patch, and x and y of its upper left pixel.

    `pictures` are levels and places of `Patches`.
    """
    bytewise, places = pictures
    first, height, width, left, top = places[number]
    levels = np.empty((height, width, 3), dtype=np.float32)
    numbers, own = levels.reshape(-1), bytewise[first : first + 3 * height * width]
    for k in range(len(own)):
        numbers[k] = own[k]
    return levels, left, top

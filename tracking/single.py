"""Compiled: levels as numbers of single precision, which a processor reads sooner than bytes."""

import numpy as np
import numpy.typing as npt

from tracking.kernel import part
from tracking.planes import Image


@part
def singly(image: Image) -> npt.NDArray[np.float32]:
    """Give the levels of a picture as numbers of single precision."""
    levels = np.empty(image.shape, dtype=np.float32)
    bytewise, numbers = image.reshape(-1), levels.reshape(-1)
    for k in range(len(bytewise)):
        numbers[k] = bytewise[k]
    return levels

"""A decoder's picture as it comes: planes of brightness and colour, upright; made BGR only where needed.

Turning a whole picture into BGR levels takes as long as decoding it does. So it is looked at as the decoder
gives it, and only what surrounds a ball is converted.
"""

import cv2
import numpy as np
import numpy.typing as npt

Image = npt.NDArray[np.uint8]
Planes = tuple[Image, Image, Image]
"""Brightness, and two colour differences of as many or half as many rows and columns."""
Window = tuple[slice, slice]
"""Rows and columns of a picture."""


def cut(whole: Planes, window: Window) -> Planes:
    """View a window, whose rows and columns start at even numbers, in all three planes."""
    rows, columns = window
    down, right = fewer(whole)
    colour = (
        slice(rows.start // down, -(-rows.stop // down)),
        slice(columns.start // right, -(-columns.stop // right)),
    )
    return whole[0][rows, columns], whole[1][colour], whole[2][colour]


def everywhere(shape: tuple[int, ...]) -> Window:
    """All rows and columns of a picture."""
    return slice(0, shape[0]), slice(0, shape[1])


def fewer(whole: Planes) -> tuple[int, int]:
    """How many times fewer rows and columns the planes of colour have than the brightness."""
    (height, width), (rows, columns) = whole[0].shape, whole[1].shape
    return -(-height // rows), -(-width // columns)


def copied(whole: Planes) -> Planes:
    """Copy planes out of the decoder's memory."""
    return whole[0].copy(), whole[1].copy(), whole[2].copy()


def colours(of: Planes) -> Image:
    """Make planes (height, width, 3) BGR levels, which may span less than a screen would show."""
    brightness, *differences = of
    blue, red = (enlarged(plane, brightness.shape, cv2.INTER_LINEAR) for plane in differences)
    return np.asarray(cv2.cvtColor(cv2.merge((brightness, red, blue)), cv2.COLOR_YCrCb2BGR), dtype=np.uint8)


def enlarged(plane: Image, shape: tuple[int, ...], how: int) -> Image:
    """Make a plane of colour as large as the brightness."""
    if plane.shape == shape:
        return plane
    down, right = (-(-full // own) for full, own in zip(shape, plane.shape, strict=True))
    wide = (plane.shape[1] * right, plane.shape[0] * down)
    return np.asarray(cv2.resize(plane, wide, interpolation=how), dtype=np.uint8)[: shape[0], : shape[1]]

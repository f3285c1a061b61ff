"""What differs from the background → patches that may be a ball."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np

from tracking.blob_kernel import Box, look_about, measured, sharp_part
from tracking.differing import closed
from tracking.planes import Image, Planes

MINIMUM_DIAMETER_PX = 5
CUT_SHARE = 0.9  # a cut that leaves more than this of a patch tells nothing new
FEWEST_POINTS = 2 * (MINIMUM_DIAMETER_PX - 1)  # of an outline so wide and high: there and back, aslant
GHOSTLY = 0.5  # of how much the background stands out


@dataclass(frozen=True, slots=True, kw_only=True)
class Blob:
    """A connected patch that differs from the background (pixels, grey levels).

    `x`, `y` is the middle of its bounding box: a ball's shaded side may be as bright as the wall behind it
    and leave a bay, which would draw a centroid away. `fill` is its area, holes filled, over that of the
    ellipse in its bounding box: 1 for a ball, sharp or smeared by motion; `spanned` the same with bays filled
    as well, `hull` being the area of its convex hull. A `ghost` is where something was that rests in the
    background: not the patch but the background stands out from what is beside it. `colour` is that of its
    middle: brightness and two differences.
    """

    x: float
    y: float
    width: float
    height: float
    area: float
    hull: float
    contrast: float
    ghost: bool
    colour: tuple[int, int, int]
    at_border: bool

    @property
    def blur(self) -> float:
        """How much longer than wide it is, px: a ball that moves is smeared."""
        return abs(self.height - self.width)

    @property
    def fill(self) -> float:
        """Area over the area of the ellipse that fits the bounding box."""
        return self.area / (np.pi / 4 * self.width * self.height)

    @property
    def spanned(self) -> float:
        """Area of the convex hull over the area of that ellipse."""
        return self.hull / (np.pi / 4 * self.width * self.height)


class Whole(NamedTuple):
    """A picture's shape; the planes, and their background, of a part of it whose corner (x, y) is known."""

    shape: tuple[int, ...]
    seen: Planes
    background: Planes
    corner: tuple[int, int]


def blobs_in(apart: Image, threshold: float, whole: Whole, corner: tuple[int, int]) -> list[Blob]:
    """List the patches of a difference, whose window lies at a corner (x, y) in its picture."""
    marks = closed(apart, threshold)
    blobs = []
    for box, area, hull in _outlines(marks):
        if area < MINIMUM_DIAMETER_PX**2 / 2:
            continue
        contrast, core, sharp = sharp_part(apart, marks, box)
        blobs.append(_blob((box, area, hull), contrast, whole, corner))
        if core < CUT_SHARE * area:
            within = corner[0] + box[0], corner[1] + box[1]
            blobs += [_blob(piece, contrast, whole, within) for piece in _outlines(sharp)]
    return blobs


def _outlines(marks: Image) -> Iterator[tuple[Box, float, float]]:
    """Box, area with holes filled and with bays filled, of each marked patch that could be a ball."""
    outlines, _ = cv2.findContours(marks, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    for outline in outlines:
        if len(outline) >= FEWEST_POINTS:
            box, area, hull = measured(np.asarray(outline, dtype=np.int32))
            if min(box[2:]) >= MINIMUM_DIAMETER_PX:
                yield box, area, hull


def _blob(piece: tuple[Box, float, float], contrast: float, whole: Whole, corner: tuple[int, int]) -> Blob:
    """Describe a patch that was outlined in a window whose corner (x, y) is known."""
    (left, top, width, height), area, hull = piece
    left, top = corner[0] + left, corner[1] + top
    box = left - whole.corner[0], top - whole.corner[1], width, height
    *colour, stands_out, background = look_about(whole.seen, whole.background, box)
    return Blob(
        x=left + (width - 1) / 2,
        y=top + (height - 1) / 2,
        width=float(width),
        height=float(height),
        area=area,
        hull=hull,
        contrast=contrast,
        colour=(colour[0], colour[1], colour[2]),
        ghost=stands_out < GHOSTLY * background,
        at_border=left <= 0 or top <= 0 or left + width >= whole.shape[1] or top + height >= whole.shape[0],
    )

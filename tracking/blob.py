"""What differs from the background → patches that may be a ball."""

from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np

from tracking.kernel import compiled
from tracking.planes import Image, Planes, Window, above, fewer

MINIMUM_DIAMETER_PX = 5
CUT_SHARE = 0.9  # a cut that leaves more than this of a patch tells nothing new
CLOSING = np.ones((5, 5), dtype=np.uint8)
GHOSTLY = 0.5  # of how much the background stands out
BESIDE_SHARE = 4  # of a patch's width, from its edge to what is beside it


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
    mask = np.asarray(cv2.morphologyEx(above(apart, threshold), cv2.MORPH_CLOSE, CLOSING), dtype=np.uint8)
    blobs = []
    for place, area, hull in _outlines(mask):
        if area < MINIMUM_DIAMETER_PX**2 / 2:
            continue
        levels = apart[place] * mask[place]
        contrast = _high_level(levels)
        blobs.append(_blob((place, area, hull), contrast, whole, corner))
        core = above(levels, 0.5 * contrast)
        if cv2.countNonZero(core) < CUT_SHARE * area:
            within = corner[0] + place[1].start, corner[1] + place[0].start
            blobs += [_blob(piece, contrast, whole, within) for piece in _outlines(core)]
    return blobs


def _outlines(mask: Image) -> list[tuple[Window, float, float]]:
    """Bounding box, area with holes filled and with bays filled, of each patch that could be a ball."""
    outlines, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    found = []
    for outline in outlines:
        left, top, width, height = cv2.boundingRect(outline)
        if min(width, height) >= MINIMUM_DIAMETER_PX:
            area = cv2.contourArea(outline) + len(outline) / 2 + 1  # Pick's theorem
            hull = cv2.convexHull(outline)
            spanned = cv2.contourArea(hull) + cv2.arcLength(hull, closed=True) / 2 + 1
            found.append(((slice(top, top + height), slice(left, left + width)), area, spanned))
    return found


@compiled
def _high_level(levels: Image) -> float:
    """Level that a tenth of the pixels above nothing exceed."""
    pixels = np.zeros(256, dtype=np.int64)
    for row in range(len(levels)):
        for column in range(levels.shape[1]):
            pixels[levels[row, column]] += 1
    rank, level = int(0.9 * (pixels[1:].sum() - 1)), 1
    while level < 255 and rank >= pixels[level]:
        rank -= pixels[level]
        level += 1
    return float(level)


def _blob(
    outline: tuple[Window, float, float], contrast: float, whole: Whole, corner: tuple[int, int]
) -> Blob:
    """Describe a patch that was outlined in a window whose corner (x, y) is known."""
    (rows, columns), area, hull = outline
    left, top = corner[0] + columns.start, corner[1] + rows.start
    width, height = columns.stop - columns.start, rows.stop - rows.start
    box = (left - whole.corner[0], top - whole.corner[1], width, height)
    return Blob(
        x=left + (width - 1) / 2,
        y=top + (height - 1) / 2,
        width=float(width),
        height=float(height),
        area=area,
        hull=hull,
        contrast=contrast,
        colour=_colour(whole.seen, box[1] + height // 2, box[0] + width // 2),
        ghost=_stands_out(whole.seen, box) < GHOSTLY * _stands_out(whole.background, box),
        at_border=left <= 0 or top <= 0 or left + width >= whole.shape[1] or top + height >= whole.shape[0],
    )


def _stands_out(planes: Planes, box: tuple[int, int, int, int]) -> int:
    """How much the middle of a box (left, top, width, height) differs from what is left and right of it."""
    left, top, width, height = box
    columns = left - width // BESIDE_SHARE, left + width // 2, left + width + width // BESIDE_SHARE
    before, inside, after = (_colour(planes, top + height // 2, column) for column in columns)
    return max(abs(2 * own - one - other) for one, own, other in zip(before, inside, after, strict=True))


def _colour(planes: Planes, row: int, column: int) -> tuple[int, int, int]:
    """Brightness and two differences of colour at a place; at the side, of what lies beyond it."""
    down, right = fewer(planes)
    column = max(column, 0)
    brightness, blue, red = (
        int(plane[row // rows, min(column // columns, plane.shape[1] - 1)])
        for plane, rows, columns in zip(planes, (1, down, down), (1, right, right), strict=True)
    )
    return brightness, blue, red

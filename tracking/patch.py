"""What surrounds a ball: a part of a picture in colours, and where it lies; and many of them at once."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from tracking.kernel import compiled, part
from tracking.planes import Image, Planes

SingleArray = npt.NDArray[np.float32]
LongArray = npt.NDArray[np.int64]

BLUE_SHARE, RED_SHARE = np.float32(1.773), np.float32(1.403)  # of a difference of colour, in that colour
BLUE_IN_GREEN, RED_IN_GREEN = np.float32(0.344), np.float32(0.714)
GREY, HALF, DARKEST, BRIGHTEST = np.array((128, 0.5, 0, 255), dtype=np.float32)
MOST, LEAST = np.array((0.75, 0.25), dtype=np.float32)  # of the nearer and the farther pixel of colour


class Patch(NamedTuple):
    """(height, width, 3) BGR levels of a part of a picture; x, y and 0 of its upper left pixel, px."""

    image: Image
    corner: npt.NDArray[np.float64]


def patch_of(seen: Planes, left: int, top: int) -> Patch:
    """Make a patch of planes that were cut out at a place."""
    brightness, blue, red = (np.ascontiguousarray(plane) for plane in seen)
    return Patch(_mixed(brightness, blue, red), np.array((left, top, 0.0)))


def part_of(image: Image, place: tuple[float, float], half: float) -> Patch:
    """View what is at most so many pixels above, below or beside a place of a picture; at least one pixel."""
    (left, right), (top, bottom) = (
        (min(max(int(value - half), 0), most - 1), min(max(int(value + half) + 1, 1), most))
        for value, most in zip(place, (image.shape[1], image.shape[0]), strict=True)
    )
    return Patch(image[top:bottom, left:right], np.array((left, top, 0.0)))


@dataclass(frozen=True, slots=True)
class Patches:
    """BGR levels of patches, one patch after the other; and where each begins there, and lies.

    `places` (n, 5): number of its first level, its height and width, x and y of its upper left pixel, px.
    Work on many patches is compiled as a whole: Python's lock is let go of once, not for each of them.
    """

    levels: Image
    places: LongArray

    def __len__(self) -> int:
        """How many there are."""
        return len(self.places)

    def take(self, which: Sequence[int]) -> "Patches":
        """Give some of them, in any order and as often as wanted."""
        return Patches(self.levels, self.places[np.asarray(which, dtype=np.int64)])


def laid_out(images: Sequence[Image | Patch] | Patches) -> Patches:
    """Lay patches one after the other; a whole picture is a patch, too."""
    if isinstance(images, Patches):
        return images
    patches = [image if isinstance(image, Patch) else Patch(image, np.zeros(3)) for image in images]
    places, first = np.empty((len(patches), 5), dtype=np.int64), 0
    for place, (image, corner) in zip(places, patches, strict=True):
        place[:] = first, *image.shape[:2], *corner[:2]
        first += image.size
    levels = [image.ravel() for image, _ in patches]
    return Patches(np.concatenate(levels) if levels else np.empty(0, dtype=np.uint8), places)


@compiled
def _mixed(brightness: Image, blue: Image, red: Image) -> Image:
    """Lay colour over brightness; where there is less of it, it is interpolated."""
    height, width = brightness.shape
    image, blended = np.empty((height, width, 3), dtype=np.uint8), np.empty(width + 2, dtype=np.float32)
    bluish, reddish = np.empty(2 * width, dtype=np.float32), np.empty(2 * width, dtype=np.float32)
    mixed = np.empty((3, width), dtype=np.uint8)
    for row in range(height):
        _spread(blue, row, brightness.shape, blended, bluish)
        _spread(red, row, brightness.shape, blended, reddish)
        levels, own = brightness[row], image[row].reshape(-1)
        blues, greens, reds = mixed[0], mixed[1], mixed[2]
        for column in range(width):
            level, b, r = np.float32(levels[column]) + HALF, bluish[column], reddish[column]
            green = level - BLUE_IN_GREEN * b - RED_IN_GREEN * r
            blues[column] = np.uint8(min(max(level + BLUE_SHARE * b, DARKEST), BRIGHTEST))
            greens[column] = np.uint8(min(max(green, DARKEST), BRIGHTEST))
            reds[column] = np.uint8(min(max(level + RED_SHARE * r, DARKEST), BRIGHTEST))
        for column in range(width):
            own[3 * column] = blues[column]
            own[3 * column + 1] = greens[column]
            own[3 * column + 2] = reds[column]
    return image


@part
def _spread(
    plane: Image, row: int, shape: tuple[int, int], blended: SingleArray, spread: SingleArray
) -> None:
    """Give one row of a plane of colour, about grey, as many pixels as the brightness has.

    A pixel lies nearer to one of colour than to the next; there is room for a row of those, `blended`.
    """
    rows, columns = plane.shape
    near = far = row
    if rows < shape[0]:
        near = row // 2
        far = min(max(near - 1 + 2 * (row % 2), 0), rows - 1)
    own, other = plane[near], plane[far]
    for k in range(columns):
        blended[k + 1] = MOST * np.float32(own[k]) + LEAST * np.float32(other[k]) - GREY
    blended[0], blended[columns + 1] = blended[1], blended[columns]
    if columns == shape[1]:
        for k in range(columns):
            spread[k] = blended[k + 1]
        return
    for k in range(columns):
        spread[2 * k] = MOST * blended[k + 1] + LEAST * blended[k]
        spread[2 * k + 1] = MOST * blended[k + 1] + LEAST * blended[k + 2]

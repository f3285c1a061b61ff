"""How the levels of a lit ball fall off towards its rim, and what pictures tell of that.

Towards its rim a lit ball darkens as the root of the depth inside, because its surface turns away. An edge
found where the levels change most is drawn inwards by that, on the bright side and the dark side differently.
Here the levels on each ray are

    outer (1 - C(u)) + inner (C(u) + shading T(u)),     u: distance from the rim, outwards

with C the share of ball in a blurred pixel and T the blurred sqrt(1 - r²/R²). Outer and inner level are free
on every ray, in brightness and in two colours; blur and shading are one `Limb` for all pictures of a ball.
Recordings keep less of colour than of brightness, and its edges are softer: it has a blur of its own. Where
the ball is darker than on average it faces away from the lamp and its light falls off less (Lambert's law):
shading is taken to be less there, by the third power of the levels' ratio. The place of the rim follows by
least squares, linearized about a circle found before (variable projection: Golub & Pereyra,
doi:10.1137/0710036).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.special import ndtr

from tracking.limb_kernel import compare_all
from tracking.patch import Patches
from tracking.rim_kernel import RAYS
from tracking.strands import side_by_side

FloatArray = npt.NDArray[np.float64]
LongArray = npt.NDArray[np.int64]
SingleArray = npt.NDArray[np.float32]

TWINS = 2  # rays side by side that make one of a rim's: they miss no pixel of a ball up to 60 px wide
SAMPLES = 16  # on a ray: as many as a processor multiplies at once
REACH_PX = 2.5  # from the rim, and half the way during the exposure
DEEPEST = 0.7  # radii
SMALL = 0.02  # difference for slopes
SLOPES = ("shift", "blur", "shading")
BESIDE_SLOPES = 5  # rows of factors: two levels, two shares, and shading · T
_SPREAD = (np.arange(TWINS) - (TWINS - 1) / 2) / TWINS
ANGLES: FloatArray = ((np.arange(RAYS)[:, None] + _SPREAD) * (2 * np.pi / RAYS)).ravel()
DIRECTIONS = np.column_stack((np.cos(ANGLES), np.sin(ANGLES)))
_SLANTS, _SLANT = np.unique(np.abs(DIRECTIONS[:, 1]).round(12), return_inverse=True)
"""How upright rays are, and which of that each is: four or more are alike."""
_DEPTHS = np.linspace(-6.0, 60.0, 3301)
_BELL = np.exp(-(np.linspace(-6.0, 6.0, 601) ** 2) / 2)
_ROOTS = np.array(
    [np.sqrt(np.maximum(depth + np.linspace(-6.0, 6.0, 601), 0.0)) @ _BELL / _BELL.sum() for depth in _DEPTHS]
)
"""Mean root of a depth that is blurred by one standard deviation."""


@dataclass(frozen=True, slots=True)
class Limb:
    """Blur of a ball's edge in brightness and in colour, standard deviations in px, and its shading.

    `shading` is the share by which its light rises inwards.
    """

    blur: float = 0.8
    colour_blur: float = 1.2
    shading: float = 0.3


class Look(NamedTuple):
    """What all rays say about rim (px outwards), blur and shading: least squares of their levels.

    `information` (n, 2, rays, kinds, kinds) and `pull` (n, 2, rays, kinds) of all three, or of the rim alone,
    by brightness and by colour; `variance` of the levels about the model (n, rays).
    """

    information: FloatArray
    pull: FloatArray
    variance: FloatArray

    @property
    def weights(self) -> FloatArray:
        """One over the variance, none better than the middle one of its picture: (n, rays)."""
        return np.asarray(1 / np.maximum(self.variance, np.median(self.variance, axis=1, keepdims=True)))


class Expected(NamedTuple):
    """What one limb should look like in some pictures, linearized: what to multiply the levels with.

    `way_of` (n,) is which of the ways up or down during the exposure belongs to each picture; `offsets`
    (ways, samples) are distances from the rim, px; all else is for brightness and for colour. `factors`
    (ways, 2, samples, 5 + 2 kinds, rays) give outer and inner level, the levels' share within the model, what
    is left along the slopes of either level's shape by rim, blur and shading, or by the rim alone, and last
    shading · T. `gram` (ways, 2, kinds², 3, rays) are the products of those slopes: of outer with outer
    level, of one with the other, of inner with inner. `lit` (ways, 2, 5 + 2 kinds, rays) are what the
    factors make of shading · T itself.
    """

    way_of: LongArray
    offsets: FloatArray
    factors: SingleArray
    gram: SingleArray
    lit: SingleArray

    def take(self, which: Sequence[int]) -> "Expected":
        """Give what some of the pictures should show."""
        return self._replace(way_of=self.way_of[np.asarray(which, dtype=np.int64)])


def look(patches: Patches, places: FloatArray, expected: Expected) -> Look:
    """Compare the levels along all rays with the model, linearized about the circles (n, 3) at `places`."""
    count, rays, kinds = len(patches), len(ANGLES), (expected.lit.shape[2] - BESIDE_SLOPES) // 2
    seen = Look(
        np.zeros((count, 2, rays, kinds, kinds)),
        np.zeros((count, 2, rays, kinds)),
        np.full((count, rays), np.inf),
    )
    pictures = patches.levels, patches.places
    written = seen.information, seen.pull, seen.variance
    rays_of = expected.way_of, DIRECTIONS, expected.offsets
    model = expected.factors, expected.gram, expected.lit
    side_by_side(partial(compare_all, pictures, places, (*rays_of, *model), written), count)
    return seen


def expect(limb: Limb, radius: float, blur: FloatArray, kinds: int = 1) -> Expected:
    """Make the model of a ball of some radius that goes some way up or down during each exposure, px."""
    ways, way_of = np.unique(np.round(blur), return_inverse=True)
    reach = np.minimum(REACH_PX + ways / 2, DEEPEST * radius)
    offsets = reach[:, None] * np.linspace(-1.0, 1.0, SAMPLES)
    smeared = ways[:, None, None] * _SLANTS[:, None] / np.sqrt(12)

    def shapes(width: float, shift: float = 0.0) -> FloatArray:
        ball, light = _shapes(offsets[:, None] - shift, np.hypot(width, smeared), radius)
        return np.stack((1 - ball, ball, light))

    both = [
        _linearized(
            shapes(width),
            (shapes(width, SMALL) - shapes(width, -SMALL)) / (2 * SMALL),
            (shapes(width + SMALL) - shapes(width - SMALL)) / (2 * SMALL),
            (limb.shading, kinds),
        )
        for width in (limb.blur, limb.colour_blur)
    ]
    factors, gram, lit = (np.stack(values, axis=1) for values in zip(*both, strict=True))
    return Expected(way_of.astype(np.int64), offsets, factors, gram, lit)


def _linearized(
    shapes: FloatArray, by_shift: FloatArray, by_blur: FloatArray, told: tuple[float, int]
) -> tuple[SingleArray, SingleArray, SingleArray]:
    """Make factors, gram and lit of one blur from 1 - C, C and T and their slopes by shift and by blur.

    Shapes and slopes are (3, ways, slants, samples); `told` are shading and kinds.
    """
    shading, kinds = told
    light = shading * shapes[2]
    by_shading = np.stack((np.zeros_like(light), shapes[2]))
    slopes = np.stack((*(_lit(slope, shading) for slope in (by_shift, by_blur)), by_shading)[:kinds])
    levels, share = _solved(_lit(shapes, shading))
    left = slopes - sum(own * np.sum(own * slopes, axis=-1, keepdims=True) for own in share)
    rows = np.concatenate((levels, share, left.reshape(2 * kinds, *light.shape), light[None]))
    lit = np.sum(rows * light, axis=-1)
    gram = np.einsum("keasn,lfasn->aklefs", left, left)
    gram = np.stack((gram[..., 0, 0, :], gram[..., 0, 1, :] + gram[..., 1, 0, :], gram[..., 1, 1, :]), axis=3)
    of_slants = (
        np.moveaxis(rows, (1, 3, 0, 2), (0, 1, 2, 3)),
        gram.reshape(len(gram), kinds**2, *gram.shape[3:]),
        np.moveaxis(lit, 1, 0),
    )
    factors, gram, lit = (np.take(values, _SLANT, axis=-1).astype(np.float32) for values in of_slants)
    return factors, gram, lit


def _lit(shapes: FloatArray, shading: float) -> FloatArray:
    """Shapes of outer and inner level from those of 1 - C, C and T, or from their slopes."""
    return np.stack((shapes[0], shapes[1] + shading * shapes[2]))


def _solved(shapes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Fit levels by two shapes (2, ..., samples): what to multiply them with, for least squares.

    The first two give how much there is of each shape, the others the levels' share within them, along two
    directions that are perpendicular (Gram and Schmidt).
    """
    first = shapes[0] / np.linalg.norm(shapes[0], axis=-1, keepdims=True)
    along = np.sum(first * shapes[1], axis=-1, keepdims=True)
    rest = shapes[1] - along * first
    length = np.linalg.norm(rest, axis=-1, keepdims=True)
    inner = rest / length**2
    outer = (first - along * inner) / np.linalg.norm(shapes[0], axis=-1, keepdims=True)
    return np.stack((outer, inner)), np.stack((first, rest / length))


def _shapes(offsets: FloatArray, width: FloatArray, radius: float) -> tuple[FloatArray, FloatArray]:
    """Give C, the share of ball in a pixel, and T, the root of the depth, blurred by some widths."""
    depth = -offsets / width
    bend = np.sqrt(1 - np.clip(-offsets, 0, radius) / (2 * radius))
    return ndtr(depth), np.sqrt(2 * width / radius) * np.interp(depth, _DEPTHS, _ROOTS) * bend

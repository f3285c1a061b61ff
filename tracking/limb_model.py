"""How the levels of a lit ball fall off towards its rim, and what pictures tell of that.

Towards its rim a lit ball darkens as the root of the depth inside, because its surface turns away. An edge
found where the levels change most is drawn inwards by that, on the bright side and the dark side differently.
Here the levels on each ray are

    outer (1 - C(u)) + inner (C(u) + shading T(u)),     u: distance from the rim, outwards

with C the share of ball in a blurred pixel and T the blurred sqrt(1 - r²/R²). Outer and inner level are free
on every ray and in every colour; blur and shading are one `Limb` for all pictures of a ball. Where the ball
is darker than on average it faces away from the lamp and its light falls off less (Lambert's law): shading is
taken to be less there, by the square of the levels' ratio. The place of the rim follows by least squares,
linearized about a circle found before (variable projection: Golub & Pereyra, doi:10.1137/0710036).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.special import ndtr

from tracking.limb_kernel import TOGETHER, compare
from tracking.patch import Patch, as_patch
from tracking.planes import Image
from tracking.rim_kernel import RAYS
from tracking.strands import side_by_side

FloatArray = npt.NDArray[np.float64]

TWINS = 2  # rays side by side that make one of a rim's: they miss no pixel of a ball up to 60 px wide
SAMPLES = 16  # on a ray: as many as a processor multiplies at once
REACH_PX = 2.5  # from the rim, and half the way during the exposure
DEEPEST = 0.7  # radii
SMALL = 0.02  # difference for slopes
SLOPES = ("shift", "blur", "shading")
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


@dataclass(frozen=True, slots=True, kw_only=True)
class Limb:
    """Blur of a ball's edge, standard deviation in px, and the share by which its light rises inwards."""

    blur: float = 0.8
    shading: float = 0.3


class Look(NamedTuple):
    """What all rays say about rim (px outwards), blur and shading: least squares of their levels.

    `information` (n, rays, kinds, kinds) and `pull` (n, rays, kinds) of all three, or of the rim alone;
    `variance` of the levels about the model (n, rays).
    """

    information: FloatArray
    pull: FloatArray
    variance: FloatArray

    @property
    def weights(self) -> FloatArray:
        """One over the variance, none better than the middle one of its picture: (n, rays)."""
        return np.asarray(1 / np.maximum(self.variance, np.median(self.variance, axis=1, keepdims=True)))


def look(
    images: Sequence[Image | Patch], places: FloatArray, blur: FloatArray, limb: Limb, kinds: int = 1
) -> Look:
    """Compare the levels along all rays with the model, linearized about the circles at `places`."""
    count = (len(images), len(ANGLES))
    seen = Look(np.empty((*count, kinds, kinds)), np.empty((*count, kinds)), np.empty(count))
    radius = float(np.median(places[:, 2])) if len(places) else 1.0
    ways = np.round(blur)
    models = {way: _model(limb, radius, way, kinds) for way in np.unique(ways).tolist()}

    def see(k: int) -> None:
        model, patch = models[float(ways[k])], as_patch(images[k])
        rays = places[k] - patch.corner, model.offsets, DIRECTIONS
        compare(patch.image, rays, model[1:], (seen.information[k], seen.pull[k], seen.variance[k]))

    side_by_side(see, len(images))
    return seen


class _Model(NamedTuple):
    """The model of one limb, linearized: what to multiply the levels on each ray with.

    `offsets` (samples,) are distances from the rim, px. `factors` (rays, samples, 5 + 2 kinds, and as many
    zeros as make it easier) give outer and inner level, the levels' share within the model, what is left along
    the slopes of either level's shape by rim, blur and shading, or by the rim alone, and last shading · T.
    `gram` (rays, 4, kinds²) are the products of those slopes, `lit` (rays, 5 + 2 kinds) are what the factors
    make of shading · T itself.
    """

    offsets: FloatArray
    factors: npt.NDArray[np.float32]
    gram: npt.NDArray[np.float32]
    lit: npt.NDArray[np.float32]


def _model(limb: Limb, radius: float, way: float, kinds: int) -> _Model:
    """Make the model of a ball of some radius that goes some way up or down during the exposure, px."""
    reach = min(REACH_PX + way / 2, DEEPEST * radius)
    offsets = np.linspace(-reach, reach, SAMPLES)
    smeared = way * _SLANTS[:, None] / np.sqrt(12)

    def basis(shift: float = 0.0, blur: float = 0.0, shading: float = 0.0) -> FloatArray:
        width = np.hypot(limb.blur + blur, smeared)
        return _shapes(offsets - shift, width, limb.shading + shading, radius)

    slopes = np.stack(
        [(basis(**{name: SMALL}) - basis(**{name: -SMALL})) / (2 * SMALL) for name in SLOPES[:kinds]],
        axis=1,
    )
    within, upper = np.linalg.qr(basis())
    left = slopes - (within @ np.swapaxes(within, 1, 2))[:, None] @ slopes
    flat = np.moveaxis(left, 2, 3).reshape(len(_SLANTS), -1, SAMPLES)
    across = np.swapaxes(within, 1, 2)
    light = basis()[..., 1] - basis(shading=-limb.shading)[..., 1]
    rows = np.concatenate((np.linalg.solve(upper, across), across, flat, light[:, None]), axis=1)
    lit = (rows @ light[..., None])[..., 0].astype(np.float32)
    factors = np.zeros((len(_SLANTS), SAMPLES, -(-rows.shape[1] // TOGETHER) * TOGETHER), dtype=np.float32)
    factors[..., : rows.shape[1]] = np.swapaxes(rows, 1, 2)
    gram = (flat @ np.swapaxes(flat, 1, 2)).reshape(-1, kinds, 2, kinds, 2)
    gram = gram.transpose(0, 2, 4, 1, 3).reshape(-1, 4, kinds**2).astype(np.float32)
    return _Model(offsets=offsets, factors=factors[_SLANT], gram=gram[_SLANT], lit=lit[_SLANT])


def _shapes(offsets: FloatArray, width: FloatArray, shading: float, radius: float) -> FloatArray:
    """Give what outer and inner level are multiplied with along each ray: (rays, samples, 2)."""
    depth = -offsets / width
    ball = ndtr(depth)
    bend = np.sqrt(1 - np.clip(-offsets, 0, radius) / (2 * radius))
    light = np.sqrt(2 * width / radius) * np.interp(depth, _DEPTHS, _ROOTS) * bend
    return np.stack((1 - ball, ball + shading * light), axis=-1)

"""The rim of a lit ball by a model of how its light falls off: no shading is taken for a part of the edge.

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

import cv2
import numpy as np
import numpy.typing as npt
from scipy.special import ndtr

from tracking.circle import RAYS, Circle, Rim, fit_circles
from tracking.planes import Image

FloatArray = npt.NDArray[np.float64]

TWINS = 2  # rays side by side that make one of a rim's: they miss no pixel of a ball up to 60 px wide
SAMPLES = 15  # on a ray
REACH_PX = 2.5  # from the rim, and half the way during the exposure
DEEPEST = 0.7  # radii
FURTHEST_PX = 1.0  # a rim is seen off the circle around which it is sought
PASSES = 2
MEASURING_STEPS = 5
LARGEST_STEP = 0.4
BLURS = (0.4, 3.0)
SHADINGS = (0.0, 1.0)  # compression alone looks like more
TOGETHER = 64  # pictures at a time: more would only need more memory
SMALL = 0.02  # difference for slopes
LEAST_LEFT = 1.0
SLOPES = ("shift", "blur", "shading")
COLOURS = 3
_SPREAD = (np.arange(TWINS) - (TWINS - 1) / 2) / TWINS
_ANGLES: FloatArray = ((np.arange(RAYS)[:, None] + _SPREAD) * (2 * np.pi / RAYS)).ravel()
_DIRECTIONS = np.column_stack((np.cos(_ANGLES), np.sin(_ANGLES)))
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


class _Look(NamedTuple):
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


def measure_limb(images: Sequence[Image], circles: Sequence[Circle], blur: FloatArray) -> Limb:
    """Measure blur and shading of a ball on some pictures, together with its place in each.

    Parameters
    ----------
    images : sequence of (height, width, 3) arrays
    circles : what was found in them
    blur : (n,) array
        Way of the ball up or down during the exposure, px.
    """
    places = np.array([(circle.x, circle.y, circle.radius) for circle in circles])
    shape = np.array([Limb().blur, Limb().shading])
    to_rim = np.column_stack((_DIRECTIONS, np.ones(len(_ANGLES))))
    for _ in range(MEASURING_STEPS):
        seen = _look(images, places, blur, Limb(blur=float(shape[0]), shading=float(shape[1])), len(SLOPES))
        weighed = seen.information * seen.weights[..., None, None]
        pull = seen.pull * seen.weights[..., None]
        own = np.einsum("ra,nr,rb->nab", to_rim, weighed[..., 0, 0], to_rim)
        mixed = np.einsum("ra,nrs->nas", to_rim, weighed[..., 0, 1:])
        towards = np.einsum("ra,nr->na", to_rim, pull[..., 0])
        without = np.swapaxes(np.linalg.solve(own, mixed), 1, 2)  # the pictures' own places eliminated
        shared = weighed[..., 1:, 1:].sum(axis=1) - without @ mixed
        right = pull[..., 1:].sum(axis=1) - np.einsum("nsa,na->ns", without, towards)
        step = np.linalg.solve(shared.sum(axis=0), right.sum(axis=0)).clip(-LARGEST_STEP, LARGEST_STEP)
        shape = np.clip(shape + step, *np.transpose((BLURS, SHADINGS)))
        places += np.linalg.solve(own, (towards - mixed @ step)[..., None])[..., 0].clip(-0.5, 0.5)
    return Limb(blur=float(shape[0]), shading=float(shape[1]))


def sharpen(
    images: Sequence[Image], circles: Sequence[Circle], blur: FloatArray, limb: Limb
) -> tuple[list[Rim], list[Circle | None]]:
    """See the rims of a ball again by its limb, from circles found before; and fit circles to them.

    Parameters
    ----------
    images : sequence of (height, width, 3) arrays
    circles : what was found in them, within a pixel or so
    blur : (n,) array
        Way of the ball up or down during the exposure, px.
    limb : as `measure_limb` gives it
    """
    rims: list[Rim] = []
    places = np.array([(circle.x, circle.y, circle.radius) for circle in circles]).reshape(-1, 3)
    fitted: list[Circle | None] = []
    for _ in range(PASSES):
        seen = _look(images, places, blur, limb)
        rims = _rims(seen, places, [circle.contrast for circle in circles])
        fitted = fit_circles(rims, places, free_radius=True)
        places = np.array(
            [p if c is None else (c.x, c.y, c.radius) for p, c in zip(places, fitted, strict=True)]
        ).reshape(-1, 3)
    return rims, fitted


def _rims(seen: _Look, places: FloatArray, contrasts: Sequence[float]) -> list[Rim]:
    """Join rays side by side, each counting as much as it knows."""
    apart = (len(places), RAYS, TWINS)
    known = (seen.information[..., 0, 0] * seen.weights).reshape(apart).sum(axis=2)
    pull = (seen.pull[..., 0] * seen.weights).reshape(apart).sum(axis=2)
    there = known > 0
    shift = np.divide(pull, known, out=np.full_like(pull, np.nan), where=there)
    middle = _DIRECTIONS.reshape(RAYS, TWINS, 2).mean(axis=1)
    directions = middle / np.linalg.norm(middle, axis=1, keepdims=True)
    distance = places[:, 2:] + shift.clip(-FURTHEST_PX, FURTHEST_PX)
    points = places[:, None, :2] + directions * distance[..., None]
    weights = known / np.maximum(known.sum(axis=1) / np.maximum(there.sum(axis=1), 1), 1e-12)[:, None]
    return [
        Rim(points=point, contrast=contrast, weights=weight)
        for point, contrast, weight in zip(points, contrasts, weights, strict=True)
    ]


def _look(images: Sequence[Image], places: FloatArray, blur: FloatArray, limb: Limb, kinds: int = 1) -> _Look:
    """Compare the levels along all rays with the model, linearized about the circles at `places`."""
    count = (len(images), len(_ANGLES))
    seen = _Look(np.zeros((*count, kinds, kinds)), np.zeros((*count, kinds)), np.full(count, np.inf))
    radius = float(np.median(places[:, 2])) if len(places) else 1.0
    ways = np.round(blur)
    for way in np.unique(ways):
        model = _model(limb, radius, float(way), kinds)
        members = np.flatnonzero(ways == way)
        for first in range(0, len(members), TOGETHER):
            some = members[first : first + TOGETHER]
            levels = np.array([_levels(images[i], places[i], model.offsets) for i in some])
            for whole, part in zip(seen, _compare(model, levels, kinds), strict=True):
                whole[some] = part
    return seen


class _Model(NamedTuple):
    """The model of one limb, linearized: what to multiply the levels on each ray with.

    `offsets` (samples,) are distances from the rim, px. `rows` (rays, 4 + 2 kinds, samples) give outer and
    inner level, the levels' share within the model, and what is left along the slopes of either level's shape
    by rim, blur and shading, or by the rim alone. `gram` (rays, 4, kinds²) are the products of those slopes.
    `light` (rays, samples) is shading · T.
    """

    offsets: FloatArray
    rows: npt.NDArray[np.float32]
    gram: npt.NDArray[np.float32]
    light: npt.NDArray[np.float32]


def _model(limb: Limb, radius: float, way: float, kinds: int) -> _Model:
    """Make the model of a ball of some radius that goes some way up or down during the exposure, px."""
    reach = min(REACH_PX + way / 2, DEEPEST * radius)
    offsets = np.linspace(-reach, reach, SAMPLES)
    smeared = way * np.abs(_DIRECTIONS[:, 1:]) / np.sqrt(12)

    def basis(shift: float = 0.0, blur: float = 0.0, shading: float = 0.0) -> FloatArray:
        width = np.hypot(limb.blur + blur, smeared)
        return _shapes(offsets - shift, width, limb.shading + shading, radius)

    slopes = np.stack(
        [(basis(**{name: SMALL}) - basis(**{name: -SMALL})) / (2 * SMALL) for name in SLOPES[:kinds]],
        axis=1,
    )
    within, upper = np.linalg.qr(basis())
    left = slopes - (within @ np.swapaxes(within, 1, 2))[:, None] @ slopes
    flat = np.moveaxis(left, 2, 3).reshape(len(_ANGLES), -1, SAMPLES)
    across = np.swapaxes(within, 1, 2)
    rows = np.concatenate((np.linalg.solve(upper, across), across, flat), axis=1).astype(np.float32)
    gram = (flat @ np.swapaxes(flat, 1, 2)).reshape(-1, kinds, 2, kinds, 2)
    gram = gram.transpose(0, 2, 4, 1, 3).reshape(-1, 4, kinds**2).astype(np.float32)
    light = (basis()[..., 1] - basis(shading=-limb.shading)[..., 1]).astype(np.float32)
    return _Model(offsets=offsets, rows=rows, gram=gram, light=light)


def _shapes(offsets: FloatArray, width: FloatArray, shading: float, radius: float) -> FloatArray:
    """Give what outer and inner level are multiplied with along each ray: (rays, samples, 2)."""
    depth = -offsets / width
    ball = ndtr(depth)
    bend = np.sqrt(1 - np.clip(-offsets, 0, radius) / (2 * radius))
    light = np.sqrt(2 * width / radius) * np.interp(depth, _DEPTHS, _ROOTS) * bend
    return np.stack((1 - ball, ball + shading * light), axis=-1)


def _levels(image: Image, place: FloatArray, offsets: FloatArray) -> npt.NDArray[np.float32]:
    """Levels (rays, samples, colours) along the rays of one circle; NaN on rays that leave the picture."""
    distances = place[2] + offsets
    x, y = ((place[axis] + _DIRECTIONS[:, axis, None] * distances).astype(np.float32) for axis in (0, 1))
    levels = cv2.remap(image, x, y, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE).astype(np.float32)
    height, width = image.shape[:2]
    levels[((x < 0) | (y < 0) | (x > width - 1) | (y > height - 1)).any(axis=1)] = np.nan
    return levels


def _compare(model: _Model, levels: npt.NDArray[np.float32], kinds: int) -> _Look:
    """Compare levels (n, rays, samples, colours) with the model."""
    inside = np.isfinite(levels[:, :, 0, 0])
    levels = np.where(inside[..., None, None], levels, np.float32(0))
    inner = (model.rows[:, 1:2] @ levels)[:, :, 0]
    facing = np.clip(inner / np.maximum(inner.mean(axis=1, keepdims=True), 1), 0, 1) ** 2
    levels = levels + (inner * (1 - facing))[:, :, None] * model.light[..., None]
    products = model.rows @ levels
    ends, share = products[:, :, :2], products[:, :, 2:4]
    along = products[:, :, 4:].reshape(*products.shape[:2], kinds, 2, COLOURS)
    pairs = (ends @ np.swapaxes(ends, 2, 3)).reshape(*products.shape[:2], 1, 4)
    left = np.einsum("nrsc,nrsc->nr", levels, levels) - np.einsum("nrsc,nrsc->nr", share, share)
    variance = np.maximum(left, LEAST_LEFT) / (COLOURS * (SAMPLES - 2))
    return _Look(
        information=(pairs @ model.gram).reshape(*products.shape[:2], kinds, kinds),
        pull=(ends[:, :, None] * along).sum(axis=(3, 4)),
        variance=np.where(inside, variance, np.inf),
    )

"""The rim of a lit ball by its limb: blur and shading are measured, and no shading is taken for an edge.

An edge found where the levels change most is drawn towards the lit side by a tenth of a pixel and more.
"""

from collections.abc import Sequence
from math import hypot

import numpy as np
import numpy.typing as npt

from tracking.circle import Circle, Rim, fit_circles, places_of
from tracking.limb_model import ANGLES, DIRECTIONS, SLOPES, TWINS, Expected, Limb, Look, expect, look
from tracking.patch import Patch, Patches, laid_out
from tracking.planes import Image
from tracking.rim_kernel import RAYS

__all__ = ["Limb", "measure_limb", "sharpen"]

FloatArray = npt.NDArray[np.float64]

FURTHEST_PX = 1.0  # a rim is seen off the circle around which it is sought
SETTLED_PX = 0.1  # a circle that the limb moves or widens by more is looked at again,
LOOKS = 5  # ... so often in all
FEW = 16  # pictures that tell how far light moves the edges in most of them
MEASURING_STEPS = 4
LARGEST_STEP = 0.4
BLURS = (0.4, 3.0)
SHADINGS = (0.0, 0.85)  # compression alone looks like more
OF_BRIGHTNESS, OF_COLOUR = (0, 1, 3), (0, 2, 3)  # which of rim, two blurs and shading either tells
LEAST_KNOWN = 1e-3  # of all that is known: a grey ball tells nothing of the blur of colour


def measure_limb(
    images: Sequence[Image | Patch] | Patches, circles: Sequence[Circle], blur: FloatArray
) -> Limb:
    """Measure blur and shading of a ball on some pictures, together with its place in each.

    Parameters
    ----------
    images : sequence of (height, width, 3) arrays, or of patches
    circles : what was found in them
    blur : (n,) array
        Way of the ball up or down during the exposure, px.
    """
    patches, places = laid_out(images), places_of(circles)
    shape = np.array([Limb().blur, Limb().colour_blur, Limb().shading])
    to_rim = np.column_stack((DIRECTIONS, np.ones(len(ANGLES))))
    for _ in range(MEASURING_STEPS):
        expected = expect(Limb(*shape.tolist()), float(np.median(places[:, 2])), blur, len(SLOPES))
        weighed, pull = _told(look(patches, places, expected))
        own = np.einsum("ra,nr,rb->nab", to_rim, weighed[..., 0, 0], to_rim)
        mixed = np.einsum("ra,nrs->nas", to_rim, weighed[..., 0, 1:])
        towards = np.einsum("ra,nr->na", to_rim, pull[..., 0])
        without = np.swapaxes(np.linalg.solve(own, mixed), 1, 2)  # the pictures' own places eliminated
        shared = (weighed[..., 1:, 1:].sum(axis=1) - without @ mixed).sum(axis=0)
        right = pull[..., 1:].sum(axis=1) - np.einsum("nsa,na->ns", without, towards)
        shared += LEAST_KNOWN * np.trace(shared) * np.eye(len(shape))
        step = np.linalg.solve(shared, right.sum(axis=0)).clip(-LARGEST_STEP, LARGEST_STEP)
        shape = np.clip(shape + step, *np.transpose((BLURS, BLURS, SHADINGS)))
        places += np.linalg.solve(own, (towards - mixed @ step)[..., None])[..., 0].clip(-0.5, 0.5)
    return Limb(*shape.tolist())


def _told(seen: Look) -> tuple[FloatArray, FloatArray]:
    """Weigh what rays tell of rim, both blurs and shading: information (n, rays, 4, 4), pull (n, rays, 4)."""
    shape = (*seen.weights.shape, 4)
    information, pull = np.zeros((*shape, 4)), np.zeros(shape)
    for kind, own in enumerate((OF_BRIGHTNESS, OF_COLOUR)):
        information[..., np.array(own)[:, None], own] += seen.information[:, kind]
        pull[..., own] += seen.pull[:, kind]
    return information * seen.weights[..., None, None], pull * seen.weights[..., None]


def sharpen(
    images: Sequence[Image | Patch] | Patches,
    circles: Sequence[Circle],
    blur: FloatArray,
    limb: Limb,
    *,
    free_radius: bool = True,
) -> tuple[list[Rim], list[Circle | None]]:
    """See the rims of a ball again by its limb, from circles found before; and fit circles to them.

    Parameters
    ----------
    images : sequence of (height, width, 3) arrays, or of patches
    circles : what was found in them, within a pixel or so
    blur : (n,) array
        Way of the ball up or down during the exposure, px.
    limb : as `measure_limb` gives it
    free_radius : bool
        Whether the circles may become larger or smaller.
    """
    patches, places = laid_out(images), places_of(circles)
    expected = expect(limb, float(np.median(places[:, 2])) if len(places) else 1.0, blur)
    if free_radius:
        places = _nearer(patches, places, expected)
    rims, fitted = _once(patches, places, expected, free_radius)
    for _ in range(LOOKS - 1):
        again = [
            (i, then)
            for i, then in enumerate(fitted)
            if then is not None and _moved(places[i].tolist(), then)
        ]
        if not again:
            break
        which = [i for i, _ in again]
        places[which] = places_of([then for _, then in again])
        seen = _once(patches.take(which), places[which], expected.take(which), free_radius)
        for i, rim, circle in zip(which, *seen, strict=True):
            rims[i], fitted[i] = rim, circle
    return rims, fitted


def _nearer(patches: Patches, places: FloatArray, expected: Expected) -> FloatArray:
    """Move all circles, if they are many, by what the limb moves some of them.

    Light moves edges in most pictures alike.
    """
    if len(places) <= FEW:
        return places
    some = np.unique(np.linspace(0, len(places) - 1, FEW).astype(int)).tolist()
    _, fitted = _once(patches.take(some), places[some], expected.take(some), True)
    found = [(i, then) for i, then in zip(some, fitted, strict=True) if then is not None]
    if not found:
        return places
    ways = places_of([then for _, then in found]) - places[[i for i, _ in found]]
    return np.asarray(places + np.median(ways, axis=0))


def _moved(before: Sequence[float], then: Circle) -> bool:
    """Whether a circle is another one."""
    x, y, radius = before
    return hypot(then.x - x, then.y - y) + abs(then.radius - radius) > SETTLED_PX


def _once(
    patches: Patches, places: FloatArray, expected: Expected, free_radius: bool
) -> tuple[list[Rim], list[Circle | None]]:
    """See the rims about the circles at some places, and fit circles to them."""
    rims = _rims(look(patches, places, expected), places)
    return rims, fit_circles(rims, places, free_radius=free_radius)


def _rims(seen: Look, places: FloatArray) -> list[Rim]:
    """Join rays side by side, each counting as much as it knows."""
    apart = (len(places), RAYS, TWINS)
    known = (seen.information[..., 0, 0].sum(axis=1) * seen.weights).reshape(apart).sum(axis=2)
    pull = (seen.pull[..., 0].sum(axis=1) * seen.weights).reshape(apart).sum(axis=2)
    there = known > 0
    shift = np.divide(pull, known, out=np.full_like(pull, np.nan), where=there)
    middle = DIRECTIONS.reshape(RAYS, TWINS, 2).mean(axis=1)
    directions = middle / np.linalg.norm(middle, axis=1, keepdims=True)
    distance = places[:, 2:] + shift.clip(-FURTHEST_PX, FURTHEST_PX)
    points = places[:, None, :2] + directions * distance[..., None]
    weights = known / np.maximum(known.sum(axis=1) / np.maximum(there.sum(axis=1), 1), 1e-12)[:, None]
    return [Rim(points=point, weights=weight) for point, weight in zip(points, weights, strict=True)]

"""A ball seen by its edges → seen by its limb: no shading shifts it."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tracking.limb import Limb, measure_limb, sharpen
from tracking.sighting import Cutting, Sighting

FURTHEST_PX = 1.5  # a limb that moves a circle by more is not the ball's


def limb_of(cuttings: Sequence[Cutting], seen: Sequence[Sighting]) -> Limb:
    """Measure a ball's limb where it is seen in some cuttings; a usual one if it is nowhere."""
    around = {cutting.frame: cutting for cutting in cuttings}
    if not seen:
        return Limb()
    return measure_limb(
        [around[sighting.frame].image for sighting in seen],
        [_placed(sighting, around[sighting.frame], -1).circle for sighting in seen],
        np.array([sighting.blur for sighting in seen]),
    )


def sharpened(cuttings: Sequence[Cutting], seen: Sequence[Sighting], limb: Limb) -> list[Sighting]:
    """See a ball by its limb wherever it was seen by its edges, which are believed where it has none."""
    around = {cutting.frame: cutting for cutting in cuttings}
    inside = [_placed(sighting, around[sighting.frame], -1) for sighting in seen]
    rims, circles = sharpen(
        [around[sighting.frame].image for sighting in seen],
        [sighting.circle for sighting in inside],
        np.array([sighting.blur for sighting in seen]),
        limb,
    )
    found = []
    for before, rim, circle in zip(inside, rims, circles, strict=True):
        if circle is not None:
            shift = (circle.x - before.circle.x, circle.y - before.circle.y)
            if np.hypot(*shift) < FURTHEST_PX:
                found.append(replace(before, rim=rim, circle=circle, shading=shift))
                continue
        found.append(before)
    return [_placed(sighting, around[sighting.frame], 1) for sighting in found]


def _placed(sighting: Sighting, cutting: Cutting, sign: int) -> Sighting:
    """Move what was found from its cutting to the picture (sign 1), or back (sign -1)."""
    left, top = cutting.corner
    rim, circle = sighting.rim, sighting.circle
    return replace(
        sighting,
        rim=replace(rim, points=rim.points + sign * np.array(cutting.corner)),
        circle=replace(circle, x=circle.x + sign * left, y=circle.y + sign * top),
    )

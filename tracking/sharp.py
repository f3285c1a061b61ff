"""A ball seen by its edges → seen by its limb: no shading shifts it."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tracking.limb import Limb, measure_limb, sharpen
from tracking.sighting import Cutting, Sighting

FURTHEST_PX = 1.5  # a limb that moves a circle by more is not the ball's,
FURTHEST = 0.1  # ... nor one that does by this share of its radius, if that is more


def limb_of(cuttings: Sequence[Cutting], seen: Sequence[Sighting]) -> Limb:
    """Measure a ball's limb where it is seen in some cuttings; a usual one if it is nowhere."""
    around = {cutting.frame: cutting.patch for cutting in cuttings}
    if not seen:
        return Limb()
    return measure_limb(
        [around[sighting.frame] for sighting in seen],
        [sighting.circle for sighting in seen],
        np.array([sighting.blur for sighting in seen]),
    )


def sharpened(cuttings: Sequence[Cutting], seen: Sequence[Sighting], limb: Limb) -> list[Sighting]:
    """See a ball by its limb wherever it was seen by its edges, which are believed where it has none."""
    around = {cutting.frame: cutting.patch for cutting in cuttings}
    rims, circles = sharpen(
        [around[sighting.frame] for sighting in seen],
        [sighting.circle for sighting in seen],
        np.array([sighting.blur for sighting in seen]),
        limb,
    )
    found = []
    for before, rim, circle in zip(seen, rims, circles, strict=True):
        if circle is not None:
            shift = (circle.x - before.circle.x, circle.y - before.circle.y)
            if np.hypot(*shift) < max(FURTHEST_PX, FURTHEST * circle.radius):
                found.append(replace(before, rim=rim, circle=circle, shading=shift))
                continue
        found.append(before)
    return found

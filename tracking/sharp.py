"""A ball seen by its edges → seen by its limb: no shading shifts it."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from tracking.circle import Circle
from tracking.limb import Limb, measure_limb, sharpen
from tracking.patch import Patches
from tracking.sighting import Cuttings, Sighting

FURTHEST_PX = 1.5  # a limb that moves a circle by more is not the ball's,
FURTHEST = 0.1  # ... nor one that does by this share of its radius, if that is more


def limb_of(cuttings: Cuttings, seen: Sequence[Sighting]) -> Limb:
    """Measure a ball's limb where it is seen in some cuttings; a usual one if it is nowhere, or cut off."""
    try:
        return measure_limb(*_looked_at(cuttings, seen)) if seen else Limb()
    except np.linalg.LinAlgError:  # the picture's border leaves too little of it
        return Limb()


def sharpened(
    cuttings: Cuttings, seen: Sequence[Sighting], limb: Limb, *, free_radius: bool = True
) -> list[Sighting]:
    """See a ball by its limb wherever it was seen by its edges, which are believed where it has none."""
    rims, circles = sharpen(*_looked_at(cuttings, seen), limb, free_radius=free_radius)
    found = []
    for before, rim, circle in zip(seen, rims, circles, strict=True):
        if circle is not None:
            shift = (circle.x - before.circle.x, circle.y - before.circle.y)
            if np.hypot(*shift) < max(FURTHEST_PX, FURTHEST * circle.radius):
                found.append(replace(before, rim=rim, circle=circle, shading=shift))
                continue
        found.append(before)
    return found


def _looked_at(
    cuttings: Cuttings, seen: Sequence[Sighting]
) -> tuple[Patches, list[Circle], npt.NDArray[np.float64]]:
    """Patches in which a ball was seen, its circles there, and its ways during the exposure."""
    number = {frame: i for i, frame in enumerate(cuttings.frames)}
    patches = cuttings.patches.take([number[sighting.frame] for sighting in seen])
    return patches, [sighting.circle for sighting in seen], np.array([sighting.blur for sighting in seen])

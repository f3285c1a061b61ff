"""How exactly balls are located, on freshly rendered recordings with known truth: centres and their sd."""

from collections.abc import Iterator, Sequence

import numpy as np

from experiments.bench import Measured
from experiments.bench_bound import centre_bounds
from experiments.bench_clips import Filmed, film, pulled, root_mean_square
from tracking.render import Camera, DropScene

RADII_PX = (8, 15, 30)
RULER_PX = 140  # of the width, so that the ruler does not stand behind the ball
SEEDS = (20_081, 20_082, 20_083, 20_084)  # walls, lights and noises; no test films these
MORE_SEEDS = range(20_081, 20_093)  # compression errs by walls and lights, each time alike: many are asked
CRF = 23
EVERY = 8  # frame is bounded: neighbours hardly differ


def centres() -> Iterator[Measured]:
    """Locate balls in pictures as they are and compressed; the truth is the centre at mid-exposure."""
    exact: list[Filmed] = []
    compressed: list[Filmed] = []
    for radius in RADII_PX:
        flat = [film(drop(radius, seed, shading=0.0), None) for seed in SEEDS]
        yield Measured(
            quantity=f"centre over Cramér-Rao bound (x, y free), R = {radius} px",
            value=over_bound(flat),
            unit="",
            most=2,
        )
        exact += flat
    for radius in RADII_PX:
        shaded = [film(drop(radius, seed), None) for seed in SEEDS]
        yield Measured(
            quantity=f"centre moved by a dark lower limb, R = {radius} px",
            value=max(float(np.hypot(*filmed.errors.mean(axis=0))) for filmed in shaded),
            unit="px",
            most=0.05,
        )
        exact += shaded
    for radius in RADII_PX:
        seen = [film(drop(radius, seed), CRF) for seed in MORE_SEEDS]
        yield Measured(
            quantity=f"centre, RMS error, H.264 crf {CRF}, R = {radius} px",
            value=root_mean_square(np.concatenate([filmed.errors for filmed in seen])),
            unit="px",
            most=0.1,
        )
        compressed += seen
    yield from pulls("not compressed", exact)
    yield from pulls("H.264", compressed)


def drop(radius: int, seed: int, shading: float = 1.0) -> DropScene:
    """Let a ball of a radius in px fall on the plate, before a wall that the seed chooses."""
    return DropScene(
        kind="plate",
        drop_height=7.5 * 0.02,
        after=0.15,
        shading=shading,
        camera=Camera(metres_per_pixel=0.02 / radius, width_px=RULER_PX + 6 * radius, flicker=0.0),
        seed=seed,
    )


def over_bound(clips: Sequence[Filmed]) -> float:
    """Root mean square error of the centres in units of what no unbiased estimate can beat."""
    errors, bounds = [], []
    for filmed in clips:
        frames = filmed.track.frame[filmed.flying][::EVERY]
        errors.append(filmed.errors)
        bounds.append(centre_bounds(filmed.scene, frames))
    return root_mean_square(np.concatenate(errors)) / root_mean_square(np.concatenate(bounds))


def pulls(kind: str, clips: Sequence[Filmed]) -> Iterator[Measured]:
    """Compare errors of all centres with their stated standard deviations."""
    yield Measured(
        quantity=f"variance of pulls of centres, {kind}",
        value=pulled([filmed.errors for filmed in clips], [filmed.sd for filmed in clips]),
        unit="",
        least=0.8,
        most=1.2,
    )

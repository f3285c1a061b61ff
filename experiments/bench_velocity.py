"""How exact times, velocities and restitution are, on freshly rendered recordings with known truth."""

import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from experiments.bench import Measured
from experiments.bench_clips import film, first_impact
from tracking.render import Camera, DropScene, write_recording
from tracking.render_motion import play
from tracking.render_stage import frame_times
from tracking.video import open_recording

FloatArray = npt.NDArray[np.float64]

REPEATS = 24  # so many that the standard error is small against what is wanted
WANTED = {240: 0.1, 60: 0.3}  # per cent of a velocity, by frames/s
CRF = 23
READOUT = 0.004  # s
SHUTTER_REPEATS = 8
MILLISECOND = 1e-3
CLOSE = Camera(width_px=160, metres_per_pixel=0.02 / 15)


def velocities() -> Iterator[Measured]:
    """Measure the first impact of many drops: mean error of the velocities, and whether their sd are true."""
    pulls = []
    for fps, wanted in WANTED.items():
        measured = [
            first_impact(film(drop(number, replace(CLOSE, fps=fps)), CRF))
            for number in range(fps, fps + REPEATS)
        ]
        shares = np.array([impact.velocities[:2] / truth - 1 for impact, truth in measured])
        pulls += [(impact.velocities[:2] - truth) / impact.sd[:2] for impact, truth in measured]
        for name, share in zip(("approach", "rebound"), shares.T, strict=True):
            yield biased(f"{name} velocity, bias, {fps} frames/s", share, wanted)
    yield Measured(
        quantity="variance of pulls of velocities",
        value=float(np.mean(np.square(pulls))),
        unit="",
        least=0.8,
        most=1.2,
    )


def times() -> Iterator[Measured]:
    """Read the time stamps of a recording whose frames come at uneven intervals, as telephones make them."""
    scene = drop(0, Camera(width_px=120, metres_per_pixel=0.002, jitter=0.3))
    with tempfile.TemporaryDirectory() as folder:
        clip = Path(folder) / "uneven.mp4"
        write_recording(scene, clip, crf=CRF)
        late = open_recording(clip).times - frame_times(scene, play(scene))
    yield Measured(
        quantity="time stamps at a variable frame rate, largest error",
        value=float(np.abs(late).max()) / MILLISECOND,
        unit="ms",
        most=0.01,
    )


def shutter() -> Iterator[Measured]:
    """Measure the restitution of drops seen by a rolling shutter, its readout told."""
    shares = []
    for number in range(SHUTTER_REPEATS):
        filmed = film(drop(1000 + number, replace(CLOSE, readout=READOUT)), None)
        impact, truth = first_impact(filmed, READOUT)
        measured, true = (-after / before for before, after in (impact.velocities[:2], truth))
        shares.append(measured / true - 1)
    yield biased("restitution, 4 ms rolling shutter, bias", np.array(shares), 0.1)


def drop(number: int, camera: Camera) -> DropScene:
    """Give one of many drops, each with its own height, restitution and moment of release."""
    rng = np.random.default_rng((2008, number))
    return DropScene(
        kind="plate",
        drop_height=rng.uniform(0.25, 0.4),
        restitution_plate=rng.uniform(0.7, 0.9),
        hold=0.05 + rng.uniform(0, 0.03),
        after=0.2,
        camera=camera,
        seed=30_000 + number,
    )


def biased(quantity: str, shares: FloatArray, most: float) -> Measured:
    """Mean of relative errors in per cent, and beside it its standard error."""
    percent = 100 * shares
    error = float(percent.std(ddof=1) / np.sqrt(len(percent)))
    return Measured(
        quantity=f"{quantity} (± {error:.2g})", value=abs(float(percent.mean())), unit="%", most=most
    )

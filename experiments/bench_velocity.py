"""How exact times, velocities and restitution are, on freshly rendered recordings with known truth."""

import tempfile
from collections.abc import Iterator, Sequence
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

REPEATS = {240: 24, 60: 24}  # frames/s; so many that the standard error is small against what is wanted
WANTED_BIAS = {240: 0.1, 60: 0.3}  # per cent
CRF = 23
READOUT = 0.004  # s
SHUTTER_REPEATS = 12
MILLISECOND = 1e-3


def velocities() -> Iterator[Measured]:
    """Measure the first impact of many drops: mean error of the velocities, and whether their sd are true."""
    pulls = []
    for fps, repeats in REPEATS.items():
        measured = [first_impact(film(drop(fps, number), CRF)) for number in range(repeats)]
        shares = np.array([impact.velocities[:2] / truth - 1 for impact, truth in measured])
        pulls += [(impact.velocities[:2] - truth) / impact.sd[:2] for impact, truth in measured]
        for name, share in zip(("approach", "rebound"), shares.T, strict=True):
            yield biased(f"{name} velocity, bias, {fps} frames/s", share, WANTED_BIAS[fps])
    yield Measured(
        quantity="velocities' mean squared error over variance",
        value=float(np.mean(np.square(pulls))),
        unit="",
        least=0.8,
        most=1.2,
    )


def times() -> Iterator[Measured]:
    """Read the time stamps of a recording whose frames come at uneven intervals, as telephones make them."""
    scene = drop(240, 0, Camera(width_px=120, metres_per_pixel=0.002, jitter=0.3))
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
        filmed = film(drop(240, 1000 + number, Camera(**CLOSE, readout=READOUT)), None)
        impact, truth = first_impact(filmed, READOUT)
        measured, true = (-after / before for before, after in (impact.velocities[:2], truth))
        shares.append(measured / true - 1)
    yield biased("restitution, rolling shutter of 4 ms corrected", np.array(shares), 0.1)


CLOSE = {"width_px": 160, "metres_per_pixel": 0.02 / 15}


def drop(fps: int, number: int, camera: Camera | None = None) -> DropScene:
    """One of many drops: height, restitution and the moment of release differ from one to the next."""
    rng = np.random.default_rng((fps, number))
    return DropScene(
        kind="plate",
        drop_height=rng.uniform(0.25, 0.4),
        restitution_plate=rng.uniform(0.7, 0.9),
        hold=0.05 + rng.uniform(0, 0.03),
        after=0.2,
        camera=camera or Camera(**CLOSE, fps=fps),
        seed=30_000 + 100 * fps + number,
    )


def biased(quantity: str, shares: FloatArray, most: float) -> Measured:
    """Mean of relative errors in per cent, and beside it its standard error."""
    percent = 100 * shares
    error = float(percent.std(ddof=1) / np.sqrt(len(percent)))
    return Measured(quantity=f"{quantity} (± {error:.2g})", value=abs(float(percent.mean())), unit="%", most=most)

"""The whole job on an experiment whose truth is known: film it, measure it, fit it, draw Fig. 5."""

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from joblib import Parallel, delayed

from calibrate.estimate import Calibration
from calibrate.files import write_whole
from experiments import paper
from impact import Ball, Contact, TwoBallDrop, collide
from tracking.render import Camera, DropScene, write_recording

BALL_MASS = 0.0027
BALL_RADIUS = 0.020
CAMERA = Camera(fps=240, metres_per_pixel=0.001, width_px=240)
DROPS = {"plate": (0.16, 0.26, 0.40), "held": (0.16, 0.26, 0.40)}
TWO_BALL_DROPS = {1.0: (0.15, 0.22, 0.30, 0.42), 2.0: (0.15, 0.22, 0.30, 0.42)}  # heights by mass ratio

# what no experimenter can hold constant: hits a little off centre, seams, dust
RESTITUTION_SCATTER = 0.004
UPPER_SCATTER = 0.004  # of the velocity
LOWER_SCATTER = 0.01  # of the velocity


@dataclass(frozen=True, slots=True, kw_only=True)
class Truth:
    """What the rendered balls obey; the fit must find it again."""

    restitution_ball_ball: float = paper.BALL_BALL.mean
    restitution_ball_table: float = paper.BALL_TABLE.mean
    stiffness_ratio: float = paper.STIFFNESS_RATIO


def design(truth: Truth, rng: np.random.Generator) -> Iterator[tuple[str, DropScene]]:
    """List the recordings of the experiment: name and scene, each trial with its own small scatter."""
    number = 0
    for kind in ("plate", "held"):
        for height in DROPS[kind]:
            yield f"{kind}-{number:02d}", _one_ball(kind, height, truth, rng)
            number += 1
    for mass_ratio, heights in TWO_BALL_DROPS.items():
        for height in heights:
            yield f"two-{number:02d}", _two_balls(mass_ratio, height, truth, rng)
            number += 1


def _one_ball(
    kind: Literal["plate", "held"], height: float, truth: Truth, rng: np.random.Generator
) -> DropScene:
    """Drop a ball on the plate, or on a ball held still."""
    ball_ball, ball_table = RESTITUTION_SCATTER * rng.standard_normal(2)
    return DropScene(
        kind=kind,
        drop_height=height,
        masses=(BALL_MASS, BALL_MASS),
        radii=(BALL_RADIUS, BALL_RADIUS),
        restitution_balls=truth.restitution_ball_ball + ball_ball,
        restitution_plate=truth.restitution_ball_table + ball_table,
        camera=CAMERA,
        after=0.17,
        seed=int(rng.integers(2**31)),
    )


def _two_balls(mass_ratio: float, height: float, truth: Truth, rng: np.random.Generator) -> DropScene:
    """Drop a ball on a ball at rest; the impact model says what comes of it."""
    masses = (mass_ratio * BALL_MASS, BALL_MASS)
    after = collide(two_ball_drop(truth, masses)).velocities  # the approach has unit speed: Theorem 4
    scatter = 1 + np.array([UPPER_SCATTER, LOWER_SCATTER]) * rng.standard_normal(2)
    upper, lower = after * scatter
    return DropScene(
        kind="two",
        drop_height=height,
        masses=masses,
        radii=(BALL_RADIUS, BALL_RADIUS),
        restitution_balls=truth.restitution_ball_ball,
        restitution_plate=truth.restitution_ball_table,
        first_rebound=(float(upper), float(lower)),
        camera=CAMERA,
        after=0.17,
        seed=int(rng.integers(2**31)),
    )


def two_ball_drop(truth: Truth, masses: tuple[float, float]) -> TwoBallDrop:
    """Give the model's side of a two-ball trial, upper ball at unit speed."""
    return TwoBallDrop(
        upper=Ball(mass=masses[0], radius=BALL_RADIUS),
        lower=Ball(mass=masses[1], radius=BALL_RADIUS),
        ball_ball=Contact(restitution=truth.restitution_ball_ball, stiffness=1.0),
        ball_table=Contact(restitution=truth.restitution_ball_table, stiffness=truth.stiffness_ratio),
        approach_velocity=-1.0,
    )


def film(out: Path, *, seed: int, workers: int, truth: Truth | None = None) -> Iterator[str]:
    """Render videos, their truth and an experiment.toml into `out`; yield each name when it is done."""
    truth = truth or Truth()
    scenes = dict(design(truth, np.random.default_rng(seed)))
    out = out.resolve()  # processes that are kept for another run may work in another folder
    out.mkdir(parents=True, exist_ok=True)
    parallel = Parallel(n_jobs=workers, return_as="generator")
    jobs = (delayed(write_recording)(scene, out / f"{name}.mp4") for name, scene in scenes.items())
    for name, _ in zip(scenes, parallel(jobs), strict=True):
        yield name
    write_whole(out / "experiment.toml", experiment_file(scenes))
    told = {name: getattr(truth, name) for name in truth.__slots__}
    write_whole(out / "truth.json", json.dumps({**told, "seed": seed}, indent=1) + "\n")


def recordings() -> int:
    """Count the recordings of the experiment."""
    return sum(map(len, DROPS.values())) + sum(map(len, TWO_BALL_DROPS.values()))


def fitted_against_truth(calibration: Calibration, truth: Truth) -> str:
    """One line a parameter: fitted, true, and whether the 95 % set holds the truth."""
    lines = [f"{'':<24} {'fitted':>10} {'truth':>10} {'error':>9}  95 % set"]
    for name in truth.__slots__:
        estimate, true = getattr(calibration, name), getattr(truth, name)
        inside = any(low <= true <= high for low, high in estimate.intervals_95)
        value, error = "several", ""
        if estimate.value is not None:
            value, error = f"{estimate.value:.5g}", f"{100 * (estimate.value / true - 1):+.2f} %"
        held = "holds the truth" if inside else "MISSES the truth"
        lines.append(f"{name.replace('_', ' '):<24} {value:>10} {true:>10.5g} {error:>9}  {held}")
    return "\n".join(lines)


def experiment_file(scenes: dict[str, DropScene]) -> str:
    """Write down what an experimenter would: scale, balls, and what each recording shows."""
    diameter = 2 * BALL_RADIUS
    lines = [
        'name = "the demo: two balls on a plate"',
        "[camera]",
        f"scale = {{ metres_per_pixel = {CAMERA.metres_per_pixel} }}",
        "[bodies]",
        f"upper = {{ mass = {BALL_MASS}, diameter = {diameter} }}",
        f"lower = {{ mass = {BALL_MASS}, diameter = {diameter} }}",
    ]
    for name, scene in scenes.items():
        lines += ["[[trial]]", f'video = "{name}.mp4"', f'kind = "{scene.kind}"']
        if scene.masses[0] != BALL_MASS:
            lines.append(f"upper = {{ mass = {scene.masses[0]}, diameter = {diameter} }}")
    return "\n".join(lines) + "\n"

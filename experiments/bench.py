"""How fast and how exact the rooms are on this machine: every figure beside the figure that is wanted."""

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from calibrate.bootstrap import bootstrap
from calibrate.fit import fit_stiffness_ratio
from calibrate.simulate import Design, simulate_trials
from experiments.aim import struck_normal
from experiments.coverage import TRUTH
from experiments.paper import FIG5_DROP, SHOT_BALL
from impact import Contact, Cue, CueShot, collide, collide_many

Array = NDArray[np.float64]

CASES = 10_000
REFITS = 50
REPEATS = 5  # the fastest counts: what disturbs a program only ever makes it slower
FIRST_CALL = """
import time
from experiments.paper import FIG5_DROP
from impact import collide
start = time.process_time()
collide(FIG5_DROP)
print(time.process_time() - start)
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Measured:
    """One figure of a benchmark: what, how much, and the most and least that are wanted."""

    quantity: str
    value: float
    unit: str
    most: float | None = None
    least: float | None = None

    @property
    def met(self) -> bool:
        """Whether the figure is as wanted."""
        return (self.most is None or self.value <= self.most) and (
            self.least is None or self.value >= self.least
        )

    @property
    def wanted(self) -> str:
        """What is wanted, as it is printed."""
        if self.least is None:
            return "" if self.most is None else f"≤ {self.most:g}"
        return f"≥ {self.least:g}" if self.most is None else f"{self.least:g} … {self.most:g}"


def lines(title: str, rows: Iterable[Measured]) -> Iterator[str]:
    """Print measured figures against wanted ones, each as soon as it is known.

    Examples
    --------
    >>> for line in lines("engine", [Measured(quantity="cue shot", value=93.0, unit="µs", most=150.0)]):
    ...     print(line)
    engine                                                  measured      wanted
    cue shot                                                   93 µs       ≤ 150
    """
    yield f"{title:52} {'measured':>11} {'wanted':>11}"
    for row in rows:
        value = f"{row.value:.3g} {row.unit}".strip()
        yield f"{row.quantity:52} {value:>11} {row.wanted:>11}{'' if row.met else '  missed'}".rstrip()


def fastest(
    work: Callable[[], object], repeats: int = REPEATS, clock: Callable[[], float] = time.perf_counter
) -> float:
    """Time of the fastest of some runs, s."""
    times = []
    for _ in range(repeats):
        start = clock()
        work()
        times.append(clock() - start)
    return min(times)


def yardstick() -> float:
    """Time of a million additions in plain Python, s: what this machine is worth just now."""

    def additions() -> int:
        total = 0
        for number in range(1_000_000):
            total += number
        return total

    return fastest(additions)


def engine() -> Iterator[Measured]:
    """Time collisions on one thread, compilation apart, and tell how exact they are."""
    rng = np.random.default_rng(2008)
    ratios = 10.0 ** rng.uniform(-2.0, 2.0, CASES)
    normals, cues = ordinary_shots(CASES // 10, rng)
    shot = ordinary_shot()
    collide(shot)
    drops = fastest(lambda: collide_many(FIG5_DROP, threads=1, stiffness_ratio=ratios))
    yield Measured(
        quantity="two-ball collision in collide_many, one thread",
        value=drops / CASES * 1e6,
        unit="µs",
        most=20,
    )
    shots = fastest(lambda: collide_many(shot, threads=1, normal=normals, cue_velocity=cues))
    yield Measured(
        quantity="cue shot in collide_many, one thread", value=shots / len(cues) * 1e6, unit="µs", most=150
    )
    one = fastest(lambda: [collide(FIG5_DROP) for _ in range(100)]) / 100
    yield Measured(quantity="collide on one drop, all bookkeeping", value=one * 1e6, unit="µs", most=200)
    for quantity, error in (
        ("error of drops at default tolerance, of their speed", error_of_drops(ratios)),
        ("error of shots at default tolerance, of the cue's", error_of_shots(normals, cues)),
    ):
        yield Measured(quantity=quantity, value=error, unit="", most=1e-8)


def compilation() -> Iterator[Measured]:
    """Time the first call after installation, and the first call of a later process."""
    with tempfile.TemporaryDirectory() as folder:
        environment = {**os.environ, "NUMBA_CACHE_DIR": folder}
        for quantity, most in (
            ("first call after installation, compilation, processor", 15.0),
            ("first call of a later process, processor", 1.0),
        ):
            run = subprocess.run(
                [sys.executable, "-c", FIRST_CALL],
                env=environment,
                cwd=Path(__file__).resolve().parents[1],
                capture_output=True,
                text=True,
                check=True,
            )
            yield Measured(quantity=quantity, value=float(run.stdout), unit="s", most=most)


def calibration() -> Iterator[Measured]:
    """Time the whole fit with its profile from 1e-3 to 1e3, two mass pairs, and refits of a bootstrap."""
    trials = simulate_trials(TRUTH, Design(), np.random.default_rng(2008))
    fitted = fit_stiffness_ratio(trials)
    seconds = fastest(lambda: fit_stiffness_ratio(trials), repeats=3, clock=time.process_time)
    yield Measured(
        quantity="fit, profile 1e-3 … 1e3, two mass pairs, processor", value=seconds, unit="s", most=2
    )

    def refits(times: int) -> float:
        draw = np.random.default_rng(2008)
        return fastest(lambda: bootstrap(trials, fitted, draw, times), repeats=1, clock=time.process_time)

    first = refits(1)  # of each kind, and the model solved for all of them
    seconds = first + (refits(REFITS // 2) - first) / (REFITS - 2) * 998
    yield Measured(
        quantity=f"1000 bootstrap fits, from {REFITS} timed, processor", value=seconds, unit="s", most=120
    )


def ordinary_shot() -> CueShot:
    """One shot as players strike it."""
    return CueShot(
        ball=SHOT_BALL,
        cue=Cue(mass=0.5),
        normal=(0.0, -1.0, 0.0),
        cue_velocity=(0.0, 2.0, 0.0),
        tip_ball=Contact(restitution=0.7, friction=0.6),
        ball_table=Contact(restitution=0.5, friction=0.2, stiffness=1.5),
    )


def ordinary_shots(count: int, rng: np.random.Generator) -> tuple[Array, Array]:
    """Contact normals up to half a radius off the middle, and cue velocities up to 40 degrees from level."""
    offsets = rng.uniform(-0.5, 0.5, (2, count)).T
    elevation, speed = np.radians(rng.uniform(0.0, 40.0, count)), rng.uniform(0.5, 6.0, count)
    cues = (speed * np.array([np.zeros(count), np.cos(elevation), -np.sin(elevation)])).T
    struck = [
        struck_normal(None, (right, up), tuple(cue)) for (right, up), cue in zip(offsets, cues, strict=True)
    ]
    return np.array(struck), cues


def error_of_drops(ratios: Array) -> float:
    """Largest difference between default and tightest tolerance, over the approach speed."""
    usual = collide_many(FIG5_DROP, stiffness_ratio=ratios).velocities
    tight = collide_many(FIG5_DROP, stiffness_ratio=ratios, rtol=1e-14).velocities
    return float(np.abs(usual - tight).max() / abs(FIG5_DROP.approach_velocity))


def error_of_shots(normals: Array, cues: Array) -> float:
    """Largest difference between default and tightest tolerance, over the speed of the cue."""
    shot = ordinary_shot()
    usual = collide_many(shot, normal=normals, cue_velocity=cues).velocity
    tight = collide_many(shot, normal=normals, cue_velocity=cues, rtol=1e-14).velocity
    return float((np.abs(usual - tight).max(axis=1) / np.linalg.norm(cues, axis=1)).max())

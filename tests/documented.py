"""What the pages show: their blocks of code, and stand-ins for the files that they speak of."""

import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from shutil import copy

import numpy as np
import pandas as pd
from clips import SMALL, Clip, film

from calibrate.simulate_shots import simulate_shots
from calibrate.trials import write_trials
from impact import Ball, Cue
from tracking.render import DropScene

HOME = Path(__file__).resolve().parents[1]
README, FILMING, FITTING, NOTES, EXPERIMENT_FILE, REPRODUCTION, MODEL = PAGES = [
    HOME / page
    for page in (
        "README.md",
        "tracking/FILMING.md",
        "calibrate/FITTING.md",
        "calibrate/NOTES.md",
        "experiments/EXPERIMENT.md",
        "experiments/REPRODUCTION.md",
        "impact/MODEL.md",
    )
]
SHORT = DropScene(kind="plate", drop_height=0.06, after=0.12, hold=0.05, camera=SMALL)
ROLLING = replace(SHORT, drop_height=0.1, after=0.15, camera=replace(SMALL, readout=0.004))
FILMED = {
    "plate-1": ROLLING,
    "held-1": replace(ROLLING, kind="held"),
    "equal-1": replace(ROLLING, kind="two", first_rebound=(0.78, 0.19)),
    "heavy-1": replace(ROLLING, kind="two", first_rebound=(0.785, 0.235)),
    "odd/late-1": replace(ROLLING, kind="two", first_rebound=(0.78, 0.19), seed=1),
}
"""What the experiment file of the pages speaks of."""
SHOT = {
    "tip_ball_restitution": 0.6,
    "tip_ball_friction": 0.6,
    "stiffness_ratio": 20.0,
    "ball_table_restitution": 0.5,
    "ball_table_friction": 0.2,
}


def blocks(page: Path, language: str) -> list[str]:
    """Fenced blocks of a page in one language."""
    return re.findall(rf"^```{language}\n(.*?)^```$", page.read_text(encoding="utf-8"), re.M | re.S)


def commands() -> Iterator[str]:
    """Every command that a page shows, once, as it is typed once the program is installed."""
    lines = (line for page in PAGES for block in blocks(page, "sh") for line in block.splitlines())
    shown = (re.sub(r"\s+#.*", "", line).split("&& ")[-1].removeprefix(".venv/bin/") for line in lines)
    yield from dict.fromkeys(shown)


def programs() -> Iterator[tuple[str, str]]:
    """Every Python block, and the text that is shown right below it, empty if there is none."""
    pattern = r"^```python\n(.*?)^```$(?:\n\n```text\n(.*?)^```$)?"
    for page in PAGES:
        yield from re.findall(pattern, page.read_text(encoding="utf-8"), re.M | re.S)


def lay_out(desk: Path, plate: Clip) -> None:
    """Put small files in place of those that the pages speak of."""
    for folder in ("drops", "slow", "odd", "out"):
        (desk / folder).mkdir()
    copy(plate.path, desk / "drops" / "plate-01.mp4")
    film(replace(SHORT, camera=replace(SMALL, file_fps=30)), desk / "slow" / "slow.mp4")
    for name, scene in FILMED.items():
        film(scene, desk / f"{name}.mp4")
    (whole,) = blocks(EXPERIMENT_FILE, "toml")
    (desk / "experiment.toml").write_text(whole, encoding="utf-8")
    (table,) = blocks(FITTING, "csv")
    (desk / "trials.csv").write_text(table)
    (desk / "out" / "trials.csv").write_text(table)
    (desk / "heights.csv").write_text(
        "ball,h0_cm,h1_cm\n" + "".join(f"ping-pong,{h},{0.72 * h}\n" for h in (30, 40, 50, 60))
    )
    write_trials(_shots(), desk / "shots.csv")


def _shots() -> pd.DataFrame:
    generator = np.random.default_rng(1)
    spread = generator.uniform([1.5, 0.0, 0.2, -0.3, -0.2], [2.5, 0.0, 0.8, 0.3, 0.3], (12, 5))
    return simulate_shots(SHOT, spread, (Ball(mass=0.17, radius=0.028575), Cue(mass=0.54)), generator)

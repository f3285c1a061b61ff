"""The bench: what it prints, and that it measures what it says."""

import numpy as np
from typer.testing import CliRunner

from experiments.bench import Measured, lines, ordinary_shot, ordinary_shots
from experiments.cli import app
from impact import collide_many


def test_a_figure_that_misses_its_mark_says_so():
    slow = Measured(quantity="collision", value=25.0, unit="µs", most=20)
    low = Measured(quantity="throughput", value=0.9, unit="", least=0.8)
    assert not slow.met
    assert low.met
    title, first, second = lines("engine", [slow, low])
    assert "wanted" in title
    assert first.endswith("missed")
    assert second.endswith("0.8")


def test_the_shots_that_are_timed_can_happen_and_strike_the_ball():
    normals, cues = ordinary_shots(200, np.random.default_rng(1))
    assert np.allclose(np.linalg.norm(normals, axis=1), 1.0)
    assert ((normals * cues).sum(axis=1) < 0).all()
    assert (collide_many(ordinary_shot(), normal=normals, cue_velocity=cues).velocity[:, 1] > 0).all()


def test_an_unknown_bench_is_refused_with_the_list_of_those_there_are():
    done = CliRunner().invoke(app, ["bench", "speed"])
    assert done.exit_code == 2
    assert "engine, compilation, calibration, tracking, memory" in done.output

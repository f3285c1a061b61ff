"""`impactlab simulate shot`: it prints what `collide` says, and refuses in one sentence."""

import re
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

from experiments import cue_shot, paper
from experiments.aim import aimed_cue, struck_normal
from experiments.cli import app
from experiments.trajectory import trajectory
from impact import Ball, Cloth, Motion, RestitutionLaw, collide

VERTICAL = ("--normal", -1, -2, 1, "--cue-velocity", 0, 0, -2)


def simulate_shot(*arguments: object) -> Result:
    return CliRunner().invoke(app, ["simulate", "shot", *map(str, arguments)])


def printed(result: Result, name: str) -> list[float]:
    """Numbers in the line that begins with a name."""
    assert result.exit_code == 0, result.output
    line = next(line for line in result.stdout.splitlines() if line.startswith(name))
    return [float(number) for number in re.findall(r"-?\d+\.?\d*(?:e-?\d+)?", line.removeprefix(name))]


@pytest.mark.parametrize("law", RestitutionLaw)
def test_simulate_shot_prints_what_collide_says(law: RestitutionLaw) -> None:
    outcome = collide(paper.cue_shot(paper.SHOTS["vertical"]), law=law)
    result = simulate_shot(*VERTICAL, "--law", law.value)
    assert printed(result, "ball velocity:") == pytest.approx(outcome.velocity, rel=1e-5, abs=1e-9)
    assert printed(result, "angular velocity:") == pytest.approx(outcome.angular_velocity, rel=1e-5, abs=1e-9)
    assert printed(result, "cue speed:") == pytest.approx([2.0, outcome.cue_speed], rel=1e-5)
    assert printed(result, "energy lost:") == pytest.approx([outcome.energy_loss], rel=1e-5)


def test_simulate_shot_prints_a_line_a_state() -> None:
    outcome = collide(paper.cue_shot(paper.SHOTS["vertical"]))
    lines = simulate_shot(*VERTICAL).stdout.splitlines()[1:5]
    assert tuple(line.split()[1] for line in lines) == outcome.states
    assert [float(number) for number in lines[-1].split()[-2:]] == pytest.approx(outcome.impulses, rel=1e-5)


def test_every_constant_of_the_shot_can_be_set() -> None:
    options = {
        **{"ball-mass": 0.2, "cue-mass": 0.4, "ball-radius": 0.03, "stiffness-ratio": 3.0, "exponent": 1.5},
        **{"tip-restitution": 0.7, "tip-friction": 0.5, "table-restitution": 0.4, "table-friction": 0.3},
    }
    before = printed(simulate_shot(*VERTICAL), "angular velocity:")
    for name, value in options.items():
        assert printed(simulate_shot(*VERTICAL, f"--{name}", value), "angular velocity:") != before, name


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("--normal", 1, 0, 0), "cue_velocity must point into the ball, against normal"),
        (("--offset", 0.8, 0.8), "offset must be less than 1 radius"),
        (("--offset", "nan", 0), "offset must be less than 1 radius"),
        (("--offset", 0, 0.5, "--normal", -1, 0, 0), "give one of them"),
        (("--speed", 1, "--cue-velocity", 1, 0, 0), "give either"),
        (("--speed", -1), "speed must be positive, got -1"),
        (("--elevation", 91), "elevation must be within [-90, 90] degrees, got 91"),
        (("--cue-velocity", 0, 0, 0), "cue_velocity must be finite and not zero"),
        (("--tip-restitution", 1.2), "restitution must be within [0, 1], got 1.2"),
        (("--plot", "shot.doc"), "ending in .svg, .png or .pdf"),
    ],
)
def test_a_shot_that_cannot_happen_is_refused(arguments: tuple[object, ...], sentence: str) -> None:
    result = simulate_shot(*arguments)
    assert result.exit_code == 2, result.output
    assert sentence in result.stderr
    assert result.stderr.startswith("impactlab: ")


def test_an_offset_is_seen_along_the_cue() -> None:
    assert struck_normal(None, (0.6, 0.0), (0.0, 2.0, 0.0)) == pytest.approx((0.6, -0.8, 0.0))
    assert struck_normal(None, (0.0, 0.6), (0.0, 2.0, 0.0)) == pytest.approx((0.0, -0.8, 0.6))
    assert struck_normal(None, (0.6, 0.0), (0.0, 0.0, -1.0)) == pytest.approx((0.0, -0.6, 0.8))


@pytest.mark.parametrize("elevation", [-20.0, 0.0, 35.0, 90.0])
def test_an_offset_has_its_distance_from_the_axis_of_the_cue(elevation: float) -> None:
    velocity = aimed_cue(None, 3.0, elevation)
    normal = struck_normal(None, (0.3, -0.4), velocity)
    assert np.linalg.norm(velocity) == pytest.approx(3.0)
    assert np.linalg.norm(normal) == pytest.approx(1.0)
    assert np.linalg.norm(np.cross(normal, velocity)) == pytest.approx(0.5 * 3.0)


def test_a_low_level_shot_draws_and_a_high_one_follows() -> None:
    low, high = (printed(simulate_shot("--offset", 0, up), "angular velocity:") for up in (-0.3, 0.3))
    assert low[1] < 0.0 < high[1]


@pytest.mark.parametrize("table", [("--table-friction", 0), ("--table-restitution", 1)])
def test_a_ball_that_never_rests_has_no_trajectory(table: tuple[str, int]) -> None:
    result = simulate_shot(*VERTICAL, *table)
    assert "never comes to rest" in result.stdout
    assert result.exit_code == 0


def test_help_shows_an_example_that_runs() -> None:
    example = simulate_shot("--help").stdout.strip().splitlines()[-1]
    assert example.strip().startswith("Example: impactlab simulate shot")
    assert simulate_shot(*example.split()[4:]).exit_code == 0


@pytest.mark.parametrize("kind", ["svg", "png"])
def test_simulate_shot_draws(kind: str, tmp_path: Path) -> None:
    result = simulate_shot(*VERTICAL, "--plot", tmp_path / f"shot.{kind}")
    assert result.exit_code == 0, result.output
    assert (tmp_path / f"shot.{kind}").stat().st_size > 10_000


def test_a_shot_with_more_states_than_fit_says_how_many_there_are() -> None:
    done = cue_shot.compute(paper.cue_shot(paper.SHOTS["vertical"], 1e-4))
    assert len(done.outcome.states) > 24
    assert f"and {len(done.outcome.states) - 24} more states" in cue_shot.describe(done)


def test_the_trajectory_ends_flight_before_it_slides_and_rolls_in_a_straight_line() -> None:
    cloth = Cloth(friction=0.2, restitution=0.5)
    way = trajectory(Ball(mass=0.17, radius=0.0286), (1.0, 0.3, 1.0), (0.0, -40.0, 0.0), cloth)
    motions = [motion for motion, _ in way.legs]
    assert motions[0] is Motion.FLYING
    assert motions[-2:] == [Motion.SLIDING, Motion.ROLLING]
    assert way.legs[-1][1][0] == pytest.approx(way.rolling_starts)


def test_rolling_is_drawn_no_farther_than_the_ball_goes() -> None:
    cloth = Cloth(friction=0.2, restitution=0.5, rolling_resistance=0.5)
    way = trajectory(Ball(mass=0.17, radius=0.0286), (1.0, 0.0, 0.0), (0.0, 0.0, 0.0), cloth)
    rest = way.path.position(way.path.duration)[0, :2]
    assert way.legs[-1][1][-1] == pytest.approx(rest)

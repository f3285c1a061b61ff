"""The closed forms of flight and of sliding, against a numerical integrator and their own symmetries."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from tracking.cloth import Cloth, cloth_position, sliding_time
from tracking.flight import (
    VACUUM,
    Air,
    Flight,
    apex,
    fall_time,
    flight_of_ball,
    position,
    velocity,
)

BALL = flight_of_ball(0.0027, 0.020, Air())
velocities = st.floats(-8.0, 8.0)
times = st.floats(-0.4, 0.4)


@pytest.mark.parametrize("start", [-12.0, -6.0, -1.0, 0.0, 1.0, 6.0, 12.0])
@pytest.mark.parametrize("time", [-0.45, -0.1, 0.1, 1.5])
def test_flight_solves_the_equation_of_motion(start: float, time: float) -> None:
    def motion(_: float, state: np.ndarray) -> list[float]:
        speed = state[1]
        return [speed, -BALL.gravity * (1 + speed * abs(speed) / BALL.terminal_speed**2)]

    end = solve_ivp(motion, (0, time), [0.0, start], method="DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
    assert position(BALL, start, time) == pytest.approx(end[0], abs=1e-9)
    assert velocity(BALL, start, time) == pytest.approx(end[1], abs=1e-9)


def test_effective_gravity_agrees_with_rendered_recordings(shared_data: Path) -> None:
    for path in (shared_data / "rendered" / "drops").glob("*-[01]?.json"):
        truth = json.loads(path.read_text())
        for mass, gravity in zip(truth["masses_kg"], truth["effective_gravity"], strict=False):
            ball = flight_of_ball(mass, truth["ball_radius_m"], Air())
            assert ball.gravity == pytest.approx(gravity, rel=1e-12)


def test_terminal_speed_balances_weight_and_drag() -> None:
    drag = 0.5 * 1.2 * 0.45 * math.pi * 0.02**2 * BALL.terminal_speed**2
    weight = (0.0027 - 1.2 * 4 / 3 * math.pi * 0.02**3) * 9.80665
    assert drag == pytest.approx(weight)


@given(velocities, times)
def test_flight_runs_backwards_as_it_ran_forwards(start: float, time: float) -> None:
    there, speed = position(BALL, start, time), velocity(BALL, start, time)
    assert there + position(BALL, speed, -time) == pytest.approx(0, abs=1e-9)
    assert velocity(BALL, speed, -time) == pytest.approx(start, abs=1e-9)


@given(velocities, times.map(lambda t: t / 2), times.map(lambda t: t / 2))
def test_two_steps_make_the_same_flight_as_one(start: float, first: float, second: float) -> None:
    step = position(BALL, start, first)
    rest = position(BALL, velocity(BALL, start, first), second)
    assert step + rest == pytest.approx(position(BALL, start, first + second), abs=1e-8)


@given(velocities)
def test_drag_never_adds_energy(start: float) -> None:
    time = np.linspace(-0.4, 2.0, 200)
    energy = velocity(BALL, start, time) ** 2 / 2 + BALL.gravity * position(BALL, start, time)
    assert np.all(np.diff(energy) <= 1e-9)


@given(velocities, times, st.floats(1e5, 1e13))
def test_weak_drag_tends_to_the_parabola_without_cancellation(
    start: float, time: float, terminal: float
) -> None:
    weak, none = Flight(gravity=9.8, terminal_speed=terminal), Flight(gravity=9.8)
    deviation = 200 / terminal**2 + 1e-14
    assert position(weak, start, time) == pytest.approx(position(none, start, time), abs=deviation)
    assert velocity(weak, start, time) == pytest.approx(velocity(none, start, time), abs=10 * deviation)


@given(velocities.filter(lambda v: abs(v) > 0.1))
def test_flight_is_smooth_through_the_apex(start: float) -> None:
    time, height = apex(BALL, start)
    near = time + np.array([-1e-6, 0.0, 1e-6])
    assert velocity(BALL, start, near) == pytest.approx([9.589e-6, 0, -9.589e-6], rel=1e-3, abs=1e-12)
    assert position(BALL, start, near) == pytest.approx(height, abs=1e-11)


def test_a_ball_thrown_down_too_fast_has_no_apex() -> None:
    with pytest.raises(ValueError, match="velocity must be above"):
        apex(BALL, -9.0)


@given(velocities.filter(lambda v: abs(v) > 1e-3), times)
def test_velocity_is_the_slope_of_position(start: float, time: float) -> None:
    ahead, behind = position(BALL, start, time + 1e-5), position(BALL, start, time - 1e-5)
    assert (ahead - behind) / 2e-5 == pytest.approx(velocity(BALL, start, time), abs=1e-7)


@given(st.floats(1e-4, 30.0))
def test_fall_time_undoes_position(height: float) -> None:
    assert position(BALL, 0.0, fall_time(BALL, height)) == pytest.approx(-height, rel=1e-12)


def test_vacuum_is_a_parabola() -> None:
    flight = flight_of_ball(0.0027, 0.020, VACUUM, gravity=9.81)
    assert position(flight, [1.0, -2.0], 0.5) == pytest.approx([0.5 - 9.81 / 8, -1.0 - 9.81 / 8])
    assert fall_time(flight, 9.81 / 2) == pytest.approx(1.0)


def test_velocities_and_times_broadcast() -> None:
    grid = position(BALL, np.array([[-3.0], [0.0], [3.0]]), np.linspace(-0.2, 0.2, 5))
    assert grid.shape == (3, 5)
    assert grid[2, 4] == position(BALL, 3.0, 0.2)


def test_flight_before_the_ball_can_have_existed_is_not_a_number() -> None:
    assert np.isnan(position(BALL, [6.0, 0.0, -9.0], -10.0)).all()
    assert np.isnan(velocity(BALL, [6.0, 0.0, -9.0], -10.0)).all()


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Air(density=-1.0), "density must be at least 0 and finite, got -1.0"),
        (lambda: Flight(gravity=0.0), "gravity must be positive and finite, got 0.0"),
        (lambda: Flight(gravity=9.8, terminal_speed=-1.0), "terminal_speed must be positive, got -1.0"),
        (lambda: flight_of_ball(-1.0, 0.02, Air()), "mass must be positive and finite, got -1.0"),
        (lambda: flight_of_ball(1.0, 0.0, Air()), "radius must be positive and finite, got 0.0"),
        (lambda: flight_of_ball(1e-5, 0.02, Air()), "mass must exceed that of the displaced air"),
        (lambda: Cloth(friction=0.0), "friction must be positive and finite, got 0.0"),
        (lambda: Cloth(friction=0.2, rolling_resistance=-1), "rolling_resistance must be at least 0, got -1"),
    ],
)
def test_impossible_numbers_are_refused_by_name(make: object, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        make()  # type: ignore[operator]


def test_cue_ball_follows_the_rendered_shots(shared_data: Path) -> None:
    for path in (shared_data / "rendered" / "shots").glob("*.json"):
        truth = json.loads(path.read_text())
        (vx, vy), (wx, wy), r = truth["v"], truth["w"], truth["ball_radius_m"]
        cloth = Cloth(friction=truth["mu"], rolling_resistance=truth["rolling"])
        slip = (vx - r * wy, vy + r * wx)
        time, x, y = np.array(truth["path"]).T
        path_of_ball = cloth_position(cloth, (vx, vy), slip, time) + np.array([x[0], y[0]])
        assert truth["strike_t"] + sliding_time(cloth, slip) == pytest.approx(truth["roll_t"], abs=1e-3)
        assert np.abs(path_of_ball - np.column_stack([x, y])).max() < 1e-3


@given(velocities, velocities, velocities, velocities)
def test_sliding_ends_with_rolling_at_the_roll_velocity(vx: float, vy: float, ux: float, uy: float) -> None:
    cloth = Cloth(friction=0.2)
    end = sliding_time(cloth, (ux, uy))
    step = np.diff(cloth_position(cloth, (vx, vy), (ux, uy), [end, end + 1.0]), axis=0)[0]
    assert step == pytest.approx([vx - 2 / 7 * ux, vy - 2 / 7 * uy], abs=1e-9)


def test_rolling_ball_stops_and_stays() -> None:
    cloth = Cloth(friction=0.2, rolling_resistance=0.01, gravity=10)
    stopped = cloth_position(cloth, (1.0, 0.0), (0.0, 0.0), [10.0, 20.0])
    assert stopped == pytest.approx(np.array([[5.0, 0.0], [5.0, 0.0]]))

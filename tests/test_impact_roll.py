"""After the shot: parabola, rolling, bounces, rest."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from impact import Ball, Cloth, Motion, RigidBody, Touch, assemble, collide, roll
from impact.contact import Contact

BALL = Ball(mass=0.17, radius=0.0286)
CLOTH = Cloth(friction=0.2, restitution=0.5)
speeds = st.floats(-3.0, 3.0)
spins = st.floats(-100.0, 100.0)


def motions(path) -> list[Motion]:
    return [stretch.motion for stretch in path.stretches]


def test_sliding_lasts_two_sevenths_of_slip_over_friction():
    path = roll(BALL, (1.0, 2.0, 0.0), (0.0, 0.0, 0.0), CLOTH)
    assert path.stretches[0].end == pytest.approx(2 * np.sqrt(5) / (7 * 0.2 * 9.80665))
    assert path.stretches[1].velocity == pytest.approx([5 / 7, 10 / 7, 0])


def test_a_rolling_ball_never_slides():
    path = roll(BALL, (1.0, 0.0, 0.0), (0.0, 1.0 / BALL.radius, 0.0), CLOTH)
    assert motions(path) == [Motion.ROLLING]
    assert path.position(path.duration)[0] == pytest.approx([1.0 / (2 * 0.01 * 9.80665), 0, 0])


def test_side_spin_outlasts_the_roll():
    path = roll(BALL, (0.1, 0.0, 0.0), (0.0, 0.0, 100.0), CLOTH)
    assert motions(path)[-1] is Motion.SPINNING
    assert path.duration == pytest.approx(100.0 * BALL.radius / (0.022 * 9.80665))


def test_a_jump_flies_and_bounces_before_it_slides():
    path = roll(BALL, (1.0, 0.0, 1.0), (0.0, 0.0, 0.0), CLOTH)
    flights = [stretch for stretch in path.stretches if stretch.motion is Motion.FLYING]
    assert [flight.velocity[2] for flight in flights[:3]] == pytest.approx([1.0, 0.5, 0.25])
    assert motions(path)[-1] is Motion.ROLLING


def test_a_ball_at_rest_has_no_path():
    assert roll(BALL, (0, 0, 0), (0, 0, 0), CLOTH).duration == 0.0


def test_a_bounce_is_what_the_impact_engine_says():
    velocity, spin = np.array([2.0, -1.0, -1.5]), np.array([30.0, 60.0, 10.0])
    body = RigidBody(
        mass=BALL.mass, inertia=BALL.inertia * np.eye(3), velocity=velocity, angular_velocity=spin
    )
    touch = Touch(
        contact=Contact(restitution=0.5, friction=0.2), normal=(0, 0, 1), body=0, point=(0, 0, -BALL.radius)
    )
    after = collide(assemble([body], [touch])).velocities
    flight = roll(BALL, velocity, spin, CLOTH).stretches[0]
    assert np.r_[flight.velocity, flight.angular_velocity] == pytest.approx(after, abs=1e-8)


@settings(deadline=None, max_examples=40, derandomize=True)
@given(speeds, speeds, st.floats(0.0, 2.0), spins, spins, spins)
def test_paths_are_continuous_and_end(x, y, z, a, b, c):
    path = roll(BALL, (x, y, z), (a, b, c), CLOTH)
    for one, other in zip(path.stretches, path.stretches[1:], strict=False):
        assert one.state_at(one.end)[0] == pytest.approx(other.position, abs=1e-9)
        assert one.end == other.start


@settings(deadline=None, max_examples=10, derandomize=True)
@given(speeds, speeds, spins, spins)
def test_sliding_obeys_newton_and_coulomb(x, y, a, b):
    """The closed form against an integration of force and torque at the lowest point."""

    def rates(_, state):
        velocity, spin = state[2:4], state[4:6]
        slip = velocity - BALL.radius * np.array([spin[1], -spin[0]])
        pull = -0.2 * 9.80665 * slip / max(np.linalg.norm(slip), 1e-9)
        return np.r_[velocity, pull, np.array([pull[1], -pull[0]]) / (0.4 * BALL.radius)]

    path = roll(BALL, (x, y, 0.0), (a, b, 0.0), CLOTH)
    if path.stretches and path.stretches[0].motion is Motion.SLIDING:
        half = 0.5 * path.stretches[0].end
        end = solve_ivp(rates, (0.0, half), [0, 0, x, y, a, b], rtol=1e-10, atol=1e-12).y[:2, -1]
        assert path.position(half)[0, :2] == pytest.approx(end, abs=1e-8)


def test_a_ball_that_loses_nothing_would_bounce_for_ever():
    lossless = Cloth(friction=0.2, restitution=1.0)
    with pytest.raises(ValueError, match="never rest"):
        roll(BALL, (1.0, 0.0, 1.0), (0.0, 0.0, 0.0), lossless)
    assert motions(roll(BALL, (1.0, 0.0, 0.0), (0.0, 0.0, 0.0), lossless))[-1] is Motion.ROLLING

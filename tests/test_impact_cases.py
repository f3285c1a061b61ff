"""Closed forms, extreme and degenerate cases, bad input, many at once."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest

from impact import (
    Ball,
    BallChain,
    BallColumn,
    Contact,
    ContactMode,
    Cue,
    CueShot,
    ImpactSystem,
    RigidBody,
    Touch,
    TwoBallDrop,
    assemble,
    collide,
    collide_many,
)

BALL = Ball(mass=0.17, radius=0.0286)
UNIT = Ball(mass=1.0, radius=0.02)
SMOOTH = Contact(restitution=0.8)


def bounce(velocity, spin=(0, 0, 0), restitution=0.5, friction=0.2):
    """One ball on the ground."""
    inertia = BALL.inertia * np.eye(3)
    body = RigidBody(mass=BALL.mass, inertia=inertia, velocity=velocity, angular_velocity=spin)
    contact = Contact(restitution=restitution, friction=friction)
    ground = Touch(contact=contact, normal=(0, 0, 1), body=0, point=(0, 0, -BALL.radius))
    return collide(assemble([body], [ground]))


def drop(restitution=0.8, ratio=1.0, upper=1.0, lower=1.0) -> TwoBallDrop:
    return TwoBallDrop(
        upper=Ball(mass=upper, radius=0.02),
        lower=Ball(mass=lower, radius=0.02),
        ball_ball=Contact(restitution=restitution),
        ball_table=Contact(restitution=restitution, stiffness=ratio),
        approach_velocity=-1.0,
    )


def shot(normal=(-1, 0, 0.5), cue_velocity=(2, 0, -1), tip_friction=0.4, table_friction=0.2) -> CueShot:
    return CueShot(
        ball=BALL,
        cue=Cue(mass=0.5),
        normal=normal,
        cue_velocity=cue_velocity,
        tip_ball=Contact(restitution=0.7, friction=tip_friction),
        ball_table=Contact(restitution=0.5, friction=table_friction, stiffness=5.0),
    )


@pytest.mark.parametrize("exponent", [1.0, 1.5, 2.0])
def test_one_contact_rebounds_at_e_times_the_approach(exponent):
    contact = Contact(restitution=0.6, exponent=exponent)
    outcome = collide(BallChain(masses=[1, 3], velocities=[2, 0], contacts=[contact]))
    assert np.diff(outcome.velocities) == pytest.approx(0.6 * 2, abs=1e-9)


def test_a_ball_that_slides_through_its_bounce_loses_mu_times_the_normal_impulse():
    outcome = bounce((3.0, 0.0, -1.0))
    assert outcome.velocities[[0, 2]] == pytest.approx([3.0 - 0.2 * 1.5, 0.5], abs=1e-9)
    assert outcome.segments[0].modes == ((ContactMode.SLIDING,),)


def test_a_ball_that_stops_sliding_in_its_bounce_rolls_off():
    outcome = bounce((0.3, 0.4, -1.0))
    assert outcome.velocities[:2] == pytest.approx([0.3 * 5 / 7, 0.4 * 5 / 7], abs=2e-9)
    assert outcome.segments[0].modes == ((ContactMode.SLIDING, ContactMode.STICKING),)


def test_spin_turns_into_speed_at_a_bounce():
    outcome = bounce((0.0, 0.0, -2.0), spin=(0.0, 300.0, 0.0))
    assert outcome.velocities[0] == pytest.approx(0.2 * 3.0, abs=1e-9)


@pytest.mark.parametrize("restitution", [0.0, 1.0])
@pytest.mark.parametrize("ratio", [1e-6, 1e-3, 1.0, 1e3, 1e6])
def test_any_stiffness_ratio_ends_cleanly(restitution, ratio):
    upper, lower = collide(drop(restitution, ratio)).velocities
    assert upper >= lower - 1e-9
    assert lower >= -1e-9
    assert upper**2 + lower**2 <= 1.0 + 1e-9


@pytest.mark.parametrize(("upper", "lower"), [(1e-4, 1.0), (1.0, 1e-4), (1e4, 1.0), (1.0, 1e4)])
def test_any_mass_ratio_ends_cleanly(upper, lower):
    outcome = collide(drop(0.8, 3.0, upper, lower))
    assert outcome.energy_loss == pytest.approx(outcome.energy_dropped.sum(), abs=1e-8 * upper)


def test_elastic_collisions_keep_their_energy():
    for ratio in (0.1, 1.0, 10.0):
        assert (collide(drop(1.0, ratio)).velocities ** 2).sum() == pytest.approx(1.0, abs=1e-10)


def test_dead_contacts_leave_everything_at_rest_on_the_table():
    assert collide(drop(0.0)).velocities == pytest.approx([0.0, 0.0], abs=1e-8)


def test_a_collapse_takes_many_states_and_ends():
    outcome = collide(drop(0.1, 0.3, upper=3.0))
    assert len(outcome.states) > 20
    assert outcome.velocities == pytest.approx([0.0, 0.0], abs=1e-8)


def test_contacts_that_end_together_are_one_transition():
    """A ball caught between two equal ones: a tie at every event."""
    chain = BallChain(masses=[1, 1, 1], velocities=[1, 0, -1], contacts=[SMOOTH, SMOOTH])
    outcome = collide(chain)
    assert outcome.velocities == pytest.approx([-0.8, 0.0, 0.8], abs=1e-9)
    assert outcome.states == ("{1,2}",)


def test_touching_balls_that_nobody_pushes_stay_out_of_it():
    chain = BallChain(masses=[1, 1, 1], velocities=[0, 0, -1], contacts=[SMOOTH, SMOOTH])
    mirrored = BallChain(masses=[1, 1, 1], velocities=[1, 0, 0], contacts=[SMOOTH, SMOOTH])
    assert collide(chain).velocities == pytest.approx(-collide(mirrored).velocities[::-1], abs=1e-10)
    apart = BallChain(masses=[1, 1, 1], velocities=[0, 2, 1], contacts=[SMOOTH, SMOOTH])
    assert collide(apart).states == ("{2}",)


def test_a_column_of_two_is_the_drop():
    column = BallColumn(
        balls=[UNIT, UNIT], velocities=[0, -1], contacts=[Contact(restitution=0.8, stiffness=7.0), SMOOTH]
    )
    assert collide(column).velocities[::-1] == pytest.approx(collide(drop(0.8, 7.0)).velocities, abs=1e-10)


def test_a_level_shot_on_the_equator_never_meets_the_table():
    outcome = collide(shot(normal=(-1, -0.5, 0), cue_velocity=(2, 0, 0)))
    assert outcome.states == ("S3",)
    assert outcome.velocity[2] == 0.0


def test_a_steep_shot_below_the_equator_drags_the_ball_onto_the_table():
    outcome = collide(shot(normal=(-1, 0, -0.07), cue_velocity=(3, 0, -3), tip_friction=0.7))
    assert "S1" in outcome.states
    assert outcome.velocity[2] >= -1e-9


def test_a_shot_through_the_centre_without_friction_leaves_no_spin():
    outcome = collide(shot(normal=(-1, 0, 0), cue_velocity=(2, 0, 0), tip_friction=0, table_friction=0))
    assert outcome.velocity == pytest.approx([2 * 1.7 * 0.5 / 0.67, 0, 0], abs=1e-9)
    assert outcome.angular_velocity == pytest.approx([0, 0, 0], abs=1e-12)


def test_enough_friction_makes_the_tip_stick_through_the_shot():
    outcome = collide(shot(normal=(-1, -0.2, 0), cue_velocity=(2, 0, 0), tip_friction=50.0))
    assert ContactMode.STICKING in outcome.segments[0].modes[0]
    slip = outcome.collision.system.jacobian[0, 1:] @ outcome.collision.velocities
    assert slip == pytest.approx([0, 0], abs=1e-8)


def test_more_friction_than_enough_changes_nothing():
    one, other = (
        collide(shot(normal=(-1, -0.2, 0), cue_velocity=(2, 0, 0), tip_friction=friction))
        for friction in (200.0, 1000.0)
    )
    assert one.velocity == pytest.approx(other.velocity, abs=5e-3)


def test_a_jammed_cue_ends_within_the_bound_on_states():
    outcome = collide(shot(normal=(0.05, 0, 1), cue_velocity=(0, 0, -2), tip_friction=0.5))
    assert outcome.velocity[2] >= -1e-8


def test_a_ball_wedged_between_two_walls_bounces_back():
    """A ball falls into a right-angled groove; both walls act at once and by symmetry alike."""
    body = RigidBody(mass=1.0, inertia=0.4 * np.eye(3), velocity=(0, 0, -1))
    walls = [
        Touch(contact=SMOOTH, normal=normal, body=0, point=-np.array(normal) / math.sqrt(2))
        for normal in ((1.0, 0.0, 1.0), (-1.0, 0.0, 1.0))
    ]
    outcome = collide(assemble([body], walls))
    assert outcome.velocities == pytest.approx([0, 0, 0.8, 0, 0, 0], abs=1e-9)


def test_a_rocking_block_that_sticks_turns_about_its_corner():
    """A tall block lands on one edge while the other rests: rough ground, no rebound."""
    width, height = 0.2, 1.0
    inertia = np.diag([1.0, (width**2 + height**2) / 12.0, 1.0])
    spin = 1.0
    pivot = np.array([width / 2, 0, -height / 2])
    velocity = -np.cross([0, spin, 0], pivot)
    body = RigidBody(mass=1.0, inertia=inertia, velocity=velocity, angular_velocity=(0, spin, 0))
    edges = [
        Touch(
            contact=Contact(restitution=0.0, friction=5.0),
            normal=(0, 0, 1),
            body=0,
            point=(x, 0, -height / 2),
        )
        for x in (-width / 2, width / 2)
    ]
    outcome = collide(assemble([body], edges))
    assert outcome.energy_loss >= 0.0
    assert (outcome.system.jacobian[:, 0] @ outcome.velocities).min() >= -1e-8


def test_nothing_happens_where_nothing_approaches():
    apart = ImpactSystem(inverse_mass=[[1.0]], jacobian=[[[1.0]]], velocity=[2.0], contacts=[SMOOTH])
    outcome = collide(apart)
    assert outcome.velocities.tolist() == [2.0]
    assert outcome.states == ()


def test_many_drops_are_the_same_as_one_by_one():
    ratios = np.geomspace(0.01, 100.0, 40)
    many = collide_many(drop(), stiffness_ratio=ratios)
    for ratio, velocities, states in zip(ratios, many.velocities, many.states, strict=True):
        one = collide(drop(ratio=ratio))
        assert velocities == pytest.approx(one.velocities, abs=1e-14)
        assert states == one.states


def test_many_shots_are_the_same_as_one_by_one():
    normals = np.array([(-1, y, z) for y in (-0.5, 0.0, 0.3) for z in (-0.1, 0.2, 0.6)])
    many = collide_many(shot(), normal=normals)
    for row, normal in enumerate(normals):
        one = collide(shot(normal=normal))
        assert many.velocity[row] == pytest.approx(one.velocity, abs=1e-12)
        assert many.angular_velocity[row] == pytest.approx(one.angular_velocity, abs=1e-10)
        assert many.states[row] == one.states


def test_many_rows_on_many_threads_keep_their_order():
    velocities = -np.linspace(1.0, 2.0, 500)
    many = collide_many(drop(), approach_velocity=velocities)
    assert many.velocities / velocities[:, None] == pytest.approx(
        np.broadcast_to(-collide(drop()).velocities, (500, 2)), abs=1e-12
    )


def test_no_rows_give_no_rows_and_threads_change_nothing():
    assert collide_many(drop(), stiffness_ratio=[]).velocities.shape == (0, 2)
    ratios = np.geomspace(0.1, 10.0, 50)
    alone = collide_many(drop(), threads=1, stiffness_ratio=ratios)
    assert (alone.velocities == collide_many(drop(), stiffness_ratio=ratios).velocities).all()
    with pytest.raises(ValueError, match="threads must be at least 1, got 0"):
        collide_many(drop(), threads=0, stiffness_ratio=ratios)


def test_a_long_collapse_among_many_keeps_all_its_states():
    many = collide_many(drop(0.1, 0.3), upper_mass=[1.0, 3.0])
    assert many.states[1] == collide(drop(0.1, 0.3, upper=3.0)).states


@pytest.mark.parametrize("exponent", [1.0, 1.5, 2.5])
def test_a_loose_tolerance_costs_digits_but_neither_states_nor_the_end(exponent):
    springs = {"restitution": 0.8, "exponent": exponent}
    scene = replace(drop(), ball_ball=Contact(**springs), ball_table=Contact(**springs))
    ratios = np.geomspace(0.1, 100.0, 200)
    exact, loose = (collide_many(scene, stiffness_ratio=ratios, rtol=rtol) for rtol in (1e-13, 1e-6))
    assert list(loose.states) == list(exact.states)
    assert loose.velocities == pytest.approx(exact.velocities, abs=1e-6)


def test_results_print_for_people():
    assert str(collide(drop(1.0, 10.0))).startswith(
        "velocities 0.990576, 0.136963 in states S1 S2; energy loss"
    )
    assert repr(collide(drop(1.0, 10.0)).segments[0]).startswith("<Segment S1: C2-C1")


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Contact(restitution=1.2), "restitution must be within [0, 1], got 1.2"),
        (lambda: Contact(restitution=math.nan), "restitution must be within [0, 1], got nan"),
        (lambda: Contact(restitution=0.5, friction=-0.1), "friction must be zero or more, got -0.1"),
        (lambda: Contact(restitution=0.5, stiffness=0.0), "stiffness must be positive, got 0.0"),
        (lambda: Contact(restitution=0.5, exponent=0.5), "exponent must be at least 1, got 0.5"),
        (lambda: Ball(mass=-1.0, radius=1.0), "mass must be positive, got -1.0"),
        (lambda: Ball(mass=1.0, radius=math.inf), "radius must be positive, got inf"),
        (lambda: Cue(mass=0.0), "mass must be positive, got 0.0"),
        (lambda: shot(cue_velocity=(0, 0, 0)), "cue_velocity must not be zero"),
        (lambda: shot(normal=(0, 0, 0)), "normal must not be zero"),
        (lambda: shot(cue_velocity=(-2, 0, 0)), "cue_velocity must point into the ball"),
        (lambda: shot(normal=(1, 2)), "normal must have shape (3,), got (2,)"),
        (lambda: BallChain(masses=[1], velocities=[1], contacts=[]), "contacts must be one or more"),
        (lambda: BallChain(masses=[1, 1], velocities=[0, 1], contacts=[SMOOTH]), "velocities must bring"),
        (lambda: BallColumn(balls=[UNIT], velocities=[-1], contacts=[]), "contacts must be as many as balls"),
        (lambda: collide(drop(), rtol=1.0), "rtol must be within"),
        (lambda: collide_many(drop(), stiffness_ratio=[-1.0]), "stiffness_ratio must be positive, got -1.0"),
        (lambda: collide_many(drop(), upper_mass=[1, 2], lower_mass=[1, 2, 3]), "one number of rows"),
        (lambda: collide_many(shot(), normal=[(1, 0, 0)]), "cue_velocity must point into the ball"),
    ],
)
def test_bad_values_die_with_name_rule_and_value(make, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        make()


def test_an_upper_ball_that_does_not_fall_is_refused():
    with pytest.raises(ValueError, match="approach_velocity must be negative"):
        TwoBallDrop(upper=UNIT, lower=UNIT, ball_ball=SMOOTH, ball_table=SMOOTH, approach_velocity=1.0)


def test_unknown_parameters_are_refused_with_the_list_of_those_there_are():
    with pytest.raises(TypeError, match="unknown parameters stiffness; allowed are upper_mass, lower_mass"):
        collide_many(drop(), stiffness=1.0)


def test_friction_needs_tangents():
    with pytest.raises(ValueError, match="jacobian must have 3 rows per contact"):
        ImpactSystem(
            inverse_mass=[[1.0]],
            jacobian=[[[1.0]]],
            velocity=[-1.0],
            contacts=[Contact(restitution=0.5, friction=0.1)],
        )

"""Ten thousand random cases a scene: none hangs, gains energy, gives NaN or leaves the friction cone."""

from dataclasses import replace

import numpy as np
import pytest

from impact import (
    Ball,
    BallChain,
    BallColumn,
    Contact,
    ConvergenceError,
    Cue,
    CueShot,
    RestitutionLaw,
    TwoBallDrop,
    collide,
)

CASES = 10_000
HERTZ = 1.5


def contact(rng: np.random.Generator, friction: float = 0.0) -> Contact:
    return Contact(
        restitution=rng.uniform(), stiffness=10.0 ** rng.uniform(-1.5, 1.5), friction=friction * rng.uniform()
    )


def ball(rng: np.random.Generator) -> Ball:
    return Ball(mass=10.0 ** rng.uniform(-1, 1), radius=0.0286)


def random_drop(rng: np.random.Generator) -> TwoBallDrop:
    return TwoBallDrop(
        upper=ball(rng),
        lower=ball(rng),
        ball_ball=contact(rng),
        ball_table=contact(rng),
        approach_velocity=-rng.uniform(0.1, 10),
    )


def random_row(rng: np.random.Generator) -> BallChain | BallColumn:
    count = int(rng.integers(2, 6))
    velocities = np.sort(rng.uniform(-5, 5, count))[::-1].tolist()
    if rng.uniform() < 0.5:
        masses = (10.0 ** rng.uniform(-1, 1, count)).tolist()
        return BallChain(
            masses=masses, velocities=velocities, contacts=[contact(rng) for _ in range(count - 1)]
        )
    balls = [ball(rng) for _ in range(count)]
    return BallColumn(balls=balls, velocities=velocities, contacts=[contact(rng) for _ in range(count)])


def random_shot(rng: np.random.Generator) -> CueShot:
    normal, cue_velocity = rng.normal(size=3), 5.0 * rng.normal(size=3)
    return CueShot(
        ball=ball(rng),
        cue=Cue(mass=10.0 ** rng.uniform(-1, 1)),
        normal=normal,
        cue_velocity=-np.sign(normal @ cue_velocity) * cue_velocity,
        tip_ball=contact(rng, 1.5),
        ball_table=contact(rng, 1.5),
    )


def hertzian(scene):
    """Replace the linear springs of a scene."""
    if isinstance(scene, BallChain | BallColumn):
        return replace(scene, contacts=[replace(one, exponent=HERTZ) for one in scene.contacts])
    names = ("tip_ball" if isinstance(scene, CueShot) else "ball_ball", "ball_table")
    return replace(scene, **{name: replace(getattr(scene, name), exponent=HERTZ) for name in names})


@pytest.mark.slow
@pytest.mark.parametrize("law", RestitutionLaw)
@pytest.mark.parametrize("springs", [lambda scene: scene, hertzian], ids=["linear", "Hertz"])
@pytest.mark.parametrize("make", [random_drop, random_row, random_shot])
def test_no_random_case_hangs_gains_energy_or_breaks_coulombs_law(make, springs, law):
    rng = np.random.default_rng(20081207)
    unfinished = []
    for case in range(CASES):
        try:
            outcome = collide(springs(make(rng)), law=law)
        except ConvergenceError as error:
            unfinished.append(case)
            outcome = error.partial
        collision = getattr(outcome, "collision", outcome)
        velocity = collision.system.velocity
        before = 0.5 * velocity @ np.linalg.solve(collision.system.inverse_mass, velocity)
        limits = np.array([touch.friction for touch in collision.system.contacts]) * collision.impulses
        tangential = np.linalg.norm(collision.tangential_impulses, axis=1)
        assert np.isfinite(collision.velocities).all(), case
        assert collision.energy_loss + collision.energy_borrowed >= -1e-9 * before, case
        assert (tangential <= limits * (1 + 1e-6) + 1e-9 * collision.impulses.max()).all(), case
    # a few scenes jam and rattle on for 20,000 states, and Poisson's law may make energy without bound: both
    # end in an error, and both must stay rare
    assert len(unfinished) <= CASES // (500 if law is RestitutionLaw.ENERGY else 200), unfinished

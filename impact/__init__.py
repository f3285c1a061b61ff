"""Simultaneous collisions as a state transition diagram (Jia, Mason and Erdmann, 2008).

>>> from impact import Ball, Contact, TwoBallDrop, collide
>>> ball = Ball(mass=0.0027, radius=0.020)
>>> drop = TwoBallDrop(upper=ball, lower=ball, approach_velocity=-3.0,
...                    ball_ball=Contact(restitution=0.807755),
...                    ball_table=Contact(restitution=0.846529, stiffness=10.0))
>>> print(collide(drop))
velocities 2.33819, 0.559932 in states S1 S3 S1 S2; energy loss 0.0043461 J

Map, in reading order:

=============  ===============================================================================
bodies         `Ball`, `Cue`
contact        `Contact` and the vocabulary: phases, modes, events, laws of restitution
drop, shot     the paper's scenes: `TwoBallDrop`, `BallColumn`, `BallChain`, `CueShot`
rigid          `RigidBody`, `Touch`, `assemble`: scenes of your own
system         `ImpactSystem`: what every scene is reduced to
diagram        `collide`, and the algorithm in ten lines: `follow_diagram`
evolve         inside a state: steps and events
series         the equations of motion as Taylor series
friction       sliding and sticking; `starting`, `sticking`: between the two
transition     between states: contacts begin, turn and end
collision      what came out: `Collision`, `Segment`
many           `collide_many`, for thousands of cases (`batches` turns parameters into rows)
roll, path     after the shot: flight, sliding, rolling, rest
kernel         the compiler, and the data every compiled function works on (`scaling`, `record`)
=============  ===============================================================================

Notation:

=============  ==========================  =====================================================
paper          here                        meaning
=============  ==========================  =====================================================
v, ω           velocity, angular_velocity  of a body, up positive
I₁, I₂         impulses                    normal impulse p_n of contact 1 (upper), 2 (lower)
I₁⊥, I₂⊥       tangential_impulses         friction impulse p_t
x₁, x₂         compression                 δ = -x, shortening of the virtual spring
k₁, k₂         stiffness                   k_cb, k_bt for a shot
E₁, E₂         elastic_energy              energy in the virtual spring
e₁, e₂         restitution                 e_cb, e_bt for a shot
μ_cb, μ_bt     friction                    Coulomb's coefficient
S₁, S₂, S₃     states                      both contacts active, only the lower, only the upper
n, z, c        normal, up, direction       of tip contact, table contact, cue
=============  ==========================  =====================================================

The equations, and what in the paper is misprinted: `MODEL.md` beside this file.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from impact.bodies import Ball, Cue
from impact.collision import Collision, ConvergenceError, Segment
from impact.contact import Contact, ContactMode, Event, Phase, RestitutionLaw
from impact.drop import BallChain, BallColumn, TwoBallDrop
from impact.path import Motion, Path, Stretch
from impact.rigid import RigidBody, Touch, assemble
from impact.roll import Cloth, roll
from impact.shot import CueShot, ShotOutcome
from impact.system import ImpactSystem

if TYPE_CHECKING:
    from impact.diagram import collide
    from impact.many import ManyDrops, ManyShots, collide_many

__all__ = [
    "Ball",
    "BallChain",
    "BallColumn",
    "Cloth",
    "Collision",
    "Contact",
    "ContactMode",
    "ConvergenceError",
    "Cue",
    "CueShot",
    "Event",
    "ImpactSystem",
    "ManyDrops",
    "ManyShots",
    "Motion",
    "Path",
    "Phase",
    "RestitutionLaw",
    "RigidBody",
    "Segment",
    "ShotOutcome",
    "Stretch",
    "Touch",
    "TwoBallDrop",
    "assemble",
    "collide",
    "collide_many",
    "roll",
]


def __getattr__(name: str) -> Any:
    """Load the compiled engine when it is first asked for, so that importing bodies stays quick."""
    if name == "collide":
        from impact import diagram

        return diagram.collide
    if name in ("collide_many", "ManyDrops", "ManyShots"):
        from impact import many

        return getattr(many, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

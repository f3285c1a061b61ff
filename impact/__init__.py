"""Simultaneous collisions as a state transition diagram (Jia, Mason and Erdmann, 2008).

>>> from impact import Ball, Contact, TwoBallDrop, collide
>>> ball = Ball(mass=0.0027, radius=0.020)
>>> drop = TwoBallDrop(upper=ball, lower=ball, approach_velocity=-3.0,
...                    ball_ball=Contact(restitution=0.807755),
...                    ball_table=Contact(restitution=0.846529, stiffness=10.0))
>>> print(collide(drop))
velocities 2.33819, 0.559932 in states S1 S3 S1 S2; energy loss 0.0043461 J
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from impact.bodies import Ball, Cue
from impact.collision import Collision, ConvergenceError, Segment
from impact.contact import Contact, ContactMode, Event, Phase, RestitutionLaw
from impact.drop import BallChain, BallColumn, TwoBallDrop
from impact.rigid import RigidBody, Touch, assemble
from impact.roll import Cloth, Motion, Path, Stretch, roll
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

"""Arrays of parameters turned into rows of collisions with two contacts each."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from impact._checks import Array
from impact.contact import Contact
from impact.drop import DROP_JACOBIAN, TwoBallDrop
from impact.kernel import CONTACT
from impact.shot import CueShot, shot_inverse_mass, shot_jacobian

Parameters = Mapping[str, npt.ArrayLike]

LARGEST = float(np.finfo(np.float64).max)
SMALLEST = float(np.nextafter(0.0, 1.0))
POSITIVE = (SMALLEST, LARGEST, "positive")
NEGATIVE = (-LARGEST, -SMALLEST, "negative")
NONNEGATIVE = (0.0, LARGEST, "zero or more")
AT_LEAST_ONE = (1.0, LARGEST, "at least 1")
FRACTION = (0.0, 1.0, "within [0, 1]")
FINITE = (-LARGEST, LARGEST, "finite")

Rules = Mapping[str, tuple[npt.ArrayLike, tuple[float, float, str]]]
"""Per parameter its default and its rule: lowest and highest value, and the rule in words."""


class Batch(NamedTuple):
    """Rows of collisions in generalized coordinates with diagonal inertia."""

    contacts: npt.NDArray[np.void]  # (N, 2) of dtype CONTACT
    inverse_mass: Array  # (N, d)
    jacobian: Array  # (N or 1, 2, r, d)
    velocity: Array  # (N, d)


def drop_batch(template: TwoBallDrop, parameters: Parameters) -> Batch:
    """Rows of two-ball drops."""
    rules: Rules = {
        "upper_mass": (template.upper.mass, POSITIVE),
        "lower_mass": (template.lower.mass, POSITIVE),
        "ball_ball_restitution": (template.ball_ball.restitution, FRACTION),
        "ball_table_restitution": (template.ball_table.restitution, FRACTION),
        "ball_ball_exponent": (template.ball_ball.exponent, AT_LEAST_ONE),
        "ball_table_exponent": (template.ball_table.exponent, AT_LEAST_ONE),
        "stiffness_ratio": (template.ball_table.stiffness / template.ball_ball.stiffness, POSITIVE),
        "approach_velocity": (template.approach_velocity, NEGATIVE),
    }
    values = _broadcast(rules, parameters)
    approach = values["approach_velocity"]
    return Batch(
        _contacts(values, ("ball_ball", "ball_table"), template.ball_ball),
        1.0 / np.column_stack([values["upper_mass"], values["lower_mass"]]),
        DROP_JACOBIAN[np.newaxis],
        np.column_stack([approach, np.zeros_like(approach)]),
    )


def shot_batch(template: CueShot, parameters: Parameters) -> Batch:
    """Rows of cue shots."""
    rules: Rules = {
        "normal": (np.asarray(template.normal, dtype=np.float64), FINITE),
        "cue_velocity": (np.asarray(template.cue_velocity, dtype=np.float64), FINITE),
        "ball_mass": (template.ball.mass, POSITIVE),
        "cue_mass": (template.cue.mass, POSITIVE),
        "tip_ball_restitution": (template.tip_ball.restitution, FRACTION),
        "tip_ball_friction": (template.tip_ball.friction, NONNEGATIVE),
        "tip_ball_exponent": (template.tip_ball.exponent, AT_LEAST_ONE),
        "ball_table_restitution": (template.ball_table.restitution, FRACTION),
        "ball_table_friction": (template.ball_table.friction, NONNEGATIVE),
        "ball_table_exponent": (template.ball_table.exponent, AT_LEAST_ONE),
        "stiffness_ratio": (template.ball_table.stiffness / template.tip_ball.stiffness, POSITIVE),
    }
    values = _broadcast(rules, parameters)
    normal, cue_velocity = values["normal"], values["cue_velocity"]
    wrong = (normal * cue_velocity).sum(axis=1) >= 0.0
    if wrong.any():
        row = int(np.flatnonzero(wrong)[0])
        raise ValueError(f"cue_velocity must point into the ball, against normal, got otherwise in row {row}")
    speed = np.linalg.norm(cue_velocity, axis=1)
    ball = template.ball
    inertia = ball.inertia_factor * values["ball_mass"] * ball.radius**2
    return Batch(
        _contacts(values, ("tip_ball", "ball_table"), template.tip_ball),
        shot_inverse_mass(values["ball_mass"], values["cue_mass"], inertia),
        shot_jacobian(
            normal / np.linalg.norm(normal, axis=1, keepdims=True),
            cue_velocity / speed[:, np.newaxis],
            ball.radius,
        ),
        np.column_stack([speed, np.zeros((len(speed), 6))]),
    )


def _contacts(values: Mapping[str, Array], names: tuple[str, str], upper: Contact) -> npt.NDArray[np.void]:
    contacts = np.zeros((len(values["stiffness_ratio"]), 2), CONTACT)
    for index, name in enumerate(names):
        for quantity in ("restitution", "friction", "exponent"):
            contacts[quantity][:, index] = values.get(f"{name}_{quantity}", 0.0)
    contacts["stiffness"][:, 0] = upper.stiffness
    contacts["stiffness"][:, 1] = upper.stiffness * values["stiffness_ratio"]
    return contacts


def _broadcast(rules: Rules, parameters: Parameters) -> dict[str, Array]:
    """Check each parameter against its rule and bring all of them to one number of rows."""
    unknown = sorted(set(parameters) - set(rules))
    if unknown:
        raise TypeError(f"unknown parameters {', '.join(unknown)}; allowed are {', '.join(rules)}")
    given = {}
    for name, (default, (low, high, rule)) in rules.items():
        trailing = np.shape(default)
        values = np.asarray(parameters.get(name, default), dtype=np.float64)
        if values.shape[values.ndim - len(trailing) :] != trailing or values.ndim > len(trailing) + 1:
            raise ValueError(f"{name} must have shape {('N', *trailing)}, got {values.shape}")
        wrong = ~((values >= low) & (values <= high))
        if wrong.any():
            raise ValueError(f"{name} must be {rule}, got {values[wrong].flat[0]}")
        given[name] = values.reshape(-1, *trailing)
    lengths = {name: len(values) for name, values in given.items() if len(values) != 1}
    count = next(iter(lengths.values()), 1)
    if any(length != count for length in lengths.values()):
        raise ValueError(f"parameters must have one number of rows, got {lengths}")
    return {name: np.broadcast_to(values, (count, *values.shape[1:])) for name, values in given.items()}

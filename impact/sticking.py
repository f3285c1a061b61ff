"""Whether contacts without slip stick or start to slide, decided for all of them together.

Friction forces of contacts at rest minimise ``½ fᵀ A f + bᵀ f`` over the product of the discs
``|f_i| ≤ μ_i f_n,i``. Inside its disc a contact has no tangential acceleration: it sticks. On the rim the
acceleration is opposed to the force: it starts to slide that way. So the paper's two tests (does sticking lie
within the cone, and which way does sliding start) are the conditions of one convex minimum, which is found by
going round the contacts.
"""

from __future__ import annotations

import math

from impact.friction import AT_REST, factor_held
from impact.kernel import (
    FRICTIONLESS,
    INACTIVE,
    SLIDING,
    STARTING,
    STICKING,
    Contact,
    Core,
    compiled,
    merged,
)
from impact.starting import best_in_disc, tangential_pull

MOST_ROUNDS = 1000
LEAST_FRICTION = 1e-12
"""Friction below this does nothing that could be seen."""


@compiled
def choose_modes(core: Core) -> None:
    """Set mode, direction and friction force of every active contact from its slip and the normal forces.

    Forces are read from and written to the first column of `core.forces`.
    """
    undecided = 0
    for index in range(core.contacts.size):
        contact = core.contacts[index]
        contact.forces[1, 0], contact.forces[2, 0] = 0.0, 0.0
        if contact.phase != INACTIVE:
            undecided += _begin(contact)
    for _ in range(MOST_ROUNDS if undecided > 1 else undecided):
        if not _go_round(core):
            break
    for index in range(core.contacts.size):
        if core.contacts[index].phase != INACTIVE and core.contacts[index].mode == STICKING:
            _decide(core, index)
    factor_held(core)


@merged
def _begin(contact: Contact) -> int:
    """Let what slips slide, and count a contact at rest as sticking for now: 1 if it is at rest."""
    if contact.friction < LEAST_FRICTION:
        contact.mode = FRICTIONLESS
        return 0
    slip = math.hypot(contact.velocity[1], contact.velocity[2])
    if slip <= AT_REST * contact.slowest:
        contact.mode = STICKING
        contact.velocity[1], contact.velocity[2] = 0.0, 0.0
        return 1
    contact.mode = SLIDING
    contact.direction_1 = contact.velocity[1] / slip
    contact.direction_2 = contact.velocity[2] / slip
    limit = contact.friction * contact.forces[0, 0]
    contact.forces[1, 0] = -limit * contact.direction_1
    contact.forces[2, 0] = -limit * contact.direction_2
    return 0


@merged
def _go_round(core: Core) -> bool:
    """Find the best force of each undecided contact, given the others; say whether any changed."""
    changed = False
    for index in range(core.contacts.size):
        contact = core.contacts[index]
        if contact.phase == INACTIVE or contact.mode != STICKING:
            continue
        forces = contact.forces
        before_1, before_2 = forces[1, 0], forces[2, 0]
        forces[1, 0], forces[2, 0] = 0.0, 0.0
        pull_1, pull_2 = tangential_pull(core, index, 0)
        limit = contact.friction * forces[0, 0]
        forces[1, 0], forces[2, 0] = best_in_disc(core, index, pull_1, pull_2, limit)
        changed = changed or math.hypot(forces[1, 0] - before_1, forces[2, 0] - before_2) > 1e-14 * limit
    return changed


@merged
def _decide(core: Core, index: int) -> None:
    """Let a contact whose friction is on the rim of its disc start to slide against it.

    One that has no normal force yet has no friction either; it slides wherever it is pulled.
    """
    contact = core.contacts[index]
    limit = contact.friction * contact.forces[0, 0]
    force_1, force_2 = contact.forces[1, 0], contact.forces[2, 0]
    if limit <= 0.0:
        pull_1, pull_2 = tangential_pull(core, index, 0)
        force_1, force_2 = -pull_1, -pull_2
    size = math.hypot(force_1, force_2)
    if size > 0.0 and size >= limit * (1.0 - 1e-10):
        contact.mode = STARTING
        contact.direction_1 = -force_1 / size
        contact.direction_2 = -force_2 / size

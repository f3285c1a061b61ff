"""The start of sliding out of rest, as a series that is exact from the first moment.

With slip velocity ``u_t = ρ û`` the equation of a sliding contact is ``ρ' û + ρ û' = b - μ f_n A û``, where b
is the tangential acceleration by everything but its own friction. At ρ = 0 the direction cannot be read off
the slip velocity, and just after it is drawn so fast to its balance that the equation is stiff. But its
solution through ρ = 0 has a series: the first term solves ``(μ f_n A + λ) û = b`` with ``|û| = 1``, which is
the paper's "starts sliding in the direction of" the acceleration (Section 3.1), and every later one is linear
in ``û_j`` and in the term of ``λ = ρ'``.
"""

from __future__ import annotations

import math

from impact._checks import Array
from impact.kernel import DIRECTION_1, DIRECTION_2, GROWTH, Core, compiled


@compiled
def starting_term(core: Core, index: int, order: int) -> float:
    """Write one term of the friction force where sliding starts; return by how much it changed."""
    contact = core.contacts[index]
    row = 3 * index
    before_1, before_2 = core.forces[row + 1, order], core.forces[row + 2, order]
    core.forces[row + 1, order], core.forces[row + 2, order] = 0.0, 0.0
    pull_1, pull_2 = tangential_pull(core, row, order)
    if contact.onset < 0 and (pull_1 != 0.0 or pull_2 != 0.0 or core.forces[row, order] != 0.0):
        contact.onset = order
    if contact.onset == order:
        _first_direction(core, index, order, pull_1, pull_2)
    elif contact.onset >= 0:
        _later_direction(core, index, order, pull_1, pull_2)
    if contact.onset >= 0:
        slip = core.slips[index]
        for lower in range(contact.onset, order + 1):
            force = contact.friction * core.forces[row, lower]
            core.forces[row + 1, order] -= force * slip[DIRECTION_1, order - lower]
            core.forces[row + 2, order] -= force * slip[DIRECTION_2, order - lower]
    return math.hypot(core.forces[row + 1, order] - before_1, core.forces[row + 2, order] - before_2)


@compiled
def tangential_pull(core: Core, row: int, order: int) -> tuple[float, float]:
    """Term of the tangential acceleration by all forces but the contact's own friction."""
    pull_1, pull_2 = 0.0, 0.0
    for column in range(core.velocity.size):
        pull_1 += core.delassus[row + 1, column] * core.forces[column, order]
        pull_2 += core.delassus[row + 2, column] * core.forces[column, order]
    return pull_1, pull_2


@compiled
def _first_direction(core: Core, index: int, order: int, pull_1: float, pull_2: float) -> None:
    """Direction in which sliding starts, and how fast it grows."""
    contact = core.contacts[index]
    row = 3 * index
    slip = core.slips[index]
    limit = contact.friction * core.forces[row, order]
    force_1, force_2 = best_in_disc(core, row, pull_1, pull_2, limit)
    size = math.hypot(force_1, force_2)
    if size > 0.0:
        slip[DIRECTION_1, 0], slip[DIRECTION_2, 0] = -force_1 / size, -force_2 / size
    else:
        size = max(math.hypot(pull_1, pull_2), 1e-300)
        slip[DIRECTION_1, 0], slip[DIRECTION_2, 0] = pull_1 / size, pull_2 / size
    contact.direction_1, contact.direction_2 = slip[DIRECTION_1, 0], slip[DIRECTION_2, 0]
    drag_1 = limit * _along(core, row + 1, slip, 0)
    drag_2 = limit * _along(core, row + 2, slip, 0)
    slip[GROWTH, order] = contact.direction_1 * (pull_1 - drag_1) + contact.direction_2 * (pull_2 - drag_2)


@compiled
def _along(core: Core, row: int, slip: Array, order: int) -> float:
    """One component of ``A û`` for one term of the direction."""
    tangent = row - row % 3 + 1
    return float(
        core.delassus[row, tangent] * slip[DIRECTION_1, order]
        + core.delassus[row, tangent + 1] * slip[DIRECTION_2, order]
    )


@compiled
def _later_direction(core: Core, index: int, order: int, pull_1: float, pull_2: float) -> None:
    """Solve for one later term of direction and growth: three linear equations."""
    contact = core.contacts[index]
    onset = contact.onset
    term = order - onset
    row = 3 * index
    slip = core.slips[index]
    slip[DIRECTION_1, term], slip[DIRECTION_2, term], slip[GROWTH, order] = 0.0, 0.0, 0.0
    for lower in range(onset + 1, order + 1):
        force = contact.friction * core.forces[row, lower]
        pull_1 -= force * _along(core, row + 1, slip, order - lower)
        pull_2 -= force * _along(core, row + 2, slip, order - lower)
        pull_1 -= slip[GROWTH, lower] * slip[DIRECTION_1, order - lower]
        pull_2 -= slip[GROWTH, lower] * slip[DIRECTION_2, order - lower]
    for lower in range(onset + 2, order + 1):
        turning = slip[GROWTH, lower - 1] / lower * (order - lower + 1)
        pull_1 -= turning * slip[DIRECTION_1, order - lower + 1]
        pull_2 -= turning * slip[DIRECTION_2, order - lower + 1]
    length = 0.0
    for lower in range(1, term):
        length -= 0.5 * slip[DIRECTION_1, lower] * slip[DIRECTION_1, term - lower]
        length -= 0.5 * slip[DIRECTION_2, lower] * slip[DIRECTION_2, term - lower]
    # along û_0 the unknown is the growth, across it the turn
    ahead_1, ahead_2 = slip[DIRECTION_1, 0], slip[DIRECTION_2, 0]
    friction = contact.friction * core.forces[row, onset]
    stiff = slip[GROWTH, onset] * (1.0 + term / (onset + 1.0))
    first_1 = friction * core.delassus[row + 1, row + 1] + stiff
    mixed = friction * core.delassus[row + 1, row + 2]
    second_2 = friction * core.delassus[row + 2, row + 2] + stiff
    pull_1 -= length * (first_1 * ahead_1 + mixed * ahead_2)
    pull_2 -= length * (mixed * ahead_1 + second_2 * ahead_2)
    across_1, across_2 = -ahead_2, ahead_1
    image_1 = first_1 * across_1 + mixed * across_2
    image_2 = mixed * across_1 + second_2 * across_2
    resistance = across_1 * image_1 + across_2 * image_2
    turn = (across_1 * pull_1 + across_2 * pull_2) / resistance if resistance > 1e-12 else 0.0
    slip[DIRECTION_1, term] = length * ahead_1 + turn * across_1
    slip[DIRECTION_2, term] = length * ahead_2 + turn * across_2
    slip[GROWTH, order] = ahead_1 * (pull_1 - turn * image_1) + ahead_2 * (pull_2 - turn * image_2)


@compiled
def best_in_disc(core: Core, row: int, pull_1: float, pull_2: float, limit: float) -> tuple[float, float]:
    """Minimum of ``½ fᵀ A f + pullᵀ f`` within ``|f| ≤ limit``.

    On the rim ``(A + λ) f = -pull`` with the λ that gives the length; Newton on 1 / |f| finds it (J. J. Moré,
    D. C. Sorensen, SIAM J. Sci. Stat. Comput. 4 (1983) 553-572, doi:10.1137/0904038).
    """
    if limit <= 0.0:
        return 0.0, 0.0
    mixed = core.delassus[row + 1, row + 2]
    shift = 1e-15
    force_1, force_2 = 0.0, 0.0
    for _ in range(60):
        first = core.delassus[row + 1, row + 1] + shift
        second = core.delassus[row + 2, row + 2] + shift
        determinant = first * second - mixed * mixed
        force_1 = (mixed * pull_2 - second * pull_1) / determinant
        force_2 = (mixed * pull_1 - first * pull_2) / determinant
        length = math.hypot(force_1, force_2)
        if length <= limit * (1.0 + 1e-14):
            break
        solved_1 = (second * force_1 - mixed * force_2) / determinant
        solved_2 = (first * force_2 - mixed * force_1) / determinant
        slope = (force_1 * solved_1 + force_2 * solved_2) / length**2
        shift += (length - limit) / (limit * slope)
    return force_1, force_2

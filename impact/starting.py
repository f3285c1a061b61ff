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

from impact.kernel import DIRECTION_1, DIRECTION_2, GROWTH, Core, acceleration, compiled, merged


@compiled
def starting_term(core: Core, index: int, order: int) -> float:
    """Write one term of the friction force where sliding starts; return by how much it changed."""
    contact = core.contacts[index]
    forces, slip = contact.forces, contact.slips
    before_1, before_2 = forces[1, order], forces[2, order]
    forces[1, order], forces[2, order] = 0.0, 0.0
    pull_1, pull_2 = tangential_pull(core, index, order)
    if contact.onset < 0 and (pull_1 != 0.0 or pull_2 != 0.0 or forces[0, order] != 0.0):
        contact.onset = order
    if contact.onset == order:
        _first_direction(core, index, pull_1, pull_2)
    elif contact.onset >= 0:
        _later_direction(core, index, order)
    if contact.onset >= 0:
        along_1, along_2 = 0.0, 0.0
        for lower in range(contact.onset, order + 1):
            along_1 += forces[0, lower] * slip[DIRECTION_1, order - lower]
            along_2 += forces[0, lower] * slip[DIRECTION_2, order - lower]
        forces[1, order], forces[2, order] = -contact.friction * along_1, -contact.friction * along_2
    return math.hypot(forces[1, order] - before_1, forces[2, order] - before_2)


@compiled
def tangential_pull(core: Core, index: int, order: int) -> tuple[float, float]:
    """Term of the tangential acceleration by all forces; by all others, if the contact's own are zero."""
    return acceleration(core, 3 * index + 1, order), acceleration(core, 3 * index + 2, order)


@compiled
def _first_direction(core: Core, index: int, pull_1: float, pull_2: float) -> None:
    """Direction in which sliding starts, and how fast it grows."""
    contact = core.contacts[index]
    slip = contact.slips
    limit = contact.friction * contact.forces[0, contact.onset]
    force_1, force_2 = best_in_disc(core, index, pull_1, pull_2, limit)
    size = math.hypot(force_1, force_2)
    if size > 0.0:
        ahead_1, ahead_2 = -force_1 / size, -force_2 / size
    else:
        size = max(math.hypot(pull_1, pull_2), 1e-300)
        ahead_1, ahead_2 = pull_1 / size, pull_2 / size
    contact.direction_1, contact.direction_2 = ahead_1, ahead_2
    slip[DIRECTION_1, 0], slip[DIRECTION_2, 0] = ahead_1, ahead_2
    first, mixed, second = tangential_response(core, index)
    drag_1 = limit * (first * ahead_1 + mixed * ahead_2)
    drag_2 = limit * (mixed * ahead_1 + second * ahead_2)
    slip[GROWTH, contact.onset] = ahead_1 * (pull_1 - drag_1) + ahead_2 * (pull_2 - drag_2)


@compiled
def tangential_response(core: Core, index: int) -> tuple[float, float, float]:
    """Return the contact's own tangential block of A: its diagonal entries, the mixed one between them."""
    row = 3 * index + 1
    return core.delassus[row, row], core.delassus[row, row + 1], core.delassus[row + 1, row + 1]


@compiled
def _later_direction(core: Core, index: int, order: int) -> None:
    """Solve for one later term of direction and growth: three linear equations."""
    contact = core.contacts[index]
    slip = contact.slips
    onset = contact.onset
    term = order - onset
    slip[DIRECTION_1, term], slip[DIRECTION_2, term], slip[GROWTH, order] = 0.0, 0.0, 0.0
    pull_1, pull_2 = _known_pull(core, index, order)
    length = 0.0
    for lower in range(1, term):
        length -= 0.5 * slip[DIRECTION_1, lower] * slip[DIRECTION_1, term - lower]
        length -= 0.5 * slip[DIRECTION_2, lower] * slip[DIRECTION_2, term - lower]
    # along û_0 the unknown is the growth, across it the turn
    ahead_1, ahead_2 = slip[DIRECTION_1, 0], slip[DIRECTION_2, 0]
    friction = contact.friction * contact.forces[0, onset]
    stiff = slip[GROWTH, onset] * (1.0 + term / (onset + 1.0))
    first, mixed, second = tangential_response(core, index)
    first_1 = friction * first + stiff
    second_2 = friction * second + stiff
    mixed *= friction
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


@merged
def _known_pull(core: Core, index: int, order: int) -> tuple[float, float]:
    """All of the equation's term that does not contain the unknown terms of direction and growth."""
    contact = core.contacts[index]
    slip = contact.slips
    first, mixed, second = tangential_response(core, index)
    pull_1, pull_2 = tangential_pull(core, index, order)
    for lower in range(contact.onset + 1, order + 1):
        force = contact.friction * contact.forces[0, lower]
        ahead_1, ahead_2 = slip[DIRECTION_1, order - lower], slip[DIRECTION_2, order - lower]
        pull_1 -= force * (first * ahead_1 + mixed * ahead_2) + slip[GROWTH, lower] * ahead_1
        pull_2 -= force * (mixed * ahead_1 + second * ahead_2) + slip[GROWTH, lower] * ahead_2
    for lower in range(contact.onset + 2, order + 1):
        turning = slip[GROWTH, lower - 1] / lower * (order - lower + 1)
        pull_1 -= turning * slip[DIRECTION_1, order - lower + 1]
        pull_2 -= turning * slip[DIRECTION_2, order - lower + 1]
    return pull_1, pull_2


@compiled
def best_in_disc(core: Core, index: int, pull_1: float, pull_2: float, limit: float) -> tuple[float, float]:
    """Minimum of ``½ fᵀ A f + pullᵀ f`` within ``|f| ≤ limit``.

    On the rim ``(A + λ) f = -pull`` with the λ that gives the length; Newton on 1 / |f| finds it (J. J. Moré,
    D. C. Sorensen, SIAM J. Sci. Stat. Comput. 4 (1983) 553-572, doi:10.1137/0904038).
    """
    if limit <= 0.0:
        return 0.0, 0.0
    own_1, mixed, own_2 = tangential_response(core, index)
    shift = 1e-15
    force_1, force_2 = 0.0, 0.0
    for _ in range(60):
        first = own_1 + shift
        second = own_2 + shift
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

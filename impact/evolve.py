"""Evolution inside a state until something happens: steps along the series and the location of events.

What may happen is watched through *margins*: each is positive as long as a contact stays in its phase and
mode.
"""

from __future__ import annotations

import math

from impact.friction import friction_margin, turn_directions
from impact.kernel import (
    COMPRESSION,
    FRICTIONLESS,
    HEAT,
    INACTIVE,
    SLIDING,
    SPEED_FLOOR,
    STARTING,
    Contact,
    Core,
    compiled,
    inlined,
    merged,
    slope_at,
    value_at,
)
from impact.record import Record, note_sample
from impact.series import FOOT, expand, longest_step

EVENT_TOLERANCE = 2e-14
LOWEST_TOLERANCE = 1e-8
"""Of the time of a lowest point, relative; the lowest value itself is then exact to rounding."""
MOST_GUESSES = 100
SAMPLES_PER_PART = 6
MOST_PARTS = 8
MOST_STEPS = 100_000


@merged
def evolve(core: Core, record: Record) -> bool:
    """Advance to the next event; False if that takes more than `MOST_STEPS` steps."""
    for _ in range(MOST_STEPS):
        expand(core)
        frequency = _fastest(core)
        step = min(longest_step(core), MOST_PARTS / frequency)
        parts = int(step * frequency) + 1
        event = first_event(core, step, parts)
        note_path(core, record, min(step, event), parts)
        absorb(core, min(step, event))
        if event <= step or (core.rows > 1 and not turn_directions(core)):
            return True
    return False


@merged
def _fastest(core: Core) -> float:
    """Bound on the angular frequency of the oscillation of the active contacts."""
    total = 0.0
    for index in range(core.contacts.size):
        contact = core.contacts[index]
        if contact.phase != INACTIVE:
            depth = max(contact.compression, FOOT)
            stiffness = contact.stiffness * contact.exponent * depth ** (contact.exponent - 1.0)
            total += stiffness * core.delassus[index * core.rows, index * core.rows]
    return math.sqrt(total)


@compiled
def first_event(core: Core, step: float, parts: int) -> float:
    """Time of the first event within `step`, looked for in so many parts; infinite if there is none."""
    first = math.inf
    for index in range(core.contacts.size):
        contact = core.contacts[index]
        left = 0.0
        for part in range(1, parts + 1):
            right = step * part / parts
            if left >= first:
                break
            if margin(contact, right) <= 0.0:
                first = min(first, _root(contact, left, right))
                break
            if _dips(contact, left, right):
                lowest = _lowest(contact, left, right)
                if margin(contact, lowest) <= 0.0:
                    first = min(first, _root(contact, left, lowest))
                    break
            left = right
    return first


@inlined
def margin(contact: Contact, time: float) -> float:
    """How far a contact is from leaving its phase or mode, at a time from now; positive while it stays."""
    return min(phase_margin(contact, time), mode_margin(contact, time))


@inlined
def phase_margin(contact: Contact, time: float) -> float:
    """How far a contact is from leaving its phase."""
    normal_velocity = value_at(contact.velocities[0], time)
    if contact.phase == INACTIVE:
        return normal_velocity + SPEED_FLOOR
    if contact.phase == COMPRESSION:
        return SPEED_FLOOR - normal_velocity
    return min(normal_velocity + SPEED_FLOOR, remaining(contact, time))


@inlined
def mode_margin(contact: Contact, time: float) -> float:
    """How far a contact is from leaving its mode of friction."""
    if contact.mode == FRICTIONLESS or contact.phase == INACTIVE:
        return math.inf
    return friction_margin(contact, time)


@inlined
def remaining(contact: Contact, time: float) -> float:
    """How far an active contact is from the end of its restitution.

    Under Poisson's law that is where its impulse is paid, or its spring empty if that comes first.
    """
    compression = value_at(contact.compressions, time)
    if contact.last_impulse == math.inf:
        return float(compression - contact.rest_compression)
    impulse = contact.impulse[0] + value_at(contact.impulses[0], time)
    return float(min(compression, contact.last_impulse - impulse))


@inlined
def _dips(contact: Contact, left: float, right: float) -> bool:
    """Whether a normal velocity may have left its phase and returned between two times.

    The tangents at both ends meet below the curve; only if they meet below zero can it dip.
    """
    velocities = contact.velocities[0]
    sign = -1.0 if contact.phase == COMPRESSION else 1.0
    before = sign * slope_at(velocities, left)
    after = sign * slope_at(velocities, right)
    if before >= 0.0 or after <= 0.0:
        return False
    start = sign * value_at(velocities, left)
    stop = sign * value_at(velocities, right)
    meeting = (stop - start - after * (right - left)) / (before - after)
    return bool(start + before * meeting < 0.0)


@compiled
def _lowest(contact: Contact, left: float, right: float) -> float:
    """Time where the normal acceleration of a contact changes sign: there its velocity is lowest."""
    velocities = contact.velocities[0]
    sign = -1.0 if contact.phase == COMPRESSION else 1.0
    falling = sign * slope_at(velocities, left)
    rising = sign * slope_at(velocities, right)
    finest = LOWEST_TOLERANCE * (right - left)
    side = 0
    for iteration in range(MOST_GUESSES):
        guess = between(left, right, falling, rising, iteration)
        slope = sign * slope_at(velocities, guess)
        if slope < 0.0:
            moved, left, falling = guess - left, guess, slope
            rising *= 0.5 if side < 0 else 1.0
            side = -1
        else:
            moved, right, rising = right - guess, guess, slope
            falling *= 0.5 if side > 0 else 1.0
            side = 1
        if moved <= finest or right - left <= finest:
            break
    return right


@compiled
def _root(contact: Contact, left: float, right: float) -> float:
    """Time where the margin of a contact vanishes."""
    above = max(margin(contact, left), 1e-300)
    below = margin(contact, right)
    side = 0
    for iteration in range(MOST_GUESSES):
        guess = between(left, right, above, below, iteration)
        value = margin(contact, guess)
        if abs(value) <= EVENT_TOLERANCE or right - left <= 1e-15 * right:
            return guess
        if value > 0.0:
            left, above = guess, value
            below *= 0.5 if side < 0 else 1.0
            side = -1
        else:
            right, below = guess, value
            above *= 0.5 if side > 0 else 1.0
            side = 1
    return right


@compiled
def between(left: float, right: float, at_left: float, at_right: float, iteration: int) -> float:
    """Guess a root between two times: a secant step, and a halving if that has gone on for long.

    The callers halve the value at an end that stays where it is twice (the Illinois rule; M. Dowell,
    P. Jarratt, BIT 11 (1971) 168-174, doi:10.1007/BF01934364), so that both ends close in.
    """
    guess = (left * at_right - right * at_left) / (at_right - at_left)
    if iteration % 16 == 15 or not left < guess < right:
        return 0.5 * (left + right)
    return guess


@merged
def note_path(core: Core, record: Record, until: float, parts: int) -> None:
    """Write down samples of the path, if there is room for any."""
    if record.samples.shape[0] == 0:
        return
    samples = SAMPLES_PER_PART * parts
    for sample in range(samples + 1):
        note_sample(core, record, until * sample / samples)


@compiled
def absorb(core: Core, time: float) -> None:
    """Move to a later time; Δp starts again from zero."""
    for index in range(core.contacts.size):
        contact = core.contacts[index]
        contact.compression = value_at(contact.compressions, time)
        contact.compressions[0] = contact.compression
        if contact.phase != INACTIVE and contact.mode in (STARTING, SLIDING):
            contact.friction_work += value_at(contact.slips[HEAT], time)
        for axis in range(core.rows):
            contact.velocity[axis] = value_at(contact.velocities[axis], time)
            contact.velocities[axis, 0] = contact.velocity[axis]
            contact.forces[axis, 0] = value_at(contact.forces[axis], time)
            contact.impulse[axis] += value_at(contact.impulses[axis], time)
            contact.impulses[axis, 0] = 0.0

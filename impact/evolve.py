"""Evolution inside a state until something happens: adaptive steps and the location of events.

What may happen is watched through *margins*: each is positive as long as a contact stays in its phase.
"""

from __future__ import annotations

import math

from impact.kernel import (
    COMPRESSION,
    END,
    INACTIVE,
    POINT,
    RATES,
    SLOPES,
    SPEED_FLOOR,
    STEP,
    TRIAL,
    VELOCITY,
    Core,
    acceleration,
    compiled,
    contact_velocity,
    load_point,
    rates_at,
)
from impact.record import Record, note_sample
from impact.stepper import interpolate, prepare_dense, try_step
from impact.tableau import STAGES

EVENT_TOLERANCE = 2e-14
SAMPLES_PER_STEP = 6
MOST_STEPS = 200_000


@compiled
def remaining(core: Core, index: int, source: int) -> float:
    """How far an active contact is from the end of its restitution, at a point."""
    contact = core.contacts[index]
    compression = core.work[source, index]
    if core.poisson:
        row = index * core.rows
        impulse = core.impulse[row] + core.work[source, core.contacts.size + row]
        return float(min(compression, contact.last_impulse - impulse))
    return float(compression - contact.rest_compression)


@compiled
def margin(core: Core, index: int, source: int) -> float:
    """How far a contact is from leaving its phase, at a point whose u is in row VELOCITY."""
    normal_velocity = core.work[VELOCITY, index * core.rows]
    phase = core.contacts[index].phase
    if phase == INACTIVE:
        return float(normal_velocity + SPEED_FLOOR)
    if phase == COMPRESSION:
        return float(SPEED_FLOOR - normal_velocity)
    return float(min(normal_velocity + SPEED_FLOOR, remaining(core, index, source)))


@compiled
def smallest_margin(core: Core, source: int) -> float:
    """Smallest margin of all contacts at a point."""
    contact_velocity(core, source)
    smallest = math.inf
    for index in range(core.contacts.size):
        smallest = min(smallest, margin(core, index, source))
    return smallest


@compiled
def _margin_within(core: Core, fraction: float) -> float:
    interpolate(core, fraction, TRIAL)
    return smallest_margin(core, TRIAL)


@compiled
def _first_event(core: Core, right: float) -> float:
    """Fraction of the step where the smallest margin vanishes: secant steps with the Illinois rule."""
    left = 0.0
    above = max(_margin_within(core, 0.0), 1e-300)
    below = _margin_within(core, right)
    for iteration in range(100):
        guess = (left * below - right * above) / (below - above)
        if iteration % 4 == 3 or not left < guess < right:
            guess = 0.5 * (left + right)
        value = _margin_within(core, guess)
        if abs(value) <= EVENT_TOLERANCE or right - left < 1e-15:
            return guess
        if value > 0.0:
            left, above = guess, value
            below *= 0.5
        else:
            right, below = guess, value
            above *= 0.5
    return right


@compiled
def _dips(core: Core, index: int, sign: float, step: float) -> bool:
    """Whether a normal velocity may have left its phase and returned within the step just made.

    The tangents at both ends of the step meet below the curve; only if they meet below zero can it dip.
    """
    row = index * core.rows
    before = sign * acceleration(core, row, SLOPES)
    after = sign * acceleration(core, row, SLOPES + STAGES)
    if before >= 0.0 or after <= 0.0:
        return False
    contact_velocity(core, POINT)
    start = sign * core.work[VELOCITY, row]
    contact_velocity(core, END)
    stop = sign * core.work[VELOCITY, row]
    meeting = (stop - start - after * step) / (before - after)
    return bool(start + before * meeting < 0.0)


@compiled
def _lowest_point(core: Core, index: int, sign: float) -> float:
    """Fraction of the step where the normal acceleration of a contact vanishes, by bisection."""
    left, right = 0.0, 1.0
    while right - left > 1e-12:
        middle = 0.5 * (left + right)
        interpolate(core, middle, TRIAL)
        rates_at(core, TRIAL, RATES)
        if sign * acceleration(core, index * core.rows, RATES) < 0.0:
            left = middle
        else:
            right = middle
    return right


@compiled
def _event_within(core: Core, step: float) -> float:
    """Fraction of the step just made where the first event lies; above 1 if there is none."""
    right = 1.0 if smallest_margin(core, END) <= 0.0 else 2.0
    dense = False
    for index in range(core.contacts.size):
        sign = -1.0 if core.contacts[index].phase == COMPRESSION else 1.0
        if _dips(core, index, sign, step):
            if not dense:
                prepare_dense(core, step)
                dense = True
            lowest = _lowest_point(core, index, sign)
            if lowest < right and _margin_within(core, lowest) <= 0.0:
                right = lowest
    if right > 1.0:
        return right
    if not dense:
        prepare_dense(core, step)
    return _first_event(core, right)


@compiled
def _note_path(core: Core, record: Record, step: float, until: float) -> None:
    prepare_dense(core, step)
    for sample in range(1, SAMPLES_PER_STEP + 1):
        interpolate(core, until * sample / SAMPLES_PER_STEP, TRIAL)
        note_sample(core, record, TRIAL)


@compiled
def _longest_step(core: Core) -> float:
    """One radian of an oscillation faster than any the active contacts can make."""
    total = 0.0
    for index in range(core.contacts.size):
        row = index * core.rows
        if core.contacts[index].phase != INACTIVE:
            total += core.delassus[row, row] * core.contacts[index].peak_stiffness
    return 1.0 / math.sqrt(total)


@compiled
def _absorb(core: Core) -> None:
    """Make the point in row END the new state; Δp starts again from zero."""
    count = core.contacts.size
    contact_velocity(core, END)
    for row in range(core.velocity.size):
        core.velocity[row] = core.work[VELOCITY, row]
        core.impulse[row] += core.work[END, count + row]
    for index in range(count):
        core.contacts[index].compression = core.work[END, index]


@compiled
def evolve(core: Core, record: Record) -> bool:
    """Advance to the next event; False if that takes more than `MOST_STEPS` steps."""
    work = core.work
    load_point(core, POINT)
    note_sample(core, record, POINT)
    rates_at(core, POINT, SLOPES)
    longest = _longest_step(core)
    for _ in range(MOST_STEPS):
        step = min(work[STEP, 0], longest)
        error = try_step(core, step)
        work[STEP, 0] = step * min(4.0, max(0.2, 0.9 * (error + 1e-12) ** -0.125))
        if not error <= 1.0:
            continue
        fraction = _event_within(core, step)
        if record.samples.shape[0] > 0:
            _note_path(core, record, step, min(fraction, 1.0))
        if fraction <= 1.0:
            interpolate(core, fraction, END)
            _absorb(core)
            return True
        for column in range(work.shape[1]):
            work[POINT, column] = work[END, column]
            work[SLOPES, column] = work[SLOPES + STAGES, column]
    return False

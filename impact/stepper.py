"""One Runge-Kutta step of order 8 and its dense output (coefficients and source in `tableau`)."""

from __future__ import annotations

import math

from impact.kernel import DENSE, END, POINT, SLOPES, TRIAL, Core, compiled, rates_at
from impact.tableau import DENSE_WEIGHTS, ERROR_WEIGHTS, STAGE_WEIGHTS, STAGES


@compiled
def _move(core: Core, stage: int, step: float, target: int) -> None:
    """Write the point of a stage into row `target`."""
    work = core.work
    for column in range(work.shape[1]):
        work[target, column] = work[POINT, column]
    for earlier in range(stage):
        weight = STAGE_WEIGHTS[stage, earlier] * step
        if weight != 0.0:
            for column in range(work.shape[1]):
                work[target, column] += weight * work[SLOPES + earlier, column]


@compiled
def try_step(core: Core, step: float) -> float:
    """Step from row POINT to row END and return the error over the tolerance.

    The slope at POINT must be in row SLOPES; the slope at END comes out in row SLOPES + STAGES.
    """
    for stage in range(1, STAGES):
        _move(core, stage, step, TRIAL)
        rates_at(core, TRIAL, SLOPES + stage)
    _move(core, STAGES, step, END)
    rates_at(core, END, SLOPES + STAGES)
    return step * _error(core) / core.tolerance


@compiled
def _error(core: Core) -> float:
    fifth = 0.0
    third = 0.0
    for column in range(core.work.shape[1]):
        error_fifth = 0.0
        error_third = 0.0
        for stage in range(STAGES):
            slope = core.work[SLOPES + stage, column]
            error_fifth += ERROR_WEIGHTS[0, stage] * slope
            error_third += ERROR_WEIGHTS[1, stage] * slope
        fifth += error_fifth**2
        third += error_third**2
    if fifth == 0.0:
        return 0.0
    return fifth / math.sqrt((fifth + 0.01 * third) * core.work.shape[1])


@compiled
def prepare_dense(core: Core, step: float) -> None:
    """Compute the coefficients of the dense output of the step just made."""
    work = core.work
    for stage in range(STAGES + 1, STAGES + 4):
        _move(core, stage, step, TRIAL)
        rates_at(core, TRIAL, SLOPES + stage)
    for column in range(work.shape[1]):
        change = work[END, column] - work[POINT, column]
        first = step * work[SLOPES, column]
        last = step * work[SLOPES + STAGES, column]
        work[DENSE, column] = change
        work[DENSE + 1, column] = first - change
        work[DENSE + 2, column] = 2.0 * change - last - first
        for row in range(4):
            total = 0.0
            for stage in range(STAGES + 4):
                total += DENSE_WEIGHTS[row, stage] * work[SLOPES + stage, column]
            work[DENSE + 3 + row, column] = step * total


@compiled
def interpolate(core: Core, fraction: float, target: int) -> None:
    """Write the point at `fraction` (0 to 1) of the step into row `target`."""
    work = core.work
    rest = 1.0 - fraction
    for column in range(work.shape[1]):
        total = 0.0
        for row in range(6, -1, -1):
            total = (total + work[DENSE + row, column]) * (fraction if row % 2 == 0 else rest)
        work[target, column] = work[POINT, column] + total

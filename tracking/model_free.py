"""Velocities at an impact without any model of flight: a parabola through the frames of each side alone.

Much less precise than flights fitted jointly, but wrong air, gravity, scale or time base cannot bend it.
Where the two disagree, one of those is not what was told.
"""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from tracking.budget import Budget
from tracking.joint import JointFit, Meeting, P, Side, heights, moved

FloatArray = npt.NDArray[np.float64]

FEWEST_FRAMES = 7  # a parabola, and enough frames beyond to tell how they scatter


@dataclass(frozen=True, slots=True, kw_only=True)
class FreeParabola:
    """Velocity at the impact (m/s) and acceleration (m/s²) of one side's frames, with standard deviations.

    All NaN where the side has too few frames.
    """

    velocity: float
    velocity_sd: float
    acceleration: float
    acceleration_sd: float


UNKNOWN = FreeParabola(velocity=np.nan, velocity_sd=np.nan, acceleration=np.nan, acceleration_sd=np.nan)


def free_parabola(side: Side, parameters: FloatArray) -> FreeParabola:
    """Fit a parabola to one side of an impact whose flights have these `parameters`.

    A flight in air is no parabola. The velocity is therefore what a parabola adds to the fitted flight: exact
    where the flight is right, and right to first order where it is not.
    """
    if side.velocity is None or len(side.time) < FEWEST_FRAMES:
        return UNKNOWN
    since = side.time - parameters[P.TIME]
    sd = np.hypot(side.sd, side.shared_sd)
    design = np.column_stack((np.ones_like(since), since, since**2 / 2)) / sd[:, None]
    inverse = np.linalg.pinv(design)
    beyond = (side.height - heights(side, parameters)) / sd
    added = inverse @ beyond
    left = beyond - design @ added
    excess = max(1.0, float(left @ left) / (len(since) - 3))
    spread = np.sqrt(np.sum(inverse**2, axis=1) * excess)
    return FreeParabola(
        velocity=float(parameters[side.velocity] + added[1]),
        velocity_sd=float(spread[1]),
        acceleration=float((inverse @ (side.height / sd))[2]),
        acceleration_sd=float(spread[2]),
    )


def free_parabolas(fit: JointFit, meeting: Meeting, budget: Budget) -> dict[P, FreeParabola]:
    """Fit each side on which a ball moves, by the place of its velocity among the parameters.

    The velocities' standard deviations include what the errors common to all frames do to them.
    """
    meetings = budget.changed(meeting).values()
    changes = [(changed, fit.parameters + moved(fit, meeting, changed)) for changed in meetings]
    found = {}
    for number, side in enumerate(meeting.sides):
        if side.velocity is not None:
            own = free_parabola(side, fit.parameters)
            shared = [
                free_parabola(changed.sides[number], parameters).velocity - own.velocity
                for changed, parameters in changes
            ]
            whole = float(np.linalg.norm([own.velocity_sd, *shared]))
            found[side.velocity] = replace(own, velocity_sd=whole)
    return found

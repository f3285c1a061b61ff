"""Velocities at an impact without any model of flight: a parabola through the frames of each side alone.

Much less precise than flights fitted jointly, but wrong air, gravity, scale or time base cannot bend it.
Where the two disagree, one of those is not what was told.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tracking.joint import P, Side

FloatArray = npt.NDArray[np.float64]

FEWEST_FRAMES = 5  # a parabola and two frames that may contradict it


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


def free_parabola(side: Side, impact: float) -> FreeParabola:
    """Fit a parabola to one side of an impact at the time `impact` (s)."""
    if len(side.time) < FEWEST_FRAMES:
        return UNKNOWN
    since = side.time - impact
    sd = np.hypot(side.sd, side.shared_sd)
    design = np.column_stack((np.ones_like(since), since, since**2 / 2)) / sd[:, None]
    solution, *_ = np.linalg.lstsq(design, side.height / sd, rcond=None)
    residual = side.height / sd - design @ solution
    excess = max(1.0, float(residual @ residual) / (len(since) - 3))
    spread = np.sqrt(np.diag(np.linalg.pinv(design.T @ design)) * excess)
    return FreeParabola(
        velocity=float(solution[1]),
        velocity_sd=float(spread[1]),
        acceleration=float(solution[2]),
        acceleration_sd=float(spread[2]),
    )


def free_parabolas(sides: tuple[Side, ...], impact: float) -> dict[P, FreeParabola]:
    """Fit each side on which a ball moves, by the place of its velocity among the parameters."""
    return {side.velocity: free_parabola(side, impact) for side in sides if side.velocity is not None}

"""From what a player says (where, how steep, how fast) to the vectors of a shot."""

import math

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Vector = tuple[float, float, float]

UP = np.array([0.0, 0.0, 1.0])
AHEAD = np.array([1.0, 0.0, 0.0])
"""Heading of a cue that points straight down."""


def aimed_cue(cue_velocity: Vector | None, speed: float | None, elevation: float | None) -> Vector:
    """Velocity of the cue, m/s, as given, or along x from its speed and its elevation in degrees.

    Raises
    ------
    ValueError
        If it is given in both ways, the speed is not positive, or the elevation beyond the vertical.

    Examples
    --------
    >>> aimed_cue(None, 2.0, 30.0)
    (1.732..., 0.0, -0.99...)
    """
    if cue_velocity is not None:
        if speed is not None or elevation is not None:
            raise ValueError("cue_velocity says speed and elevation too: give either it or those")
        return cue_velocity
    speed = 1.0 if speed is None else speed
    elevation = 0.0 if elevation is None else elevation
    if not 0.0 < speed < math.inf:
        raise ValueError(f"speed must be positive, got {speed:g}")
    if not -90.0 <= elevation <= 90.0:
        raise ValueError(f"elevation must be within [-90, 90] degrees, got {elevation:g}")
    angle = math.radians(elevation)
    return (speed * math.cos(angle), 0.0, -speed * math.sin(angle))


def struck_normal(normal: Vector | None, offset: tuple[float, float] | None, cue_velocity: Vector) -> Vector:
    """Outward normal of the ball where the tip strikes, as given or from the offset, else in the middle.

    Parameters
    ----------
    normal : vector or None
        Of any length.
    offset : (right, up) or None
        Of the struck point from the axis of the cue through the centre, in ball radii, seen along the cue.
    cue_velocity : vector
        m/s.

    Raises
    ------
    ValueError
        If it is given in both ways, or the cue does not move or passes the ball.

    Examples
    --------
    >>> struck_normal(None, (0.0, 0.6), (1.0, 0.0, 0.0))
    (-0.8, 0.0, 0.6)
    """
    if normal is not None:
        if offset is not None:
            raise ValueError("normal and offset both say where the tip strikes: give one of them")
        return normal
    right, above = (0.0, 0.0) if offset is None else offset
    if not right**2 + above**2 < 1.0:
        raise ValueError(
            f"offset must be less than 1 radius, or the cue passes the ball, got {right:g} {above:g}"
        )
    speed = math.sqrt(sum(part**2 for part in cue_velocity))
    if not 0.0 < speed < math.inf:
        raise ValueError(f"cue_velocity must be finite and not zero, got {list(cue_velocity)}")
    along = np.array(cue_velocity) / speed
    sideways = np.cross(along, UP)
    if np.linalg.norm(sideways) < 1e-12:
        sideways = np.cross(AHEAD, UP)
    sideways /= np.linalg.norm(sideways)
    struck = right * sideways + above * np.cross(sideways, along) - math.sqrt(1 - right**2 - above**2) * along
    return (float(struck[0]), float(struck[1]), float(struck[2]))

"""How a ball moves between impacts: straight up and down through air, in closed form.

In air the equation of motion (up positive) is

    (m + C_a m_air) dv/dt = -(m - m_air) g - 1/2 rho C_d pi r**2 v |v|

with m_air = rho 4/3 pi r**3, the mass of the displaced air. Divided by the inertia on the left it needs two
numbers only, ``dv/dt = -gravity (1 + v |v| / terminal_speed**2)``, and those two are a `Flight`. It has
closed solutions for the rising and for the falling ball; `position` and `velocity` join them at the apex, in
either direction of time.

Added mass: a sphere that accelerates takes along fluid worth half the displaced mass (C_a = 1/2, potential
flow; Batchelor, *An Introduction to Fluid Dynamics*, section 6.8, doi:10.1017/CBO9780511800955). The
convention here puts it on the side of the inertia alone: weight and buoyancy are unchanged, gravity and drag
are both divided by the larger inertia, and the terminal speed, where nothing accelerates, does not depend on
it. The drag coefficient of a smooth sphere is 0.4 to 0.5 for Reynolds numbers from 1e3 to 2e5 (Clift, Grace
& Weber, *Bubbles, Drops, and Particles*, 1978, chapter 5, standard drag curve; Brown & Lawler,
doi:10.1061/(ASCE)0733-9372(2003)129:3(222)); a ping-pong ball at 0.4 to 8 m/s lies within that range. Hence
0.45 with a standard uncertainty of 0.05, which also covers air 10 % thinner than told.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

STANDARD_GRAVITY = 9.80665
"""Gravity where nobody says otherwise, m/s² (between 9.78 at the equator and 9.83 at the poles)."""

Floats = NDArray[np.float64]
JUST_ABOVE_MINUS_ONE, JUST_BELOW_MINUS_ONE = np.nextafter(-1.0, [0.0, -2.0])


@dataclass(frozen=True, slots=True, kw_only=True)
class Air:
    """What the ball flies through.

    Attributes
    ----------
    density : float
        Density of the air, kg/m³; 0 is vacuum.
    drag_coefficient, drag_coefficient_sd : float
        Drag coefficient of the ball on its frontal area, and its standard uncertainty.
    added_mass : float
        Mass of air that accelerates with the ball, in units of the displaced mass.

    Raises
    ------
    ValueError
        If one of them is negative or not finite.
    """

    density: float = 1.2
    drag_coefficient: float = 0.45
    drag_coefficient_sd: float = 0.05
    added_mass: float = 0.5

    def __post_init__(self) -> None:
        for name in self.__slots__:
            if not 0 <= getattr(self, name) < math.inf:
                raise ValueError(f"{name} must be at least 0 and finite, got {getattr(self, name)}")


VACUUM = Air(density=0.0)
"""No air at all: the flight is a parabola."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Flight:
    """The two numbers that decide a vertical flight.

    Attributes
    ----------
    gravity : float
        Effective gravity, m/s²: how a ball just let go accelerates, with buoyancy and added mass.
    terminal_speed : float
        Speed at which drag balances weight, m/s; infinite where there is no drag.

    Raises
    ------
    ValueError
        If one of them is not positive, or the gravity is infinite.
    """

    gravity: float
    terminal_speed: float = math.inf

    def __post_init__(self) -> None:
        if not 0 < self.gravity < math.inf:
            raise ValueError(f"gravity must be positive and finite, got {self.gravity}")
        if not self.terminal_speed > 0:
            raise ValueError(f"terminal_speed must be positive, got {self.terminal_speed}")


def flight_of_ball(mass: float, radius: float, air: Air, gravity: float = STANDARD_GRAVITY) -> Flight:
    """Effective gravity and terminal speed of a ball in air.

    Parameters
    ----------
    mass, radius : float
        Mass (kg) and radius (m) of the ball.
    air : Air
        What it flies through.
    gravity : float
        Local gravity, m/s².

    Raises
    ------
    ValueError
        If mass or radius is not positive, or the ball is lighter than the air it displaces.

    Examples
    --------
    >>> ball = flight_of_ball(0.0027, 0.020, Air())
    >>> print(f"{ball.gravity:.4f} m/s², {ball.terminal_speed:.2f} m/s")
    9.5892 m/s², 8.77 m/s
    """
    for name, value in (("mass", mass), ("radius", radius)):
        if not 0 < value < math.inf:
            raise ValueError(f"{name} must be positive and finite, got {value}")
    displaced = air.density * 4 / 3 * math.pi * radius**3
    if mass <= displaced:
        raise ValueError(f"mass must exceed that of the displaced air, {displaced:.3g} kg, got {mass}")
    weight = (mass - displaced) * gravity
    drag = air.density * air.drag_coefficient * math.pi * radius**2 / 2
    terminal_speed = math.sqrt(weight / drag) if drag > 0 else math.inf
    return Flight(gravity=weight / (mass + air.added_mass * displaced), terminal_speed=terminal_speed)


def position(flight: Flight, velocity: ArrayLike, time: ArrayLike) -> Floats:
    """Displacement from where the ball is at time 0.

    Parameters
    ----------
    flight : Flight
        Effective gravity and terminal speed.
    velocity : array_like
        Velocity at time 0, m/s, up positive.
    time : array_like
        Times, s; negative ones look back. Broadcasts with `velocity`.

    Returns
    -------
    ndarray
        ``y(time) - y(0)`` in m, up positive. Not a number at times so early that the ball could not have
        been in flight: drag lets even an infinitely fast one rise for ``pi/2 terminal_speed/gravity`` only.

    Examples
    --------
    One smooth curve through the apex, here half a second before and after a ball is thrown up:

    >>> position(flight_of_ball(0.0027, 0.020, Air()), 2.0, [-0.5, 0.0, 0.5]).round(4)
    array([-2.4622,  0.    , -0.2067])
    """
    velocity, time = np.broadcast_arrays(np.asarray(velocity, float), np.asarray(time, float))
    if math.isinf(flight.terminal_speed):
        return np.asarray(velocity * time - flight.gravity * time**2 / 2)
    up, down, rising, falling = _stretches(flight, velocity, time)
    # ln(cos x + u sin x) and ln(cosh x + s sinh x), written so that nothing cancels where drag is weak
    height = np.log1p(up * np.sin(rising) - 2 * np.sin(rising / 2) ** 2)
    height -= np.log1p(down * np.sinh(falling) + 2 * np.sinh(falling / 2) ** 2)
    return np.asarray(flight.terminal_speed**2 / flight.gravity * height)


def velocity(flight: Flight, velocity: ArrayLike, time: ArrayLike) -> Floats:
    """Velocity at other times than 0, m/s, up positive; arguments as in `position`.

    Examples
    --------
    >>> velocity(Flight(gravity=9.8), 2.0, [-1.0, 0.0, 1.0])
    array([11.8,  2. , -7.8])
    """
    velocity, time = np.broadcast_arrays(np.asarray(velocity, float), np.asarray(time, float))
    if math.isinf(flight.terminal_speed):
        return np.asarray(velocity - flight.gravity * time)
    up, down, rising, falling = _stretches(flight, velocity, time)
    tangent, hyperbolic = np.tan(rising), np.tanh(falling)
    upwards = (up - tangent) / (1 + up * tangent)
    downwards = (down + hyperbolic) / (1 + down * hyperbolic)
    return np.asarray(flight.terminal_speed * (upwards - downwards))


def _stretches(flight: Flight, velocity: Floats, time: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Split a flight at its apex: starting speeds up and down, times spent rising and falling.

    Speeds are in units of the terminal speed, times in terminal_speed/gravity; a stretch seen backwards has
    negative time. One that is reached only through the apex starts from rest. Impossible times become nan.
    """
    scaled = velocity / flight.terminal_speed
    x = time * (flight.gravity / flight.terminal_speed)
    # a ball that falls faster than its terminal speed was thrown: it has no apex in its past
    thrown = scaled <= -1
    apex = np.where(scaled > 0, np.arctan(scaled), np.arctanh(np.clip(scaled, JUST_ABOVE_MINUS_ONE, 0)))
    apex = np.where(thrown, -np.inf, apex)
    earliest = np.where(thrown, np.arctanh(1 / np.minimum(scaled, JUST_BELOW_MINUS_ONE)), apex - np.pi / 2)
    x = np.where(x > earliest, x, np.nan)
    rising = np.where(scaled > 0, np.minimum(x, apex), np.minimum(x - apex, 0))
    return np.maximum(scaled, 0), np.maximum(-scaled, 0), rising, x - rising


def apex(flight: Flight, velocity: float) -> tuple[float, float]:
    """Time (s) and displacement (m) of the apex of a ball with `velocity` now; the past if it already falls.

    Raises
    ------
    ValueError
        If the ball falls at its terminal speed or faster: it was thrown, its flight has no apex.

    Examples
    --------
    >>> apex(Flight(gravity=10.0), -5.0)
    (-0.5, 1.25)
    """
    if velocity <= -flight.terminal_speed:
        raise ValueError(f"velocity must be above -{flight.terminal_speed}, got {velocity}")
    if math.isinf(flight.terminal_speed):
        time = velocity / flight.gravity
    else:
        scaled = velocity / flight.terminal_speed
        angle = math.atan(scaled) if velocity > 0 else math.atanh(scaled)
        time = angle * flight.terminal_speed / flight.gravity
    return time, float(position(flight, velocity, time))


def fall_time(flight: Flight, height: ArrayLike) -> Floats:
    """Time a ball let go at rest takes to fall through `height` (m), in s.

    Examples
    --------
    >>> float(fall_time(Flight(gravity=9.8), 4.9))
    1.0
    """
    height = np.asarray(height, float)
    if math.isinf(flight.terminal_speed):
        return np.asarray(np.sqrt(2 * height / flight.gravity))
    # cosh x - 1 = exp(q) - 1 = 2 sinh(x/2)**2
    q = height * (flight.gravity / flight.terminal_speed**2)
    x = 2 * np.arcsinh(np.sqrt(np.expm1(q) / 2))
    return np.asarray(x * (flight.terminal_speed / flight.gravity))

"""Does restitution depend on speed? The line e(v) = e0 - a v, tested against a constant.

A line with the sign of a loss is what viscoelastic and plastic contacts show to first order over a narrow
range of speeds; it says nothing about speeds outside that range.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import stats

from calibrate.report import rounded

Array = NDArray[np.float64]

FEWEST = 4
"""Points from which a dependence on speed is looked for."""
SURELY = 0.01
"""Chance of so steep a line under a constant restitution, below which the line is believed."""
_NARROWEST = 1.1  # fastest over slowest: less tells nothing about speed


@dataclass(frozen=True, slots=True, kw_only=True)
class SpeedLaw:
    """Restitution as a line over the approach speed, and as a constant.

    Attributes
    ----------
    at_rest, at_rest_sd : float
        e0, the line at speed zero, and its standard deviation.
    slope, slope_sd : float
        a, restitution lost for each m/s, s/m.
    constant, constant_sd : float
        The best constant.
    probability : float
        Chance that scatter alone makes a constant restitution look at least so dependent on speed (F-test).
    speeds : (float, float)
        Slowest and fastest, m/s.
    middle : float
        Speed at which the line is known best, m/s.
    points : int
        How many it rests on.

    Examples
    --------
    >>> law = fit_speed_law([1.0, 1.5, 2.0, 2.5], [0.91, 0.899, 0.891, 0.88])
    >>> print(law)
    falls with speed: e(v) = 0.9293 ± 0.0016 - (0.01960 ± 0.00085) s/m v, v from 1 to 2.5 m/s (probability \
of a constant 0.002)
    >>> [round(number, 4) for number in law.at(2.0)]
    [0.8901, 0.0005]
    """

    at_rest: float
    at_rest_sd: float
    slope: float
    slope_sd: float
    constant: float
    constant_sd: float
    probability: float
    speeds: tuple[float, float]
    middle: float
    points: int

    @property
    def depends_on_speed(self) -> bool:
        """Whether a constant is hardly believable."""
        return self.probability < SURELY

    def at(self, speed: float) -> tuple[float, float]:
        """Restitution and its standard deviation at a speed (m/s), by the line."""
        at_middle = np.sqrt(max(self.at_rest_sd**2 - (self.slope_sd * self.middle) ** 2, 0.0))
        sd = np.hypot(at_middle, self.slope_sd * (speed - self.middle))
        return self.at_rest - self.slope * speed, float(sd)

    def __str__(self) -> str:
        chance = f"probability of a constant {self.probability:.1g}"
        low, high = (f"{speed:.3g}" for speed in self.speeds)
        if not self.depends_on_speed:
            constant = rounded(self.constant, self.constant_sd)
            return f"no dependence on speed seen: e = {constant}, v from {low} to {high} m/s ({chance})"
        word = "falls" if self.slope > 0 else "rises"
        slope = rounded(abs(self.slope), self.slope_sd)
        sign = "-" if self.slope > 0 else "+"
        line = f"e(v) = {rounded(self.at_rest, self.at_rest_sd)} {sign} ({slope}) s/m v"
        return f"{word} with speed: {line}, v from {low} to {high} m/s ({chance})"


def fit_speed_law(speed: ArrayLike, restitution: ArrayLike, sd: ArrayLike = 1.0) -> SpeedLaw:
    """Fit e(v) = e0 - a v by weighted least squares; the scatter about the line tells the uncertainty.

    Parameters
    ----------
    speed : array_like (N,)
        Approach speeds, m/s.
    restitution : array_like (N,)
        Measured there. Readings that share an error, such as repeats at one marked height, belong averaged
        into one point.
    sd : array_like (N,) or float
        Relative to each other; only their ratios count.

    Raises
    ------
    ValueError
        If there are fewer than four points, a number is not finite, an `sd` not above zero, or the speeds
        are too much alike.
    """
    speed, restitution = np.asarray(speed, dtype=float), np.asarray(restitution, dtype=float)
    sd = np.broadcast_to(np.asarray(sd, dtype=float), speed.shape)
    _check(speed, restitution, sd)
    weight = 1 / sd**2
    middle, constant = (float(np.average(values, weights=weight)) for values in (speed, restitution))
    off_middle = speed - middle
    breadth = float(np.sum(weight * off_middle**2))
    slope = float(np.sum(weight * off_middle * (constant - restitution))) / breadth
    freedom = len(speed) - 2
    about_constant = float(np.sum(weight * (restitution - constant) ** 2))
    about_line = max(about_constant - slope**2 * breadth, 1e-12 * about_constant)
    variance = about_line / freedom
    return SpeedLaw(
        at_rest=constant + slope * middle,
        at_rest_sd=float(np.sqrt(variance * (1 / weight.sum() + middle**2 / breadth))),
        slope=slope,
        slope_sd=float(np.sqrt(variance / breadth)),
        constant=constant,
        constant_sd=float(np.sqrt(about_constant / (freedom + 1) / weight.sum())),
        probability=float(stats.f.sf(slope**2 * breadth / variance, 1, freedom)) if variance else 1.0,
        speeds=(float(speed.min()), float(speed.max())),
        middle=middle,
        points=len(speed),
    )


def tells_about_speed(speed: ArrayLike) -> bool:
    """Whether speeds are many and different enough to look for a dependence on them."""
    speed = np.asarray(speed, dtype=float)
    return bool(len(speed) >= FEWEST and speed.min() > 0 and speed.max() >= _NARROWEST * speed.min())


def _check(speed: Array, restitution: Array, sd: Array) -> None:
    if len(speed) < FEWEST:
        raise ValueError(f"a dependence on speed needs at least {FEWEST} points, got {len(speed)}")
    for name, values in (("speed", speed), ("restitution", restitution), ("sd", sd)):
        if not np.all(np.isfinite(values)):
            raise ValueError(f"{name} must be finite, got {values[~np.isfinite(values)][0]}")
    if not np.all(sd > 0):
        raise ValueError(f"sd must be above zero, got {sd.min():g}")
    if not tells_about_speed(speed):
        got = f"{speed.min():g} to {speed.max():g} m/s"
        raise ValueError(f"speeds must differ by a factor of {_NARROWEST} or more, got {got}")

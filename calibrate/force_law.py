"""Linear spring, Hertz' contact, or something between, and whether the data can tell.

The force law F = k x**exponent changes the outcome as much as the stiffness ratio does. Each law gets its
own best ratio and restitutions; they are then compared by chi-square, which for these measurements is minus
twice the logarithm of the likelihood up to a constant.
"""

from dataclasses import dataclass, replace

import numpy as np

from calibrate.basins import Basin, refined_basins
from calibrate.descent import descend, search
from calibrate.estimate import Estimate
from calibrate.intervals import Interval, joined
from calibrate.limits import limit
from calibrate.misfit import Misfit
from calibrate.model import HERTZ, LINEAR
from calibrate.outcome import stiffness_estimate
from calibrate.profile import starting_grid, trace_profile
from calibrate.report import interval_text

NAMES = {LINEAR: "linear", HERTZ: "Hertz"}
EXPONENTS = (1.0, 2.0)
"""Exponents searched: real contacts of smooth bodies lie between a linear spring and a fully plastic cone."""

_COARSE = 9  # exponents searched from scratch
_STEP = 0.02  # from exponent to exponent along a valley
_FOLLOWED = 3  # valleys
_REACH = 0.25  # of the ratio, in the logarithm, from one exponent to the next
_HIGHEST = 12.0  # rise of chi-square at which a valley is left


@dataclass(frozen=True, slots=True, kw_only=True)
class Law:
    """One force law with its best parameters.

    Attributes
    ----------
    exponent : float
        Of the force law.
    chi_square : float
        Of its best fit.
    stiffness_ratio : Estimate
        Under this law.
    """

    exponent: float
    chi_square: float
    stiffness_ratio: Estimate


@dataclass(frozen=True, slots=True, kw_only=True)
class ForceLaws:
    """Linear, Hertz, and the exponent left free.

    Attributes
    ----------
    linear, hertz : Law
        The two laws that are named.
    exponent, chi_square : tuple of float
        Best chi-square at each exponent tried, in rising order.
    limit : float
        Largest chi-square not excluded with 95 % confidence.
    intervals_95 : tuple of (low, high)
        Exponents not excluded.
    """

    linear: Law
    hertz: Law
    exponent: tuple[float, ...]
    chi_square: tuple[float, ...]
    limit: float
    intervals_95: tuple[Interval, ...]

    @property
    def best(self) -> float:
        """Exponent that fits best."""
        return self.exponent[int(np.argmin(self.chi_square))]

    @property
    def sentence(self) -> str:
        """Whether the data can tell, plainly."""
        inside = [law for law in (self.linear, self.hertz) if law.chi_square <= self.limit]
        if len(inside) == 2:
            return "the data cannot tell linear from Hertz: the stiffness ratio depends on which is assumed"
        if not inside:
            reach = " or ".join(interval_text(pair) for pair in self.intervals_95)
            return (
                f"neither linear nor Hertz describes the data: an exponent of {reach} does better than both"
            )
        (kept,) = inside
        left = self.hertz if kept is self.linear else self.linear
        return f"the data tell: {NAMES[kept.exponent]}, not {NAMES[left.exponent]}"

    def __str__(self) -> str:
        lines = [
            f"force law {NAMES[law.exponent]} (exponent {law.exponent:g}): chi-square {law.chi_square:.1f},"
            f" stiffness ratio {law.stiffness_ratio}"
            for law in (self.linear, self.hertz)
        ]
        reach = " or ".join(interval_text(pair) for pair in self.intervals_95)
        free = f"force law free: chi-square {min(self.chi_square):.1f} at exponent {self.best:.2f}"
        return "\n".join([*lines, f"{free} (95 %: {reach})", self.sentence])


def compare_force_laws(misfit: Misfit) -> ForceLaws:
    """Fit linear, Hertz, and every exponent between 1 and 2.

    Parameters
    ----------
    misfit : Misfit
        Everything measured, as `calibrate.fit.misfit_of` makes it; its own exponent plays no part.
    """
    linear, hertz = (_law(replace(misfit, exponent=exponent)) for exponent in (LINEAR, HERTZ))
    tried = {law.exponent: law.chi_square for law in (linear, hertz)}
    coarse = [(float(exponent), _anew(misfit, exponent)) for exponent in np.linspace(*EXPONENTS, _COARSE)]
    for exponent, basin in sorted(coarse, key=lambda pair: pair[1].chi_square)[:_FOLLOWED]:
        for direction in (1, -1):
            _follow(misfit, exponent, basin, direction * _STEP, tried)
    exponents = sorted(tried)
    chi_square = [tried[exponent] for exponent in exponents]
    highest = limit(min(chi_square), misfit.degrees_of_freedom - 1, 0.95)
    inside = [
        (e - _STEP / 2, e + _STEP / 2) for e, chi in zip(exponents, chi_square, strict=True) if chi <= highest
    ]
    return ForceLaws(
        linear=linear,
        hertz=hertz,
        exponent=tuple(exponents),
        chi_square=tuple(chi_square),
        limit=highest,
        intervals_95=tuple(
            (max(low, EXPONENTS[0]), min(high, EXPONENTS[1])) for low, high in joined(inside, gap=_STEP / 2)
        ),
    )


def _law(misfit: Misfit) -> Law:
    profile = trace_profile(misfit)
    return Law(
        exponent=misfit.exponent,
        chi_square=profile.basins[0].chi_square,
        stiffness_ratio=stiffness_estimate(profile),
    )


def _anew(misfit: Misfit, exponent: float) -> Basin:
    """Best basin under one exponent, searched over all ratios."""
    mine = replace(misfit, exponent=exponent)
    return refined_basins(mine, search(mine, starting_grid()), _HIGHEST)[0]


def _follow(misfit: Misfit, start: float, basin: Basin, step: float, tried: dict[float, float]) -> None:
    """Follow a valley from exponent to exponent until it is too high or the exponents end."""
    exponent = start
    while EXPONENTS[0] - 1e-9 < exponent < EXPONENTS[1] + 1e-9:
        basin = _nearby(replace(misfit, exponent=exponent), basin)
        key = round(exponent, 6)
        tried[key] = min(basin.chi_square, tried.get(key, np.inf))
        if basin.chi_square > min(tried.values()) + _HIGHEST:
            return
        exponent += step


def _nearby(misfit: Misfit, basin: Basin) -> Basin:
    log_ratio = np.log(basin.stiffness_ratio) + np.linspace(-_REACH, _REACH, 41)
    trace = descend(misfit, log_ratio, np.tile(basin.restitutions, (len(log_ratio), 1)))
    return refined_basins(misfit, trace, 1.0)[0]

"""Refine the local minima of chi-square in all three parameters at once: the one place that calls lmfit."""

from dataclasses import dataclass, replace

import lmfit
import numpy as np
from numpy.typing import NDArray

from calibrate.descent import Trace
from calibrate.misfit import Misfit

_INSIDE = 1e-4  # lmfit cannot start at a bound


@dataclass(frozen=True, slots=True, kw_only=True)
class Basin:
    """One local minimum of chi-square.

    Attributes
    ----------
    stiffness_ratio : float
        Ball-table over ball-ball.
    restitutions : tuple of two floats
        Ball-ball and ball-table.
    chi_square : float
        At the minimum.
    history : tuple of float
        Chi-square after each evaluation of the local fit, the start first.
    """

    stiffness_ratio: float
    restitutions: tuple[float, float]
    chi_square: float
    history: tuple[float, ...] = ()


def refined_basins(misfit: Misfit, trace: Trace, depth: float) -> list[Basin]:
    """Refine every local minimum of a trace.

    Parameters
    ----------
    misfit : Misfit
        What to make small.
    trace : Trace
        Where the minima are, to the spacing of its ratios.
    depth : float
        Minima this far above the smallest chi-square are passed over.

    Returns
    -------
    list of Basin
        Best first.
    """
    walled = np.concatenate([[np.inf], trace.chi_square, [np.inf]])
    lowest = (trace.chi_square <= walled[:-2]) & (trace.chi_square <= walled[2:])
    near = trace.chi_square < trace.chi_square.min() + depth
    basins = [_refined(misfit, trace, index) for index in np.flatnonzero(lowest & near).tolist()]
    return sorted(basins, key=lambda basin: basin.chi_square)


def _refined(misfit: Misfit, trace: Trace, index: int) -> Basin:
    """Fit between the neighbouring ratios of one minimum; with too few numbers measured leave it as it is."""
    found = _as_found(trace, index)
    if misfit.degrees_of_freedom < 0:
        return found
    low, high = max(index - 1, 0), min(index + 1, len(trace.log_ratio) - 1)
    ball_ball, ball_table = np.clip(trace.restitutions[index], _INSIDE, 1 - _INSIDE)
    parameters = lmfit.Parameters()
    parameters.add("log_ratio", trace.log_ratio[index], min=trace.log_ratio[low], max=trace.log_ratio[high])
    parameters.add("ball_ball", ball_ball, min=0.0, max=1.0)
    parameters.add("ball_table", ball_table, min=0.0, max=1.0)

    history: list[float] = []

    def residuals(values: lmfit.Parameters) -> NDArray[np.float64]:
        restitutions = np.array([[values["ball_ball"].value, values["ball_table"].value]])
        (row,) = misfit.residuals(np.array([values["log_ratio"].value]), restitutions)
        history.append(float(np.sum(row**2)))
        return np.asarray(row)

    fit = lmfit.minimize(residuals, parameters, calc_covar=False, max_nfev=100, epsfcn=1e-10)
    if fit.chisqr > found.chi_square:  # stopped at a jump
        return replace(found, history=tuple(history))
    best = fit.params.valuesdict()
    return Basin(
        stiffness_ratio=float(np.exp(best["log_ratio"])),
        restitutions=(float(best["ball_ball"]), float(best["ball_table"])),
        chi_square=float(fit.chisqr),
        history=tuple(history),
    )


def _as_found(trace: Trace, index: int) -> Basin:
    ball_ball, ball_table = trace.restitutions[index].tolist()
    return Basin(
        stiffness_ratio=float(np.exp(trace.log_ratio[index])),
        restitutions=(ball_ball, ball_table),
        chi_square=float(trace.chi_square[index]),
    )

"""The model solved over all stiffness ratios, once for all designs of experiment."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibrate.model import LINEAR, rebound_ratios
from calibrate.profile import RATIO_LIMITS

Array = NDArray[np.float64]

_GRID_POINTS = 1500
_STEP = 1e-5  # of restitution, for slopes
_STEEPEST = 20.0  # slope above which a step led across a jump and tells nothing


@dataclass(frozen=True, slots=True, kw_only=True)
class Landscape:
    """The model solved for all ratios and mass pairs that may be asked for.

    Attributes
    ----------
    log_ratio : ndarray (G,)
        Natural logarithm of the stiffness ratio.
    mass_ratios : tuple of P floats
        Upper over lower mass.
    restitutions : (float, float)
        Ball-ball and ball-table, expected.
    rebounds : ndarray (G, P, 2)
        Velocity ratios v1/|v0|, v2/|v0|.
    slopes : ndarray (G, P, 2, 2)
        Their derivatives by the two restitutions (last axis).
    """

    log_ratio: Array
    mass_ratios: tuple[float, ...]
    restitutions: tuple[float, float]
    rebounds: Array
    slopes: Array


def landscape(
    mass_ratios: Sequence[float],
    restitutions: tuple[float, float],
    candidates: Sequence[float],
    exponent: float = LINEAR,
) -> Landscape:
    """Solve the model over all ratios for some mass pairs; the candidates are among the ratios exactly."""
    low, high = np.log(RATIO_LIMITS)
    even_in_root = 2 * np.arcsinh(np.linspace(np.sinh(low / 2), np.sinh(high / 2), _GRID_POINTS // 2))
    even = np.linspace(low, high, _GRID_POINTS // 2)
    log_ratio = np.unique(np.concatenate([even, even_in_root, np.log(candidates)]))
    at = np.array(restitutions)
    steps = np.where(at > 0.5, -_STEP, _STEP)
    places = np.stack([at, at + steps * [1, 0], at + steps * [0, 1]])
    shape = (len(log_ratio), len(mass_ratios), len(places))
    ratio, mass, place = np.broadcast_arrays(
        np.exp(log_ratio)[:, None, None], np.array(mass_ratios)[None, :, None], np.arange(3)[None, None, :]
    )
    solved = rebound_ratios(ratio.ravel(), places[place.ravel()], mass.ravel(), exponent=exponent)
    solved = solved.reshape(*shape, 2)
    slopes = np.moveaxis((solved[:, :, 1:] - solved[:, :, :1]) / steps[:, None], 2, 3)
    across = np.abs(slopes).max(axis=(2, 3)) > _STEEPEST
    slopes[across] = 0.0
    return Landscape(
        log_ratio=log_ratio,
        mass_ratios=tuple(mass_ratios),
        restitutions=restitutions,
        rebounds=solved[:, :, 0],
        slopes=slopes,
    )

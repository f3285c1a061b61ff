"""How far model and measurements are apart, for many candidate parameters at once."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibrate.model import LINEAR, rebound_ratios
from calibrate.repeats import Repeats

Array = NDArray[np.float64]

_STRAY = (0.0, -1.5, 1.5)  # standard deviations by which a restitution is tried beside its own drops' mean


@dataclass(frozen=True, slots=True, kw_only=True)
class Misfit:
    """Everything measured about one pair of contacts.

    Attributes
    ----------
    ball_ball, ball_table : Repeats or None
        Restitutions from their own drops; None where there were none, the restitution is then free in [0, 1].
    rebounds : Repeats
        Velocity ratios (v1/|v0|, v2/|v0|) of each mass pair.
    mass_ratios : ndarray (J,)
        Upper over lower mass of each pair.
    exponent : float
        Of the force law.
    """

    ball_ball: Repeats | None
    ball_table: Repeats | None
    rebounds: Repeats
    mass_ratios: Array
    exponent: float = LINEAR

    @property
    def degrees_of_freedom(self) -> int:
        """Independent numbers measured less the three parameters."""
        return self.rebounds.means.size + len(self._own_drops) - 3

    def predicted(self, log_ratio: Array, restitutions: Array) -> Array:
        """Velocity ratios the model gives each mass pair, (N, J, 2); parameters as for `residuals`."""
        pairs = len(self.mass_ratios)
        if not log_ratio.size:
            return np.empty((0, pairs, 2))
        ratios = rebound_ratios(
            np.repeat(np.exp(log_ratio), pairs),
            np.repeat(restitutions, pairs, axis=0),
            np.tile(self.mass_ratios, len(log_ratio)),
            exponent=self.exponent,
        )
        return ratios.reshape(len(log_ratio), pairs, 2)

    def residuals(self, log_ratio: Array, restitutions: Array) -> Array:
        """Standardized residuals.

        Parameters
        ----------
        log_ratio : ndarray (N,)
            Natural logarithm of the stiffness ratio.
        restitutions : ndarray (N, 2)
            Ball-ball and ball-table restitution.

        Returns
        -------
        ndarray (N, R)
            Their squares add up to `chi_square`.
        """
        predicted = self.predicted(log_ratio, restitutions)
        rows = [self.rebounds.distances(predicted)]
        rows += [drops.distances(restitutions[:, [[column]]]) for column, drops in self._own_drops]
        return np.concatenate(rows, axis=1)

    def chi_square(self, log_ratio: Array, restitutions: Array) -> Array:
        """Sum of squared residuals, (N,)."""
        return np.asarray(np.sum(self.residuals(log_ratio, restitutions) ** 2, axis=1))

    def likely_restitutions(self) -> Array:
        """Spread of plausible (ball-ball, ball-table) restitutions to start searches from, (S, 2)."""
        first, second = np.meshgrid(_plausible(self.ball_ball), _plausible(self.ball_table), indexing="ij")
        return np.stack([first.ravel(), second.ravel()], axis=1)

    @property
    def out_of_reach(self) -> float:
        """Chi-square above the smallest from which parameters are hopeless, the fewer repeats the less."""
        return min(100.0, self.rebounds.chi_square_at(30.0))

    @property
    def _own_drops(self) -> list[tuple[int, Repeats]]:
        return [
            (column, drops)
            for column, drops in enumerate((self.ball_ball, self.ball_table))
            if drops is not None
        ]


def _plausible(drops: Repeats | None) -> Array:
    if drops is None:
        return np.linspace(0.1, 0.98, 9)
    return np.asarray(np.clip(drops.means[0, 0] + drops.mean_sd() * np.array(_STRAY), 0.0, 1.0))

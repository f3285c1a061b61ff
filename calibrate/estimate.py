"""What a fit returns: numbers with their confidence sets, a verdict, and where they came from."""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from calibrate.files import write_whole
from calibrate.intervals import BAD_FIT, Interval, chance_of
from calibrate.notebook import calibration_html, estimate_html
from calibrate.report import calibration_text, estimate_text


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimate:
    """One fitted number.

    Attributes
    ----------
    value : float or None
        Best value; None where the data do not single one out.
    sd : float or None
        Half the width of the 68 % interval around it, where there is only one.
    intervals_68, intervals_95 : tuple of (low, high)
        Confidence sets; their intervals need not be symmetric nor connected.
    verdict : str
        ``one value``, ``several values``, ``bounded on one side`` or ``not determined``.

    Examples
    --------
    >>> print(Estimate(value=0.80776, sd=0.0075, intervals_68=((0.8, 0.815),),
    ...                intervals_95=((0.79, 0.825),), verdict="one value"))
    one value: 0.8078 ± 0.0075 (95 %: 0.7900 to 0.8250)
    """

    value: float | None
    sd: float | None
    intervals_68: tuple[Interval, ...]
    intervals_95: tuple[Interval, ...]
    verdict: str

    def __str__(self) -> str:
        return estimate_text(self)

    def _repr_html_(self) -> str:
        return estimate_html(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class MassPair:
    """Measured and fitted velocity ratios (v1/|v0|, v2/|v0|) of the trials with one pair of masses.

    Attributes
    ----------
    mass_ratio : float
        Upper over lower mass.
    trials : int
        How many there are.
    measured, measured_sd, fitted : (float, float)
        Means of the trials, their standard deviations, and what the best fit predicts.
    fitted_68, fitted_95 : (low, high) for each of the two
        What all parameters inside the confidence set predict.
    states : tuple of str
        Sequence of states of the best fit.
    """

    mass_ratio: float
    trials: int
    measured: tuple[float, float]
    measured_sd: tuple[float, float]
    fitted: tuple[float, float]
    fitted_68: tuple[Interval, Interval]
    fitted_95: tuple[Interval, Interval]
    states: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Curve:
    """Chi-square over the stiffness ratio, columns of equal length, and the largest not excluded.

    `states` are the sequences, such as ``S1 S3 S1 S2``, for the mass pair with most trials.
    """

    stiffness_ratio: tuple[float, ...] = ()
    chi_square: tuple[float, ...] = ()
    states: tuple[str, ...] = ()
    limit_68: float = 0.0
    limit_95: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Valley:
    """One local fit: where it ended (ratio, ball-ball and ball-table restitution), chi-square on the way."""

    stiffness_ratio: float
    restitutions: tuple[float, float]
    chi_square: float
    history: tuple[float, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Calibration:
    """Everything one fit found; prints its verdict first.

    Attributes
    ----------
    restitution_ball_ball, restitution_ball_table : Estimate
        e1 and e2.
    stiffness_ratio : Estimate
        Ball-table over ball-ball stiffness, k2/k1.
    states : tuple of str
        Sequence of states of the best fit for the mass pair with most trials.
    pairs : tuple of MassPair
        In order of their mass ratio.
    chi_square : float
        At the best fit; judges the model by the trials' own scatter.
    degrees_of_freedom : int
        Independent numbers measured less parameters fitted.
    exponent : float
        Of the force law, 1 linear, 1.5 Hertz.
    notes : tuple of str
        What the reader has to know, in sentences.
    profile : Curve
        Chi-square over the stiffness ratio.
    valleys : tuple of Valley
        Local fits, best first.
    provenance : mapping
        Versions, inputs and options.
    """

    restitution_ball_ball: Estimate
    restitution_ball_table: Estimate
    stiffness_ratio: Estimate
    states: tuple[str, ...]
    pairs: tuple[MassPair, ...]
    chi_square: float
    degrees_of_freedom: int
    exponent: float
    notes: tuple[str, ...]
    profile: Curve
    valleys: tuple[Valley, ...] = ()
    provenance: Mapping[str, Any] = field(default_factory=dict)

    @property
    def caveat(self) -> str:
        """What has to be said in one breath with the verdict: that the model misses the data, if it does."""
        if chance_of(self.chi_square, self.degrees_of_freedom) >= BAD_FIT:
            return ""
        return ", but the model misses the measurements: do not trust it"

    def __str__(self) -> str:
        return calibration_text(self)

    def _repr_html_(self) -> str:
        return calibration_html(self)

    def to_json(self) -> str:
        """Write all of it as JSON text that `from_json` reads back."""
        return json.dumps(asdict(self), indent=1, ensure_ascii=False, allow_nan=False) + "\n"

    @classmethod
    def from_json(cls, text: str) -> "Calibration":
        """Read what `to_json` wrote."""
        data = _tuples(json.loads(text))
        for name in ("restitution_ball_ball", "restitution_ball_table", "stiffness_ratio"):
            data[name] = Estimate(**data[name])
        data["pairs"] = tuple(MassPair(**pair) for pair in data["pairs"])
        data["profile"] = Curve(**data["profile"])
        data["valleys"] = tuple(Valley(**valley) for valley in data.get("valleys", ()))
        return cls(**data)

    def save(self, path: str | Path) -> Path:
        """Write ``fit.json``, whole or not at all."""
        return write_whole(path, self.to_json())


def _tuples(value: Any) -> Any:
    """Turn JSON lists, at any depth, into the tuples they were."""
    if isinstance(value, list):
        return tuple(_tuples(item) for item in value)
    if isinstance(value, dict):
        return {key: _tuples(item) for key, item in value.items()}
    return value

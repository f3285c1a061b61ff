"""What a profile amounts to: estimates with their sets and verdicts, mass pair by mass pair."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from calibrate.estimate import Curve, Estimate, MassPair, Valley
from calibrate.intervals import NOT_DETERMINED, ONE_VALUE, SEVERAL_VALUES, Interval, joined, verdict
from calibrate.misfit import Misfit
from calibrate.model import state_sequence, state_sequences
from calibrate.observed import Observed
from calibrate.profile import LEVELS, RATIO_LIMITS, Profile, propagate
from calibrate.repeats import Repeats

Array = NDArray[np.float64]

_RESTITUTION_LIMITS = (0.0, 1.0)
_WIDEST_RESTITUTION = 0.5
_SAME_RESTITUTION = 0.005  # intervals closer together than this are one
_WIDEST_RATIO = 4.0  # a 95 % interval that spans a larger factor does not name a value
UNKNOWN_RESTITUTION = Estimate(
    value=None,
    sd=None,
    intervals_68=(_RESTITUTION_LIMITS,),
    intervals_95=(_RESTITUTION_LIMITS,),
    verdict=NOT_DETERMINED,
)
UNKNOWN_RATIO = Estimate(
    value=None, sd=None, intervals_68=(RATIO_LIMITS,), intervals_95=(RATIO_LIMITS,), verdict=NOT_DETERMINED
)


def estimate_from_own_drops(drops: Repeats) -> Estimate:
    """Mean of a restitution's own drops with Student's intervals."""
    intervals = [[_clipped(drops.interval(level))] for level in LEVELS]
    return _restitution_estimate(float(drops.means[0, 0]), intervals, drops.mean_sd())


def restitution_estimates(misfit: Misfit, profile: Profile) -> tuple[Estimate, Estimate]:
    """Restitutions of the joint fit, with the sets every accepted stiffness ratio allows them."""
    reach = [
        propagate(misfit, profile, level, lambda log_ratio, restitutions: restitutions) for level in LEVELS
    ]
    ball_ball, ball_table = (
        _restitution_estimate(
            profile.basins[0].restitutions[column],
            [
                [_clipped(pair) for pair in zip(low[:, column], high[:, column], strict=True)]
                for low, high in reach
            ],
        )
        for column in range(2)
    )
    return ball_ball, ball_table


def _restitution_estimate(value: float, intervals: list[list[Interval]], sd: float | None = None) -> Estimate:
    inner, outer = (joined(level, gap=_SAME_RESTITUTION) for level in intervals)
    word = verdict(outer, _RESTITUTION_LIMITS, _WIDEST_RESTITUTION)
    return _estimate(value, inner, outer, word, sd)


def stiffness_estimate(profile: Profile) -> Estimate:
    """Judge the stiffness ratio; distances on its scale are ratios, so the verdict works on logarithms."""
    inner, outer = (profile.intervals(level) for level in LEVELS)
    logs = tuple((float(np.log(low)), float(np.log(high))) for low, high in outer)
    limits = (float(np.log(RATIO_LIMITS[0])) + 1e-9, float(np.log(RATIO_LIMITS[1])) - 1e-9)
    word = verdict(logs, limits, float(np.log(_WIDEST_RATIO)))
    return _estimate(profile.basins[0].stiffness_ratio, inner, outer, word)


def _estimate(
    value: float, inner: tuple[Interval, ...], outer: tuple[Interval, ...], word: str, sd: float | None = None
) -> Estimate:
    around = [(low, high) for low, high in inner if low <= value <= high]
    return Estimate(
        value=value if word in (ONE_VALUE, SEVERAL_VALUES) else None,
        sd=(sd or (around[0][1] - around[0][0]) / 2) if word == ONE_VALUE and around else None,
        intervals_68=inner,
        intervals_95=outer,
        verdict=word,
    )


def mass_pairs(misfit: Misfit, profile: Profile, two: Observed) -> tuple[MassPair, ...]:
    """Set measured velocity ratios beside fitted ones, with what the whole confidence set predicts."""
    best = profile.basins[0]
    fitted = _predictions(misfit)(np.log([best.stiffness_ratio]), np.array([best.restitutions]))[0].reshape(
        -1, 2
    )
    bands = [_bands(misfit, profile, level) for level in LEVELS]
    return tuple(
        MassPair(
            mass_ratio=float(ratio),
            trials=int(two.trials[pair]),
            measured=_two(two.repeats.means[pair]),
            measured_sd=(two.repeats.mean_sd(pair, 0), two.repeats.mean_sd(pair, 1)),
            fitted=_two(fitted[pair]),
            fitted_68=bands[0][pair],
            fitted_95=bands[1][pair],
            states=state_sequence(
                best.stiffness_ratio, best.restitutions, float(ratio), exponent=misfit.exponent
            ),
        )
        for pair, ratio in enumerate(misfit.mass_ratios)
    )


def _bands(misfit: Misfit, profile: Profile, level: float) -> list[tuple[Interval, Interval]]:
    """Range of both velocity ratios of each mass pair over all parameters inside the confidence set."""
    low, high = propagate(misfit, profile, level, _predictions(misfit))
    ends = np.stack([low.min(axis=0), high.max(axis=0)], axis=1).reshape(-1, 2, 2)
    return [(_two(upper), _two(lower)) for upper, lower in ends]


def _predictions(misfit: Misfit) -> Callable[[Array, Array], Array]:
    """Velocity ratios of all mass pairs, (N, 2 J), as a function of the parameters."""
    return lambda log_ratio, restitutions: misfit.predicted(log_ratio, restitutions).reshape(
        len(log_ratio), -1
    )


def curve_of(misfit: Misfit, profile: Profile, mass_ratio: float) -> Curve:
    """Write the profile as plain columns, with the states that one mass pair goes through."""
    trace = profile.trace
    states = state_sequences(trace.log_ratio, trace.restitutions, mass_ratio, exponent=misfit.exponent)
    return Curve(
        stiffness_ratio=tuple(np.exp(trace.log_ratio).tolist()),
        chi_square=tuple(trace.chi_square.tolist()),
        states=tuple(" ".join(sequence) for sequence in states),
        limit_68=profile.limit(0.68),
        limit_95=profile.limit(0.95),
    )


def valleys_of(profile: Profile) -> tuple[Valley, ...]:
    """List the local fits, best first."""
    return tuple(
        Valley(
            stiffness_ratio=basin.stiffness_ratio,
            restitutions=basin.restitutions,
            chi_square=basin.chi_square,
            history=basin.history,
        )
        for basin in profile.basins
    )


def _two(values: Array) -> tuple[float, float]:
    first, second = values.tolist()
    return first, second


def _clipped(interval: Interval) -> Interval:
    low, high = np.clip(interval, *_RESTITUTION_LIMITS)
    return float(low), float(high)

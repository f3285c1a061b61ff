"""Do confidence sets keep their promise? Simulated experiments, each fitted as a real one would be."""

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from calibrate.estimate import Estimate
from calibrate.fit import fit_stiffness_ratio
from calibrate.intervals import ONE_VALUE
from calibrate.simulate import Design, Truth, simulate_trials


@dataclass(frozen=True, slots=True, kw_only=True)
class Coverage:
    """What became of many fits to experiments with one truth.

    Attributes
    ----------
    stiffness_ratio : float
        The truth, ball-table over ball-ball.
    experiments : int
        How many were simulated.
    held : int
        How often the 95 % set held the truth.
    wrong : int
        How often the verdict was ``one value`` and the set around it did not hold the truth.
    verdicts : mapping of str to int
        How often each verdict was given.
    """

    stiffness_ratio: float
    experiments: int
    held: int
    wrong: int
    verdicts: Mapping[str, int]


def simulated_estimate(truth: Truth, design: Design, seed: int) -> Estimate:
    """Simulate one experiment and fit its stiffness ratio."""
    trials = simulate_trials(truth, design, np.random.default_rng(seed))
    return fit_stiffness_ratio(trials, exponent=truth.exponent).stiffness_ratio


def coverage_of(estimates: Iterable[Estimate], stiffness_ratio: float) -> Coverage:
    """Count how often estimates of one truth are right.

    Parameters
    ----------
    estimates : iterable of Estimate
        Of the stiffness ratio, one an experiment.
    stiffness_ratio : float
        The truth behind all of them.

    Examples
    --------
    >>> right = Estimate(value=2.1, sd=0.1, intervals_68=((2.0, 2.2),), intervals_95=((1.9, 2.3),),
    ...                  verdict="one value")
    >>> counted = coverage_of([right, right], 2.4)
    >>> counted.held, counted.wrong
    (0, 2)
    """
    estimates = list(estimates)
    held = [
        any(low <= stiffness_ratio <= high for low, high in estimate.intervals_95) for estimate in estimates
    ]
    surely = [estimate.verdict == ONE_VALUE for estimate in estimates]
    return Coverage(
        stiffness_ratio=stiffness_ratio,
        experiments=len(estimates),
        held=sum(held),
        wrong=sum(sure and not inside for sure, inside in zip(surely, held, strict=True)),
        verdicts=dict(Counter(estimate.verdict for estimate in estimates)),
    )

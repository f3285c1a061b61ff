"""Restitution over speed: a line is found where there is one, and hardly ever where there is none."""

import numpy as np
import pandas as pd
import pytest

from calibrate import check_trials, fit_stiffness_ratio
from calibrate.speed import fit_speed_law

SPEEDS = np.linspace(1.0, 4.0, 12)


def test_a_line_is_found_again() -> None:
    noise = np.random.default_rng(1).normal(0.0, 0.003, len(SPEEDS))
    law = fit_speed_law(SPEEDS, 0.93 - 0.02 * SPEEDS + noise)
    assert law.depends_on_speed
    assert abs(law.slope - 0.02) < 3 * law.slope_sd
    assert abs(law.at_rest - 0.93) < 3 * law.at_rest_sd
    assert "falls with speed" in str(law)


def test_a_constant_is_called_dependent_as_seldom_as_promised() -> None:
    generator = np.random.default_rng(2)
    called = [
        fit_speed_law(SPEEDS, 0.9 + generator.normal(0.0, 0.01, len(SPEEDS))).depends_on_speed
        for _ in range(2000)
    ]
    assert 0.004 < np.mean(called) < 0.018


def test_the_stated_uncertainty_of_the_line_is_its_scatter() -> None:
    generator = np.random.default_rng(3)
    laws = [fit_speed_law(SPEEDS, 0.9 - 0.01 * SPEEDS + generator.normal(0.0, 0.01, 12)) for _ in range(1000)]
    at_three = [law.at(3.0) for law in laws]
    assert np.std([value for value, _ in at_three]) == pytest.approx(
        np.sqrt(np.mean([sd**2 for _, sd in at_three])), rel=0.1
    )


def test_only_ratios_of_the_stated_deviations_count() -> None:
    noise = np.random.default_rng(4).normal(0.0, 0.01, len(SPEEDS))
    small, large = (fit_speed_law(SPEEDS, 0.9 + noise, sd=sd) for sd in (0.001, 5.0))
    assert small.slope_sd == pytest.approx(large.slope_sd)
    assert small.probability == pytest.approx(large.probability)


@pytest.mark.parametrize(
    ("speed", "restitution", "sentence"),
    [
        ([1, 2, 3], [0.9, 0.9, 0.9], "at least 4 points, got 3"),
        ([2, 2, 2, 2], [0.9, 0.9, 0.9, 0.8], "differ by a factor of 1.1 or more, got 2 to 2 m/s"),
        ([1, 2, 3, np.nan], [0.9, 0.9, 0.9, 0.9], "speed must be finite, got nan"),
    ],
)
def test_speeds_that_tell_nothing_are_refused(
    speed: list[float], restitution: list[float], sentence: str
) -> None:
    with pytest.raises(ValueError, match=sentence):
        fit_speed_law(speed, restitution)


def test_the_fit_says_that_restitution_of_its_drops_falls_with_speed() -> None:
    noise = np.random.default_rng(5).normal(0.0, 0.002, len(SPEEDS))
    rebounds = (0.93 - 0.02 * SPEEDS + noise) * SPEEDS
    columns = {"kind": "plate", "approach_velocity": -SPEEDS, "upper_rebound_velocity": rebounds}
    notes = fit_stiffness_ratio(check_trials(pd.DataFrame(columns))).notes
    assert any("drops on the plate falls with speed: e(v) = 0.9" in note for note in notes)

"""Repeats: an honest spread, however few there are."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy import stats

from calibrate.intervals import joined, verdict
from calibrate.observed import observed_restitution
from calibrate.repeats import ASSUMED_SCATTER, FINEST_SCATTER, Repeats, known, repeats_of
from calibrate.report import rounded
from calibrate.trials import check_trials


def repeats(values: NDArray[np.float64], groups: list[int], stated: float = np.nan) -> Repeats:
    channels = values.shape[1]
    covariance = (
        np.full((len(values), channels, channels), np.nan)
        if np.isnan(stated)
        else stated**2 * np.eye(channels)
    )
    return repeats_of(
        values, np.broadcast_to(covariance, (len(values), channels, channels)), np.array(groups)
    )


@pytest.mark.parametrize(
    ("groups", "channels"), [([0, 0, 0], 1), ([0, 0, 0, 0, 1, 1], 2), ([0] * 10 + [1] * 5, 2)]
)
def test_the_true_means_are_excluded_as_often_as_promised(groups: list[int], channels: int) -> None:
    generator = np.random.default_rng(1)
    mixing = 0.02 * np.array([[1.0, 0.0], [0.6, 0.8]])[:channels, :channels]
    chi_square = []
    for _ in range(1500):
        values = 0.5 + generator.normal(size=(len(groups), channels)) @ mixing.T
        distances = repeats(values, groups).distances(np.full((groups[-1] + 1, channels), 0.5))
        chi_square.append(np.sum(distances**2))
    excluded = stats.chi2.sf(chi_square, (groups[-1] + 1) * channels) < 0.05
    assert np.mean(excluded) == pytest.approx(0.05, abs=0.018)


def test_repeats_of_one_number_give_students_interval() -> None:
    values = np.array([0.80, 0.82, 0.81, 0.79])
    low, high = repeats(values[:, None], [0] * 4).interval(0.95)
    assert (low, high) == pytest.approx(stats.t.interval(0.95, 3, values.mean(), stats.sem(values)))


def test_scatter_beyond_the_stated_uncertainty_is_seen() -> None:
    values = np.array([[0.80], [0.84], [0.79], [0.83]])
    assert repeats(values, [0] * 4, stated=0.001).mean_sd() == pytest.approx(
        stats.sem(values[:, 0]), rel=0.05
    )


def test_identical_trials_do_not_pretend_perfection() -> None:
    alike = repeats(np.full((5, 1), 0.8), [0] * 5)
    assert alike.too_alike
    assert alike.mean_sd() == pytest.approx(0.8 * FINEST_SCATTER / np.sqrt(5), rel=0.01)


def test_two_different_trials_each_seen_twice_show_no_perfect_correlation() -> None:
    pair = repeats(np.array([[0.78, 0.18], [0.74, 0.20]] * 2), [0] * 4)
    assert np.all(np.linalg.eigvalsh(pair.spread) > 0)
    assert np.all(np.isfinite(pair.distances([[0.7, 0.1]])))


def test_lucky_agreement_does_not_beat_the_stated_uncertainty() -> None:
    lucky = repeats(np.array([[0.800], [0.801], [0.8005]]), [0] * 3, stated=0.01)
    assert lucky.mean_sd() >= 0.01 / np.sqrt(3) * 0.999


def test_a_single_trial_is_given_an_assumed_scatter() -> None:
    single = repeats(np.array([[0.8]]), [0])
    assert np.isinf(single.degrees_of_freedom)
    assert single.mean_sd() == pytest.approx(ASSUMED_SCATTER * 0.8)


def test_a_vague_trial_counts_less_than_a_sharp_one() -> None:
    values, groups = np.array([[0.80], [0.81], [0.90]]), np.zeros(3, dtype=np.int64)
    stated = np.array([0.005, 0.005, 0.2]).reshape(3, 1, 1) ** 2
    assert repeats_of(values, stated, groups).means[0, 0] < 0.815


@given(st.floats(0.1, 0.9), st.floats(0.001, 0.1), st.floats(-5.0, 5.0))
def test_a_known_number_is_a_plain_normal_one(mean: float, sd: float, off: float) -> None:
    assert known(mean, sd).distances([[mean + off * sd]])[0] == pytest.approx(off, abs=1e-9)


def test_distances_are_zero_at_the_means_and_grow_away_from_them() -> None:
    pair = repeats(np.array([[0.78, 0.18], [0.77, 0.19], [0.76, 0.185], [0.79, 0.187]]), [0] * 4)
    steps = [float(np.sum(pair.distances(pair.means + step) ** 2)) for step in (0.0, 0.01, 0.1, 1.0, 100.0)]
    assert steps[0] == 0.0
    assert steps == sorted(steps)


def test_verdicts_follow_the_shape_of_the_set() -> None:
    def judged(*intervals: tuple[float, float]) -> str:
        return verdict(intervals, limits=(-3.0, 3.0), widest=1.0)

    assert judged((0.0, 0.5)) == "one value"
    assert judged((0.0, 0.5), (1.0, 1.2)) == "several values"
    assert judged((1.0, 3.0)) == "bounded on one side"
    assert judged((-3.0, 3.0)) == judged((-1.0, 1.0)) == "not determined"


def test_intervals_that_touch_become_one() -> None:
    assert joined([(2.0, 3.0), (0.0, 1.0), (0.5, 1.95)], gap=0.1) == ((0.0, 3.0),)


def test_values_are_rounded_by_their_uncertainty() -> None:
    assert rounded(0.80776, 0.0075) == "0.8078 ± 0.0075"
    assert rounded(10.04, 0.0996) == "10.04 ± 0.10"
    assert rounded(1234.5, 99.6) == "1234 ± 100"


def test_an_error_common_to_all_trials_is_not_averaged_away() -> None:
    values, groups = np.full((400, 1), 0.8), np.zeros(400, dtype=np.int64)
    stated = np.full((400, 1, 1), 1e-6)
    alike = repeats_of(values, stated, groups, shared=np.full((400, 1, 1), 0.005))
    assert alike.mean_sd() == pytest.approx(0.005, rel=0.01)
    assert abs(alike.distances([[0.81]])[0]) == pytest.approx(2.0, rel=0.02)
    low, high = alike.interval(0.95)
    assert high - low == pytest.approx(2 * 1.96 * 0.005, rel=0.01)


def test_a_wrong_scale_moves_velocities_but_not_their_ratio() -> None:
    speed = np.linspace(2.0, 3.0, 6)
    table = {
        "kind": ["plate"] * 6,
        "approach_velocity": -speed,
        "upper_rebound_velocity": 0.8 * speed,
        "approach_velocity_scale": -0.02 * speed,
        "upper_rebound_velocity_scale": 0.016 * speed,
        "approach_velocity_sd": np.hypot(0.02, 0.001) * speed,
        "upper_rebound_velocity_sd": np.hypot(0.016, 0.001) * speed,
    }
    told = observed_restitution(check_trials(pd.DataFrame(table)), "plate")
    silent = observed_restitution(
        check_trials(pd.DataFrame(table)[["kind", *[c for c in table if c.endswith(("velocity", "sd"))]]]),
        "plate",
    )
    assert told is not None
    assert silent is not None
    assert told.repeats.mean_sd() < 0.001 < 0.005 < silent.repeats.mean_sd()


def test_scatter_in_proportion_to_speed_is_seen_as_such() -> None:
    generator = np.random.default_rng(4)
    means, groups = np.array([[0.7, 0.1], [0.7, 0.5]]), np.repeat([0, 1], 500)
    values = means[groups] * (1 + 0.01 * generator.normal(size=(1000, 2)))
    found = repeats_of(values, np.full((1000, 2, 2), np.nan), groups)
    for group in (0, 1):
        deviations = np.sqrt(np.diagonal(found.covariance(group)))
        assert deviations == pytest.approx(0.01 * means[group], rel=0.06)

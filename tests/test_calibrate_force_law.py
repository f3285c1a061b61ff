"""Linear or Hertz: the data tell where they can, and say so where they cannot."""

import numpy as np
import pytest

from calibrate.fit import misfit_of
from calibrate.force_law import ForceLaws, compare_force_laws
from calibrate.model import HERTZ, LINEAR
from calibrate.simulate import Design, Truth, simulate_trials

GOOD = Design(plate=6, held=6, two={1.0: 6, 2.0: 6})


def compared(exponent: float, design: Design = GOOD) -> ForceLaws:
    truth = Truth(stiffness_ratio=10.0, ball_ball=0.81, ball_table=0.85, exponent=exponent)
    return compare_force_laws(misfit_of(simulate_trials(truth, design, np.random.default_rng(1))))


@pytest.mark.slow
@pytest.mark.parametrize(("exponent", "name"), [(LINEAR, "linear, not Hertz"), (HERTZ, "Hertz, not linear")])
def test_good_data_tell_the_force_law(exponent: float, name: str) -> None:
    laws = compared(exponent)
    assert laws.sentence == f"the data tell: {name}"
    assert any(low <= exponent <= high for low, high in laws.intervals_95)
    law = laws.linear if exponent == LINEAR else laws.hertz
    assert law.stiffness_ratio.intervals_95[0] == pytest.approx((10.0, 10.0), rel=0.1)


@pytest.mark.slow
def test_one_mass_pair_cannot_tell_the_force_law() -> None:
    laws = compared(LINEAR, Design(plate=4, held=4, two={1.0: 4}))
    assert "the data cannot tell linear from Hertz" in str(laws)


@pytest.mark.slow
def test_an_exponent_between_the_two_is_found() -> None:
    laws = compared(1.25)
    assert laws.best == pytest.approx(1.25, abs=0.03)
    assert "neither linear nor Hertz describes the data" in laws.sentence

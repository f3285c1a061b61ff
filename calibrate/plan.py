"""Which experiment would tell candidate stiffness ratios apart, before a single ball is dropped."""

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

from calibrate.expectation import Expectation, expectation
from calibrate.intervals import ONE_VALUE
from calibrate.landscape import Landscape
from calibrate.setup import Setup
from calibrate.simulate import Design

CANDIDATES = (0.5, 1.0, 2.0, 2.83, 5.0, 10.0, 20.0, 50.0)
"""Stiffness ratios that a plan has to tell apart where nobody says which."""
_COUNTS = (3, 5, 10, 20)  # trials that may be added at once
_MOST_ADDITIONS = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """A design with what it is expected to find, candidate by candidate.

    Attributes
    ----------
    design : Design
        Numbers of trials of each kind.
    added : mapping of str or float to int
        Trials added to the design asked about: ``held``, ``plate``, or a mass ratio, to their number.
    expectations : tuple of Expectation
        In the order of the candidates.
    """

    design: Design
    expectations: tuple[Expectation, ...]
    added: Mapping[str | float, int] = field(default_factory=dict)

    @property
    def settles(self) -> bool:
        """Whether each candidate would come out as one value."""
        return all(each.verdict == ONE_VALUE for each in self.expectations)

    @property
    def unsettled(self) -> int:
        """How many candidates would not."""
        return sum(each.verdict != ONE_VALUE for each in self.expectations)


def expected(view: Landscape, setup: Setup, design: Design, candidates: Sequence[float]) -> Plan:
    """Tell what a design would find if each of several ratios were the truth.

    Parameters
    ----------
    view : Landscape
        For all mass ratios of the design and all candidates.
    setup : Setup
        Camera, heights and repeatability.
    design : Design
        Numbers of trials.
    candidates : sequence of float
        Stiffness ratios, ball-table over ball-ball.

    Raises
    ------
    ValueError
        If the design has no two-ball trial.
    """
    if not any(design.two.values()):
        raise ValueError("a plan needs at least one two-ball trial, got none")
    return Plan(
        design=design, expectations=tuple(expectation(view, setup, design, truth) for truth in candidates)
    )


def smallest_addition(
    view: Landscape, setup: Setup, design: Design, candidates: Sequence[float]
) -> Plan | None:
    """Find the fewest added trials with which every candidate would come out as one value.

    Parameters
    ----------
    view, setup, design, candidates
        As for `expected`; trials with all mass ratios of the landscape, and drops, may be added.

    Returns
    -------
    Plan or None
        The plan that settles all with fewest trials, else the one that leaves fewest candidates open; None
        if no addition settles more than the design alone.
    """
    best, fewest = None, expected(view, setup, design, candidates).unsettled
    for added in _additions(view.mass_ratios):
        plan = replace(expected(view, setup, _extended(design, added), candidates), added=added)
        if plan.settles:
            return plan
        if plan.unsettled < fewest:
            best, fewest = plan, plan.unsettled
    return best


def _additions(mass_ratios: Sequence[float]) -> Iterator[dict[str | float, int]]:
    """List what may be added, fewest trials first; fewer kinds of trial before more."""
    kinds: tuple[str | float, ...] = (*mass_ratios, "held", "plate")
    choices = [
        dict(zip(chosen, counts, strict=True))
        for number in range(1, _MOST_ADDITIONS + 1)
        for chosen in itertools.combinations(kinds, number)
        for counts in itertools.product(_COUNTS, repeat=number)
    ]
    yield from sorted(choices, key=lambda added: (sum(added.values()), len(added)))


def _extended(design: Design, added: Mapping[str | float, int]) -> Design:
    two = dict(design.two)
    for kind, count in added.items():
        if not isinstance(kind, str):
            two[kind] = two.get(kind, 0) + count
    return Design(
        plate=design.plate + added.get("plate", 0), held=design.held + added.get("held", 0), two=two
    )

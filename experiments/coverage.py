"""How often the 95 % set of the stiffness ratio holds the truth: hundreds of simulated experiments."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import joblib

from calibrate.coverage import Coverage, coverage_of, simulated_estimate
from calibrate.simulate import Design, Truth
from experiments import paper

RATIOS = (0.3, 2.0, 10.0, 60.0)
TRUTH = Truth(
    stiffness_ratio=paper.STIFFNESS_RATIO, ball_ball=paper.BALL_BALL.mean, ball_table=paper.BALL_TABLE.mean
)
Experiments = tuple[Truth, Design]
DESIGNS: dict[str, Experiments] = {
    "few repeats of two mass pairs": (TRUTH, Design()),
    "the paper's design": (
        replace(TRUTH, restitution_scatter=paper.BALL_TABLE.sd, rebound_scatter=(0.02, 0.02)),
        Design(plate=16, held=8, two={1.0: 10}),
    ),
}


def compute(
    design: str, experiments: int, workers: int = 1, ratios: Sequence[float] = RATIOS
) -> Iterator[Coverage]:
    """Simulate and fit experiments with each of several stiffness ratios.

    Parameters
    ----------
    design : str
        One of `DESIGNS`.
    experiments : int
        How many with each ratio; their seeds are 0, 1, 2, …
    workers : int
        Processes side by side.
    ratios : sequence of float
        Ball-table over ball-ball stiffness.

    Yields
    ------
    Coverage
        For each ratio in turn.
    """
    truth, trials = DESIGNS[design]
    run: Callable[..., object] = joblib.delayed(simulated_estimate)
    for ratio in ratios:
        mine = replace(truth, stiffness_ratio=ratio)
        estimates = joblib.Parallel(n_jobs=workers)(run(mine, trials, seed) for seed in range(experiments))
        yield coverage_of(estimates, ratio)


def coverage_text(design: str, rows: Sequence[Coverage]) -> str:
    """Print the counts as a table.

    Examples
    --------
    >>> row = Coverage(stiffness_ratio=2.0, experiments=20, held=19, wrong=1, verdicts={"one value": 18})
    >>> print(coverage_text("few repeats", [row]))
    few repeats; wanted: truth held 90 to 99 %, one value wrong below 5 %
     k2/k1  experiments  truth held  one value  wrong
         2           20      95.0 %     90.0 %  5.0 %
    """
    lines = [
        f"{design}; wanted: truth held 90 to 99 %, one value wrong below 5 %",
        " k2/k1  experiments  truth held  one value  wrong",
    ]
    for row in rows:
        held, sure, wrong = (
            f"{count / row.experiments:.1%}".replace("%", " %")
            for count in (row.held, row.verdicts.get("one value", 0), row.wrong)
        )
        lines.append(f"{row.stiffness_ratio:>6g}  {row.experiments:>11}  {held:>10}  {sure:>9}  {wrong:>5}")
    return "\n".join(lines)

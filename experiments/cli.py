"""`impactlab`: thin verbs over the rooms. Each imports what it needs when it runs: help comes at once."""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from experiments import plan
from experiments.fit import EPILOG, calibrated, fit
from experiments.simulate import simulate
from experiments.verbs import SOME_FAILED, verb

if TYPE_CHECKING:
    from experiments.trial import Trial

app = typer.Typer(
    help="Film simultaneous collisions, measure them, and fit the impact model to them.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
app.add_typer(simulate, name="simulate")
app.command(epilog=EPILOG)(fit)
app.command(epilog=plan.EPILOG)(plan.plan)

FIGURES = ("fig3", "fig4", "fig5", "table1", "states")
Quiet = Annotated[bool, typer.Option("--quiet", help="No progress, no remarks.")]
Out = Annotated[Path, typer.Option(help="Folder to write to; made when missing.")]


@app.command(epilog="Example: impactlab demo --out demo")
@verb
def demo(
    out: Out = Path("demo"),
    seed: Annotated[int, typer.Option(help="Another seed films another experiment.")] = 1,
    workers: Annotated[int | None, typer.Option(help="Processes side by side; all cores without it.")] = None,
    quiet: Quiet = False,
) -> None:
    """Film an experiment with known truth, measure it, fit it, draw Fig. 5: fitted against truth."""
    from experiments import console
    from experiments.demo import Truth, film, fitted_against_truth, recordings
    from experiments.experiment import read_experiment

    truth = Truth()
    films = film(out / "recordings", seed=seed, workers=cores() if workers is None else workers, truth=truth)
    for _ in console.progress(films, recordings(), "filming", quiet=quiet):
        pass
    measure(read_experiment(out / "recordings" / "experiment.toml"), out, workers, quiet, overlays=False)
    typer.echo("")
    calibration = calibrated([out / "trials.csv"], out, {})
    typer.echo("\n" + fitted_against_truth(calibration, truth))


@app.command(
    epilog="Example: impactlab process drops/ --kind plate --ball-diameter 0.040 --ball-mass 0.0027 --out out"
)
@verb
def process(
    sources: Annotated[
        list[Path], typer.Argument(help="experiment.toml, videos, or folders of either.", metavar="SOURCE...")
    ],
    out: Out = Path("out"),
    kind: Annotated[
        str | None, typer.Option(help="What bare videos show: plate, held, two, shot or pair.")
    ] = None,
    ball_diameter: Annotated[float | None, typer.Option(help="Of the balls in bare videos, m.")] = None,
    ball_mass: Annotated[
        float | None, typer.Option(help="Of the balls in bare videos, kg; without it air is left out.")
    ] = None,
    metres_per_pixel: Annotated[
        float | None, typer.Option(help="Scale; else the ball's diameter tells it.")
    ] = None,
    capture_fps: Annotated[
        float | None, typer.Option(help="Frames captured a second, if the file does not tell.")
    ] = None,
    readout: Annotated[float, typer.Option(help="Rolling shutter: first to last row, s.")] = 0.0,
    overlays: Annotated[bool, typer.Option(help="Draw what was found on the recordings.")] = True,
    workers: Annotated[int | None, typer.Option(help="Processes side by side; all cores without it.")] = None,
    quiet: Quiet = False,
) -> None:
    """Measure recordings: velocities before and after each impact, into trials.csv, tracks/, overlays/."""
    from experiments.experiment import collect_trials
    from experiments.trial import Body, Camera

    ball = Body(mass=ball_mass, diameter=ball_diameter)
    scale = {} if metres_per_pixel is None else {"metres_per_pixel": metres_per_pixel}
    trials = collect_trials(
        sources,
        kind=kind,
        bodies=dict.fromkeys(("upper", "lower", "ball", "striker", "struck"), ball),
        camera=Camera(capture_fps=capture_fps, readout=readout, scale=scale),
    )
    if measure(trials, out, workers, quiet, overlays=overlays):
        raise typer.Exit(SOME_FAILED)


@app.command(epilog="Example: impactlab figures fig4 fig5 --out figures")
@verb
def figures(
    names: Annotated[
        list[str] | None, typer.Argument(help="All without a name.", metavar="[NAME]...")
    ] = None,
    out: Out = Path("figures"),
) -> None:
    """Recreate the paper's figures and tables; print ours, printed, difference. `states` is our own."""
    import importlib

    for name in names or FIGURES:
        if name not in FIGURES:
            raise ValueError(f"figure must be one of {', '.join(FIGURES)}, got {name!r}")
    for name in names or FIGURES:
        typer.echo(importlib.import_module(f"experiments.{name}").main(out) + "\n")


@app.command(epilog="Example: impactlab bench engine tracking")
@verb
def bench(
    names: Annotated[
        list[str] | None, typer.Argument(help="All without a name.", metavar="[NAME]...")
    ] = None,
    coverage: Annotated[
        int,
        typer.Option(help="Instead, fit so many simulated experiments a ratio: do the 95 % sets hold?"),
    ] = 0,
    accuracy: Annotated[
        bool, typer.Option("--accuracy", help="Instead, track fresh recordings of known truth: how exactly?")
    ] = False,
) -> None:
    """Measure speed and accuracy on this machine, each figure beside the one that is wanted."""
    if coverage:
        return count_coverage(coverage)
    if accuracy:
        return measure_accuracy()
    from experiments import bench as benches
    from experiments import bench_tracking

    rows = {
        "engine": benches.engine,
        "compilation": benches.compilation,
        "calibration": benches.calibration,
        "tracking": bench_tracking.throughput,
        "memory": bench_tracking.memory,
    }
    unknown = set(names or ()) - set(rows)
    if unknown:
        raise ValueError(f"a bench must be one of {', '.join(rows)}, got {', '.join(sorted(unknown))}")
    typer.echo(f"a million additions in plain Python take {benches.yardstick() * 1e3:.0f} ms here")
    for name in names or rows:
        typer.echo("")
        for line in benches.lines(name, rows[name]()):
            typer.echo(line)


def count_coverage(experiments: int) -> None:
    """Print how often the sets of simulated experiments hold the truth; minutes to an hour."""
    from experiments.coverage import DESIGNS, compute, coverage_text

    for design in DESIGNS:
        typer.echo(coverage_text(design, list(compute(design, experiments, cores()))) + "\n")


def measure_accuracy() -> None:
    """Print how exactly rendered recordings are measured; some minutes."""
    from experiments import bench_accuracy, bench_velocity
    from experiments.bench import lines

    rows = {
        "centres": bench_accuracy.centres,
        "velocities": bench_velocity.velocities,
        "times": bench_velocity.times,
        "rolling shutter": bench_velocity.shutter,
    }
    for title, measured in rows.items():
        for line in lines(title, measured()):
            typer.echo(line)
        typer.echo("")


def measure(trials: "Sequence[Trial]", out: Path, workers: int | None, quiet: bool, *, overlays: bool) -> int:
    """Process trials, print a line an impact; give the number of trials that failed."""
    from experiments import console
    from experiments.process import process as process_trials

    width, headline, failed = console.name_width(trial.name for trial in trials), "", 0
    workers = cores() if workers is None else workers
    done = process_trials(trials, out, workers=workers, overlays=overlays)
    for measured in console.progress(done, len(trials), "measuring", quiet=quiet):
        if headline != (headline := console.headline(measured.trial.kind, width)):
            typer.echo(headline)
        for line in console.impact_lines(measured, width):
            typer.echo(line)
        for line in () if quiet else console.complaints(measured):
            typer.echo(line, err=True)
        failed += any(row["status"] == "failed" for row in measured.rows)
    return failed


def cores() -> int:
    """Cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def main() -> None:
    """Run the command line."""
    app()

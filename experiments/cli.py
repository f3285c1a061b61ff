"""`impactlab`: thin verbs over the rooms. Each imports what it needs when it runs: help comes at once."""

import signal
from pathlib import Path
from typing import Annotated

import typer

from experiments import plan, run
from experiments.fit import EPILOG, fit
from experiments.fitting import calibrated
from experiments.run import Out, Quiet, Workers, cores, leave_report, measure
from experiments.simulate import simulate
from experiments.verbs import INTERRUPTED, announce_compilation, verb

app = typer.Typer(
    help="Film simultaneous collisions, measure them, and fit the impact model to them.",
    no_args_is_help=True,
    add_completion=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
app.add_typer(simulate, name="simulate")
app.command(epilog=run.EPILOG)(run.process)
app.command(epilog=EPILOG)(fit)
app.command(epilog=plan.EPILOG)(plan.plan)

FIGURES = ("fig3", "fig4", "fig5", "table1", "states")


@app.command(epilog="Example: impactlab demo --out demo")
@verb
def demo(
    out: Out = Path("demo"),
    seed: Annotated[int, typer.Option(help="Another seed films another experiment.")] = 1,
    workers: Workers = None,
    quiet: Quiet = False,
) -> None:
    """Film an experiment with known truth, measure it, fit it, draw Fig. 5: fitted against truth."""
    from experiments import console
    from experiments.batch import Batch
    from experiments.demo import Truth, film, fitted_against_truth, recordings
    from experiments.experiment import read_experiment

    truth = Truth()
    workers = cores() if workers is None else workers
    films = film(out / "recordings", seed=seed, workers=workers, truth=truth)
    for _ in console.progress(films, recordings(), "filming", quiet=quiet):
        pass
    batch = Batch(out=out, workers=workers, overlays=False)
    if measure(read_experiment(out / "recordings" / "experiment.toml"), batch, quiet=quiet) == INTERRUPTED:
        raise typer.Exit(INTERRUPTED)
    announce_compilation()
    calibration = calibrated([out / "trials.csv"], out, {})
    typer.echo(f"\n{calibration}")
    typer.echo("\n" + fitted_against_truth(calibration, truth))
    leave_report(out, "demo", quiet=quiet)


@app.command(epilog="Example: impactlab report out")
@verb
def report(
    out: Annotated[Path, typer.Argument(help="Folder that process or fit wrote to.", metavar="DIR")],
) -> None:
    """Write report.html again: what was measured, what failed and why, what the fit says."""
    from experiments.report import write_report

    typer.echo(write_report(out))


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
    announce_compilation()
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


def main() -> None:
    """Run the command line; who asks it to end, as schedulers of clusters do, interrupts it."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    app()

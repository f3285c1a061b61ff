"""The verb `process`: recordings in; trials.csv, tracks, overlays and a report out."""

import json
import os
from collections import Counter
from collections.abc import Sequence
from contextlib import closing, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from experiments.apart import USUAL_TIMEOUT
from experiments.verbs import INTERRUPTED, SOME_FAILED, TRACKING, announce_compilation, verb

if TYPE_CHECKING:
    from experiments.batch import Batch
    from experiments.record import Record
    from experiments.trial import Trial

EPILOG = "Example: impactlab process drops/ --kind plate --ball-diameter 0.040 --ball-mass 0.0027 --out out"
COLOURS = {"suspect": "yellow", "failed": "red"}

Out = Annotated[Path, typer.Option(help="Folder to write to; made when missing.")]
Quiet = Annotated[bool, typer.Option("--quiet", help="No progress, no remarks.")]
Json = Annotated[bool, typer.Option("--json", help="Print the results as JSON, and nothing else.")]
Workers = Annotated[
    int | None, typer.Option(help="Recordings measured side by side; as many as cores without it.")
]


@verb
def process(
    sources: Annotated[
        list[str],
        typer.Argument(help="experiment.toml, videos, folders of either, or patterns.", metavar="SOURCE..."),
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
    start_px: Annotated[
        tuple[float, float] | None,
        typer.Option(help="Where the ball to measure is first seen, x and y in px, if several move."),
    ] = None,
    readout: Annotated[
        float | None, typer.Option(help="Rolling shutter: first to last row, s; 0 if the camera has none.")
    ] = None,
    overlays: Annotated[bool, typer.Option(help="Draw what was found on the recordings.")] = True,
    workers: Workers = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="Keep what is finished of the same recordings, options and code.")
    ] = False,
    timeout: Annotated[float, typer.Option(help="Seconds a recording may take.")] = USUAL_TIMEOUT,
    memory: Annotated[
        float | None,
        typer.Option(help="GB a recording may take (Linux); without it a fair share of what there is."),
    ] = None,
    cluster: Annotated[
        str | None, typer.Option(help="Dask scheduler, tcp://host:port, whose workers do the work.")
    ] = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Measure recordings: velocities before and after each impact; write trials.csv and report.html."""
    from experiments.apart import Limits, fair_memory
    from experiments.batch import Batch
    from experiments.experiment import collect_trials
    from experiments.trial import Body, Camera

    ball = Body(mass=ball_mass, diameter=ball_diameter)
    scale = {} if metres_per_pixel is None else {"metres_per_pixel": metres_per_pixel}
    camera = Camera(capture_fps=capture_fps, readout=readout, scale=scale)
    trials = collect_trials(
        sources,
        kind=kind,
        bodies=dict.fromkeys(("upper", "lower", "ball", "striker", "struck"), ball),
        camera=camera,
        start_px=start_px,
    )
    if camera != Camera() and any(trial.camera != camera for trial in trials):
        typer.echo("options of the camera serve bare videos only: experiment.toml has [camera]", err=True)
    workers = cores() if workers is None else workers
    if memory is None and cluster is None and workers > 0:
        memory = fair_memory(workers)
    batch = Batch(
        out=out,
        workers=workers,
        overlays=overlays,
        resume=resume,
        limits=Limits(timeout=timeout, memory=memory),
        cluster=cluster,
    )
    code = measure(trials, batch, quiet=quiet, as_json=as_json)
    leave_report(out, "process", quiet=quiet)
    if code:
        raise typer.Exit(code)


def measure(trials: "Sequence[Trial]", batch: "Batch", *, quiet: bool, as_json: bool = False) -> int:
    """Process trials, print a line an impact, or all rows as JSON; give the exit code."""
    from experiments import console
    from experiments.batch import in_order, process_all

    if not quiet:
        announce_compilation(TRACKING, "what tracks balls")
    records: list[Record] = []
    said: Counter[str] = Counter()
    total, width, headline = len(trials), console.name_width(trial.name for trial in trials), ""
    try:
        with (
            closing(process_all(trials, batch)) as done,
            closing(console.progress(done, total, "measuring", quiet=quiet)) as watched,
        ):
            for record in in_order(watched, trials):
                records.append(record)
                if not as_json:
                    headline = show(record, headline, width)
                for line in () if quiet else console.complaints(record, said):
                    typer.echo(line, err=True)
    except KeyboardInterrupt:
        typer.echo("impactlab: stopped; what is finished is kept, go on with --resume", err=True)
        return INTERRUPTED
    for line in () if quiet else console.said_again(said):
        typer.echo(line, err=True)
    if batch.resume and not quiet:
        kept = sum(record.kept for record in records)
        typer.echo(f"{kept} of {total} trials were finished before and are kept", err=True)
    if as_json:
        print_json([row for record in records for row in record.rows])
    failed = any(row["status"] == "failed" for record in records for row in record.rows)
    return SOME_FAILED if failed else 0


def print_json(results: object) -> None:
    """Print results for machines."""
    typer.echo(json.dumps(results, ensure_ascii=False, indent=1))


def leave_report(out: Path, verb: str, *, quiet: bool) -> None:
    """Write down how the command was called, and the page of what lies in `out`, if anything does."""
    from experiments.experiment import ExperimentError
    from experiments.provenance import write_command
    from experiments.report import write_report

    write_command(out, verb)
    with suppress(ExperimentError):
        page = write_report(out)
        if not quiet:
            typer.echo(f"report: {page}", err=True)


def show(record: "Record", headline: str, width: int) -> str:
    """Print the impacts of a trial, under their headline where it changes, and give it."""
    from experiments import console

    if headline != (headline := console.headline(record.kind, width)):
        typer.echo(headline)
    for row, line in zip(record.rows, console.impact_lines(record, width), strict=True):
        colour = COLOURS.get(row["status"])
        typer.echo(typer.style(line, fg=colour) if colour else line)
    return headline


def cores() -> int:
    """Cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1

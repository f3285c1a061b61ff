"""`impactlab simulate`: a collision, or a table of trials, from numbers on the command line."""

from pathlib import Path
from typing import Annotated

import typer

from experiments import paper
from experiments.verbs import announce_compilation, verb
from impact import Ball, Contact, Cue, CueShot, RestitutionLaw, TwoBallDrop

simulate = typer.Typer(
    help="Run one collision, or make a table of trials, from numbers on the command line.",
    no_args_is_help=True,
)

Vector = tuple[float, float, float]


@simulate.command(epilog="Example: impactlab simulate drop --stiffness-ratio 10 --approach-velocity -3")
@verb
def drop(
    stiffness_ratio: Annotated[float, typer.Option(help="Ball-table over ball-ball, k2/k1.")] = 10.0,
    ball_ball: Annotated[float, typer.Option(help="Ball-ball restitution.")] = 0.81,
    ball_table: Annotated[float, typer.Option(help="Ball-table restitution.")] = 0.85,
    upper_mass: Annotated[float, typer.Option(help="kg")] = 0.0027,
    lower_mass: Annotated[float, typer.Option(help="kg")] = 0.0027,
    approach_velocity: Annotated[float, typer.Option(help="m/s, up positive.")] = -3.0,
    exponent: Annotated[float, typer.Option(help="Of the force law: 1 linear, 1.5 Hertz.")] = 1.0,
    plot: Annotated[
        Path | None, typer.Option(help="Draw impulse curve and energies: FILE.svg or .png.")
    ] = None,
) -> None:
    """Drop a ball on a ball that rests on a table: states, impulses, velocities."""
    announce_compilation()
    from experiments.drawing import save_figure
    from experiments.fig4 import compute, describe, draw

    curve = compute(
        TwoBallDrop(
            upper=Ball(mass=upper_mass, radius=0.020),
            lower=Ball(mass=lower_mass, radius=0.020),
            ball_ball=Contact(restitution=ball_ball, stiffness=1.0, exponent=exponent),
            ball_table=Contact(restitution=ball_table, stiffness=stiffness_ratio, exponent=exponent),
            approach_velocity=approach_velocity,
        )
    )
    typer.echo(describe(curve))
    if plot:
        save_figure(draw(curve), plot)


@simulate.command(epilog="Example: impactlab simulate trials --mass-ratio 1 --mass-ratio 2 --out pairs.csv")
@verb
def trials(
    out: Annotated[Path, typer.Option(help="Table to write, for impactlab fit.")] = Path("simulated.csv"),
    stiffness_ratio: Annotated[
        float, typer.Option(help="Ball-table over ball-ball, k2/k1.")
    ] = paper.STIFFNESS_RATIO,
    ball_ball: Annotated[float, typer.Option(help="Ball-ball restitution.")] = paper.BALL_BALL.mean,
    ball_table: Annotated[float, typer.Option(help="Ball-table restitution.")] = paper.BALL_TABLE.mean,
    mass_ratio: Annotated[list[float], typer.Option(help="Upper over lower mass; name several.")] = [1.0],  # noqa: B006
    count: Annotated[int, typer.Option(help="Trials of each mass ratio, at as many heights.")] = 10,
    scatter: Annotated[float, typer.Option(help="Of rebounds from trial to trial, relative.")] = 0.02,
    exponent: Annotated[float, typer.Option(help="Of the force law: 1 linear, 1.5 Hertz.")] = 1.0,
    seed: Annotated[
        int | None, typer.Option(help="Draw the scatter by chance; without it, it is exactly as stated.")
    ] = None,
) -> None:
    """Make a table of two-ball trials with a known truth, to see what a fit would find. Default: Fig. 5."""
    announce_compilation()
    import numpy as np

    from calibrate.simulate import Design, Truth, simulate_trials, typical_trials
    from calibrate.trials import write_trials

    truth = Truth(
        stiffness_ratio=stiffness_ratio,
        ball_ball=ball_ball,
        ball_table=ball_table,
        exponent=exponent,
        rebound_scatter=(scatter, scatter),
    )
    two = dict.fromkeys(mass_ratio, count)
    if seed is None:
        table = typical_trials(truth, two)
    else:
        design = Design(plate=0, held=0, two=two)
        table = simulate_trials(truth, design, np.random.default_rng(seed))
    typer.echo(f"{len(table)} trials in {write_trials(table, out)}")


@simulate.command(epilog="Example: impactlab simulate shot --normal -1 -2 1 --cue-velocity 0 0 -2")
@verb
def shot(
    offset: Annotated[
        tuple[float, float] | None,
        typer.Option(help="Where the tip strikes, seen along the cue: right, up, in ball radii."),
    ] = None,
    normal: Annotated[
        Vector | None, typer.Option(help="The same as outward normal of the ball there: x, y, z.")
    ] = None,
    speed: Annotated[float | None, typer.Option(help="Of the cue, m/s; 1 without it.")] = None,
    elevation: Annotated[
        float | None, typer.Option(help="Of the cue, degrees from level; it points along x. 0 without it.")
    ] = None,
    cue_velocity: Annotated[
        Vector | None, typer.Option(help="Direction and speed in one: x, y, z (up), m/s.")
    ] = None,
    ball_mass: Annotated[float, typer.Option(help="kg")] = paper.SHOT_BALL_MASS,
    cue_mass: Annotated[float, typer.Option(help="kg")] = paper.SHOT_CUE_MASS,
    ball_radius: Annotated[float, typer.Option(help="m")] = paper.SHOT_BALL_RADIUS,
    tip_restitution: Annotated[float, typer.Option(help="Tip-ball.")] = paper.SHOT_TIP_RESTITUTION,
    tip_friction: Annotated[float, typer.Option(help="Tip-ball.")] = paper.SHOT_TIP_FRICTION,
    table_restitution: Annotated[float, typer.Option(help="Ball-table.")] = paper.SHOT_TABLE_RESTITUTION,
    table_friction: Annotated[float, typer.Option(help="Ball-table.")] = paper.SHOT_TABLE_FRICTION,
    stiffness_ratio: Annotated[
        float, typer.Option(help="Ball-table over tip-ball, k_bt/k_cb.")
    ] = paper.SHOT_STIFFNESS_RATIO,
    exponent: Annotated[float, typer.Option(help="Of the force law: 1 linear, 1.5 Hertz.")] = 1.0,
    law: Annotated[RestitutionLaw, typer.Option(help="When restitution ends.")] = RestitutionLaw.ENERGY,
    plot: Annotated[
        Path | None, typer.Option(help="Draw impulses, energies and trajectory: FILE.svg or .png.")
    ] = None,
) -> None:
    """Strike a ball on the table with a cue: states, impulses, velocities. Constants: the paper's Table 1."""
    announce_compilation()
    from experiments import cue_shot
    from experiments.aim import aimed_cue, struck_normal
    from experiments.drawing import save_figure

    velocity = aimed_cue(cue_velocity, speed, elevation)
    done = cue_shot.compute(
        CueShot(
            ball=Ball(mass=ball_mass, radius=ball_radius),
            cue=Cue(mass=cue_mass),
            normal=struck_normal(normal, offset, velocity),
            cue_velocity=velocity,
            tip_ball=Contact(restitution=tip_restitution, friction=tip_friction, exponent=exponent),
            ball_table=Contact(
                restitution=table_restitution,
                friction=table_friction,
                stiffness=stiffness_ratio,
                exponent=exponent,
            ),
        ),
        law,
    )
    typer.echo(cue_shot.describe(done))
    if plot:
        save_figure(cue_shot.draw(done), plot)

"""`Track` → impact events: velocities just before and just after, with their uncertainties.

The flights before and after an impact meet in one point of time and height. Fitting both at once, each in
closed form through air, is what makes a restitution good to a fraction of a per cent: two-point differences
are off by 20 %, free parabolas by 1 %, and neglected air imitates a restitution that depends on speed.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from tracking.bounce import FEWEST_FRAMES, Bounce, crossing, find_bounces, until_next_meeting
from tracking.budget import NOTHING_SHARED, Budget
from tracking.flight import Flight
from tracking.hop import low_hop
from tracking.joint import JointFit, Meeting, P, Side, fit_meeting, moved, without_outliers
from tracking.model_free import UNKNOWN, free_parabolas
from tracking.notebook import html_table
from tracking.sides import first_guess, is_low, lower_sides, slope, upper_sides
from tracking.track import Track

FloatArray = npt.NDArray[np.float64]

TREMBLING = 0.25  # of the approach speed: a later bounce that is known no better is none
GAP_SHARE_SD = 0.01  # how well the outlines tell the distance of two balls that touch

VELOCITIES = [P.APPROACH, P.REBOUND, P.LOWER_REBOUND]


@dataclass(frozen=True, slots=True, kw_only=True)
class Impact:
    """One impact as measured (SI units, up positive).

    Attributes
    ----------
    time, height : float
        When it happened (s) and the height of the upper ball's centre then (m).
    velocities, sd : (3,) arrays
        Upper ball before, upper ball after, lower ball after (NaN where none is tracked), m/s.
    covariance : (3, 3) array
        Of the velocities, (m/s)²: the frames' own errors and all `shared` ones.
    shared : mapping of str to (3,) array
        What one standard deviation of each error common to all frames (`Budget` names them)
        does to the velocities, m/s, signed.
    gravity_check, gravity_check_sd : float
        Fitted over expected acceleration of the flights: 1 if scale and time base are right; and how far from
        1 it may be by chance and by what is shared.
    free_velocities, free_sd : (3,) arrays
        The velocities again from a parabola through each side's frames alone, m/s; NaN where there are too
        few frames for one.
    free_gravity, free_gravity_sd : (2,) arrays
        Acceleration of those parabolas before and after, downwards, m/s².
    sideways : (2,) array
        Sideways velocity of the upper ball before and after, m/s.
    frames : (2,) tuple of int
        Frames of the upper ball used before and after.
    residual : float
        Root mean square distance of the frames from the fitted flights, m.
    """

    time: float
    height: float
    velocities: FloatArray
    covariance: FloatArray
    shared: Mapping[str, FloatArray]
    gravity_check: float
    gravity_check_sd: float
    free_velocities: FloatArray
    free_sd: FloatArray
    free_gravity: FloatArray
    free_gravity_sd: FloatArray
    sideways: FloatArray
    frames: tuple[int, int]
    residual: float

    @property
    def sd(self) -> FloatArray:
        """Standard deviations of the velocities, m/s."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    def _repr_html_(self) -> str:
        """Show the velocities and whether the ball fell as balls do."""
        names = ("before", "after", "lower ball after")
        rows = [
            (name, f"{value:.4f} ± {sd:.4f} m/s")
            for name, value, sd in zip(names, self.velocities, self.sd, strict=True)
            if np.isfinite(value)
        ]
        rows.append(("gravity check", f"{self.gravity_check:.3f} ± {self.gravity_check_sd:.3f}"))
        rows.append(("frames", f"{self.frames[0]} before, {self.frames[1]} after"))
        return html_table(f"impact at {self.time:.4f} s", rows)


def measure_impacts(track: Track, flight: Flight, budget: Budget = NOTHING_SHARED) -> list[Impact]:
    """Measure every bounce of one ball.

    Parameters
    ----------
    track : Track
        In metres.
    flight : Flight
        How the ball falls through air.
    budget : Budget
        How well scale, time base, air and gravity are known.

    Returns
    -------
    list of Impact
        In order of time; empty if the ball never bounces. After the first, those that tell nothing are left
        out: at last a ball trembles and rolls.
    """
    found = (
        _measure(track, bounce, Meeting(sides=upper_sides(track, bounce, flight)), budget)
        for bounce in find_bounces(track)
    )
    impacts = [impact for impact in found if impact is not None]
    return impacts[:1] + [impact for impact in impacts[1:] if _is_telling(impact)]


def measure_two_ball_impact(
    upper: Track, lower: Track, flights: Sequence[Flight], budget: Budget = NOTHING_SHARED
) -> Impact | None:
    """Measure the first impact of a falling ball on a ball at rest, both fitted jointly.

    They touch at the impact: their centres are the sum of their radii apart, within what the outlines tell.

    Parameters
    ----------
    upper, lower : Track
        In metres.
    flights : two Flights
        Of the upper and of the lower ball.
    budget : Budget
        How well scale, time base, air and gravity are known.

    Returns
    -------
    Impact or None
        None if the upper ball never rebounds.
    """
    bounces = find_bounces(upper)
    if not bounces:
        return None
    bounce = until_next_meeting(bounces[0], upper, lower)
    # a ball that mostly rests shows less than one that flies how far compression errs
    lower = replace(lower, shared_sd=max(upper.shared_sd, lower.shared_sd))
    rest, hop = lower_sides(lower, crossing(upper, bounce.before, bounce.after), flights[1])
    touching = upper.radius + lower.radius
    meeting = Meeting(
        sides=(*upper_sides(upper, bounce, flights[0]), rest), gap=touching, gap_sd=GAP_SHARE_SD * touching
    )
    if is_low(rest, hop):
        impact = _measure(upper, bounce, meeting, budget)
        return None if impact is None else _with_low_hop(impact, lower, flights[1])
    return _measure(upper, bounce, replace(meeting, sides=(*meeting.sides, hop)), budget)


def _with_low_hop(impact: Impact, lower: Track, flight: Flight) -> Impact | None:
    """Add the lower ball's velocity, which rules nothing else; what all frames share is nothing beside it."""
    hop = low_hop(lower, impact.time, flight)
    if hop is None:
        return None
    velocity, sd = hop
    covariance = np.zeros((3, 3))
    covariance[:2, :2] = impact.covariance[:2, :2]
    covariance[2, 2] = sd**2
    return replace(
        impact,
        velocities=np.append(impact.velocities[:2], velocity),
        covariance=covariance,
        shared={name: np.append(effect[:2], 0.0) for name, effect in impact.shared.items()},
    )


def _measure(track: Track, bounce: Bounce, meeting: Meeting, budget: Budget) -> Impact | None:
    """Fit one impact: first robustly, then without frames off the flights, then with free gravity."""
    if _too_few(meeting.sides):
        return None
    free = _free(meeting)
    start = first_guess(track, bounce, meeting.sides)
    robust = fit_meeting(meeting, start, free, robust=True)
    meeting = without_outliers(meeting, robust.parameters)
    if _too_few(meeting.sides):
        return None
    fit = fit_meeting(meeting, robust.parameters, free)
    falling = fit_meeting(meeting, fit.parameters, [*free, P.GRAVITY])
    shared = _effects(fit, meeting, budget)
    weighed = _effects(falling, meeting, budget)
    parabolas = free_parabolas(fit, meeting, budget)
    free_sides = [parabolas.get(place, UNKNOWN) for place in VELOCITIES]
    return Impact(
        time=float(fit.parameters[P.TIME]),
        height=float(fit.parameters[P.HEIGHT]),
        velocities=_known(fit.parameters[VELOCITIES], free),
        covariance=fit.covariance[np.ix_(VELOCITIES, VELOCITIES)]
        + sum(np.outer(effect[VELOCITIES], effect[VELOCITIES]) for effect in shared.values()),
        shared={name: _known(effect[VELOCITIES], free) for name, effect in shared.items()},
        gravity_check=float(falling.parameters[P.GRAVITY]),
        gravity_check_sd=float(
            np.sqrt(
                falling.covariance[P.GRAVITY, P.GRAVITY]
                + sum(effect[P.GRAVITY] ** 2 for effect in weighed.values())
            )
        ),
        free_velocities=np.array([side.velocity for side in free_sides]),
        free_sd=np.array([side.velocity_sd for side in free_sides]),
        free_gravity=np.array([-side.acceleration for side in free_sides[:2]]),
        free_gravity_sd=np.array([side.acceleration_sd for side in free_sides[:2]]),
        sideways=np.array([slope(track.time[i], track.x[i]) for i in (bounce.before, bounce.after)]),
        frames=(len(meeting.sides[0].time), len(meeting.sides[1].time)),
        residual=fit.residual,
    )


def _effects(fit: JointFit, meeting: Meeting, budget: Budget) -> dict[str, FloatArray]:
    """Give what one standard deviation of each shared error does to the fitted parameters."""
    return {name: moved(fit, meeting, changed) for name, changed in budget.changed(meeting).items()}


def _free(meeting: Meeting) -> list[P]:
    """Parameters that rule the frames of a meeting."""
    starts = {side.start for side in meeting.sides}
    return sorted({P.TIME} | starts | {side.velocity for side in meeting.sides if side.velocity is not None})


def _known(velocities: FloatArray, free: list[P]) -> FloatArray:
    """Leave the velocity of a ball out that is not fitted."""
    return np.where(np.isin(VELOCITIES, free), velocities, np.nan)


def _is_telling(impact: Impact) -> bool:
    """Tell whether the approach is known at all; if not, the ball trembles or rolls rather than bounces."""
    return bool(impact.sd[0] <= TREMBLING * abs(impact.velocities[0]))


def _too_few(sides: Sequence[Side]) -> bool:
    """Tell whether a flight has too few frames to be fitted; one look at a ball at rest is enough."""
    return any(len(side.time) < (1 if side.velocity is None else FEWEST_FRAMES - 1) for side in sides)

"""`Track` → impact events: velocities just before and just after, with their uncertainties.

The flights before and after an impact meet in one point of time and height. Fitting both at once, each in
closed form through air, is what makes a restitution good to a fraction of a per cent: two-point differences
are off by 20 %, free parabolas by 1 %, and neglected air imitates a restitution that depends on speed.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tracking.bounce import FEWEST_FRAMES, WINDOW, Bounce, crossing, find_bounces
from tracking.flight import Flight
from tracking.joint import Meeting, P, Side, fit_meeting, without_outliers
from tracking.track import Track

FloatArray = npt.NDArray[np.float64]
IndexArray = npt.NDArray[np.int64]

GAP_SHARE_SD = 0.01  # how well the outlines tell the distance of two balls that touch
LANDED = 0.3  # a hop has ended when the ball is down to this share of its greatest height
REST_FRAMES = 60
REST_SHARE_SD = 0.01  # how well a ball's height is known where it touches the plate, as a share of its radius

SINGLE = [P.TIME, P.HEIGHT, P.APPROACH, P.REBOUND]
DOUBLE = [*SINGLE, P.LOWER_HEIGHT, P.LOWER_REBOUND]


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
        Of the velocities, (m/s)².
    gravity_check, gravity_check_sd : float
        Fitted over expected acceleration of the flights: 1 if scale and time base are right.
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
    gravity_check: float
    gravity_check_sd: float
    sideways: FloatArray
    frames: tuple[int, int]
    residual: float

    @property
    def sd(self) -> FloatArray:
        """Standard deviations of the velocities, m/s."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))


def measure_impacts(track: Track, flight: Flight) -> list[Impact]:
    """Measure every bounce of one ball.

    Parameters
    ----------
    track : Track
        In metres.
    flight : Flight
        How the ball falls through air.

    Returns
    -------
    list of Impact
        In order of time; empty if the ball never bounces.
    """
    found = (_measure(track, bounce, _upper_sides(track, bounce, flight)) for bounce in find_bounces(track))
    return [impact for impact in found if impact is not None]


def measure_two_ball_impact(upper: Track, lower: Track, flights: Sequence[Flight]) -> Impact | None:
    """Measure the first impact of a falling ball on a ball at rest, both fitted jointly.

    They touch at the impact: their centres are the sum of their radii apart, within what the outlines tell.

    Parameters
    ----------
    upper, lower : Track
        In metres.
    flights : two Flights
        Of the upper and of the lower ball.

    Returns
    -------
    Impact or None
        None if the upper ball never rebounds.
    """
    bounces = find_bounces(upper)
    if not bounces:
        return None
    bounce = bounces[0]
    impact = crossing(upper, bounce.before, bounce.after)
    sides = [*_upper_sides(upper, bounce, flights[0]), *_lower_sides(lower, impact, flights[1])]
    return _measure(upper, bounce, sides, touching=upper.radius + lower.radius)


def _upper_sides(track: Track, bounce: Bounce, flight: Flight) -> list[Side]:
    """Flights of the falling ball before and after the impact."""
    return [
        _side(track, bounce.before, (P.HEIGHT, P.APPROACH), flight),
        _side(track, bounce.after, (P.HEIGHT, P.REBOUND), flight),
    ]


def _lower_sides(lower: Track, impact: float, flight: Flight) -> list[Side]:
    """Rest of the lower ball before the impact, and its hop until shortly before it lands."""
    interval = float(np.median(np.diff(lower.time)))
    before = np.flatnonzero(lower.time < impact - interval / 2)[-REST_FRAMES:]
    after = np.flatnonzero((lower.time > impact + interval / 2) & (lower.time < impact + WINDOW))
    lift = lower.y[after] - np.median(lower.y[before])
    highest = np.maximum.accumulate(lift)
    landed = np.flatnonzero((lift < LANDED * highest) & (highest > 5 * np.median(lower.y_sd)))
    hop = after[: landed[0]] if landed.size else after
    return [_rest(lower, before, flight), _side(lower, hop, (P.LOWER_HEIGHT, P.LOWER_REBOUND), flight)]


def _rest(lower: Track, before: IndexArray, flight: Flight) -> Side:
    """Height at which the lower ball rests, as one observation.

    However many frames show it, it is no better known than a rim that touches the plate and its own mirror
    image can be: its error is common to all of them.
    """
    height = np.median(lower.y[before], keepdims=True)
    return Side(
        time=lower.time[before[-1:]],
        height=height,
        sd=np.full_like(height, REST_SHARE_SD * lower.radius),
        start=P.LOWER_HEIGHT,
        velocity=None,
        flight=flight,
    )


def _side(track: Track, index: IndexArray, rule: tuple[P, P | None], flight: Flight) -> Side:
    """Take some frames of a track."""
    start, velocity = rule
    return Side(
        time=track.time[index],
        height=track.y[index],
        sd=track.y_sd[index],
        start=start,
        velocity=velocity,
        flight=flight,
    )


def _measure(
    track: Track, bounce: Bounce, sides: list[Side], *, touching: float | None = None
) -> Impact | None:
    """Fit one impact: first robustly, then without frames off the flights, then with free gravity."""
    if _too_few(sides):
        return None
    free = SINGLE if touching is None else DOUBLE
    meeting = Meeting(sides=tuple(sides), gap=touching, gap_sd=GAP_SHARE_SD * (touching or np.inf))
    start = _first_guess(track, bounce, sides)
    robust = fit_meeting(meeting, start, free, robust=True)
    meeting = without_outliers(meeting, robust.parameters)
    if _too_few(meeting.sides):
        return None
    fit = fit_meeting(meeting, robust.parameters, free)
    falling = fit_meeting(meeting, fit.parameters, [*free, P.GRAVITY])
    chosen = [P.APPROACH, P.REBOUND, P.LOWER_REBOUND]
    velocities = fit.parameters[chosen]
    return Impact(
        time=float(fit.parameters[P.TIME]),
        height=float(fit.parameters[P.HEIGHT]),
        velocities=velocities if touching is not None else np.append(velocities[:2], np.nan),
        covariance=fit.covariance[np.ix_(chosen, chosen)],
        gravity_check=float(falling.parameters[P.GRAVITY]),
        gravity_check_sd=float(np.sqrt(falling.covariance[P.GRAVITY, P.GRAVITY])),
        sideways=np.array([slope(track.time[i], track.x[i]) for i in (bounce.before, bounce.after)]),
        frames=(len(meeting.sides[0].time), len(meeting.sides[1].time)),
        residual=fit.residual,
    )


def _too_few(sides: Sequence[Side]) -> bool:
    """Tell whether a flight has too few frames to be fitted; one look at a ball at rest is enough."""
    return any(len(side.time) < (1 if side.velocity is None else FEWEST_FRAMES - 1) for side in sides)


def _first_guess(track: Track, bounce: Bounce, sides: list[Side]) -> FloatArray:
    """Start from the crossing of the paths and straight lines through the frames nearest to it."""
    guess = np.zeros(len(P))
    guess[P.GRAVITY] = 1.0
    guess[P.TIME] = crossing(track, bounce.before, bounce.after)
    fall, rise = bounce.before[-4:], bounce.after[:4]
    guess[P.APPROACH] = slope(track.time[fall], track.y[fall])
    guess[P.REBOUND] = slope(track.time[rise], track.y[rise])
    guess[P.HEIGHT] = track.y[fall[-1]] + guess[P.APPROACH] * (guess[P.TIME] - track.time[fall[-1]])
    if len(sides) > 2:
        rest, hop = sides[2:]
        guess[P.LOWER_HEIGHT] = np.median(rest.height)
        guess[P.LOWER_REBOUND] = slope(hop.time[:4], hop.height[:4])
    return guess


def slope(time: FloatArray, value: FloatArray) -> float:
    """Slope of the straight line through points; 0 for fewer than two."""
    if len(time) < 2:
        return 0.0
    since = time - time.mean()
    return float(since @ value / (since @ since))

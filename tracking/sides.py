"""Track → the flights before and after one impact, as frames to be fitted, and where the fit may start."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from tracking.bounce import WINDOW, Bounce, crossing
from tracking.flight import Flight
from tracking.joint import P, Side
from tracking.track import Track

FloatArray = npt.NDArray[np.float64]
IndexArray = npt.NDArray[np.int64]

LANDED = 0.3  # a hop has ended when the ball is down to this share of its greatest height
REST_FRAMES = 60
REST_SHARE_SD = 0.01  # how well a ball's height is known where it touches the plate, as a share of its radius


def upper_sides(track: Track, bounce: Bounce, flight: Flight) -> tuple[Side, Side]:
    """Flights of the falling ball before and after the impact."""
    return (
        _side(track, bounce.before, (P.HEIGHT, P.APPROACH), flight),
        _side(track, bounce.after, (P.HEIGHT, P.REBOUND), flight),
    )


def lower_sides(lower: Track, impact: float, flight: Flight) -> tuple[Side, Side]:
    """Rest of the lower ball before the impact, and its hop until shortly before it lands."""
    interval = float(np.median(np.diff(lower.time)))
    before = np.flatnonzero(lower.time < impact - interval / 2)[-REST_FRAMES:]
    after = np.flatnonzero((lower.time > impact + interval / 2) & (lower.time < impact + WINDOW))
    lift = lower.y[after] - np.median(lower.y[before])
    highest = np.maximum.accumulate(lift)
    landed = np.flatnonzero((lift < LANDED * highest) & (highest > 5 * np.median(lower.y_sd)))
    hop = after[: landed[0]] if landed.size else after
    return _rest(lower, before, flight), _side(lower, hop, (P.LOWER_HEIGHT, P.LOWER_REBOUND), flight)


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
        shared_sd=track.shared_sd,
        alike=track.radius,
    )


def first_guess(track: Track, bounce: Bounce, sides: Sequence[Side]) -> FloatArray:
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

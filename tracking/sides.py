"""Track → the flights before and after one impact, as frames to be fitted, and where the fit may start."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from tracking.bounce import FEWEST_FRAMES, FEWEST_WINDOW_FRAMES, WINDOW, Bounce, crossing
from tracking.flight import Flight
from tracking.joint import P, Side
from tracking.track import Track

FloatArray = npt.NDArray[np.float64]
IndexArray = npt.NDArray[np.int64]

LOW = 0.2  # a hop lower than this share of the radius is low
REST_FRAMES = 60
REST_SHARE_SD = 0.01  # how well a ball's height is known where it touches the plate, as a share of its radius


def upper_sides(track: Track, bounce: Bounce, flight: Flight) -> tuple[Side, Side]:
    """Flights of the falling ball before and after the impact."""
    return (
        _side(track, bounce.before, (P.HEIGHT, P.APPROACH), flight),
        _side(track, bounce.after, (P.HEIGHT, P.REBOUND), flight),
    )


def before_and_after(lower: Track, impact: float) -> tuple[IndexArray, IndexArray]:
    """Frames in which the lower ball rests, and those after an impact at some time, s."""
    interval = float(np.median(np.diff(lower.time)))
    before = np.flatnonzero(lower.time < impact - interval / 2)[-REST_FRAMES:]
    window = max(WINDOW, FEWEST_WINDOW_FRAMES * interval)
    return before, np.flatnonzero((lower.time > impact + interval / 2) & (lower.time < impact + window))


def lower_sides(lower: Track, impact: float, flight: Flight) -> tuple[Side, Side]:
    """Rest of the lower ball before the impact, and its hop until it lands.

    It lands as long after its highest point as it started before: later hops are lower, so the highest frame
    tells when. The upper ball, which leaves the impact faster, cannot meet it earlier.
    """
    interval = float(np.median(np.diff(lower.time)))
    before, after = before_and_after(lower, impact)
    lift = lower.y[after] - np.median(lower.y[before])
    landing = impact + 2 * np.sqrt(2 * max(lift.max(initial=0.0), 0.0) / flight.gravity)
    hop = after[lower.time[after] < landing - interval / 2]
    return _rest(lower, before, flight), _side(lower, hop, (P.LOWER_HEIGHT, P.LOWER_REBOUND), flight)


def is_low(rest: Side, hop: Side) -> bool:
    """Tell whether a hop is too low or too short to be fitted like a fall."""
    highest = hop.height.max(initial=-np.inf) - rest.height.max(initial=-np.inf)
    return len(hop.time) < FEWEST_FRAMES or bool(highest < LOW * hop.alike)


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
    for rest in sides[2:3]:
        guess[P.LOWER_HEIGHT] = np.median(rest.height)
    for hop in sides[3:]:
        guess[P.LOWER_REBOUND] = slope(hop.time[:4], hop.height[:4])
    return guess


def slope(time: FloatArray, value: FloatArray) -> float:
    """Slope of the straight line through points; 0 for fewer than two."""
    if len(time) < 2:
        return 0.0
    since = time - time.mean()
    return float(since @ value / (since @ since))

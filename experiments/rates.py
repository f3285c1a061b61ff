"""At which rate a recording was captured, if its ball does not fall as balls do."""

from dataclasses import replace

from tracking.flight import Flight
from tracking.track import Track
from tracking.velocity import measure_impacts

USUAL_RATES = (24, 25, 30, 50, 60, 90, 100, 120, 180, 240, 300, 480, 600, 960, 1000)  # frames/s
AS_STORED = 0.1  # a usual rate this close to the one believed is no news
RIGHT = 0.08  # of gravity: neighbours among the usual rates differ by 20 % in it


def likely_rate(ball: Track, flight: Flight, believed: float) -> int | None:
    """Find the usual rate with which the ball falls as it must; None if there is none.

    Parameters
    ----------
    ball : Track
        The falling ball, m.
    flight : Flight
        How it falls.
    believed : float
        Rate on which the times of the track rest, frames/s.
    """
    misfits = {}
    for rate in USUAL_RATES:
        if abs(rate / believed - 1) > AS_STORED:
            impacts = measure_impacts(replace(ball, time=ball.time * believed / rate), flight)
            misfits[rate] = abs(impacts[0].gravity_check - 1) if impacts else float("inf")
    best = min(misfits, key=lambda rate: misfits[rate])
    return best if misfits[best] < RIGHT else None

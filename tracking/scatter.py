"""How much places scatter about a smooth path: what no single picture tells of its own error."""

import numpy as np
import numpy.typing as npt
from scipy.stats import chi2

FloatArray = npt.NDArray[np.float64]

WINDOWS = ((48, 5), (24, 3), (12, 3), (8, 3))
"""Frames, the longest that a path has room for, and the degree of the polynomial through them: flight through
air is none more crooked, and errors of compression last for several frames."""
FEWEST = 6  # windows
MOVING_PX = 0.5  # a frame: what rests is compressed to the same picture again, and seems to err less
SHARE = 0.35  # of the windows are sure to span no strike and no kink


def path_scatter(frame: npt.NDArray[np.int64], places: FloatArray) -> FloatArray:
    """Give the standard deviation of places about a path that bends evenly between impacts.

    Errors of compression last for frames, or swing: what neighbours differ by tells less of them than how far
    places lie off a smooth curve through many.

    Parameters
    ----------
    frame : (n,) array
        Numbers of the frames; only those that follow each other are compared.
    places : (n, 2) array
        Where a ball is, px.

    Returns
    -------
    (2,) array
        Of both coordinates, px; 0 where too few frames show the ball on its way.

    Examples
    --------
    >>> noise = np.random.default_rng(1).normal(0, 0.1, (400, 2))
    >>> frame = np.arange(400)
    >>> path_scatter(frame, 0.01 * (frame[:, None] - 200.0) ** 2 + noise).round(1)
    array([0.1, 0.1])
    """
    for length, degree in WINDOWS:
        clear = _in_flight(frame, places, length)
        if clear.sum() >= FEWEST:
            windows = np.lib.stride_tricks.sliding_window_view(places, length, axis=0)[clear]
            return _scatter(windows, degree)
    return np.zeros(2)


def _in_flight(frame: npt.NDArray[np.int64], places: FloatArray, length: int) -> npt.NDArray[np.bool_]:
    """Tell of each window of so many frames whether the ball moves in it all the time and does not bounce."""
    if len(frame) < length:
        return np.zeros(0, dtype=bool)
    moving = np.hypot(*np.diff(places, axis=0).T) > MOVING_PX
    rising = np.diff(places[:, 1]) < 0
    lowest = rising[1:] & ~rising[:-1]  # shortly before or after a bounce
    bounced = np.append(lowest, False) | np.append(False, lowest)
    spoiled = np.append(0, np.cumsum(~moving | bounced))
    return np.asarray(
        (frame[length - 1 :] - frame[: 1 - length] == length - 1)
        & (spoiled[length - 1 :] == spoiled[: len(spoiled) - length + 1])
    )


def _scatter(windows: FloatArray, degree: int) -> FloatArray:
    """Give the standard deviation about a polynomial through each window, (n, 2, frames)."""
    length = windows.shape[-1]
    free = length - degree - 1
    smooth, _ = np.linalg.qr(np.vander(np.linspace(-1, 1, length), degree + 1))
    rest = windows - windows @ smooth @ smooth.T
    variance = np.quantile(np.sum(rest**2, axis=-1) / free, SHARE, axis=0)
    return np.asarray(np.sqrt(variance * free / chi2.ppf(SHARE, free)))

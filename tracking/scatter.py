"""How much places scatter about a smooth path: what no single picture tells of its own error."""

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]

DEGREE = 3  # of the difference: free flight has none but by drag
FEWEST = 6
MOVING_PX = (
    0.5  # a frame: what rests is compressed to the same picture again and again, and seems to err less
)
SHARE = 0.35  # of the differences are sure to span no impact, however slow the camera
QUANTILE = 0.4538  # standard deviations: so much of a normal distribution's values are within


def path_scatter(frame: npt.NDArray[np.int64], places: FloatArray) -> FloatArray:
    """Give the standard deviation of places about a path that bends evenly between impacts.

    Neighbouring errors count as independent; what they have in common, the path seems to have.

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
    way = np.hypot(*(places[DEGREE:] - places[:-DEGREE]).T)
    compared = (frame[DEGREE:] - frame[:-DEGREE] == DEGREE) & (way > DEGREE * MOVING_PX)
    if compared.sum() < FEWEST:
        return np.zeros(2)
    of_one = np.sqrt(np.sum(np.square(np.poly(np.ones(DEGREE)))))
    apart = np.abs(np.diff(places, DEGREE, axis=0)[compared])
    return np.asarray(np.quantile(apart, SHARE, axis=0) / QUANTILE / of_one)

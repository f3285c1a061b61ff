"""How much places scatter about a smooth path: what no single picture tells of its own error."""

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]

DEGREE = 3  # of the difference: free flight has none but by drag
FEWEST = 6
SHARE = 0.35  # of the differences are sure to span no impact, however slow the camera
QUANTILE = 0.4538  # standard deviations: so much of a normal distribution's values are within


def path_scatter(frame: npt.NDArray[np.int64], place: FloatArray) -> float:
    """Give the standard deviation of places about a path that bends evenly between impacts.

    Neighbouring errors count as independent; what they have in common, the path seems to have.

    Parameters
    ----------
    frame : (n,) array
        Numbers of the frames; only those that follow each other are compared.
    place : (n,) array
        One coordinate.

    Returns
    -------
    float
        In the unit of the places; 0 where too few frames follow each other.

    Examples
    --------
    >>> noise = np.random.default_rng(1).normal(0, 0.1, 400)
    >>> frame = np.arange(400)
    >>> print(f"{path_scatter(frame, 0.01 * (frame - 200.0) ** 2 + noise):.2f}")
    0.10
    """
    apart = np.diff(place, DEGREE)
    following = frame[DEGREE:] - frame[:-DEGREE] == DEGREE
    if following.sum() < FEWEST:
        return 0.0
    of_one = np.sqrt(np.sum(np.square(np.poly(np.ones(DEGREE)))))
    return float(np.quantile(np.abs(apart[following]), SHARE) / QUANTILE / of_one)

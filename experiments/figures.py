"""The two pictures of a fit, as matplotlib figures to show, change or save.

They show themselves in a notebook after ``%matplotlib inline``; elsewhere `savefig` writes them.
"""

import pandas as pd
from matplotlib.figure import Figure

from calibrate.estimate import Calibration
from experiments import fig5 as velocities
from experiments import profile_plot


def fig5(trials: pd.DataFrame | None = None, calibration: Calibration | None = None) -> Figure:
    """Draw velocities after the impact over approach speed (Fig. 5 of the paper): a panel a mass pair.

    Parameters
    ----------
    trials : pandas.DataFrame, optional
        As `calibrate.read_trials` returns it, with two-ball trials.
    calibration : Calibration, optional
        The fit to these trials. Without both, the paper's own lines are drawn.

    Returns
    -------
    matplotlib.figure.Figure

    Examples
    --------
    >>> fig5().axes[0].get_xlabel()
    'approach speed |v₀| [m/s]'
    """
    return velocities.draw(velocities.compute(trials, calibration))


def profile(calibration: Calibration) -> Figure:
    """Draw chi-square over the stiffness ratio with its confidence sets.

    Parameters
    ----------
    calibration : Calibration
        A fit to a table with two-ball trials.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    ValueError
        If the calibration has no profile because there were no two-ball trials.
    """
    return profile_plot.draw(profile_plot.compute(calibration))

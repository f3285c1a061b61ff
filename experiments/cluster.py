"""A batch on a cluster: joblib hands the trials to the workers of a Dask scheduler instead of threads here.

joblib's own backend is enough: a trial whose worker dies is given to another one, and as each trial runs in
a process of its own there as well, a bad recording cannot take a worker with it.
"""

from collections.abc import Iterator
from contextlib import contextmanager

import joblib

from experiments.experiment import ExperimentError

PATIENCE = 20  # s, for a scheduler to answer and a first worker to come


@contextmanager
def connected(address: str) -> Iterator[None]:
    """Let joblib work on a cluster while this lasts.

    Parameters
    ----------
    address : str
        Of the scheduler, ``tcp://host:port``.

    Raises
    ------
    ExperimentError
        If `distributed` is not installed, no scheduler or no worker answers, or they are lost on the way.
    """
    try:
        from distributed import Client
    except ImportError:
        raise ExperimentError(
            "cluster: needs the package distributed; install it with pip install distributed, here "
            "and on the cluster"
        ) from None
    try:
        client = Client(address, timeout=PATIENCE)
    except (OSError, ValueError) as error:
        raise ExperimentError(
            f"cluster: no scheduler answers at {address} ({error}); start one with dask scheduler, and give "
            "its address as tcp://host:port"
        ) from error
    with client:
        try:
            client.wait_for_workers(1, timeout=PATIENCE)
        except TimeoutError:
            raise ExperimentError(
                f"cluster: the scheduler at {address} has no worker; start some with dask worker {address}"
            ) from None
        try:
            with joblib.parallel_config(backend="dask"):
                yield
        except Exception as error:  # a trial raises none: whatever comes here is the cluster's
            reason = str(error).partition("\n")[0] or type(error).__name__
            raise ExperimentError(
                f"cluster: {address} is lost ({reason}); what is finished is kept, go on with --resume"
            ) from error

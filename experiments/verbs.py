"""What all verbs of the command share: how they refuse, and their exit codes."""

import functools
from collections.abc import Callable
from typing import ParamSpec

import typer

Parameters = ParamSpec("Parameters")

SOME_FAILED, WRONG_USE = 1, 2


def verb(function: Callable[Parameters, None]) -> Callable[Parameters, None]:
    """Turn what a user can put right into one sentence on stderr and exit code 2."""

    @functools.wraps(function)
    def guarded(*args: Parameters.args, **kwargs: Parameters.kwargs) -> None:
        try:
            function(*args, **kwargs)
        except typer.Exit:
            raise
        except OSError as error:
            fail(f"{error.filename}: {error.strerror}" if error.filename else str(error))
        except (ValueError, RuntimeError) as error:
            fail(str(error))

    return guarded


def fail(sentence: str) -> None:
    """Say what is wrong and end with the exit code for wrong use."""
    typer.echo(f"impactlab: {sentence}", err=True)
    raise typer.Exit(WRONG_USE)

"""What all verbs of the command share: how they refuse, and their exit codes."""

import functools
from collections.abc import Callable
from typing import ParamSpec

import typer

Parameters = ParamSpec("Parameters")

SOME_FAILED, WRONG_USE, INTERRUPTED = 1, 2, 130


def verb(function: Callable[Parameters, None]) -> Callable[Parameters, None]:
    """Turn what a user can put right into one sentence on stderr and exit code 2."""

    @functools.wraps(function)
    def guarded(*args: Parameters.args, **kwargs: Parameters.kwargs) -> None:
        try:
            function(*args, **kwargs)
        except typer.Exit:
            raise
        except KeyboardInterrupt:
            fail("stopped", INTERRUPTED)
        except OSError as error:
            fail(f"{error.filename}: {error.strerror}" if error.filename else str(error))
        except (ValueError, RuntimeError) as error:
            fail(str(error))

    return guarded


def fail(sentence: str, code: int = WRONG_USE) -> None:
    """Say what is wrong and end."""
    typer.echo(f"impactlab: {sentence}", err=True)
    raise typer.Exit(code)

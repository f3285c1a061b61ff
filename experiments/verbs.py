"""What all verbs of the command share: how they refuse, and their exit codes."""

import functools
import os
from collections.abc import Callable
from pathlib import Path
from typing import ParamSpec

import typer

Parameters = ParamSpec("Parameters")

ENGINE, TRACKING = (Path(__file__).resolve().parents[1] / room for room in ("impact", "tracking"))
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


def announce_compilation(room: Path = ENGINE, what: str = "the model") -> None:
    """Say why the first run after installation takes long, before it does: nothing moves meanwhile."""
    kept_elsewhere = "NUMBA_CACHE_DIR" in os.environ or not os.access(room, os.W_OK)
    if not kept_elsewhere and next((room / "__pycache__").glob("*.nbi"), None) is None:
        typer.echo(f"impactlab: {what} is being compiled, once: half a minute or more", err=True)


def fail(sentence: str, code: int = WRONG_USE) -> None:
    """Say what is wrong and end."""
    typer.echo(f"impactlab: {sentence}", err=True)
    raise typer.Exit(code)

"""Work in a process of its own: what crashes, hangs or grows there costs that one piece of work only.

A helper is this file run as a program. It keeps what it has imported, so it is kept for the next piece of
work; it ends when it is told to, when its parent is gone, or after some time without work.
"""

import contextlib
import importlib
import os
import pickle
import queue
import signal
import subprocess
import sys
import threading
from dataclasses import dataclass
from typing import Any, BinaryIO, TypeAlias

from experiments.trial import require_positive

IDLE_SECONDS = 60.0
USUAL_TIMEOUT = 600.0  # s: a recording cut to its fall takes seconds
LEAST_MEMORY = 0.5  # GB: what is imported needs most of that
FAIR_MEMORY = 2.0  # GB that every recording may take by default, however many are measured side by side
GIGABYTE = 2**30
ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
BROKEN = (OSError, EOFError, ValueError, pickle.UnpicklingError)  # what comes of a pipe to nobody

Helper: TypeAlias = "subprocess.Popen[bytes]"
Task: TypeAlias = tuple[str, tuple[Any, ...] | None, float | None]
"""Name of a function, its arguments (None: only load it), and the memory it may take, GB."""
Answer: TypeAlias = tuple[Any, str]
"""Its result, and what went wrong, one of them empty."""

_all: set[Helper] = set()
_idle: list[Helper] = []


class LostError(RuntimeError):
    """A piece of work gave no result; the message says why, and the remedy."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Limits:
    """What one piece of work may take: seconds, and GB of memory; None: as much as it likes.

    Examples
    --------
    >>> Limits(timeout=0)
    Traceback (most recent call last):
    ValueError: timeout must be positive, got 0
    """

    timeout: float | None = USUAL_TIMEOUT
    memory: float | None = None

    def __post_init__(self) -> None:
        for name in ("timeout", "memory"):
            if getattr(self, name) is not None:
                require_positive(name, getattr(self, name))
        if self.memory is not None and self.memory < LEAST_MEMORY:
            raise ValueError(f"memory must be at least {LEAST_MEMORY:g} GB, got {self.memory:g}")
        if self.memory is not None and not sys.platform.startswith("linux"):
            raise ValueError("memory can be limited on Linux only; leave --memory out")


def fair_memory(workers: int) -> float | None:
    """Share this machine's memory among workers, GB; None where memory cannot be limited."""
    if not sys.platform.startswith("linux"):
        return None
    whole = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / GIGABYTE
    return max(FAIR_MEMORY, whole / workers)


def apart(name: str, *arguments: Any, limits: Limits) -> Any:
    """Call a function in a helper and give its result.

    Parameters
    ----------
    name : str
        Of the function, as in ``"math:sqrt"``: this process need not import it.
    arguments
        Passed on by pickle, like the result.
    limits : Limits
        Counted from the moment a helper is ready.

    Raises
    ------
    LostError
        If it took too long, its process ended, or it raised an exception.

    Examples
    --------
    >>> apart("math:sqrt", 4.0, limits=Limits(timeout=60))
    2.0
    >>> end_helpers(busy=False)
    """
    helper = _taken(name)
    overdue = threading.Event()
    patience = threading.Timer(limits.timeout or 0.0, _kill, (helper, overdue))
    if limits.timeout is not None:
        patience.start()
    try:
        result, complaint = _asked(helper, (name, arguments, limits.memory))
    except BROKEN:
        raise LostError(_why_lost(_ended(helper), limits.timeout if overdue.is_set() else None)) from None
    finally:
        patience.cancel()
    _idle.append(helper)
    if complaint:
        raise LostError(complaint)
    return result


def end_helpers(*, busy: bool) -> None:
    """End the helpers that have nothing to do; the busy ones as well if asked to."""
    for helper in list(_all) if busy else list(_idle):
        helper.kill()
        _ended(helper)


def _taken(name: str) -> Helper:
    """Take an idle helper, or start one, and have it load what is to be called."""
    while _idle:
        with contextlib.suppress(IndexError, *BROKEN):  # another thread was quicker, or it has just ended
            helper = _idle.pop()
            _asked(helper, (name, None, None))
            return helper
    helper = _started()
    try:
        _, complaint = _asked(helper, (name, None, None))
    except BROKEN:
        complaint = "the process that should do the work ended when it was started; please report it"
    if complaint:
        helper.kill()
        _ended(helper)
        raise LostError(complaint)
    return helper


def _started() -> Helper:
    """Start a helper that finds the same packages, and counts on one core: so all give the same digits."""
    paths = os.pathsep.join(path for path in sys.path if path)
    helper = subprocess.Popen(
        [sys.executable, "-P", "-m", "experiments.apart"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env={**os.environ, **dict.fromkeys(ONE_THREAD, "1"), "PYTHONPATH": paths},
    )
    _all.add(helper)
    return helper


def _asked(helper: Helper, task: Task) -> Answer:
    """Give a helper a task and wait for its answer."""
    _send(helper.stdin, task)
    answer: Answer = pickle.load(helper.stdout)  # type: ignore[arg-type]
    return answer


def _kill(helper: Helper, overdue: threading.Event) -> None:
    """End a helper that is out of time."""
    overdue.set()
    helper.kill()


def _ended(helper: Helper) -> int:
    """Give the exit code of a helper that ends, and let go of its pipes."""
    code = helper.wait()
    for pipe in (helper.stdin, helper.stdout):
        with contextlib.suppress(OSError):
            pipe.close()  # type: ignore[union-attr]
    _all.discard(helper)
    with contextlib.suppress(ValueError):
        _idle.remove(helper)
    return code


def _why_lost(code: int, timeout: float | None) -> str:
    """Say why there is no result, and what to do about it; `timeout` if that is why."""
    if timeout is not None:
        return f"it took longer than {timeout:g} s; cut it to what matters, or allow more with --timeout"
    if code == -9:
        return "its process was killed, most likely because memory ran out; use fewer --workers"
    name = signal.Signals(-code).name if code < 0 else f"exit code {code}"
    return f"its process ended by itself ({name}); the file may be damaged, copy it again or report it"


def _send(pipe: Any, message: Task | Answer) -> None:
    pickle.dump(message, pipe)
    pipe.flush()


def _serve() -> None:
    """Do what comes in on standard input until nothing comes any more."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent decides what an interruption ends
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # whatever prints must not print into the answers
    tasks: queue.SimpleQueue[Task] = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(sys.stdin.buffer, tasks), daemon=True).start()
    with contextlib.suppress(queue.Empty):
        while True:
            _send(answers, _answer(*tasks.get(timeout=IDLE_SECONDS)))
    os._exit(0)  # the thread that listens still waits: no orderly end can wait for it


def _listen(pipe: BinaryIO, tasks: "queue.SimpleQueue[Task]") -> None:
    """Queue what comes in; a parent that is gone wants no answer any more."""
    while True:
        try:
            tasks.put(pickle.load(pipe))
        except Exception:  # EOFError mostly; nobody is left to tell of another one
            os._exit(0)


def _answer(name: str, arguments: tuple[Any, ...] | None, memory: float | None) -> Answer:
    """Do a task."""
    try:
        module, _, function = name.partition(":")
        call = getattr(importlib.import_module(module), function)
        if arguments is None:
            return None, ""
        _allow(memory)
        return call(*arguments), ""
    except MemoryError:
        allowed = "there is" if memory is None else f"the {memory:g} GB allowed with --memory"
        return None, f"it needs more memory than {allowed}; film fewer pixels, or cut it to what matters"
    except Exception as error:
        return None, f"unexpected {type(error).__name__}: {error}; please report it"
    finally:
        _allow(None)


def _allow(memory: float | None) -> None:
    """Limit what this process may allocate, in GB; None: as much as it likes."""
    if sys.platform.startswith("linux"):
        import resource

        _, most = resource.getrlimit(resource.RLIMIT_DATA)
        allowed = most if memory is None else int(memory * GIGABYTE)
        resource.setrlimit(resource.RLIMIT_DATA, (allowed, most))


if __name__ == "__main__":
    _serve()

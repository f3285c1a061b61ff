"""How tracking is compiled: the only file in it that knows numba.

OpenCV and numpy do one small thing to a whole array at a time. Around a ball fifty pixels wide each such call
costs more than its work, and Python's lock is held in between. The inner loops are therefore compiled, each
doing all there is to do in one picture.
"""

from collections.abc import Callable
from typing import Any, TypeVar

import numba

Function = TypeVar("Function", bound=Callable[..., Any])

njit: Any = numba.njit  # its stubs do not know what may be passed on
OPTIONS = {
    "cache": True,
    "error_model": "numpy",
    "nogil": True,
    "fastmath": {"contract", "nsz"},  # sums in another order would change with what is compiled together
}
compiled: Callable[[Function], Function] = njit(**OPTIONS)
"""Compile a function to machine code on first call, keep the code on disk, and let other threads run.

What is kept is renewed when the function's own file changes, so what it calls is in the same file, or in
`median` or `single`, which have no reason to change.
"""
part: Callable[[Function], Function] = njit(no_cpython_wrapper=True, no_cfunc_wrapper=True, **OPTIONS)
"""The same for a function that only compiled ones call: without wrappers for Python it compiles sooner."""
inlined: Callable[[Function], Function] = njit(
    forceinline=True, no_cpython_wrapper=True, no_cfunc_wrapper=True, **OPTIONS
)
"""The same for a small function that is called so often that the call itself would cost most."""

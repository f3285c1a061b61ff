"""How tracking is compiled: the only file in it that knows numba.

OpenCV and numpy do one small thing to a whole array at a time. Around a ball fifty pixels wide each such call
costs more than its work, and Python's lock is held in between. The inner loops are therefore compiled, each
doing all there is to do in one picture: they are in `coarse`, `patch`, `path`, `rim_kernel`, `limb_kernel`.
"""

from collections.abc import Callable
from typing import Any, TypeVar

import numba
import numpy as np
import numpy.typing as npt

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

What is kept is renewed when the function's own file changes, so what it calls is in the same file.
"""
part: Callable[[Function], Function] = njit(no_cpython_wrapper=True, no_cfunc_wrapper=True, **OPTIONS)
"""The same for a function that only compiled ones call: without wrappers for Python it compiles sooner."""
inlined: Callable[[Function], Function] = njit(
    forceinline=True, no_cpython_wrapper=True, no_cfunc_wrapper=True, **OPTIONS
)
"""The same for a small function that is called so often that the call itself would cost most."""


@part
def upper_median(values: npt.NDArray[np.float64]) -> float:
    """Select the middle value, the upper one of an even number; the values change their order."""
    low, high, wanted = 0, len(values) - 1, len(values) // 2
    while low < high:
        pivot, i, j = values[(low + high) // 2], low, high
        while i <= j:
            while values[i] < pivot:
                i += 1
            while values[j] > pivot:
                j -= 1
            if i <= j:
                values[i], values[j] = values[j], values[i]
                i, j = i + 1, j - 1
        if wanted > j and wanted < i:
            break
        low, high = (low, j) if wanted <= j else (i, high)
    return float(values[wanted])

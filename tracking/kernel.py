"""How tracking is compiled: the only file in it that knows numba.

OpenCV and numpy do one small thing to a whole array at a time. Around a ball fifty pixels wide each such call
costs more than its work, and Python's lock is held in between. The inner loops are therefore compiled, each
doing all there is to do in one picture.
"""

from collections.abc import Callable
from typing import Any, TypeVar

import numba
from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import intrinsic

Function = TypeVar("Function", bound=Callable[..., Any])

njit: Any = numba.njit  # its stubs do not know what may be passed on
insert: Any = cgutils.get_or_insert_function  # has none
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


def _fetching(_context: Any, array: Any, index: Any) -> Any:
    """Type and code of `fetch`."""

    def instruct(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        items = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        byte, number = ir.IntType(8).as_pointer(), ir.IntType(32)
        form = ir.FunctionType(ir.VoidType(), [byte, number, number, number])
        order = insert(builder.module, form, "llvm.prefetch.p0i8")
        to_read, often, data = number(0), number(3), number(1)
        place = builder.bitcast(builder.gep(items, [arguments[1]]), byte)
        builder.call(order, [place, to_read, often, data])
        return context.get_dummy_value()

    return types.void(array, types.intp), instruct


fetch: Any = intrinsic(_fetching)
"""Within a compiled function, ask for an item of a one-dimensional array: memory is slow to answer."""

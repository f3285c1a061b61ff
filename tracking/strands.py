"""Compiled work on many pictures, as many of them at a time as there are processors."""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

LEAST = 24  # pictures a strand, or starting it costs more than it saves


def side_by_side(work: Callable[[int], None], count: int) -> None:
    """Do some work for each number below a count, in several strands if they are many.

    It pays where nearly all the work is compiled and long (50 µs and more): Python itself runs in one strand
    at a time, and the others wait for it.

    Examples
    --------
    >>> squares = [0] * 100
    >>> side_by_side(lambda k: squares.__setitem__(k, k * k), 100)
    >>> squares[99]
    9801
    """
    strands = max(1, min(os.cpu_count() or 1, count // LEAST))

    def strand(first: int) -> None:
        for k in range(first, count, strands):
            work(k)

    if strands == 1:
        return strand(0)
    with ThreadPoolExecutor(strands) as pool:
        list(pool.map(strand, range(strands)))

"""Compiled work on many pictures, as many of them at a time as there are processors."""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

LEAST = 24  # pictures a strand, or starting it costs more than it saves


def side_by_side(work: Callable[[tuple[int, int]], None], count: int) -> None:
    """Do some work of `count` parts, in several strands if they are many.

    `work` gets the number of its first part and by how much to go on to the next. It must be compiled as a
    whole: Python itself runs in one strand at a time, and the others would wait for it.

    Examples
    --------
    >>> squares = [0] * 100
    >>> def work(part_of):
    ...     for k in range(part_of[0], 100, part_of[1]):
    ...         squares[k] = k * k
    >>> side_by_side(work, 100)
    >>> squares[99]
    9801
    """
    strands = max(1, min(os.cpu_count() or 1, count // LEAST))
    if strands == 1:
        return work((0, 1))
    with ThreadPoolExecutor(strands - 1) as pool:
        others = [pool.submit(work, (first, strands)) for first in range(1, strands)]
        work((0, strands))
        for other in others:
            other.result()

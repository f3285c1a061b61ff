"""Which stored frames are pictures of their own, and when those were taken.

Screen recorders and converters store pictures twice. If they do so in a steady rhythm (24, 25 or 20 pictures
stored as 30 or 60), the pictures were taken evenly, though their time stamps are not even.
"""

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

REPEAT_LEVEL = 4.0  # grey levels: two encodings of one picture differ by less
REPEAT_SHARE = 0.2  # ... and by less than this share of what a genuine neighbour differs by
MOVING_LEVEL = 6.0  # grey levels: where nothing changes by more, nobody can tell
REPEATS_TO_BELIEVE = 0.1  # at the top of a bounce two pictures may look alike by chance
LONGEST_RHYTHM = 12  # frames
STEADY = 0.85  # of the frames that can be told are repeats, or none, at one place of a rhythm
FEWEST_BEATS = 3
EVEN = 0.2  # intervals that differ by less are even


def find_genuine(changes: FloatArray) -> tuple[BoolArray, int | None]:
    """Tell pictures from repeats: a repeat changes nothing while its neighbours change a lot.

    Parameters
    ----------
    changes : (n,) array
        How much each stored frame differs from the one before it, grey levels; the first is infinite.

    Returns
    -------
    (n,) array of bool, int or None
        False where a frame stores its predecessor's picture again; after how many frames the rhythm of
        repeats begins anew, None if they follow none.
    """
    padded = np.pad(np.where(np.isfinite(changes), changes, 0.0), 3)
    around = np.lib.stride_tricks.sliding_window_view(padded, 7).max(axis=1)
    moving = around > MOVING_LEVEL
    repeats = (changes < REPEAT_LEVEL) & (changes < REPEAT_SHARE * around) & moving
    if repeats.sum() < max(3, REPEATS_TO_BELIEVE * len(changes)):
        return np.ones(len(changes), dtype=bool), None
    for length in range(2, LONGEST_RHYTHM + 1):
        beat = np.arange(len(changes)) % length
        told = np.bincount(beat[moving], minlength=length)
        share = np.bincount(beat[repeats], minlength=length) / np.maximum(told, 1)
        if told.min() >= FEWEST_BEATS and np.all((share > STEADY) | (share < 1 - STEADY)):
            return ~(share > STEADY)[beat], length
    return ~repeats, None


def even_times(times: FloatArray, genuine: BoolArray, rhythm: int | None) -> tuple[FloatArray, list[str]]:
    """Give pictures that were taken evenly even times, and say what was done about repeats.

    Parameters
    ----------
    times : (n,) array
        Time stamps of all stored frames, s.
    genuine, rhythm : as `find_genuine` gives them

    Examples
    --------
    >>> stored = np.arange(13) / 30
    >>> times, _ = even_times(stored, np.arange(13) % 6 != 3, 6)
    >>> np.diff(times[np.arange(13) % 6 != 3]).round(3).tolist()
    [0.04, 0.04, 0.04, 0.04, 0.04, 0.04, 0.04, 0.04, 0.04, 0.04]
    """
    repeats = int((~genuine).sum())
    if not repeats:
        return times, []
    note = f"{repeats} of {len(genuine)} frames store the picture before them again; they were left out"
    numbers, steps = np.flatnonzero(genuine), np.diff(times)
    if np.ptp(np.diff(numbers)) == 0:
        return times, [note]
    usual = float(np.median(steps))
    if rhythm is None or np.ptp(steps) > EVEN * usual:
        late = f"{1e3 * usual:.3g} ms"
        return times, [f"{note}; they come irregularly, so that a picture's time may be wrong by {late}"]
    step = float(np.mean(steps)) * rhythm / int(genuine[:rhythm].sum())
    taken = step * np.arange(len(numbers))
    taken += float(np.mean(times[numbers] - taken))
    even = np.interp(np.arange(len(times)), numbers, taken)
    return even, [f"{note}, and the others spread evenly: {1 / step:.4g} a second"]

"""Rolling shutter: the rows of a picture are read one after the other, so a low ball is seen later."""

from dataclasses import replace

import numpy as np

from tracking.track import Track
from tracking.video import Recording


def with_row_times(track: Track, recording: Recording, readout: float) -> Track:
    """Give each frame of a track the time at which the row of the ball's centre was read.

    Parameters
    ----------
    track : Track
        In pixels.
    recording : Recording
        Where it was tracked; rows of the sensor are columns of a picture that was turned by a quarter.
    readout : float
        Time from the first to the last row of the sensor, s.

    Returns
    -------
    Track
        The same places at times up to `readout` later.
    """
    height, width = recording.size
    down, right = track.y / (height - 1), track.x / (width - 1)
    way = (down, right, 1 - down, 1 - right)
    return replace(track, time=track.time + readout * np.clip(way[recording.quarter_turns], 0.0, 1.0))

"""Pictures to a video file that a browser plays."""

from collections.abc import Iterable
from fractions import Fraction
from pathlib import Path

import av
import cv2
import numpy as np
from numpy.typing import NDArray

THREADS = 2
"""Fixed, so that the same pictures make the same file on every machine."""


def write_video(
    path: Path,
    frames: Iterable[NDArray[np.uint8]],
    fps: float,
    *,
    crf: int = 20,
    preset: str = "veryfast",
    index_first: bool = False,
) -> int:
    """Encode frames as H.264 (yuv420p) with time stamps of exactly ``k / fps``.

    Parameters
    ----------
    path : Path
        File to write; its ending chooses the container, as in ``drop.mp4``.
    frames : iterable of ndarray of uint8, shape (rows, columns, 3)
        Pictures, blue, green, red; rows and columns even.
    fps : float
        Frames per second the file shall claim.
    crf : int
        Constant rate factor of x264: 0 loses nothing, 18 looks lossless, 51 is worst.
    preset : str
        Speed of x264 against size.
    index_first : bool
        Whether an MP4 file begins with its table of contents, so that a browser can play it while it loads.

    Returns
    -------
    int
        Number of frames written.
    """
    rate = Fraction(fps).limit_denominator(1001)
    count = 0
    options = {"movflags": "faststart"} if index_first else {}
    with av.open(str(path), "w", options=options) as container:
        stream = container.add_stream("libx264", rate=rate)
        stream.pix_fmt = "yuv420p"
        stream.thread_count = THREADS
        stream.options = {"crf": str(crf), "preset": preset}
        for count, picture in enumerate(frames, start=1):
            if count == 1:
                stream.height, stream.width = picture.shape[:2]
            yuv = cv2.cvtColor(picture, cv2.COLOR_BGR2YUV_I420)
            frame = av.VideoFrame.from_ndarray(np.asarray(yuv, np.uint8), format="yuv420p")
            frame.pts, frame.time_base = count - 1, 1 / rate
            container.mux(stream.encode(frame))
        container.mux(stream.encode())
    return count

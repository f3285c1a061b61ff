"""Pictures to a video file that a browser plays."""

from collections.abc import Iterable, Sequence
from fractions import Fraction
from pathlib import Path

import av
import cv2
import numpy as np
from numpy.typing import NDArray

THREADS = 2
"""Fixed, so that the same pictures make the same file on every machine."""
NO_TREE = {"x264-params": "mbtree=0"}
"""Without its macroblock tree x264 takes no bits from what moves for what stays, as cameras do not either,
and the same pictures make the same bytes each time."""
CLOCK = 90_000
"""Ticks a second in which telephones stamp frames that come at uneven intervals."""


def write_video(
    path: Path,
    frames: Iterable[NDArray[np.uint8]],
    fps: float,
    *,
    crf: int | None = 20,
    preset: str = "veryfast",
    tree: bool = False,
    index_first: bool = False,
    times: Sequence[float] | NDArray[np.float64] | None = None,
) -> int:
    """Encode frames as H.264 (yuv420p) with time stamps of exactly ``k / fps``, or as told.

    Parameters
    ----------
    path : Path
        File to write; its ending chooses the container, as in ``drop.mp4``.
    frames : iterable of ndarray of uint8, shape (rows, columns, 3)
        Pictures, blue, green, red; rows and columns even.
    fps : float
        Frames per second the file shall claim.
    crf : int or None
        Constant rate factor of x264: 0 loses nothing but colour between pixels, 18 looks lossless, 51 is
        worst. None stores every level of every colour as it is (FFV1).
    preset : str
        Speed of x264 against size.
    tree : bool
        Whether x264 may use its macroblock tree, as programs let it. What moves gets fewer bits then, and the
        bytes are not the same from run to run.
    index_first : bool
        Whether an MP4 file begins with its table of contents, so that a browser can play it while it loads.
    times : sequence of float, optional
        Time stamp of each frame, s, the first 0; kept to 1/180000 s.

    Returns
    -------
    int
        Number of frames written.
    """
    rate = Fraction(fps).limit_denominator(1001)
    clock = 1 / rate if times is None else Fraction(1, CLOCK)
    count = 0
    with av.open(str(path), "w", options={"movflags": "faststart"} if index_first else {}) as container:
        stream = container.add_stream("ffv1" if crf is None else "libx264", rate=rate)
        stream.pix_fmt = "bgr0" if crf is None else "yuv420p"
        stream.thread_count = THREADS
        stream.codec_context.time_base = clock
        if crf is not None:
            stream.options = {"crf": str(crf), "preset": preset, **({} if tree else NO_TREE)}
        for count, picture in enumerate(frames, start=1):
            if count == 1:
                stream.height, stream.width = picture.shape[:2]
            frame = _exact(picture) if crf is None else _compressible(picture)
            frame.pts = count - 1 if times is None else round(times[count - 1] * CLOCK)
            frame.time_base = clock
            container.mux(stream.encode(frame))
        container.mux(stream.encode())
    return count


def _compressible(picture: NDArray[np.uint8]) -> av.VideoFrame:
    """Keep the brightness of each pixel and the mean colour of four.

    OpenCV by itself takes the colour of one of the four, which moves every edge of colour by half a pixel.
    """
    height, width = picture.shape[:2]
    mean = cv2.resize(picture, (width // 2, height // 2), interpolation=cv2.INTER_AREA)
    blocks = cv2.resize(mean, (width, height), interpolation=cv2.INTER_NEAREST)
    yuv, coarse = (np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2YUV_I420)) for image in (picture, blocks))
    yuv[height:] = coarse[height:]
    return av.VideoFrame.from_ndarray(np.asarray(yuv, np.uint8), format="yuv420p")


def _exact(picture: NDArray[np.uint8]) -> av.VideoFrame:
    """Leave all colours as they are."""
    return av.VideoFrame.from_ndarray(picture, format="bgr24").reformat(format="bgr0")

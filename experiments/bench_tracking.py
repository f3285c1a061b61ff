"""How fast recordings are tracked, as a share of the speed at which they can be decoded at all."""

import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from experiments.bench import Measured, fastest
from tracking.decode import decode_only
from tracking.render import Camera, DropScene, write_recording
from tracking.track import track_balls
from tracking.video import open_recording

UPRIGHT = DropScene(kind="plate", drop_height=0.92, hold=0.2, after=1.6)  # a telephone; four bounces
PICTURES = {  # 240 frames a second; the ball is 50 pixels wide in the smaller
    "720p": replace(UPRIGHT, camera=Camera(width_px=720), seed=720),
    "1080p": replace(UPRIGHT, camera=Camera(width_px=1080, metres_per_pixel=0.00053), seed=1080),
}
FILES = {  # strength of x264's compression for each picture, and its preset
    "as a telephone writes it": ({"720p": 13, "1080p": 14}, "veryfast"),  # some 50 Mbit a second
    "made small": ({"720p": 23, "1080p": 23}, "medium"),  # by a program, to be sent: a tenth of that
}
RUNS = 5  # of tracking and decoding in turn: what else the machine does then disturbs both
SHORT, LONG = 0.3, 8.0  # s filmed after the first impact: how much does memory grow?
TRACKED = """
from tracking.track import track_balls
from tracking.video import open_recording
track_balls(open_recording(clip))
"""
DRAWN = """
from experiments.process import process
from experiments.trial import Body, Trial
ball = Body(diameter=0.04)
process(Trial(name="drop", video=clip, kind="plate", bodies={"upper": ball}), {"overlays": True}, clip.parent)
"""
WORKS = {"tracked": TRACKED, "measured and drawn": DRAWN}
MEMORY = """
import resource, sys
from pathlib import Path
clip = Path(sys.argv[1])
{work}
most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
status = Path("/proc/self/status")
if status.exists():  # on Linux `most` includes the process that started this one
    most = next(line.split()[1] for line in status.read_text().splitlines() if line.startswith("VmHWM"))
print(float(most) / 1024)
"""


def throughput() -> Iterator[Measured]:
    """Track clips and decode them, by the same library in the same run."""
    with tempfile.TemporaryDirectory() as folder:
        for file, (strengths, preset) in FILES.items():
            for name, scene in PICTURES.items():
                clip = Path(folder) / f"{name}.mp4"
                shown = write_recording(scene, clip, crf=strengths[name], preset=preset, tree=True)
                seconds = shown["frames"] / scene.camera.fps
                rate = 8e-6 * clip.stat().st_size / seconds
                yield from _ratios(clip, f"{name} H.264 {file} ({rate:.2g} Mbit/s)")


def _ratios(clip: Path, name: str) -> Iterator[Measured]:
    """Track a clip and decode it, in turn."""
    works: list[Callable[[], object]] = [partial(track, clip), partial(decode_only, clip)]
    if shutil.which("ffmpeg"):
        works.append(partial(decode_by_ffmpeg, clip))
    for work in works:
        work()
    tracking, *decoding = np.min([[fastest(work, repeats=1) for work in works] for _ in range(RUNS)], axis=0)
    for what, seconds, least in zip(("decoding", "ffmpeg"), decoding, (0.8, None), strict=False):
        yield Measured(
            quantity=f"tracking over {what}, {name}", value=float(seconds / tracking), unit="", least=least
        )


def memory() -> Iterator[Measured]:
    """Peak memory of tracking a short clip and a long one, and of all that is done with each."""
    with tempfile.TemporaryDirectory() as folder:
        for name, picture, after in (("short", "720p", SHORT), ("long", "1080p", LONG)):
            clip = Path(folder) / f"{name}.mp4"
            write_recording(replace(PICTURES[picture], after=after), clip)
            for done, work in WORKS.items():
                run = subprocess.run(
                    [sys.executable, "-c", MEMORY.format(work=work), str(clip)],
                    cwd=Path(__file__).resolve().parents[1],
                    capture_output=True,
                    text=True,
                    check=True,
                )
                yield Measured(
                    quantity=f"peak memory, {picture}, {name} clip, {done}",
                    value=float(run.stdout),
                    unit="MB",
                    most=500,
                )


def track(clip: Path) -> None:
    """Track the ball in every frame."""
    track_balls(open_recording(clip))


def decode_by_ffmpeg(clip: Path) -> None:
    """Let the ffmpeg program do the same."""
    subprocess.run(["ffmpeg", "-v", "error", "-i", str(clip), "-f", "null", "-"], check=True)

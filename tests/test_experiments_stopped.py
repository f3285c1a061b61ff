"""Runs that are stopped at any moment, or lose a part of their cluster, as a person or a machine does it."""

import json
import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from clips import Clip

pytestmark = pytest.mark.slow


def left_over(out: Path) -> list[Path]:
    return [path for path in out.rglob(".*") if path.is_file()]


def environment() -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}


def started(folder: Path, out: Path, *words: str) -> "subprocess.Popen[bytes]":
    """Run the command on a folder of drops."""
    program = "import sys; from experiments.cli import main; main()"
    command = [
        "process",
        str(folder),
        "--kind",
        "plate",
        "--ball-diameter",
        "0.04",
        "--out",
        str(out),
        *words,
    ]
    return subprocess.Popen(
        [sys.executable, "-c", program, *command, "--workers", "2", "--quiet"],
        env=environment(),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
    )


def finished(folder: Path, out: Path, *words: str) -> int:
    """Run the command to its end, give its exit code."""
    run = started(folder, out, *words)
    run.communicate()
    return run.returncode


@pytest.fixture(scope="module")
def folder(plate_clip: Clip, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Nine recordings, one of them cut short."""
    folder = tmp_path_factory.mktemp("drops")
    content = plate_clip.path.read_bytes()
    for name in "abcdefgh":
        (folder / f"{name}.mp4").write_bytes(content)
    (folder / "cut.mp4").write_bytes(content[:9000])
    return folder


@pytest.fixture(scope="module")
def whole(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """The table of a run that nobody disturbs."""
    out = tmp_path_factory.mktemp("whole")
    assert finished(folder, out) == 1
    return (out / "trials.csv").read_bytes()


def records_in(out: Path) -> list[Path]:
    return list((out / "trials").glob("[!.]*.json"))


@pytest.mark.parametrize("seed", range(3))
def test_a_killed_run_goes_on_to_the_same_table(
    folder: Path, whole: bytes, tmp_path: Path, seed: int
) -> None:
    moments = random.Random(seed)
    for _ in range(2):
        run = started(folder, tmp_path, "--resume")
        time.sleep(moments.uniform(0.5, 12))
        run.kill()
        run.communicate()
    assert all(json.loads(path.read_text())["rows"] for path in records_in(tmp_path))
    if (tmp_path / "trials.csv").exists():
        assert (tmp_path / "trials.csv").read_bytes() == whole
    assert finished(folder, tmp_path, "--resume") == 1
    assert (tmp_path / "trials.csv").read_bytes() == whole
    assert left_over(tmp_path) == []


@pytest.mark.parametrize("ending", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_run_leaves_the_table_of_what_is_finished(
    folder: Path, tmp_path: Path, ending: signal.Signals
) -> None:
    run = started(folder, tmp_path)
    while not records_in(tmp_path):
        time.sleep(0.02)
    time.sleep(0.5)
    run.send_signal(ending)
    _, complaint = run.communicate()
    assert run.returncode == 130
    assert b"stopped; what is finished is kept, go on with --resume" in complaint
    assert (tmp_path / "report.html").exists()
    assert 1 <= len(records_in(tmp_path)) < 9
    rows = len((tmp_path / "trials.csv").read_text().splitlines()) - 1
    assert 0 <= len(records_in(tmp_path)) - rows <= 2  # one a worker may be done in that very moment
    assert rows
    assert left_over(tmp_path) == []


Members = list["subprocess.Popen[bytes]"]


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[tuple[str, Members]]:
    """A Dask scheduler and two workers, each a process of its own."""
    pytest.importorskip("distributed")
    place = tmp_path / "scheduler.json"
    program = [sys.executable, "-m", "distributed.cli.dask_scheduler"]
    quiet: dict[str, Any] = {"env": environment(), "stderr": subprocess.DEVNULL, "cwd": tmp_path}
    told = ["--scheduler-file", str(place), "--host", "127.0.0.1", "--port", "0", "--no-dashboard"]
    members = [subprocess.Popen([*program, *told], **quiet)]
    try:
        while not place.exists():
            time.sleep(0.05)
        address = json.loads(place.read_text())["address"]
        program[-1] = "distributed.cli.dask_worker"
        told = [address, "--no-nanny", "--nthreads", "1", "--no-dashboard"]
        members += [subprocess.Popen([*program, *told], **quiet) for _ in range(2)]
        yield address, members
    finally:
        for member in members:
            member.kill()
            member.wait()


def kill_half_way(run: "subprocess.Popen[bytes]", out: Path, member: "subprocess.Popen[bytes]") -> bytes:
    """Kill a member of the cluster as soon as something is finished; give what the run complains of."""
    while not records_in(out):
        time.sleep(0.02)
    member.kill()
    return run.communicate()[1]


def test_a_cluster_that_loses_a_worker_gives_the_same_table(
    folder: Path, whole: bytes, tmp_path: Path, cluster: tuple[str, Members]
) -> None:
    address, (_, worker, _) = cluster
    run = started(folder, tmp_path / "out", "--cluster", address)
    complaint = kill_half_way(run, tmp_path / "out", worker)
    assert run.returncode == 1, complaint
    assert (tmp_path / "out" / "trials.csv").read_bytes() == whole


def test_a_run_that_loses_its_cluster_says_so_and_goes_on_here(
    folder: Path, whole: bytes, tmp_path: Path, cluster: tuple[str, Members]
) -> None:
    address, (scheduler, *_) = cluster
    run = started(folder, tmp_path / "out", "--cluster", address)
    complaint = kill_half_way(run, tmp_path / "out", scheduler)
    assert run.returncode == 2
    assert b"is lost" in complaint
    assert b"what is finished is kept, go on with --resume" in complaint
    assert finished(folder, tmp_path / "out", "--resume") == 1
    assert (tmp_path / "out" / "trials.csv").read_bytes() == whole

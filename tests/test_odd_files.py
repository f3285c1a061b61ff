"""A thousand damaged films, tables and experiment files: a result or a clear sentence each, never a crash."""

from pathlib import Path
from typing import Any

import pytest
from odd_files import OF_FILMS, OF_TEXT, damaged
from test_tracking_odd_films import encode, fall
from typer.testing import CliRunner

from calibrate.readings import read_readings
from calibrate.rows import TrialTableError
from calibrate.trials import read_trials
from experiments.apart import Limits
from experiments.batch import Batch, process_all
from experiments.cli import app
from experiments.experiment import ExperimentError, read_experiment
from experiments.fitting import hold_readings
from experiments.process import measure
from experiments.trial import KINDS, Body, Camera, Trial
from tracking.encode import write_video

BALL = Body(mass=0.0027, diameter=0.040)
FAULTS = ("unexpected", "ended by itself", "took longer", "was killed", "needs more memory")
MANY, FEW = 1000, 32

TABLES = {
    "plate.csv": b"trial,kind,approach_velocity,upper_rebound_velocity,upper_mass\n"
    b"a,plate,-2.0,1.7,0.0027\nb,plate,-2.5,2.1,0.0027\nc,held,-3.0,2.4,0.0027\nd,plate,-3.1,2.6,\n",
    "german.csv": "Kind;v0 [m/s];v1 [cm/s];Größe\r\nplate;-2,5;210;7\r\nheld;-3,0;240,5;\r\n;;;\r\n".encode(
        "cp1252"
    ),
    "heights.csv": b"ball\th0 [cm]\th1 [mm]\trepeat\nred\t50\t421\t1\nred\t80\t660\t1\nred\t20\t172\t1\n",
    "intervals.csv": b"ball,h0_cm,interval_no,launch,dt_s\nred,8,1,1,0.255\nred,8,2,1,0.243\nred,8,3,1,.23\n",
    "wide.csv": "kind,v0,v1\nplate,-3,2.5\nplate,-2,1.7\n".encode("utf-16"),
    "shots.csv": b"trial,kind,velocity_x,velocity_y,approach_velocity,contact_offset,cue_elevation (deg)\n"
    b"a,shot,1.2,0.1,1.0,0.1,10\nb,shot,1.4,0.0,1.2,0.0,5\n",
}
TOLD = {
    "experiment.toml": b"""name = "drops"
[camera]
capture_fps = 240
readout = 0.004
scale = { points_px = [[215, 40], [215, 640]], distance = 0.30, relative_sd = 0.002 }
[bodies]
upper = { mass = 0.0027, diameter = 0.040 }
lower = { mass = 0.0030 }
[[trial]]
video = "drop.mp4"
kind = "plate"
start_px = [80, 20.5]
[[trial]]
video = "drop.mp4"
kind = "held"
name = "again"
upper = { mass = 0.0054 }
scale = { metres_per_pixel = 0.0008 }
"""
}


@pytest.fixture(scope="module")
def films(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    folder = tmp_path_factory.mktemp("good")
    write_video(folder / "late.mp4", fall(40), 120)
    write_video(folder / "early.mp4", fall(40), 120, index_first=True)
    write_video(folder / "film.mkv", fall(40), 120)
    encode(folder / "old.avi", fall(40), "mpeg4")
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


def trials_of(films: dict[str, bytes], folder: Path, count: int) -> list[Trial]:
    trials = []
    for number, (name, content) in enumerate(damaged(films, OF_FILMS, count, seed=1)):
        (folder / name).write_bytes(content)
        bodies = dict.fromkeys(("upper", "lower", "ball", "striker", "struck"), BALL)
        kind = KINDS[number % len(KINDS)]
        trials.append(Trial(name=name, video=folder / name, kind=kind, bodies=bodies))
    return trials


def assert_sensible(rows: list[dict[str, Any]], trials: list[Trial]) -> None:
    """Each trial has a row; each that failed says why, naming its file, and never by a fault of ours."""
    assert {row["trial"] for row in rows} == {trial.name for trial in trials}
    failed = [row for row in rows if row["status"] == "failed"]
    assert [row for row in failed if row["trial"] not in row["reason"]] == []
    assert [row for row in failed if any(fault in row["reason"] for fault in FAULTS)] == []


def test_damaged_films_give_a_result_or_a_sentence(tmp_path: Path, films: dict[str, bytes]) -> None:
    trials = trials_of(films, tmp_path, 18)
    assert_sensible([row for trial in trials for row in measure(trial).rows], trials)


@pytest.mark.slow
def test_a_thousand_damaged_films_cost_no_process_and_no_patience(
    tmp_path: Path, films: dict[str, bytes]
) -> None:
    trials = trials_of(films, tmp_path, MANY)
    batch = Batch(out=tmp_path / "out", workers=2, overlays=False, limits=Limits(timeout=60))
    assert_sensible([dict(row) for record in process_all(trials, batch) for row in record.rows], trials)


@pytest.mark.parametrize("count", [FEW, pytest.param(MANY, marks=pytest.mark.slow)])
def test_every_damaged_table_is_read_or_refused_with_its_name(tmp_path: Path, count: int) -> None:
    read, refused = [], []
    for name, content in damaged(TABLES, OF_TEXT, count, seed=2):
        path = tmp_path / name
        path.write_bytes(content)
        try:
            read.append(read_readings(path) if hold_readings([path]) else read_trials(path))
        except TrialTableError as error:
            refused.append((name, str(error)))
    assert refused
    assert [sentence for name, sentence in refused if name not in sentence] == []
    assert read  # some damage leaves a file as good as it was


@pytest.mark.parametrize("count", [FEW, pytest.param(MANY // 8, marks=pytest.mark.slow)])
def test_fit_ends_damaged_tables_with_a_result_or_a_sentence(tmp_path: Path, count: int) -> None:
    odd = []
    for name, content in damaged(TABLES, OF_TEXT, count, seed=4):
        (tmp_path / name).write_bytes(content)
        done = CliRunner().invoke(app, ["fit", str(tmp_path / name), "--out", str(tmp_path / "out")])
        said = done.exit_code in (0, 1) or done.stderr.startswith("impactlab: ")
        if not said or not isinstance(done.exception, (SystemExit, type(None))):
            odd.append((name, done.exit_code, done.stderr, repr(done.exception)))
    assert odd == []


@pytest.mark.parametrize("count", [FEW, pytest.param(MANY, marks=pytest.mark.slow)])
def test_every_damaged_experiment_file_is_read_or_refused_with_its_name(
    tmp_path: Path, films: dict[str, bytes], count: int
) -> None:
    (tmp_path / "drop.mp4").write_bytes(films["early.mp4"])
    read: list[Trial] = []
    refused: list[tuple[str, str]] = []
    for name, content in damaged(TOLD, OF_TEXT, count, seed=3):
        (tmp_path / name).write_bytes(content)
        try:
            read += read_experiment(tmp_path / name)
        except ExperimentError as error:
            refused.append((name, str(error)))
    assert refused
    assert [sentence for name, sentence in refused if name not in sentence] == []
    assert read  # some damage leaves a file as good as it was
    assert all(isinstance(trial.camera, Camera) for trial in read)

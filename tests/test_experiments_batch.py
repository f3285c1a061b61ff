"""Many trials: none at the cost of another, none done twice, nothing half-written."""

import json
import os
import signal
import sys
from dataclasses import replace
from pathlib import Path
from shutil import copytree
from typing import Any

import numpy as np
import pytest
from clips import Clip
from hypothesis import given
from hypothesis import strategies as st

from experiments.apart import FAIR_MEMORY, Limits, LostError, apart, end_helpers, fair_memory
from experiments.batch import Batch, in_order, process_all
from experiments.experiment import ExperimentError, collect_trials
from experiments.provenance import code_digest
from experiments.record import Record, finished_record, sweep, told_of, write_record
from experiments.trial import Body, Camera, Trial

BALL = {"upper": Body(mass=0.0027, diameter=0.040)}
FREE = Limits()


def trial_of(video: Path, name: str = "") -> Trial:
    return Trial(name=name or video.stem, video=video, kind="plate", bodies=BALL)


@pytest.fixture(autouse=True, scope="module")
def _no_helper_outlives_these_tests() -> object:
    yield
    end_helpers(busy=True)


def test_work_apart_gives_its_result_and_its_helper_serves_again() -> None:
    first = apart("os:getpid", limits=FREE)
    assert first != os.getpid()
    assert apart("os:getpid", limits=FREE) == first
    end_helpers(busy=False)
    assert apart("os:getpid", limits=FREE) != first


@pytest.mark.parametrize(
    ("work", "limits", "sentence"),
    [
        (("time:sleep", 60.0), Limits(timeout=0.2), "it took longer than 0.2 s; cut it to what matters"),
        (("os:abort",), FREE, r"its process ended by itself \(SIGABRT\)"),
        (("signal:raise_signal", signal.SIGKILL), FREE, "was killed, most likely because memory ran out"),
        (("math:sqrt", -1.0), FREE, "unexpected ValueError: .*; please report it"),
        (("os:nothing",), FREE, "unexpected AttributeError: .*nothing"),
    ],
)
def test_lost_work_is_told_with_its_reason_and_costs_nothing_else(
    work: tuple[Any, ...], limits: Limits, sentence: str
) -> None:
    name, *arguments = work
    with pytest.raises(LostError, match=sentence):
        apart(name, *arguments, limits=limits)
    assert apart("math:sqrt", 4.0, limits=FREE) == 2.0


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="memory is limited on Linux only")
def test_work_that_outgrows_its_memory_is_lost_and_the_next_may_have_more() -> None:
    with pytest.raises(LostError, match=r"it needs more memory than the 0.5 GB allowed with --memory"):
        apart("builtins:bytes", 2**30, limits=Limits(memory=0.5))
    assert len(apart("builtins:bytes", 2**20, limits=FREE)) == 2**20


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="memory is limited on Linux only")
def test_recordings_share_the_memory_there_is_but_none_goes_without() -> None:
    whole = fair_memory(1)
    assert whole is not None
    assert fair_memory(2) == max(whole / 2, FAIR_MEMORY)
    assert fair_memory(10**6) == FAIR_MEMORY


@given(order=st.permutations(range(6)))
def test_results_come_in_the_order_of_the_trials_whatever_the_order_of_work(order: list[int]) -> None:
    trials = [trial_of(Path(f"{number}.mp4")) for number in range(6)]
    records = [Record(name=str(number), kind="plate", told={}, rows=[]) for number in order]
    assert [record.name for record in in_order(records, trials)] == list("012345")


def test_what_is_finished_is_kept_and_what_changed_is_done_again(plate_clip: Clip, tmp_path: Path) -> None:
    trial, batch = trial_of(plate_clip.path), Batch(out=tmp_path, resume=True)
    kept = tmp_path / "trials" / f"{trial.name}.json"
    (first,) = process_all([trial], batch)
    written, table = kept.stat().st_mtime_ns, (tmp_path / "trials.csv").read_bytes()
    (again,) = process_all([trial], batch)
    assert (again, kept.stat().st_mtime_ns) == (replace(first, kept=True), written)
    assert (tmp_path / "trials.csv").read_bytes() == table
    (tmp_path / "overlays" / f"{trial.name}.png").unlink()
    list(process_all([trial], batch))
    assert kept.stat().st_mtime_ns != written
    assert (tmp_path / "overlays" / f"{trial.name}.png").is_file()


def test_a_trial_out_of_time_is_a_failed_row_and_is_tried_again(plate_clip: Clip, tmp_path: Path) -> None:
    batch = Batch(out=tmp_path, limits=Limits(timeout=0.01), overlays=False)
    (record,) = process_all([trial_of(plate_clip.path)], batch)
    assert record.rows[0]["status"] == "failed"
    assert "plate-00.mp4: it took longer than 0.01 s" in (tmp_path / "trials.csv").read_text()
    (again,) = process_all([trial_of(plate_clip.path)], Batch(out=tmp_path, resume=True, overlays=False))
    assert again.rows[0]["status"] == "ok"


def test_every_option_and_the_content_tell_one_trial_from_another(tmp_path: Path) -> None:
    video = tmp_path / "drop.mp4"
    video.write_bytes(b"a film")
    trial = trial_of(video)
    told = [told_of(trial, overlays=drawn) for drawn in (True, False)]
    told.append(told_of(replace(trial, camera=Camera(readout=0.001)), overlays=True))
    told.append(told_of(replace(trial, bodies={}), overlays=True))
    video.write_bytes(b"a film!")
    told.append(told_of(trial, overlays=True))
    assert all(one != other for number, one in enumerate(told) for other in told[:number])
    video.unlink()
    assert told_of(trial, overlays=True) == {}


def test_every_change_of_the_code_that_measures_tells_one_trial_from_another(tmp_path: Path) -> None:
    (tmp_path / "home" / "tracking" / "deeper").mkdir(parents=True)
    digests = []
    for number, name in enumerate(("track.py", "track.py", "deeper/video.py")):
        (tmp_path / "home" / "tracking" / name).write_text(f"edge = {number}")
        copytree(tmp_path / "home", tmp_path / str(number))
        digests.append(code_digest(tmp_path / str(number)))
    assert len(set(digests)) == 3
    video = tmp_path / "drop.mp4"
    video.write_bytes(b"a film")
    told = told_of(trial_of(video), overlays=True)
    assert told["code"] == code_digest()
    write_record(Record(name="drop", kind="plate", told=told, rows=[]), tmp_path)
    assert finished_record(tmp_path, "drop", told)
    assert finished_record(tmp_path, "drop", told | {"code": digests[0]}) is None


def test_a_record_reads_as_it_was_written_without_nan(tmp_path: Path) -> None:
    rows = [{"time": np.float64(0.1) + 0.2, "frames": np.int64(7), "lift": np.nan, "reason": "größer"}]
    record = write_record(Record(name="a", kind="plate", told={}, rows=rows), tmp_path)
    assert record.rows == [{"time": 0.1 + 0.2, "frames": 7, "lift": None, "reason": "größer"}]
    assert json.loads((tmp_path / "trials" / "a.json").read_text(encoding="utf-8"))["rows"] == record.rows


def test_only_what_a_killed_process_left_of_these_trials_is_swept(tmp_path: Path) -> None:
    folder = tmp_path / "tracks"
    folder.mkdir()
    names = (".a.k3_x9abc.csv", ".a.b.k3_x9abc.csv", ".other.k3_x9abc.csv", ".a.csv", "a.csv")
    for name in names:
        (folder / name).touch()
    sweep(tmp_path, ["a"])
    assert {path.name for path in folder.iterdir()} == set(names[1:])


def test_a_cluster_that_does_not_answer_is_said(plate_clip: Clip, tmp_path: Path) -> None:
    batch = Batch(out=tmp_path, cluster="nonsense://127.0.0.1:1")
    with pytest.raises(
        ExperimentError, match=r"cluster: (no scheduler answers at nonsense|needs the package)"
    ):
        list(process_all([trial_of(plate_clip.path)], batch))


def test_patterns_stand_for_the_files_they_match_in_order(tmp_path: Path) -> None:
    for name in ("b.mp4", "a.mp4", "c.mov", "[d].mp4"):
        (tmp_path / name).touch()
    told = {"kind": "plate", "bodies": BALL, "camera": Camera()}
    assert [t.name for t in collect_trials([f"{tmp_path}/?.mp4"], **told)] == ["a", "b"]  # type: ignore[arg-type]
    assert [t.name for t in collect_trials([f"{tmp_path}/[d].mp4"], **told)] == ["[d]"]  # type: ignore[arg-type]
    with pytest.raises(ExperimentError, match=r"x\*.mp4: no file matches this pattern"):
        collect_trials([tmp_path / "x*.mp4"], kind="plate", bodies=BALL, camera=Camera())

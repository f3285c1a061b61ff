"""What a person reads while a batch runs: everything once, nothing sixty times."""

import shutil
from collections import Counter
from pathlib import Path

from clips import Clip
from typer.testing import CliRunner

from experiments import console
from experiments.cli import app
from experiments.record import Record


def record_of(name: str, *remarks: str) -> Record:
    return Record(name=name, kind="plate", told={}, rows=[], remarks=remarks)


def test_a_remark_on_many_recordings_is_said_once_and_then_counted() -> None:
    said: Counter[str] = Counter()
    records = [record_of(name, f"no mass is told, so {name} falls in a vacuum") for name in "abc"]
    lines = [line for record in records for line in console.complaints(record, said)]
    assert lines == ["a: no mass is told, so a falls in a vacuum"]
    assert list(console.said_again(said)) == ["on 2 more: no mass is told …"]


def test_remarks_that_begin_otherwise_are_all_said() -> None:
    said: Counter[str] = Counter()
    records = [record_of(name, f"the camera drifts by {k} px, undone") for k, name in enumerate("ab")]
    assert len([line for record in records for line in console.complaints(record, said)]) == 2
    assert list(console.said_again(said)) == []


def test_a_run_that_goes_on_says_how_much_it_keeps(plate_clip: Clip, tmp_path: Path) -> None:
    folder = tmp_path / "clips"
    folder.mkdir()
    words = ["process", str(folder), "--kind", "plate", "--ball-diameter", "0.04", "--no-overlays"]
    words += ["--out", str(tmp_path / "out"), "--resume"]
    shutil.copy(plate_clip.path, folder / "a.mp4")
    assert "0 of 1 trials were finished before and are kept" in CliRunner().invoke(app, words).output
    shutil.copy(plate_clip.path, folder / "b.mp4")
    assert "1 of 2 trials were finished before and are kept" in CliRunner().invoke(app, words).output

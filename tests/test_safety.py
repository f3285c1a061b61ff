"""Recordings and tables come from strangers: they are read, and results stay where they were asked for."""

import os
from pathlib import Path

import pytest
from test_tracking_odd_films import fall
from typer.testing import CliRunner, Result

from experiments.cli import app
from experiments.experiment import read_experiment
from experiments.trial import Trial
from tracking.encode import write_video
from tracking.errors import RecordingError
from tracking.render import DropScene, write_recording
from tracking.video import open_recording


def process(*words: str | Path) -> Result:
    told = ("--kind", "plate", "--ball-diameter", "0.04", "--workers", "1", "--quiet")
    return CliRunner().invoke(app, ["process", *map(str, words), *told])


@pytest.fixture(scope="module")
def drop(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("films") / "drop.mp4"
    write_video(path, fall(), 120)
    return path


@pytest.mark.parametrize("folder", ["tracks", "overlays", "trials"])
def test_a_folder_of_results_that_is_a_link_elsewhere_is_refused(
    tmp_path: Path, drop: Path, folder: str
) -> None:
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere" / ".drop.abcdefgh.csv").touch()
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / folder).symlink_to(tmp_path / "elsewhere")
    done = process(drop, "--out", tmp_path / "out")
    assert done.exit_code == 2
    assert f"{folder} must lie in" in done.stderr
    assert "remove the link, or give another --out" in done.stderr
    assert [path.name for path in (tmp_path / "elsewhere").iterdir()] == [".drop.abcdefgh.csv"]


def test_a_folder_of_results_that_leads_nowhere_or_is_a_file_is_refused(tmp_path: Path, drop: Path) -> None:
    (tmp_path / "tracks").symlink_to(tmp_path.parent / "nowhere")
    assert "is a link to" in process(drop, "--out", tmp_path).stderr
    (tmp_path / "tracks").unlink()
    (tmp_path / "tracks").touch()
    assert "must be a folder, but is a file" in process(drop, "--out", tmp_path).stderr


def test_results_replace_planted_links_and_never_follow_them(tmp_path: Path, drop: Path) -> None:
    (tmp_path / "precious").write_text("mine")
    planted = ["trials.csv", "report.html", "run.json", "tracks/drop.csv", "trials/drop.json"]
    planted += ["overlays/drop.mp4", "overlays/drop.png"]
    for name in planted:
        place = tmp_path / "out" / name
        place.parent.mkdir(parents=True, exist_ok=True)
        place.symlink_to(tmp_path / "precious")
    assert process(drop, "--out", tmp_path / "out").exit_code in (0, 1)
    assert (tmp_path / "precious").read_text() == "mine"
    assert not any((tmp_path / "out" / name).is_symlink() for name in planted)
    assert {path.name for path in tmp_path.iterdir()} == {"out", "precious"}


def test_an_out_that_is_itself_a_link_is_the_choice_of_who_typed_it(tmp_path: Path, drop: Path) -> None:
    (tmp_path / "disk").mkdir()
    (tmp_path / "out").symlink_to(tmp_path / "disk")
    assert process(drop, "--out", tmp_path / "out").exit_code in (0, 1)
    assert (tmp_path / "disk" / "trials.csv").is_file()


def test_rendered_recordings_do_not_follow_links(tmp_path: Path) -> None:
    (tmp_path / "precious").write_text("mine")
    for ending in ("mp4", "json"):
        (tmp_path / f"drop.{ending}").symlink_to(tmp_path / "precious")
    write_recording(DropScene(kind="plate", drop_height=0.05, after=0.05, hold=0.05), tmp_path / "drop.mp4")
    assert (tmp_path / "precious").read_text() == "mine"


@pytest.mark.parametrize("video", ["../films/drop.mp4", "{absolute}", "link.mp4"])
def test_a_video_may_lie_anywhere_but_its_results_lie_in_out(tmp_path: Path, drop: Path, video: str) -> None:
    (tmp_path / "films").mkdir()
    (tmp_path / "films" / "drop.mp4").write_bytes(drop.read_bytes())
    (tmp_path / "told").mkdir()
    (tmp_path / "told" / "link.mp4").symlink_to(drop)
    video = video.format(absolute=drop)
    told = tmp_path / "told" / "experiment.toml"
    told.write_text(f'[[trial]]\nvideo = "{video}"\nkind = "plate"\n')
    before = set(tmp_path.rglob("*"))
    process(told, "--out", tmp_path / "out")
    made = set(tmp_path.rglob("*")) - before
    assert made
    assert all((tmp_path / "out") in (path, *path.parents) for path in made)


@pytest.mark.parametrize(
    "name", ["../drop", "/tmp/drop", "..", "a/b", "=1+1", "@SUM(1)", "-2+3|cmd!A0", "a\x00b"]
)
def test_a_name_that_leads_elsewhere_or_would_be_computed_is_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(ValueError, match="name must"):
        Trial(name=name, video=Path("drop.mp4"), kind="plate")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
def test_a_pipe_is_refused_instead_of_waited_for(tmp_path: Path) -> None:
    for name in ("drop.mp4", "experiment.toml", "trials.csv"):
        os.mkfifo(tmp_path / name)
    assert (
        "drop.mp4: no such file"
        in process(tmp_path / "drop.mp4", "--out", tmp_path / "out").stdout
        + (tmp_path / "out" / "trials.csv").read_text()
    )
    with pytest.raises(ValueError, match="must be a file of text"):
        read_experiment(tmp_path / "experiment.toml")
    refused = CliRunner().invoke(app, ["fit", str(tmp_path / "trials.csv")])
    assert "trials.csv is no file" in refused.stderr


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (b"PK\x03\x04", "is an archive, not a video; unpack it and give the videos in it"),
        (b"\x1f\x8b\x08", "is an archive"),
        (b"#EXTM3U\n#EXTINF:1,\n/etc/passwd\n", "is a list of other files, not a video"),
        (b"ffconcat version 1.0\nfile drop.mp4\n", "is a list of other files, not a video"),
        (b'<?xml version="1.0"?><MPD></MPD>', "is a list of other files, not a video"),
    ],
)
def test_archives_and_playlists_are_refused_before_anything_follows_them(
    tmp_path: Path, content: bytes, sentence: str
) -> None:
    (tmp_path / "drop.mp4").write_bytes(content + bytes(100))
    with pytest.raises(RecordingError, match=rf"drop\.mp4: {sentence}"):
        open_recording(tmp_path / "drop.mp4")

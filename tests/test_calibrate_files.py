"""Files appear whole or not at all."""

from pathlib import Path

import pytest

from calibrate.files import write_whole, written_beside


def test_a_file_that_could_not_be_finished_leaves_the_old_one_and_nothing_else(tmp_path: Path) -> None:
    write_whole(tmp_path / "film.mp4", b"old")
    with pytest.raises(TypeError), written_beside(tmp_path / "film.mp4") as beside:
        beside.write_bytes("not bytes")  # type: ignore[arg-type]
    assert [path.name for path in tmp_path.iterdir()] == ["film.mp4"]
    assert (tmp_path / "film.mp4").read_bytes() == b"old"


def test_a_file_is_not_in_its_place_before_it_is_whole(tmp_path: Path) -> None:
    with written_beside(tmp_path / "deep" / "film.mp4") as beside:
        beside.write_bytes(b"new")
        assert (beside.parent, beside.suffix) == (tmp_path / "deep", ".mp4")
        assert not (tmp_path / "deep" / "film.mp4").exists()
    assert (tmp_path / "deep" / "film.mp4").read_bytes() == b"new"


def test_a_name_with_dots_keeps_all_of_it(tmp_path: Path) -> None:
    assert write_whole(tmp_path / "trial.1.csv", "x").name == "trial.1.csv"
    assert [path.name for path in tmp_path.iterdir()] == ["trial.1.csv"]

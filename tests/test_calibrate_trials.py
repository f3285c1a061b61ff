"""The trial table: what is understood, what is refused, and in which words."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from calibrate.trials import COLUMNS, TrialTableError, check_trials, read_trials, write_trials

HEADER = "kind,approach_velocity,upper_rebound_velocity,lower_rebound_velocity,upper_mass,lower_mass"


def typed(folder: Path, text: str) -> Path:
    path = folder / "typed.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_hand_typed_table_needs_only_the_essential_columns(tmp_path: Path) -> None:
    trials = read_trials(typed(tmp_path, f"{HEADER}\ntwo,-3,2.34,0.56,0.0027,0.0027\n"))
    assert tuple(trials.columns) == COLUMNS
    assert trials.status[0] == "ok"
    assert trials.impact[0] == 1
    assert np.isnan(trials.approach_velocity_sd[0])


def test_a_spreadsheet_from_central_europe_is_understood(tmp_path: Path) -> None:
    text = "\ufeffkind;approach_velocity;upper_rebound_velocity\r\nPlate;-2,5;2,1\r\n;;\r\nheld;-2,5;2,0\r\n"
    trials = read_trials(typed(tmp_path, text))
    assert list(trials.kind) == ["plate", "held"]
    assert list(trials.approach_velocity) == [-2.5, -2.5]


def test_what_is_written_reads_back_the_same(tmp_path: Path) -> None:
    trials = read_trials(
        typed(tmp_path, f"{HEADER},frames\ntwo,-3,2.34,0.56,0.0027,0.0027,12\nplate,-3,2,,,,9\n")
    )
    pd.testing.assert_frame_equal(read_trials(write_trials(trials, tmp_path / "trials.csv")), trials)
    assert list(tmp_path.glob(".*")) == []


def test_several_files_become_one_table(tmp_path: Path) -> None:
    path = typed(tmp_path, f"{HEADER}\nplate,-3,2.4,,,\n")
    assert len(read_trials([path, path])) == 2


def test_one_bad_row_does_not_lose_the_others(tmp_path: Path) -> None:
    trials = read_trials(typed(tmp_path, f"{HEADER}\nplate,-3,fast,,,\nplate,-3,2.4,,,\n"))
    assert list(trials.status) == ["failed", "ok"]
    assert trials.reason[0] == "typed.csv, line 2: upper_rebound_velocity must be a number, got 'fast'"


@pytest.mark.parametrize(
    ("row", "sentence"),
    [
        ("plate,3,2.4,,,", "approach_velocity must be below zero (up is positive), got 3"),
        ("plate,-3,-2.4,,,", "upper_rebound_velocity must not be negative (up is positive), got -2.4"),
        ("held,-3,3.1,,,", "faster than the approach"),
        ("held,-3,inf,,,", "upper_rebound_velocity must be finite, got 'inf'"),
        ("two,-3,2,1,-0.0027,0.0027", "upper_mass must be above zero, got -0.0027"),
        ("two,-3,2,1,,0.0027", "upper_mass is missing, trials of kind 'two' need it"),
        ("two,-3,1,2,1,1", "are the two columns swapped?"),
        ("two,-3,2.5,2,1,1", "more energy than the upper one brought"),
        ("roll,-3,2,1,1,1", "kind must be one of plate, held, two, shot, pair, got 'roll'"),
    ],
)
def test_a_bad_row_says_which_rule_it_breaks(tmp_path: Path, row: str, sentence: str) -> None:
    trials = read_trials(typed(tmp_path, f"{HEADER}\n{row}\nplate,-3,2.4,,,\n"))
    assert trials.status[0] == "failed"
    assert sentence in trials.reason[0]
    assert trials.reason[0].startswith("typed.csv, line 2: ")


def test_measurement_noise_alone_does_not_condemn_a_very_elastic_rebound() -> None:
    row = {"kind": "plate", "approach_velocity": -2.0, "upper_rebound_velocity": 2.01}
    sure = check_trials(
        pd.DataFrame([row | {"upper_rebound_velocity_sd": 0.001}, row | {"upper_rebound_velocity": 1}])
    )
    unsure = check_trials(pd.DataFrame([row | {"upper_rebound_velocity_sd": 0.01}]))
    assert list(sure.status) == ["failed", "ok"]
    assert list(unsure.status) == ["ok"]


def test_a_row_that_came_as_failed_keeps_its_own_reason() -> None:
    row = {"kind": "plate", "status": "failed", "reason": "the ball leaves the picture"}
    trials = check_trials(pd.DataFrame([row | {"approach_velocity": None, "upper_rebound_velocity": None}]))
    assert trials.reason[0] == "the ball leaves the picture"


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", "typed.csv is empty"),
        (f"{HEADER}\n", "typed.csv holds no trial"),
        ("approach_velocity\n-3\n", "typed.csv has no column 'kind'"),
        (
            "kind,approach_velocity\nplate,-3\n",
            "no column 'upper_rebound_velocity', which trials of kind 'plate' need",
        ),
        ("kind,kind\nplate,plate\n", "column 'kind' appears twice"),
        (f"{HEADER}\nplate,-3,0,2,4,,,\n", "typed.csv, line 2: 8 cells where the header has 6"),
        (
            f"{HEADER}\nplate,3,2.4,,,\n",
            "no usable trial in typed.csv; the first reason is: typed.csv, line 2",
        ),
    ],
)
def test_a_broken_table_is_refused_in_one_sentence(tmp_path: Path, text: str, sentence: str) -> None:
    with pytest.raises(TrialTableError) as refused:
        read_trials(typed(tmp_path, text))
    assert sentence in str(refused.value)


def test_a_table_that_is_not_text_is_refused(tmp_path: Path) -> None:
    (tmp_path / "book.csv").write_bytes(b"\x89\x8d\xff\xfe")
    with pytest.raises(TrialTableError, match="not UTF-8 text"):
        read_trials(tmp_path / "book.csv")

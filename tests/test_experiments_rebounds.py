"""Restitution from rebound heights and bounce intervals: air, units, agreement of the two on one ball."""

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

from calibrate import TrialTableError
from calibrate.readings import read_readings
from experiments.cli import app
from experiments.rebounds import HEIGHTS, INTERVALS, BallResult, results
from tracking.flight import Air, apex, fall_time, flight_of_ball, velocity

PINGPONG = (0.0027, 0.040)
LAW = (0.96, 0.02)  # e0 and a, s/m


def fit(*words: str) -> Result:
    return CliRunner().invoke(app, ["fit", *words])


def typed(folder: Path, text: str) -> Path:
    path = folder / "heights.csv"
    path.write_text(text, encoding="utf-8")
    return path


def bounces_in_air(folder: Path) -> tuple[Path, Path]:
    """Tables of a ball that loses `LAW` at each bounce and flies through air, without reading errors."""
    flight = flight_of_ball(PINGPONG[0], PINGPONG[1] / 2, Air())
    heights, intervals = ["ball,h0_cm,h1_cm"], ["ball,h0_mm,launch,interval_no,dt_ms"]
    for height in (0.1, 0.2, 0.4, 0.8):
        start, fallen = height, height
        for number in range(6):
            landing = -float(velocity(flight, 0.0, fall_time(flight, fallen)))
            rise, top = apex(flight, (LAW[0] - LAW[1] * landing) * landing)
            time = rise + float(fall_time(flight, top))
            intervals.append(f"white,{1000 * start},a,{number + 1},{1000 * time}")
            if number == 0:
                heights.append(f"white,{100 * start},{100 * top}")
            fallen = top
    (folder / "intervals.csv").write_text("\n".join(intervals), encoding="utf-8")
    return typed(folder, "\n".join(heights)), folder / "intervals.csv"


@pytest.fixture(scope="module")
def real_pingpong_ball(shared_data: Path) -> BallResult:
    tables = [
        read_readings(shared_data / "real" / f"{name}.csv")
        for name in ("rebound-heights", "bounce-intervals")
    ]
    return results(tables, {"pingpong_parquet": PINGPONG})[0]


def test_both_methods_find_the_same_law_through_air(tmp_path: Path) -> None:
    (ball,) = results([read_readings(table) for table in bounces_in_air(tmp_path)], {"white": PINGPONG})
    for method in (HEIGHTS, INTERVALS):
        assert (ball.laws[method].at_rest, ball.laws[method].slope) == pytest.approx(LAW, abs=2e-5)


def test_leaving_air_out_makes_restitution_fall_too_steeply(tmp_path: Path) -> None:
    readings = [read_readings(table) for table in bounces_in_air(tmp_path)]
    (ball,) = results(readings, {})
    assert all(law.slope > 1.5 * LAW[1] for law in ball.laws.values())


def test_restitution_of_a_real_pingpong_ball_falls_with_speed(real_pingpong_ball: BallResult) -> None:
    law = real_pingpong_ball.laws[INTERVALS]
    assert law.depends_on_speed
    assert 0.002 < law.slope < 0.01
    assert real_pingpong_ball.laws[HEIGHTS].slope > 0


def test_heights_and_intervals_of_a_real_ball_agree(real_pingpong_ball: BallResult) -> None:
    (one, one_sd), (other, other_sd) = (law.at(1.5) for law in real_pingpong_ball.laws.values())
    assert abs(one - other) < 2.5 * np.hypot(one_sd, other_sd)
    assert one == pytest.approx(0.955, abs=0.005)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("h0_in,h1_in\n5,4\n", "unit in 'h0_in' must be one of m, cm, mm, got 'in'"),
        ("h0,h1\n5,4\n", "column 'h0' must say its unit, such as h0_mm"),
        ("h1_cm,repeat\n5,1\n", "has no column of drop height, such as h0_cm"),
        ("ball,dt_s\nred,0.5\n", "has no column of number, such as interval_no"),
        ("h0_cm,h1_cm\n5,six\n", "heights.csv, line 2: rebound height must be a number above zero"),
    ],
)
def test_a_table_that_is_not_understood_is_refused(tmp_path: Path, text: str, sentence: str) -> None:
    with pytest.raises(TrialTableError) as refused:
        read_readings(typed(tmp_path, text))
    assert sentence in str(refused.value)


def test_fit_understands_heights_and_leaves_a_bad_line_out(tmp_path: Path) -> None:
    rows = "\n".join(f"red,{height},{0.8 * height}" for height in (10, 20, 40, 60))
    path = typed(tmp_path, f"ball,h0_cm,h1_cm\n{rows}\nred,10,11\n")
    done = fit(str(path), "--out", str(tmp_path), "--ball", "red=0.05,0.04")
    assert done.exit_code == 1
    assert "line 6: rebound height 0.11 m is above drop height 0.1 m; left out" in done.stderr
    assert "red, through air" in done.stdout
    assert (tmp_path / "restitution.png").exists()


def test_a_ball_that_is_not_in_the_table_is_refused(tmp_path: Path) -> None:
    path = typed(tmp_path, "ball,h0_cm,h1_cm\nred,10,8\n")
    done = fit(str(path), "--ball", "blue=0.05,0.04", "--out", str(tmp_path))
    assert done.exit_code == 2
    assert "ball must be one of red, got 'blue'" in done.stderr


def test_intervals_none_of_which_follows_another_are_said_to_tell_nothing(tmp_path: Path) -> None:
    path = typed(
        tmp_path, "ball,h0_cm,interval_no,launch,dt_s\nred,8,1,1,0.255\nred,8,2,1,nan\nred,8,3,1,0.23\n"
    )
    done = fit(str(path), "--out", str(tmp_path))
    assert done.exit_code == 1
    assert "line 3: interval must be a number above zero; left out" in done.stderr
    assert "nothing to compare: no two intervals of a launch follow each other" in done.stdout
    assert (tmp_path / "restitution.png").exists()

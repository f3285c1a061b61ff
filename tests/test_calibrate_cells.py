"""Tables as spreadsheets save them: what is understood, what is refused as it may mean two things."""

import gzip
import zipfile
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from calibrate.cells import read_cells
from calibrate.readings import holds_readings, read_readings
from calibrate.rows import TrialTableError
from calibrate.trials import read_trials

ROWS = [
    ["kind", "v0 [m/s]", "v1 (cm/s)", "Größe"],
    ["plate", "-2.5", "210", "groß"],
    ["held", "-3", "240.5", ""],
]
NUMBERS = ["approach_velocity", "upper_rebound_velocity"]


def saved(folder: Path, text: str, encoding: str = "utf-8") -> Path:
    path = folder / "typed.csv"
    path.write_bytes(text.encode(encoding))
    return path


def refusal(folder: Path, text: str) -> str:
    with pytest.raises(TrialTableError) as refused:
        read_cells(saved(folder, text))
    return str(refused.value)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "cp1252", "utf-16"])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize(
    ("separator", "comma"), [(",", "."), (";", ","), (";", "."), ("\t", ","), ("\t", ".")]
)
def test_every_way_a_spreadsheet_saves_gives_the_same_table(
    tmp_path: Path, encoding: str, end: str, separator: str, comma: str
) -> None:
    lines = [separator.join([ROWS[0][0], *ROWS[0][1:], "", ""])]
    lines += [separator.join([cell.replace(".", comma) for cell in row] + ["", ""]) for row in ROWS[1:]]
    lines.insert(2, separator * 5)
    trials = read_trials(saved(tmp_path, end.join([*lines, "", ""]), encoding))
    assert trials[NUMBERS].to_numpy().tolist() == [[-2.5, 2.1], [-3.0, 2.405]]
    assert trials["Größe"].tolist() == ["groß", ""]
    assert trials.trial.tolist() == ["typed-02", "typed-04"]


def test_a_line_that_names_the_separator_is_obeyed(tmp_path: Path) -> None:
    trials = read_trials(saved(tmp_path, "sep=;\nkind;v0;v1\nplate;-2,5;2\n"))
    assert trials.approach_velocity.tolist() == [-2.5]
    assert trials.trial.tolist() == ["typed-03"]


@pytest.mark.parametrize(
    ("column", "cell", "name", "value"),
    [
        ("v0 [km/h]", "-9", "approach_velocity", -2.5),
        ("approach_velocity (cm/s)", "-250", "approach_velocity", -2.5),
        ("Approach velocity", "-2.5", "approach_velocity", -2.5),
        ("lower_mass [g]", "2,7E+00", "lower_mass", 0.0027),
        ("m1_g", "2.7", "upper_mass", 0.0027),
        ("v2_sd [mm/s]", "12", "lower_rebound_velocity_sd", 0.012),
        ("cue elevation [deg]", "180", "cue_elevation", 3.141592653589793),
        ("angular_velocity_x [rpm]", "60", "angular_velocity_x", 6.283185307179586),
        ("time (ms)", "\u22125", "time", -0.005),
        ("room temperature [C]", "21.5", "room temperature [C]", 21.5),
    ],
)
def test_a_unit_in_the_name_of_a_column_is_understood(
    tmp_path: Path, column: str, cell: str, name: str, value: float
) -> None:
    table = read_cells(saved(tmp_path, f"kind;{column}\nplate;{cell}\n"))
    assert float(table[name][2]) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize("column", ["h1 [cm]", "h1_cm", "rebound height (cm)", "H1[cm]"])
def test_heights_may_carry_their_unit_in_every_form(tmp_path: Path, column: str) -> None:
    path = saved(tmp_path, f"h0 [mm]\t{column}\n500\t42\n")
    assert holds_readings(path)
    assert read_readings(path).heights.rebound_height.tolist() == [0.42]


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("kind,v0 [mph]\nplate,-3\n", "unit in 'v0 [mph]' must be one of m/s, cm/s, mm/s, km/h, got 'mph'"),
        ("kind,mass [g]\ntwo,3\n", "column 'mass [g]' may be upper_mass or lower_mass; name it so"),
        ("h0_cm,height [cm]\n5,3\n", "column 'height [cm]' may be drop_height or rebound_height; name it so"),
        ("h0 [in],h1_cm\n5,4\n", "unit in 'h0 [in]' must be one of m, cm, mm, got 'in'"),
        ("kind [m],v0\nplate,-3\n", "unit in 'kind [m]' must not be there, it holds text"),
        ("kind,v0,v0 [cm/s]\nplate,-3,-300\n", "appears twice, as 'v0' and as 'v0 [cm/s]'; remove one"),
        ("kind,v0,\nplate,-2,5\n", "line 2: column 3 must have a name in the header, but has none"),
        ("kind,v0,v1\nplate,-2,5,2\n", "with decimal commas, separate the cells by semicolons"),
        ('kind,v0\n"plate,-3\n', "cannot be split into cells (unexpected end of data); check its quot"),
        (f"kind,note\nplate,{'x' * 200_000}\n", "line 2: cannot be split into cells (field larger than"),
    ],
)
def test_a_table_that_is_not_clear_is_refused_with_the_rule(tmp_path: Path, text: str, sentence: str) -> None:
    assert sentence in refusal(tmp_path, text)


@pytest.mark.parametrize(
    ("text", "readings"),
    [
        ("ball,h0_cm;h1_cm\nred,50;42\n", ("with a comma between", "with a semicolon between")),
        ("kind;v0;v1\nplate;-2,5;1.9\n", ("decimal comma ('-2,5', line 2)", "decimal point ('1.9', line 2)")),
        ("kind\tm1 [g]\nplate\t1,234\n", ("1.234 (decimal comma)", "1234 (comma between thousands)")),
        ('kind,m1 [g]\nplate,"1,234"\n', ("1.234 (decimal comma)", "1234 (comma between thousands)")),
    ],
)
def test_what_may_be_read_in_two_ways_is_refused_and_both_are_named(
    tmp_path: Path, text: str, readings: tuple[str, str]
) -> None:
    said = refusal(tmp_path, text)
    assert readings[0] in said
    assert readings[1] in said


def test_a_decimal_comma_in_three_digits_is_clear_where_another_number_has_one_digit(tmp_path: Path) -> None:
    table = read_cells(saved(tmp_path, "kind\tv0\tv1\nplate\t-2,345\t1,9\n"))
    assert table.iloc[0].tolist() == ["plate", "-2.345", "1.9"]


def test_text_keeps_its_commas(tmp_path: Path) -> None:
    trials = read_trials(saved(tmp_path, 'trial;kind;v0;v1\n1,5;plate;-2,5;2,0\n1.6;plate;-2,5;"2,1"\n'))
    assert trials.trial.tolist() == ["1,5", "1.6"]


def test_digits_with_an_underscore_are_no_number(tmp_path: Path) -> None:
    trials = read_trials(saved(tmp_path, "kind,v0,v1\nplate,-1_5,2\nplate,-3,2\n"))
    assert trials.reason[0] == "typed.csv, line 2: approach_velocity must be a number, got '-1_5'"


def test_workbooks_archives_and_folders_are_refused_with_the_remedy(tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "book.xlsx", "w") as book:
        book.writestr("xl/workbook.xml", "<workbook/>")
    (tmp_path / "table.csv.gz").write_bytes(gzip.compress(b"kind,v0,v1\nplate,-3,2\n"))
    (tmp_path / "folder.csv").mkdir()
    for name, what in (
        ("book.xlsx", "a workbook"),
        ("table.csv.gz", "compressed"),
        ("folder.csv", "no file"),
    ):
        with pytest.raises(TrialTableError, match=rf"{name} .*{what}"):
            read_cells(tmp_path / name)


def test_a_table_of_more_bytes_than_any_experiment_is_refused_unread(tmp_path: Path) -> None:
    with (tmp_path / "huge.csv").open("wb") as file:
        file.truncate(60_000_000_000)
    with pytest.raises(TrialTableError, match=r"huge.csv must have at most 50 MB, got 60000 MB"):
        read_cells(tmp_path / "huge.csv")


def test_twenty_thousand_lines_are_read_all(tmp_path: Path) -> None:
    trials = read_trials(saved(tmp_path, "kind;v0;v1 [cm/s]\n" + "plate;-2,5;212,5\n;;\n" * 20_000))
    assert len(trials) == 20_000
    assert set(trials.upper_rebound_velocity) == {2.125}


@given(st.floats(-1e6, 1e6), st.sampled_from([",", "."]))
def test_a_number_means_the_same_with_comma_and_point(
    tmp_path_factory: pytest.TempPathFactory, value: float, sign: str
) -> None:
    folder = tmp_path_factory.mktemp("number")
    table = read_cells(saved(folder, f"kind;v0\nplate;{str(value).replace('.', sign)}\n"))
    assert float(table["approach_velocity"][2]) == value

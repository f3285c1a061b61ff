"""What is to be measured: experiment files, folders and bare videos, and every way to get them wrong."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from experiments.experiment import ExperimentError, collect_trials, read_experiment
from experiments.trial import Body, Camera, Trial

TRIAL = '[[trial]]\nvideo = "two-00.mp4"\nkind = "two"\n'
SHOT = TRIAL.replace('"two"', '"shot"')
NAN = float("nan")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "two-00.mp4").touch()
    return tmp_path


def written(folder: Path, text: str) -> Path:
    path = folder / "experiment.toml"
    path.write_text(text, encoding="utf-8")
    return path


def collected(*sources: Path, kind: str | None = "plate") -> list[Trial]:
    return collect_trials(sources, kind=kind, bodies={}, camera=Camera())


def test_trial_comes_before_the_experiment_and_the_experiment_before_nothing(folder: Path) -> None:
    text = """name = "all there is"
        [camera]
        capture_fps = 240
        scale = { points_px = [[215, 40], [215, 640]], distance = 0.30 }
        [bodies]
        upper = { mass = 0.0027, diameter = 0.040 }
        lower = { mass = 0.0030 }
        [[trial]]
        video = "two-00.mp4"
        kind = "two"
        [[trial]]
        video = "two-00.mp4"
        kind = "held"
        name = "again"
        readout = 0.004
        upper = { mass = 0.0054 }
    """
    first, second = read_experiment(written(folder, text))
    assert (first.name, first.kind, first.video) == ("two-00", "two", folder / "two-00.mp4")
    assert first.body("upper") == Body(mass=0.0027, diameter=0.040)
    assert (first.camera.capture_fps, first.camera.readout) == (240, None)
    assert (second.name, second.body("upper")) == ("again", Body(mass=0.0054, diameter=0.040))
    assert second.body("lower") == Body(mass=0.0030)
    assert (second.camera.readout, second.camera.scale) == (0.004, first.camera.scale)


def test_a_pattern_stands_for_all_its_videos_with_what_its_trial_says(folder: Path) -> None:
    for name in ("two-10.mp4", "two-2.MOV", "two-00.json", "held-0.mp4", "._two-3.mp4"):
        (folder / name).touch()
    text = TRIAL.replace("two-00.mp4", "two-*") + "upper = { mass = 0.0054 }"
    trials = read_experiment(written(folder, text))
    assert [trial.name for trial in trials] == ["two-00", "two-10", "two-2"]
    assert {trial.body("upper").mass for trial in trials} == {0.0054}


def test_a_name_with_brackets_is_no_pattern_and_a_pattern_of_several_has_no_name(folder: Path) -> None:
    for name in ("take [1].mp4", "take 1.mp4"):
        (folder / name).touch()
    (trial,) = read_experiment(written(folder, TRIAL.replace("two-00", "take [1]")))
    assert trial.name == "take [1]"
    with pytest.raises(ExperimentError, match=r"trial 1: name must be .* but 'take \*.mp4' matches 2; leave"):
        read_experiment(written(folder, TRIAL.replace("two-00", "take *") + 'name = "one"'))


def test_a_shot_may_be_told_its_cue_ball(folder: Path) -> None:
    bodies = "[bodies]\nball = { mass = 0.1673, diameter = 0.0572 }\ncue = { mass = 0.5018 }\n"
    (trial,) = read_experiment(written(folder, bodies + SHOT + "start_px = [751, 270.5]"))
    assert trial.start_px == [751, 270.5]
    assert trial.body("ball") == Body(mass=0.1673, diameter=0.0572)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", r"holds no \[\[trial\]\]; add one with video and kind"),
        ("trial = 3", r"holds no \[\[trial\]\]"),
        ("trial = [3]", "trial 1: must be a table of keys and values, got 3"),
        ("[[trial]\n", "is not valid TOML"),
        (f"x = {'[' * 3000}", "is not valid TOML"),
        (f"x = {'9' * 5000}", "is not valid TOML"),
        ('colour = "red"\n' + TRIAL, "unknown key 'colour'; known are bodies, camera, name, trial"),
        (TRIAL + "mass = 1", "trial 1: unknown key 'mass'; known are ball, "),
        ("[camera]\nfps = 240\n" + TRIAL, r"\[camera\]: unknown key 'fps'; known are capture_fps, readout"),
        ("[bodies]\nmiddle = {}\n" + TRIAL, r"\[bodies\]: unknown key 'middle'; known are ball, cue"),
        ("[bodies]\nupper = 0.04\n" + TRIAL, r"\[bodies\], upper: must be a table .*, got 0\.04"),
        ("[bodies.upper]\nradius = 1\n" + TRIAL, "upper: unknown key 'radius'; known are diameter, mass"),
        ("[bodies.upper]\nmass = -1\n" + TRIAL, r"upper: mass must be positive, got -1"),
        ("[bodies.upper]\nmass = 'a gram'\n" + TRIAL, "upper: mass must be positive, got 'a gram'"),
        ("[bodies.upper]\nmass = true\n" + TRIAL, "upper: mass must be positive, got True"),
        ("[bodies.upper]\ndiameter = 0\n" + TRIAL, "upper: diameter must be positive, got 0"),
        ("[bodies.upper]\ndiameter = 40\n" + TRIAL, "diameter must be at most 1 m, got 40; is it in metres"),
        ("[bodies.upper]\nmass = nan\n" + TRIAL, "mass must be positive, got nan"),
        ("[bodies.upper]\nmass = inf\n" + TRIAL, "mass must be positive, got inf"),
        (f"[bodies.upper]\nmass = 1{'0' * 400}\n" + TRIAL, "mass must be positive, got 1000"),
        ("[camera]\ncapture_fps = 0\n" + TRIAL, "capture_fps must be positive, got 0"),
        ("[camera]\ncapture_fps = 1e300\n" + TRIAL, r"capture_fps must be at most 1e\+06, got 1e\+300"),
        ("[camera]\nreadout = -0.1\n" + TRIAL, r"readout must be within \[0, 1\) s, got -0\.1"),
        ("[camera]\nscale = 0.0008\n" + TRIAL, "scale must be a table such as .*, got 0.0008"),
        ("[camera]\nscale = []\n" + TRIAL, "scale must be a table such as"),
        ("[camera.scale]\nmm = 1\n" + TRIAL, "scale must have ball_diameter or .*, got the keys mm"),
        ("[camera.scale]\nmetres_per_pixel = 0\n" + TRIAL, "metres_per_pixel must be positive, got 0"),
        ("[camera.scale]\nmetres_per_pixel = 1e200\n" + TRIAL, r"must be within \[1e-09, 1000\] m, got"),
        ("[camera.scale]\nball_diameter = 0.04\n" + TRIAL, "must name the ball 'upper', .*, got 0.04"),
        ("[camera.scale]\ndistance = 1\npoints_px = 'ab'\n" + TRIAL, r"must be 2 points \[x, y\] in pixels"),
        ("[camera.scale]\ndistance = 1\npoints_px = [[0, 1], [nan, 2]]\n" + TRIAL, "must be 2 points"),
        ("[camera.scale]\ndistance = 1\npoints_px = [[0, 1]]\n" + TRIAL, "must be 2 points"),
        ("[camera.scale]\nwidth = 1\nheight = 1\ncorners_px = [1, 2, 3, 4]\n" + TRIAL, "must be 4 points"),
        (
            "[camera.scale]\nwidth = 1\nheight = 1\ncorners_px = [[0, 0], [9, 0], [9, 9], [0, 9]]\n" + TRIAL,
            "must be the lower left, lower right, upper right and upper left corner, in this order",
        ),
        (TRIAL.replace("two-00", "two-99"), "trial 1: there is no video 'two-99.mp4'; its path counts"),
        (TRIAL.replace("two-00", "one-*"), "trial 1: no video matches 'one-.*.mp4'; its path counts from"),
        (TRIAL.replace("two-00.mp4", "*.toml"), "trial 1: no video matches"),
        (TRIAL + TRIAL.replace("-00", "-*"), "trial 2: two-00.mp4 must be in one trial only, .* a name"),
        (TRIAL.replace("two-00.mp4", r"\\u0000/*"), "trial 1: no video matches"),
        (TRIAL.replace("two-00.mp4", "."), "trial 1: there is no video '.'"),
        (TRIAL.replace("two-00", "x" * 5000), "trial 1: there is no video"),
        (TRIAL.replace('"two-00.mp4"', "7"), "trial 1: video must be given as text, got 7"),
        ('[[trial]]\nvideo = "two-00.mp4"', "trial 1: kind must be given as text, got None"),
        (TRIAL.replace('"two"', '"three"'), "trial 1: kind must be one of plate, .*, got 'three'"),
        (TRIAL + TRIAL + "name = 5", "trial 2: name must be given as text, got 5"),
        (TRIAL + 'name = "../x"', "trial 1: name must be that of a file"),
        (
            TRIAL.replace('"two"', '"pair"') + "start_px = [1, 2]",
            "trial 1: start_px is for trials that measure one ball, got kind 'pair'",
        ),
        (SHOT + "start_px = 7", r"trial 1: start_px must be a point \[x, y\] in pixels, got 7"),
        (SHOT + "start_px = [nan, 0]", r"trial 1: start_px must be a point \[x, y\] in pixels"),
    ],
)
def test_broken_rule_is_named_with_file_key_and_value(folder: Path, text: str, message: str) -> None:
    with pytest.raises(ExperimentError, match=rf"experiment\.toml.*{message}"):
        read_experiment(written(folder, text))


@pytest.mark.parametrize(
    "name",
    ["", " ", ".", "..", "../x", "a/../../x", "/etc/x", "C:x", "a\\b", "a\nb", "a\0b", "\udcff", "x" * 201],
)
def test_name_never_leads_out_of_the_folder_of_results(name: str) -> None:
    with pytest.raises(ValueError, match="name must be that of a file"):
        Trial(name=name, video=Path("a.mp4"), kind="plate")


@given(st.text(max_size=60))
def test_every_accepted_name_makes_a_file_in_its_folder(name: str) -> None:
    try:
        Trial(name=name, video=Path("a.mp4"), kind="plate")
    except ValueError:
        return
    path = Path("/results/tracks") / f"{name}.csv"
    assert path.parent == Path("/results/tracks")
    assert path.name == f"{name}.csv"
    assert path.name.encode()


def test_names_stay_apart_even_where_case_is_ignored(tmp_path: Path) -> None:
    names = ("a/drop.mp4", "b/drop.mp4", "c/Drop.mp4", "d/drop-2.mp4")
    for name in names:
        (tmp_path / name).parent.mkdir()
        (tmp_path / name).touch()
    trials = collected(*(tmp_path / name for name in names))
    assert [trial.name for trial in trials] == ["drop", "drop-2", "Drop-3", "drop-2-2"]


def test_folder_gives_its_experiment_or_else_its_videos(folder: Path) -> None:
    for name in ("one.MOV", "._two-00.mp4", "notes.txt"):
        (folder / name).touch()
    assert [trial.name for trial in collected(folder)] == ["one", "two-00"]
    written(folder, TRIAL)
    assert [(trial.name, trial.kind) for trial in collected(folder)] == [("two-00", "two")]


def test_bare_videos_take_what_the_command_line_says(folder: Path) -> None:
    bodies, camera = {"upper": Body(diameter=0.04)}, Camera(capture_fps=120)
    (trial,) = collect_trials([folder / "two-00.mp4"], kind="held", bodies=bodies, camera=camera)
    assert (trial.kind, trial.body("upper").diameter, trial.camera.capture_fps) == ("held", 0.04, 120)
    assert trial.body("lower") == Body()


def test_sources_that_hold_nothing_are_wrong_use(folder: Path) -> None:
    (folder / "empty").mkdir()
    for sources, message in (
        ([], "nothing to process: name an experiment.toml, a video, or a folder"),
        ([folder / "two-99.mp4"], "two-99.mp4: no such file or folder; check the spelling"),
        ([folder / ("x" * 5000)], "no such file or folder"),
        ([folder / "empty"], "holds no experiment.toml and no video"),
    ):
        with pytest.raises(ExperimentError, match=message):
            collected(*sources)
    with pytest.raises(ExperimentError, match=r"two-00\.mp4: say what it shows with --kind: plate"):
        collected(folder / "two-00.mp4", kind=None)


def test_videos_whose_names_cannot_be_used_say_what_to_do(tmp_path: Path) -> None:
    (tmp_path / "10:32.mp4").touch()
    with pytest.raises(ExperimentError, match=r"name must be that of a file .*; rename it or describe it"):
        collected(tmp_path)
    with pytest.raises(ExperimentError, match="kind must be one of plate, held, two, shot, pair, got 'drop'"):
        collected(tmp_path, kind="drop")


@pytest.mark.parametrize("value", [0, -1, NAN, float("inf"), "3", True, [1]])
def test_sizes_and_rates_must_be_positive_numbers(value: object) -> None:
    for make in (Body, Camera):
        for name in ("mass", "diameter") if make is Body else ("capture_fps",):
            with pytest.raises(ValueError, match=rf"{name} must be positive, got"):
                make(**{name: value})


def test_file_that_is_not_text_is_said(folder: Path) -> None:
    path = folder / "experiment.toml"
    path.write_bytes(b"\xff\xfe\x00name")
    with pytest.raises(ExperimentError, match=r"experiment\.toml: is not valid TOML"):
        read_experiment(path)
    with pytest.raises(ExperimentError, match="cannot be read: "):
        read_experiment(folder)


def test_byte_order_mark_is_no_hindrance(folder: Path) -> None:
    assert len(read_experiment(written(folder, "\ufeff" + TRIAL))) == 1

"""What is to be measured: an `experiment.toml`, or bare videos with options, as checked dataclasses."""

import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any

KINDS = ("plate", "held", "two", "shot", "pair")
BODIES = ("upper", "lower", "ball", "cue")
VIDEO_SUFFIXES = {".mp4", ".mov", ".m4v", ".avi", ".mkv", ".webm", ".mts", ".3gp", ".wmv"}
SCALE_KEYS = (
    {"ball_diameter"},
    {"metres_per_pixel"},
    {"points_px", "distance"},
    {"corners_px", "width", "height"},
)


class ExperimentError(ValueError):
    """What was asked for cannot be done; the message names the file, the key, the rule and the value."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Body:
    """A ball or a cue: mass in kg and diameter in m, None where it was not told."""

    mass: float | None = None
    diameter: float | None = None

    def __post_init__(self) -> None:
        for name in ("mass", "diameter"):
            value = getattr(self, name)
            if value is not None and not (_is_number(value) and value > 0):
                raise ValueError(f"{name} must be positive, got {value!r}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Camera:
    """How the pictures were taken: frames captured a second, rolling-shutter readout in s, and the scale.

    `scale` is as in the file: ``{"metres_per_pixel": 0.0008}``, ``{"ball_diameter": "upper"}``, two points
    and their distance, or four corners with width and height. Empty: from the diameter of the upper ball.
    """

    capture_fps: float | None = None
    readout: float = 0.0
    scale: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.capture_fps is not None and not (_is_number(self.capture_fps) and self.capture_fps > 0):
            raise ValueError(f"capture_fps must be positive, got {self.capture_fps!r}")
        if not (_is_number(self.readout) and 0 <= self.readout < 1):
            raise ValueError(f"readout must be within [0, 1) s, got {self.readout!r}")
        if self.scale and set(self.scale) not in SCALE_KEYS:
            raise ValueError(f"scale must have {_one_of(SCALE_KEYS)}, got the keys {', '.join(sorted(self.scale))}")
        if "ball_diameter" in self.scale and self.scale["ball_diameter"] not in ("upper", "ball"):
            raise ValueError(f"scale: ball_diameter must name the ball 'upper', got {self.scale['ball_diameter']!r}")
        for name in {"metres_per_pixel", "distance", "width", "height"} & set(self.scale):
            if not (_is_number(self.scale[name]) and self.scale[name] > 0):
                raise ValueError(f"scale: {name} must be positive, got {self.scale[name]!r}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """One recording: its name in the results, the video, what kind of impact it shows, bodies and camera."""

    name: str
    video: Path
    kind: str
    bodies: Mapping[str, Body] = field(default_factory=dict)
    camera: Camera = field(default_factory=Camera)

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise ValueError(f"kind must be one of {', '.join(KINDS)}, got {self.kind!r}")

    def body(self, name: str) -> Body:
        """Give a body, unknown in everything if it was not told."""
        return self.bodies.get(name, Body())


def collect_trials(sources: Iterable[Path | str], *, kind: str | None, bodies: Mapping[str, Body], camera: Camera) -> list[Trial]:
    """Gather the trials of experiment files, video files and folders, in the order given.

    Parameters
    ----------
    sources : paths of experiment.toml files, of videos, or of folders of either
    kind, bodies, camera :
        What the command line says; it serves bare videos and overrides nothing in an experiment file.

    Raises
    ------
    ExperimentError
        If a source is missing, holds no recording, or an experiment file breaks a rule.
    """
    trials: list[Trial] = []
    for source in map(Path, sources):
        if source.is_dir():
            trials += _from_folder(source, kind, bodies, camera)
        elif not source.exists():
            raise ExperimentError(f"{source}: no such file or folder; check the spelling")
        elif source.suffix == ".toml":
            trials += read_experiment(source)
        else:
            trials.append(_bare(source, kind, bodies, camera))
    if not trials:
        raise ExperimentError("nothing to process: name an experiment.toml, a video, or a folder of them")
    return _with_unique_names(trials)


def read_experiment(path: Path) -> list[Trial]:
    """Read an `experiment.toml`: every key checked, every path relative to the file.

    Raises
    ------
    ExperimentError
        Naming file, key, rule and value.
    """
    try:
        told = tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ExperimentError(f"{path.name}: is not valid TOML: {error}") from error
    _only(told, {"name", "camera", "bodies", "trial"}, path.name)
    camera = _made(Camera, told.get("camera", {}), f"{path.name}, [camera]")
    bodies = _bodies(told.get("bodies", {}), f"{path.name}, [bodies]")
    entries = told.get("trial", [])
    if not isinstance(entries, list) or not entries:
        raise ExperimentError(f"{path.name}: holds no [[trial]]; add one with video and kind for each recording")
    return [
        _trial(entry, (bodies, camera), path, f"{path.name}, trial {number}")
        for number, entry in enumerate(entries, start=1)
    ]


def _trial(entry: Any, common: tuple[Mapping[str, Body], Camera], path: Path, place: str) -> Trial:
    """Check one [[trial]] and give it what the whole experiment shares."""
    bodies, camera = common
    camera_keys = {f.name for f in fields(Camera)}
    _only(entry, {"video", "kind", "name", *BODIES, *camera_keys}, place)
    for key in ("video", "kind"):
        if not isinstance(entry.get(key), str):
            raise ExperimentError(f"{place}: {key} must be given as text, got {entry.get(key)!r}")
    video = path.parent / entry["video"]
    if not video.is_file():
        raise ExperimentError(f"{place}: video {entry['video']!r} is not beside the experiment file; check the name")
    own = _bodies({key: entry[key] for key in BODIES if key in entry}, place)
    merged = {name: _overridden(bodies.get(name, Body()), own.get(name, Body())) for name in {*bodies, *own}}
    changes = {key: entry[key] for key in camera_keys if key in entry}
    try:
        return Trial(
            name=str(entry.get("name", video.stem)),
            video=video,
            kind=entry["kind"],
            bodies=merged,
            camera=replace(camera, **changes),
        )
    except (TypeError, ValueError) as error:
        raise ExperimentError(f"{place}: {error}") from error


def _overridden(common: Body, own: Body) -> Body:
    """What a trial says of a body comes before what the experiment says."""
    return Body(mass=own.mass or common.mass, diameter=own.diameter or common.diameter)


def _bodies(told: Any, place: str) -> dict[str, Body]:
    """Check a table of bodies."""
    _only(told, set(BODIES), place)
    return {name: _made(Body, values, f"{place}, {name}") for name, values in told.items()}


def _made(kind: type[Any], values: Any, place: str) -> Any:
    """Make a dataclass from a table of the file, or say which key or value is wrong."""
    _only(values, {f.name for f in fields(kind)}, place)
    try:
        return kind(**values)
    except (TypeError, ValueError) as error:
        raise ExperimentError(f"{place}: {error}") from error


def _only(table: Any, known: set[str], place: str) -> None:
    """Refuse what is no table and keys nobody reads."""
    if not isinstance(table, Mapping):
        raise ExperimentError(f"{place}: must be a table of keys and values, got {table!r}")
    unknown = sorted(set(table) - known)
    if unknown:
        raise ExperimentError(f"{place}: unknown key {unknown[0]!r}; known are {', '.join(sorted(known))}")


def _from_folder(folder: Path, kind: str | None, bodies: Mapping[str, Body], camera: Camera) -> list[Trial]:
    """Take a folder's experiment files, or its videos if there is none."""
    files = sorted(folder.glob("*.toml"))
    if files:
        return [trial for file in files for trial in read_experiment(file)]
    videos = sorted(path for path in folder.iterdir() if path.suffix.lower() in VIDEO_SUFFIXES)
    if not videos:
        raise ExperimentError(f"{folder}: holds no experiment.toml and no video")
    return [_bare(video, kind, bodies, camera) for video in videos]


def _bare(video: Path, kind: str | None, bodies: Mapping[str, Body], camera: Camera) -> Trial:
    """Take a video with what the command line says of it."""
    if kind is None:
        raise ExperimentError(
            f"{video.name}: say what it shows with --kind: plate (a ball on the plate), held (on a ball held still), "
            "two (on a ball at rest)"
        )
    return Trial(name=video.stem, video=video, kind=kind, bodies=bodies, camera=camera)


def _with_unique_names(trials: Sequence[Trial]) -> list[Trial]:
    """Number the trials whose names occur before: every trial needs files of its own."""
    seen: dict[str, int] = {}
    unique = []
    for trial in trials:
        seen[trial.name] = seen.get(trial.name, 0) + 1
        count = seen[trial.name]
        unique.append(trial if count == 1 else replace(trial, name=f"{trial.name}-{count}"))
    return unique


def _is_number(value: object) -> bool:
    """Tell a number from text, a truth value or NaN."""
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < float("inf")


def _one_of(choices: Iterable[set[str]]) -> str:
    """List alternatives for a person."""
    return " or ".join(" + ".join(sorted(keys)) for keys in choices)

"""What is to be measured: an `experiment.toml`, or bare videos with options, as checked dataclasses."""

import os
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import fields, replace
from functools import partial
from glob import glob, has_magic
from itertools import chain
from pathlib import Path
from reprlib import repr as shown
from typing import Any

from experiments.trial import Body, Camera, Trial

__all__ = ["Body", "Camera", "ExperimentError", "Trial", "collect_trials", "read_experiment"]

CAMERA_KEYS = {field.name for field in fields(Camera)}
BODIES = ("upper", "lower", "ball", "cue", "striker", "struck")
LARGEST = 5e6
"""Bytes of an experiment file: tens of thousands of trials."""
VIDEO_SUFFIXES = {".mp4", ".mov", ".m4v", ".avi", ".mkv", ".webm", ".mts", ".3gp", ".wmv"}


class ExperimentError(ValueError):
    """What was asked for cannot be done; the message names the file, the key, the rule and the value."""


def collect_trials(
    sources: Iterable[Path | str],
    *,
    kind: str | None,
    bodies: Mapping[str, Body],
    camera: Camera,
    start_px: tuple[float, float] | None = None,
) -> list[Trial]:
    """Gather the trials of experiment files, video files and folders, in the order given.

    Parameters
    ----------
    sources : paths of experiment.toml files, of videos, or of folders of either; patterns (``*.mp4``)
    kind, bodies, camera, start_px :
        What the command line says; it serves bare videos and overrides nothing in an experiment file.

    Returns
    -------
    list of Trial
        Each with a name of its own.

    Raises
    ------
    ExperimentError
        If a source is missing, holds no recording, or an experiment file breaks a rule.

    Examples
    --------
    >>> collect_trials(["two-06.mp4"], kind="two", bodies={}, camera=Camera())
    Traceback (most recent call last):
    experiments.experiment.ExperimentError: two-06.mp4: no such file or folder; check the spelling
    """
    bare = partial(_bare, kind=kind, bodies=bodies, camera=camera, start_px=start_px)
    trials: list[Trial] = []
    for source in chain.from_iterable(map(_matching, sources)):
        if os.path.isdir(source):
            trials += _from_folder(source, bare)
        elif not os.path.exists(source):
            raise ExperimentError(f"{source}: no such file or folder; check the spelling")
        elif source.suffix.lower() == ".toml":
            trials += read_experiment(source)
        else:
            trials.append(bare(source))
    if not trials:
        raise ExperimentError("nothing to process: name an experiment.toml, a video, or a folder of them")
    return _with_unique_names(trials)


def _matching(source: Path | str) -> list[Path]:
    """Give the files a pattern stands for, where the shell has not done so; names in order."""
    if os.path.exists(source) or not has_magic(str(source)):
        return [Path(source)]
    found = sorted(glob(str(source), recursive=True))
    if not found:
        raise ExperimentError(f"{source}: no file matches this pattern; check the spelling")
    return [Path(path) for path in found]


def read_experiment(path: Path) -> list[Trial]:
    """Read an `experiment.toml`: every key checked, every path relative to the file.

    Raises
    ------
    ExperimentError
        Naming file, key, rule and value.
    """
    if os.path.exists(path) and not path.is_file():
        raise ExperimentError(f"{path}: cannot be read: must be a file of text, but is none")
    if path.is_file() and path.stat().st_size > LARGEST:
        raise ExperimentError(f"{path.name}: must have at most {LARGEST / 1e6:g} MB; split it")
    try:
        told = tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except OSError as error:
        raise ExperimentError(f"{path}: cannot be read: {error.strerror}") from error
    except (ValueError, RecursionError) as error:
        raise ExperimentError(f"{path.name}: is not valid TOML: {error}") from error
    _only(told, {"name", "camera", "bodies", "trial"}, path.name)
    camera = _made(Camera, told.get("camera", {}), f"{path.name}, [camera]")
    bodies = _bodies(told.get("bodies", {}), f"{path.name}, [bodies]")
    entries = told.get("trial", [])
    if not isinstance(entries, list) or not entries:
        raise ExperimentError(
            f"{path.name}: holds no [[trial]]; add one with video and kind for each recording"
        )
    trials: dict[tuple[str, Path], Trial] = {}
    for number, entry in enumerate(entries, start=1):
        place = f"{path.name}, trial {number}"
        for trial in _trials(entry, (bodies, camera), path, place):
            if trials.setdefault((trial.name, trial.video), trial) is not trial:
                raise ExperimentError(
                    f"{place}: {trial.video.name} must be in one trial only, but is in one before as well; "
                    "mend the pattern, or give this trial a name of its own"
                )
    return list(trials.values())


def _trials(entry: Any, common: tuple[Mapping[str, Body], Camera], path: Path, place: str) -> Iterator[Trial]:
    """Check one [[trial]] and give each of its recordings what the whole experiment shares."""
    _only(entry, {"video", "kind", "name", "start_px", *BODIES, *CAMERA_KEYS}, place)
    for key in ("video", "kind", "name"):
        if not isinstance(entry.get(key, "" if key == "name" else None), str):
            raise ExperimentError(f"{place}: {key} must be given as text, got {shown(entry.get(key))}")
    videos = _videos(entry["video"], path, place)
    if "name" in entry and len(videos) > 1:
        raise ExperimentError(
            f"{place}: name must be that of one recording, but {entry['video']!r} matches {len(videos)}; "
            "leave it out, then each is named after its file"
        )
    for video in videos:
        yield _trial(entry, common, video, place)


def _videos(told: str, path: Path, place: str) -> list[Path]:
    """Give the recordings that a path or a pattern stands for, in order of their names."""
    folder = path.parent
    if os.path.isfile(folder / told):
        return [folder / told]
    found = sorted(glob(told, root_dir=folder)) if has_magic(told) else []
    videos = [folder / name for name in found if Path(name).suffix.lower() in VIDEO_SUFFIXES]
    if not videos:
        missing = f"no video matches {told!r}" if has_magic(told) else f"there is no video {told!r}"
        raise ExperimentError(f"{place}: {missing}; its path counts from the folder of {path.name}")
    return videos


def _trial(entry: Any, common: tuple[Mapping[str, Body], Camera], video: Path, place: str) -> Trial:
    """Give one recording what its [[trial]] says of it, and what the whole experiment shares."""
    bodies, camera = common
    own = _bodies({key: entry[key] for key in BODIES if key in entry}, place)
    merged = {name: _overridden(bodies.get(name, Body()), own.get(name, Body())) for name in {*bodies, *own}}
    changes = {key: entry[key] for key in CAMERA_KEYS if key in entry}
    try:
        return Trial(
            name=entry.get("name", video.stem),
            video=video,
            kind=entry["kind"],
            bodies=merged,
            camera=replace(camera, **changes),
            start_px=entry.get("start_px"),
        )
    except (TypeError, ValueError) as error:
        raise ExperimentError(f"{place}: {error}") from error


def _overridden(common: Body, own: Body) -> Body:
    """Prefer what a trial says of a body to what the experiment says."""
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
        raise ExperimentError(f"{place}: must be a table of keys and values, got {shown(table)}")
    unknown = sorted(set(table) - known)
    if unknown:
        raise ExperimentError(f"{place}: unknown key {unknown[0]!r}; known are {', '.join(sorted(known))}")


def _from_folder(folder: Path, bare: Callable[[Path], Trial]) -> list[Trial]:
    """Take a folder's experiment files, or its videos if there is none; hidden files are no recordings."""
    visible = sorted(path for path in folder.iterdir() if not path.name.startswith("."))
    files = [path for path in visible if path.suffix.lower() == ".toml"]
    if files:
        return [trial for file in files for trial in read_experiment(file)]
    videos = [path for path in visible if path.suffix.lower() in VIDEO_SUFFIXES]
    if not videos:
        raise ExperimentError(f"{folder}: holds no experiment.toml and no video")
    return [bare(video) for video in videos]


def _bare(video: Path, *, kind: str | None, **told: Any) -> Trial:
    """Take a video with what the command line says of it."""
    if kind is None:
        raise ExperimentError(
            f"{video.name}: say what it shows with --kind: plate (a ball on the plate), "
            "held (on a ball held still), two (on a ball at rest), shot (a cue ball struck), "
            "pair (two discs or balls that meet)"
        )
    try:
        return Trial(name=video.stem, video=video, kind=kind, **told)
    except ValueError as error:
        raise ExperimentError(
            f"{video.name}: {error}; rename it or describe it in an experiment.toml"
        ) from error


def _with_unique_names(trials: Sequence[Trial]) -> list[Trial]:
    """Give every trial a name, and so files, of its own, even where case is ignored."""
    taken: set[str] = set()
    unique = []
    for trial in trials:
        name, count = trial.name, 1
        while name.casefold() in taken:
            count += 1
            name = f"{trial.name}-{count}"
        taken.add(name.casefold())
        unique.append(replace(trial, name=name))
    return unique

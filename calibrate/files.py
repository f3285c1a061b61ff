"""Files that appear whole or not at all."""

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


def write_whole(path: str | Path, content: str | bytes) -> Path:
    r"""Write a file beside its place, then rename it there, so that no reader ever sees half of it.

    Parameters
    ----------
    path : str or Path
        The file to write; its folder is made when missing.
    content : str or bytes
        All of it. Text is written as UTF-8 with line ends as given.

    Returns
    -------
    Path
        `path`, as a `Path`.

    Examples
    --------
    >>> import tempfile
    >>> folder = tempfile.mkdtemp()
    >>> write_whole(f"{folder}/deep/note.txt", "done\n").read_text()
    'done\n'
    """
    with written_beside(path) as beside:
        beside.write_bytes(content.encode() if isinstance(content, str) else content)
    return Path(path)


@contextmanager
def written_beside(path: str | Path) -> Iterator[Path]:
    """Give a file beside a place to write to; when all went well it is renamed there, else it is removed.

    Parameters
    ----------
    path : str or Path
        Where the file shall appear; its folder is made when missing.

    Yields
    ------
    Path
        An empty file in the same folder, with the same ending.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    descriptor, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.stem}.", suffix=path.suffix)
    os.close(descriptor)
    try:
        yield Path(name)
        os.chmod(name, 0o666 & ~_umask())
        os.replace(name, path)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise


def _umask() -> int:
    """Permission bits this process withholds; a temporary file would otherwise stay private to its owner."""
    mask = os.umask(0)
    os.umask(mask)
    return mask

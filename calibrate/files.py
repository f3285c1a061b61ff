"""Files that appear whole or not at all."""

import os
import tempfile
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
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    data = content.encode() if isinstance(content, str) else content
    descriptor, beside = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with os.fdopen(descriptor, "wb") as file:
            file.write(data)
        os.chmod(beside, 0o666 & ~_umask())
        os.replace(beside, path)
    except BaseException:
        Path(beside).unlink(missing_ok=True)
        raise
    return path


def _umask() -> int:
    """Permission bits this process withholds; a temporary file would otherwise stay private to its owner."""
    mask = os.umask(0)
    os.umask(mask)
    return mask

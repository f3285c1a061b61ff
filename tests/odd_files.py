"""Files as a stranger may send them: copies of good ones, damaged, the same every time."""

from collections.abc import Callable, Iterator

import numpy as np

Damage = Callable[[bytes, np.random.Generator], bytes]

EXTREMES = (
    b"\x00\x00\x00\x00",
    b"\xff\xff\xff\xff",
    b"\x7f\xff\xff\xff",
    b"\x80\x00\x00\x00",
    b"\x00\x00\x00\x01",
)
TOKENS = (
    *(b"nan", b"inf", b"-inf", b"1e999", b"-1e-320", b"0", b"-1", b"99999999999999999999", b"1_0", b"0x1F"),
    *(b"", b" ", b'"', b"'", b",", b";", b"\t", b"\n", b"\r", b"\x00", b"\xff\xfe", b"\xef\xbb\xbf", b"=1+1"),
    *(
        b"1,5",
        b"1.234,5",
        b"kind",
        b"two",
        b"shot",
        b"ok",
        b"failed",
        b"[",
        b"]",
        b"{",
        b"}",
        b"[[trial]]",
        b"#",
    ),
    *("µ−°😀\u2028".encode(), b"../../x", b"/etc/passwd", b"true", b"2020-01-01", b"9" * 400, b"x" * 5000),
)


def flipped(content: bytes, rng: np.random.Generator) -> bytes:
    """Change some bytes."""
    data = np.frombuffer(content, np.uint8).copy()
    data[rng.integers(len(data), size=rng.integers(1, 30))] = rng.integers(256, dtype=np.uint8)
    return data.tobytes()


def cut(content: bytes, rng: np.random.Generator) -> bytes:
    """Break off."""
    return content[: rng.integers(len(content))]


def holed(content: bytes, rng: np.random.Generator) -> bytes:
    """Lose a piece."""
    start, end = _piece(content, rng)
    return content[:start] + content[end:]


def blanked(content: bytes, rng: np.random.Generator) -> bytes:
    """Read zeros for a piece."""
    start, end = _piece(content, rng)
    return content[:start] + bytes(end - start) + content[end:]


def doubled(content: bytes, rng: np.random.Generator) -> bytes:
    """Hold a piece twice."""
    start, end = _piece(content, rng)
    return content[:end] + content[start:]


def extreme(content: bytes, rng: np.random.Generator) -> bytes:
    """Hold the largest, smallest or no number somewhere, most often where a header may be."""
    place = int(rng.choice([rng.integers(64), rng.integers(1, 3000), -rng.integers(1, 3000)])) % len(content)
    number = EXTREMES[rng.integers(len(EXTREMES))]
    return content[:place] + number + content[place + len(number) :]


def retyped(content: bytes, rng: np.random.Generator) -> bytes:
    """Replace some words or numbers by others that mean something."""
    for _ in range(rng.integers(1, 4)):
        start = int(rng.integers(len(content) + 1))
        end = start + int(rng.integers(6))
        content = content[:start] + TOKENS[rng.integers(len(TOKENS))] + content[end:]
    return content


def replaced(content: bytes, rng: np.random.Generator) -> bytes:
    """Put something else where a whole value stood."""
    marks = [place for place, byte in enumerate(content) if byte in b',;\t\n= []"']
    first = int(rng.integers(len(marks) - 1))
    return content[: marks[first] + 1] + TOKENS[rng.integers(len(TOKENS))] + content[marks[first + 1] :]


OF_FILMS: tuple[Damage, ...] = (flipped, cut, holed, blanked, doubled, extreme)
OF_TEXT: tuple[Damage, ...] = (flipped, cut, holed, blanked, doubled, retyped, replaced, replaced)


def damaged(
    good: dict[str, bytes], ways: tuple[Damage, ...], count: int, seed: int
) -> Iterator[tuple[str, bytes]]:
    """Yield names and contents of damaged copies, of each good file and in each way in turn."""
    rng = np.random.default_rng(seed)
    names = list(good)
    for number in range(count):
        name = names[number % len(names)]
        stem, _, ending = name.partition(".")
        yield f"{stem}-{number:04d}.{ending}", ways[number // len(names) % len(ways)](good[name], rng)


def _piece(content: bytes, rng: np.random.Generator) -> tuple[int, int]:
    start = int(rng.integers(len(content)))
    return start, start + int(rng.integers(1, max(2, len(content) // 8)))

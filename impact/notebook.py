"""How results show in a notebook: small HTML tables."""

from collections.abc import Iterable, Sequence
from html import escape


def html_table(caption: str, rows: Iterable[Sequence[str]], header: Sequence[str] = ()) -> str:
    """Write an HTML table, every text escaped; the first cell of each row is its name, the last fills it.

    Examples
    --------
    >>> html_table("a < b", [("speed", "3 m/s")])
    '<table><caption>a &lt; b</caption><tr><th>speed</th><td>3 m/s</td></tr></table>'
    """
    head = "".join(f"<th>{escape(cell)}</th>" for cell in header)
    lines = [f"<tr>{head}</tr>"] if head else []
    for name, *cells in rows:
        wide = f' colspan="{len(header) - len(cells)}"' if len(header) - len(cells) > 1 else ""
        row = "".join(f"<td>{escape(cell)}</td>" for cell in cells[:-1])
        row += f"<td{wide}>{escape(cells[-1])}</td>"
        lines.append(f"<tr><th>{escape(name)}</th>{row}</tr>")
    return f"<table><caption>{escape(caption)}</caption>{''.join(lines)}</table>"

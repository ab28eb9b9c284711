"""Tables for people: one description of what is shown, as plain text for a terminal and as HTML for a notebook.

What is shown is a sequence of parts: a Grid, a line of text, or lines folded under a summary. Names come from files
and are anybody's: control characters never reach a terminal, no name begins a line of its own, and HTML is escaped. It
has no colours, so that it reads on light and dark, no script, and loads nothing.
"""

from __future__ import annotations

import os
import sys
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import TypeVar, cast

WIDTH = 100  # columns, at most; fewer in a narrower terminal
LEAST_WIDTH = 20  # columns to which text is folded
NARROWEST = 12  # to which a column of words is cut, to meet it
FORMULA = ("=", "+", "-", "@", "\t", "\n")
LONGEST = 40  # characters of a name in a caption
_LEFT = "text-align:left"
_RIGHT = "text-align:right"


@dataclass(frozen=True)
class Table:
    """Rows of cells under heads."""

    heads: Sequence[str]  # Of the columns
    rows: Sequence[Sequence[str]]  # Cells
    caption: str = ""  # Line above; empty for none
    right: Sequence[int] = ()  # Columns of figures: set to the right, never cut


@dataclass(frozen=True)
class Details:
    """Lines under a summary: a terminal shows the summary alone, a notebook opens it."""

    summary: str
    lines: tuple[str, ...]


Block = Table | Details | str
T = TypeVar("T")


def clean(text: str) -> str:
    """Return text as one line that steers nothing: each control character, line end and override is replaced."""
    return text if text.isprintable() else "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in text)


def csv_cell(text: str) -> str:
    """Return text as a cell of CSV that no spreadsheet runs: one that starts like a formula gets an apostrophe."""
    plain = text.replace("\r", "\n")  # csv quotes the latter alone
    return f"'{plain}" if plain.startswith(FORMULA) and len(plain) > 1 else plain


def cleaned(content: T) -> T:
    """Return the content of a file, lists and objects too, with every text of it clean."""
    found: object = content
    if isinstance(content, str):
        found = clean(content)
    elif isinstance(content, Mapping):
        found = {clean(key) if isinstance(key, str) else key: cleaned(part) for key, part in content.items()}
    elif isinstance(content, list | tuple):
        found = [cleaned(part) for part in content]
    return cast("T", found)


def short(text: str, longest: int = LONGEST) -> str:
    """Return a name cut to what a line can show."""
    return text if len(text) <= longest else f"{text[: longest - 1]}…"


def ending(path: str, longest: int = LONGEST) -> str:
    """Return the end of a path, cut to what a line can show."""
    return path if len(path) <= longest else f"…{path[len(path) - longest + 1 :]}"


def terminal_width() -> int:
    """Return the columns of the terminal, 20 of a narrower one; 0 where there is none, or it does not say."""
    try:
        columns = os.get_terminal_size(sys.stdout.fileno()).columns
    except (OSError, ValueError):
        return 0
    return max(columns, LEAST_WIDTH) if columns else 0


def aligned(
    rows: Sequence[Sequence[str]],
    heads: Sequence[str] | None = None,
    right: Sequence[int] = (),
    width: int | None = None,
) -> str:
    """Return rows as aligned columns; those that do not fit go below, after the first column and the axis again.

    Parameters
    ----------
    rows : sequence of sequence of str
        Cells.
    heads : sequence of str, optional
        Column heads.
    right : sequence of int
        Columns set to the right.
    width : int, optional
        To meet; columns of words are cut, those set to the right never. Without it, nothing is cut.
    """
    cells = [[clean(cell) for cell in row] for row in ([heads] if heads else []) + list(rows)]
    if not cells:
        return ""
    widths = [max(len(row[i]) for row in cells) for i in range(len(cells[0]))]
    if width is not None:
        widths = _narrowed(widths, right, width)
    limit = width or terminal_width()
    first = [0, 1] if heads and list(heads[1:2]) == ["axis"] else [0]  # again in each group
    groups: list[list[int]] = [[]]
    for i in range(len(widths)):
        if limit and len(groups[-1]) > len(first) and sum(widths[j] + 2 for j in groups[-1]) + widths[i] > limit:
            groups.append([*first])
        groups[-1].append(i)
    blocks = []
    for group in groups:
        lines = []
        for row in cells:
            cut = [row[i].rjust(widths[i]) if i in right else short(row[i], widths[i]).ljust(widths[i]) for i in group]
            lines.append("  ".join(cut).rstrip())
        blocks.append("\n".join(lines))
    return "\n\n".join(blocks)


def _narrowed(widths: list[int], right: Sequence[int], width: int) -> list[int]:
    """Take from the widest column of words, again and again, until all fit or none can give more."""
    found = list(widths)
    words = [i for i in range(len(found)) if i not in right]
    while sum(found) + 2 * (len(found) - 1) > width:
        widest = max(words, key=lambda i: found[i], default=None)
        if widest is None or found[widest] <= NARROWEST:
            break
        found[widest] -= 1
    return found


def text(parts: Iterable[Block]) -> str:
    """Return the parts as text, folded and cut to the terminal, and to 100 columns."""
    columns = min(terminal_width() or WIDTH, WIDTH)

    def folded(line: str) -> str:
        return textwrap.fill(clean(line), columns, subsequent_indent="    ", break_on_hyphens=False)

    lines = []
    for part in parts:
        if isinstance(part, Details):
            lines.append(folded(part.summary))
        elif isinstance(part, str):
            lines.append(folded(part))
        else:
            lines += [folded(part.caption)] if part.caption else []
            lines.append(textwrap.indent(aligned(part.rows, part.heads, part.right, columns - 2), "  "))
    return "\n".join(lines)


def html(parts: Iterable[Block], figure: str = "") -> str:
    """Return the parts as HTML for a notebook, every text of them escaped, below a figure: markup as it is."""
    return f"<div>\n{figure}{''.join(_html(part) for part in parts)}</div>"


def _html(part: Block) -> str:
    if isinstance(part, str):
        return f'<div style="{_LEFT};white-space:pre-wrap;overflow-wrap:anywhere">{_safe(part)}</div>\n'
    if isinstance(part, Details):
        items = "".join(f"<li>{_safe(line)}</li>" for line in part.lines)
        return f'<details style="{_LEFT}"><summary>{_safe(part.summary)}</summary><ul>{items}</ul></details>\n'
    caption = f'<caption style="{_LEFT};caption-side:top">{_safe(part.caption)}</caption>' if part.caption else ""
    heads = "".join(_cell(head, i in part.right, 'th scope="col"') for i, head in enumerate(part.heads))
    rows = "".join(
        f"<tr>{''.join(_cell(cell, i in part.right) for i, cell in enumerate(row))}</tr>\n" for row in part.rows
    )
    return f'<table style="margin:0.5em 0">{caption}<thead><tr>{heads}</tr></thead>\n<tbody>\n{rows}</tbody></table>\n'


def _cell(content: str, right: bool, tag: str = "td") -> str:
    style = f"{_RIGHT};white-space:nowrap" if right else f"{_LEFT};overflow-wrap:anywhere;max-width:32em"
    return f'<{tag} style="{style}">{_safe(content)}</{tag[:2]}>'


def _safe(content: str) -> str:
    return escape(clean(content))

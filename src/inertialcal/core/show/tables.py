"""Tables for people: one description of what is shown, as plain text for a terminal and as HTML for a notebook.

What is shown is a sequence of parts: a Grid, a line of text, or lines folded under a summary. Names come from files
and are anybody's: control characters never reach a terminal, no name begins a line of its own, and HTML is escaped. It
has no colours, so that it reads on light and dark, no script, and loads nothing.
"""

from __future__ import annotations

import re
import shutil
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import TypeVar, cast

SHORT = 12  # rows of a table that a notebook shows open where there are many
WIDTH = 100  # columns, at most; fewer in a narrower terminal
UNKNOWN_WIDTH = 80  # columns where nothing says how many there are
PROSE_WIDTH = 110  # columns of sentences, at most
HANG = 2  # blanks before the second and later lines of a first cell
LEAST_WIDTH = 20  # columns to which text is folded
FOLDED = 12  # to which one is folded, where no word of it is longer
BLANK, BLANK_OR_NAME = re.compile(" "), re.compile(r" |(?<=_)")  # where a cell may be broken
BOUND = "\N{NO-BREAK SPACE}"
FIGURE = re.compile(r"(?<=\d) (?=\S)|(?<=±) | (?=±)|(?<=\.\.) | (?=\.\.)")  # blanks inside a figure with its unit
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
    folded: bool = False  # A notebook shows its caption with the count of rows, and opens it


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
    """Return the columns that COLUMNS says, or those of the terminal, or 80; at least 20."""
    return max(shutil.get_terminal_size((UNKNOWN_WIDTH, 1)).columns, LEAST_WIDTH)


def wrapped(text: str, indent: str = "  ", widest: int | None = PROSE_WIDTH) -> str:
    """Return text folded to the terminal and to 110 columns, the first line flush and the rest indented.

    Names, paths and figures with their units stay whole.
    """
    found = textwrap.fill(
        _bound(clean(text)), min(terminal_width(), widest or terminal_width()), subsequent_indent=indent,
        break_on_hyphens=False, break_long_words=False,
    )  # fmt: skip
    return found.replace(BOUND, " ")


def _bound(text: str) -> str:
    return FIGURE.sub(BOUND, text)


def aligned(
    rows: Sequence[Sequence[str]],
    heads: Sequence[str] | None = None,
    right: Sequence[int] = (),
    width: int | None = None,
) -> str:
    """Return rows as aligned columns that fit the terminal.

    Words are folded inside their column; columns that do not fit go below, after the first and the axis again.

    Parameters
    ----------
    rows : sequence of sequence of str
        Cells.
    heads : sequence of str, optional
        Column heads.
    right : sequence of int
        Columns set to the right.
    width : int, optional
        To meet, in place of that of the terminal; words longer than a name can be are then cut.
    """
    cells = [[clean(cell) for cell in row] for row in ([heads] if heads else []) + list(rows)]
    if not cells:
        return ""
    if width is not None:
        cells = [[cell if i in right else _cut(cell) for i, cell in enumerate(row)] for row in cells]
    limit = terminal_width() if width is None else width
    columns = list(zip(*cells, strict=True))
    widths = [max(map(len, column)) for column in columns]
    first = [0, 1] if heads and list(heads[1:2]) == ["axis"] else [0]  # again in each group
    least = [widths[i] if i in right else _least(column, BLANK) for i, column in enumerate(columns)]
    beside = sum(least[i] + 2 for i in first[1:]) + max(least[len(first) :], default=-2) + 2
    if 0 not in right and least[0] + beside > limit:  # names are broken, sooner than a column left wide
        least[0] = _least(columns[0], BLANK_OR_NAME)
    groups: list[list[int]] = [[]]
    for i in range(len(widths)):
        if len(groups[-1]) > len(first) and sum(least[j] + 2 for j in groups[-1]) + least[i] > limit:
            groups.append([*first])
        groups[-1].append(i)
    return "\n\n".join(_block(cells, group, widths, least, right, limit) for group in groups)


def _block(
    cells: Sequence[Sequence[str]],
    group: Sequence[int],
    widths: Sequence[int],
    least: Sequence[int],
    right: Sequence[int],
    limit: int,
) -> str:
    """Return some columns beside each other, the words of them folded where they must be."""
    wide = [widths[i] for i in group]
    fitted = _narrowed(wide, [least[i] for i in group], limit)
    if fitted != wide:  # the widest words get what the others leave
        shown = [[_cell_lines(row[i], fitted[j], i in right, i == 0) for row in cells] for j, i in enumerate(group)]
        fitted = [max(len(line) for lines in column for line in lines) for column in shown]
        widest = max(range(len(group)), key=lambda j: wide[j] - fitted[j])
        spare = max(limit - sum(fitted) - 2 * (len(group) - 1), 0)
        fitted[widest] = min(fitted[widest] + spare, wide[widest])
    lines = []
    for row in cells:
        parts = [_cell_lines(row[i], fitted[j], i in right, i == 0) for j, i in enumerate(group)]
        lines += ["  ".join(line).rstrip() for line in _side_by_side(parts, fitted)]
    return "\n".join(lines)


def _cut(cell: str) -> str:
    return " ".join(short(word) for word in cell.split(" ")) if len(cell) > LONGEST else cell


def _least(column: Sequence[str], breaks: re.Pattern[str]) -> int:
    """Return to which width a column of words can be folded: no word, and no figure with its unit, is broken."""
    return max(_least_of(cell, breaks) for cell in column)


def _least_of(cell: str, breaks: re.Pattern[str]) -> int:
    if len(cell) <= FOLDED:
        return len(cell)
    words = breaks.split(_bound(cell.strip()))
    blanks = len(cell) - len(cell.lstrip())
    return max(FOLDED, blanks + len(words[0]), *(blanks + HANG + len(word) for word in words[1:]))


def _cell_lines(cell: str, width: int, right: bool, first: bool) -> list[str]:
    """Return a cell in lines of a width; in the first column the second and later lines stand in."""
    if right or len(cell) <= width:
        return [cell.rjust(width) if right else cell]
    blanks = " " * (len(cell) - len(cell.lstrip()))
    below = blanks + " " * (HANG * first)
    found = textwrap.wrap(
        _bound(cell.strip()), width, initial_indent=blanks, subsequent_indent=below,
        break_on_hyphens=False, break_long_words=False,
    )  # fmt: skip
    lines = []
    for line in found:
        rest = line
        while first and len(rest) > width and (at := rest.rfind("_", len(below), width) + 1):
            lines.append(rest[:at])
            rest = below + rest[at:]
        lines.append(rest)
    return [line.replace(BOUND, " ") for line in lines]


def _side_by_side(cells: Sequence[Sequence[str]], widths: Sequence[int]) -> list[list[str]]:
    """Return the lines of cells that stand in one row, each filled to the width of its column."""
    high = max(map(len, cells))
    filled = [[*cell, *[""] * (high - len(cell))] for cell in cells]
    return [[part.ljust(width) for part, width in zip(line, widths, strict=True)] for line in zip(*filled, strict=True)]


def _narrowed(widths: list[int], least: list[int], width: int) -> list[int]:
    """Take from the widest column that can give, again and again, until all fit or none can give more."""
    found = list(widths)
    while sum(found) + 2 * (len(found) - 1) > width:
        widest = max((i for i in range(len(found)) if found[i] > least[i]), key=found.__getitem__, default=None)
        if widest is None:
            break
        found[widest] -= 1
    return found


def text(parts: Iterable[Block]) -> str:
    """Return the parts as text, folded and cut to the terminal, and to 100 columns."""
    columns = min(terminal_width(), WIDTH)

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
    if part.folded:
        caption = ""
    table = f'<table style="margin:0.5em 0">{caption}<thead><tr>{heads}</tr></thead>\n<tbody>\n{rows}</tbody></table>\n'
    if not part.folded:
        return table
    summary = f"{part.caption or 'table'}: {len(part.rows)} row{'s' * (len(part.rows) != 1)}"
    return f'<details style="{_LEFT}"><summary>{_safe(summary)}</summary>{table}</details>\n'


def _cell(content: str, right: bool, tag: str = "td") -> str:
    style = f"{_RIGHT};white-space:nowrap" if right else f"{_LEFT};overflow-wrap:break-word;max-width:32em"
    return f'<{tag} style="{style}">{_safe(content)}</{tag[:2]}>'


def _safe(content: str) -> str:
    return escape(clean(content))

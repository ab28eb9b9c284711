"""What a terminal shows of a long text: a screen of it, the rest counted; verdicts in colour, with a sign.

Into a file or a pipe goes the whole text, plain. ``--all`` shows it whole on a terminal too; NO_COLOR, and a terminal
that is called dumb, leave it plain.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar

ROWS = 40  # that a result takes on a terminal
LEAST = 2  # of them, for each part
STYLES = {  # word -> number of its colour (ECMA-48), sign before a verdict
    "PASS": ("32", "\N{CHECK MARK}"), "FAIL": ("31", "\N{BALLOT X}"), "INCONCLUSIVE": ("33", "?"), "OPEN": ("33", "?"),
    "error:": ("31", ""), "warning:": ("33", ""), "NO": ("31", ""),
}  # fmt: skip
WORD = re.compile(rf"(?<![\w/.-])({'|'.join(STYLES)})(?![\w/.-])")
OVERALL = re.compile(r"^(overall: |closed loop[^:]*: )(?=(PASS|FAIL|INCONCLUSIVE|OPEN)\b)", re.MULTILINE)
_whole: ContextVar[bool] = ContextVar("whole", default=False)


@contextmanager
def shown_whole(said: bool | None) -> Iterator[None]:
    """Show texts whole inside, if that is said."""
    token = _whole.set(bool(said))
    try:
        yield
    finally:
        _whole.reset(token)


def all_asked() -> bool:
    """Tell whether texts are to be shown whole: ``--all``."""
    return _whole.get()


def folds() -> bool:
    """Tell whether long texts are folded: on a terminal, where not all was asked for."""
    return sys.stdout.isatty() and not all_asked()


def folded(text: str, rows: int = ROWS) -> str:
    """Return a text in at most so many rows on a terminal, the last of them with the count of the rest."""
    lines = text.split("\n")
    if not folds() or len(lines) <= rows:
        return text
    kept = max(rows - 1, 1)
    return "\n".join([*lines[:kept], f"  ... {len(lines) - kept} more rows: --all"])


def screen(parts: Sequence[str]) -> str:
    """Return the parts of a result, each after an empty line: on a terminal they share a screen.

    Short parts stay whole, and long ones share what these leave. Empty ones are left out.
    """
    there = [part for part in parts if part]
    sizes = [part.count("\n") + 1 for part in there]
    room, rows = ROWS - len(there) + 1, [0] * len(there)
    for done, i in enumerate(sorted(range(len(there)), key=sizes.__getitem__)):
        rows[i] = max(min(sizes[i], room // (len(there) - done)), LEAST)
        room -= rows[i]
    return "\n\n".join(map(folded, there, rows))


def say(text: str) -> None:
    """Print a text; its verdicts in colour and with their sign where the terminal has both."""
    print(coloured(text) if _has_colours() else text)


def coloured(text: str) -> str:
    """Return a text with its verdicts in colour; those over all with a sign, where the encoding has it."""

    def signed(found: re.Match[str]) -> str:
        return found[1] + (f"{sign} " if _encodes(sign := STYLES[found[2]][1]) else "")

    return WORD.sub(lambda found: f"\x1b[{STYLES[found[1]][0]}m{found[1]}\x1b[0m", OVERALL.sub(signed, text))


def _has_colours() -> bool:
    named = os.environ.get("TERM", "")
    return sys.stdout.isatty() and not os.environ.get("NO_COLOR") and named not in ("", "dumb")


def encodes_braille() -> bool:
    """Tell whether standard output can write the signs that a plot of dots is made of."""
    return _encodes(chr(0x28FF))


def _encodes(sign: str) -> bool:
    try:
        sign.encode(sys.stdout.encoding or "ascii")
    except (UnicodeEncodeError, LookupError):
        return False
    return True

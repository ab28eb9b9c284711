"""Progress of long work: a bar on a terminal, plain lines elsewhere; always on standard error."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from ...core.show.compiling import compiling
from .output import clean

COMPILING = "compiling, once: the next command starts without"
Tell = Callable[[int, int, str], None]


@contextmanager
def progress(quiet: bool) -> Iterator[Tell]:
    """Yield a function of (done, in all, what comes next)."""
    if quiet:
        yield lambda done, total, what: None
    elif not sys.stderr.isatty():
        yield lambda done, total, what: print(f"{done}/{total} {clean(what)}", file=sys.stderr)
    else:
        from rich.console import Console
        from rich.markup import escape
        from rich.progress import Progress

        with Progress(console=Console(stderr=True), transient=True) as bar:
            task = bar.add_task("")
            yield lambda done, total, what: bar.update(
                task, completed=done, total=total, description=escape(clean(what))
            )


def say_compiling() -> None:
    """Have it said on a terminal where loops are compiled for longer than a second."""
    if sys.stderr.isatty():
        compiling.say = lambda: print(COMPILING, file=sys.stderr)

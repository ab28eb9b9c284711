"""A file that is complete or not there: written aside, then put in its place; never over its own input."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from ...core.errors import DataError, StoreError
from ...core.interruption import interruption


@contextmanager
def atomic_write(path: str | os.PathLike[str], inputs: Iterable[str | os.PathLike[str]] = ()) -> Iterator[Path]:
    """Yield a path to write to; what was written takes the place of ``path`` when all went well.

    Parameters
    ----------
    path : path
        Where the file shall be; one that is there is replaced.
    inputs : iterable of path
        Files that it may not replace, because they were read for it.

    Raises
    ------
    DataError
        ``overwrites_input``, if ``path`` is one of the inputs, also by a link.
    StoreError
        ``not_written``, if the folder is not there or cannot be written.
    """
    target = Path(path)
    for given in inputs:
        _refuse_same(target, Path(given))
    aside = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        if "\0" in str(target):
            raise OSError(0, "a nul in the name")
        if target.is_dir():
            raise IsADirectoryError(0, "this is a folder")
        if target.exists() and not target.is_file():
            raise OSError(0, "this is a device or a pipe, not a file")
        if not target.parent.is_dir():
            raise FileNotFoundError(0, f"there is no folder {str(target.parent)!r}")
        yield aside
        with interruption.held():
            aside.replace(target)
            interruption.note(target)
    except OSError as error:
        raise StoreError(
            f"cannot be written: {error.strerror or error}", where=str(target), code="not_written"
        ) from None
    finally:
        _remove(aside)


def _refuse_same(target: Path, given: Path) -> None:
    try:
        same = target.samefile(given)
    except (OSError, ValueError):  # one of them is not there
        return
    if same:
        raise DataError(
            "the output would overwrite the input",
            where=str(target),
            why="a recording cannot be replaced",
            do="Choose another name for -o",
            code="overwrites_input",
        )


def _remove(aside: Path) -> None:
    try:
        aside.unlink(missing_ok=True)
    except (OSError, ValueError):
        return

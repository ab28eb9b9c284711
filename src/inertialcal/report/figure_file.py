"""A figure as a file: PNG, SVG or PDF by the ending of its name; complete or not there, never over an input.

No file holds the date on which it was written: the same result gives the same bytes.
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ..core.errors import UsageError
from ..files.write.atomic import atomic_write

if TYPE_CHECKING:
    from .figures.drawing.picture import Picture

# ending -> what of its metadata is left out, because it changes from day to day
FORMATS: dict[str, tuple[str, ...]] = {".png": (), ".svg": ("Date",), ".pdf": ("CreationDate",)}
DPI = 200
MOST = 3  # pictures on one file: the axes of one test


def check_ending(path: str | os.PathLike[str]) -> str:
    """Return the ending of a figure's file.

    Raises
    ------
    UsageError
        ``unsupported_format``, if no figure is written with that ending.
    """
    ending = Path(path).suffix.lower()
    if ending not in FORMATS:
        raise UsageError(
            f"-o {os.fspath(path)!r}: cannot write a figure as {ending or 'a file without an ending'}",
            do=f"End the name with one of: {', '.join(FORMATS)}",
            code="unsupported_format",
        )
    return ending


def write_figure(
    path: str | os.PathLike[str], pictures: Sequence[Picture], inputs: Iterable[str | os.PathLike[str]] = ()
) -> None:
    """Write pictures to a file, side by side.

    Parameters
    ----------
    path : path
        Where; one that is there is replaced.
    pictures : sequence of Picture
        At least one, at most three.
    inputs : iterable of path
        Files that it may not replace.

    Raises
    ------
    UsageError, DataError, StoreError
        As `check_ending` and ``files.write.atomic``.
    """
    from matplotlib import rc_context  # noqa: PLC0415 - heavy: only where one is drawn

    from .figures.drawing.picture import on_new_figure, side_by_side  # noqa: PLC0415 - heavy
    from .figures.drawing.svg import SALT  # noqa: PLC0415 - heavy

    ending = check_ending(path)
    shown = pictures[:MOST]
    with atomic_write(path, inputs) as aside, rc_context({"svg.hashsalt": SALT}), warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing")  # a name in a script that the font has not
        figure = on_new_figure(shown[0], titled=True) if len(shown) == 1 else side_by_side(shown)
        metadata = dict.fromkeys(FORMATS[ending])
        figure.savefig(aside, format=ending[1:], dpi=DPI, metadata=metadata)

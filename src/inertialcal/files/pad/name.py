"""Names of acceleration files in the public archive: START, sign, STOP, sensor.

``2014_10_22_09_36_36.324-2014_10_22_09_37_35.317.121f03006`` and, beside it, the same with ``.header`` behind. ``+``
says that the file goes on where the one before it ended, ``-`` that there is a gap. Times are UTC; the stop is that
of the last sample.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from ...core.times import read_instant

HEADER = ".header"
STAMP = r"[0-9]{4}(?:_[0-9]{2}){5}(?:\.[0-9]{1,9})?"
NAME = re.compile(rf"(?P<start>{STAMP})(?P<sign>[+-])(?P<stop>{STAMP})\.(?P<sensor>[A-Za-z0-9_]+)")


@dataclass(frozen=True)
class PadName:
    """What the name of a data file says.

    Parameters
    ----------
    start, stop : int
        First and last sample [ns since 1970 UTC].
    contiguous : bool
        Whether the file goes on where the one before it ended.
    sensor : str
        Behind the last dot.
    """

    start: int
    stop: int
    contiguous: bool
    sensor: str


def parse_name(name: str) -> PadName | None:
    """Return what a file's name says; None where it is not of the archive's form, or names no possible time."""
    match = NAME.fullmatch(name.removesuffix(HEADER))
    if match is None:
        return None
    try:
        start, stop = read_instant(match["start"]), read_instant(match["stop"])
    except ValueError:
        return None
    return PadName(start, stop, match["sign"] == "+", match["sensor"])


@dataclass(frozen=True)
class Pair:
    """A data file and its header."""

    data: Path
    header: Path

    @property
    def name(self) -> PadName | None:
        """What the name says; None where it is not of the archive's form."""
        return parse_name(self.data.name)

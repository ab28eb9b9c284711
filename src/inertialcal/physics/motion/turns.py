"""Programme of a turned mass: its runs, and their CSV with a row a run.

Rates are positive in the sense of the orbit; angles are counted from the input axis in that sense. Numbers are written
with all digits of their bits.
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable
from dataclasses import dataclass

WRITTEN = {"start": "s", "stop": "s", "rate": "deg/s", "angle": "deg"}  # columns, with the unit of the file


@dataclass(frozen=True)
class Turn:
    """One run of the programme."""

    run: str  # Its name
    start: float  # On the clock of the programme [s]
    stop: float  # [s]
    rate: float  # Signed, positive in the sense of the orbit [rad/s]
    angle: float = 0.0  # Of the mass from the input axis, at the start [rad]
    where: str = ""  # Row, for messages

    @property
    def period(self) -> float:
        """Time of a turn [s]."""
        return 2.0 * math.pi / abs(self.rate)

    @property
    def turns(self) -> float:
        """How many it makes."""
        return (self.stop - self.start) / self.period

    @property
    def named(self) -> str:
        """Its period and sense in words: ``"+1 h"``."""
        sign, hours = "+" if self.rate > 0.0 else "-", self.period / 3600.0
        return f"{sign}{hours:.4g} h" if hours >= 1.0 / 60.0 else f"{sign}{self.period:.4g} s"


def programme_text(turns: Iterable[Turn], notes: Iterable[str] = ()) -> str:
    """Return the CSV of a programme; notes become comments above its rows."""
    made = io.StringIO()
    made.writelines(f"# {note}\n" for note in notes)
    writer = csv.writer(made, lineterminator="\n")
    writer.writerow(["run", *(f"{name} [{unit}]" for name, unit in WRITTEN.items())])
    for one in turns:
        writer.writerow([one.run, one.start, one.stop, math.degrees(one.rate), math.degrees(one.angle)])
    return made.getvalue()

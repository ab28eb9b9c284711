"""Requirement curve: root mean square of a third of an octave over frequency, as a file of nodes.

The figures of a requirement change from revision to revision of its document, and from one allocation to the next
(vehicle, payloads, both): they are the user's, and none is built in. Between nodes the curve is straight on logarithmic
axes; outside them there is no limit.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.units import factor, same_dimension
from ...files.text.headers import bare_name
from ...files.text.table import read_table

SI = "m/s^2"
LEVELS = ("rms", "limit", "level", "acceleration", "acc")


@dataclass(frozen=True, eq=False)
class Requirement:
    """A requirement curve."""

    frequency: Array  # shape (n,): rising [Hz]
    rms: Array  # shape (n,): of a third of an octave [m/s^2]
    path: str = ""

    def at(self, frequency: Array) -> Array:
        """Return the limit at frequencies, shape (k,); NaN where there is none [m/s^2]."""
        found = np.exp(np.interp(np.log(frequency), np.log(self.frequency), np.log(self.rms)))
        inside = (frequency >= self.frequency[0] * (1.0 - 1e-3)) & (frequency <= self.frequency[-1] * (1.0 + 1e-3))
        return np.where(inside, found, np.nan)


def read_requirement(path: str | Path) -> Requirement:
    """Return the curve in a table with the columns ``frequency [Hz]`` and ``rms [ug]``.

    Raises
    ------
    DataError
        ``no_column``, ``wrong_unit``, ``wrong_curve``; as reading a table.
    """
    table, where = read_table(path), str(path)
    names = [bare_name(name).lower() for name in table.names]
    found = []
    for wanted, unit, example in ((("frequency", "freq", "f"), "Hz", "frequency [Hz]"), (LEVELS, SI, "rms [ug]")):
        at = next((i for i, name in enumerate(names) if name in wanted), None)
        if at is None:
            do = f'Head it "{example}"'
            raise DataError(f"no column {wanted[0]}; there are: {', '.join(table.names)}", where, do=do,
                            code="no_column")  # fmt: skip
        own = table.units[at] if at < len(table.units) else None
        if own is None or not same_dimension(own, unit):
            what = f"column {table.names[at]!r} has {'no unit' if own is None else f'the unit {own}'}"
            raise DataError(what, where, "levels in g, ug and m/s^2 look alike", f'Head it "{example}"', "wrong_unit")
        found.append(np.asarray(table.numbers(table.names[at]), dtype=np.float64) * factor(own, unit))
    frequency, rms = found
    rising = len(frequency) > 1 and bool(np.all(np.diff(frequency) > 0.0)) and frequency[0] > 0.0
    if not rising or not bool(np.all(rms > 0.0)):
        what = f"{len(frequency)} nodes: need two or more, with rising frequencies and levels above 0"
        raise DataError(what, where, do="Correct the file", code="wrong_curve")
    return Requirement(frequency, rms, where)

"""What is fitted to a record with a known drive in it: the drive, its quadrature, drift, and its side bands.

Drift is a sum of the rows of a cosine transform, ``cos(pi k (t - t_0) / T)``, k = 0 ... q, T the length of the record:
row k is drift at the frequency k / 2T, and with the level (k = 0) and both ends free it follows slow noise without the
leakage that a Fourier series has. A straight line goes with them. q is chosen so that the highest row stays below 0.4
of the frequency of the drive; 20 rows are enough for any record: what a random walk leaves behind them is about 2 % of
the variance at the line. Or drift is a polynomial.

Side bands are the drive times ``cos`` and ``sin(2 pi j t / T)``, j = 1 ... J: every line of the drive with the same
weight as in the drive itself, moved by j lines to both sides. Their size tells the noise at the drive, whatever its
colour, as long as its density is about the same over the band that they cover.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ...core.errors import DataError, PlanError
from ...core.estimate import Array
from .drive import Drive

Drift = Literal["dct", "polynomial"]

BELOW = 0.4  # of the frequency of the drive: highest row of drift
MOST_ROWS = 20
DEGREE = 3  # of a polynomial
HIGHEST = 12  # degree
FEWEST_CYCLES = 3.0
CLEAR = 0.16  # of the frequency of the drive: half width of the side bands in a long record
SIDES = (4, 6)  # side bands on each side that a long record has at least, and at most
AT_ONCE = 16_384  # samples


@dataclass(frozen=True, eq=False)
class Design:
    """Columns of the fit."""

    drive: Drive  # at the samples that there are
    drift: Drift  # which
    rows: int  # highest row of the cosine transform, or degree
    side_bands: int  # on each side

    @property
    def line(self) -> int:
        """Columns of the drive: 2, or 1 without quadrature."""
        return 1 if self.drive.quadrature is None else 2

    @property
    def main(self) -> int:
        """Columns of drive and drift."""
        return self.line + self.rows + (2 if self.drift == "dct" else 1)

    @property
    def width(self) -> int:
        """All columns."""
        return self.main + 2 * self.line * self.side_bands

    def parts(self, columns: int | None = None) -> Iterator[tuple[slice, Array]]:
        """Yield the columns for some samples after another: which samples, and the columns, shape (columns, samples).

        Parameters
        ----------
        columns : int, optional
            How many; all by default.
        """
        n = len(self.drive.times)
        for start in range(0, n, AT_ONCE):
            part = slice(start, min(start + AT_ONCE, n))
            yield part, self._columns(part, self.width if columns is None else columns)

    def _columns(self, part: slice, count: int) -> Array:
        drive, line = self.drive, self.line
        found = np.empty((self.width if count > self.main else self.main, part.stop - part.start))
        found[0] = drive.in_phase[part]
        if drive.quadrature is not None:
            found[1] = drive.quadrature[part]
        place = (drive.times[part] - drive.times[0]) / drive.span
        middle = place + 0.5 * drive.step / drive.span
        if self.drift == "dct":
            found[line] = 2.0 * middle - 1.0
            _fill(found[line + 1 : self.main], np.cos(np.pi * middle), self.drift)
        else:
            _fill(found[line : self.main], 2.0 * middle - 1.0, self.drift)
        if count > self.main:
            turned = np.exp(2j * np.pi * place)
            carrier, at = np.ones_like(turned), self.main
            for _ in range(self.side_bands):
                carrier = carrier * turned
                for row in range(line):
                    np.multiply(found[row], carrier.real, out=found[at])
                    np.multiply(found[row], carrier.imag, out=found[at + 1])
                    at += 2
        return found


def _fill(rows: Array, first: Array, drift: Drift) -> None:
    """Fill rows 0, 1, ... by recursion: cosines of multiples, or Legendre polynomials."""
    rows[0] = 1.0
    if len(rows) > 1:
        rows[1] = first
    for k in range(2, len(rows)):
        if drift == "dct":
            rows[k] = 2.0 * first * rows[k - 1] - rows[k - 2]
        else:
            rows[k] = ((2 * k - 1) * first * rows[k - 1] - (k - 1) * rows[k - 2]) / k


def design_of(drive: Drive, drift: Drift = "dct", rows: int | None = None, side_bands: int | None = None) -> Design:
    """Choose drift and side bands for a drive.

    Parameters
    ----------
    drive : Drive
        At the samples that there are.
    drift : {"dct", "polynomial"}
        Of what kind.
    rows : int, optional
        Highest row, or degree; see the module head. 3 is the degree of a polynomial by default.
    side_bands : int, optional
        On each side; 4 to 6 by default (twice as many where the drive has no quadrature), fewer in a short record.

    Raises
    ------
    DataError
        ``too_few_cycles`` below three cycles in the record, ``side_bands`` if there is no room for any.
    PlanError
        If the drift reaches the drive, or a number is out of range.
    """
    cycles = drive.cycles
    if cycles < FEWEST_CYCLES:
        raise _too_short(drive)
    q = _rows(drift, rows, cycles)
    top = 0.5 * q if drift == "dct" else 0.5 * min(q, int(cycles))
    sides = _sides(drive, side_bands, cycles, top)
    found = Design(drive, drift, q, sides)
    if found.width >= len(drive.times):
        columns = f"drive, {found.main - found.line} of drift, {sides} side band(s)"
        what = f"{len(drive.times)} samples for {found.width} columns: {columns}"
        raise DataError(what, do="Record longer, or fit less drift", code="too_few_readings")
    return found


def _rows(drift: Drift, rows: int | None, cycles: float) -> int:
    if drift not in {"dct", "polynomial"}:
        raise PlanError(f"drift {drift!r}", do="There are 'dct' and 'polynomial'", code="wrong_value")
    if drift == "polynomial":
        degree = DEGREE if rows is None else rows
        if not 0 <= degree <= HIGHEST:
            raise PlanError(f"a polynomial of degree {degree}", do=f"Need 0 to {HIGHEST}", code="wrong_value")
        return degree
    if rows is None:
        return min(int(2.0 * BELOW * cycles), MOST_ROWS)
    if not 0 <= rows < 2.0 * cycles - 2.0:
        what = f"{rows} rows of drift, {cycles:.6g} cycles"
        why = "a row at the frequency of the drive takes it away"
        raise PlanError(what, why=why, do=f"Need 0 to {int(np.ceil(2.0 * cycles - 2.0)) - 1}", code="wrong_value")
    return rows


def _sides(drive: Drive, asked: int | None, cycles: float, top: float) -> int:
    """Side bands on each side: their lowest stays half a line above the drift."""
    room = int(np.floor(cycles - top - 0.5 + 1e-9))
    if asked is not None:
        if not 1 <= asked <= room:
            what = f"{asked} side bands on each side of line {cycles:.6g}, drift up to line {top:.6g}"
            raise PlanError(what, do=f"There is room for 1 to {room}" if room else "Fit less drift", code="side_bands")
        return asked
    if room < 1:
        what = f"{cycles:.6g} cycles, drift up to line {top:.6g}: no side band lies between"
        raise DataError(what, why="the noise at the drive cannot be told", do="Record longer", code="side_bands")
    wanted = int(np.clip(CLEAR * cycles, *SIDES)) * (2 if drive.quadrature is None else 1)
    return min(wanted, room)


def _too_short(drive: Drive) -> DataError:
    period, cycles = 1.0 / drive.frequency, drive.cycles
    what = f"a record of {drive.span:.6g} s, a period of {period:.6g} s: {cycles:.3g} cycles"
    why = "it is not longer than the period" if cycles < 1.0 else "drive and drift cannot be told apart"
    do = f"Record {FEWEST_CYCLES:g} cycles or more: {FEWEST_CYCLES * period:.6g} s"
    return DataError(what, why=why, do=do, code="too_few_cycles")

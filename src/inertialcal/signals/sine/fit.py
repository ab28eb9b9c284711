"""Fit of a known drive in drift and coloured noise, with the noise taken from beside the line.

The amplitudes in phase and in quadrature, and the drift, are fitted at once by least squares to the samples that there
are, at their own times: gaps and jitter need no repair. No noise is subtracted: with the phase known the estimate is
without bias as it stands.

The variance of a sample's noise, as it is at the drive, comes from the side bands: what they explain of the residuals,
over their number. Its degrees of freedom are that number, and with them the interval is Student's. Assumed: noise that
is stationary and normal, of about the same density from the lowest to the highest side band, and a drive that is known
exactly. Not assumed: that noise is white. The residuals as a whole would tell nothing of the noise at the drive.

The normal equations are summed over parts of the record: memory is of order (columns x 16,384), time of order
(samples x columns^2).

What is fitted to a record with a known drive in it: the drive, its quadrature, drift, and its side bands.

Drift is a sum of the rows of a cosine transform, ``cos(pi k (t - t_0) / T)``, k = 0 ... q, T the length of the record:
row k is drift at the frequency k / 2T, and with the level (k = 0) and both ends free it follows slow noise without the
leakage that a Fourier series has. A straight line goes with them. q is chosen so that the highest row stays below 0.4
of the frequency of the drive; 20 rows are enough for any record: what a random walk leaves behind them is about 2 % of
the variance at the line. Or drift is a polynomial.

Side bands are the drive times ``cos`` and ``sin(2 pi j t / T)``, j = 1 ... J: every line of the drive with the same
weight as in the drive itself, moved by j lines to both sides. Their size tells the noise at the drive, whatever its
colour, as long as its density is about the same over the band that they cover.

References
----------
.. [1] G. A. F. Seber and A. J. Lee, Linear Regression Analysis, 2nd ed., Wiley, 2003, 3.7 and 4.3.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy import linalg

from ...core.errors import DataError, PlanError
from ...core.estimate import Array
from .drive import Drive

DISTINCT = 1e-9  # smallest eigenvalue of the scaled normal equations that counts
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
class LineFit:
    """Drive found in one record, or in several of one design."""

    # in_phase, u_in_phase: amplitude in phase with the drive, signed, and its standard uncertainty [unit of the
    # readings, or that over the unit applied], shape (k,)
    in_phase: Array
    u_in_phase: Array
    # quadrature, u_quadrature: a quarter of a period ahead of it, shape (k,)
    quadrature: Array | None
    u_quadrature: Array | None
    correlation: float  # of both
    dof: float  # degrees of freedom of all uncertainties
    # standard deviation of white noise with the density that there is at the drive [unit of the readings], shape (k,)
    noise: Array
    drift: Array  # coefficients, in the order of the design, shape (columns of drift, k)
    # covariance of the coefficients for noise of unit variance, shape (columns of drive and drift, same)
    cofactors: Array
    design: Design  # what was fitted

    @property
    def density(self) -> Array:
        """One-sided spectral density of the noise at the drive, shape (k,) [unit^2/Hz]."""
        return 2.0 * self.noise**2 * self.design.drive.step

    def weights_on(self, columns: Array) -> Array:
        """Return the in-phase amplitude that the fit finds in columns (n, k) that are no records, shape (k,).

        Of the identity matrix these are the weights that the estimate gives to each reading; of the weights of another
        estimate, their product with its own.
        """
        right = np.zeros((self.design.main, columns.shape[1]))
        for part, rows in self.design.parts(self.design.main):
            right += rows @ columns[part]
        return np.asarray(self.cofactors[0] @ right)

    def fitted(self) -> tuple[Array, Array]:
        """Return line and drift of the first record at the samples, shape (n,) each."""
        design, n = self.design, len(self.design.drive.times)
        line, drift = np.empty(n), np.empty(n)
        of_line = [self.in_phase[0], *([] if self.quadrature is None else [self.quadrature[0]])]
        for part, columns in design.parts(design.main):
            line[part] = np.array(of_line) @ columns[: design.line]
            drift[part] = self.drift[:, 0] @ columns[design.line : design.main]
        return line, drift


def fit_line(design: Design, readings: Array) -> LineFit:
    """Fit a design to readings.

    Parameters
    ----------
    design : Design
        For the samples of the readings.
    readings : ndarray, shape (n,) or (n, k)
        One record, or several with the same samples; all finite: leave missing samples out of drive and readings.

    Raises
    ------
    DataError
        If shapes disagree or a reading is missing; ``rank_deficient`` if drive and drift cannot be separated at these
        samples, ``no_scatter`` if nothing but the drive and drift is there (noise not estimated).
    """
    x = _checked(design, readings)
    offset = np.median(x, axis=0)
    gram, right = _normal_equations(design, x - offset)
    scale = 1.0 / np.sqrt(np.diag(gram))
    gram, right = gram * np.outer(scale, scale), right * scale[:, None]
    m = design.main
    inverse = _inverse(gram[:m, :m])
    main = inverse @ right[:m]
    square, dof = _side_bands(gram, right, inverse @ gram[:m, m:], main, m)
    cofactors = inverse * np.outer(scale[:m], scale[:m])
    noise = np.sqrt(square)
    if not np.all(noise > 1e-13 * np.abs(x - offset).max(axis=0)):
        raise DataError("nothing but drive and drift in the record", why="noise not estimated", code="no_scatter")
    values, u = main * scale[:m, None], np.sqrt(np.diag(cofactors))
    drift = values[design.line :].copy()
    drift[1 if design.drift == "dct" else 0] += offset
    two = design.line == 2
    return LineFit(
        values[0], u[0] * noise, values[1] if two else None, u[1] * noise if two else None,
        float(cofactors[0, 1] / (u[0] * u[1])) if two else 0.0, float(dof), noise, drift, cofactors, design,
    )  # fmt: skip


def _checked(design: Design, readings: Array) -> Array:
    x = np.asarray(readings, dtype=np.float64)
    x = x[:, None] if x.ndim == 1 else x
    if x.ndim != 2 or len(x) != len(design.drive.times):
        what = f"{len(design.drive.times)} samples of the drive, {len(x)} readings"
        raise DataError(what, do="Give one of the drive for each reading", code="different_length")
    if not np.all(np.isfinite(x)):
        missing = int(np.count_nonzero(~np.isfinite(x).all(axis=1)))
        raise DataError(f"{missing} readings are missing", do="Leave them out of readings and drive", code="gaps")
    return x


def _normal_equations(design: Design, x: Array) -> tuple[Array, Array]:
    gram, right = np.zeros((design.width, design.width)), np.zeros((design.width, x.shape[1]))
    for part, columns in design.parts():
        gram += columns @ columns.T
        right += columns @ x[part]
    return gram, right


def _inverse(gram: Array) -> Array:
    """Inverse of scaled normal equations; refused where two columns are the same at these samples."""
    sizes = np.linalg.eigvalsh(gram)
    if not sizes[0] > DISTINCT:
        what = "drive and drift cannot be separated at these samples"
        raise DataError(what, do="Fit less drift, or record longer", code="rank_deficient")
    return np.asarray(linalg.inv(gram))


def _side_bands(gram: Array, right: Array, mixed: Array, main: Array, m: int) -> tuple[Array, int]:
    """Variance that the side bands tell of each record, and how many tell it."""
    rest = gram[m:, m:] - gram[m:, :m] @ mixed
    explained = right[m:] - gram[m:, :m] @ main
    sizes, axes = np.linalg.eigh(rest)
    good = sizes > DISTINCT**0.5
    if good.sum() < 2:
        raise DataError("no side band can be separated from drive and drift", do="Record longer", code="side_bands")
    parts = axes[:, good].T @ explained
    return np.asarray(np.sum(parts**2 / sizes[good, None], axis=0) / good.sum()), int(good.sum())


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
        why = "drift at the frequency of the drive would remove it"
        raise PlanError(what, why=why, do=f"Need 0 to {int(np.ceil(2.0 * cycles - 2.0)) - 1}", code="wrong_value")
    return rows


def _sides(drive: Drive, wanted: int | None, cycles: float, top: float) -> int:
    """Side bands on each side: their lowest stays half a line above the drift."""
    room = int(np.floor(cycles - top - 0.5 + 1e-9))
    if wanted is not None:
        if not 1 <= wanted <= room:
            what = f"{wanted} side bands on each side of line {cycles:.6g}, drift up to line {top:.6g}"
            raise PlanError(what, do=f"There is room for 1 to {room}" if room else "Fit less drift", code="side_bands")
        return wanted
    if room < 1:
        what = f"{cycles:.6g} cycles, drift up to line {top:.6g}: no side band lies between"
        raise DataError(what, why="the noise at the drive cannot be estimated", do="Record longer", code="side_bands")
    wanted = int(np.clip(CLEAR * cycles, *SIDES)) * (2 if drive.quadrature is None else 1)
    return min(wanted, room)


def _too_short(drive: Drive) -> DataError:
    period, cycles = 1.0 / drive.frequency, drive.cycles
    what = f"a record of {drive.span:.6g} s, a period of {period:.6g} s: {cycles:.3g} cycles"
    why = "it is shorter than one period" if cycles < 1.0 else "drive and drift cannot be separated"
    do = f"Record {FEWEST_CYCLES:g} cycles or more: {FEWEST_CYCLES * period:.6g} s"
    return DataError(what, why=why, do=do, code="too_few_cycles")

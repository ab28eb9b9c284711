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

References
----------
.. [1] G. A. F. Seber and A. J. Lee, Linear Regression Analysis, 2nd ed., Wiley, 2003, 3.7 and 4.3.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import linalg

from ...core.errors import DataError
from ...core.estimate import Array
from .design import Design

DISTINCT = 1e-9  # smallest eigenvalue of the scaled normal equations that counts


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
        """Return the in-phase amplitude that the fit finds in columns that are no records, shape (k,).

        Of the identity matrix these are the weights that the estimate gives to each reading; of the weights of another
        estimate, their product with its own.

        Parameters
        ----------
        columns : ndarray, shape (n, k)
            Any.
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
        If shapes disagree or a reading is missing; ``rank_deficient`` if drive and drift cannot be told apart at these
        samples, ``no_scatter`` if nothing but the drive and drift is there (no noise can be told).
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
        raise DataError("the record is drive and drift alone", why="no noise can be told", code="no_scatter")
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
        raise DataError(f"{missing} readings are missing", do="Leave them out, here and in the drive", code="gaps")
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
        what = "drive and drift cannot be told apart at the samples that there are"
        raise DataError(what, do="Fit less drift, or record longer", code="rank_deficient")
    return np.asarray(linalg.inv(gram))


def _side_bands(gram: Array, right: Array, mixed: Array, main: Array, m: int) -> tuple[Array, int]:
    """Variance that the side bands tell of each record, and how many tell it."""
    rest = gram[m:, m:] - gram[m:, :m] @ mixed
    told = right[m:] - gram[m:, :m] @ main
    sizes, axes = np.linalg.eigh(rest)
    good = sizes > DISTINCT**0.5
    if good.sum() < 2:
        raise DataError("no side band can be told from drive and drift", do="Record longer", code="side_bands")
    parts = axes[:, good].T @ told
    return np.asarray(np.sum(parts**2 / sizes[good, None], axis=0) / good.sum()), int(good.sum())

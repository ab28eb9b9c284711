"""Rows of readings times small matrices, and inverses of many small matrices at once."""

from __future__ import annotations

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array


def mixed(matrix: Array, x: Array) -> Array:
    """Return rows of x times a matrix, shape (n, k), summed in the order of the columns (not left to a BLAS).

    So the last digit of a row depends neither on the rows around it nor on the number of threads. An entry of
    zero takes nothing from x, not even a missing reading.

    Parameters
    ----------
    matrix : ndarray, shape (1 or n, k, l)
        One for all rows, or one a row.
    x : ndarray, shape (n, l)
        One row a reading.
    """
    out = np.empty((max(len(matrix), len(x)), matrix.shape[1]))
    columns = np.ascontiguousarray(x.T)
    for i, row in enumerate(np.any(matrix != 0.0, axis=0)):
        total = np.zeros(len(out))
        for j in np.flatnonzero(row):
            total += matrix[:, i, j] * np.where(matrix[:, i, j] != 0.0, columns[j], 0.0)
        out[:, i] = total
    return out


def inverted(matrix: Array) -> Array:
    """Return the inverses of matrices, shape (n, k, k).

    Three by three, by cofactors over the determinant: 20 times faster than one factorisation a matrix, and as good
    for matrices like these, near a diagonal one.

    Raises
    ------
    DataError
        ``not_invertible`` if one is singular.
    """
    try:
        return _by_cofactors(matrix) if matrix.shape[1:] == (3, 3) else np.asarray(np.linalg.inv(matrix))
    except np.linalg.LinAlgError:
        raise DataError(
            "the matrix of the model is singular at a temperature of the data", code="not_invertible"
        ) from None


def _by_cofactors(matrix: Array) -> Array:
    rows = [matrix[:, i, :].T for i in range(3)]
    cofactors = np.stack([_cross(rows[(i + 1) % 3], rows[(i + 2) % 3]) for i in range(3)])  # (row, column, n)
    determinant = (rows[0] * cofactors[0]).sum(axis=0)
    if np.any(determinant == 0.0):
        raise np.linalg.LinAlgError
    return np.asarray((cofactors / determinant).transpose(2, 1, 0))


def _cross(a: Array, b: Array) -> Array:
    """Vector products of columns, shape (3, n)."""
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])

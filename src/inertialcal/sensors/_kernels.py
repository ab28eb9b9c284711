"""Compiled loops: arrays in, preallocated arrays out, no checks."""

from __future__ import annotations

import numba

from ..core.estimate import Array


@numba.njit(cache=True)  # type: ignore[untyped-decorator]
def affine_3(matrix: Array, shift: Array, x: Array, out: Array) -> None:
    """Fill ``out`` with matrix (x - shift), three sensors a row; sums in the order of ``equation.mixed``."""
    for n in range(x.shape[0]):
        a = x[n, 0] - shift[0]
        b = x[n, 1] - shift[1]
        c = x[n, 2] - shift[2]
        out[n, 0] = matrix[0, 0] * a + matrix[0, 1] * b + matrix[0, 2] * c
        out[n, 1] = matrix[1, 0] * a + matrix[1, 1] * b + matrix[1, 2] * c
        out[n, 2] = matrix[2, 0] * a + matrix[2, 1] * b + matrix[2, 2] * c

"""What counts as smooth drift, against a decomposition of forty digits."""

from __future__ import annotations

import mpmath  # type: ignore[import-untyped]
import numpy as np
import pytest

from inertialcal.core.estimate import Array
from inertialcal.signals.sine.smooth import BLIND, COARSE, LENGTH, LONG, STRENGTH, Stretch


@pytest.mark.parametrize(("n", "step"), [(60, 1.0 / 12.0), (40, 0.5)])
def test_every_smooth_drift_is_a_sum_of_the_columns(n: int, step: float) -> None:
    """But for the millionth of a column that may be left to the cubic."""
    times: Array = np.arange(0.5, n, dtype=np.float64) * step
    line = np.column_stack([np.sin(2.0 * np.pi * times), np.cos(2.0 * np.pi * times)])
    with mpmath.workdps(40):
        length = mpmath.mpf(LENGTH if step < COARSE else LONG)
        apart = [[(mpmath.mpf(s) - mpmath.mpf(t)) / length for t in times.tolist()] for s in times.tolist()]
        powers, axes = mpmath.eigsy(mpmath.matrix([[mpmath.exp(-d * d / 2) for d in row] for row in apart]))
        slow = [k for k in range(n) if powers[k] > BLIND / STRENGTH]
        exact = np.array([[float(axes[i, k]) for k in slow] for i in range(n)])
    basis = Stretch(times, line, step).drift_basis
    np.testing.assert_allclose(basis.T @ basis, np.eye(basis.shape[1]), atol=1e-9)
    assert np.linalg.norm(exact - basis @ (basis.T @ exact)) < 1e-6

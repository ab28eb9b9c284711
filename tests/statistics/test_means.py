"""Weighted means against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest

from inertialcal.core.errors import DataError
from inertialcal.statistics.means import weighted_mean

CLOSED = 1e-12  # relative


def test_weighted_mean_of_two() -> None:
    found = weighted_mean([1.0, 2.0], [1.0, 0.5], dof=[4.0, 6.0])
    assert found.value == pytest.approx(1.8, rel=CLOSED)  # weights 1 and 4
    assert found.u == pytest.approx(1.0 / math.sqrt(5.0), rel=CLOSED)
    assert found.dof == pytest.approx(1.0 / (0.2**2 / 4.0 + 0.8**2 / 6.0), rel=CLOSED)
    assert weighted_mean([1.0, 2.0], [1.0, 0.5]).dof == math.inf


def test_weighted_mean_of_equal_uncertainties_is_the_mean() -> None:
    x = np.array([3.0, 5.0, 10.0, 2.0])
    assert weighted_mean(x, np.full(4, 0.2)).value == pytest.approx(x.mean(), rel=CLOSED)


def test_refusals() -> None:
    with pytest.raises(DataError, match="1 not finite, the first is number 2") as caught:
        weighted_mean([1.0, math.nan], [1.0, 1.0])
    assert caught.value.problems[0].code == "not_finite"
    with pytest.raises(DataError, match="smallest standard uncertainty 0"):
        weighted_mean([1.0, 2.0], [0.0, 1.0])
    with pytest.raises(DataError, match="0 values"):
        weighted_mean([], [])

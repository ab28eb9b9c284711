"""Polynomials: NIST's hardest data set, the GUM's thermometer, exact change of variable."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from test_least_squares import CERTIFIED, THERMOMETER

from inertialcal.core.errors import DataError, PlanError
from inertialcal.core.estimate import Array
from inertialcal.statistics.least_squares import fit
from inertialcal.statistics.polynomial import Polynomial, fit_polynomial, from_monomials

STRD = Path(__file__).parent / "strd"
CERTIFIED_DIGITS = 1e-11  # relative


def needed(covariance: Array | None) -> Array:
    assert covariance is not None
    return covariance


def thermometer(order: int = 1) -> Polynomial:
    t, b = THERMOMETER.T
    return fit_polynomial(t, b, order, domain=(20.0, 30.0))


def test_order_ten_of_nist_by_exact_change_of_variable() -> None:
    """Filip: the series and its covariance, as powers of x, give the certified digits."""
    filip = next(one for one in CERTIFIED if one["dataset"] == "filip")
    order, estimates, stds = max(filip["powers"]), filip["estimates"], filip["standard_deviations"]
    y, x = np.loadtxt(STRD / "filip.txt").T
    coefficients, covariance = fit_polynomial(x, y, order).monomials()
    assert coefficients == pytest.approx(np.array(estimates), rel=CERTIFIED_DIGITS)
    assert np.sqrt(np.diag(needed(covariance))) == pytest.approx(np.array(stds), rel=CERTIFIED_DIGITS)


def test_thermometer_of_the_gum_at_30_degrees() -> None:
    """JCGM 100, H.3.3 and H.3.4."""
    found = thermometer()
    powers, covariance = found.monomials(reference=20.0)
    u = np.sqrt(np.diag(needed(covariance)))
    assert powers[0] == pytest.approx(-0.1712, abs=5e-5)
    assert powers[1] == pytest.approx(0.00218, abs=5e-6)
    assert u[0] == pytest.approx(0.0029, abs=5e-5)
    assert u[1] == pytest.approx(0.00067, abs=5e-6)
    assert needed(covariance)[0, 1] / u.prod() == pytest.approx(-0.930, abs=5e-4)
    assert found.values(30.0) == pytest.approx(-0.1494, abs=5e-5)
    assert found.u(30.0) == pytest.approx(0.0041, abs=5e-5)
    assert found.dof == 9.0
    assert found.order == 1


@given(
    coefficients=st.lists(st.floats(-5.0, 5.0), min_size=1, max_size=6),
    lo=st.floats(-50.0, 50.0),
    width=st.floats(1.0, 100.0),
    where=st.floats(-0.2, 1.2),
)
def test_series_and_powers_are_one_polynomial(coefficients: list[float], lo: float, width: float, where: float) -> None:
    series = Polynomial(np.array(coefficients), np.eye(len(coefficients)), 5.0, (lo, lo + width))
    reference = lo + where * width
    powers, covariance = series.monomials(reference)
    x = np.linspace(lo, lo + width, 7)
    design = np.vander(x - reference, powers.size, increasing=True)
    size = np.sum(np.abs(coefficients)) + 1.0
    assert design @ powers == pytest.approx(series.values(x), abs=1e-9 * size)
    u = np.sqrt(np.einsum("ni,ij,nj->n", design, needed(covariance), design))
    assert u == pytest.approx(series.u(x), rel=1e-6)


@given(at_edge=st.lists(st.floats(-5.0, 5.0), min_size=1, max_size=6), reference=st.floats(-30.0, 70.0))
def test_there_and_back(at_edge: list[float], reference: float) -> None:
    """Each power gives up to 5 units at the edge of the range, 40 from its middle."""
    scale = 40.0 ** -np.arange(len(at_edge))
    C = np.diag(np.linspace(1.0, 2.0, len(at_edge)))
    series = from_monomials(at_edge * scale, (-20.0, 60.0), reference, C * np.outer(scale, scale), dof=4.0)
    back, covariance = series.monomials(reference)
    assert back / scale == pytest.approx(np.array(at_edge), abs=1e-9)
    assert needed(covariance) / np.outer(scale, scale) == pytest.approx(C, abs=1e-9)
    assert series.dof == 4.0


def test_a_published_cubic_evaluates_as_printed() -> None:
    """1 - 2 d + 3 d² - 4 d³ at d = x - 25."""
    series = from_monomials([1.0, -2.0, 3.0, -4.0], (0.0, 50.0), reference=25.0)
    assert series.values([25.0, 26.0, 24.0]) == pytest.approx([1.0, -2.0, 10.0], rel=1e-9)
    assert series.covariance is None
    assert series.dof == 0.0
    assert series.monomials(0.0)[1] is None


def test_fit_and_its_uncertainty_are_those_of_plain_least_squares() -> None:
    rng = np.random.default_rng(1)
    x = rng.uniform(-3.0, 8.0, 20)
    y = 1.0 + x - 0.2 * x**2 + rng.normal(0.0, 0.1, 20)
    w = rng.uniform(0.5, 2.0, 20)
    found = fit_polynomial(x, y, 2, weights=w)
    plain = fit(np.vander(x, 3, increasing=True), y, weights=w)
    at = np.linspace(x.min(), x.max(), 5)
    design = np.vander(at, 3, increasing=True)
    assert found.values(at) == pytest.approx(design @ plain.coefficients, rel=1e-10)
    u = np.sqrt(np.einsum("ni,ij,nj->n", design, plain.need_covariance(), design))
    assert found.u(at) == pytest.approx(u, rel=1e-9)
    assert found.domain == (x.min(), x.max())


def test_order_zero_is_the_mean() -> None:
    found = fit_polynomial([25.0, 25.0, 25.0], [1.0, 2.0, 6.0], 0)
    assert found.values(25.0) == pytest.approx(3.0)
    assert found.u(25.0) == pytest.approx(math.sqrt(7.0 / 3.0), rel=1e-12)


def test_shape_of_x_is_kept() -> None:
    x = np.array([[21.0, 22.0], [23.0, 24.0], [25.0, 26.0]])
    assert thermometer(2).values(x).shape == (3, 2)
    assert thermometer(2).u(x).shape == (3, 2)
    assert thermometer().values(21.0).shape == ()


def test_refusals_by_their_words() -> None:
    with pytest.raises(DataError, match=r"2 value\(s\) outside the validity range 20 to 30, the first is 19.5"):
        thermometer().values([19.5, 25.0, 31.0])
    with pytest.raises(DataError, match="the first is nan"):
        thermometer().u(math.nan)
    with pytest.raises(DataError, match="2 different values of x for a polynomial of order 2"):
        fit_polynomial([1.0, 1.0, 2.0, 2.0], [1.0, 2.0, 3.0, 4.0], 2)
    with pytest.raises(DataError, match=r"1 value\(s\) outside the validity range 1 to 3, the first is nan"):
        fit_polynomial([1.0, 2.0, 3.0, math.nan], [1.0, 2.0, 3.0, 4.0], 1)
    with pytest.raises(DataError, match="outside the validity range 0 to 2"):
        fit_polynomial([1.0, 2.0, 3.0], [1.0, 2.0, 3.0], 1, domain=(0.0, 2.0))
    with pytest.raises(DataError, match="polynomial of order 1 without covariance"):
        fit_polynomial([1.0, 2.0], [1.0, 2.0], 1).u(1.5)
    with pytest.raises(PlanError, match="polynomial of order -1"):
        fit_polynomial([1.0], [1.0], -1)
    with pytest.raises(PlanError, match="validity range 30 to 20"):
        from_monomials([1.0], (30.0, 20.0))
    with pytest.raises(DataError, match="coefficients \\[nan\\]"):
        from_monomials([math.nan], (20.0, 30.0))

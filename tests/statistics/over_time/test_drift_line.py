"""Drift of a unit: closed forms, invariants, and simulated units whose truth is known."""

from __future__ import annotations

import math

import numpy as np
import pytest
from ageing import Ageing, Life, life
from hypothesis import given
from hypothesis import strategies as st

from inertialcal.core.errors import DataError
from inertialcal.core.results import Curvature
from inertialcal.statistics.difference import Figure, difference
from inertialcal.statistics.intervals import covers, t_interval
from inertialcal.statistics.over_time.drift_line import ENOUGH, Line, due, line
from sized import sized

ROUNDING = 1e-9


def figures(of: Life) -> list[Figure]:
    columns = zip(of.values, of.u, of.dof, of.certificates, strict=True)
    return [Figure(float(y), float(u), float(dof), {name: of.standard}) for y, u, dof, name in columns]


def fitted(of: Ageing, seed: int) -> Line:
    lived = life(of, np.random.default_rng(seed))
    return line(lived.years, figures(lived))


def test_the_line_of_known_variances_is_that_of_generalised_least_squares() -> None:
    t, y = np.array([0.0, 1.0, 2.5, 4.0]), np.array([1.0, 1.2, 1.1, 1.5])
    own, c = np.array([0.2, 0.3, 0.25, 0.2]), np.array([0.4, 0.4, 0.0, 0.0])
    d = np.array([0.0, 0.0, 0.5, 0.5])
    V = np.diag(own**2) + np.outer(c, c) + np.outer(d, d)
    X = np.column_stack([np.ones(4), t])
    covariance = np.linalg.inv(X.T @ np.linalg.inv(V) @ X)
    level, slope = covariance @ X.T @ np.linalg.inv(V) @ y
    given_figures = [
        Figure(y[i], math.sqrt(V[i, i]), changes={"first": 0.4} if i < 2 else {"second": 0.5}) for i in range(4)
    ]
    found = line(t, given_figures)
    assert found.slope == pytest.approx(slope, rel=ROUNDING)
    assert found.u == pytest.approx(math.sqrt(covariance[1, 1]), rel=ROUNDING)
    for at in (-1.0, 2.0, 9.0):
        x = np.array([1.0, at])
        assert found.at(at) == pytest.approx((level + slope * at, math.sqrt(x @ covariance @ x)), rel=ROUNDING)


def test_two_tests_give_their_difference_over_the_time_between() -> None:
    a, b = Figure(1.0, 0.05, 12.0, {"table": 0.04}), Figure(1.2, 0.06, 9.0, {"table": 0.04})
    found, apart = line([3.0, 1.0], [b, a]), difference(a, b)
    assert (found.slope, found.u, found.dof) == pytest.approx((apart.value / 2, apart.u / 2, apart.dof))
    assert found.basis == "difference"


def test_with_one_standard_its_error_is_not_in_the_drift_and_with_another_it_is() -> None:
    t = [0.0, 1.0, 2.0]
    one = line(t, [Figure(y, 0.05, changes={"table": 0.04}) for y in (1.0, 1.1, 1.2)])
    other = line(t, [Figure(y, 0.05, changes={f"table {i}": 0.04}) for i, y in enumerate((1.0, 1.1, 1.2))])
    assert one.u == pytest.approx(0.03 / math.sqrt(2.0))
    assert other.u == pytest.approx(0.05 / math.sqrt(2.0))


def test_residuals_alone_say_how_far_many_tests_scatter() -> None:
    """Of equal and independent tests u is that of a straight line by least squares, whatever was stated."""
    t, rng = np.arange(8.0), np.random.default_rng(1)
    y = 0.1 * t + rng.normal(0.0, 0.3, 8)
    found = line(t, [Figure(value, 0.7) for value in y])
    slope, level = np.polyfit(t, y, 1)
    rest = float(np.sum((y - level - slope * t) ** 2))
    assert found.slope == pytest.approx(slope, rel=1e-6)
    assert found.u == pytest.approx(math.sqrt(rest / 6.0 / np.sum((t - t.mean()) ** 2)), rel=1e-6)
    assert found.dof == 6.0
    assert found.wander == 0.0


def test_a_wander_beyond_the_stated_uncertainties_is_found() -> None:
    rng = np.random.default_rng(2)
    found = line(np.arange(400.0), [Figure(value, 0.1) for value in rng.normal(0.0, math.hypot(0.1, 0.5), 400)])
    assert found.wander == pytest.approx(0.5, rel=0.1)
    assert found.consistency < 1e-6


def test_a_curvature_of_the_unit_that_is_the_same_in_all_tests_cancels() -> None:
    term = {"third_order_x": Curvature(0.04, 1.0)}
    found = line([0.0, 1.0, 2.0], [Figure(y, 0.05, curvature=term) for y in (1.0, 1.1, 1.2)])
    assert found.u == pytest.approx(0.03 / math.sqrt(2.0))


def test_what_shows_no_drift_is_refused() -> None:
    one = Figure(1.0, 0.1)
    with pytest.raises(DataError, match="tests at one time"):
        line([0.0], [one])
    with pytest.raises(DataError, match="tests at one time"):
        line([1.0, 1.0], [one, one])
    with pytest.raises(DataError, match="no figure has an uncertainty"):
        line([0.0, 1.0], [Figure(1.0, 0.0), Figure(2.0, 0.0)])


@given(
    seed=st.integers(1, 10_000), years=st.integers(2, 9), shift=st.floats(-1e3, 1e3), scale=st.floats(0.01, 100.0),
    later=st.floats(-50.0, 50.0),
)  # fmt: skip
def test_units_and_zeros_do_not_matter(seed: int, years: int, shift: float, scale: float, later: float) -> None:
    lived = life(Ageing(years=years), np.random.default_rng(seed))
    before = figures(lived)
    moved = [Figure(scale * (one.value + shift), scale * one.u, one.dof, {k: scale * c for k, c in one.changes.items()})
             for one in before]  # fmt: skip
    one, other = line(lived.years, before), line(lived.years + later, moved)
    assert other.slope == pytest.approx(scale * one.slope, rel=1e-5, abs=1e-7 * scale)
    assert other.u == pytest.approx(scale * one.u, rel=1e-4)


def test_a_unit_is_due_where_its_interval_touches_the_limit() -> None:
    t = np.arange(0.0, 10.0)
    found = line(t, [Figure(0.1 * x + 0.001 * (-1.0) ** x, 0.001) for x in t])
    when = due(found, 9.0, 0.9, 0.5, 30.0)
    assert when.expected == pytest.approx(5.0, abs=0.1)
    assert when.first is not None
    assert when.expected is not None
    assert when.last is not None
    assert when.first < when.expected < when.last
    still = line(t, [Figure(0.001 * (-1.0) ** x, 0.001) for x in t])
    assert due(still, 9.0, 0.0, 0.5, 30.0).first is None
    assert due(still, 9.0, 0.0, 1e-6, 30.0).first == 0.0


CASES = {
    "certificates of four years": Ageing(),
    "no drift": Ageing(drift=0.0),
    "one certificate": Ageing(certificate_years=99),
    "a certificate a year": Ageing(certificate_years=1),
    "few power-ups": Ageing(runs=4),
    "a wander": Ageing(wander=0.03),
    "six tests": Ageing(years=6),
    "three tests": Ageing(years=3),
    "two tests": Ageing(years=2, drift=0.0),
}


@pytest.mark.parametrize(
    "name", [pytest.param(one, marks=[pytest.mark.slow] if i > 1 else []) for i, one in enumerate(CASES)]
)
def test_intervals_of_drift_hold_the_truth_in_95_of_100(name: str) -> None:
    """And a drift is said where there is none in at most 5 of 100, as the interval holds 0 in the others."""
    of = CASES[name]
    n = sized(1000, 300) if name not in list(CASES)[:2] else 100
    hits, called = 0, 0
    for seed in range(1, n + 1):
        found = fitted(of, seed)
        interval = t_interval(found.slope, found.u, found.dof)
        assert interval.lo is not None
        assert interval.hi is not None
        hits += interval.lo <= of.drift <= interval.hi
        called += found.p_value < 0.05
        assert found.basis == ("difference" if of.years == 2 else "residuals" if of.years >= ENOUGH else found.basis)
    assert covers(hits, n), f"{hits} of {n}"
    if of.drift == 0.0:
        assert called == n - hits

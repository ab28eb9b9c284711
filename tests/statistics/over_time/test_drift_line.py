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
from inertialcal.statistics.decision import holm
from inertialcal.statistics.difference import Figure, difference
from inertialcal.statistics.intervals import covers, t_interval
from inertialcal.statistics.over_time.drift_line import Line, due, line
from sized import sized

ROUNDING = 1e-9


def figures(of: Life) -> list[Figure]:
    columns = zip(of.values, of.u, of.dof, of.certificates, strict=True)
    return [Figure(float(y), float(u), float(dof), {name: of.standard}) for y, u, dof, name in columns]


def fitted(of: Ageing, seed: int, told: bool = True) -> Line:
    lived = life(of, np.random.default_rng(seed))
    return line(lived.years, figures(lived), lived.adjusted if told else None)


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
    rest = y - X @ [level, slope]
    gain = covariance @ X.T @ np.linalg.inv(V)
    standards = gain @ (np.outer(c, c) + np.outer(d, d)) @ gain.T
    covariance = standards + (covariance - standards) * (rest @ np.linalg.solve(V, rest) / 2.0)  # by the residuals
    assert found.u == pytest.approx(math.sqrt(covariance[1, 1]), rel=ROUNDING)
    assert (found.dof, found.wander) == (2.0, 0.0)
    for at in (-1.0, 2.0, 9.0):
        x = np.array([1.0, at])
        assert found.at(at) == pytest.approx((level + slope * at, math.sqrt(x @ covariance @ x)), rel=ROUNDING)


def test_two_tests_give_their_difference_over_the_time_between() -> None:
    a, b = Figure(1.0, 0.05, 12.0, {"table": 0.04}), Figure(1.2, 0.06, 9.0, {"table": 0.04})
    found, apart = line([3.0, 1.0], [b, a]), difference(a, b)
    assert (found.slope, found.u, found.dof) == pytest.approx((apart.value / 2, apart.u / 2, apart.dof))
    assert found.basis == "difference"


def test_with_one_standard_its_error_is_not_in_the_drift_and_with_another_it_is() -> None:
    """Two tests before an adjustment and one after it: no residual, and u is that of the stated uncertainties."""
    t = [0.0, 1.0, 2.0]
    one = line(t, [Figure(y, 0.05, changes={"table": 0.04}) for y in (1.0, 1.1, 1.7)], [0, 0, 1])
    other = line(t, [Figure(y, 0.05, changes={f"table {i}": 0.04}) for i, y in enumerate((1.0, 1.1, 1.7))], [0, 0, 1])
    assert (one.basis, other.basis) == ("stated", "stated")
    assert one.slope == pytest.approx(0.1)
    assert one.u == pytest.approx(0.03 * math.sqrt(2.0))
    assert other.u == pytest.approx(0.05 * math.sqrt(2.0))
    assert one.at(2.0)[0] == pytest.approx(1.7)


def test_an_adjustment_moves_the_level_and_not_the_slope() -> None:
    t, noise = np.arange(10.0), 0.01 * (-1.0) ** np.arange(10)
    y = 0.1 * t + noise
    before = line(t, [Figure(value, 0.01) for value in y])
    moved = line(t, [Figure(value, 0.01) for value in y - 3.0 * (t >= 5.0)], [0] * 5 + [1] * 5)
    X = np.column_stack([t < 5.0, t >= 5.0, t]).astype(float)
    coefficients, rest, *_ = np.linalg.lstsq(X, y - 3.0 * (t >= 5.0), rcond=None)
    assert moved.slope == pytest.approx(coefficients[2], rel=1e-9)
    assert moved.u == pytest.approx(math.sqrt(rest[0] / 7.0 * np.linalg.inv(X.T @ X)[2, 2]), rel=1e-6)
    assert (moved.dof, before.dof) == (7.0, 8.0)
    assert moved.at(0.0)[0] == pytest.approx(coefficients[1], rel=1e-9)


def test_residuals_alone_say_how_far_many_tests_scatter() -> None:
    """Of equal and independent tests u is that of a straight line by least squares, whatever was stated."""
    t, rng = np.arange(8.0), np.random.default_rng(1)
    y = 0.1 * t + rng.normal(0.0, 0.3, 8)
    found = line(t, [Figure(value, 0.4) for value in y])
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
    assert found.at(found.middle)[1] == pytest.approx(0.5, rel=0.1)  # the unit, at a test to come
    assert found.consistency < 1e-6


def test_a_curvature_of_the_unit_that_is_the_same_in_all_tests_cancels() -> None:
    term = {"third_order_x": Curvature(0.04, 1.0)}
    found = line([0.0, 1.0, 2.0], [Figure(y, 0.05, curvature=term) for y in (1.0, 1.1, 1.7)], [0, 0, 1])
    assert found.u == pytest.approx(0.03 * math.sqrt(2.0))


def test_what_shows_no_drift_is_refused() -> None:
    one = Figure(1.0, 0.1)
    with pytest.raises(DataError, match="tests at one time"):
        line([0.0], [one])
    with pytest.raises(DataError, match="tests at one time"):
        line([1.0, 1.0], [one, one])
    with pytest.raises(DataError, match="tests at one time"):
        line([0.0, 1.0], [one, one], [0, 1])
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
    table = line(t, [Figure(0.1 * x + 0.001 * (-1.0) ** x, 0.3, changes={"table": 0.29999833 + 1e-9 * x}) for x in t])
    assert table.at(9.0)[1] == pytest.approx(0.3, rel=1e-3)
    again = due(table, 9.0, 0.9, 0.5, 30.0)  # the error of the one table is in no change
    assert (again.first, again.last) == pytest.approx((when.first, when.last), rel=1e-3)
    still = line(t, [Figure(0.001 * (-1.0) ** x, 0.001) for x in t])
    assert due(still, 9.0, 0.0, 0.5, 30.0).first is None
    assert due(still, 9.0, 0.0, 1e-6, 30.0).first == 0.0


CASES = {
    "certificates of four years": Ageing(),
    "no drift": Ageing(drift=0.0),
    "one certificate": Ageing(certificate_years=99),
    "a certificate a year": Ageing(certificate_years=1),
    "four power-ups": Ageing(runs=4),
    "three power-ups": Ageing(runs=3),
    "two power-ups": Ageing(runs=2),
    "a wander": Ageing(wander=0.03),
    "a wander, three power-ups": Ageing(wander=0.03, runs=3),
    "six tests": Ageing(years=6),
    "five tests that wander": Ageing(years=5, wander=0.02),
    "four tests that wander": Ageing(years=4, wander=0.02),
    "three tests that wander": Ageing(years=3, wander=0.02),
    "three tests": Ageing(years=3),
    "two tests": Ageing(years=2, drift=0.0),
    "adjusted halfway": Ageing(adjusted=5, by=0.7),
    "adjusted after two of five": Ageing(years=5, adjusted=2, by=0.7, wander=0.02),
    "another standard halfway": Ageing(certificate_years=6, standard=0.1),
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
        assert found.basis == ("difference" if of.years == 2 else "residuals")
    assert covers(hits, n), f"{hits} of {n}"
    if of.drift == 0.0:
        assert called == n - hits


A_YEAR = {  # without drift
    "tested each month": Ageing(years=13, apart=1.0 / 12.0, drift=0.0, certificate_years=99),
    "tested each month, another certificate halfway": Ageing(
        years=13, apart=1.0 / 12.0, drift=0.0, certificate_years=7
    ),
    "tested each quarter": Ageing(years=5, apart=0.25, drift=0.0, certificate_years=99),
    "tested each quarter, and it wanders": Ageing(years=5, apart=0.25, drift=0.0, wander=0.03),
    "tested at both ends": Ageing(years=2, drift=0.0, certificate_years=99),
    "tested at both ends, another certificate": Ageing(years=2, drift=0.0, certificate_years=1, runs=3),
}


@pytest.mark.parametrize(
    ("name", "n"),
    [("tested at both ends", 100), *(pytest.param(one, sized(1000, 300), marks=pytest.mark.slow) for one in A_YEAR)],
)
def test_a_year_without_drift_is_called_one_in_at_most_5_of_100(name: str, n: int) -> None:
    """Of one axis, and of any of three by Holm's step-down; the interval of the drift holds 0 in the others."""
    alone = any_of_three = 0
    for seed in range(1, n + 1):
        rng = np.random.default_rng(seed)
        lives = [life(A_YEAR[name], rng) for _ in range(3)]
        p_values = [line(one.years, figures(one)).p_value for one in lives]
        alone += p_values[0] < 0.05
        any_of_three += any(holm(p_values, 0.05))
    print(f"{name}: {alone} of {n} called a drift, {any_of_three} of three axes")
    assert covers(n - alone, n), f"{alone} of {n}"
    assert covers(n - any_of_three, n), f"{any_of_three} of {n}"


DEPARTED = {  # with the year of the step, or of the odd test
    "ages with the logarithm of the years": (Ageing(curve=0.3, certificate_years=99), "bend", 0),
    "adjusted, and nobody said so": (Ageing(adjusted=5, by=0.4, certificate_years=99), "jump", 5),
    "another unit's serial number": (Ageing(swapped=5, certificate_years=99), "odd", 5),
    "rad/s for deg/s": (Ageing(factor=1.0 / 57.3, certificate_years=99), "odd", 5),
    "% for 1": (Ageing(factor=100.0, odd=10, certificate_years=99), "odd", 10),
}


@pytest.mark.parametrize("name", list(DEPARTED))
def test_what_is_no_line_is_named(name: str) -> None:
    """Where it is clear; another unit, or a factor, may lie by the line by chance, and then does little to it."""
    of, kind, index = DEPARTED[name]
    n, named, seen = sized(1000, 40), 0, 0
    for seed in range(1, n + 1):
        found = fitted(of, seed, told=False).departure
        assert found is not None
        seen += found.p_value < 0.05
        named += found.p_value < 0.05 and (found.kind, found.index) == (kind, index)
    assert seen >= 0.85 * n, f"{seen} of {n} seen"
    assert named >= 0.8 * seen, f"{named} of {seen} named"


@pytest.mark.parametrize("name", ["certificates of four years", "three tests", "adjusted halfway", "a wander"])
def test_a_line_is_called_no_line_in_at_most_5_of_100(name: str) -> None:
    n, called = sized(1000, 100), 0
    for seed in range(1, n + 1):
        found = fitted(CASES[name], seed).departure
        called += found is not None and found.p_value < 0.05
    assert covers(n - called, n), f"{called} of {n}"

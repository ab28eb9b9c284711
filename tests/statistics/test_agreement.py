"""Which values disagree with the others: false alarms, power, and what nobody can tell."""

from typing import Any

import numpy as np
import pytest

from inertialcal.statistics import _kernels_levels as kernels
from inertialcal.statistics.agreement import MANY, disagreeing, repeated_median_lines

CAMPAIGNS = 400


@pytest.mark.parametrize("n", [3, 5, 8])
def test_few_false_alarms_where_the_scatter_is_unknown(n: int) -> None:
    """At a chance of 10 % the bound of Bonferroni holds, and is not far from it."""
    rng = np.random.default_rng(n)
    found = [disagreeing(rng.standard_normal(n), alpha=0.1).any() for _ in range(CAMPAIGNS)]
    assert 0.02 < np.mean(found) < 0.11


def test_a_known_scatter_is_a_floor() -> None:
    """Four values that happen to be close do not make the fifth an odd one, as each is known to 0.1 only."""
    values = [1.0, 1.0001, 1.0002, 0.9999, 1.1]
    assert disagreeing(values).tolist() == [False] * 4 + [True]
    assert not disagreeing(values, u=0.1).any()


def test_an_uncertain_value_may_be_far_off() -> None:
    """A value of large uncertainty does not disagree, one that is well known does."""
    values = np.array([1.0, 1.001, 0.999, 1.0005, 1.2])
    assert disagreeing(values, u=[1e-3] * 5)[4]
    assert not disagreeing(values, u=[1e-3] * 4 + [0.1]).any()


@pytest.mark.parametrize("bad", [1, 2, 3])
def test_nearly_half_may_be_bad(bad: int) -> None:
    """Bad values, alike or not, neither hide each other nor make good ones look bad."""
    rng = np.random.default_rng(bad)
    for spread in (0.0, 1.0):
        values = 1.0 + 1e-4 * rng.standard_normal(7)
        values[:bad] = -1.0 + spread * rng.random(bad)
        assert disagreeing(values).tolist() == [True] * bad + [False] * (7 - bad)


def test_of_two_both_are_named_where_their_scatter_is_known_otherwise() -> None:
    """Nobody knows which of two is wrong; without another source of the scatter, nobody knows that any is."""
    assert not disagreeing([1.0, -1.0]).any()
    assert disagreeing([1.0, -1.0], scatter=1e-4, dof=4.0).all()
    assert not disagreeing([1.0, 1.0001], scatter=1e-4, dof=4.0).any()


def test_half_against_half_names_all() -> None:
    """Two against two: all are named."""
    assert disagreeing([1.0, 1.0001, 2.0, 2.0001], scatter=1e-4, dof=4.0).all()


def test_two_percent_in_one_of_five() -> None:
    """A run that reads 2 % more, the others within 1e-4 of each other."""
    rng = np.random.default_rng(1)
    found = [disagreeing(1.0 + 1e-4 * rng.standard_normal(5) + [0, 0, 0.02, 0, 0], 1e-4, 3e-4) for _ in range(200)]
    assert np.mean([one.tolist() == [False, False, True, False, False] for one in found]) > 0.95


def test_equal_values_and_missing_ones() -> None:
    """Exactly equal values agree; a missing one neither agrees nor disagrees."""
    assert not disagreeing([2.0, 2.0, 2.0]).any()
    assert disagreeing([2.0, 2.0, 2.0, 2.1, np.nan]).tolist() == [False, False, False, True, False]
    assert not disagreeing([np.nan, 1.0]).any()
    assert not disagreeing([]).any()


def directly(x: Any, y: Any) -> tuple[float, float]:
    """Repeated medians as they are defined."""
    middles = []
    for i in range(len(x)):
        slopes = [(y[i] - y[j]) / (x[i] - x[j]) for j in range(len(x)) if x[i] != x[j]]
        middles += [np.median(slopes)] if slopes else []
    slope = float(np.median(middles)) if middles else np.nan
    return slope, float(np.median(y - slope * x)) if middles else np.nan


@pytest.mark.parametrize("places", ["apart", "shared"])
@pytest.mark.parametrize("n", [2, 3, 8, 13])
def test_repeated_medians_side_by_side(n: int, places: str) -> None:
    rng = np.random.default_rng(n)
    x, y = rng.normal(size=(5, 1, n)), rng.normal(size=(2, 5, 8, n))
    if places == "shared":
        x = np.round(x)
        x[1], y[0, 2] = 1.0, np.round(y[0, 2])
    assert y[..., 0].size > MANY
    expected = [[[directly(x[i, 0], line) for line in lines] for i, lines in enumerate(unit)] for unit in y]
    every = repeated_median_lines(x, y)
    np.testing.assert_allclose(np.stack(every, axis=-1), expected, rtol=1e-12)
    for u, unit in enumerate(y):  # few, by themselves
        for i, lines in enumerate(unit):
            for one, all_of_them in zip(repeated_median_lines(x[i], lines), every, strict=True):
                np.testing.assert_array_equal(one, all_of_them[u, i])
    slope, level = np.empty((2, y[..., 0].size))
    columns = [np.ascontiguousarray(np.broadcast_to(own, y.shape).reshape(-1, n).T) for own in (x, y)]
    plain: Any = kernels.fill_lines
    plain.py_func(*columns, slope, level)
    np.testing.assert_array_equal(np.stack((slope, level)), [own.ravel() for own in every])


def test_numbers_in_order_by_exchanges_without_the_compiler() -> None:
    rows = np.random.default_rng(1).normal(size=(11, 6)).round(1)
    expected, inner = np.sort(rows, axis=0), [getattr(kernels, name) for name in ("_put_in_order", "_exchange")]
    inner[0].py_func(rows)
    np.testing.assert_array_equal(rows, expected)
    low, high = np.array([2.0, 1.0]), np.array([1.0, 2.0])
    inner[1].py_func(low, high)
    assert low.tolist() == [1.0, 1.0]
    assert high.tolist() == [2.0, 2.0]

"""Which values disagree with the others: false alarms, power, and what nobody can tell."""

import numpy as np
import pytest

from inertialcal.statistics.agreement import disagreeing

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

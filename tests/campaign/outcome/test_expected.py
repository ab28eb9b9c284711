"""How many intervals of a campaign hold the truth: the range against counts of errors drawn by another route."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy import stats

from inertialcal.campaign.twins.expected import expected_range
from inertialcal.statistics.intervals import binomial_interval

Row = dict[str, Any]
CAMPAIGNS = 600


def row(test: str, quantity: str, axis: str, u: float, dof: float | None, shared: dict[str, float]) -> Row:
    figure = {"quantity": quantity, "axis": axis, "sensor": "", "power": 0, "at": None}
    return figure | {"test": test, "value": value_of(test, quantity, axis), "u": u, "dof": dof, "shared": shared}


def value_of(*names: str) -> float:
    return float(sum(ord(letter) * 31**place for place, letter in enumerate("".join(names))))


def key(one: Row) -> Row:
    return {name: one[name] for name in ("quantity", "axis", "sensor", "power", "at")}


def drawn(rng: np.random.Generator, standards: dict[str, float], dof: float | None) -> tuple[list[Row], list[Row], Any]:
    """Return rows and covariances of a made-up campaign, and errors over u of campaigns like it, (CAMPAIGNS, n).

    Three tests: each has a covariance of its own scatter (a random matrix of low rank), and all feel the standards.
    """
    rows: list[Row] = []
    covariances: list[Row] = []
    errors = []
    drawn_standards = {name: rng.standard_normal(CAMPAIGNS) for name in standards}
    for test in ("one", "two", "three"):
        n = 12
        mixing = rng.standard_normal((n, 4)) * rng.uniform(0.1, 3.0, n)[:, None]
        own = mixing @ mixing.T
        changes = {name: size * rng.standard_normal(n) for name, size in standards.items()}
        whole = own + sum(np.outer(one, one) for one in changes.values())
        u = np.sqrt(np.diag(whole))
        of = [{name: float(each[number]) for name, each in changes.items()} for number in range(n)]
        mine = [row(test, f"q{number}", "x", float(u[number]), dof, of[number]) for number in range(n)]
        rows += mine
        covariances.append({"test": test, "keys": [key(one) for one in mine], "matrix": whole.tolist()})
        error = rng.standard_normal((CAMPAIGNS, 4)) @ mixing.T
        error += sum(drawn_standards[name][:, None] * one for name, one in changes.items())
        if dof is not None:  # u as estimated: with one draw of the scatter for the test
            error = error / np.sqrt(rng.chisquare(dof, CAMPAIGNS) / dof)[:, None]
        errors.append(error / u)
    return rows, covariances, np.hstack(errors)


@pytest.mark.parametrize("standards", [{}, {"table.rate": 0.5}, {"table.rate": 5.0, "site.latitude": 2.0}])
@pytest.mark.parametrize("dof", [None, 4.0])
def test_the_range_holds_95_percent_of_counts(standards: dict[str, float], dof: float | None) -> None:
    rng = np.random.default_rng(17)
    rows, covariances, errors = drawn(rng, standards, dof)
    low, high = expected_range(rows, covariances)
    factor = 1.959963985 if dof is None else float(stats.t.ppf(0.975, dof))
    counts = (np.abs(errors) <= factor).sum(axis=1)
    inside = int(((counts >= low) & (counts <= high)).sum())
    assert binomial_interval(inside, CAMPAIGNS, 0.999)[1] >= 0.95
    if len(standards) > 1:  # what errors counted apart would promise does not hold
        least, most = stats.binom.ppf([0.025, 0.975], len(rows), 0.95)
        held = int(((counts >= least) & (counts <= most)).sum())
        assert binomial_interval(held, CAMPAIGNS, 0.999)[1] < 0.95


def test_independent_figures_give_the_binomial_range() -> None:
    rows = [row("t", f"q{number}", "xyz"[number % 3], 1.0, None, {}) for number in range(100)]
    low, high = expected_range(rows)
    assert abs(low - stats.binom.ppf(0.025, 100, 0.95)) <= 1
    assert abs(high - stats.binom.ppf(0.975, 100, 0.95)) <= 1


def test_one_number_in_two_rows_misses_in_both() -> None:
    one = [row("t", f"q{number}", "x", 1.0, None, {}) for number in range(40)]
    both = [*one, *({**each, "test": "model"} for each in one)]
    low, high = expected_range(both)
    alone = expected_range(one)
    assert (low, high) == (2 * alone[0], 2 * alone[1])


def test_figures_that_share_all_of_their_error_miss_together() -> None:
    rows = [row(f"t{number}", "scale_factor_error", "x", 2.0, None, {"table.rate": 2.0}) for number in range(30)]
    assert expected_range(rows) == (0, 30)  # all miss in 5 %, which is more than 2.5 %
    assert expected_range([]) == (0, 0)


@pytest.mark.parametrize("drawn_at", [0.0, 2.5, -4.0])
def test_an_error_that_is_known_is_no_chance(drawn_at: float) -> None:
    """Of 40 figures half feel a standard: where it is known to be far off they miss, and the others do as ever."""
    rng = np.random.default_rng(23)
    change = 0.9
    rows = [
        row(f"t{number}", "q", "x", 1.0, None, {"table.rate": change} if number < 20 else {}) for number in range(40)
    ]
    low, high = expected_range(rows, drawn={"table.rate": drawn_at})
    own = np.sqrt(1.0 - change**2) * rng.standard_normal((CAMPAIGNS, 20)) + change * drawn_at
    others = rng.standard_normal((CAMPAIGNS, 20))
    counts = (np.abs(np.hstack([own, others])) <= 1.959963985).sum(axis=1)
    inside = int(((counts >= low) & (counts <= high)).sum())
    assert binomial_interval(inside, CAMPAIGNS, 0.999)[1] >= 0.95
    assert high - low <= 12


def test_a_model_is_as_far_off_as_the_test_that_it_is_taken_from() -> None:
    tested = [row("t", f"q{number}", "x", 1.0, None, {}) for number in range(30)]
    keys = [key(one) for one in tested]
    covariance = {"test": "t", "keys": keys, "matrix": (0.9 + 0.1 * np.eye(30)).tolist()}
    model = [one | {"test": "model", "value": one["value"] * 1.001} for one in tested]
    both = expected_range([*tested, *model], [covariance], {"model": ["t"]})
    alone = expected_range(tested, [covariance])
    assert both[1] == 2 * alone[1] == 60
    assert abs(both[0] - 2 * alone[0]) <= 4  # of what 20,000 draws leave uncertain
    apart = expected_range([*tested, *model], [covariance])
    assert apart[0] > both[0] + 6


def test_the_same_results_give_the_same_range() -> None:
    rng = np.random.default_rng(5)
    rows, covariances, _ = drawn(rng, {"table.rate": 1.0}, 6.0)
    assert expected_range(rows, covariances) == expected_range(rows, covariances)
    assert all(math.isfinite(end) for end in expected_range(rows, covariances))

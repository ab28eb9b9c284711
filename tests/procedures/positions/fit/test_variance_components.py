"""Variances found by restricted maximum likelihood: closed forms of balanced groups, and what is zero or unknown."""

from __future__ import annotations

import numpy as np
import pytest

from inertialcal.core.errors import DataError
from inertialcal.core.estimate import Array
from inertialcal.procedures.positions.fit.variance_components import Components, fit_components

GROUPS, EACH = 8, 4
SAME: Array = np.asarray(np.kron(np.eye(GROUPS), np.ones((EACH, EACH))), dtype=np.float64)


def groups(between: float, within: float, seed: int = 1) -> tuple[Array, Components]:
    rng = np.random.default_rng(seed)
    y = 5.0 + np.repeat(between * rng.standard_normal(GROUPS), EACH) + within * rng.standard_normal(GROUPS * EACH)
    unknown = {"groups": SAME, "readings": np.eye(len(y))}
    return y, fit_components(np.ones((len(y), 1)), y, {}, unknown)


def test_balanced_groups_are_those_of_the_analysis_of_variance() -> None:
    y, found = groups(2.0, 1.0)
    table = y.reshape(GROUPS, EACH)
    within = float(table.var(axis=1, ddof=1).mean())
    between = float(table.mean(axis=1).var(ddof=1)) - within / EACH
    assert found.variances == pytest.approx({"groups": between, "readings": within}, rel=1e-4)
    assert found.coefficients == pytest.approx([y.mean()])
    assert found.covariance[0, 0] == pytest.approx(table.mean(axis=1).var(ddof=1) / GROUPS, rel=1e-4)
    assert found.variance_dof("readings") == pytest.approx(GROUPS * (EACH - 1), rel=1e-3)
    assert found.chi_square == pytest.approx(found.free, rel=1e-3)
    assert sum(found.unknown.values()) == pytest.approx(found.covariance)


def test_no_variance_falls_below_zero_and_its_uncertainty_stays() -> None:
    y, found = next(one for one in (groups(0.0, 1.0, seed) for seed in range(20)) if one[1].variances["groups"] == 0.0)
    assert found.variances["readings"] == pytest.approx(float(y.var(ddof=1)), rel=1e-4)
    assert found.variance_dof("groups") == 0.0
    assert found.variances_covariance[0, 0] > 0.0


def test_known_variance_is_taken_off() -> None:
    y, whole = groups(0.0, 1.0)
    some = fit_components(
        np.ones((len(y), 1)), y, {"noise": 0.3 * np.eye(len(y))}, {"groups": SAME, "readings": np.eye(len(y))}
    )
    assert some.variances["readings"] + 0.3 == pytest.approx(whole.variances["readings"], rel=1e-3)
    assert some.known["noise"][0, 0] + sum(one[0, 0] for one in some.unknown.values()) == pytest.approx(
        some.covariance[0, 0]
    )


@pytest.mark.parametrize(("y", "code"), [(np.ones(1), "no_dof"), (np.ones(4), "no_scatter")])
def test_refusals(y: Array, code: str) -> None:
    with pytest.raises(DataError) as caught:
        fit_components(np.ones((len(y), 1)), y, {}, {"readings": np.eye(len(y))})
    assert caught.value.problems[0].code == code

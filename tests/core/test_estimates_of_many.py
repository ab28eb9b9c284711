"""Estimates of many units at once: each as alone; the degrees of freedom of joined parts by a series."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import special

from inertialcal.core.errors import DataError
from inertialcal.core.estimate import Component, Estimate, Sources, joined_dof
from inertialcal.core.influence import Influence
from inertialcal.core.key import Key, Origin

UNITS = 5
SERIES = 1e-11  # relative, of the degrees of freedom
TABLE = Influence(0.3, "1", standard="rate_table", quantity="rate")


def sources(sizes: list[int], rng: np.random.Generator) -> list[Sources]:
    """Return scatter, a standard, and one that some units have alone."""
    most = max(sizes)
    covariance, changes, some = np.zeros((UNITS, most, most)), np.zeros((UNITS, 2, most)), np.zeros((UNITS, 1, most))
    dof = np.full((UNITS, most), np.inf)
    for i, k in enumerate(sizes):
        root = rng.normal(size=(k, k))
        covariance[i, :k, :k] = root @ root.T
        covariance[i] = 0.5 * (covariance[i] + covariance[i].T)
        dof[i, :k], changes[i, :, :k], some[i, :, :k] = rng.uniform(1.0, 9.0, k), rng.normal(size=(2, k)), 0.1 * i
    origin = Origin("scatter between runs", level="run")
    there = np.arange(UNITS) % 2 == 1
    some[~there] = 0.0
    hidden = Sources.of_changes("hidden", some)
    return [
        Sources(origin, "A", covariance, dof, "t"),
        Sources.of_influence(TABLE.origin("table"), changes, TABLE, ("a", "b")),
        Sources("hidden", "B", hidden.covariance, there=there),
    ]


@pytest.mark.parametrize("sizes", [[3] * UNITS, [1, 4, 2, 4, 3]])
def test_estimates_of_units_are_those_of_each_alone(sizes: list[int]) -> None:
    rng = np.random.default_rng(2)
    values, each = rng.normal(size=(UNITS, max(sizes))), sources(sizes, rng)
    keys = [tuple(Key("bias", f"a{j}") for j in range(k)) for k in sizes]
    units = [("rad/s",) * k for k in sizes]
    for i, found in enumerate(Estimate.of_each(keys, values, units, each)):
        k = sizes[i]
        parts = [
            Component(one.given, one.kind, one.covariance[i, :k, :k],
                      one.dof if isinstance(one.dof, float) else one.dof[i, :k], one.distribution,
                      TABLE.stated if one.unknowns else None,
                      None if one.changes is None else one.changes[i, :, :k], one.unknowns)
            for one in each if one.there is None or one.there[i]
        ]  # fmt: skip
        alone = Estimate(keys[i], values[i, :k], units[i], tuple(parts))
        assert isinstance(found, Estimate)
        assert found.keys == alone.keys
        assert len(found.components) == len(alone.components)
        for name in ("values", "covariance", "u", "dof", "changes"):
            assert getattr(found, name).tobytes() == getattr(alone, name).tobytes()


def test_the_unit_whose_covariance_is_none_is_refused_alone() -> None:
    covariance = np.tile(np.eye(2), (3, 1, 1))
    covariance[1, 0, 0] = np.nan
    keys = (Key("bias", "x"), Key("bias", "y"))
    found = Estimate.of_each([keys] * 3, np.zeros((3, 2)), [("1", "1")] * 3, [Sources("scatter", "A", covariance)])
    assert [isinstance(one, DataError) for one in found] == [False, True, False]


@pytest.mark.parametrize("dof", [0.6, 1.0, 1.3, 2.0, 7.5, 60.0, 499.0, 501.0, 1e4])
def test_joined_degrees_of_freedom_have_the_t_of_the_interval(dof: float) -> None:
    share = 0.7
    found = float(joined_dof([np.array([share]), np.array([1.0 - share])], [dof, np.inf])[0])
    z, t = float(special.ndtri(0.975)), float(special.stdtrit(dof, 0.975))
    square = z**2 + share ** max(1.0, 2.0 - 1.5 / dof) * (t**2 - z**2)
    reached = float(special.stdtrit(found, 0.975)) ** 2 - z**2
    assert reached == pytest.approx(square - z**2, rel=max(SERIES, 1e-13 * dof))

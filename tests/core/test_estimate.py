"""Estimate: covariances add, degrees of freedom are those whose t gives an interval that holds 95 %."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import special

from inertialcal.core.errors import DataError
from inertialcal.core.estimate import Array, Component, Estimate, Sources, fewer_joined, joined_dof
from inertialcal.core.influence import Influence
from inertialcal.core.key import Key, Origin

NAMES = ("scale_factor", "bias")
UNITS = ("V/(deg/s)", "deg/s")
SCATTER = Component("scatter between dwells", "A", np.array([[4e-6, 1e-6], [1e-6, 9e-6]]), dof=11.0)
TABLE = Component("table rate", "B", np.array([[1e-6, 0.0], [0.0, 0.0]]), distribution="rectangular")

COUNT = 5
SERIES = 1e-11  # relative, of the degrees of freedom
CERTIFIED = Influence(0.3, "1", standard="rate_table", quantity="rate")


def estimate(*components: Component) -> Estimate:
    return Estimate(NAMES, np.array([0.5, -0.01]), UNITS, components or (SCATTER, TABLE))


def test_components_add() -> None:
    np.testing.assert_allclose(estimate().covariance, [[5e-6, 1e-6], [1e-6, 9e-6]], rtol=1e-15)
    np.testing.assert_allclose(estimate().u, np.sqrt([5e-6, 9e-6]), rtol=1e-15)
    np.testing.assert_allclose(SCATTER.u, [2e-3, 3e-3], rtol=1e-15)


def test_degrees_of_freedom_of_the_guides_end_gauge() -> None:
    """JCGM 100:2008, H.1.6: 25, 9.7, 2.9, 16.6 nm with 18, 25.6, 50, 2 give 16; the last counts for more here."""
    parts = [(25.0, 18.0), (9.7, 25.6), (2.9, 50.0), (16.6, 2.0)]
    components = tuple(Component(f"source {u}", "B", np.array([[u**2]]), dof=dof) for u, dof in parts)
    gauge = Estimate(("length",), np.array([50.000838e6]), ("nm",), components)
    assert gauge.u[0] == pytest.approx(32.0, abs=0.5)
    assert 2.0 < gauge.dof[0] < 16.0
    many = [replace(one, dof=100.0 * one.dof) for one in components]
    welch = 32.0**4 / sum(u**4 / (100.0 * dof) for u, dof in parts)
    assert replace(gauge, components=tuple(many)).dof[0] == pytest.approx(welch, rel=0.06)


@pytest.mark.parametrize("probability", [0.95, 0.9])
@pytest.mark.parametrize("dof", [1.0, 2.0, 4.0, 9.0])
def test_intervals_hold_95_percent_where_few_dof_join_known_parts(dof: float, probability: float) -> None:
    """Coverage by quadrature over what the scatter may come out as; Welch-Satterthwaite falls to 87 % with dof 1."""
    steps = (np.arange(4000) + 0.5) / 4000
    found = special.chdtri(dof, 1.0 - steps) / dof  # variance found over the true one
    for ratio in (0.1, 0.3, 1.0, 3.0, 10.0):
        variance = ratio**2 * found
        joined = joined_dof([variance, np.ones(4000)], [dof, np.inf])
        k = np.where(np.isinf(joined), 1.96, special.stdtrit(np.minimum(joined, 1e8), 0.5 * (1.0 + probability)))
        rate = np.mean(1.0 - 2.0 * special.ndtr(-k * np.sqrt((variance + 1.0) / (ratio**2 + 1.0))))
        assert probability - 6e-4 < rate < probability + (0.07 if dof == 1.0 else 0.037)


def test_intervals_hold_95_percent_where_two_scatters_of_few_degrees_of_freedom_join() -> None:
    rng = np.random.default_rng(21)
    n = 20_000
    for dofs in ((1.0, 4.0), (2.0, 9.0), (4.0, 4.0), (1.0, 1.0)):
        for ratio in (0.3, 1.0, 3.0):
            variances = [size**2 * rng.chisquare(dof, n) / dof for size, dof in zip((ratio, 1.0), dofs, strict=True)]
            k = special.stdtrit(joined_dof(variances, list(dofs)), 0.975)
            error = np.hypot(ratio, 1.0) * rng.standard_normal(n)
            assert np.mean(np.abs(error) <= k * np.sqrt(sum(variances))) > 0.95 - 3.3 * np.sqrt(0.05 * 0.95 / n)


def test_degrees_of_freedom_one_source_many_known_and_none() -> None:
    np.testing.assert_allclose(estimate(SCATTER).dof, [11.0, 11.0])
    assert 15.0 < estimate().dof[0] < 11.0 * (5.0 / 4.0) ** 2
    assert estimate().dof[1] == 11.0
    np.testing.assert_array_equal(estimate(TABLE).dof, [np.inf, np.inf])
    exact = Estimate(NAMES, np.zeros(2), UNITS, ())
    np.testing.assert_array_equal(exact.u, [0.0, 0.0])
    np.testing.assert_array_equal(exact.dof, [np.inf, np.inf])


def test_whether_parts_join_to_fewer_degrees_of_freedom_than_asked() -> None:
    rng = np.random.default_rng(1)
    variances = rng.exponential(size=(3, 2000)) * rng.integers(0, 2, size=(3, 2000))
    each, asked = np.exp(rng.uniform(-1.0, 8.0, size=(2, 2000)))
    joined = joined_dof(list(variances), [each] * 3)
    clear = np.abs(joined - asked) > 1e-6 * asked
    found = (each < asked) & (fewer_joined(variances, asked)(each, np.arange(len(each))) > 1.0)
    assert np.array_equal(found[clear], (joined < asked)[clear])


def test_degrees_of_freedom_of_each_value() -> None:
    two = Component("scatter", "A", np.diag([1.0, 1.0]), dof=np.array([3.0, np.inf]))
    np.testing.assert_allclose(estimate(two).dof, [3.0, np.inf])


variances = st.floats(1e-3, 1e3)


@given(st.lists(st.tuples(variances, st.floats(1.0, 1e4)), min_size=1, max_size=5), st.floats(-90.0, 90.0))
def test_degrees_of_freedom_lie_between_smallest_and_sum_in_any_unit(
    parts: list[tuple[float, float]], decade: float
) -> None:
    def dof(scale: float) -> float:
        components = tuple(Component("c", "A", np.array([[scale * v]]), dof=nu) for v, nu in parts)
        return float(Estimate(("x",), np.zeros(1), ("1",), components).dof[0])

    smallest, total = min(nu for _, nu in parts), sum(nu for _, nu in parts)
    assert smallest * (1.0 - 1e-9) <= dof(1.0) <= total * (1.0 + 1e-6)
    assert dof(10.0 ** (2.0 * decade)) == pytest.approx(dof(1.0), rel=1e-9)


def test_select_takes_values_and_covariance_in_the_order_asked_for() -> None:
    own = Component("scatter", "A", SCATTER.covariance, dof=np.array([3.0, 7.0]))
    turned = estimate(own).select(["bias", "scale_factor"])
    assert turned.names == ("bias", "scale_factor")
    assert turned.units == ("deg/s", "V/(deg/s)")
    np.testing.assert_array_equal(turned.values, [-0.01, 0.5])
    np.testing.assert_array_equal(turned.covariance, [[9e-6, 1e-6], [1e-6, 4e-6]])
    np.testing.assert_allclose(turned.dof, [7.0, 3.0])
    assert turned.components[0].source == "scatter"
    assert estimate().select(["bias"]).components[1].distribution == "rectangular"


def test_value_and_index_by_name() -> None:
    assert estimate().value("bias") == -0.01
    assert estimate().index("bias") == 1
    for ask in (estimate().value, estimate().index, lambda name: estimate().select([name])):
        with pytest.raises(DataError, match=r"no value 'gain'\. There are: scale_factor, bias"):
            ask("gain")


def test_as_text_and_as_frame() -> None:
    lines = str(estimate()).splitlines()
    assert lines[0].startswith("2 value(s); uncertainty from: ")
    assert lines[1].split() == ["name", "value", "±", "u", "unit", "dof"]
    assert lines[2].split() == ["scale_factor", "0.5000", "±", "0.0022", "V/(deg/s)", "15.8"]
    assert len(lines) == 4
    frame = estimate().to_frame()
    assert list(frame.index) == list(NAMES)
    assert list(frame.columns) == ["value", "u", "unit", "dof"]
    assert frame.loc["bias", "u"] == pytest.approx(3e-3)


@pytest.mark.parametrize(
    ("names", "values", "units", "words"),
    [
        (("a", "b"), np.zeros(3), ("1", "1"), r"2 names, values of shape \(3,\), 2 units"),
        (("a", "b"), np.zeros(2), ("1",), r"2 names, values of shape \(2,\), 1 units"),
        (("a", "a"), np.zeros(2), ("1", "1"), "a name appears twice"),
    ],
)
def test_shapes_that_disagree(names: Any, values: Array, units: Any, words: str) -> None:
    with pytest.raises(DataError, match=words):
        Estimate(names, values, units, ())


@pytest.mark.parametrize(
    ("covariance", "dof", "words"),
    [
        (np.eye(3), 1.0, r"covariance of shape \(3, 3\), need \(2, 2\)"),
        (np.diag([1.0, np.nan]), 1.0, "covariance is not finite. Leave out what is not estimated"),
        (np.diag([1.0, -1.0]), 1.0, "not a covariance"),
        (np.array([[1.0, 0.5], [0.4, 1.0]]), 1.0, "not a covariance"),
        (np.eye(2), 0.0, "degrees of freedom 0.0, need 2 positive ones"),
        (np.eye(2), np.nan, "degrees of freedom nan"),
        (np.eye(2), np.array([1.0, -2.0]), "need 2 positive ones"),
        (np.eye(2), np.ones(3), "need 2 positive ones or one for all"),
    ],
)
def test_components_that_are_none(covariance: Array, dof: Array | float, words: str) -> None:
    with pytest.raises(DataError, match=f"drift: .*{words}"):
        estimate(Component("drift", "A", covariance, dof))


def test_a_covariance_is_symmetric_but_for_rounding() -> None:
    """Two orders of a sum of 1e6 numbers differ by less than 1e-10; a mistake of 1e-8 is none of rounding."""
    size = np.diag([1e-3, 1e4])
    for asymmetry, allowed in ((1e-10, True), (1e-8, False)):
        part = Component("fit", "A", size @ np.array([[1.0, 0.5], [0.5 + asymmetry, 1.0]]) @ size)
        if allowed:
            assert estimate(part).u == pytest.approx([1e-3, 1e4])
        else:
            with pytest.raises(DataError, match="not symmetric"):
                estimate(part)


def test_the_sources_own_uncertainty_stays_with_a_selection() -> None:
    rate = replace(TABLE, stated=(5e-4, "1"))
    chosen = estimate(SCATTER, rate).select(NAMES[:1])
    assert [component.stated for component in chosen.components] == [None, (5e-4, "1")]


def test_a_source_that_contributes_has_an_uncertainty_of_its_own() -> None:
    with pytest.raises(DataError, match="table rate: contributes, but its own uncertainty is 0"):
        estimate(replace(TABLE, stated=(0.0, "1")))


def sources_of_units(sizes: list[int], rng: np.random.Generator) -> list[Sources]:
    """Return scatter, a standard, and one that some units have alone."""
    most = max(sizes)
    covariance, changes, some = np.zeros((COUNT, most, most)), np.zeros((COUNT, 2, most)), np.zeros((COUNT, 1, most))
    dof = np.full((COUNT, most), np.inf)
    for i, k in enumerate(sizes):
        root = rng.normal(size=(k, k))
        covariance[i, :k, :k] = root @ root.T
        covariance[i] = 0.5 * (covariance[i] + covariance[i].T)
        dof[i, :k], changes[i, :, :k], some[i, :, :k] = rng.uniform(1.0, 9.0, k), rng.normal(size=(2, k)), 0.1 * i
    origin = Origin("scatter between runs", level="run")
    there = np.arange(COUNT) % 2 == 1
    some[~there] = 0.0
    hidden = Sources.of_changes("hidden", some)
    return [
        Sources(origin, "A", covariance, dof, "t"),
        Sources.of_influence(CERTIFIED.origin("table"), changes, CERTIFIED, ("a", "b")),
        Sources("hidden", "B", hidden.covariance, there=there),
    ]


@pytest.mark.parametrize("sizes", [[3] * COUNT, [1, 4, 2, 4, 3]])
def test_estimates_of_units_are_those_of_each_alone(sizes: list[int]) -> None:
    rng = np.random.default_rng(2)
    values, each = rng.normal(size=(COUNT, max(sizes))), sources_of_units(sizes, rng)
    keys = [tuple(Key("bias", f"a{j}") for j in range(k)) for k in sizes]
    units = [("rad/s",) * k for k in sizes]
    for i, found in enumerate(Estimate.of_each(keys, values, units, each)):
        k = sizes[i]
        parts = [
            Component(one.given, one.kind, one.covariance[i, :k, :k],
                      one.dof if isinstance(one.dof, float) else one.dof[i, :k], one.distribution,
                      CERTIFIED.stated if one.unknowns else None,
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

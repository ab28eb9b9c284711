"""Terms of several tests as those of one model: their covariance against closed form and simulation, and refusals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from inertialcal.core.errors import PlanError
from inertialcal.core.estimate import Component, Estimate
from inertialcal.core.key import Key, Origin
from inertialcal.procedures.model_terms import KINDS, ModelTerms, joined_terms, joined_terms_many, kind_of
from inertialcal.sensors.model.sensor_model import Provenance

BIAS, SLOPE = Key("bias", "x"), Key("bias_temperature", "x", power=1)
SCALE = Key("scale_factor_error", "x")
LATITUDE = Origin("latitude", standard="site", quantity="latitude")
SCATTER = Origin("scatter between runs", level="run")


def terms(
    values: dict[Key, float], components: tuple[Component, ...], test: str, after: tuple[str, ...] = ()
) -> ModelTerms:
    units = {"bias": "rad/s", "bias_temperature": "rad/s/degC"}
    estimate = Estimate(
        tuple(values),
        np.array(list(values.values())),
        tuple(units.get(key.quantity, "1") for key in values),
        components,
    )
    given = dict.fromkeys(values, Provenance(test, (f"{test}_1",)))
    return ModelTerms(estimate, estimate.keys, ("x",), given, tests=(test,), after=after)


def scatter(changes: list[list[float]], origin: Origin = SCATTER, dof: float = 4.0) -> Component:
    """Return a source with known unknowns: a row an unknown."""
    rows = np.array(changes)
    return Component(origin, "A", rows.T @ rows, dof, changes=rows)


def test_a_correction_and_what_was_found_after_it_cancel_where_they_met() -> None:
    """Thermal law b + c h with errors e1, e2; the later bias was read at h = 10: its error is n - e1 - 10 e2."""
    own = scatter([[3.0, 0.0], [0.0, 0.2]], Origin("scatter between runs", test="thermal", level="run"))
    first = terms({BIAS: 1.0, SLOPE: 0.5}, (own,), "thermal")
    taken = scatter([[-3.0, 0.0], [-2.0, 0.0]], Origin("scatter between runs", test="thermal", level="run"))
    noise = Component(SCATTER, "A", np.diag([0.25, 1e-4]), 6.0)
    later = terms({BIAS: 0.1, SCALE: 0.01}, (taken, noise), "rate", ("thermal",))
    whole = joined_terms([later, first])
    assert whole.estimate is not None
    estimate = whole.estimate.select([BIAS, SLOPE, SCALE])
    assert estimate.values == pytest.approx([1.1, 0.5, 0.01])
    # bias = e1 + n - e1 - 10 e2 with u(e2) = 0.2; covariance with the slope: -10 * 0.04
    want = np.array([[0.25 + 4.0, -0.4, 0.0], [-0.4, 0.04, 0.0], [0.0, 0.0, 1e-4]])
    assert estimate.covariance == pytest.approx(want)
    at_10 = np.array([1.0, 10.0, 0.0])
    assert at_10 @ estimate.covariance @ at_10 == pytest.approx(0.25)  # there only the later noise is left
    assert whole.provenance[BIAS] == Provenance("rate, thermal", ("rate_1", "thermal_1"))


def test_an_origin_that_two_parts_have_is_one_unknown_and_scatter_is_not() -> None:
    """Against a simulation of both tests with one latitude, and scatter of their own."""
    a = terms({SCALE: 0.0}, (scatter([[2.0]], LATITUDE), Component(SCATTER, "A", np.array([[1.0]]), 5.0)), "one")
    b = terms({BIAS: 0.0}, (scatter([[-3.0]], LATITUDE), Component(SCATTER, "A", np.array([[4.0]]), 3.0)), "two")
    whole = joined_terms([a, b]).estimate
    assert whole is not None
    rng = np.random.default_rng(1)
    latitude, one, two = rng.standard_normal((3, 200_000))
    simulated = np.cov(np.vstack([2.0 * latitude + one, -3.0 * latitude + 2.0 * two]))
    assert whole.covariance == pytest.approx(simulated, rel=0.02)
    assert {one.origin.test for one in whole.components if one.kind == "A" and not one.origin.standard} == {
        "one",
        "two",
    }
    assert whole.shared(SCALE) == {"site.latitude": pytest.approx(2.0)}


def test_parts_in_two_units_of_one_quantity_add_with_their_uncertainties() -> None:
    """1 rad/s with u 0.3 rad/s, and after it 1 deg/s with u 2 deg/s."""
    first = terms({BIAS: 1.0}, (Component(SCATTER, "A", np.array([[0.09]]), 5.0),), "thermal")
    later = terms({BIAS: 1.0, SCALE: 0.0}, (scatter([[2.0, 0.001]]),), "rate", ("thermal",))
    assert later.estimate is not None
    estimate = replace(later.estimate, units=("deg/s", "1"))
    whole = joined_terms([first, replace(later, estimate=estimate)]).estimate
    assert whole is not None
    place = whole.keys.index(BIAS)
    degree = 1.0 if whole.units[place] == "rad/s" else np.degrees(1.0)  # whichever comes first
    assert whole.values[place] == pytest.approx(degree * (1.0 + np.radians(1.0)))
    assert whole.covariance[place, place] == pytest.approx(degree**2 * (0.09 + np.radians(2.0) ** 2))
    covariance = whole.covariance[place, whole.keys.index(SCALE)]
    assert covariance == pytest.approx(degree * np.radians(2.0) * 0.001)


def test_one_term_of_two_tests_is_refused_with_what_decides() -> None:
    a = terms({BIAS: 0.0}, (Component(SCATTER, "A", np.array([[1.0]]), 5.0),), "one")
    b = terms({BIAS: 0.0}, (Component(SCATTER, "A", np.array([[1.0]]), 5.0),), "two")
    with pytest.raises(PlanError) as refused:
        joined_terms([a, b])
    (problem,) = refused.value.problems
    assert problem.code == "terms_twice"
    assert "one" in problem.what
    assert "two" in problem.what
    assert "[model]" in problem.do


def test_every_term_of_the_equation_has_a_kind() -> None:
    assert kind_of(SLOPE) == "bias"
    assert kind_of(Key("bias_supply", "x")) == "sensitivity"
    assert kind_of(Key("warm_up_time", power=1)) == "warm_up"
    assert {kind_of(key) for key in (BIAS, SCALE, SLOPE)} < set(KINDS)


def test_kinds_are_taken_one_by_one() -> None:
    both = terms({BIAS: 1.0, SCALE: 2.0}, (Component(SCATTER, "A", np.eye(2), 5.0),), "one")
    assert both.of_kinds(["bias"]).parameters == (BIAS,)
    assert both.of_kinds(["noise"]).parameters == ()


def test_terms_of_many_units_are_joined_as_those_of_each() -> None:
    """Units of other terms and other sources together, one part alone, one refused: to the last bit."""
    rng = np.random.default_rng(4)
    shared = Origin("latitude", standard="site", quantity="latitude")
    units = []
    for i in range(9):
        values = dict(zip((BIAS, SLOPE), rng.normal(size=2).tolist(), strict=True)) if i % 3 else {BIAS: 0.1 * i}
        law = Origin("scatter between runs", test="thermal", level="run")  # of polynomials of other orders
        own = [scatter(rng.normal(size=(2, len(values))).tolist(), shared, 4.0 + i),
               scatter(rng.normal(size=(2 + i % 4, len(values))).tolist(), law)]  # fmt: skip
        if i % 2:
            own.append(Component(SCATTER, "A", np.diag(rng.random(len(values))), 2.0 + rng.random(len(values))))
        first = terms(values, tuple(own), "thermal")
        taken = [scatter(rng.normal(size=(2 + i % 4, 1)).tolist(), law)] if i > 5 else []
        after = () if i % 4 else ("thermal",)
        later = terms({SCALE: 0.01 * i}, (scatter([[0.3 * i], [0.1]], shared), *taken), "rate", after)
        units.append([later] if i == 5 else [first, terms({BIAS: 1.0}, (), "rate")] if i == 7 else [later, first])
    found = joined_terms_many(units)
    for i, (parts, one) in enumerate(zip(units, found, strict=True)):
        if i == 7:
            assert isinstance(one, PlanError)
            continue
        alone = joined_terms(parts)
        assert isinstance(one, ModelTerms)
        assert one.estimate is not None
        assert alone.estimate is not None
        assert (one.parameters, one.provenance, one.axes) == (alone.parameters, alone.provenance, alone.axes)
        assert (one.estimate.keys, one.estimate.units) == (alone.estimate.keys, alone.estimate.units)
        for name in ("values", "covariance", "u", "dof"):
            assert getattr(one.estimate, name).tolist() == getattr(alone.estimate, name).tolist()
        for mine, its in zip(one.estimate.components, alone.estimate.components, strict=True):
            assert (mine.given, mine.unknowns) == (its.given, its.unknowns)
            assert mine.covariance.tolist() == its.covariance.tolist()
            assert (mine.changes is None) == (its.changes is None)
            assert mine.changes is None or its.changes is None or mine.changes.tolist() == its.changes.tolist()

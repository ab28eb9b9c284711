"""Thermal tests of many units at once: the same figures and remarks, to the bit, as those of each unit alone."""

from __future__ import annotations

import numpy as np
import pytest
from thermal_sweeps import path, plan, way

from inertialcal.core.errors import DataError, InertialcalError
from inertialcal.core.influence import Influence
from inertialcal.core.key import Method
from inertialcal.procedures import procedure_of, protocol
from inertialcal.procedures.thermal.correction import sources_of_each, sources_of_laws
from inertialcal.procedures.thermal.recordings import Readings, Sweep
from inertialcal.procedures.thermal.reduction import Result, reduce, reduce_many

KINDS = (
    "bent", "straight", "bent", "gap", "another length", "cold", "one way", "two loops", "runs", "one axis missing",
    "own thermometers", "bent",
)  # fmt: skip


def unit(seed: int, kind: str) -> Readings:
    """Return a unit of three axes in a chamber, simulated with numpy alone."""
    rng = np.random.default_rng(seed)
    points = {"cold": (20.0, 20.5), "one way": (-30.0, 60.0), "two loops": (0.0, 60.0, 0.0, 60.0, 0.0)}
    sweeps = []
    for run in range(4 if kind == "runs" else 1):
        t, true = path(*points.get(kind, (-30.0, 60.0, -30.0)), interval=25.0 if kind == "another length" else 10.0)
        T = true + rng.normal(0.0, 0.02, true.size)
        bent = 0.0 if kind == "straight" else 1e-5
        outputs = {
            axis: bent * (k + 1) * (true / 50.0) ** (k + 1) + 2e-6 * way(true) + rng.normal(0.0, 3e-6, true.size)
            for k, axis in enumerate("xyz")
        }
        if kind == "gap":
            outputs["y"][50:400] = np.nan
        if kind == "one axis missing":
            outputs["z"][:] = np.nan
        own = kind == "own thermometers"
        warm = {axis: T + rng.normal(0.0, 0.02, T.size) if own else T for axis in outputs}
        sweeps.append(Sweep(f"r{run}", f"r{run}", f"r{run}.csv", t, warm, outputs))
    return Readings(tuple(sweeps))


def test_units_at_once_have_the_figures_of_each_alone() -> None:
    asked = plan(at=(0.0, 40.0))
    tests = [(asked, unit(seed, kind)) for seed, kind in enumerate(KINDS)]
    together = reduce_many(tests)
    for kind, (own, readings), found in zip(KINDS, tests, together, strict=True):
        if kind == "cold":  # hardly any change of temperature
            with pytest.raises(InertialcalError) as error:
                reduce(own, readings)
            assert str(found) == str(error.value)
            continue
        alone = reduce(own, readings)
        assert isinstance(found, Result)
        assert [row.to_dict() for row in found.rows()] == [row.to_dict() for row in alone.rows()]
        assert found.remarks == alone.remarks
        assert alone.estimate is not None
        assert found.estimate is not None
        assert found.estimate.covariance.tobytes() == alone.estimate.covariance.tobytes()
    orders = {one.law.order for found in together if isinstance(found, Result) for one in found.sensors.values()}
    assert len(orders) > 2  # laws of several orders in one block


def test_terms_and_rows_of_units_at_once_are_those_of_each_alone() -> None:
    asked, thermal = plan(at=(0.0, 40.0)), procedure_of("thermal")
    tests = [(asked, unit(seed, kind)) for seed, kind in enumerate(("bent", "straight", "one way", "runs", "gap"))]
    results = [one for one in reduce_many(tests) if isinstance(one, Result)]
    assert len(results) == len(tests)
    given = [(one, [protocol.Tested("warm", "", "fit", asked, one.readings, one)]) for one in results]
    for found, one in zip(thermal.terms_many(given), given, strict=True):
        alone = thermal.terms(*one)
        assert (found is None) == (alone is None)
        if found is not None and alone is not None:
            assert found.estimate is not None
            assert alone.estimate is not None
            assert found.estimate.keys == alone.estimate.keys
            assert found.estimate.covariance.tobytes() == alone.estimate.covariance.tobytes()
            assert found.estimate.changes.tobytes() == alone.estimate.changes.tobytes()
    rows = [[row.to_dict() for row in own] for own in thermal.rows_many(results)]
    assert rows == [[row.to_dict() for row in reduce(*one).rows()] for one in tests]


def test_terms_of_a_result_are_those_of_the_correction_made_anew() -> None:
    standards = {
        "thermometer.temperature": Influence(0.5, "degC"),
        "converter.reference": Influence(1e-3, "1"),
        "site.latitude": Influence(1e-3, "rad"),
    }
    asked = plan(at=(0.0, 40.0), standards=standards)
    tests = [(asked, unit(seed, kind)) for seed, kind in enumerate(("bent", "straight", "one way", "runs", "gap"))]
    results = [one for one in reduce_many(tests) if isinstance(one, Result)]
    for found, want in zip(sources_of_laws(results), sources_of_each(results), strict=True):
        assert not isinstance(found, DataError)
        assert not isinstance(want, DataError)
        (estimate, sources), (again, others) = found, want
        assert (estimate is None) == (again is None)
        if estimate is None or again is None:
            continue
        assert estimate.keys == again.keys
        assert estimate.units == again.units
        np.testing.assert_allclose(estimate.values, again.values, rtol=1e-12)
        np.testing.assert_allclose(estimate.covariance, again.covariance, rtol=1e-12)
        assert [str(one.given) for one, _ in sources] == [str(one.given) for one, _ in others]
        for (_, mine), (_, its) in zip(sources, others, strict=True):
            np.testing.assert_allclose(mine, its, rtol=1e-9, atol=1e-30)


def test_the_published_cubic_of_many_samples_is_that_of_numpy() -> None:
    result = reduce(plan(), unit(3, "runs"))
    rows = {row.key.power: row for row in result.rows() if row.method is Method.TEXTBOOK and row.key.axis == "x"}
    sensor = result.sensors["x"]
    used = ~(sensor.series.time < sensor.start_up.cut)
    assert np.count_nonzero(used) > 1000  # by their moments
    x, y = sensor.series.temperature[used] - result.plan.reference_temperature, sensor.series.reading[used]
    found, covariance = np.polyfit(x, y, 3, cov=True)
    for power in range(1, 4):
        value, u = rows[power].value, rows[power].u
        assert value == pytest.approx(found[3 - power], rel=1e-8)
        assert u == pytest.approx(np.sqrt(covariance[3 - power, 3 - power]), rel=1e-8)

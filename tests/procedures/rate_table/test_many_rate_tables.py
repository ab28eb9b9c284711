"""Rate tables of many units at once: the same figures and remarks, to the bit, as those of each unit alone."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from inertialcal.core.errors import InertialcalError
from inertialcal.core.influence import Influence
from inertialcal.procedures import procedure_of
from inertialcal.procedures.rate_table.agreement import agreement_many
from inertialcal.procedures.rate_table.plan import Attitude, Plan
from inertialcal.procedures.rate_table.readings import Readings
from inertialcal.procedures.rate_table.reduction import Result, reduce, reduce_many

DEG = np.pi / 180.0
FAULTS = (
    "none", "outlier", "empty cells", "empty column", "dwells missing", "one sense", "run of one axis missing",
    "wrong unit", "sign", "axes swapped", "constant", "copy", "scatter", "runs half named", "no runs", "samples",
)  # fmt: skip
RUNS, SIZES = 4, (5.0, 20.0, 60.0, 100.0)
PLAN = Plan(
    attitude=Attitude(tilt=-0.6, u=0.01, azimuth=0.2, u_azimuth=0.03),
    latitude=0.7,
    input_range=(-110.0 * DEG, 110.0 * DEG),
    scale_factor={"x": 0.5, "y": -0.4, "z": 0.3},
    standards={"rate_table.rate": Influence(3e-4, "1"), "rate_table.mounting": Influence(1e-3, "rad")},
)


def unit(seed: int, fault: str = "none") -> Readings:  # noqa: PLR0912 - a branch a fault
    """Return the dwells of one unit, simulated with numpy alone: three axes, both senses, with a fault."""
    rng = np.random.default_rng(seed)
    rows = [(run, axis, way * size) for run in range(RUNS) for axis in range(3) for size in SIZES for way in (-1, 1)]
    run, axis = (np.array([row[i] for row in rows]) for i in (0, 1))
    true = np.zeros((len(rows), 3))
    true[np.arange(len(rows)), axis] = applied = np.array([row[2] for row in rows]) * DEG
    curved = rng.choice([0.0, 0.02]) * true**2
    matrix, offsets = np.eye(3) + 0.003 * rng.standard_normal((3, 3)), 0.01 * DEG * rng.standard_normal((RUNS, 3))
    y = true @ matrix.T + curved + offsets[run] + 0.003 * DEG * rng.standard_normal(true.shape)
    scatter, keep = 0.05 * DEG * (1.0 + 0.1 * rng.standard_normal(true.shape)), np.ones(len(rows), dtype=bool)
    labels, samples = np.array([f"r{one}" for one in run]), np.full(len(rows), 100.0)
    match fault:
        case "outlier":
            y[rng.integers(len(y)), rng.integers(3)] += 3.0 * DEG
        case "empty cells":
            y[rng.random(y.shape) < 0.05] = np.nan
        case "empty column":
            y[:, rng.integers(3)] = np.nan
        case "dwells missing":
            keep = rng.random(len(y)) > 0.1
        case "one sense":
            keep = (axis > 0) | (applied > 0.0)
        case "run of one axis missing":
            keep = (axis > 0) | (run > 0)
        case "wrong unit":
            y[run == 0] /= DEG
        case "sign":
            y[:, 0] *= -1.0
        case "axes swapped":
            y[run == 1] = y[run == 1][:, [1, 0, 2]]
        case "constant":
            y[:, 0] = 0.1
        case "copy":
            y = true.copy()
        case "scatter":
            scatter[rng.integers(len(y)), rng.integers(3)] *= 9.0
        case "runs half named":
            labels[0] = ""
        case "no runs":
            labels[:] = ""
        case "samples":
            samples = rng.integers(50, 400, len(y)).astype(float)
    return Readings(
        applied=applied,
        axis=np.array(list("xyz"))[axis],
        outputs={name: y[:, i].copy() for i, name in enumerate("xyz")},
        scatters={name: scatter[:, i].copy() for i, name in enumerate("xyz")},
        samples=samples,
        run=labels,
        recording=np.full(len(y), "rates"),
        where=tuple(f"rates.csv:{i + 2}" for i in range(len(y))),
        sensors=("x", "y", "z"),
    ).take(keep)


def alone(plan: Plan, readings: Readings) -> Result | InertialcalError:
    """Return the result of one unit, or its refusal."""
    try:
        return reduce(plan, readings)
    except InertialcalError as error:
        return error


def told(found: Result | InertialcalError) -> Any:
    """Return all that a result says, to the bit."""
    if isinstance(found, InertialcalError):
        return [str(problem) for problem in found.problems]
    return [repr(row.to_dict()) for row in found.rows()], found.remarks, [str(one) for one in found.curves()]


def test_many_units_are_the_same_as_each_alone_whatever_their_faults() -> None:
    tests = [(PLAN, unit(seed, fault)) for seed in (1, 2) for fault in FAULTS]
    tests += [(replace(PLAN, nonlinearity="always"), unit(3)), (replace(PLAN, asymmetry=False), unit(4))]
    found = procedure_of("rate_table").reduce_many(tests)
    assert [told(one) for one in found] == [told(alone(*test)) for test in tests]
    assert sum(isinstance(one, InertialcalError) for one in found) == 2  # runs half named


def test_what_disagrees_in_many_units_is_what_disagrees_in_each_alone() -> None:
    tests = [(PLAN, unit(seed, fault)) for seed in (1, 2, 3) for fault in FAULTS]
    tests += [(PLAN, unit(seed)) for seed in range(10, 30)]
    found = agreement_many(tests)
    assert found == [list(procedure_of("rate_table").agreement(*test)) for test in tests]
    assert {remark.code for one in found for remark in one} >= {
        "copy_of_applied", "sign_disagrees", "axes_disagree", "reading_disagrees",
    }  # fmt: skip
    assert not any(found[-20:])


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(1, 11))
def test_the_order_and_the_number_of_units_change_nothing(seed: int) -> None:
    rng = np.random.default_rng(seed)
    tests = [(PLAN, unit(100 * seed + i, str(rng.choice(FAULTS)))) for i in range(30)]
    expected = {i: told(one) for i, one in enumerate(reduce_many(tests))}
    for i in (order := rng.permutation(len(tests)))[:10]:
        assert told(alone(*tests[i])) == expected[int(i)]
    again = reduce_many([tests[i] for i in order[:17]])
    assert [told(one) for one in again] == [expected[int(i)] for i in order[:17]]


def test_a_sensor_without_any_reading_is_named_and_the_others_have_their_figures() -> None:
    result = reduce(PLAN, unit(5, "empty column"))
    assert next(one.what for one in result.remarks if one.code == "no_line").endswith("sensor: no readings")
    assert len(result.lines) == 2


def test_a_negative_ideal_scale_factor_has_a_positive_uncertainty() -> None:
    row = next(one for one in reduce(PLAN, unit(6)).rows() if (one.quantity, one.axis) == ("scale_factor", "y"))
    assert row.value == pytest.approx(-0.4, rel=0.02)
    assert row.u is not None
    assert row.u > 0.0

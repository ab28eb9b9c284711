"""Triads of many units at once: the same figures and remarks, to the bit, as those of each unit alone."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from independent.positions import FACES, G
from inertialcal.core.errors import InertialcalError
from inertialcal.core.influence import Influence
from inertialcal.procedures import procedure_of
from inertialcal.procedures.positions.plan import Plan
from inertialcal.procedures.positions.readings import Readings, Triad
from inertialcal.procedures.positions.reduction import Result, reduce, reduce_many

PLAN = Plan(gravity=G, standards={
    "gravity.value": Influence(1e-4, "m/s^2"), "fixture.orientation": Influence(1e-3, "rad"),
    "fixture.mounting": Influence(1e-3, "rad"),
})  # fmt: skip
COUNTS = 1000.0
FAULTS = (
    "none", "outlier", "two outliers", "swapped positions", "dead axis", "in g", "3 positions", "6 positions",
    "9 positions", "10 positions", "13 positions", "one plane", "no scatter", "exact", "much scatter", "left-handed",
    "known", "half known", "misnamed", "counts", "counts with an outlier",
)  # fmt: skip


def unit(seed: int, fault: str = "none") -> Readings:
    """Return the positions of one unit, simulated with numpy alone, with a fault."""
    rng = np.random.default_rng(seed)
    up = np.vstack([np.array(list(FACES.values()), float), rng.standard_normal((14, 3))])
    if fault == "one plane":
        up[:, 2] = 0.0
        up = up[np.linalg.norm(up, axis=1) > 0.0]
    up /= np.linalg.norm(up, axis=1)[:, None]
    read = G * up @ (np.eye(3) + 0.01 * rng.standard_normal((3, 3))).T + 0.05 * rng.standard_normal(3)
    read += (0.0 if fault == "exact" else 0.05 if fault == "much scatter" else 2e-3) * rng.standard_normal(up.shape)
    scatter = 0.01 * np.sqrt(rng.chisquare(99, up.shape) / 99)
    direction = up.copy() if fault in {"known", "half known", "misnamed"} else None
    if "outlier" in fault:
        read[rng.permutation(len(read))[: 2 if "two" in fault else 1], rng.integers(3)] += 0.1
    if fault == "swapped positions":
        read[[0, 3]] = read[[3, 0]]
    if fault == "dead axis":
        read[:, 1] = 0.02
    if fault == "in g":
        read /= G
    if fault in {"no scatter", "exact"}:
        scatter[:] = 0.0
    if fault == "left-handed":
        read[:, 0] *= -1.0
    if fault == "half known" and direction is not None:
        direction[8:] = np.nan
    if fault == "misnamed" and direction is not None:
        direction[0] *= -1.0
    if "counts" in fault:
        read, scatter = COUNTS * (read + 1.0), COUNTS * scatter
    count = int(fault.split(maxsplit=1)[0]) if fault[0].isdigit() else len(read)
    samples = np.full((count, 3), 100.0)
    acc = Triad(read[:count], scatter[:count], samples, "count" if "counts" in fault else "m/s^2", samples[:, 0])
    return Readings(acc, direction=direction, where=tuple(f"rests.csv:{k + 2}" for k in range(count)))


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
    rows = [repr(row.to_dict()) for row in found.rows()]
    models = [repr((one.estimate and one.estimate.covariance, one.terms)) for one in found.models.values()]
    return rows, models, found.remarks, [str(one) for one in found.curves()]


def test_many_units_are_the_same_as_each_alone_whatever_their_faults() -> None:
    tests = [(PLAN, unit(seed, fault)) for seed in (1, 2) for fault in FAULTS]
    tests += [(replace(PLAN, prior_bias=0.1), unit(3)), (replace(PLAN, outlier_risk=1e-3), unit(4, "outlier"))]
    found = procedure_of("positions").reduce_many(tests)
    assert [told(one) for one in found] == [told(alone(*test)) for test in tests]
    refused = {one.problems[0].code for one in found if isinstance(one, InertialcalError)}
    assert refused >= {"too_few_positions", "unit_slip", "one_plane", "position_misnamed"}
    codes = {remark.code for one in found if isinstance(one, Result) for remark in one.remarks}
    assert codes >= {"outlier_position", "not_observable", "no_dof"}


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_the_order_and_the_number_of_units_change_nothing(seed: int) -> None:
    rng = np.random.default_rng(seed)
    tests = [(PLAN, unit(100 * seed + i, str(rng.choice(FAULTS)))) for i in range(30)]
    expected = {i: told(one) for i, one in enumerate(reduce_many(tests))}
    order = rng.permutation(len(tests))[:17]
    again = reduce_many([tests[i] for i in order])
    assert [told(one) for one in again] == [expected[int(i)] for i in order]

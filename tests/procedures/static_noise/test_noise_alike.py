"""Records that are alike, worked on side by side: what each gives by itself, remark by remark."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from inertialcal.core.errors import InertialcalError
from inertialcal.core.estimate import Array
from inertialcal.procedures.static_noise import axis_noise
from inertialcal.procedures.static_noise.plan import Plan
from inertialcal.procedures.static_noise.readings import Readings, Run
from inertialcal.procedures.static_noise.record import recorded_alike
from inertialcal.procedures.static_noise.reduction import Result, reduce, reduce_many

PLAN = Plan(kind="gyro")
N, INTERVAL = 6_000, 0.01


def units() -> list[tuple[Plan, Readings]]:
    """Return sound units, faulty ones, and ones that are like no other."""
    rng = np.random.default_rng(5)
    t = np.arange(N)

    def unit(**changed: object) -> Readings:
        x = {axis: rng.normal(size=N) + 1e-3 * np.cumsum(rng.normal(size=N)) for axis in "xyz"}
        for axis, change in changed.items():
            x[axis] = change(x[axis]) if callable(change) else x[axis]
        return Readings((Run(x, {}, INTERVAL, name="still"),))

    def gap(x: Array) -> Array:
        return np.where(t // 30 == 20, np.nan, x)

    found = [
        (PLAN, unit()),
        (PLAN, unit(x=lambda x: x + np.sin(0.7 * t), y=lambda x: np.round(x / 3.0) * 3.0)),
        (PLAN, unit(x=gap, y=lambda x: 0.0 * x + 2.0, z=lambda x: x + 40.0 * (t // 50 == 70))),
        (PLAN, unit(x=lambda x: x + 3.0 * np.exp(-t / 700.0), y=lambda x: x.astype(np.float32))),
        (PLAN, unit(x=lambda x: np.rint(1e3 * x).astype(np.int64), z=lambda x: x + 5.0 * (t > N // 2))),
        (PLAN, unit(x=lambda x: np.zeros(N), y=lambda x: np.full(N, np.nan), z=lambda x: np.zeros(N))),
        (replace(PLAN, deviation="hadamard", lines=False), unit()),
        (replace(PLAN, lines=False, segment=3.0), unit()),
        (replace(PLAN, terms=["rate_ramp"]), unit()),
        (PLAN, Readings((*unit().records, replace(unit().records[0], name="again")))),
        (PLAN, Readings(())),
        (replace(PLAN, kind=None, unit="mV"), unit()),
    ]
    for few in (300, 4_500):
        run = unit().records[0]
        found.append((PLAN, Readings((replace(run, values={axis: x[:few] for axis, x in run.values.items()}),))))
    return found


def said(found: Result | InertialcalError) -> object:
    if isinstance(found, InertialcalError):
        return type(found), found.problems
    intervals = [found.interval_at(row, 0.9) for row in found.rows()]
    return [row.to_dict() for row in found.rows()], found.remarks, [one.lines for one in found.axes], intervals


def test_units_are_reduced_side_by_side_as_each_by_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    together = [said(one) for one in reduce_many(units())]
    every = [(plan, run, axis) for plan, one in units() for run in one.records for axis in "xyz"]
    assert sum(one is not None for one in recorded_alike(every)) > 12
    monkeypatch.setattr(axis_noise, "recorded_alike", lambda asked: [None] * len(asked))
    apart = []
    for plan, readings in units():
        try:
            apart.append(said(reduce(plan, readings)))
        except InertialcalError as error:
            apart.append(said(error))
    for one, other in zip(together, apart, strict=True):
        assert one == other

"""Intervals of another probability, of rows of many results at once: those that each row has by itself."""

from __future__ import annotations

from functools import cache

import numpy as np

from inertialcal.core.key import Key
from inertialcal.core.recording import Channel, Recording
from inertialcal.core.results import Row
from inertialcal.procedures.static_noise.plan import Plan
from inertialcal.procedures.static_noise.readings import AtRest
from inertialcal.procedures.static_noise.recordings import readings_from
from inertialcal.procedures.static_noise.reduction import Result, reduce
from inertialcal.procedures.static_noise.rows import intervals_at

P = 0.90
SAME = 1e-9  # relative: the fits of series side by side


@cache
def noise(seed: int, walk: float) -> Result:
    """A unit of two axes, white noise and a random walk."""
    rng = np.random.default_rng(seed)
    values = rng.normal(size=(2, 8000)) + np.cumsum(rng.normal(scale=walk, size=(2, 8000)), axis=1)
    channels = tuple(Channel(axis, x, "deg/s", "header", axis) for axis, x in zip("xy", values, strict=True))
    plan = Plan(kind="gyro")
    return reduce(plan, readings_from(plan, [AtRest(Recording(channels, None, 0.01), {"x": "x", "y": "y"})]))


def close(one: float | None, other: float | None) -> bool:
    return one is other or bool(one is not None and other is not None and abs(one - other) <= SAME * abs(other))


def test_intervals_of_many_rows_are_those_of_each() -> None:
    results = [noise(1, 0.02), noise(2, 0.02), noise(3, 0.0)]
    given = [(result, row, p) for result in results for row in result.rows() if row.status == "estimated"
             for p in (P, 0.95)]  # fmt: skip
    nowhere: Row = given[0][1].changed(key=Key("angle_random_walk", "z"))  # an axis that was not read
    found = intervals_at([*given, (results[0], nowhere, P)])
    assert found[-1] is None
    assert len(given) > 2 * len(results)
    for (result, row, p), many in zip(given, found, strict=False):
        alone = result.interval_at(row, p)
        assert many is not None
        assert alone is not None
        assert many.p == alone.p == p
        assert close(many.lo, alone.lo)
        assert close(many.hi, alone.hi)


def test_the_interval_of_one_quantity_is_that_among_all() -> None:
    for one in noise(1, 0.02).axes:
        assert one.fit is not None
        every = one.fit.estimated_at(P, "")
        assert len(every) > 1
        for term in every:
            (own,) = one.fit.estimated_at(P, term.parameters[0].name)
            for mine, its in zip(own.parameters, term.parameters, strict=True):
                assert mine.name == its.name
                assert close(mine.interval.lo, its.interval.lo)
                assert close(mine.interval.hi, its.interval.hi)

"""Start-up transient: found again, its interval holds it, and nothing is found where there is none."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from inertialcal.core.errors import DataError
from inertialcal.core.estimate import Array
from inertialcal.sensors.warm_up import WarmUp, find_warm_up
from inertialcal.statistics.intervals import binomial_interval, contains, covers, t_interval

A, TAU, NOISE = 0.02, 150.0, 0.0008


def readings(rng: np.random.Generator, runs: int = 5, change: float = A) -> tuple[Array, Array, Array]:
    t = np.arange(5.0, 900.0, 10.0)
    y = [change * np.exp(-t / TAU) + rng.normal(0.0, 0.01) + rng.normal(0.0, NOISE, t.size) for _ in range(runs)]
    return np.tile(t, runs), np.concatenate(y), np.repeat(np.arange(runs), t.size)


def test_without_noise_the_transient_is_found() -> None:
    t = np.arange(5.0, 900.0, 10.0)
    y = np.concatenate([1.0 + A * np.exp(-t / TAU), -2.0 + A * np.exp(-t / TAU)])
    found = find_warm_up(np.tile(t, 2), y, np.repeat([0, 1], t.size))
    assert found.change == pytest.approx(A, rel=1e-4)
    assert found.time_constant == pytest.approx(TAU, rel=1e-4)
    assert found.settled_after(A / math.e) == pytest.approx(TAU, rel=1e-3)


def test_settled_is_where_less_than_the_tolerance_is_left() -> None:
    one = WarmUp(-0.03, 200.0, np.diag([1e-8, 4.0]), np.array([4.0, 4.0]), "run", 0.001, resolved=True)
    t = one.settled_after(1e-3)
    assert 0.03 * np.exp(-t / 200.0) == pytest.approx(1e-3)
    u, dof = one.u_settled_after(1e-3)
    step = 1e-6
    slopes = [
        (replace(one, change=-0.03 - step).settled_after(1e-3) - t) / -step,
        (replace(one, time_constant=200.0 + step).settled_after(1e-3) - t) / step,
    ]
    assert u == pytest.approx(np.sqrt(slopes[0] ** 2 * 1e-8 + slopes[1] ** 2 * 4.0), rel=1e-3)
    assert dof == 4.0
    assert one.settled_after(0.5) == 0.0


def test_intervals_hold_the_transient() -> None:
    hits = np.zeros(2, dtype=int)
    n = 300
    for seed in range(1, n + 1):
        found = find_warm_up(*readings(np.random.default_rng(seed)))
        u = np.sqrt(np.diag(found.covariance))
        pairs = zip((found.change, found.time_constant), u, found.dof, (A, TAU), strict=True)
        hits += [contains(t_interval(v, float(s), float(d)), true) for v, s, d, true in pairs]
    assert all(covers(int(one), n) for one in hits), hits / n


def test_one_power_up_has_the_scatter_of_its_stretches() -> None:
    found = find_warm_up(*readings(np.random.default_rng(2), runs=1))
    assert found.level == "stretch"
    assert found.identified
    assert found.change == pytest.approx(A, rel=0.2)


def test_no_transient_is_not_seen() -> None:
    seen = [find_warm_up(*readings(np.random.default_rng(seed), change=0.0)).identified for seed in range(60)]
    assert np.mean(seen) < 0.15
    none = find_warm_up(*readings(np.random.default_rng(3), change=0.0))
    assert none.identified or none.settled_after(1e-9) == 0.0


def test_too_few_readings_are_refused() -> None:
    with pytest.raises(DataError, match="5 readings after a power-up, need 12"):
        find_warm_up(np.arange(5.0), np.zeros(5), np.zeros(5))


@pytest.mark.parametrize("runs", [2, 5])
@pytest.mark.parametrize("walk", [0.0, 0.2])
def test_a_transient_is_found_where_there_is_none_in_five_percent(runs: int, walk: float) -> None:
    """Exact in slow noise too, which within a record looks like a transient: Student's t over the power-ups."""
    t = np.arange(5.0, 900.0, 30.0)
    alarms, n = 0, 300
    for seed in range(n):
        noise = np.random.default_rng(seed).standard_normal((2, runs, t.size))
        y = noise[0] + walk * np.cumsum(noise[1], axis=1)
        alarms += find_warm_up(np.tile(t, runs), y.ravel(), np.repeat(np.arange(runs), t.size)).identified
    low, high = binomial_interval(alarms, n)
    assert low <= 0.05 <= high


def test_a_transient_longer_than_the_record_is_found_without_figures() -> None:
    t = np.arange(5.0, 900.0, 10.0)
    rng = np.random.default_rng(3)
    y = np.concatenate([np.exp(-t / 3000.0) + 1e-3 * rng.standard_normal(t.size) for _ in range(5)])
    found = find_warm_up(np.tile(t, 5), y, np.repeat(np.arange(5), t.size))
    assert found.identified
    assert not found.resolved

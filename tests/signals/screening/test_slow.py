"""Slow channels that are stuck, and coarse ones that are right to stay where they are."""

import numpy as np
import pytest

from inertialcal.core.estimate import Array
from inertialcal.core.recording import SECOND
from inertialcal.signals.screening.slow import stuck_slow

N = 2_400
RAMPS = np.interp(np.arange(N), [0, 300, 900, 1500, 2100, N], [20.0, 20.0, -20.0, 60.0, 0.0, 20.0])
FINE, COARSE = 0.001, 0.5  # step of the thermometer [degC]


def thermometer(true: Array, step: float, seed: int, noise: float = 0.01) -> Array:
    rng = np.random.default_rng(seed)
    return np.asarray(np.round((true + noise * rng.normal(size=len(true))) / step) * step)


def gyro(true: Array, seed: int) -> Array:
    rng = np.random.default_rng([seed, 1])
    return np.asarray(0.02 + 2e-4 * true + 3e-6 * true**2 + 1e-3 * rng.normal(size=len(true)))


def held(values: Array, first: int, last: int) -> Array:
    out = values.copy()
    out[first : last + 1] = values[first]
    return out


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(("first", "last"), [(0, 1199), (1200, N - 1), (1000, 1400)])
def test_a_noisy_thermometer_that_is_stuck(seed: int, first: int, last: int) -> None:
    found = stuck_slow(held(thermometer(RAMPS, FINE, seed), first, last))
    assert found is not None
    assert (found.first, found.last) == (first, last)
    assert found.length == last - first + 1


@pytest.mark.parametrize(("first", "last"), [(0, 1000), (1200, N - 1)])
def test_a_coarse_one_by_its_jump_or_by_the_readings(first: int, last: int) -> None:
    x, readings = held(thermometer(RAMPS, COARSE, 1), first, last), gyro(RAMPS, 1)
    found = stuck_slow(x, [readings])
    assert found is not None
    assert abs(found.first - first) <= 3
    assert found.why.startswith("it jumps" if last == 1000 else "the readings go on")


DWELLS = np.repeat([20.0, -20.0, 0.0, 40.0], N // 4)
SETTLING = 25.0 - 5.0 * np.exp(-np.arange(N) / 400.0)
ONE_DWELL = np.concatenate((np.linspace(20.0, 60.0, N // 4), np.full(3 * N // 4, 60.0)))
RIGHT = {"ramps": RAMPS, "dwells": DWELLS, "settling": SETTLING, "one dwell": ONE_DWELL, "constant": np.full(N, 21.0)}


@pytest.mark.parametrize("step", [FINE, 0.0625, 0.1, COARSE])
@pytest.mark.parametrize("noise", [0.0, 0.003, 0.03, 0.3])
@pytest.mark.parametrize("name", RIGHT)
def test_a_thermometer_that_is_right_to_stay(name: str, step: float, noise: float) -> None:
    for seed in range(5):
        x = thermometer(RIGHT[name], step, seed, noise)
        assert stuck_slow(x, [gyro(RIGHT[name], seed)]) is None


def test_a_step_across_a_gap_is_no_jump() -> None:
    x = np.concatenate((np.full(300, 20.0), thermometer(np.linspace(30.0, 40.0, 900), COARSE, 1)))
    time_ns = np.arange(1200, dtype=np.int64) * SECOND
    assert stuck_slow(x, (), time_ns) is not None
    time_ns[300:] += 3600 * SECOND
    assert stuck_slow(x, (), time_ns) is None


def test_missing_and_short() -> None:
    assert stuck_slow(np.full(100, np.nan)) is None
    assert stuck_slow(np.arange(10.0)) is None
    x = held(thermometer(RAMPS, FINE, 1), 1200, N - 1)
    x[100:140] = np.nan
    assert stuck_slow(x) is not None


@pytest.mark.parametrize("value", [np.inf, -np.inf, 1e308, np.nan, 5e-324])
def test_values_that_nothing_has_end_in_no_warning(value: float) -> None:
    x, readings = held(thermometer(RAMPS, COARSE, 1), 1200, N - 1), gyro(RAMPS, 1)
    x[100:160], readings[300:400] = value, value
    with np.errstate(all="raise"):
        stuck_slow(x, [readings, x])

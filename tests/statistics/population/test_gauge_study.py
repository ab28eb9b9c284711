"""Gauge R&R: the example of the manual of the AIAG, truth of simulated studies, honesty of what tests state."""

from __future__ import annotations

import math

import numpy as np
import pytest

from inertialcal.core.errors import DataError
from inertialcal.statistics.intervals import covers
from inertialcal.statistics.population.gauge import Gauge, gauge

# AIAG, Measurement Systems Analysis, 4th edition, table III-B 6a: three appraisers, three trials of ten parts
AIAG = """
0.29 -0.56 1.34 0.47 -0.80 0.02 0.59 -0.31 2.26 -1.36
0.41 -0.68 1.17 0.50 -0.92 -0.11 0.75 -0.20 1.99 -1.25
0.64 -0.58 1.27 0.64 -0.84 -0.21 0.66 -0.17 2.01 -1.31
0.08 -0.47 1.19 0.01 -0.56 -0.20 0.47 -0.63 1.80 -1.68
0.25 -1.22 0.94 1.03 -1.20 0.22 0.55 0.08 2.12 -1.62
0.07 -0.68 1.34 0.20 -1.28 0.06 0.83 -0.34 2.19 -1.50
0.04 -1.38 0.88 0.14 -1.46 -0.29 0.02 -0.46 1.77 -1.49
-0.11 -1.13 1.09 0.20 -1.07 -0.67 0.01 -0.56 1.45 -1.77
-0.15 -0.96 0.67 0.11 -1.45 -0.49 0.21 -0.49 1.87 -2.16
"""
MS_STATION, MS_PART, MS_BOTH, MS_REPEAT = 1.58363, 9.81799, 0.01994, 0.04598  # its analysis of variance


def study(values: np.ndarray, part: np.ndarray, station: np.ndarray, stated: float = 1.0) -> Gauge:
    return gauge(values, np.full(values.size, stated), np.full(values.size, np.inf), part, station)


def test_the_example_of_the_aiag() -> None:
    y = np.array([[float(x) for x in line.split()] for line in AIAG.split("\n") if line])
    station, _, part = np.meshgrid(np.arange(3), np.arange(3), np.arange(10), indexing="ij")
    found = study(y.ravel(), part.ravel(), station.ravel())
    assert found.repeatability.value == pytest.approx(math.sqrt(MS_REPEAT), rel=2e-4)
    between = (MS_STATION - MS_BOTH) / 30.0 + (MS_BOTH - MS_REPEAT) / 3.0
    assert found.reproducibility is not None
    assert found.reproducibility.value == pytest.approx(math.sqrt(between), rel=2e-3)
    assert found.part == pytest.approx(math.sqrt((MS_PART - MS_BOTH) / 9.0), rel=2e-4)
    assert (found.units, found.tests, found.stations, found.crossed, found.dof) == (10, 90, 3, 10, 60)
    assert found.distinct == int(math.sqrt(2.0) * found.part / found.gauge.value)


def simulated(parts: int, stations: int, times: int, sizes: tuple[float, float, float], seed: int) -> Gauge:
    rng = np.random.default_rng(seed)
    p, s, _ = (one.ravel() for one in np.meshgrid(*(np.arange(k) for k in (parts, stations, times)), indexing="ij"))
    between, both, repeat = sizes
    y = 2.0 * rng.standard_normal(parts)[p] + between * rng.standard_normal(stations)[s]
    y += both * rng.standard_normal((parts, stations))[p, s] + repeat * rng.standard_normal(p.size)
    return study(y, p, s)


@pytest.mark.parametrize("n", [20, pytest.param(300, marks=pytest.mark.slow)])
@pytest.mark.parametrize(("layout", "sizes"), [
    ((10, 3, 3), (0.7, 0.3, 1.0)), ((30, 2, 2), (0.7, 0.0, 1.0)), ((10, 4, 2), (0.0, 0.0, 1.0)),
    ((15, 3, 1), (0.5, 0.0, 1.0)),
])  # fmt: skip
def test_coverage(layout: tuple[int, int, int], sizes: tuple[float, float, float], n: int) -> None:
    hits = [0, 0, 0]
    between = math.hypot(*sizes[:2])
    for seed in range(1, n + 1):
        found = simulated(*layout, sizes, seed)
        assert found.reproducibility is not None
        truths = (sizes[2], between, math.hypot(between, sizes[2]))
        for i, (one, truth) in enumerate(zip((found.repeatability, found.reproducibility, found.gauge), truths,
                                             strict=True)):  # fmt: skip
            hits[i] += (one.interval.lo or 0.0) <= truth <= (one.interval.hi or math.inf)
    assert all(covers(count, n) for count in hits), hits


def test_one_station_knows_repeats_alone() -> None:
    found = simulated(20, 1, 3, (0.0, 0.0, 1.0), 1)
    assert found.reproducibility is None
    assert found.repeatability.value == pytest.approx(1.0, rel=0.25)
    parts = [simulated(20, 1, 3, (0.0, 0.0, 1.0), seed).part for seed in range(1, 31)]
    assert np.mean(parts) == pytest.approx(2.0, rel=0.1)


def test_honesty_of_what_is_stated() -> None:
    rng = np.random.default_rng(2)
    part = np.repeat(np.arange(20), 4)
    y = rng.standard_normal(20)[part] + 0.5 * rng.standard_normal(80)
    at = np.zeros(80, dtype=int)
    assert study(y, part, at, 0.5).excess > 0.01
    assert study(y, part, at, 0.5).lack > 0.01
    assert study(y, part, at, 0.2).excess < 1e-9
    assert study(y, part, at, 2.0).lack < 1e-9
    ratio = study(y, part, at, 0.2).ratio
    assert ratio.lo is not None
    assert ratio.hi is not None
    assert ratio.lo < 2.5 < ratio.hi


def test_units_tested_once_do_not_count() -> None:
    rng = np.random.default_rng(3)
    part = np.concatenate([np.repeat(np.arange(5), 3), np.arange(5, 100)])
    y = rng.standard_normal(100)[part] + 0.1 * rng.standard_normal(part.size)
    found = study(y, part, np.zeros(part.size, dtype=int))
    assert (found.units, found.tests) == (5, 15)


def test_refusals() -> None:
    with pytest.raises(DataError, match="tested more than once"):
        study(np.arange(5.0), np.arange(5), np.zeros(5, dtype=int))
    part = np.repeat(np.arange(4), 2)
    with pytest.raises(DataError, match="equal"):
        study(np.repeat(np.arange(4.0), 2), part, np.zeros(8, dtype=int))

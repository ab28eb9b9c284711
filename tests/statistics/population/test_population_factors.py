"""Stations, levels and drift of a lot: those that are off are found, sound lots have few findings."""

from __future__ import annotations

import numpy as np
import pytest

from inertialcal.statistics.intervals import binomial_interval
from inertialcal.statistics.population.factors import along, levels

FIGURES = 10


def named(y: np.ndarray, at: np.ndarray, common: float, figures: int = FIGURES) -> list[int]:
    return [one.number for one in levels(y, at, common, figures) if one.off]


@pytest.mark.parametrize("n", [40, pytest.param(400, marks=pytest.mark.slow)])
@pytest.mark.parametrize(("units", "stations", "common"), [(300, 4, 0.1), (60, 3, 0.0), (1000, 8, 0.3)])
def test_sound_lots_have_few_findings(units: int, stations: int, common: float, n: int) -> None:
    off = drifts = wanders = 0
    for seed in range(1, n + 1):
        rng = np.random.default_rng(seed)
        found = [False, False, False]
        at = rng.integers(0, stations, units)
        for _ in range(FIGURES):
            y = common * rng.standard_normal(stations)[at] + rng.standard_normal(units)
            found[0] |= bool(named(y, at, common))
            course = along(y, np.arange(units, dtype=float), at, FIGURES)
            assert course is not None
            found[1] |= course.drifts
            found[2] |= course.wanders
        off, drifts, wanders = off + found[0], drifts + found[1], wanders + found[2]
    assert all(binomial_interval(count, n)[0] <= 0.05 for count in (off, drifts, wanders)), (off, drifts, wanders)


@pytest.mark.parametrize("n", [40, pytest.param(400, marks=pytest.mark.slow)])
@pytest.mark.parametrize(("units", "common"), [(5, 0.15), (6, 0.15), (12, 0.15), (8, 1.0), (20, 0.15)])
def test_sound_lots_of_few_units_have_few_findings(units: int, common: float, n: int) -> None:
    """Of one or two units a station the scatter is hardly known: by a normal deviate nearly all had a finding."""
    off = 0
    for seed in range(1, n + 1):
        rng = np.random.default_rng(seed)
        at = np.arange(units) % 4
        y = common * rng.standard_normal(4)[at] + rng.standard_normal((3 * FIGURES, units))
        off += any(named(one, at, common, 3 * FIGURES) for one in y)
    assert binomial_interval(off, n)[0] <= 0.06, off


@pytest.mark.parametrize("n", [40, pytest.param(400, marks=pytest.mark.slow)])
@pytest.mark.parametrize(("units", "stations", "levels_of"), [(24, 4, 3), (60, 30, 2)])
def test_levels_after_the_stations(units: int, stations: int, levels_of: int, n: int) -> None:
    """Means of stations that were taken off left less scatter: of 60 units at 30 stations every second lot had one."""
    at, station = (np.arange(units) // stations) % levels_of, np.arange(units) % stations
    off = 0
    for seed in range(1, n + 1):
        y = np.random.default_rng(seed).standard_normal((3 * FIGURES, units))
        rest = [one - (np.bincount(station, one) / np.bincount(station))[station] for one in y]
        off += any(one.off for each in rest for one in levels(each, at, 0.0, 3 * FIGURES, stations - 1))
    assert binomial_interval(off, n)[0] <= 0.05, off


def test_heavy_tails_make_no_finding() -> None:
    rng = np.random.default_rng(1)
    at = np.arange(200) % 8
    assert sum(bool(named(rng.standard_t(1.5, 200), at, 0.0)) for _ in range(40)) <= 3


def test_a_station_that_is_off() -> None:
    rng = np.random.default_rng(2)
    at = np.arange(300) % 4
    y = rng.standard_normal(300) + 0.1 * rng.standard_normal(4)[at] + np.array([0.0, 0.0, 1.5, 0.0])[at]
    found = {one.number: one for one in levels(y, at, 0.1, FIGURES)}
    assert [number for number, one in found.items() if one.off] == [2]
    assert found[2].offset == pytest.approx(1.5, abs=0.5)
    assert found[2].u == pytest.approx(np.sqrt(1.0 / 75.0 + 1.0 / 225.0), rel=0.1)


def test_two_stations_of_five_that_are_off() -> None:
    rng = np.random.default_rng(3)
    at = np.arange(500) % 5
    y = rng.standard_normal(500) + np.array([0.0, 3.0, 0.0, -3.0, 0.0])[at]
    assert named(y, at, 0.05) == [1, 3]


def test_of_two_none_is_the_wrong_one() -> None:
    rng = np.random.default_rng(4)
    at = np.arange(200) % 2
    assert named(rng.standard_normal(200) + 3.0 * at, at, 0.1) == [0, 1]


def test_what_standards_allow_is_no_finding() -> None:
    rng = np.random.default_rng(5)
    at = np.arange(4000) % 4
    y = rng.standard_normal(4000) + np.array([0.0, 0.5, -0.5, 0.2])[at]
    assert not named(y, at, 0.5)
    assert named(y, at, 0.01)


def test_a_drift() -> None:
    rng = np.random.default_rng(6)
    place = np.sort(rng.uniform(0.0, 20.0, 400))
    found = along(rng.standard_normal(400) + 0.1 * place, place)
    assert found is not None
    assert found.drifts
    assert abs(found.slope - 0.1) < 3 * found.u
    assert found.change == pytest.approx(found.slope * (place[-1] - place[0]))


def test_a_station_that_began_late_is_no_drift() -> None:
    rng = np.random.default_rng(7)
    at = (np.arange(400) > 250).astype(int)
    found = along(rng.standard_normal(400) + 3.0 * at, np.arange(400, dtype=float), at)
    assert found is not None
    assert not found.drifts


@pytest.mark.parametrize("n", [60, pytest.param(600, marks=pytest.mark.slow)])
def test_batches_are_no_drift_but_a_mean_that_wanders(n: int) -> None:
    drifts = wanders = 0
    for seed in range(1, n + 1):
        rng = np.random.default_rng(seed)
        found = along(rng.standard_normal(1000) + np.repeat(0.5 * rng.standard_normal(20), 50), np.arange(1000.0))
        assert found is not None
        drifts += found.drifts
        wanders += found.wanders
    assert wanders > 0.9 * n
    assert binomial_interval(drifts, n)[0] <= 0.05


def test_figures_that_do_not_vary_are_left_alone() -> None:
    at = np.arange(40) % 4
    assert not named(np.full(40, 2.5), at, 0.0)
    assert along(np.full(40, 2.5), np.arange(40.0)) is None
    assert along(np.arange(40.0), np.zeros(40)) is None

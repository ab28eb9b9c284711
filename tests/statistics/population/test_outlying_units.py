"""Units of another kind: found where they are put in, none named in sound lots."""

from __future__ import annotations

import numpy as np
import pytest

from inertialcal.statistics.intervals import binomial_interval
from inertialcal.statistics.population.outliers import outliers


def lot(n: int, p: int, rng: np.random.Generator) -> np.ndarray:
    return rng.standard_normal((n, p)) @ (rng.standard_normal((p, p)) + 0.5)


@pytest.mark.parametrize("n", [40, pytest.param(400, marks=pytest.mark.slow)])
@pytest.mark.parametrize(("units", "parameters"), [(50, 1), (200, 6), (600, 20)])
def test_sound_lots_have_none(units: int, parameters: int, n: int) -> None:
    named = sum(bool(outliers(lot(units, parameters, np.random.default_rng(seed))).outlier.any()) for seed in range(n))
    assert binomial_interval(named, n)[0] <= 0.06, named


@pytest.mark.parametrize("n", [20, pytest.param(300, marks=pytest.mark.slow)])
@pytest.mark.parametrize("parameters", [10, 33])
def test_sound_lots_with_repeated_units_have_none(parameters: int, n: int) -> None:
    """Seven more tests of one unit in twenty: taken for units, they made 19 to 49 of 100 sound lots have one."""
    any_odd = 0
    rows = np.concatenate([np.arange(120), np.repeat(np.linspace(0, 119, 6).astype(int), 7)])
    first = np.arange(rows.size) < 120
    for seed in range(1, n + 1):
        rng = np.random.default_rng(seed)
        units = rng.standard_normal((120, parameters))
        found = outliers(units[rows] + 0.1 * rng.standard_normal((rows.size, parameters)), first)
        any_odd += bool(found.outlier.any())
    assert binomial_interval(any_odd, n)[0] <= 0.06, any_odd


@pytest.mark.parametrize("share", [0.01, 0.1])
def test_odd_units_are_found(share: float) -> None:
    rng = np.random.default_rng(1)
    x = lot(1000, 8, rng)
    odd = rng.permutation(1000)[: int(1000 * share)]
    x[odd] += 8.0 * rng.standard_normal(8) * x.std(axis=0)
    found = outliers(x)
    assert set(odd) <= set(np.flatnonzero(found.outlier))
    assert found.outlier.sum() <= odd.size + 2


def test_a_unit_that_is_odd_only_together() -> None:
    rng = np.random.default_rng(2)
    x = rng.standard_normal((500, 1)) + 0.05 * rng.standard_normal((500, 2))
    x[17] = [1.5, -1.5]  # each of them is usual
    found = outliers(x)
    assert np.flatnonzero(found.outlier).tolist() == [17]
    assert np.abs(found.deviation[17]).max() < 3.0


def test_distance_of_one_parameter_is_its_deviate() -> None:
    rng = np.random.default_rng(3)
    x = rng.standard_normal((5000, 1))
    x[0] = 6.0
    assert outliers(x).distance[0] == pytest.approx(6.0, rel=0.05)


def test_units_that_lack_parameters_are_judged_on_the_others() -> None:
    rng = np.random.default_rng(4)
    x = lot(400, 5, rng)
    x[rng.permutation(400)[:60], 2] = np.nan
    x[7, :2] += 20.0 * x[:, :2].std(axis=0) * [1.0, -1.0]
    x[7, 2:] = np.nan
    found = outliers(x)
    assert found.outlier[7]
    assert np.isfinite(found.distance).all()
    x[8] = np.nan
    assert np.isnan(outliers(x).distance[8])


def test_skewed_parameters_are_taken_as_logarithms() -> None:
    rng = np.random.default_rng(5)
    x = np.exp(0.6 * rng.standard_normal((800, 2)))
    found = outliers(x)
    assert found.logarithm.all()
    assert not found.outlier.any()


def test_a_parameter_of_heavy_tails_is_left_out() -> None:
    rng = np.random.default_rng(6)
    x = np.column_stack([rng.standard_normal(600), rng.standard_t(1.2, 600)])
    assert outliers(x).used.tolist() == [0]


def test_heavy_tails_together_are_told() -> None:
    rng = np.random.default_rng(7)
    scale = np.sqrt(4.0 / rng.chisquare(4.0, 2000))[:, np.newaxis]
    assert outliers(rng.standard_normal((2000, 10)) * scale).heavy
    assert not outliers(rng.standard_normal((2000, 10))).heavy


def test_equal_and_copied_parameters() -> None:
    rng = np.random.default_rng(8)
    x = rng.standard_normal((200, 3))
    found = outliers(np.column_stack([x, x[:, 0], np.full(200, 3.0)]))
    assert 4 not in found.used
    assert np.isfinite(found.distance).all()

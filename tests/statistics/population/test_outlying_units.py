"""Units of another kind: found where they are put in, none named in sound lots."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from inertialcal.core.estimate import Array
from inertialcal.statistics.intervals import binomial_interval
from inertialcal.statistics.population import outliers as outlying
from inertialcal.statistics.population.outliers import Uncertain, outliers
from sized import sized


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


SOUND: dict[str, dict[str, float]] = {
    "curvature by chance": {"chosen": True},
    "the same, units all alike": {"chosen": True, "scatter": 0.0},
    "known as such": {"chosen": True, "usual": False},
    "known as such, units all alike": {"chosen": True, "usual": False, "scatter": 0.0},
    "tests of other lengths": {"spread": 0.5},
    "far other lengths": {"spread": 1.0, "repeats": np.inf},
    "far other lengths, units all alike": {"spread": 1.0, "repeats": np.inf, "scatter": 0.0},
    "two units a station, all alike": {"stations": 30, "scatter": 0.0},
    "one station": {"stations": 1, "scatter": 0.0},
    "u twice too small": {"times": 0.5},
    "u four times too large, units all alike": {"times": 4.0, "scatter": 0.0},
}


def line(
    n: int, seed: int, scatter: float = 1.0, spread: float = 0.0, repeats: float = 4.0, stations: int = 4,
    chosen: bool = False, usual: bool = True, times: float = 1.0,
) -> tuple[Array, Uncertain]:  # fmt: skip
    """Return nine figures of units and what their tests state: threes that scatter far more, as much, far less.

    Where terms are chosen by what is seen, a tenth of the units have ten times the uncertainty in the second and third
    of a three, whose errors are nearly opposite.
    """
    rng = np.random.default_rng(seed)
    p = 9
    units = scatter * rng.standard_normal((n, p)) @ (0.4 * rng.standard_normal((p, p)) + np.eye(p)).T
    units *= np.tile([10.0, 1.0, 0.05], p // 3)
    mixed = 0.4 * rng.standard_normal((p, p)) + np.eye(p)
    errors = rng.standard_normal((n, p)) @ (mixed / np.linalg.norm(mixed, axis=1)[:, np.newaxis]).T
    jumps = np.zeros((n, p), dtype=bool)
    for first in range(0, p if chosen else 0, 3):
        jump, shared = rng.random(n) < 0.1, rng.standard_normal(n)
        for column, sign in ((first + 1, 1.0), (first + 2, -1.0)):
            own = 0.97 * sign * shared + np.sqrt(1.0 - 0.97**2) * rng.standard_normal(n)
            jumps[:, column], errors[:, column] = jump, np.where(jump, 10.0 * own, errors[:, column])
    true = np.exp(spread * rng.standard_normal((n, p)))
    dof = np.where(jumps, 3e4, repeats)
    stated = np.where(np.isfinite(dof), np.sqrt(rng.chisquare(np.minimum(dof, 1e9)) / np.minimum(dof, 1e9)), 1.0)
    station = rng.integers(0, stations, n)
    common = np.tile([3.0, 0.0, 0.0], p // 3)
    shift = common * rng.standard_normal((stations, p))
    u = times * true * stated * np.where(jumps, 10.0, 1.0)
    every = np.broadcast_to(common, (n, p)).copy()
    return units + true * errors + shift[station], Uncertain(u, dof, every, station, ~jumps | usual)


@pytest.mark.parametrize(
    ("n", "seeds"),
    [(24, 12), *(pytest.param(n, 0, marks=pytest.mark.slow) for n in (24, 60, 200))],
)
@pytest.mark.parametrize("case", SOUND)
def test_units_are_judged_by_what_their_own_test_allows(case: str, n: int, seeds: int) -> None:
    """Judged by the scatter of the lot alone, 56 to 100 of 100 lots with curvature by chance named a sound unit."""
    count = seeds or sized(200, 60)
    named = 0
    for seed in range(1, count + 1):
        values, uncertain = line(n, seed, **SOUND[case])  # type: ignore[arg-type]
        named += bool(outliers(values, None, uncertain).outlier.any())
    assert binomial_interval(named, count)[0] <= 0.06, named


@pytest.mark.parametrize("case", [one for one in SOUND if "large" not in one])
def test_odd_units_are_found_among_them(case: str) -> None:
    """Ten standard deviations of test, station and population, in a parameter that scatters more, or as its test."""
    for column in (0, 1):
        found = 0
        for seed in range(1, 11):
            values, uncertain = line(60, seed, **SOUND[case])  # type: ignore[arg-type]
            scatter = 1.0 if "scatter" not in SOUND[case] else 0.0
            test = max(float(uncertain.u[7, column]), float(np.median(uncertain.u[:, column])))
            alike = np.hypot(uncertain.common[7, column], scatter * values[:, column].std())
            values[7, column] += 10.0 * np.hypot(test, alike)
            found += bool(outliers(values, None, uncertain).outlier[7])
        assert found >= 9, (column, found)


def test_a_wide_uncertainty_of_its_own_has_to_be_exceeded() -> None:
    rng = np.random.default_rng(9)
    values = rng.standard_normal((100, 3))
    u = np.full(values.shape, 0.1)
    values[7, 1], u[7, 1] = 12.0, 5.0
    uncertain = Uncertain(u, np.full(values.shape, np.inf), np.zeros(values.shape), np.zeros(100, np.intp),
                          np.ones(values.shape, dtype=bool))  # fmt: skip
    assert outliers(values).outlier[7]
    assert not outliers(values, None, uncertain).outlier.any()
    values[7, 1] = 40.0
    assert np.flatnonzero(outliers(values, None, uncertain).outlier).tolist() == [7]
    uncertain.dof[7, 1] = 2.0  # from three repeats
    assert not outliers(values, None, uncertain).outlier.any()


def test_many_units_are_judged_as_few_are(monkeypatch: pytest.MonkeyPatch) -> None:
    """Medians of F of many come of a spline: with degrees of freedom from 1 to a million, no two alike."""
    values, uncertain = line(1500, 1)
    rng = np.random.default_rng(2)
    uncertain = replace(uncertain, dof=np.exp(rng.uniform(0.0, np.log(1e6), values.shape)))
    found = outliers(values, None, uncertain)
    monkeypatch.setattr(outlying, "NODES", values.size)
    exact = outliers(values, None, uncertain)
    assert not np.array_equal(found.deviation, exact.deviation, equal_nan=True)
    np.testing.assert_allclose(found.deviation, exact.deviation, rtol=1e-8, atol=1e-8)
    assert np.array_equal(found.outlier, exact.outlier)

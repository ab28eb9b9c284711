"""Two levels of variance: closed forms, truth recovered, deletion residuals, refusals."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from inertialcal.core.errors import DataError
from inertialcal.core.estimate import Array
from inertialcal.statistics._kernels_levels import fill_contrasts
from inertialcal.statistics.intervals import coverage_factor, covers
from inertialcal.statistics.two_levels import TwoLevels, fit_many_levels, fit_two_levels, fit_with_prior

EXACT = 1e-6


def test_equal_noise_gives_the_mean_square_of_the_residuals_less_the_noise() -> None:
    rng = np.random.default_rng(1)
    y = 3.0 + rng.normal(0.0, 0.2, 30)
    found = fit_two_levels(np.ones((30, 1)), y, {"noise": np.full(30, 0.01)})
    assert found.coefficients[0] == pytest.approx(y.mean())
    assert found.between**2 == pytest.approx(y.var(ddof=1) - 0.01, rel=1e-4)
    assert found.covariance[0, 0] == pytest.approx(y.var(ddof=1) / 30, rel=1e-4)
    assert found.chi_square / found.free == pytest.approx(1.0, rel=1e-4)
    assert found.chi_square_known == pytest.approx(np.sum((y - y.mean()) ** 2) / 0.01)
    total = found.parts["noise"] + found.between_part
    assert total == pytest.approx(found.covariance)
    assert found.dof_of(np.eye(1))[0] == pytest.approx(29.0, rel=1e-3)
    assert found.hidden == pytest.approx(y.var(ddof=1) * np.sqrt(2.0 / 29.0), rel=1e-3)


def test_noise_that_explains_everything_leaves_nothing_between() -> None:
    y = np.array([0.0, 0.1, -0.1, 0.05, -0.05])
    found = fit_two_levels(np.ones((5, 1)), y, {"noise": np.full(5, 1.0)})
    assert found.between == 0.0
    assert found.covariance[0, 0] == pytest.approx(0.2)  # not smaller than the known noise allows


def test_a_number_that_two_readings_decide_is_not_judged_by_the_others() -> None:
    """Mean and slope from one good reading at each end; four bad ones between agree with anything."""
    x = np.array([-1.0, 1.0, 0.0, 0.0, 0.0, 0.0])
    design = np.column_stack([np.ones(6), x, np.abs(x) < 0.5])  # the middle has an offset of its own
    noise = np.array([1e-3, 1e-3, 1.0, 1.0, 1.0, 1.0])
    found = fit_two_levels(design, np.array([0.0, 2.0, 0.5, -0.9, 1.4, 0.2]), {"noise": noise**2})
    mean, slope, _ = found.dof_of(np.eye(3))
    assert mean == pytest.approx(slope)
    assert mean < 1e-4
    middle = np.array([[1.0, 0.0, 1.0]])  # the mean of four readings, whatever the ends say
    assert found.dof_of(middle)[0] == pytest.approx(3.0, rel=0.01)
    assert found.by_between(middle)[0, 0] == pytest.approx(0.25)


def test_a_scatter_that_is_given_is_known_for_good() -> None:
    found = fit_two_levels(np.eye(2), np.ones(2), {"noise": np.ones(2)}, between=0.5)
    assert np.isinf(found.dof_of(np.eye(2))).all()
    assert found.hidden == 0.0
    assert found.covariance == pytest.approx(1.25 * np.eye(2))


def test_interval_of_the_scatter_is_that_of_chi_square_less_the_noise() -> None:
    y = np.random.default_rng(5).normal(0.0, 0.3, 20)
    found = fit_two_levels(np.ones((20, 1)), y, {"noise": np.full(20, 0.01)})
    square = np.sum((y - y.mean()) ** 2)
    expected = [np.sqrt(square / stats.chi2.ppf(p, 19) - 0.01) for p in (0.975, 0.025)]
    assert found.between_interval == pytest.approx(expected, rel=1e-6)
    quiet = fit_two_levels(np.ones((20, 1)), 0.3 * y, {"noise": np.full(20, 0.01)})
    assert quiet.between_interval[0] == 0.0


@pytest.mark.parametrize("scatter", [0.1, 0.7])
def test_interval_of_the_scatter_holds_it(scatter: float) -> None:
    """Whether it is seen or not: readings of unequal noise, 0.2 to 1."""
    rng, n, hits = np.random.default_rng(6), 1000, 0
    noise = np.linspace(0.2, 1.0, 12)
    for _ in range(n):
        y = rng.normal(0.0, noise) + rng.normal(0.0, scatter, 12)
        low, high = fit_two_levels(np.ones((12, 1)), y, {"noise": noise**2}).between_interval
        hits += low <= scatter <= high
    assert covers(hits, n)


def test_a_noisy_reading_counts_less() -> None:
    y = np.array([0.0, 0.1, -0.1, 0.05, -0.05, 5.0])
    found = fit_two_levels(np.ones((6, 1)), y, {"noise": np.array([1e-4] * 5 + [100.0])})
    assert abs(found.coefficients[0]) < 0.01


def test_deletion_residuals_are_those_of_a_fit_without_the_reading() -> None:
    rng = np.random.default_rng(2)
    x = rng.normal(size=(12, 3))
    y = x @ [1.0, -2.0, 0.5] + rng.normal(0.0, 0.3, 12)
    known = np.diag(rng.uniform(0.01, 0.05, 12)) + 0.01
    found = fit_two_levels(x, y, {"noise": known}, between=0.2)
    for k in range(12):
        kept = np.arange(12) != k
        other = fit_two_levels(x[kept], y[kept], {"noise": known[np.ix_(kept, kept)]}, between=0.2)
        pull = np.linalg.solve((known + 0.04 * np.eye(12))[np.ix_(kept, kept)], y[kept] - x[kept] @ other.coefficients)
        predicted = x[k] @ other.coefficients + known[k, kept] @ pull
        assert found.deletion[k] == pytest.approx(y[k] - predicted, abs=EXACT)


def test_coverage_with_both_levels() -> None:
    rng = np.random.default_rng(3)
    design = np.column_stack([np.ones(15), np.linspace(-1.0, 1.0, 15)])
    noise = np.linspace(0.2, 1.0, 15)
    hits = 0
    for _ in range(500):
        y = 2.0 + design[:, 1] + rng.normal(0.0, noise) + rng.normal(0.0, 0.7, 15)
        found = fit_two_levels(design, y, {"noise": noise**2})
        u = float(np.sqrt(found.covariance[1, 1]))
        hits += abs(found.coefficients[1] - 1.0) <= coverage_factor(found.free) * u
    assert covers(hits, 500)


def test_as_many_unknowns_as_readings_is_refused() -> None:
    with pytest.raises(DataError, match="2 readings for 2 unknowns leave no scatter") as error:
        fit_two_levels(np.eye(2), np.ones(2), {"noise": np.ones(2)})
    assert error.value.problems[0].code == "no_dof"


def test_no_scatter_at_all_is_refused() -> None:
    with pytest.raises(DataError, match="do not scatter at all"):
        fit_two_levels(np.ones((4, 1)), np.zeros(4), {})


class TestPrior:
    """A prior on coefficients: closed form, limits, coverage."""

    def test_one_coefficient_is_the_weighted_mean_of_prior_and_readings(self) -> None:
        y = 1.0 + np.array([0.3, -0.2, 0.1, -0.3, 0.2])
        prior = {"prior": (np.array([[1.0 / 0.1]]), np.array([0.5 / 0.1]))}
        found = fit_with_prior(np.ones((5, 1)), y, {"noise": np.full(5, 0.04)}, prior)
        weights = np.array([5.0 / (0.04 + found.between**2), 1.0 / 0.1**2])
        assert found.coefficients[0] == pytest.approx(weights @ [y.mean(), 0.5] / weights.sum())
        assert found.covariance[0, 0] == pytest.approx(1.0 / weights.sum())
        total = sum(found.parts.values()) + found.between_part
        assert total == pytest.approx(found.covariance)

    def test_a_prior_that_says_nothing_changes_nothing(self) -> None:
        rng = np.random.default_rng(5)
        x, noise = rng.normal(size=(12, 3)), np.full(12, 0.01)
        y = x @ [1.0, -2.0, 0.5] + rng.normal(0.0, 0.3, 12)
        plain = fit_two_levels(x, y, {"noise": noise})
        wide = fit_with_prior(x, y, {"noise": noise}, {"prior": (1e-3 * np.eye(3), np.zeros(3))})
        assert wide.coefficients == pytest.approx(plain.coefficients, rel=1e-4)
        assert wide.covariance == pytest.approx(plain.covariance, rel=1e-3)
        assert wide.between == pytest.approx(plain.between, rel=1e-3)

    def test_a_wrong_prior_is_no_scatter_beyond_the_one_given(self) -> None:
        y = 1.0 + np.array([0.3, -0.2, 0.1, -0.3, 0.2])
        prior = {"prior": (np.array([[1000.0]]), np.array([0.0]))}
        noise = {"noise": np.full(5, 1e-4)}
        assert fit_with_prior(np.ones((5, 1)), y, noise, prior).between > 0.9
        assert fit_with_prior(np.ones((5, 1)), y, noise, prior, most=0.4).between == pytest.approx(0.4)

    def test_fewer_readings_than_coefficients(self) -> None:
        rng, hits = np.random.default_rng(6), []
        for _ in range(200):
            x, b = rng.normal(size=(4, 6)), rng.normal(0.0, 0.5, 6)
            y = x @ b + rng.normal(0.0, 0.1, 4)
            found = fit_with_prior(x, y, {"noise": np.full(4, 0.01)}, {"prior": (2.0 * np.eye(6), np.zeros(6))})
            hits += list(np.abs(found.coefficients - b) <= 1.96 * np.sqrt(np.diag(found.covariance)))
        assert 0.93 < np.mean(hits) < 0.97


def covariances(kind: str, sets: int, n: int) -> Array:
    """Return what is known of readings: of each apart, of all together, of none, alike, or of few sources."""
    rng = np.random.default_rng(n)
    if kind == "apart":
        return np.asarray(rng.uniform(0.1, 1.0, (sets, 1, n)) * np.eye(n))
    if kind in {"joint", "few"}:
        root = rng.normal(size=(sets, n, n if kind == "joint" else 2))
        return np.asarray(root @ root.swapaxes(1, 2) / n)
    return np.asarray(np.tile(0.3 * np.eye(n) * (kind == "alike"), (sets, 1, 1)))


@pytest.mark.parametrize("kind", ["apart", "joint", "none", "alike", "few"])
@pytest.mark.parametrize(("n", "p"), [(24, 9), (5, 3), (3, 2), (2, 1)])
def test_contrasts_are_those_of_eigenvalues(kind: str, n: int, p: int) -> None:
    """Variances apart in order, and weighted squares that do not depend on which contrasts they are of."""
    rng = np.random.default_rng(7)
    design, y, fixed = rng.normal(size=(4, n, p)), rng.normal(size=(4, n)), covariances(kind, 4, n)
    known, pull, largest, squares = np.empty((4, n - p)), np.empty((4, n - p)), np.empty(4), np.empty(4)
    fill_contrasts(design, y, fixed, known, pull, largest, squares)
    for k in range(4):
        free = np.linalg.qr(design[k], mode="complete")[0][:, p:]
        sizes, axes = np.linalg.eigh(free.T @ fixed[k] @ free)
        np.testing.assert_allclose(known[k], np.maximum(sizes, 0.0), rtol=0.0, atol=1e-13 * max(1.0, sizes.max()))
        for square in (0.3, 2.0):
            expected = np.sum((axes.T @ free.T @ y[k]) ** 2 / (np.maximum(sizes, 0.0) + square))
            assert np.sum(pull[k] / (known[k] + square)) == pytest.approx(expected, rel=1e-11)
        assert largest[k] == pytest.approx(max(np.mean((free.T @ y[k]) ** 2), np.trace(fixed[k]) / n))
        assert 0.0 <= squares[k] < np.inf


@pytest.mark.parametrize("between", [None, 0.3])
def test_scatters_at_once_are_those_that_are_asked_for(between: float | None) -> None:
    rng = np.random.default_rng(8)
    noise = rng.uniform(0.1, 1.0, (3, 12))
    noise[1, 4] = 0.0  # known to be exact: no chi-square
    many = fit_many_levels(rng.normal(size=(3, 12, 4)), rng.normal(size=(3, 12)), {"noise": noise}, between)
    for at_once, asked in zip(many.fits(range(3), with_scatter=True), many.fits(range(3)), strict=True):
        assert isinstance(at_once, TwoLevels)
        assert isinstance(asked, TwoLevels)
        assert at_once.between_interval == pytest.approx(asked.between_interval, rel=1e-14)
        assert at_once.chi_square_known == pytest.approx(asked.chi_square_known, rel=1e-14, nan_ok=True)

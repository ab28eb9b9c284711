"""Launches about as small as what flips do not know: how often intervals of the drift and of the next flight hold."""

from __future__ import annotations

import numpy as np
import pytest

from inertialcal.procedures.shifted_model.fit import fitted
from inertialcal.statistics.intervals import coverage_factor
from sized import sized

FLIPS, LAUNCH, DRIFT = 2, 1.0, 2.0  # flips of a flight; size of launches, and of drifts a year
HOLD = 0.93


def held(flights: int, u: float, kept: bool, seed: int) -> tuple[bool, bool]:
    """Whether intervals of the drift and of the flight that follows hold the truth."""
    rng = np.random.default_rng(seed)
    years, group = np.sort(rng.uniform(0.0, 8.0, flights)), np.repeat(np.arange(flights), FLIPS)
    drift, launches = rng.normal(0.0, DRIFT), rng.normal(0.0, LAUNCH, flights + 1)
    launches = np.cumsum(launches) if kept else launches
    middle = float(years[group].mean())
    design = np.column_stack([np.ones(len(group)), years[group] - middle])
    shift = 30.0 + drift * years[group] + launches[group] + rng.normal(0.0, u, len(group))
    fit = fitted(design, shift, np.full(len(group), u), group, 2, kept, None)
    k = coverage_factor(fit.dof)
    _, covariance = fit.predicted(np.array([[0.0, 1.0]]), ahead=False)
    own = abs(float(fit.coefficients[1]) - drift) <= k * float(np.sqrt(covariance[0, 0]))
    row = np.array([1.0, years[-1] - middle])
    weights, covariance = fit.predicted(row[None])
    off = float((weights @ shift)[0]) - (30.0 + drift * float(years[-1]) + float(launches[-1]))
    return own, abs(off) <= k * float(np.sqrt(covariance[0, 0] + fit.launch(row)))


@pytest.mark.parametrize("n", [20, pytest.param(sized(1000, 300), marks=pytest.mark.slow)])
@pytest.mark.parametrize("kept", [False, True], ids=["fresh", "kept"])
@pytest.mark.parametrize("flights", [6, 10, 16])
def test_intervals_hold_whatever_the_size_of_launches(flights: int, kept: bool, n: int) -> None:
    for u in (0.4, 0.7, 1.5):
        each = np.array([held(flights, u, kept, seed) for seed in range(1, n + 1)]).mean(axis=0)
        print(f"{flights} flights, u of {u} launches: {100.0 * each} % of {n} hold")
        assert (each > HOLD - 3.0 * np.sqrt(HOLD * (1.0 - HOLD) / n)).all()


@pytest.mark.parametrize("square", [0.5, 3.0, 6.0, 40.0])
def test_a_mean_is_off_by_the_mixture_of_what_launches_may_be(square: float) -> None:
    """Of F flights of like u, the variance of the mean is u^2 / F times q / w, at least 1, with chi-squared w."""
    flights, u = 6, 2.0
    shift = np.array([-1.0, 1.0, 0.5, -0.5, 0.2, -0.2])
    shift *= u * np.sqrt(square / float(shift @ shift))
    fit = fitted(np.ones((flights, 1)), shift, np.full(flights, u), np.arange(flights), 1, False, None)
    alone = u / np.sqrt(flights)
    rng = np.random.default_rng(1)
    drawn = np.maximum(1.0, square / rng.chisquare(flights - 1, 400_000)) ** 0.5 * rng.normal(size=400_000)
    student = coverage_factor(flights - 1) * max(1.0, square / (flights - 1)) ** 0.5
    wanted = max(float(np.quantile(np.abs(drawn), 0.95)), student) * alone
    _, covariance = fit.predicted(np.ones((1, 1)))
    assert coverage_factor(fit.dof) * float(np.sqrt(covariance[0, 0])) == pytest.approx(wanted, rel=5e-3)
    assert (fit.tau > 0.0) == (square > flights - 1)

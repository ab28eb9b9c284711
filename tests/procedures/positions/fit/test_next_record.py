"""Bias of these rests and of the next record: what the wander of a bias does to both."""

from __future__ import annotations

import numpy as np
import pytest

from independent.static import flicker
from inertialcal.core.estimate import Array
from inertialcal.procedures.positions.fit.next_record import Rests, Wander, rests_of, slow_noise_of
from inertialcal.procedures.positions.readings import Readings, Triad
from inertialcal.statistics.intervals import coverage_factor
from inertialcal.statistics.slow_noise import FLICKER, WALK, flicker_covariance, walk_covariance, window_covariance
from inertialcal.statistics.two_levels import fit_two_levels, with_gain

M, REST, TURN = 24, 6.0, 1.5
START: Array = np.asarray((REST + TURN) * np.arange(M), dtype=np.float64)
RESTS = Rests(START, START + REST, float(START[-1] + REST))
ALONE = np.tile([1.0, 0.0, 0.0], (M, 1))
HERTZ = 10.0


def found(y: Array, noise: float) -> tuple[float, float]:
    """Return half of the interval of the next record, and the part of the scatter that is one of positions."""
    fit = fit_two_levels(np.ones((M, 1)), y, {"noise": np.full(M, noise**2)})
    slow = slow_noise_of(Wander(fit.projector, fit.residuals, fit.free, fit.between**2, np.arange(M), ALONE), RESTS)
    assert slow is not None
    u, dof = slow.next_record(RESTS.weights, 0, noise**2 / M)
    return u * coverage_factor(dof), slow.of_positions


def wandering(rng: np.random.Generator) -> tuple[Array, float]:
    """Return the means over the rests of flicker of unit size, and the mean of a record that follows."""
    n = round(RESTS.length * HERTZ)
    values = flicker(rng, 1.0, 2 * n)
    means = [values[round(a * HERTZ) : round(b * HERTZ)].mean() for a, b in zip(RESTS.start, RESTS.stop, strict=True)]
    return np.array(means), float(values[n:].mean())


def test_windows_of_one_length_are_blocks() -> None:
    times = np.array([0.5, 1.5, 4.5, 9.5])
    for kind, blocks in ((FLICKER, flicker_covariance), (WALK, walk_covariance)):
        assert window_covariance(times - 0.5, times + 0.5, kind) == pytest.approx(blocks(times, 1.0), abs=1e-12)


def test_next_record_holds_where_the_noise_of_the_mean_does_not() -> None:
    rng, n, hits, white = np.random.default_rng(5), 60, 0, 0
    for _ in range(n):
        means, after = wandering(rng)
        y = means + 0.3 * rng.standard_normal(M)
        half, _ = found(y, 0.3)
        hits += abs(y.mean() - after) <= half
        white += abs(y.mean() - after) <= 1.96 * 0.3 / np.sqrt(M)
    assert hits >= 54  # 95 % or more: 54 has a chance of 5 %
    assert white < 20


def test_wander_is_told_from_a_scatter_of_positions() -> None:
    rng = np.random.default_rng(6)
    of_wander = np.median([found(wandering(rng)[0], 0.05)[1] for _ in range(9)])
    of_scatter = np.median([found(rng.standard_normal(M), 0.05)[1] for _ in range(9)])
    assert of_wander < 0.45 < of_scatter


def test_scale_of_the_readings_does_not_matter() -> None:
    y = np.random.default_rng(7).standard_normal(M)
    assert found(1e-6 * y, 1e-7)[0] == pytest.approx(1e-6 * found(y, 0.1)[0], rel=1e-6)


def test_rounding_of_the_projector_adds_no_contrast() -> None:
    """Where readings are known to very different variances, zeros of the projector are rounding of its largest part."""
    rng = np.random.default_rng(8)
    fit = fit_two_levels(np.ones((M, 1)), rng.standard_normal(M), {"noise": np.full(M, 0.01)})
    noise = 1e-13 * np.max(fit.projector) * rng.standard_normal((M, M))
    exact, rounded = (
        slow_noise_of(Wander(P, fit.residuals, fit.free, fit.between**2, np.arange(M), ALONE), RESTS)
        for P in (fit.projector, fit.projector + noise + noise.T)
    )
    assert exact is not None
    assert rounded is not None
    u = [one.next_record(RESTS.weights, 0, 0.01 / M)[0] for one in (exact, rounded)]
    assert u[1] == pytest.approx(u[0], rel=1e-6)


def test_too_few_positions_show_nothing() -> None:
    fit = fit_two_levels(np.ones((4, 1)), np.array([1.0, 2.0, 0.0, 1.5]), {"noise": np.ones(4)})
    some = Rests(START[:4], START[:4] + REST, 60.0)
    assert slow_noise_of(Wander(fit.projector, fit.residuals, fit.free, 0.0, np.arange(4), ALONE[:4]), some) is None


def test_a_scatter_that_does_not_count_leaves_the_noise() -> None:
    fit = fit_two_levels(np.ones((4, 1)), np.array([1.0, 9.0, -4.0, 3.0]), {"noise": np.full(4, 0.04)})
    weights = np.array([[0.4, 0.2, 0.2, 0.2]])
    mean = with_gain(fit, weights, np.zeros((1, 4)))
    assert mean.coefficients[0] == pytest.approx(2.0)
    assert mean.covariance[0, 0] == pytest.approx(0.04 * 0.28)


def test_recordings_whose_clocks_begin_anew_follow_one_another() -> None:
    triad = Triad(np.zeros((4, 3)), np.ones((4, 3)), np.ones((4, 3)), "m/s^2")
    start = np.array([0, 10, 0, 10]) * 10**9
    readings = Readings(triad, start_ns=start, stop_ns=start + 6 * 10**9, recordings=(0, 0, 1, 1))
    rests = rests_of(readings)
    assert rests is not None
    assert rests.start == pytest.approx([0.0, 10.0, 16.0, 26.0])
    assert rests.length == 16.0

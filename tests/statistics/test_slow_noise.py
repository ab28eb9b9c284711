"""White and 1/f noise from block means: closed forms, truth recovered, coverage of contrasts."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import integrate, special

from inertialcal.core.errors import DataError
from inertialcal.core.estimate import Array
from inertialcal.statistics.intervals import covers
from inertialcal.statistics.slow_noise import SlowNoise, blocks_of, flicker_covariance, slow_noise, walk_covariance

BLOCK = 10.0  # [s]
COUNT = 360  # an hour


def record(corner: float, rng: np.random.Generator, step: float = 0.2, sd: float = 1.0) -> Array:
    """Samples of one hour: white of sd 1, and 1/f of equal density at the corner; made four times as long, cut out."""
    count = round(COUNT * BLOCK / step)
    white = rng.normal(0.0, sd, count)
    if corner == 0.0:
        return white
    long = 4 * count
    f = np.fft.rfftfreq(long, step)
    density = np.zeros(len(f))
    density[1:] = 2.0 * sd**2 * step * corner / f[1:]
    parts = rng.normal(size=(len(f), 2)) @ np.array([1.0, 1.0j])
    slow = np.fft.irfft(parts * np.sqrt(density * long / (4.0 * step)), long)
    return white + np.roll(slow, rng.integers(long))[:count]


def blocks(samples: Array) -> Array:
    return np.asarray(samples.reshape(COUNT, -1).mean(axis=1))


TIMES: Array = np.arange(0.5, COUNT, dtype=np.float64) * BLOCK
DESIGN: Array = np.column_stack([np.ones(COUNT), np.where(TIMES < 1800.0, 1.0, -1.0)])
SHAPE = blocks_of(TIMES, BLOCK, DESIGN)
FIRST = ((TIMES > 1480.0) & (TIMES < 1780.0)) / 30.0
SECOND = ((TIMES > 1820.0) & (TIMES < 2120.0)) / 30.0
CONTRASTS = {"difference": 0.5 * (FIRST - SECOND), "mean": 0.5 * (FIRST + SECOND) - 1.0 / COUNT}


def test_variance_of_a_difference_of_means_is_the_integral_of_its_spectrum() -> None:
    h, apart = 3.0, 60.0
    weights = np.zeros(7)
    weights[0], weights[6] = 1.0, -1.0
    times: Array = np.arange(7, dtype=np.float64) * BLOCK

    def passed(f: float) -> float:
        return float(4.0 * np.sin(np.pi * f * apart) ** 2 * np.sinc(f * BLOCK) ** 2)

    edges = np.concatenate([[1e-9], np.arange(1, 400) / BLOCK])
    slow = sum(integrate.quad(lambda f: h / f * passed(f), a, b, limit=200)[0] for a, b in pairwise(edges))
    assert weights @ (h * flicker_covariance(times, BLOCK)) @ weights == pytest.approx(slow, rel=1e-5)


def test_variance_of_white_noise_is_its_density_over_twice_the_length() -> None:
    noise = SlowNoise(0.4, 0.0, np.diag([1e-6, 1e-6]), SHAPE)
    samples = 30 * BLOCK / 0.2  # of sd 1 at 0.2 s in each of the two means
    assert noise.variance(CONTRASTS["difference"])[0] == pytest.approx(0.25 * 2.0 / samples)


@given(st.floats(-1e3, 1e3), st.floats(0.1, 10.0))
def test_a_level_and_a_step_do_not_matter_and_a_scale_goes_with_its_square(level: float, scale: float) -> None:
    means = blocks(record(0.01, np.random.default_rng(5)))
    one = slow_noise(means, SHAPE)
    other = slow_noise(scale * means + level + 3.0 * DESIGN[:, 1], SHAPE)
    assert other.white == pytest.approx(scale**2 * one.white, rel=1e-5)
    assert other.flicker == pytest.approx(scale**2 * one.flicker, rel=1e-4)


@pytest.mark.parametrize("corner", [0.0, 0.01, 0.1])
def test_the_truth_is_recovered_and_intervals_hold_it(corner: float) -> None:
    _coverage(corner, 300)


@pytest.mark.slow
@pytest.mark.parametrize("corner", [0.0, 0.01, 0.1])
def test_the_truth_is_recovered_and_intervals_hold_it_long(corner: float) -> None:
    _coverage(corner, 1000)


def _coverage(corner: float, n: int) -> None:
    hits = dict.fromkeys(CONTRASTS, 0)
    found = []
    for seed in range(1, n + 1):
        means = blocks(record(corner, np.random.default_rng(seed)))
        noise = slow_noise(means, SHAPE)
        found.append((noise.white, noise.flicker))
        for name, weights in CONTRASTS.items():
            variance, dof = noise.variance(weights)
            hits[name] += abs(weights @ means) <= special.stdtrit(dof, 0.975) * np.sqrt(variance)
    assert all(covers(hit, n) for hit in hits.values()), hits
    white = 2.0 * 0.2  # one-sided density of sd 1 at 0.2 s
    middle = np.mean(found, axis=0)
    error = np.std(found, axis=0) / np.sqrt(n)
    assert abs(middle[0] - white) < 5.0 * error[0]
    assert abs(middle[1] - white * corner) < 5.0 * error[1] + 0.02 * white * corner


def test_results_that_the_design_sees_bound_a_negative_flicker_part() -> None:
    """On white noise the likelihood alone may leave a step a negative variance, as no contrast shows it."""
    step = DESIGN[None, :, 1] - DESIGN[:, 1].mean()
    for seed in range(1, 11):
        means = np.random.default_rng(seed).normal(size=COUNT)
        noise = slow_noise(means, SHAPE, step)
        white = noise.white / (2.0 * BLOCK) * float(step[0] @ step[0])
        assert noise.variance(step[0])[0] >= 0.09 * white


def test_what_cannot_be_told_is_refused() -> None:
    with pytest.raises(DataError, match="17 block means, of which 2 are fitted: need 16 more"):
        blocks_of(TIMES[171:188], BLOCK, DESIGN[171:188])
    with pytest.raises(DataError, match="do not differ"):
        slow_noise(np.full(COUNT, 3.0), SHAPE)
    noise = slow_noise(blocks(record(0.0, np.random.default_rng(1))), SHAPE)
    with pytest.raises(DataError, match="do not add up to 0"):
        noise.variance(np.full(COUNT, 1.0 / COUNT))


@pytest.mark.parametrize("apart", [1, 2, 7])
def test_means_of_a_random_walk_differ_as_a_wiener_process_does(apart: int) -> None:
    """Var of the difference of means over L, d apart, of a walk of variance t in time t: d - L / 3 for d >= L."""
    contrast = np.array([1.0, -1.0])
    found = contrast @ walk_covariance(np.array([0.0, apart * BLOCK]), BLOCK) @ contrast
    assert found == pytest.approx(apart * BLOCK - BLOCK / 3.0, rel=1e-12)  # next to each other: twice tau / 3 of Allan


@pytest.mark.parametrize("length", [0.3, 1.0, 7.0])
def test_means_of_a_walk_over_neighbouring_blocks_differ_by_two_thirds_of_a_block(length: float) -> None:
    """The Allan variance of a random walk, K^2 tau / 3 (IEEE 952), is half of that."""
    differ = np.diff(np.eye(5), axis=0)
    found = differ @ walk_covariance(length * np.arange(5.0), length) @ differ.T
    np.testing.assert_allclose(np.diag(found), 2.0 * length / 3.0, rtol=1e-12)

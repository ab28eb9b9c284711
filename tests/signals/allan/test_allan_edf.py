"""Degrees of freedom and noise types: against the definition, against Greenhall's, against made noise."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from allantools.ci import edf_greenhall
from scipy.linalg import toeplitz
from scipy.signal import fftconvolve

from inertialcal.core.estimate import Array
from inertialcal.signals.allan import Deviation, allan
from inertialcal.signals.allan.deviations import KINDS, terms_of
from inertialcal.signals.allan.edf import degrees_of_freedom


def coloured(power: int, n: int, rng: np.random.Generator, columns: int = 1) -> Array:
    """Return noise with spectrum |2 sin(pi f)|^power, (n, columns), by Kasdin's filter after a start of 2 n."""
    k = np.arange(1.0, 3 * n)
    h = np.concatenate([[1.0], np.cumprod((k - 1.0 - power / 2.0) / k)])
    white = rng.normal(size=(3 * n, columns))
    made: Array = fftconvolve(white, h[:, None], axes=0)[2 * n : 3 * n]
    return made


def weights_of(deviation: Deviation, m: int) -> Array:
    """Return what a term is made of, as weights of the samples."""
    kind = KINDS[deviation]
    blocks = [-1.0, 1.0] if kind.order == 2 else [1.0, -2.0, 1.0]
    weights = np.repeat(blocks, m) / m
    return np.convolve(weights, np.ones(m) / m) if kind.modified else weights


@pytest.mark.parametrize("deviation", [name for name, kind in KINDS.items() if not kind.total])
@pytest.mark.parametrize(("n", "m"), [(60, 1), (60, 4), (96, 12), (240, 60), (400, 40)])
def test_white_noise_by_the_definition(deviation: Deviation, n: int, m: int) -> None:
    kind, weights = KINDS[deviation], weights_of(deviation, m)
    terms = int(terms_of(kind, n + 1, np.array([m]))[0])
    stride = 1 if kind.overlapping else m
    full = np.correlate(weights, weights, mode="full")[len(weights) - 1 :]
    covariance = np.zeros(max(terms * stride, len(full)))
    covariance[: len(full)] = full
    c = toeplitz(covariance[::stride][:terms])
    exact = np.trace(c) ** 2 / np.sum(c * c)
    assert degrees_of_freedom(kind, m, terms, 0) == pytest.approx(exact, rel=3e-3)


@pytest.mark.parametrize(("deviation", "d"), [("overlapping", 2), ("non_overlapping", 2), ("overlapping_hadamard", 3)])
@pytest.mark.parametrize("power", [2, 1, 0, -1, -2, -3, -4])
@pytest.mark.parametrize("m", [20, 100, 300])
def test_greenhall_and_riley_for_long_windows(deviation: Deviation, d: int, power: int, m: int) -> None:
    kind, points = KINDS[deviation], 3001
    if power < max(kind.reddest, -3):  # the peer's table ends before -4
        return
    terms = int(terms_of(kind, points, np.array([m]))[0])
    published = edf_greenhall(power, d, m, points, overlapping=kind.overlapping, modified=False)
    # The flicker of an angle hangs on its bandwidth, which differs; at 20 samples the sampling shows.
    allowed = 0.25 if power == 1 else 0.1 if m == 20 else 0.05
    assert degrees_of_freedom(kind, m, terms, power) == pytest.approx(published, rel=allowed)


@pytest.mark.parametrize("power", [2, 1, 0, -1, -2])
@pytest.mark.parametrize("m", [20, 100, 300])
def test_greenhall_and_riley_for_the_modified_deviation(power: int, m: int) -> None:
    terms = int(terms_of(KINDS["modified"], 3001, np.array([m]))[0])
    published = edf_greenhall(power, 2, m, 3001, overlapping=True, modified=True)
    assert degrees_of_freedom(KINDS["modified"], m, terms, power) == pytest.approx(published, rel=0.05)


def test_sum_over_lags_does_not_hang_on_their_spacing() -> None:
    kind = KINDS["overlapping"]  # windows just short enough for all lags, and just longer
    for power in (1, 0, -1, -2):
        fine = degrees_of_freedom(kind, 32, 3200, power) / 3200 * 32
        assert degrees_of_freedom(kind, 36, 3600, power) / 3600 * 36 == pytest.approx(
            fine, rel=0.02 if power < 1 else 0.1
        )


@pytest.mark.parametrize("power", [2, 1, 0, -1, -2])
def test_noise_types_are_found(power: int) -> None:
    x = coloured(power, 20_000, np.random.default_rng(power + 10))[:, 0]
    found = allan(x, 1.0, quantity="rate", factors=[1, 2, 4, 8] if power > 0 else [1, 2, 4, 8, 16, 32, 64])
    if power < 1:
        assert found.power[:, 0].tolist() == [power] * len(found)
    else:
        assert found.power[0, 0] == power


@pytest.mark.parametrize("power", [-3, -4])
def test_redder_noise_is_found_for_hadamard_and_cut_for_allan(power: int) -> None:
    x = np.cumsum(coloured(power + 2, 8_000, np.random.default_rng(1)), axis=0)[:, 0]
    found = allan(x, 1.0, quantity="rate", deviation="overlapping_hadamard", factors=[2, 4, 8])
    assert found.power[:, 0].tolist() == [power] * 3
    assert allan(x, 1.0, quantity="rate", factors=[2, 4]).power[:, 0].tolist() == [-2, -2]


def test_white_gives_way_to_random_walk() -> None:
    rng = np.random.default_rng(2)
    x = rng.normal(size=100_000) + np.cumsum(0.02 * rng.normal(size=100_000))
    found = allan(x, 1.0, quantity="rate").power[:, 0]
    assert found[:3].tolist() == [0.0] * 3
    assert found[-4:].tolist() == [-2.0] * 4
    assert all(a >= b for a, b in pairwise(found))


def test_noise_type_may_be_said() -> None:
    x = np.random.default_rng(1).normal(size=1000)
    found = allan(x, 1.0, quantity="rate", noise=-2)
    assert np.all(found.power == -2)
    assert found.edf[3, 0] < allan(x, 1.0, quantity="rate").edf[3, 0]


def test_interval_of_more_probability_is_wider() -> None:
    x = np.random.default_rng(1).normal(size=1000)
    one, two = (allan(x, 1.0, quantity="rate", p=p) for p in (0.6827, 0.95))
    assert np.all((two.lo < one.lo) & (one.lo < one.deviation) & (one.deviation < one.hi) & (one.hi < two.hi))

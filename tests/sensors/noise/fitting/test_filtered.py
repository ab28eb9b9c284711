"""Noise behind a filter: the band that is found, and what its pole takes of an Allan variance."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import butter, lfilter, sosfilt

from inertialcal.sensors.noise import BiasInstability, RandomWalk, RateRandomWalk, fit, simulate
from inertialcal.sensors.noise.fitting.allan_covariance import covariance_of_allan
from inertialcal.sensors.noise.fitting.filtered import (
    DOUBTFUL,
    SHAPE,
    Band,
    Search,
    corner_of,
    crossing,
    rolled,
    search,
    search_many,
)
from inertialcal.sensors.noise.fitting.problem import Run
from inertialcal.sensors.noise.fitting.spread import spread_with
from inertialcal.sensors.noise.terms import Phase
from inertialcal.signals.allan import allan
from inertialcal.signals.spectrum.psd import psd, psd_alike

N = 40_000
CORNER = 0.1  # cycles a sample


def filtered(kind: str, x: NDArray[np.float64]) -> NDArray[np.float64]:
    if kind == "first order":
        kept = np.exp(-2.0 * np.pi * CORNER)
        return np.asarray(lfilter([1.0 - kept], [1.0, -kept], x))
    if kind == "mean of 4":
        return np.asarray(lfilter(np.full(4, 0.25), [1.0], x))
    return np.asarray(sosfilt(butter(4, CORNER, fs=1.0, output="sos"), x))


def searched(x: NDArray[np.float64]) -> Search:
    found = search(psd(x, 1.0))
    assert found is not None
    return found


@pytest.mark.parametrize("kind", ["first order", "mean of 4", "fourth order"])
def test_the_level_inside_the_band_is_the_random_walk(kind: str) -> None:
    """All filters have gain 1 at low frequency: N stays 1."""
    x = filtered(kind, np.random.default_rng(7).standard_normal(N))
    found = searched(x)
    assert Search.together([found])
    band = found.band()
    assert band is not None
    assert band.corner == pytest.approx(CORNER, rel=0.15)
    terms = fit(allan(x, 1.0, quantity="rate"), None, bands=[band], axis=0)
    assert [term.name for term in terms.terms] == ["random_walk"]
    (white,) = terms.found[0].parameters
    assert white.interval.lo is not None
    assert white.interval.hi is not None
    assert white.interval.lo < 1.0 < white.interval.hi
    assert white.u < 0.025


@pytest.mark.parametrize(
    "terms", [(RandomWalk(1.0),), (RandomWalk(0.1), BiasInstability(1.0)), (RandomWalk(1.0), RateRandomWalk(0.1))]
)
def test_noise_without_a_filter_shows_none(terms: tuple[RandomWalk, ...]) -> None:
    found = searched(simulate(terms, N, 1.0, np.random.default_rng(3)))
    assert not Search.together([found])


def test_a_pole_takes_what_the_closed_form_says() -> None:
    """First order: autocovariance a^k of a process whose density at zero is (1 + a) / (1 - a)."""
    a = 0.6
    cycles = (np.arange(4000) + 0.5) / 8000.0
    passed = np.asarray((1.0 - a) ** 2 / (1.0 - 2.0 * a * np.cos(2.0 * np.pi * cycles) + a * a), dtype=np.float64)
    band = Band(CORNER, cycles.astype(np.float64), passed, (CORNER,) * 3, 0.0, np.zeros((2, 2)))
    level = (1.0 + a) / (1.0 - a)
    m = np.array([1.0, 2.0, 16.0, 128.0, 4096.0])
    sums = [k * level - 2.0 * a * (1.0 - a**k) / (1.0 - a) ** 2 for k in (m, 2.0 * m)]  # variance of sums of k
    wanted = (4.0 * sums[0] - sums[1]) / (2.0 * m**2)
    found = level / m - band.lost([Phase(linear=level)], m)[0]
    np.testing.assert_allclose(found, wanted, rtol=2e-3)


def test_parts_of_a_band_are_their_closed_forms() -> None:
    """1 / (1 + s 4 sin^2(pi f)) folds a pole, cosh(2 pi fc) = 1 + 1 / (2 s); curve 2: (1 + x^2)^-2; half by halves."""
    kept = np.exp(-2.0 * np.pi * CORNER)
    assert corner_of(kept / (1.0 - kept) ** 2) == pytest.approx(CORNER)
    np.testing.assert_allclose(rolled(np.array([0.0, 1.0, 2.0]), 2.0), [1.0, 0.25, 0.04])
    cycles = np.geomspace(0.01, 0.5, 200)
    assert crossing(cycles, 1.0 / (1.0 + (cycles / CORNER) ** 2), CORNER) == pytest.approx(CORNER, rel=1e-3)
    band = Band(CORNER, np.array([0.1, 0.2]), np.array([0.8, 0.5]), (CORNER,) * 3, 0.0, np.zeros((2, 2)))
    np.testing.assert_allclose(band.passed_at(np.array([0.05, 0.1])), [0.95, 0.8])


def test_what_is_not_known_of_a_filter_widens_the_covariance() -> None:
    """By the uncertainty of what it takes, at each averaging time, of the same noise; its shape is common to all."""
    cycles = np.asarray((np.arange(4000) + 0.5) / 8000.0, dtype=np.float64)
    passed, doubt = np.exp(-((cycles / CORNER) ** 2)), np.array([[4e-3, -1e-3], [-1e-3, 9e-3]])
    band = Band(CORNER, cycles, passed, (CORNER,) * 3, 0.5, doubt)
    m, power = np.exp2(np.arange(5.0, 12.0)), 0.04
    n, ones = 20_000.0 - 2.0 * m + 1.0, np.ones(len(m))
    run = Run(m, ones, n, ones, 1.0, 1.0, ones, band=band)
    found = spread_with((run,), (RandomWalk(1.0),)).covariance(np.array([power]))
    noise = Phase(linear=power)
    lost = band.lost([noise], m)[0]
    own = covariance_of_allan(noise + Phase(point=-lost[0] * m[0] ** 2 / 3.0), m, n)
    by = band.slopes([noise], m)[0]
    wider = 1.0 + np.sqrt(np.einsum("ki,ij,kj->k", by, doubt, by) / np.diag(own))
    assert wider[0] > 1.1
    np.testing.assert_allclose(found, own * np.outer(wider, wider) + SHAPE**2 * np.outer(lost, lost), rtol=1e-9)


@pytest.mark.parametrize("kind", ["none", "first order"])
def test_sizes_left_out_of_the_search_hide_nothing(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    x = np.random.default_rng(5).normal(size=20_000)
    spectrum = psd(x if kind == "none" else lfilter([0.6], [1.0, -0.4], x), 0.01)
    few = search(spectrum)
    monkeypatch.setattr("inertialcal.sensors.noise.fitting.filtered.COARSE", 1)  # all are tried
    monkeypatch.setattr("inertialcal.sensors.noise.fitting.filtered.STRIDE", 1)
    every = search(spectrum)
    assert few is not None
    assert every is not None
    assert few.hidden == every.hidden
    assert max(few.gain, every.gain) < DOUBTFUL or (few.gain, few.corner) == (every.gain, every.corner)
    assert Search.together([few]) == (kind != "none")


def test_spectra_searched_together_give_what_each_gives_alone() -> None:
    rng = np.random.default_rng(3)
    white = [rng.normal(size=20_000) for _ in range(4)]
    x = [*white[:3], lfilter([0.6], [1.0, -0.4], white[3]), np.cumsum(white[0]), rng.normal(size=300)]
    steep = np.convolve(white[1], np.hanning(12), "same")
    asked = [(one, None) for one in psd_alike([*x[:5], steep], 0.01).apart()]
    asked += [(asked[1][0], np.arange(len(asked[1][0].frequency)) % 97 == 3), (psd(x[5], 0.01), None)]
    together = search_many(asked)
    assert [one is None for one in together] == [False] * 7 + [True]
    for (spectrum, marked), found in zip(asked, together, strict=True):
        alone = search(spectrum, marked)
        if found is not None and alone is not None:
            assert (found.gain, found.corner, found.hidden) == (alone.gain, alone.corner, alone.hidden)
            np.testing.assert_array_equal(found.density, alone.density)
            np.testing.assert_array_equal(found.cycles, alone.cycles)
        else:
            assert found is alone
    assert [one is not None and Search.together([one]) for one in together] == [False] * 3 + [
        True,
        False,
        True,
        False,
        False,
    ]

"""Intervals keep their promise, with the noise type found from each record: white, flicker, random walk.

Issue 6: within 3 points of 68 and 95 % up to an eighth of the record; beyond, too wide by at most 7 points, never too
narrow; judged by the 99.9 % binomial interval of the hit rate. The chi-square form alone gives 70.9 for 68.3 % at an
eighth of the record (white noise, Hadamard). The truth is the mean of the variances over all records, of total ones of
those without mirrors. Seeds: 1, 2, 3.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest
from scipy.signal import fftconvolve

from inertialcal.core.estimate import Array
from inertialcal.signals.allan import Deviation, allan
from inertialcal.signals.allan.deviations import KINDS
from inertialcal.signals.allan.edf import interval
from inertialcal.statistics.intervals import binomial_interval
from sized import sized

N = 1024  # samples a record
FACTORS = [1, 2, 4, 8, 16, 32, 64, 128, 192, 256]
POINTS, BEYOND = 0.03, 0.07
MIRRORED: dict[Deviation, Deviation] = {
    "total": "overlapping", "modified_total": "modified", "hadamard_total": "overlapping_hadamard",
}  # fmt: skip
SEEDS = {"white": 1, "flicker": 2, "walk": 3}


@lru_cache(maxsize=3)
def records(noise: str, n: int) -> Array:
    rng = np.random.default_rng(SEEDS[noise])
    if noise == "flicker":  # Kasdin's filter, started 3 N before
        k = np.arange(1.0, 4 * N)
        h = np.concatenate([[1.0], np.cumprod((k - 0.5) / k)])
        made = [fftconvolve(rng.normal(size=(4 * N, 100)), h[:, None], axes=0)[3 * N : 4 * N] for _ in range(n // 100)]
        return np.asfortranarray(np.concatenate(made, axis=1))
    x = np.asfortranarray(rng.normal(size=(N, n)))
    return np.cumsum(x, axis=0) if noise == "walk" else x


def check(noise: str, deviation: Deviation, n: int) -> None:
    found = allan(records(noise, n), 1.0, quantity="rate", deviation=deviation, factors=FACTORS)
    plain = allan(
        records(noise, n), 1.0, quantity="rate", deviation=MIRRORED.get(deviation, deviation), factors=FACTORS
    )
    truth = np.sqrt(plain.variance.mean(axis=1))[:, None]
    for p in (0.6827, 0.95):
        lo, hi = interval(found.deviation, found.edf, p)
        hits = np.count_nonzero((lo <= truth) & (truth <= hi), axis=1)
        for m, hit in zip(FACTORS, hits.tolist(), strict=True):
            least, most = binomial_interval(hit, n)
            told = f"{noise}, {deviation}, m = {m}: {hit / n:.1%} of {n} intervals of {p:.0%}"
            if m > N // 8:
                assert most >= p, told
                assert least <= p + BEYOND, told
            else:
                assert most >= p - POINTS, told
                assert least <= p + POINTS, told


@pytest.mark.parametrize("deviation", KINDS)
@pytest.mark.parametrize("noise", SEEDS)
def test_coverage_of_300(noise: str, deviation: Deviation) -> None:
    check(noise, deviation, 300)


@pytest.mark.slow
@pytest.mark.parametrize("deviation", KINDS)
@pytest.mark.parametrize("noise", SEEDS)
def test_coverage_of_many(noise: str, deviation: Deviation) -> None:
    check(noise, deviation, sized(4000, 1000))

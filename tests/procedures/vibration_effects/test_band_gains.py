"""The gain of a band: its interval holds the truth where few windows tell the noise; false findings are rare."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from independent.coverage import keeps
from inertialcal.procedures.vibration_effects.spectra import bands_of, summed

SAMPLES, WINDOW = 3000, 200  # 29 windows


def tried(n: int, gain: float) -> tuple[Counter[int], Counter[str]]:
    """Return hits by band, and how many records have a band that is significant, of white records."""
    hits: Counter[int] = Counter()
    found: Counter[str] = Counter()
    for seed in range(1, n + 1):
        rng = np.random.default_rng([seed, 5])
        x = rng.standard_normal(SAMPLES)
        spectra = summed([(x, gain * x + rng.standard_normal(SAMPLES))], 1e-3, WINDOW)
        assert spectra is not None
        bands = bands_of(spectra, None)
        hits.update({i: int(one.lo <= gain <= one.hi) for i, one in enumerate(bands)})
        found["significant"] += any(one.significant for one in bands)
    return hits, found


@pytest.mark.parametrize("gain", [0.1, 1.0])
def test_intervals_of_gains_hold(gain: float) -> None:
    hits, _ = tried(60, gain)
    assert len(hits) == 5
    assert all(keeps("holds", one, 60) for one in hits.values()), hits


def test_noise_alone_is_seldom_significant() -> None:
    _, found = tried(60, 0.0)
    assert found["significant"] <= 10  # of 3 expected


@pytest.mark.slow
@pytest.mark.parametrize("gain", [0.02, 0.1, 1.0])
def test_intervals_of_gains_hold_in_1000(gain: float) -> None:
    hits, _ = tried(1000, gain)
    assert all(keeps("holds", one, 1000) for one in hits.values()), hits

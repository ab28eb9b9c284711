"""Spectra against scipy's Welch method, on the same segments, densities agreeing."""

from __future__ import annotations

from functools import partial

import numpy as np
from scipy.signal import welch

import inertialcal as ic
from inertialcal.signals.spectrum.psd import psd

from ..comparison import Work, line

AGREES = 1e-11  # relative


def alone(n: int, segment: int | None) -> Work:
    x = np.random.default_rng(1).normal(size=n)
    found = psd(x, 1.0, segment=segment)
    size = {"nperseg": found.segment, "noverlap": found.segment // 2}
    order = np.rint(found.frequency * found.segment).astype(np.int64)
    np.testing.assert_allclose(found.density[:, 0], welch(x, 1.0, **size)[1][order], rtol=AGREES)
    return Work(lambda: psd(x, 1.0, segment=segment), lambda: welch(x, 1.0, **size), moved=x.nbytes)


def whole(n: int) -> Work:
    x = np.random.default_rng(1).normal(size=n)
    ic.psd(x, sample_rate=1.0)
    size = 2**17 if n // 8 > 2**17 else n // 8  # as `ic.psd` has it of a long record
    return Work(
        lambda: ic.psd(x, sample_rate=1.0), lambda: welch(x, 1.0, nperseg=size, noverlap=size // 2), moved=x.nbytes
    )


for samples, length in ((1_000_000, None), (10_000_000, None), (10_000_000, 2**17)):
    name = f"psd, {samples:.0e} samples, segments of {length or samples // 8}"
    line(name, peer="scipy.signal.welch", goal=2.0)(partial(alone, samples, length))
for samples in (1_000_000, 10_000_000):
    line(f"ic.psd, {samples:.0e} samples", peer="scipy.signal.welch alone", goal=2.0)(partial(whole, samples))

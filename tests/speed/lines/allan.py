"""Allan deviations against allantools, on the same array and averaging times, results agreeing."""

from __future__ import annotations

from functools import partial

import allantools
import numpy as np

import inertialcal as ic
from inertialcal.core.estimate import Array
from inertialcal.signals.allan import Deviation, allan
from inertialcal.signals.allan.deviations import KINDS, variances
from inertialcal.signals.allan.prefix import give_back, phase_of

from ..comparison import Work, line

AGREES = 1e-9  # relative


def noise(n: int) -> Array:
    return np.random.default_rng(1).normal(size=n)


def whole(n: int) -> Work:
    x = noise(n)
    ic.allan(x, sample_rate=1.0)
    return Work(
        own=lambda: ic.allan(x, sample_rate=1.0),
        peer=lambda: allantools.oadev(x, rate=1.0, data_type="freq", taus="octave"),
        moved=x.nbytes,
    )


for size, least in ((100_000, 0.0), (1_000_000, 1.0), (10_000_000, 1.0)):
    line(f"ic.allan, {size:.0e} samples", peer="allantools.oadev alone", goal=least)(partial(whole, size))


def kernel(deviation: Deviation, peer: str, n: int) -> Work:
    x = noise(n)
    found = allan(x, 1.0, quantity="rate", deviation=deviation)

    def own() -> Array:
        phase = phase_of(x, "rate")
        deviations: Array = np.sqrt(variances(phase, KINDS[deviation], found.m).variance)
        give_back(phase)
        return deviations

    def theirs() -> Array:
        deviations: Array = getattr(allantools, peer)(x, rate=1.0, data_type="freq", taus=found.tau)[1]
        return deviations

    np.testing.assert_allclose(own(), theirs(), rtol=AGREES)
    return Work(own, theirs, moved=x.nbytes)


GOALS: dict[Deviation, tuple[str, dict[int, float]]] = {
    "overlapping": ("oadev", {100_000: 15.0, 1_000_000: 40.0, 10_000_000: 40.0}),
    "modified": ("mdev", {100_000: 6.0, 1_000_000: 6.0, 10_000_000: 6.0}),
    "overlapping_hadamard": ("ohdev", {100_000: 6.0, 1_000_000: 6.0}),
}
for kind, (name, goals) in GOALS.items():
    for size, least in goals.items():
        line(f"{kind}, kernel, {size:.0e} samples", peer=f"allantools.{name}", goal=least)(
            partial(kernel, kind, name, size)
        )

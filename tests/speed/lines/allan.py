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
from inertialcal.signals.allan.total import Total, total_deviations

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
        line(f"{kind}, kernel, {size:.0e} samples", peer=f"allantools.{name} (1 core)", goal=least)(
            partial(kernel, kind, name, size)
        )


def total(kind: Total, peer: str, n: int, longest: int) -> Work:
    x = noise(n)
    factors = 2 ** np.arange(longest.bit_length())

    def own() -> Array:
        return total_deviations(x, factors, kind)

    def theirs() -> Array:
        taus = factors.astype(np.float64)
        deviations: Array = getattr(allantools, peer)(x, rate=1.0, data_type="freq", taus=taus)[1]
        return deviations

    np.testing.assert_allclose(own(), theirs(), rtol=AGREES)
    return Work(own, theirs, moved=x.nbytes)


# By its time at 1e3 samples, which goes with their square, allantools would take weeks for the other two at 1e6:
# their ratios are of short records, where theirs are the least.
TOTALS: dict[Total, tuple[str, int, int]] = {
    "total": ("totdev", 1_000_000, 2**18),
    "modified_total": ("mtotdev", 1_000, 2**8),
    "hadamard_total": ("htotdev", 1_000, 2**8),
}
for which, (name, size, longest) in TOTALS.items():
    line(f"{which}, octaves, {size:.0e} samples", peer=f"allantools.{name} (1 core)", goal=20.0)(
        partial(total, which, name, size, longest)
    )


def total_of_long_record(kind: Total) -> Work:
    x, factors = noise(1_000_000), 2 ** np.arange(19)
    total_deviations(x[:4000], factors[:10], kind)
    return Work(lambda: total_deviations(x, factors, kind), 60.0, moved=x.nbytes)


for which in ("modified_total", "hadamard_total"):
    line(f"{which}, octaves, 1e+06 samples", peer="allowed (allantools: weeks)", goal=1.0)(
        partial(total_of_long_record, which)
    )

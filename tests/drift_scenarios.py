"""Pulse rate of an accelerometer under a small known drive, in drift and noise as a report of 1969 had them.

Made inputs: scatter of the runs as the report's own figures give it, shapes of drift assumed (its curves are not in the
text): a random cubic of about 0.5 pps, a thermostat's saw-tooth of 25 to 40 samples that rises for 85 % of its period.
Noise: white, 1/f by Hosking's filter, random walk; counts are whole impulses in 100 s.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

N = 100  # samples
STEP = 120.0  # from sample to sample [s]: 100 s counted, 20 s to move the mass
AMPLITUDE = 0.2348  # [pps]: 23 ng at 10.21 pps/ug
ONE_COUNT = 0.01  # [pps]


@dataclass(frozen=True)
class Scenario:
    """Standard deviations a sample [pps]; peak of the saw-tooth, from minus to plus."""

    white: float
    flicker: float = 0.0
    walk: float = 0.0
    cubic: float = 0.0
    saw: float = 0.0


SCENARIOS = {
    "S0": Scenario(0.056),
    "S1": Scenario(0.056, cubic=0.5, saw=0.5),
    "S2": Scenario(0.105, 0.060, cubic=0.5),
    "S3": Scenario(0.105, 0.060, cubic=0.5, saw=0.5),
    "S4": Scenario(0.03, walk=0.17),
    "S5": Scenario(0.105, 0.060, cubic=0.5, saw=1.5),
}


def drawn(scenario: Scenario, drive: Array, n: int, seed: int = 1, amplitude: float = AMPLITUDE) -> Array:
    """Records of a drive of unit amplitude, shape (samples, n) [pps]."""
    rng = np.random.default_rng(seed)
    size = len(drive)
    x = amplitude * drive[:, None] + scenario.white * rng.standard_normal((size, n))
    if scenario.flicker:
        filtered = np.cumprod(np.concatenate([[1.0], (np.arange(1, 4 * size) - 0.5) / np.arange(1, 4 * size)]))
        white = rng.standard_normal((4 * size, n))
        made = np.fft.irfft(np.fft.rfft(white, 8 * size, axis=0) * np.fft.rfft(filtered, 8 * size)[:, None], axis=0)
        x += scenario.flicker * made[3 * size : 4 * size]
    if scenario.walk:
        x += scenario.walk * np.cumsum(rng.standard_normal((size, n)), axis=0)
    place = np.linspace(-1.0, 1.0, size)
    if scenario.cubic:
        x += scenario.cubic * np.polynomial.legendre.legvander(place, 3) @ rng.standard_normal((4, n))
    if scenario.saw:
        period, start = rng.uniform(25.0, 40.0, n), rng.random(n)
        phase = np.mod(np.arange(size)[:, None] / period + start, 1.0)
        rise = 0.85
        x += scenario.saw * (np.where(phase < rise, phase / rise, (1.0 - phase) / (1.0 - rise)) - 0.5)
    return np.round(x / ONE_COUNT) * ONE_COUNT

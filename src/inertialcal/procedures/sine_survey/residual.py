"""What the modes leave of a response at the frequency of the drive: of a linear item that stays as it is, noise alone.

Where an item changes during a sweep (a joint loosens, a crack opens), or is not linear, no set of modes gives both
parts of the record, and what is left follows the drive. It is set against what is left beside the drive at the same
time, so that noise which is coloured or follows the level does not count, and against the resonance nearby: a mode too
small to be one (`least`) leaves something at the drive, too. A steady tone (hum) stands in a line or two of the whole
record, as no resonance does: it is taken out before.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from ...core.estimate import Array
from .modal import Modes
from .swept import Swept

BESIDE = (0.75, 1.25, 1.5)  # of the frequency of the drive, where noise is looked at
AVERAGED = 11  # sums of cycles over which it is averaged
CHANCE = 20.0  # power at the drive over that of the noise, of two sums in turn
SIZE = 0.05  # of the resonance nearby, from which it is told
LEAST = 2.0  # times the least part of a mode
NEAR = 0.15  # of a frequency, within which a resonance is nearby
ENDS = 3  # sums at each end that are left out
LINE, FOOT = 3, 12  # lines of the record that a tone lies in, and to which it reaches, on each side
STEADY = 100.0  # power of a tone over that of its foot


class Residual(NamedTuple):
    """The largest that is left at the drive: when [s], at which frequency [Hz], over the resonance nearby."""

    time: float
    frequency: float
    share: float


def residual_at_drive(swept: Swept, axis: str, modes: Modes, least: float) -> Residual | None:
    """Return what the modes leave of a response at the drive; None where it is no more than noise.

    Parameters
    ----------
    swept : Swept
        The sweep.
    axis : str
        Of the response.
    modes : Modes
        As they were found.
    least : float
        Part of a mode in the transmissibility, below which it is none.
    """
    one, band = swept.sweep, swept.band(axis)
    whole = np.zeros(band.length // 2 + 1, dtype=complex)
    whole[band.first : band.first + len(band.frequency)] = (
        band.response - modes.transmissibility(band.frequency) * band.control
    )
    whole[_of_tones(np.abs(whole) ** 2)] = 0.0
    left = np.zeros(len(swept.shaken.control))
    left[swept.part] = fft.irfft(whole, band.length)
    if len(one.times) < 4 * ENDS:
        return None
    noise = np.mean([np.abs(amplitudes(swept, left, multiple)) ** 2 for multiple in BESIDE], axis=0)
    even = np.ones(AVERAGED)
    noise = np.convolve(noise, even, "same") / np.convolve(np.ones(len(noise)), even, "same")
    power = np.abs(amplitudes(swept, left)) ** 2
    frequency = one.frequency(one.times)
    size = np.abs(amplitudes(swept, swept.shaken.responses[axis])) / np.maximum(one.amplitude, 1e-300)
    nearby = np.array([float(size[np.abs(frequency / f - 1.0) < NEAR].max()) for f in frequency])
    ratio = np.sqrt(power) / np.maximum(one.amplitude, 1e-300)
    told = (power > CHANCE * noise) & (ratio > np.maximum(SIZE * nearby, LEAST * least))
    told[:ENDS], told[-ENDS:] = False, False
    told[1:] &= told[:-1]
    if not told[1:].any():
        return None
    at = int(np.argmax(np.where(told, ratio, 0.0)))
    return Residual(float(one.times[at]), float(frequency[at]), float(ratio[at] / max(nearby[at], 1e-300)))


def _of_tones(power: Array) -> NDArray[np.bool_]:
    """Return whether each line of a record belongs to a steady tone."""
    sides = [np.roll(power, shift) for k in range(LINE + 1, FOOT + 1) for shift in (-k, k)]
    peaks = power > STEADY * np.median(sides, axis=0)
    return np.asarray(np.convolve(peaks, np.ones(2 * FOOT + 1), "same") > 0.0)


def amplitudes(swept: Swept, values: Array, multiple: float = 1.0) -> NDArray[np.complex128]:
    """Return the complex amplitude of a channel at the drive, or a multiple of it, at the times of the sums."""
    one, rate = swept.sweep, swept.shaken.rate
    edges = np.concatenate([[1.5 * one.times[0] - 0.5 * one.times[1]], 0.5 * (one.times[1:] + one.times[:-1]),
                            [1.5 * one.times[-1] - 0.5 * one.times[-2]]])  # fmt: skip
    first, stop = max(0, round(edges[0] * rate)), min(len(values), round(edges[-1] * rate))
    t = np.arange(first, stop) / rate
    starts = np.clip(np.round(edges[:-1] * rate).astype(np.int64) - first, 0, len(t) - 1)
    turned = values[first:stop] * np.exp(-1j * multiple * one.phase(t))
    counts = np.diff(np.append(starts, len(t)))
    return np.asarray(2.0 * np.add.reduceat(turned, starts) / np.maximum(counts, 1))

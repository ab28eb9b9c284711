"""A triaxial head in orbit: from what it feels to what its filters let through, sample by sample.

The reading of a sensor, in the sense of ``sensors.model``::

    r = S(T) / S0 (K0(T, t) + M(T) x + noise)         then 1- and 7-pole low-pass, gain, zero, converter

x is the acceleration along the axes of the head. Noise is that of sensor and electronics: white, and 1/f below a
corner. The filters let what is slow through unchanged.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy import signal

from ...core.estimate import Array
from ..parts.flicker import flicker
from .setup import CUT_OFF_BEFORE, CUT_OFF_MAIN, POLES_BEFORE, POLES_MAIN


def temperature_course(
    seconds: Array, start: Array, warming: float, time_constant: float, swing: float, orbit: float, phase: float
) -> Array:
    """Return the temperature of each axis, shape (n, 3) [degC]: it warms up, and waves once an orbit.

    Parameters
    ----------
    start : ndarray, shape (3,)
        Of each axis [degC].
    """
    risen = warming * -np.expm1(-seconds / time_constant)
    wave = swing * (np.sin(2.0 * np.pi * seconds / orbit + phase) - np.sin(phase))
    return np.asarray(start + (risen + wave)[:, None])


def polynomial(coefficients: Array, away: Array) -> Array:
    """Return the value of a polynomial for each axis, shape (n, 3); coefficients of rising powers, shape (q, 3)."""
    found = np.broadcast_to(coefficients[-1], away.shape)
    for one in coefficients[-2::-1]:
        found = found * away + one
    return np.asarray(found)


def hysteresis(temperature: Array, interval: float, size: float, slowest: float) -> Array:
    """Return what the bias has more while warming and less while cooling, shape (n, 3).

    Parameters
    ----------
    temperature : ndarray, shape (n, 3)
        [degC]
    interval : float
        From sample to sample [s].
    size : float
        In the unit of the bias.
    slowest : float
        Slope at which it is three quarters of that [degC/s].
    """
    slope = np.gradient(temperature, interval, axis=0)
    return np.asarray(size * np.tanh(slope / slowest))


def noise(density: float, corner: float, n: int, k: int, rate: float, rng: np.random.Generator) -> Array:
    """Return noise of k sensors, shape (n, k): white, and 1/f that is as large at the corner [Hz].

    Parameters
    ----------
    density : float
        Of the white part, one-sided [unit/sqrt(Hz)].
    rate : float
        Samples a second.
    """
    found = flicker(density**2 * corner, n, k, rng)
    white = rng.standard_normal((k, n)).T
    white *= density * np.sqrt(0.5 * rate)
    found += white
    return found


@lru_cache(16)
def _sections(poles: int, cut_off: float, rate: float) -> tuple[Array, Array]:
    sections = signal.butter(poles, cut_off, fs=rate, output="sos")
    return sections, signal.sosfilt_zi(sections)


def low_pass(x: Array, poles: int, cut_off: float, rate: float) -> Array:
    """Return channels after a Butterworth low-pass that has been at rest at the first sample, shape (n, k).

    Parameters
    ----------
    cut_off : float
        Where its gain is sqrt(1/2) [Hz].
    rate : float
        Samples a second.
    """
    sections, rest = _sections(poles, cut_off, rate)
    found, _ = signal.sosfilt(sections, x, axis=0, zi=rest[:, :, None] * x[0])
    return np.asarray(found)


def through_filters(x: Array, rate: float) -> Array:
    """Return channels after the one-pole filter of the preamplifier and the seven-pole filter, shape (n, k)."""
    before = low_pass(x, POLES_BEFORE, CUT_OFF_BEFORE * rate, rate)
    return low_pass(before, POLES_MAIN, CUT_OFF_MAIN * rate, rate)

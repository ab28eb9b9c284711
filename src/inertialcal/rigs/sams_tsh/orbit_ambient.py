"""Acceleration inside an orbiter, along axes fixed in it: quasi-steady part, vibration lines, crew and robot arm.

Only the quasi-steady part has a mean: whatever moves inside, or hangs at the arm, pushes back what it pushed.
"""

from __future__ import annotations

import numpy as np

from ...core.estimate import Array

RINGING = 8.0  # decay times after which a push is over
ARM_FADE = 10.0  # [s] in which the arm's motion grows and dies


def slow_variation(seconds: Array, mean: Array, swing: Array, period: float, phase: float) -> Array:
    """Return the quasi-steady acceleration, shape (n, 3): a mean, and a wave once an orbit."""
    return np.asarray(mean + np.multiply.outer(np.sin(2.0 * np.pi * seconds / period + phase), swing))


def line(seconds: Array, frequency: float, amplitude: Array, phase: float) -> Array:
    """Return one vibration line, shape (n, 3), with the amplitude of each axis, shape (3,)."""
    return np.multiply.outer(np.sin(2.0 * np.pi * frequency * seconds + phase), amplitude)


def add_push(total: Array, seconds: Array, start: float, amplitude: Array, frequency: float, decay: float) -> None:
    """Add a push by the crew to ``total``, (n, 3): the structure rings at a frequency and dies away, its mean zero.

    Parameters
    ----------
    seconds : ndarray, shape (n,)
        Ascending [s].
    start, frequency, decay : float
        When, at which frequency it rings [Hz], and in which time it dies by 1/e [s].
    amplitude : ndarray, shape (3,)
        Of each axis.
    """
    a, b = np.searchsorted(seconds, (start, start + RINGING * decay))
    since = seconds[a:b] - start
    angular = 2.0 * np.pi * frequency
    shape = np.exp(-since / decay) * np.sin(angular * since - np.arctan(angular * decay))  # its integral is 0
    total[a:b] += np.multiply.outer(shape, amplitude)


def add_arm(
    total: Array, seconds: Array, span: tuple[float, float], amplitude: Array, frequency: float, phase: float
) -> None:
    """Add the swinging of the robot arm to ``total``, (n, 3), between two times [s], at its low frequency [Hz]."""
    a, b = np.searchsorted(seconds, span)
    t = seconds[a:b]
    fade = np.clip(np.minimum(t - span[0], span[1] - t) / ARM_FADE, 0.0, 1.0)
    total[a:b] += np.multiply.outer(fade * np.sin(2.0 * np.pi * frequency * t + phase), amplitude)

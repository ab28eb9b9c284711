"""One record of a triaxial head that is turned in orbit, before its converter, and the truth behind it.

What the truth means: the bias is the mean over the record of all that a sensor reads without acceleration (its
polynomial at the temperatures of the record, hysteresis, drift and noise), the ambient acceleration that of the
quasi-steady acceleration along the axes of the head at position 0. Pushes, lines and the robot arm have mean 0 and
belong to neither.

Errors of the standards are drawn as ``procedures.flip`` takes them: one angle for all positions but 0, two small angles
of the axis, a zero and a scale factor for each sensor.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise

import numpy as np
from scipy import signal

from ...core.estimate import Array
from ...core.influence import Influence
from ...core.key import AXES
from ..parts.campaign import drawn_error
from ..parts.head_turn import course, felt, swung
from ..parts.noise import flicker
from .campaign import windows
from .setup import (
    CUT_OFF_BEFORE,
    CUT_OFF_MAIN,
    GAINS,
    POLES_BEFORE,
    POLES_MAIN,
    REFERENCE_TEMPERATURE,
    UG,
    Bench,
    Head,
    draw_head,
)

PUSH_UG = (50.0, 500.0)  # ends of what a push of the crew is drawn from
PUSH_HZ = (0.5, 3.0)
PUSH_DECAY = (0.5, 3.0)  # [s]
OFF = 10.0  # [s] that pushes stay off the windows, beyond their ringing
SLOWEST = 2e-6  # slope at which hysteresis is seen [degC/s]


@dataclass(frozen=True, eq=False)
class Errors:
    """True errors of the standards; zero where a standard is not given."""

    angle: float  # error of every position except 0 [rad]
    axis: Array  # error of the turn axis towards the other two, (2,) [rad]
    zero: Array  # zero error of the electronics of each axis, (3,) [m/s^2]
    scale: Array  # relative error of each scale factor, (3,)


@dataclass(frozen=True, eq=False)
class Record:
    """One record of the head before its converter, and the truth behind it."""

    seconds: Array  # time since the start, (n,) [s]
    readings: Array  # readings by the stated scale factors, (n, 3) [m/s^2]
    temperature: Array  # (n, 3) [degC]
    # true means over the record, (3,) [m/s^2]
    bias: Array
    ambient: Array
    errors: Errors  # errors of the standards


def record(bench: Bench, head: Head, rng: np.random.Generator) -> Record:
    """Return what the filters of a head let through during one record.

    Parameters
    ----------
    bench : Bench
        The flip as it is made; what is zero or absent there costs no time.
    head : Head
        That is turned.
    rng : numpy.random.Generator
        All draws come from it.
    """
    of_errors, of_world, of_noise = rng.spawn(3)
    errors = draw_errors(bench, of_errors)
    n = round(bench.duration * bench.rate)
    seconds: Array = (np.arange(n, dtype=np.float64) + 0.5) / bench.rate
    temperature = _temperature(bench, seconds, of_world)
    steady, shaken = _ambient(bench, seconds, of_world)
    read = _still_reading(bench, head, seconds, temperature, of_noise)
    bias = read.mean(axis=0)
    matrix = head.matrix[0] + head.matrix[1] * (float(temperature.mean()) - REFERENCE_TEMPERATURE)
    _add_acceleration(bench, head.arms, matrix, errors, seconds, shaken, read)
    at = [GAINS.index(gain) for gain in bench.gains]
    read *= polynomial(head.scale[at, :, range(3)].T, temperature - REFERENCE_TEMPERATURE) * (1.0 + errors.scale)
    if bench.filtered:
        read = through_filters(read, bench.rate)
    read += errors.zero
    return Record(seconds, read, temperature, bias, steady.mean(axis=0), errors)


def draw_errors(bench: Bench, rng: np.random.Generator) -> Errors:
    """Draw what the standards are off."""
    names = ("turn.angle", "turn.axis", "converter.zero", "sensor.scale_factor")
    sizes = zip(names, (1, 2, 3, 3), strict=True)
    found = {name: np.array([drawn_error(bench.standards.get(name), rng) for _ in range(k)]) for name, k in sizes}
    return Errors(float(found[names[0]][0]), *(found[name] for name in names[1:]))


def _temperature(bench: Bench, seconds: Array, rng: np.random.Generator) -> Array:
    start = REFERENCE_TEMPERATURE + rng.normal(0.0, 0.1, 3)
    phase = float(rng.uniform(0.0, 2.0 * np.pi))
    if bench.warming == 0.0 and bench.temperature_swing == 0.0:
        return start[np.newaxis]
    return temperature_course(
        seconds, start, bench.warming, bench.warming_time, bench.temperature_swing, bench.orbit, phase
    )


def _ambient(bench: Bench, seconds: Array, rng: np.random.Generator) -> tuple[Array, Array]:
    """Quasi-steady acceleration, and with all that shakes the orbiter, along the head at position 0, (n or 1, 3)."""
    mean, swing = (rng.normal(0.0, size * UG, 3) for size in (bench.ambient_ug, bench.swing_ug))
    phases = rng.uniform(0.0, 2.0 * np.pi, 1 + len(bench.lines))
    if bench.swing_ug == 0.0:
        steady = mean[np.newaxis]
    else:
        steady = slow_variation(seconds, mean, swing, bench.orbit, float(phases[0]))
    total = steady
    for (frequency, size), phase in zip(bench.lines, phases[1:], strict=True):
        direction = rng.normal(0.0, size * UG, 3)
        if frequency < 0.5 * bench.rate:
            total = total + line(seconds, frequency, direction, float(phase))
    if bench.pushes > 0.0 or bench.arm is not None:
        total = np.array(np.broadcast_to(total, (len(seconds), 3)))
        _disturb(bench, seconds, total, rng)
    return steady, total


def _disturb(bench: Bench, seconds: Array, total: Array, rng: np.random.Generator) -> None:
    """Add what the crew and the robot arm do."""
    stated = [*windows(bench), *((start, start + bench.turn_time, 0.0) for start in bench.turn_starts)]
    for _ in range(int(rng.poisson(bench.pushes * bench.duration / 3600.0))):
        start, decay = float(rng.uniform(0.0, bench.duration)), float(rng.uniform(*PUSH_DECAY))
        size = rng.normal(0.0, 1.0, 3) * rng.uniform(*PUSH_UG) * UG
        frequency = float(rng.uniform(*PUSH_HZ))
        if not any(a - RINGING * decay - OFF < start < b + OFF for a, b, _ in stated):
            add_push(total, seconds, start, size, frequency, decay)
    if bench.arm is not None:
        way = rng.normal(size=3)
        size = way / np.linalg.norm(way) * rng.uniform(*bench.arm_ug) * UG
        phase = float(rng.uniform(0.0, 2.0 * np.pi))
        add_arm(total, seconds, bench.arm, size, float(rng.uniform(*bench.arm_frequency)), phase)


def _still_reading(bench: Bench, head: Head, seconds: Array, temperature: Array, rng: np.random.Generator) -> Array:
    """Return what the sensors read without acceleration, shape (n, 3): their bias, and their noise."""
    interval = 1.0 / bench.rate
    still = noise(bench.density_ug * UG, bench.corner, len(seconds), 3, bench.rate, rng)
    still += polynomial(head.bias, temperature - REFERENCE_TEMPERATURE)
    if bench.hysteresis_ug > 0.0 and len(temperature) > 1:
        still += hysteresis(temperature, interval, bench.hysteresis_ug * UG, SLOWEST)
    if bench.drift_ug > 0.0:
        still += np.multiply.outer(seconds / 3600.0, rng.normal(0.0, bench.drift_ug * UG, 3))
    return still


def _add_acceleration(
    bench: Bench, arms: Array, matrix: Array, errors: Errors, seconds: Array, fixed: Array, read: Array
) -> None:
    """Add to ``read`` what the sensors read of the acceleration along a head that is turned, and of the turns."""
    own = AXES.index(bench.turn_axis)
    along = np.eye(3)[own]
    along[(own + 1) % 3], along[(own + 2) % 3] = errors.axis
    along /= np.linalg.norm(along)
    stated = np.radians(bench.positions_deg)
    angles = stated + np.radians(bench.stopped_deg) + np.where(stated != 0.0, errors.angle, 0.0)
    starts, length = np.array(bench.turn_starts), bench.turn_time
    edges = np.searchsorted(seconds, [0.0, *np.ravel(np.column_stack([starts, starts + length])), np.inf])
    for i, (a, b) in enumerate(pairwise(edges.tolist())):
        motion = course(seconds[a : b if i % 2 else a + 1], starts, angles, length)  # between turns it rests
        x = felt(fixed if len(fixed) == 1 else fixed[a:b], motion.angle, along)
        if i % 2:
            x += np.column_stack([swung(motion, along, arms[j])[:, j] for j in range(3)])
        read[a:b] += x @ matrix.T


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


def reduced(
    seed: int,
    corner: float,
    *,
    turn_starts: tuple[float, ...] = (1200.0, 2400.0),
    positions_deg: tuple[float, ...] = (180.0, 0.0),
    arm: tuple[float, float] | None = None,
    standards: Mapping[str, Influence] | None = None,
) -> Record:
    """Return one record of an hour at 25 samples/s.

    Parameters
    ----------
    seed : int
        Of all draws.
    corner : float
        Frequency below which 1/f noise is larger than white noise [Hz]; 0 for white noise alone.
    turn_starts, positions_deg : tuple of float
        When each turn begins [s], and the angle that it ends at [deg].
    arm : (float, float), optional
        When the robot arm moves [s].
    standards : mapping of Influence, optional
        An error of each is drawn; none by default.
    """
    bench = reduced_bench(corner, turn_starts, positions_deg, arm, standards)
    of_head, of_record = np.random.default_rng(seed).spawn(2)
    return record(bench, aligned(draw_head(bench, of_head)), of_record)


def aligned(head: Head) -> Head:
    """Return a head without misalignment, with the ideal scale factors at every temperature."""
    scale = np.zeros_like(head.scale)
    scale[:, 0] = 1.0
    return replace(head, matrix=np.stack([np.eye(3), np.zeros((3, 3))]), scale=scale)


def reduced_bench(
    corner: float,
    turn_starts: tuple[float, ...],
    positions_deg: tuple[float, ...],
    arm: tuple[float, float] | None = None,
    standards: Mapping[str, Influence] | None = None,
) -> Bench:
    """Return the bench of `reduced`."""
    return Bench(
        corner=corner, turn_starts=turn_starts, positions_deg=positions_deg, stopped_deg=(0.0,) * len(turn_starts),
        arm=arm, standards=standards or {}, swing_ug=0.0, lines=(), pushes=0.0, warming=0.0, temperature_swing=0.0,
        hysteresis_ug=0.0, drift_ug=0.0, filtered=False,
    )  # fmt: skip

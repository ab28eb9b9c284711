"""Simulated readings of a flip.

The noise is drawn as samples of one second, white and 1/f. Its mean over the quiet record counts as bias, as in
``uncertainty``, and is removed: ``Truth.bias`` is the mean bias over that record.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from ...core.estimate import Array
from ...core.key import AXES
from ...core.recording import SECOND
from .dwells.quiet import Window, quiet_of, stretches
from .plan import Plan
from .readings import Readings
from .separation.equations import rotation, slope, tilted

STEP = 1.0  # [s]
LONGER = 4  # than the record is drawn, so that its ends do not meet


@dataclass(frozen=True, eq=False)
class Truth:
    """Head, test and noise.

    Parameters
    ----------
    bias, ambient : ndarray, shape (3,)
        Of the axes, and along them at position 0 [m/s^2].
    white : float
        One-sided density of the white noise [(m/s^2)^2/Hz].
    corner : float
        Frequency at which 1/f noise is as large [Hz].
    angles : tuple of float
        Positions, one after the other [rad].
    dwell, turn, record : float
        Length of a window, of the turn between two, of the whole record [s].
    """

    bias: Array = field(default_factory=lambda: np.zeros(3))
    ambient: Array = field(default_factory=lambda: np.zeros(3))
    white: float = 1e-12
    corner: float = 0.0
    angles: tuple[float, ...] = (0.0, math.pi)
    dwell: float = 300.0
    turn: float = 40.0
    record: float = 3600.0


def simulate(plan: Plan, truth: Truth, rng: np.random.Generator) -> Readings:
    """Return the readings of one flip in the middle of a record; errors of the plan's standards are drawn."""
    count = round(truth.record / STEP)
    time_ns = np.asarray((np.arange(count) + 0.5) * STEP * SECOND, dtype=np.int64)
    step = truth.dwell + truth.turn
    start = 0.5 * (truth.record - len(truth.angles) * step + truth.turn)  # windows around the middle of the record
    starts = [round((start + i * step) * SECOND) for i in range(len(truth.angles))]
    dwell = round(truth.dwell * SECOND)
    given = [Window(start, start + dwell, angle) for start, angle in zip(starts, truth.angles, strict=True)]
    parts = stretches(given, 0, round(truth.record * SECOND))
    channels = {axis: coloured(count, STEP, truth.white, truth.corner, rng) for axis in AXES}
    rows = np.arange(len(given))
    quiet, _ = quiet_of(time_ns, channels, parts, rows, len(given), plan.block)
    levels = _levels(plan, truth, np.array(truth.angles), rng)
    means, outputs = {}, {}
    position = np.array([truth.angles.index(angle) for angle in quiet.angle])
    for at, axis in enumerate(AXES):
        noise = quiet.means[axis] - quiet.means[axis].mean()
        means[axis] = noise + levels[position, at]
        outputs[axis] = quiet.weights @ noise + levels[:, at]
    middle = quiet.spans.mean(axis=1)
    record = replace(quiet, means=means, name="simulated")
    return Readings(np.array(truth.angles), np.full(len(given), "1"), outputs, time=middle, quiet=(record,))


def coloured(count: int, step: float, white: float, corner: float, rng: np.random.Generator) -> Array:
    """Return samples of white and 1/f noise, shape (count,).

    Parameters
    ----------
    count : int
        How many.
    step : float
        From sample to sample [s].
    white : float
        One-sided density of the white part [unit^2/Hz].
    corner : float
        Frequency at which the 1/f part is as large [Hz]; 0 for none.
    rng : numpy.random.Generator
        All draws come from it.
    """
    samples = rng.normal(0.0, math.sqrt(white / (2.0 * step)), count)
    if corner == 0.0:
        return samples
    long = LONGER * count
    f = np.fft.rfftfreq(long, step)
    density = np.zeros(len(f))
    density[1:] = white * corner / f[1:]
    parts = rng.normal(size=(len(f), 2)) @ np.array([1.0, 1.0j])
    slow = np.fft.irfft(parts * np.sqrt(density * long / (4.0 * step)), long)
    first = int(rng.integers(long - count))
    return np.asarray(samples + slow[first : first + count])


def _levels(plan: Plan, truth: Truth, angles: Array, rng: np.random.Generator) -> Array:
    """Return what the axes read at each position without noise, shape (n, 3)."""
    change = slope(plan.axis, angles) * (draw(plan, "turn.angle", rng) * (angles != 0.0))[:, None, None]
    for axis in plan.turned:
        small = draw(plan, "turn.axis", rng) * np.eye(3)[AXES.index(axis)]
        change = change + tilted(plan.axis, angles, small)
    zero = np.array([draw(plan, "converter.zero", rng) for _ in AXES])
    scale = np.array([draw(plan, "sensor.scale_factor", rng) for _ in AXES])
    level = truth.bias + (rotation(plan.axis, angles) + change) @ truth.ambient
    return np.asarray(level + zero + scale * (level + plan.raw_bias))


def draw(plan: Plan, name: str, rng: np.random.Generator) -> float:
    """Return the error of a standard, drawn; 0 where none is stated."""
    influence = plan.standards.get(name)
    if influence is None:
        return 0.0
    if influence.distribution == "rectangular":
        half = influence.u * math.sqrt(3.0)
        return float(rng.uniform(-half, half))
    return float(rng.normal(0.0, influence.u))

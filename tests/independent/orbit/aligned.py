"""A unit at rest on the turning earth, made without any code of the package.

The place is a point of a sphere of plumb lines: up, east and north follow from latitude in axes of the earth, whose z
turns. The unit stands on a turntable whose axis is nearly the vertical; between two positions it turns by a smooth
half cosine, and its rates are differences of its attitude. Readings are specific force and rate through matrices of
errors, with biases, white noise, and noise with a memory.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]
EARTH = 7.292115e-5  # [rad/s]
HOUR = np.pi / 180.0 / 3600.0  # deg/h [rad/s]
G = 9.80665


@dataclass
class Bench:
    """The unit as it truly is, and what is done with it."""

    latitude: float = 36.6  # [deg]
    gravity: float = 9.799
    heading: float = 40.0  # of the first position [deg]
    pitch: float = 0.8  # [deg]
    roll: float = -0.5  # [deg]
    turns: tuple[float, ...] = (180.0,)  # true, from each position to the next [deg]
    seconds: float = 600.0  # of each position
    moving: float = 20.0  # of each turn [s]
    step: float = 0.1
    z_up: bool = False
    gyro_bias: tuple[float, float, float] = (0.0, 0.0, 0.0)  # [deg/h]
    acc_bias: tuple[float, float, float] = (0.0, 0.0, 0.0)  # [mg]
    gyro_noise: float = 0.3  # white [deg/h/sqrt(Hz)]
    acc_noise: float = 0.02  # [mg/sqrt(Hz)]
    slow: float = 0.0  # standard deviation of gyro noise with a memory [deg/h]
    memory: float = 30.0  # [s]
    redrawn: float = 0.0  # standard deviation of the bias from position to position [deg/h]
    drift: tuple[float, float, float] = (0.0, 0.0, 0.0)  # of the gyros over all the time [deg/h]
    gyro_matrix: Array = field(default_factory=lambda: np.eye(3))
    acc_matrix: Array = field(default_factory=lambda: np.eye(3))
    step_at: float = 0.0  # of tilt in the middle of the last position [deg]
    tilting: float = 0.0  # of the base over the last position [deg]
    sway: float = 0.0  # amplitude of a base that rocks at 0.4 Hz in the last third of the last position [deg]


@dataclass
class Made:
    """A record, with the truth."""

    bench: Bench
    times: Array  # [s]
    acc: Array  # shape (n, 3) [m/s^2]
    gyro: Array  # shape (n, 3) [rad/s]
    spans: list[tuple[int, int]]  # samples of each position, those beside a turn left out
    headings: list[float]  # [deg]
    attitudes: list[Array]  # takes body to north, east, down

    def write(self, path: Path, first: int = 0, stop: int | None = None) -> Path:
        """Write samples as a text file."""
        names = "time [s]," + ",".join(f"acc_{a} [m/s2]" for a in "xyz") + "," + ",".join(
            f"gyro_{a} [deg/s]" for a in "xyz")  # fmt: skip
        part = slice(first, stop)
        table = np.column_stack([self.times[part], self.acc[part], np.degrees(self.gyro[part])])
        np.savetxt(path, table, "%.10g", ",", header=names, comments="", encoding="utf-8")
        return path


def earth_in_level(latitude: float) -> Array:
    """Return the rate of the earth along north, east and down, by the axes of a place [rad/s]."""
    lat = np.radians(latitude)
    axis = np.array([0.0, 0.0, EARTH])
    up = np.array([np.cos(lat), 0.0, np.sin(lat)])
    east = np.array([0.0, 1.0, 0.0])
    north = np.cross(up, east)
    return np.array([axis @ north, axis @ east, -(axis @ up)])


def made(bench: Bench, rng: np.random.Generator) -> Made:
    """Return what both triads read."""
    step, count = bench.step, round(bench.seconds / bench.step)
    turning = round(bench.moving / step)
    angle, spans, at = [np.zeros(count)], [(0, count)], count
    total = 0.0
    for turn in bench.turns:
        phase = (np.arange(turning) + 0.5) / turning
        angle += [total + turn * 0.5 * (1.0 - np.cos(np.pi * phase)), np.full(count, total + turn)]
        total += turn
        spans.append((at + turning, at + turning + count))
        at += turning + count
    turned = np.radians(np.concatenate(angle))
    n = len(turned)
    times: Array = np.asarray(np.arange(n) * step, dtype=np.float64)
    start = Rotation.from_euler("ZYX", np.radians([bench.heading, bench.pitch, bench.roll]))
    tilt = np.zeros(n)
    first, last = spans[-1]
    middle = (first + last) // 2
    tilt[middle:] += np.radians(bench.step_at)
    tilt[first:last] += np.radians(bench.tilting) * (np.arange(last - first) / (last - first))
    rock = slice(last - (last - first) // 3, last)
    tilt[rock] += np.radians(bench.sway) * np.sin(2.0 * np.pi * 0.4 * times[rock])
    zero = np.zeros(n)
    attitude = (Rotation.from_rotvec(np.column_stack([tilt, zero, zero]))
                * Rotation.from_rotvec(np.column_stack([zero, zero, turned])) * start)  # fmt: skip
    if bench.z_up:
        attitude = attitude * Rotation.from_rotvec([np.pi, 0.0, 0.0])
    rates = np.zeros((n, 3))
    between = (attitude[:-1].inv() * attitude[1:]).as_rotvec() / step
    rates[:-1] += 0.5 * between
    rates[1:] += 0.5 * between
    rates[middle - 1 : middle + 1] = 0.0 if bench.step_at else rates[middle - 1 : middle + 1]
    gyro = rates + attitude.inv().apply(earth_in_level(bench.latitude))
    acc = attitude.inv().apply([0.0, 0.0, -bench.gravity])
    gyro = gyro @ bench.gyro_matrix.T + np.array(bench.gyro_bias) * HOUR
    acc = acc @ bench.acc_matrix.T + np.array(bench.acc_bias) * 1e-3 * G
    for a, b in spans:
        gyro[a:b] += rng.normal(0.0, bench.redrawn, 3) * HOUR
    gyro += np.outer(np.linspace(-0.5, 0.5, n), np.array(bench.drift)) * HOUR
    root = np.sqrt(0.5 / step)
    gyro += rng.normal(0.0, bench.gyro_noise * HOUR * root, (n, 3))
    acc += rng.normal(0.0, bench.acc_noise * 1e-3 * G * root, (n, 3))
    if bench.slow:
        keep = np.exp(-step / bench.memory)
        drive = rng.normal(0.0, bench.slow * np.sqrt(1.0 - keep**2), (n, 3))
        drive[0] = rng.normal(0.0, bench.slow, 3)
        gyro += lfilter([1.0], [1.0, -keep], drive, axis=0) * HOUR
    headings = [float(np.degrees(turned[a]) + bench.heading) % 360.0 for a, _ in spans]
    spans = [(a + 2 * (a > 0), b - 2 * (b < n)) for a, b in spans]
    return Made(bench, times, acc, gyro, spans, headings, [attitude[a].as_matrix() for a, _ in spans])

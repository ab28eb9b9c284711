"""A triaxial head turned by half turns about x: dwells in ambient acceleration, turns, slow noise.

In a dwell at the angle ``theta`` about x (Chestney and Sicker 1996, equations 1 to 7)::

    y = B + C(theta) G(t) + noise        C about x: y reads cos G_y + sin G_z, z reads -sin G_y + cos G_z

A turn takes some time by the smooth angle ``pi (s - sin(2 pi s) / 2 pi)``; at a lever arm it is felt as ``r theta'^2``
towards the axis and ``r theta''`` across it. ``G(t)`` may change with time, and the bias may wander (flicker).

The truth of ``bias`` is its mean over the time at rest, that of ``bias_next_record`` its mean over as long again from
the end of this record; ``of the head`` is the constant behind both.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from .case import Array, Case, Table
from .static import flicker

AXES = "xyz"
UG_OF_SI = 1e6 / 9.80665


@dataclass(frozen=True)
class Head:
    """Truth of head and cabin, in ug."""

    bias: tuple[float, float, float] = (-120.0, 80.0, 250.0)
    ambient: tuple[float, float, float] = (1.0, 3.0, -2.0)
    ambient_rate: tuple[float, float, float] = (0.0, 0.0, 0.0)  # [ug/h]
    bias_rate: tuple[float, float, float] = (0.0, 0.0, 0.0)  # [ug/h]
    white: float = 20.0  # of a sample
    slow: float = 0.0  # flicker B of the bias
    walk: float = 0.0  # of the bias, in a second
    correlated: tuple[float, float] = (0.0, 1.0)  # of the bias: standard deviation, correlation time [s]
    angle_error: float = 0.0  # standard deviation of each turn [deg]
    lever: float = 0.1  # [m]
    shake: float = 3.0  # noise during a turn, in parts of the white noise


@dataclass(frozen=True)
class Programme:
    """Dwells and turns."""

    dwells: int = 6
    dwell: tuple[float, float] = (540.0, 600.0)  # shortest and longest [s]
    turn: float = 60.0
    rate: float = 25.0
    before: float = 0.0  # quiet record before the first and after the last dwell [s]
    given: bool = True  # windows are stated
    step: tuple[int, float] = (0, 0.0)  # the bias of y and z steps by so much in the middle of this dwell


def turned(seed: int, head: Head | None = None, programme: Programme | None = None) -> Case:
    """Return one record of a head that is turned to and fro."""
    head, programme = head or Head(), programme or Programme()
    rng = np.random.default_rng([7, seed])
    dt = 1.0 / programme.rate
    pieces, windows, at = [], [], 0.0
    angle, levels = 0.0, []
    for k in range(programme.dwells):
        length = rng.uniform(*programme.dwell)
        extra = programme.before if k in (0, programme.dwells - 1) else 0.0
        n = round((length + extra) / dt)
        first = at + (extra if k == 0 else 0.0)
        windows.append((first, first + length, 180 * (k % 2)))
        levels.append(round(at / dt))
        pieces.append(np.full(n, angle))
        at += n * dt
        if k < programme.dwells - 1:
            goal = np.pi * ((k + 1) % 2) + np.radians(head.angle_error) * rng.standard_normal() * ((k + 1) % 2)
            m = round(programme.turn / dt)
            s = (np.arange(m) + 0.5) / m
            pieces.append(angle + (goal - angle) * (s - np.sin(2.0 * np.pi * s) / (2.0 * np.pi)))
            angle, at = goal, at + m * dt
    theta = np.concatenate(pieces)
    time: Array = dt * np.arange(len(theta), dtype=float)
    wander = slow(rng, head, 2 * len(time), dt)  # this record and the next
    y = readings(rng, head, theta, time, dt, wander[: len(time)])
    which, size = programme.step
    if size:
        middle = round(0.5 * (windows[which][0] + windows[which][1]) / dt)
        y[middle:, 1:] += size
    columns = {"time [s]": time} | {f"acc_{a} [ug]": y[:, i] for i, a in enumerate(AXES)}
    signals = tuple(f"acc_{a} [ug]" for a in AXES)
    table = Table(columns, signals, "time [s]", form={"time [s]": "%.3f"} | dict.fromkeys(signals, "%.3f"))
    words = ["flip", "@head.csv"]
    if programme.given:
        for start, stop, position in windows:
            words += ["--window", f"{start:.2f}..{stop:.2f}={position} deg"]
    hours = float(np.mean([w[0] + w[1] for w in windows])) / 7200.0
    truth: dict[str, float] = {f"turns {k}": start for k, start in enumerate(levels[1:], 1)}
    still = np.abs(np.gradient(theta)) == 0.0
    later = float(time.mean()) + float(time[-1])
    for i, a in enumerate("yz", 1):
        truth[f"ambient_acceleration {a}"] = head.ambient[i] + head.ambient_rate[i] * hours
        now = head.bias_rate[i] * float(time[still].mean()) / 3600.0 + float(wander[: len(time), i][still].mean())
        truth[f"bias {a}"] = head.bias[i] + now  # of the quiet record
        onward = head.bias_rate[i] * later / 3600.0 + float(wander[len(time) :, i].mean())
        truth[f"bias_next_record {a}"] = head.bias[i] + onward
        truth[f"bias_next_record of the head {a}"] = head.bias[i]
    ideal = {}
    if not np.any(wander):
        counts = {p: [(b - a) / dt for a, b, q in windows if q == p] for p in (0, 180)}
        u = 0.5 * head.white * float(np.sqrt(sum(np.sum(1.0 / np.array(n)) / len(n) ** 2 for n in counts.values())))
        ideal = {f"{name} {a}": u for name in ("bias", "ambient_acceleration") for a in "yz"}
    return Case("flip", {"head.csv": table}, words, truth, noise=head.white, rate=programme.rate, rng_seed=seed,
                ideal=ideal)  # fmt: skip


def slow(rng: np.random.Generator, head: Head, count: int, dt: float) -> Array:
    """Return how the bias wanders (count, 3)."""
    found = np.zeros((count, len(AXES)))
    for i in range(len(AXES)):
        if head.slow:
            found[:, i] += flicker(rng, head.slow, count)
        if head.walk:
            found[:, i] += head.walk * np.sqrt(dt) * np.cumsum(rng.standard_normal(count))
        if head.correlated[0]:
            kept = np.exp(-dt / head.correlated[1])
            steps = np.sqrt(1.0 - kept**2) * rng.standard_normal(count)
            steps[0] = rng.standard_normal()
            found[:, i] += head.correlated[0] * lfilter([1.0], [1.0, -kept], steps)
    return found


def readings(rng: np.random.Generator, head: Head, theta: Array, time: Array, dt: float, wander: Array) -> Array:
    """Return what the head reads (n, 3)."""
    hours = time[:, None] / 3600.0
    G = np.array(head.ambient) + np.array(head.ambient_rate) * hours
    speed = np.gradient(theta, dt)
    c, s = np.cos(theta), np.sin(theta)
    y = np.column_stack([G[:, 0], c * G[:, 1] + s * G[:, 2], -s * G[:, 1] + c * G[:, 2]])
    y[:, 1] -= UG_OF_SI * head.lever * speed**2
    y[:, 2] += UG_OF_SI * head.lever * np.gradient(speed, dt)
    y += np.array(head.bias) + np.array(head.bias_rate) * hours
    y += wander
    sd = np.where(np.abs(speed) > 0.0, 1.0 + head.shake, 1.0)[:, None] * head.white
    values: Array = y + sd * rng.standard_normal(y.shape)
    return values


def half_sums(case: Case, windows: list[tuple[float, float, int]]) -> tuple[Array, Array]:
    """Return bias and ambient acceleration of y and z: half sums, half differences of means at both positions."""
    table = case.tables["head.csv"]
    t = table.columns["time [s]"]
    y = np.column_stack([table.columns[name] for name in table.signals])
    means = {p: np.mean([y[(t >= a) & (t < b)].mean(0) for a, b, q in windows if q == p], axis=0) for p in (0, 180)}
    return 0.5 * (means[0] + means[180])[1:], 0.5 * (means[0] - means[180])[1:]

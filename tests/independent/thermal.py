"""A unit at rest in a chamber: ramps down and up, one recording a power-up.

What is read, with the chamber's temperature ``T`` at the thermometer and the sensing element behind it by ``lag``::

    element:  dE/dt = (T - E) / lag
    y = P(E) + h(t) / 2 + offset of the power-up + A exp(-t / tau) + walk + noise

``P`` is a polynomial about 20 degC. ``h`` is hysteresis of the play type (Preisach, one relay, smoothed): it goes from
-h to h within ``turn`` degC of a turn of the temperature, whatever the speed. A constant ramp r leaves ``-lag P'(T) r``
behind, so that warming less cooling is ``h - 2 lag P'(T) |r|``.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import lfilter

from .case import START, Array, Case, Table

REFERENCE = 20.0  # [degC]
EARTH = np.degrees(7.292115e-5)  # [deg/s]


@dataclass(frozen=True)
class Unit:
    """Truth of one gyro in deg/s, degC, s; every axis is alike but for its bias."""

    polynomial: tuple[float, ...] = (0.02, 2e-4, 3e-6)  # of (T - 20 degC)^0, ^1, ...
    hysteresis: float = 0.0  # warming less cooling
    turn: float = 2.0  # within which the path changes [degC]
    lag: float = 0.0
    turn_on: float = 0.003  # standard deviation from power-up to power-up
    slope_scatter: float = 0.0  # of the linear coefficient from power-up to power-up [deg/s/degC]
    walk: float = 0.0  # [deg/s / sqrt(s)]
    warm_up: float = 0.0  # A
    warm_up_scatter: float = 0.0  # of A, as a part
    tau: float = 300.0
    sample: float = 0.002
    wave: tuple[float, float] = (0.0, 600.0)  # thermostat: amplitude of the temperature [degC], period [s]
    thermometer: float = 0.0  # standard deviation of its error, the same in all runs [degC]
    attitude: bool = True  # z stands on end at the pole, as stated; else nobody knows how the unit lies


@dataclass(frozen=True)
class Chamber:
    """What the chamber does, in each power-up."""

    runs: int = 5
    interval: float = 10.0
    hold: float = 1800.0  # before the first ramp
    points: tuple[float, ...] = (20.0, -20.0, 60.0, -20.0, 60.0, 20.0)  # turned at
    speeds: tuple[float, ...] = (0.02, 0.02, 0.02, 0.01, 0.01)  # of the ramps between them [degC/s]
    scatter: float = 0.01  # of the thermometer [degC]
    # Points of each power-up, in turn, where they are not alike; ramped at the first speeds
    in_turn: tuple[tuple[float, ...], ...] = ()

    def of_run(self, run: int) -> Chamber:
        """Return what is done in one power-up."""
        points = self.in_turn[(run - 1) % len(self.in_turn)] if self.in_turn else self.points
        return replace(self, points=points, speeds=self.speeds[: len(points) - 1])


def path(chamber: Chamber) -> tuple[Array, Array]:
    """Return times and temperatures of one power-up."""
    times, levels = [0.0, chamber.hold], [chamber.points[0], chamber.points[0]]
    for level, speed in zip(chamber.points[1:], chamber.speeds, strict=True):
        times.append(times[-1] + abs(level - levels[-1]) / speed)
        levels.append(level)
    time = np.arange(0.0, times[-1], chamber.interval)
    return time, np.interp(time, times, levels)


def play(temperature: Array, turn: float) -> Array:
    """Return -1 (cooling) to 1 (warming): it follows the temperature within a band of ``turn`` degC."""
    values = np.empty_like(temperature)
    level = temperature[0]
    for i, t in enumerate(temperature.tolist()):
        level = min(max(level, t - turn / 2.0), t + turn / 2.0)
        values[i] = 2.0 * (t - level) / turn
    return values


def ramped(
    seed: int, unit: Unit | None = None, chamber: Chamber | None = None, axes: str = "x", again: int = 0
) -> Case:
    """Return recordings of a gyro in a chamber, a file a power-up.

    ``again``: the test is made once more, with the same thermometer.
    """
    unit, chamber = unit or Unit(), chamber or Chamber()
    rng = np.random.default_rng([3, seed])
    tables: dict[str, Table] = {}
    signals = tuple(f"gyro_{axis} [deg/s]" for axis in axes)
    wrong = unit.thermometer * rng.standard_normal()
    rng = np.random.default_rng([3, seed, 1, again]) if again else rng
    earth = 0.0 if unit.attitude else EARTH * rng.uniform(-1.0, 1.0)  # along x: a direction drawn at random
    for run in range(1, chamber.runs + 1):
        time, true_temperature = path(chamber.of_run(run))
        size, period = unit.wave
        t = true_temperature + size * np.sin(2.0 * np.pi * time / period + rng.uniform(0.0, 2.0 * np.pi))
        element = lagged(t, unit.lag, chamber.interval)
        columns = {"unix_s": START + 1e5 * run + time}
        columns["temperature [degC]"] = t + wrong + chamber.scatter * rng.standard_normal(len(t))
        for name in signals:
            coefficients = np.array(unit.polynomial)
            coefficients[1] += unit.slope_scatter * rng.standard_normal()
            y = np.polynomial.polynomial.polyval(element - REFERENCE, coefficients)
            y = y + 0.5 * unit.hysteresis * play(t, unit.turn) + unit.turn_on * rng.standard_normal()
            y += unit.warm_up * (1.0 + unit.warm_up_scatter * rng.standard_normal()) * np.exp(-time / unit.tau)
            y += unit.walk * np.sqrt(chamber.interval) * np.cumsum(rng.standard_normal(len(t)))
            columns[name] = y + earth + unit.sample * rng.standard_normal(len(t))
        form = {"unix_s": "%.1f", "temperature [degC]": "%.3f"} | dict.fromkeys(signals, "%.7f")
        tables[f"run{run}.csv"] = Table(columns, signals, "unix_s", temperature="temperature [degC]", form=form)
    words = ["thermal", *(f"@{name}" for name in tables), "--at", "0 degC", "--at", "40 degC"]
    if unit.attitude:
        words += ["--latitude", "90 deg", "--attitude", '{ tilt = "0 deg" }']  # x and y read nothing of the earth
    if unit.thermometer:
        words += ["--standard", f"thermometer.temperature={unit.thermometer} degC"]
    truth = {}
    for axis in axes:
        for condition, at in (("", REFERENCE), (" 0 degC", 0.0), (" 40 degC", 40.0)):
            truth[f"bias {axis}{condition}"] = float(
                np.polynomial.polynomial.polyval(at - REFERENCE, np.array(unit.polynomial))
            )
        truth |= {f"bias_temperature_{k} {axis}": value for k, value in enumerate(unit.polynomial) if k}
        truth |= {f"hysteresis {axis}": unit.hysteresis, f"thermal_lag {axis}": unit.lag}
        if not unit.lag:
            truth[f"path_difference {axis}"] = unit.hysteresis
    case = Case("thermal", tables, words, truth, noise=unit.sample, rate=1.0 / chamber.interval, rng_seed=seed)
    return case


def lagged(temperature: Array, lag: float, interval: float) -> Array:
    """Return the temperature of an element that is behind by ``lag``: exact for ramps between samples."""
    if not lag:
        return temperature
    a = np.exp(-interval / lag)
    b = 1.0 - lag / interval * (1.0 - a)  # weight of the newer end of a ramp
    start = temperature[0]
    values: Array = start + lfilter([b, 1.0 - a - b], [1.0, -a], temperature - start)
    return values

"""Gyros in a chamber where supply, temperature, pressure and time since power-up change; one recording a power-up.

What is read, with ``d`` the supply less 5 V and ``e`` the temperature less 20 degC::

    y = offset of the power-up + P(e) + s d + c d e + q d^2 + v(p) (p0 + p1 e)
        + sum_j (w_j + a_j (T_start - 20 degC)) exp(-t / tau_j) + (1 + m0 + m1 e + m_V d) x + walk + noise

``v`` goes from 0 in air to 1 in vacuum, with half of it at `Unit.knee` (slip flow: a logistic curve of the logarithm).
``s`` differs from power-up to power-up by ``scatter``. Input axes are level and the laboratory lies at the pole: the
earth is read by nobody, or on the table by whole.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from .case import START, Array, Case, Table

VOLTS, DEGREES, AIR = 5.0, 20.0, 101_325.0  # where deviations are zero [V], [degC]; [Pa]
EARTH = np.degrees(7.292115e-5)  # [deg/s]


@dataclass(frozen=True)
class Unit:
    """Truth of the gyros, in deg/s, V, degC, Pa, s; every axis is alike but for what is drawn."""

    polynomial: tuple[float, ...] = (0.02, 2e-4, 3e-6)  # of e^0, ^1, ...
    supply: float = 0.02  # s
    supply_temperature: float = 2e-4  # c
    bend: float = 0.0  # q
    scatter: float = 0.0  # of s from power-up to power-up, as a part
    turn_on: float = 0.006  # standard deviation from power-up to power-up
    slope_scatter: float = 0.0  # of the linear coefficient in temperature from power-up to power-up
    vacuum: tuple[float, float] = (0.0, 0.0)  # p0, p1
    knee: float = 30.0
    pump: float = 1.0  # noise while the pump runs, over that in air
    warm_up: tuple[tuple[float, float, float], ...] = ()  # w_j, a_j, tau_j
    warm_up_scatter: float = 0.0  # of all w_j of a power-up, as a part
    self_heating: float = 0.0  # rise of the thermometer after power-up [degC]
    scale: tuple[float, float, float] = (4e-3, 1e-4, 2e-3)  # m0, m1, m_V
    scale_scatter: float = 0.0  # of m0 from power-up to power-up
    walk: float = 0.0  # [deg/s / sqrt(s)]
    sample: float = 0.002
    thermometer: float = 0.005  # scatter of the thermometer [degC]
    meter: float = 2e-4  # scatter of the voltmeter [V]


@dataclass(frozen=True)
class Visits:
    """What one power-up goes through: at each temperature each supply, each for ``dwell``."""

    runs: int = 5
    temperatures: tuple[float, ...] = (-10.0, 20.0, 50.0)
    volts: tuple[float, ...] = (5.0, 4.85, 5.15, 5.0)
    dwell: float = 300.0
    ramp: float = 0.05  # [degC/s]
    interval: float = 5.0
    coupled: bool = False  # whether the supply follows the temperature and nothing else
    rates: tuple[float, ...] = (0.0,)  # of the table, in each dwell [deg/s]
    axes: str = "xy"


@dataclass
class Course:
    """Conditions of one power-up over time, (n,) each."""

    time: Array
    temperature: Array
    volts: Array
    pressure: Array
    rate: Array


def course(visits: Visits, backward: bool) -> Course:
    """Return what one power-up goes through; every second one goes backward."""
    order = tuple(reversed(visits.temperatures)) if backward else visits.temperatures
    at = 0.0
    times: list[Array] = []
    levels: list[Array] = []
    volts: list[Array] = []
    rates: list[Array] = []
    before = order[0]
    step = visits.interval
    for level in order:
        rising = np.arange(0.0, abs(level - before) / visits.ramp, step)
        if len(rising):
            times.append(np.asarray(at + rising))
            levels.append(before + np.sign(level - before) * visits.ramp * rising)
            volts.append(VOLTS + (0.005 * (levels[-1] - DEGREES) if visits.coupled else 0.0 * rising))
            rates.append(np.zeros(len(rising)))
            at += step * len(rising)
        for supply, rate in product(visits.volts, visits.rates):
            n = round(visits.dwell / step)
            times.append(np.asarray(at + step * np.arange(n)))
            levels.append(np.full(n, level))
            volts.append(np.full(n, VOLTS + 0.005 * (level - DEGREES) if visits.coupled else supply))
            rates.append(np.full(n, rate))
            at += step * n
        before = level
    time, temperature, volt, turned = (np.concatenate(some) for some in (times, levels, volts, rates))
    return Course(time, temperature, volt, np.full(len(time), AIR), turned)


def part_in_vacuum(pressure: Array, knee: float) -> Array:
    """Return how much of the change from air to vacuum there is."""
    full: Array = 1.0 / (1.0 + (pressure / knee) ** 1.5)
    at_air = 1.0 / (1.0 + (AIR / knee) ** 1.5)
    return np.asarray((full - at_air) / (1.0 - at_air))


def read(unit: Unit, one: Course, axes: str, rng: np.random.Generator) -> dict[str, Array]:
    """Return the columns of one power-up, as a logger writes them."""
    rise = unit.self_heating * (1.0 - np.exp(-one.time / 900.0))
    true = one.temperature + rise
    e, d = true - DEGREES, one.volts - VOLTS
    n = len(e)
    columns = {
        "unix_s": START + one.time,
        "temperature [degC]": true + unit.thermometer * rng.standard_normal(n),
        "supply [V]": one.volts + unit.meter * rng.standard_normal(n),
    }
    inside = part_in_vacuum(one.pressure, unit.knee)
    for axis in axes:
        coefficients = np.array(unit.polynomial)
        coefficients[1] += unit.slope_scatter * rng.standard_normal()
        y = np.polynomial.polynomial.polyval(e, coefficients) + unit.turn_on * rng.standard_normal()
        y += unit.supply * (1.0 + unit.scatter * rng.standard_normal()) * d
        y += unit.supply_temperature * d * e + unit.bend * d**2
        y += inside * (unit.vacuum[0] + unit.vacuum[1] * e)
        common = 1.0 + unit.warm_up_scatter * rng.standard_normal()
        for w, a, tau in unit.warm_up:
            y += common * (w + a * (one.temperature[0] - DEGREES)) * np.exp(-one.time / tau)
        m0, m1, m_v = unit.scale
        x = one.rate + (EARTH if one.rate.any() else 0.0)
        y += (1.0 + m0 + unit.scale_scatter * rng.standard_normal() + m1 * e + m_v * d) * x
        if unit.walk:
            steps = np.sqrt(np.diff(one.time, prepend=one.time[0]))
            y += unit.walk * np.cumsum(steps * rng.standard_normal(n))
        louder = np.where(inside > 0.5, unit.pump, 1.0)
        columns[f"gyro_{axis} [deg/s]"] = y + unit.sample * louder * rng.standard_normal(n)
    return columns


FORMS = {"unix_s": "%.1f", "temperature [degC]": "%.3f", "supply [V]": "%.5f", "pressure [Pa]": "%.4e"}
LEVEL = ("--latitude", "90 deg", "--attitude", '{ tilt = "0 deg" }')  # x and y read nothing of the earth


def table_of(columns: dict[str, Array], axes: str, run: int) -> Table:
    """Return one power-up as a file."""
    columns["unix_s"] = columns["unix_s"] + 1e6 * run
    signals = tuple(f"gyro_{axis} [deg/s]" for axis in axes)
    form = {name: FORMS.get(name, "%.7f") for name in columns}
    return Table(columns, signals, "unix_s", temperature="temperature [degC]", form=form)


def supplied(seed: int, unit: Unit | None = None, visits: Visits | None = None) -> Case:
    """Return power-ups at rest, with the supply stepped at each temperature."""
    unit, visits = unit or Unit(), visits or Visits()
    rng = np.random.default_rng([9, seed])
    tables = {
        f"run{run}.csv": table_of(read(unit, course(visits, run % 2 == 0), visits.axes, rng), visits.axes, run)
        for run in range(1, visits.runs + 1)
    }
    words = ["sensitivity", *(f"@{name}" for name in tables), "--to", "supply", *LEVEL]
    truth: dict[str, float] = {}
    for axis in visits.axes:
        truth |= {f"bias_supply {axis}": unit.supply, f"bias_supply_temperature {axis}": unit.supply_temperature}
    return Case("sensitivity", tables, words, truth, noise=unit.sample, rate=1.0 / visits.interval, rng_seed=seed)


def on_table(seed: int, unit: Unit | None = None, visits: Visits | None = None) -> Case:
    """Return power-ups on a rate table in a chamber: scale factor at each temperature and supply; x is turned."""
    unit = unit or Unit()
    visits = visits or Visits(volts=(4.85, 5.0, 5.15), dwell=60.0, rates=(-3.0, 0.0, 3.0), axes="x")
    rng = np.random.default_rng([10, seed])
    tables = {}
    for run in range(1, visits.runs + 1):
        one = course(visits, run % 2 == 0)
        columns = read(unit, one, visits.axes, rng) | {"table [deg/s]": one.rate}
        tables[f"run{run}.csv"] = table_of(columns, visits.axes, run)
    words = ["sensitivity", *(f"@{name}" for name in tables), "--to", "supply", "--to", "temperature", "--latitude",
             "90 deg", "--attitude", '{ tilt = "0 deg" }']  # fmt: skip
    truth: dict[str, float] = {}
    for axis in visits.axes:
        truth |= {f"scale_factor_error_temperature_1 {axis}": 100.0 * unit.scale[1]}
        truth |= {f"scale_factor_error_supply {axis}": 100.0 * unit.scale[2]}
        truth |= {f"bias_supply {axis}": unit.supply, f"bias_supply_temperature {axis}": unit.supply_temperature}
    return Case("sensitivity", tables, words, truth, noise=unit.sample, rate=1.0 / visits.interval, rng_seed=seed)


def warming(
    seed: int,
    unit: Unit | None = None,
    starts: tuple[float, ...] = (-20.0, 20.0, 50.0),
    runs: int = 2,
    hours: float = 2.0,
    interval: float = 10.0,
    axes: str = "xy",
) -> Case:
    """Return power-ups from several temperatures, ``runs`` from each, whose chamber stays where it is."""
    unit = unit or Unit(warm_up=((0.03, 2e-4, 200.0), (0.015, 1e-4, 2000.0)))
    rng = np.random.default_rng([11, seed])
    tables = {}
    for run, start in enumerate(starts * runs, 1):
        time = np.arange(0.0, 3600.0 * hours, interval)
        still = np.ones(len(time))
        one = Course(time, start * still, VOLTS * still, AIR * still, 0.0 * still)
        tables[f"run{run}.csv"] = table_of(read(unit, one, axes, rng), axes, run)
    words = ["sensitivity", *(f"@{name}" for name in tables), "--to", "warm_up", *LEVEL]
    truth = {f"warm_up_time_{j} ": tau for j, (_, _, tau) in enumerate(unit.warm_up, 1)}
    for axis in axes:
        truth |= {f"bias_warm_up_{j} {axis}": w for j, (w, _, _) in enumerate(unit.warm_up, 1)}
        truth |= {f"warm_up_start_temperature_{j} {axis}": a for j, (_, a, _) in enumerate(unit.warm_up, 1)}
    return Case("sensitivity", tables, words, truth, noise=unit.sample, rate=1.0 / interval, rng_seed=seed)


def pumped(
    seed: int,
    unit: Unit | None = None,
    runs: int = 5,
    temperatures: tuple[float, ...] = (-10.0, 20.0, 50.0),
    levels: tuple[float, ...] = (AIR, 1e-3),
    dwell: float = 600.0,
    interval: float = 5.0,
    axes: str = "xy",
) -> Case:
    """Return power-ups at each temperature of which the chamber is pumped out, or vented in every second one."""
    unit = unit or Unit(vacuum=(0.04, 3e-4), pump=2.0)
    rng = np.random.default_rng([12, seed])
    tables = {}
    for run in range(1, runs + 1):
        order = levels if run % 2 else tuple(reversed(levels))
        n = round(dwell / interval)
        pressure = np.concatenate([np.repeat(order, n)] * len(temperatures))
        warmth = np.repeat(temperatures, n * len(order))
        time, still = np.asarray(interval * np.arange(len(pressure))), np.ones(len(pressure))
        one = Course(time, warmth.astype(float), VOLTS * still, pressure, 0.0 * still)
        gauge = pressure * (1.0 + 0.02 * rng.standard_normal(len(pressure)))
        tables[f"run{run}.csv"] = table_of(read(unit, one, axes, rng) | {"pressure [Pa]": gauge}, axes, run)
    words = ["sensitivity", *(f"@{name}" for name in tables), "--to", "pressure", *LEVEL]
    truth: dict[str, float] = {}
    for axis in axes:
        change = tuple(-one / (levels[0] - levels[-1]) for one in unit.vacuum)  # per pascal
        truth |= {f"bias_pressure {axis}": change[0], f"bias_pressure_temperature {axis}": change[1]}
    return Case("sensitivity", tables, words, truth, noise=unit.sample, rate=1.0 / interval, rng_seed=seed)


def plane(case: Case, axis: str) -> dict[str, float]:
    """Return what least squares of all power-ups make of the supply, each with an intercept of its own."""
    rows, values = [], []
    for i, table in enumerate(case.tables.values()):
        e, d = table.columns["temperature [degC]"] - DEGREES, table.columns["supply [V]"] - VOLTS
        own = np.zeros((len(table), len(case.tables)))
        own[:, i] = 1.0
        rows.append(np.column_stack([d, d * e, e, e**2, own]))
        values.append(table.columns[f"gyro_{axis} [deg/s]"])
    found, *_ = np.linalg.lstsq(np.concatenate(rows), np.concatenate(values), rcond=None)
    return {"bias_supply": float(found[0]), "bias_supply_temperature": float(found[1])}

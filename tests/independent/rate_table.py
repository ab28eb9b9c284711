"""A triad of gyros on a rate table: power-ups by rates by axes, as recordings or as a table of means.

Sensor equation (IEEE Std 1431, annex of the model equation), with the rate ``u = M x`` along the sensors::

    y = K0 + turn-on + u + K1'/2 |u| + K2 u^2 + K3 u^3 + noise

``x`` is the rate in body axes: the table's own rate is wrong by one part, and the unit sits askew by small angles for
each axis, the same in all dwells. The laboratory lies at the pole and the table is level, so that the earth adds its
whole rate along the table and nothing across it.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from .case import START, Array, Case, Table, toml, turned

AXES = "xyz"
EARTH = np.degrees(7.292115e-5)  # IERS conventions [deg/s]


@dataclass(frozen=True)
class Gyros:
    """Truth of the triad and of its test. Rates in deg/s, errors of matrix entries as parts of one."""

    bias: tuple[float, float, float] = (0.03, -0.05, 0.02)
    scale: tuple[float, float, float] = (4e-3, -3e-3, 1e-3)  # M_xx - 1
    misalignment: float = 2e-3  # standard deviation of the cross terms, drawn by seed
    asymmetry: tuple[float, float, float] = (0.0, 0.0, 0.0)  # K1'
    k2: tuple[float, float, float] = (0.0, 0.0, 0.0)  # [1 / (deg/s)]
    k3: tuple[float, float, float] = (0.0, 0.0, 0.0)  # [1 / (deg/s)^2]
    turn_on: float = 0.0  # standard deviation of the bias from power-up to power-up
    slope_scatter: float = 0.0  # the same of the scale factor, as a part
    sample: float = 0.02  # of one sample
    dwell: float = 0.0  # standard deviation of a dwell's level
    drift: float = 0.0  # random walk of the rate within a run [deg/s / sqrt(s)]
    limit: float = np.inf  # end of the range
    table_rate: float = 0.0  # standard deviation of the table's relative error
    fixture: float = 0.0  # standard deviation of each small angle of the fixture [rad]


@dataclass(frozen=True)
class Protocol:
    """What the table does."""

    rates: tuple[float, ...] = (-10.0, -5.0, -2.0, 2.0, 5.0, 10.0)
    axes: str = "xyz"
    runs: int = 5  # power-ups an axis
    samples: int = 200  # a dwell
    rate: float = 20.0  # samples a second
    ramp: float = 20.0  # of the table [deg/s^2]
    turn_gap: float = 3600.0  # from run to run [s]
    shuffled: bool = False
    labelled: bool = True
    standards: dict[str, dict[str, str]] = field(default_factory=dict)  # {"rate_table.rate": {"u": "0.05 %"}}
    mounting: str = ""  # what the campaign calls this laying of the unit


@dataclass
class Drawn:
    """What was drawn: the matrix, the table's relative error, the fixture."""

    matrix: Array
    rate_error: float
    fixture: dict[str, Array]


def drawn(rng: np.random.Generator, gyros: Gyros, protocol: Protocol) -> Drawn:
    """Draw the unit and the errors of the fixture."""
    matrix = np.eye(3) + np.diag(gyros.scale)
    matrix += gyros.misalignment * rng.standard_normal((3, 3)) * (1.0 - np.eye(3))
    fixture = {axis: turned(gyros.fixture * rng.standard_normal(3))[:, AXES.index(axis)] for axis in protocol.axes}
    return Drawn(matrix, gyros.table_rate * rng.standard_normal(), fixture)


def output(gyros: Gyros, unit: Drawn, x: Array, offset: Array, slope: Array) -> Array:
    """Return what the triad reads of rates x (n, 3) in body axes, without noise."""
    u = x @ (unit.matrix * (1.0 + slope)[:, None]).T
    k1, k2, k3 = (np.array(values) for values in (gyros.asymmetry, gyros.k2, gyros.k3))
    values: Array = np.array(gyros.bias) + offset + u + 0.5 * k1 * np.abs(u) + k2 * u**2 + k3 * u**3
    return values


def truth_of(gyros: Gyros, unit: Drawn, protocol: Protocol) -> dict[str, float]:
    """Return the truth as the command prints it: percent, rad, deg/s."""
    truth: dict[str, float] = {}
    for i, sensor in enumerate(AXES):
        truth[f"bias {sensor}"] = gyros.bias[i]
        if sensor in protocol.axes and any(gyros.k2 + gyros.k3):
            truth[f"second_order {sensor}"] = gyros.k2[i]
            truth[f"third_order {sensor}"] = gyros.k3[i]
        for j, axis in enumerate(AXES):
            if i == j and axis in protocol.axes:
                truth[f"scale_factor_error {sensor}"] = 100.0 * (unit.matrix[i, i] - 1.0)
                truth[f"scale_factor_asymmetry {sensor}"] = 100.0 * gyros.asymmetry[i]
            elif sensor in protocol.axes and axis in protocol.axes and i != j:
                truth[f"misalignment {sensor}{axis}"] = unit.matrix[i, j] / unit.matrix[i, i]
    return truth


def reduced(
    seed: int,
    gyros: Gyros | None = None,
    protocol: Protocol | None = None,
    again: int = 0,
    remounted: bool = False,
    other_day: bool = False,
) -> Case:
    """Return a table of means, a row a dwell; noise of a mean is that of its samples and of the dwell.

    ``again``: the test is made once more, on the same unit and table; ``remounted``: with the fixture laid anew;
    ``other_day``: with another error of the table's rate.
    """
    gyros, protocol = gyros or Gyros(), protocol or Protocol()
    rng = np.random.default_rng([2, seed])
    unit = drawn(rng, gyros, protocol)
    rng = np.random.default_rng([2, seed, 1, again])
    if remounted:
        unit.fixture = drawn(rng, gyros, protocol).fixture
    if other_day:
        unit.rate_error = gyros.table_rate * rng.standard_normal()
    rows: list[tuple[str, float, Array, float, str]] = []
    for axis in protocol.axes:
        for run in range(protocol.runs):
            offset = gyros.turn_on * rng.standard_normal(3)
            slope = gyros.slope_scatter * rng.standard_normal(3)
            rates = np.array(protocol.rates)
            if protocol.shuffled:
                rng.shuffle(rates)
            x = np.outer(rates * (1.0 + unit.rate_error) + EARTH, unit.fixture[axis])
            means = output(gyros, unit, x, offset, slope)
            sd = np.hypot(gyros.sample / np.sqrt(protocol.samples), gyros.dwell)
            means = means + sd * rng.standard_normal(means.shape)
            scatter = gyros.sample * np.sqrt(rng.chisquare(protocol.samples - 1, len(rates)) / (protocol.samples - 1))
            rows += [(axis, r, y, s, f"{axis}{run + 1}") for r, y, s in zip(rates, means, scatter, strict=True)]
    columns = {
        "axis": np.array([row[0] for row in rows], dtype=object),
        "rate [deg/s]": np.array([row[1] for row in rows]),
        **{f"g{name} [deg/s]": np.array([row[2][i] for row in rows]) for i, name in enumerate(AXES)},
        "std [deg/s]": np.array([row[3] for row in rows]),
        "n": np.full(len(rows), protocol.samples),
        "run": np.array([row[4] for row in rows], dtype=object),
    }
    if not protocol.labelled:
        del columns["run"]
    signals = tuple(f"g{name} [deg/s]" for name in AXES)
    table = Table(columns, signals, applied="rate [deg/s]", run="run" if protocol.labelled else "", kind="reduced")
    table.form = dict.fromkeys((*signals, "std [deg/s]"), "%.7f")
    rows_of = {
        "applied": "rate [deg/s]", "reading": {name: f"g{name} [deg/s]" for name in AXES}, "axis": "axis",
        "samples": "n", "unit": "deg/s",
    } | ({"run": "run"} if protocol.labelled else {})  # fmt: skip
    entries: dict[str, dict[str, object]] = {
        "recordings.table": {"sensor": "gyros", "file": "table.csv", "rows": rows_of}
    }
    campaign = campaign_text(gyros, protocol, entries, ["table"])
    truth = truth_of(gyros, unit, protocol)
    noise = float(np.hypot(gyros.sample / np.sqrt(protocol.samples), gyros.dwell))
    case = Case("rate_table", {"table.csv": table}, ["run", "@"], truth, {"campaign.toml": campaign}, noise=noise)
    case.rng_seed = seed
    if protocol.labelled:
        for axis, X in designs(case).items():
            root = np.sqrt(np.diag(np.linalg.inv(X.T @ X)))
            case.ideal[f"scale_factor_error {axis}"] = 100.0 * noise * float(root[0])
            case.ideal[f"scale_factor_asymmetry {axis}"] = 200.0 * noise * float(root[1])
    return case


def recorded(
    seed: int, gyros: Gyros | None = None, protocol: Protocol | None = None, held_out: int = 0, still: float = 10.0
) -> Case:
    """Return a recording a power-up: the table ramps from dwell to dwell, and stands still at both ends.

    The last ``held_out`` runs of each axis are for the closed loop.
    """
    gyros, protocol = gyros or Gyros(), protocol or Protocol()
    rng = np.random.default_rng([2, seed])
    unit = drawn(rng, gyros, protocol)
    tables: dict[str, Table] = {}
    entries: dict[str, dict[str, object]] = {}
    fit: list[str] = []
    hold: list[str] = []
    at = 0.0
    for axis in protocol.axes:
        for run in range(protocol.runs + held_out):
            rates = np.array(protocol.rates)
            if protocol.shuffled:
                rng.shuffle(rates)
            table = power_up(rng, gyros, protocol, unit, axis, rates, START + at, still)
            at += protocol.turn_gap + len(table) / protocol.rate
            name = f"{axis}{run + 1}"
            tables[f"{name}.csv"] = table
            entry: dict[str, object] = {
                "sensor": "gyros", "file": f"{name}.csv", "axis": axis, "clock": {"column": "unix_s"},
                "channels": {s: {"column": f"g{s} [deg/s]", "unit": "deg/s"} for s in AXES}
                | {"applied": {"column": "table [deg/s]", "unit": "deg/s"}},
            }  # fmt: skip
            if protocol.labelled:
                entry["run"] = name
            entries[f"recordings.{name}"] = entry
            (fit if run < protocol.runs else hold).append(name)
    campaign = campaign_text(gyros, protocol, entries, fit, hold)
    truth = truth_of(gyros, unit, protocol)
    case = Case("rate_table", tables, ["run", "@"], truth, {"campaign.toml": campaign}, noise=gyros.sample)
    case.rate, case.rng_seed = protocol.rate, seed
    case.fit, case.held_out = tuple(f"{name}.csv" for name in fit), tuple(f"{name}.csv" for name in hold)
    return case


def power_up(
    rng: np.random.Generator, gyros: Gyros, protocol: Protocol, unit: Drawn, axis: str, rates: Array, start: float,
    still: float,
) -> Table:  # fmt: skip
    """Return the recording of one power-up: rest, dwells with ramps between them, rest."""
    dt, levels = 1.0 / protocol.rate, [0.0, *rates, 0.0]
    parts = [np.full(round(still * protocol.rate), 0.0)]
    for before, level in pairwise(levels):
        steps = max(1, round(abs(level - before) / protocol.ramp * protocol.rate))
        parts.append(before + (level - before) * np.arange(1, steps) / steps)
        parts.append(np.full(protocol.samples if level else round(still * protocol.rate), level))
    applied = np.concatenate(parts)
    x = np.outer(applied * (1.0 + unit.rate_error) + EARTH, unit.fixture[axis])
    offset, slope = gyros.turn_on * rng.standard_normal(3), gyros.slope_scatter * rng.standard_normal(3)
    values = output(gyros, unit, x, offset, slope)
    if gyros.dwell:
        number = np.cumsum(np.concatenate([[0], np.diff(applied) != 0.0]))
        values = values + gyros.dwell * rng.standard_normal((number[-1] + 1, 3))[number]
    if gyros.drift:
        values = values + gyros.drift * np.sqrt(dt) * np.cumsum(rng.standard_normal(values.shape), axis=0)
    values = np.clip(values + gyros.sample * rng.standard_normal(values.shape), -gyros.limit, gyros.limit)
    columns = {"unix_s": start + dt * np.arange(len(applied)), "table [deg/s]": applied}
    columns |= {f"g{name} [deg/s]": values[:, i] for i, name in enumerate(AXES)}
    signals = tuple(f"g{name} [deg/s]" for name in AXES)
    form = {"unix_s": "%.3f"} | dict.fromkeys(signals, "%.6f")
    return Table(columns, signals, "unix_s", "table [deg/s]", form=form)


def campaign_text(
    gyros: Gyros,
    protocol: Protocol,
    entries: dict[str, dict[str, object]],
    fit: list[str],
    hold: list[str] | None = None,
) -> str:
    """Return campaign.toml for these recordings."""
    plan = {"attitude": {"tilt": "0 deg"}}
    common = {"procedure": "rate_table", "plan": plan} | ({"mounting": protocol.mounting} if protocol.mounting else {})
    tests = [{"id": "rates", "recordings": fit} | common]
    if hold:
        tests.append({"id": "judged", "recordings": hold, "use": "hold_out"} | common)
    sensor: dict[str, object] = {"kind": "gyro", "axes": list(AXES), "unit": "deg/s"}
    if np.isfinite(gyros.limit):
        sensor["range"] = [f"{-gyros.limit} deg/s", f"{gyros.limit} deg/s"]
    groups: dict[str, object] = {"schema": 2, "campaign": {"id": "gyros"}, "site": {"latitude": "90 deg"}}
    by_name: dict[str, dict[str, object]] = {}
    for key, stated in protocol.standards.items():
        standard, quantity = key.split(".")
        by_name.setdefault(f"standards.{standard}", {})[quantity] = stated
    return toml(groups | by_name | {"sensors.gyros": sensor} | dict(entries) | {"tests": tests})


def asymmetries(case: Case) -> dict[str, float]:
    """Return the asymmetry K1' of each axis [%] by the same fit."""
    return {axis: 200.0 * b[1] / b[0] for axis, b in fits(case).items()}


def slopes(case: Case) -> dict[str, float]:
    """Return the scale-factor error of each axis [%]."""
    return {axis: 100.0 * (b[0] - 1.0) for axis, b in fits(case).items()}


def fits(case: Case) -> dict[str, Array]:
    """Return slope and coefficient of ``abs(rate)`` of each axis, by least squares with an intercept a run."""
    table = case.tables["table.csv"]
    readings = {
        axis: table.columns[name][table.columns["axis"] == axis] for axis, name in zip(AXES, table.signals, strict=True)
    }
    return {axis: np.linalg.lstsq(X, readings[axis], rcond=None)[0] for axis, X in designs(case).items()}


def designs(case: Case) -> dict[str, Array]:
    """Return, of each axis that is turned: rate, its size, and a column a run."""
    table = case.tables["table.csv"]
    found = {}
    for axis in dict.fromkeys(table.columns["axis"].tolist()):
        rows = table.columns["axis"] == axis
        x = table.columns["rate [deg/s]"][rows] + EARTH
        run = (table.columns["run"][rows][:, None] == np.unique(table.columns["run"][rows])).astype(float)
        found[axis] = np.column_stack([x, np.abs(x), run])
    return found

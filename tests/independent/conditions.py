"""A triad of gyros in a chamber, in air and in vacuum, and on a rate table in air: two models, and what each leaves.

In a condition c, with ``e`` the temperature less 20 degC and ``x`` the rate in body axes::

    y = B_c(e) + offset and slope of the power-up + M x + noise

The laboratory lies at the pole and z stands on end. What is left of a power-up held out is its mean compensated rate
less the earth's, over all temperatures.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from . import rate_table, thermal
from .case import START, Array, Case, Table, toml

AXES = rate_table.AXES
REFERENCE = 20.0  # [degC]
PASCAL = {"air": 101_325.0, "vacuum": 1e-3}
RANGES = {"air": ["80 kPa", "120 kPa"], "vacuum": ["0 Pa", "0.01 Pa"]}


@dataclass(frozen=True)
class Suite:
    """Truth of the triad in deg/s and degC: polynomials by condition, one a sensor."""

    bias: dict[str, tuple[tuple[float, ...], ...]] = field(
        default_factory=lambda: {
            "air": ((-0.07, -1.6e-3, -7e-6), (-0.006, -5e-4, -5e-6), (0.03, -4e-4, -8e-6)),
            "vacuum": ((-0.02, -1.5e-3, -5e-6), (0.008, -4.5e-4, -5e-6), (0.064, -3.5e-4, -9e-6)),
        }
    )
    turn_on: float = 0.006  # standard deviation from power-up to power-up
    slope_scatter: float = 1e-5  # of the linear coefficient from power-up to power-up
    sample: float = 0.004
    gyros: rate_table.Gyros = field(default_factory=lambda: rate_table.Gyros(turn_on=0.006, sample=0.004, dwell=2e-4))


@dataclass(frozen=True)
class Programme:
    """What is done with it."""

    runs: int = 5  # power-ups behind a fit
    held_out: int = 2  # more of them in each condition
    chamber: thermal.Chamber = field(
        default_factory=lambda: thermal.Chamber(points=(20.0, -20.0, 60.0, 20.0), speeds=(0.02,) * 3)
    )
    table: rate_table.Protocol = field(
        default_factory=lambda: rate_table.Protocol(
            rate=1.0, samples=60, ramp=5.0, rates=(-4.5, -1.5, 1.5, 4.5), runs=3
        )
    )


def suite(seed: int, truth: Suite | None = None, programme: Programme | None = None) -> Case:
    """Return the campaign: thermal in air and in vacuum, rate table in air, and power-ups held out of each."""
    truth, programme = truth or Suite(), programme or Programme()
    rng = np.random.default_rng([13, seed])
    unit = rate_table.drawn(rng, truth.gyros, programme.table)
    tables: dict[str, Table] = {}
    entries: dict[str, Any] = {}
    tests = []
    clock = {"column": "unix_s"}
    columns = {axis: {"column": f"g{axis} [deg/s]", "unit": "deg/s"} for axis in AXES}
    stand = {"latitude": "90 deg"}
    for number, (condition, polynomials) in enumerate(truth.bias.items()):
        names = [f"{condition}{run}" for run in range(1, programme.runs + programme.held_out + 1)]
        for run, name in enumerate(names):
            at = START + 1e6 * number + 1e5 * run
            tables[f"{name}.csv"] = in_chamber(rng, truth, programme, unit, polynomials, PASCAL[condition], at)
            channels = columns | {"temperature": {"column": "temperature [degC]", "unit": "degC"}}
            channels |= {"pressure": {"column": "pressure [Pa]", "unit": "Pa"}}
            entry = {"sensor": "gyros", "file": f"{name}.csv", "run": name, "clock": clock, "channels": channels}
            entries[f"recordings.{name}"] = entry
        plan = {"attitude": {"tilt": "0 deg"}, "reference_temperature": f"{REFERENCE:g} degC"}
        common = {"procedure": "thermal", "condition": condition, "plan": plan}
        tests.append({"id": f"thermal_{condition}", "recordings": names[: programme.runs]} | common)
        held = {"id": f"held_{condition}", "use": "hold_out", "recordings": names[programme.runs :]}
        tests.append(held | common)
    names = []
    for axis in AXES:
        for run in range(programme.table.runs):
            name = f"{axis}{run + 1}"
            at = START + 5e6 + 1e4 * len(names)
            rates = np.array(programme.table.rates)
            tables[f"{name}.csv"] = rate_table.power_up(
                rng, truth.gyros, programme.table, unit, axis, rates, at, still=60.0
            )
            channels = columns | {"applied": {"column": "table [deg/s]", "unit": "deg/s"}}
            entry = {"sensor": "gyros", "file": f"{name}.csv", "axis": axis, "run": name, "clock": clock}
            entries[f"recordings.{name}"] = entry | {"channels": channels}
            names.append(name)
    turned = {"id": "rate", "procedure": "rate_table", "recordings": names, "condition": "air"}
    tests.append(turned | {"plan": {"attitude": {"tilt": "0 deg"}}})
    taken = {kind: ["rate"] for kind in ("scale_factor", "misalignment", "asymmetry")}
    groups: dict[str, Any] = {"schema": 2, "campaign": {"id": "suite"}, "site": stand}
    groups |= {"sensors.gyros": {"kind": "gyro", "axes": list(AXES), "unit": "deg/s"}}
    groups |= {f"conditions.{name}": {"pressure": given} for name, given in RANGES.items()}
    groups |= entries | {"tests": tests}
    groups["model.by_condition.air"] = {"bias": ["thermal_air"]}
    groups["model.by_condition.vacuum"] = {"bias": ["thermal_vacuum"]} | taken
    case = Case("thermal", tables, ["run", "@"], {}, {"campaign.toml": toml(groups)}, rng_seed=seed)
    case.held_out = tuple(f"{name}.csv" for one in tests if one.get("use") for name in one["recordings"])
    return case


def in_chamber(
    rng: np.random.Generator,
    truth: Suite,
    programme: Programme,
    unit: rate_table.Drawn,
    polynomials: Sequence[Sequence[float]],
    pressure: float,
    start: float,
) -> Table:
    """Return a power-up in the chamber."""
    time, temperature = thermal.path(programme.chamber)
    n = len(time)
    e = temperature - REFERENCE
    still = np.tile([0.0, 0.0, rate_table.EARTH], (n, 1))
    bare = rate_table.Gyros(bias=(0.0, 0.0, 0.0), scale=truth.gyros.scale)
    y = rate_table.output(bare, unit, still, np.zeros(3), np.zeros(3))
    own = np.column_stack([truth.turn_on * rng.standard_normal(3), truth.slope_scatter * rng.standard_normal(3)])
    y = y + np.column_stack([np.polynomial.polynomial.polyval(e, one) for one in polynomials])
    y = y + own[:, 0] + own[:, 1] * e[:, None] + truth.sample * rng.standard_normal((n, 3))
    columns = {"unix_s": start + time, "pressure [Pa]": pressure * (1.0 + 0.02 * rng.standard_normal(n))}
    columns["temperature [degC]"] = temperature + programme.chamber.scatter * rng.standard_normal(n)
    columns |= {f"g{axis} [deg/s]": y[:, i] for i, axis in enumerate(AXES)}
    signals = tuple(f"g{axis} [deg/s]" for axis in AXES)
    form = {"unix_s": "%.1f", "pressure [Pa]": "%.4e", "temperature [degC]": "%.3f"} | dict.fromkeys(signals, "%.6f")
    return Table(columns, signals, "unix_s", temperature="temperature [degC]", form=form)


def left_over(text: str) -> Array:
    """Return mean compensated rate less the earth's, and the mean of its stated u, by axis, shape (2, 3) [deg/s]."""
    header, *lines = text.splitlines()
    rows = np.array([[float(cell or "nan") for cell in line.split(",")[: header.count(",") + 1]] for line in lines])
    names = [name.split(" [")[0] for name in header.split(",")]
    means = {name: float(np.nanmean(rows[:, i])) for i, name in enumerate(names) if not name.startswith("compensated")}
    earth = np.array([0.0, 0.0, rate_table.EARTH])
    return np.array([[means[f"g{axis}"] for axis in AXES] - earth, [means[f"u_g{axis}"] for axis in AXES]])


def without_pressure(table: Table) -> Table:
    """Return the recording of a logger that has no gauge."""
    bare = table.copy()
    del bare.columns["pressure [Pa]"]
    return bare

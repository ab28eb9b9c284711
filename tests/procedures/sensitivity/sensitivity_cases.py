"""Simulated cases as the procedure takes them, without files; and what spoils them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from independent.case import Case
from inertialcal.core.estimate import Array
from inertialcal.core.recording import Channel, Recording
from inertialcal.core.results import Row
from inertialcal.procedures.sensitivity.plan import Plan
from inertialcal.procedures.sensitivity.readings import ConditionRecording, readings_from
from inertialcal.procedures.sensitivity.reduction import Result, reduce

Spoil = Callable[[ConditionRecording], ConditionRecording]
SUPPLY = Plan(to=["supply"], unit="deg/s")


def recordings_of(case: Case, spoil: Spoil | None = None) -> list[ConditionRecording]:
    """Return the power-ups of a case; on a table x is turned."""
    found = []
    for name, table in case.tables.items():
        columns = table.columns
        axes = [axis for axis in "xyz" if f"gyro_{axis} [deg/s]" in columns]
        channels = tuple(
            Channel(axis, np.radians(columns[f"gyro_{axis} [deg/s]"]), "rad/s", "flag", axis) for axis in axes
        )
        stamps = np.round(columns["unix_s"] * 1e9).astype(np.int64)
        recording = Recording(channels, stamps, 1.0 / case.rate, epoch="utc")
        conditions = {"temperature": columns["temperature [degC]"], "supply": columns["supply [V]"]}
        units = {"temperature": "degC", "supply": "V"}
        if "table [deg/s]" in columns:
            conditions["applied"], units["applied"] = np.radians(columns["table [deg/s]"]), "rad/s"
        by_axis = {condition: dict.fromkeys(axes, values) for condition, values in conditions.items()}
        one = ConditionRecording(recording, by_axis, units, "", name, "x" if "applied" in units else "")
        found.append(one if spoil is None else spoil(one))
    return found


def reduced(case: Case, plan: Plan = SUPPLY, spoil: Spoil | None = None) -> Result:
    """Return what the procedure finds in a case."""
    return reduce(plan, readings_from(plan, recordings_of(case, spoil), "rad/s"))


def codes(result: Result) -> set[str]:
    """Return the codes of all remarks."""
    return {one.code for one in result.remarks}


def row(result: Result, name: str) -> Row:
    """Return a row by quantity and axis: ``"bias_supply x"``."""
    return next(one for one in result.rows() if f"{one.quantity} {one.axis}" == name)


def truth_of(case: Case, name: str) -> float:
    """Return a true value, SI."""
    return case.truth[name] * (0.01 if name.startswith("scale") else np.pi / 180.0)


def hits(case: Case, result: Result) -> dict[str, bool]:
    """Return by quantity and axis whether the interval holds the truth."""
    found = {}
    for one in result.rows():
        name = f"{one.quantity} {one.axis}"
        if name in case.truth and one.interval is not None:
            lo, hi = one.interval.lo, one.interval.hi
            assert lo is not None
            assert hi is not None
            found[name] = lo <= truth_of(case, name) <= hi
    return found


def with_supply(one: ConditionRecording, changed: Callable[[Array], Array]) -> ConditionRecording:
    """Return a recording whose supply channel says something else."""
    supply = {axis: changed(values) for axis, values in one.conditions["supply"].items()}
    return replace(one, conditions={**one.conditions, "supply": supply})


def with_transient(one: ConditionRecording, size: float = 0.01, tau: float = 60.0) -> ConditionRecording:
    """Return readings that follow each step of the supply late: an exponential of ``size`` [deg/s] for 0.15 V."""
    volts = np.round(one.conditions["supply"]["x"], 2)
    time = 5.0 * np.arange(len(volts))
    added = np.zeros(len(volts))
    for k in np.flatnonzero(np.diff(volts)):
        late = time[k + 1 :] - time[k + 1]
        added[k + 1 :] += size * (volts[k + 1] - volts[k]) / 0.15 * np.exp(-late / tau)
    channels = tuple(replace(c, data=c.data + np.radians(added)) for c in one.recording.channels)
    return replace(one, recording=replace(one.recording, channels=channels))


def covered(cases: Sequence[Case], plan: Plan = SUPPLY, spoil: Spoil | None = None) -> dict[str, tuple[int, int]]:
    """Return how many intervals hold the truth, of how many, by quantity and axis."""
    found: dict[str, tuple[int, int]] = {}
    for case in cases:
        for name, hit in hits(case, reduced(case, plan, spoil)).items():
            count, n = found.get(name, (0, 0))
            found[name] = count + hit, n + 1
    return found

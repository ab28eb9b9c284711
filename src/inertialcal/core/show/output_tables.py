"""Two tables of a rate-sensor suite, from the results of a campaign: its summary, and its output for flight.

They hold what Tables 14 and 15 of [1]_ hold, one of each for every condition, every figure with its standard
uncertainty and in the unit that follows from its equation: volts for the polynomial B, m1, m2, m3 (it must be divided
by the scale factor before it is a rate), percent for M. Where the thesis's M has the sign of the correction and the
turned axis in its row, M here is the error: positive where a sensor reads too much, a column a sensor. A figure that
the campaign does not have in a condition is not estimated, with the reason. A test without a condition holds in each.

References
----------
.. [1] V. V. Badescu, NPS thesis, September 2011, Tables 14 and 15.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..key import Method
from ..results import WrittenRow, case_of
from ..units import parse_quantity

ORDER = {"fit": 0, "report_only": 1, "hold_out": 2}
REFERENCED = "referenced"  # reason of a bias where the reading at rest was subtracted
FIELDS = ("value", "u", "dof", "interval", "status", "reason", "test")  # of a row, that a table has
NOTHING = "no test of the campaign gives it"


@dataclass(frozen=True)
class Wanted:
    """A line of a table: which rows it holds."""

    group: str
    name: str  # As the table has it
    quantity: str
    power: int = 0
    unit: str = ""  # In which it is written, where it is another way to write that of the row
    beside: str = ""  # Another quantity that its test must give
    held_out: bool = False  # Of a test that is held out, first
    referenced: bool | None = None  # Of a test whose readings at rest were subtracted, or were not


SUMMARY = (
    Wanted("Start-up", "change in warm-up", "warm_up_change"),
    Wanted("Start-up", "time constant", "warm_up_time_constant"),
    Wanted("Start-up", "time until settled", "warm_up_time"),
    Wanted("Voltages", "reference", "reference_voltage"),
    Wanted("Voltages", "thermometer reference", "temperature_reference_voltage"),
    Wanted("Voltages", "thermometer nominal", "nominal_voltage"),
    Wanted("Repeatability", "bias run to run", "scatter_run", beside="hysteresis"),
    Wanted("Repeatability", "residual settled", "residual_bias", beside="hysteresis", held_out=True),
    Wanted("Thermal ramp", "hysteresis", "hysteresis"),
    Wanted("Thermal ramp", "vacuum offset", "vacuum_offset"),
    Wanted("Rate", "resolution direct", "resolution", referenced=False),
    Wanted("Rate", "resolution less rest", "resolution", referenced=True),
    Wanted("Rate", "scale factor", "scale_factor"),
    Wanted("Rate", "scale factor error", "scale_factor_error"),
    Wanted("Noise", "angle random walk", "angle_random_walk"),
    Wanted("Noise", "bias instability", "bias_instability"),
    Wanted("Noise", "rate random walk", "rate_random_walk"),
    Wanted("Noise", "rate ramp", "rate_ramp"),
)
OUTPUT = (
    Wanted("Rate", "B", "bias_voltage", 0, "V"),
    Wanted("Rate", "m1", "bias_voltage", 1, "V/V"),
    Wanted("Rate", "m2", "bias_voltage", 2, "V/V^2"),
    Wanted("Rate", "m3", "bias_voltage", 3, "V/V^3"),
    Wanted("Rate", "b_cons", "bias", beside="scale_factor"),
)
THERMOMETER = (("T_ref", "temperature", "degC"), ("V_nominal", "voltage", "V"), ("slope", "slope", "V/degC"))


@dataclass(frozen=True)
class Line:
    """A figure a sensor."""

    group: str
    name: str
    unit: str
    rows: Mapping[str, Mapping[str, Any]]  # Axis -> row of results, or the same fields of what was stated


@dataclass(frozen=True)
class OutputTable:
    """One table of one condition."""

    title: str
    condition: str  # Of the campaign; empty where it names none
    lines: tuple[Line, ...]
    axes: tuple[str, ...]

    def to_dict(self) -> dict[str, Any]:
        """Return it as ``--json`` prints it: a row a figure."""
        rows = [
            {"group": line.group, "name": line.name, "axis": axis, "unit": line.unit}
            | {name: line.rows[axis].get(name) for name in FIELDS}
            for line in self.lines
            for axis in self.axes
        ]
        return {"title": self.title, "condition": self.condition, "rows": rows}


def output_tables(results: Mapping[str, Any]) -> list[OutputTable]:
    """Return the summary and the output of a suite, condition by condition.

    Parameters
    ----------
    results : mapping
        Content of ``results.json``.

    Returns
    -------
    list of OutputTable
        None where the campaign has no gyro.
    """
    sensor = next((one for one in results["sensors"].values() if one["kind"] == "gyro"), None)
    if sensor is None:
        return []
    axes = tuple(sensor["axes"])
    steps = {step["test"]: step for step in results["sequence"]}
    conditions = list(dict.fromkeys(step["condition"] for step in steps.values() if step["condition"])) or [""]
    rows = [row for row in results["results"] if row["test"] in steps and _is_result(row)]
    tables = []
    for condition in conditions:
        summary = tuple(_line(one, rows, steps, axes, condition) for one in SUMMARY)
        output = tuple(_line(one, rows, steps, axes, condition) for one in OUTPUT)
        tables.append(OutputTable("Summary (thesis Table 14)", condition, summary, axes))
        matrix = tuple(_matrix(axis, rows, steps, axes, condition) for axis in axes)
        whole = (*output, *matrix, *_thermometer(sensor.get("chain"), axes))
        tables.append(OutputTable("Output (thesis Table 15)", condition, whole, axes))
    return tables


def _is_result(row: WrittenRow) -> bool:
    case = case_of(row)
    return case.at is None and case.method is Method.RESULT and (
        case.member is None or case.member.kind == "requirement"
    )  # fmt: skip


Steps = Mapping[str, Mapping[str, Any]]  # test -> its entry in ``sequence``


def _line(one: Wanted, rows: Sequence[WrittenRow], steps: Steps, axes: Sequence[str], condition: str) -> Line:
    found = {axis: _row(one, axis, rows, steps, condition) for axis in axes}
    unit = one.unit or next((str(row["unit"]) for row in found.values() if row["unit"]), "")
    return Line(one.group, one.name, unit, found)


def _matrix(moved: str, rows: Sequence[WrittenRow], steps: Steps, axes: Sequence[str], condition: str) -> Line:
    """Return what each sensor reads of the motion along one axis, less its own in full."""
    found = {}
    for axis in axes:
        own = axis == moved
        one = Wanted("", "", "scale_factor_error" if own else "cross_axis_sensitivity")
        found[axis] = _row(one, axis if own else axis + moved, rows, steps, condition)
    return Line("Rate", f"M from {moved}", "%", found)


def _row(one: Wanted, axis: str, rows: Sequence[WrittenRow], steps: Steps, condition: str) -> Mapping[str, Any]:
    """Return the row of an axis: of the test that comes first and has an estimate."""
    given = {row["test"] for row in rows if row["quantity"] == one.beside}
    rest = {
        row["test"]
        for row in rows
        if row["quantity"] == "bias" and row["reason"] is not None and row["reason"]["code"] == REFERENCED
    }
    every = [
        row
        for row in rows
        if (row["quantity"], row["power"], row["axis"]) == (one.quantity, one.power, axis)
        and (not one.beside or row["test"] in given)
        and (one.referenced is None or (row["test"] in rest) == one.referenced)
    ]

    def place(row: WrittenRow) -> tuple[bool, bool, int]:
        step = steps[row["test"]]
        use = ORDER[step["use"]]
        return row["status"] == "not_estimated", not step["condition"], -use if one.held_out else use

    there = [row for row in every if steps[row["test"]]["condition"] in (condition, "")]
    if there:
        first = sorted(there, key=place)[0]
        return {name: first[name] for name in (*FIELDS, "unit")}
    elsewhere = dict.fromkeys(steps[row["test"]]["condition"] for row in every if row["status"] != "not_estimated")
    text = f"tests give it only in condition {', '.join(elsewhere)}" if elsewhere else NOTHING
    reason = {"code": "no_test", "text": text}
    return {"value": None, "u": None, "unit": "", "status": "not_estimated", "reason": reason, "test": ""}


def _thermometer(chain: Mapping[str, Any] | None, axes: Sequence[str]) -> tuple[Line, ...]:
    """Return the constants of the temperature channel, as the campaign states them."""
    said = (chain or {}).get("thermometer") or {}
    lines = []
    for name, field, unit in THERMOMETER:
        given = said.get(field)
        found: dict[str, Mapping[str, Any]] = {}
        for axis in axes:
            text = given.get(axis) if isinstance(given, Mapping) else given
            value = None if text is None else parse_quantity(str(text)).to(unit)
            why = {"code": "stated", "text": "stated in the chain of the campaign, without uncertainty"}
            none = {"code": "no_thermometer", "text": "the chain of the campaign has no temperature channel"}
            reason = none if value is None else why
            found[axis] = {"value": value, "u": None, "status": "not_estimated", "reason": reason, "test": ""}
        lines.append(Line("Temperature", name, unit, found))
    return tuple(lines)

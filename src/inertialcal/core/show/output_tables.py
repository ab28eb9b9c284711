"""Two tables of a rate-sensor suite, from the results of a campaign: its summary, and its output for flight.

They hold what Tables 14 and 15 of [1]_ hold, one of each for every condition, every figure with its standard
uncertainty and in the unit that follows from its equation: volts for the polynomial B, m1, m2, m3 (it must be divided
by the scale factor before it is a rate), percent for M. Where the thesis's M has the sign of the correction and the
turned axis in its row, M here is the error: positive where a sensor reads too much, a column a sensor. Where the
model of a condition takes terms from a test in another one, as ``[model.by_condition]`` decides, the table has the
figures of that test too, marked with its condition. Any other figure that the campaign does not have in a condition is
not estimated, with the reason. A test without a condition holds in each.

References
----------
.. [1] V. V. Badescu, NPS thesis, September 2011, Tables 14 and 15.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Generic

from ..key import Key, Method
from ..results import WrittenRow, case_of, key_of
from ..units import parse_quantity
from .rows import R, reason_code

ORDER = {"fit": 0, "report_only": 1, "hold_out": 2}
REFERENCED = "referenced"  # reason of a bias where the reading at rest was subtracted
FIELDS = ("value", "u", "dof", "interval", "status", "reason", "test")  # of a row, that a table has
NOTHING = "no test of the campaign gives it"
NO_ROW = {
    "value": None, "u": None, "dof": None, "interval": None, "unit": "", "status": "not_estimated", "reason": None,
    "test": "",
}  # fmt: skip
NO_THERMOMETER = {"code": "no_thermometer", "text": "the chain of the campaign has no temperature channel"}


@dataclass(frozen=True)
class Wanted:
    """A line of a table: which rows it holds."""

    group: str
    name: str  # As the table has it
    quantity: str
    power: int = 0
    unit: str = ""  # In which it is written, where it is another way to write that of the row
    beside: tuple[str, ...] = ()  # Another quantity that its test must give; of the first of these, where several do
    held_out: bool = False  # Of a test that is held out, first
    referenced: bool | None = None  # Of a test whose readings at rest were subtracted, or were not
    stated: str = ""  # Key of ``chain.thermometer`` that says it where no test does
    kind: str = ""  # Of the terms of a model: what a condition takes from another one by decision


SUMMARY = (
    Wanted("Start-up", "change in warm-up", "warm_up_change"),
    Wanted("Start-up", "time constant", "warm_up_time_constant"),
    Wanted("Start-up", "time until settled", "warm_up_time"),
    Wanted("Start-up", "joint warm-up 1", "bias_warm_up", 1, kind="warm_up"),
    Wanted("Start-up", "time constant 1", "warm_up_time", 1, kind="warm_up"),
    Wanted("Start-up", "joint warm-up 2", "bias_warm_up", 2, kind="warm_up"),
    Wanted("Start-up", "time constant 2", "warm_up_time", 2, kind="warm_up"),
    Wanted("Voltages", "reference", "reference_voltage"),
    Wanted("Voltages", "thermometer reference", "temperature_reference_voltage"),
    Wanted("Voltages", "thermometer nominal", "thermometer_voltage", 0, "V", stated="voltage"),
    Wanted("Voltages", "bias by supply", "bias_supply", kind="sensitivity"),
    Wanted("Voltages", "bias by supply and temperature", "bias_supply_temperature", kind="sensitivity"),
    Wanted("Voltages", "scale factor by supply", "scale_factor_error_supply", kind="sensitivity"),
    Wanted("Voltages", "bias by reference", "bias_reference", kind="sensitivity"),
    Wanted("Repeatability", "bias run to run", "scatter_run", beside=("hysteresis", "scale_factor_error")),
    Wanted("Repeatability", "residual settled", "residual_bias", beside=("hysteresis",), held_out=True),
    Wanted("Thermal ramp", "hysteresis", "hysteresis"),
    Wanted("Thermal ramp", "vacuum offset", "vacuum_offset"),
    Wanted("Rate", "resolution direct", "resolution", referenced=False),
    Wanted("Rate", "resolution less rest", "resolution", referenced=True),
    Wanted("Rate", "scale factor", "scale_factor", kind="scale_factor"),
    Wanted("Rate", "scale factor error", "scale_factor_error", kind="scale_factor"),
    Wanted("Noise", "angle random walk", "angle_random_walk", kind="noise"),
    Wanted("Noise", "bias instability", "bias_instability", kind="noise"),
    Wanted("Noise", "rate random walk", "rate_random_walk", kind="noise"),
    Wanted("Noise", "rate ramp", "rate_ramp", kind="noise"),
)
OUTPUT = (
    Wanted("Rate", "B", "bias_voltage", 0, "V", kind="bias"),
    Wanted("Rate", "m1", "bias_voltage", 1, "V/V", kind="bias"),
    Wanted("Rate", "m2", "bias_voltage", 2, "V/V^2", kind="bias"),
    Wanted("Rate", "m3", "bias_voltage", 3, "V/V^3", kind="bias"),
    Wanted("Rate", "b_cons", "bias", beside=("scale_factor_error",), kind="bias"),
)
THERMOMETER = (
    Wanted("Temperature", "T_ref", "", 0, "degC", stated="temperature"),
    Wanted("Temperature", "V_nominal", "thermometer_voltage", 0, "V", stated="voltage"),
    Wanted("Temperature", "slope", "thermometer_slope", 0, "V/degC", stated="slope"),
)
STATED = {"code": "stated", "text": "stated in campaign.toml, without uncertainty"}


@dataclass(frozen=True)
class Line(Generic[R]):
    """A figure a sensor."""

    group: str
    name: str
    unit: str
    rows: Mapping[str, R | Mapping[str, Any]]  # Axis -> row of results, or fields of one where there is none
    taken: Mapping[str, str]  # Test -> its condition, where the table is of another one

    @property
    def is_empty(self) -> bool:
        """Whether no axis has a value."""
        return all(row["value"] is None for row in self.rows.values())

    @property
    def tests(self) -> list[str]:
        """Tests that its values come from."""
        return list(
            dict.fromkeys(row["test"] for row in self.rows.values() if row["test"] and row["value"] is not None)
        )


@dataclass(frozen=True)
class OutputTable(Generic[R]):
    """One table of one condition."""

    title: str
    condition: str  # Of the campaign; empty where it names none
    lines: tuple[Line[R], ...]
    axes: tuple[str, ...]

    @property
    def reasons(self) -> list[tuple[str, list[str]]]:
        """Why figures are not estimated, and the names of those figures, with the axes if it is not all of them."""
        found: dict[str, dict[str, list[str]]] = {}
        for line in self.lines:
            for axis in self.axes:
                row = line.rows[axis]
                if row["status"] == "not_estimated" and row["reason"] is not None:
                    found.setdefault(row["reason"]["text"], {}).setdefault(line.name, []).append(axis)
        every = len(self.axes)
        return [
            (text, [name if len(axes) == every else f"{name} ({' '.join(axes)})" for name, axes in names.items()])
            for text, names in found.items()
        ]

    def to_dict(self) -> dict[str, Any]:
        """Return it as ``--json`` prints it: a row a figure."""
        rows = [
            {"group": line.group, "name": line.name, "axis": axis, "unit": line.unit}
            | {name: line.rows[axis][name] for name in FIELDS}
            | {"taken_from": line.taken.get(line.rows[axis]["test"], "")}
            for line in self.lines
            for axis in self.axes
        ]
        return {"title": self.title, "condition": self.condition, "rows": rows}


def output_tables(
    sensors: Mapping[str, Any], sequence: Sequence[Mapping[str, Any]], results: Sequence[R]
) -> list[OutputTable[R]]:
    """Return the summary and the output of a suite, condition by condition.

    Parameters
    ----------
    sensors : mapping
        ``sensors`` of ``results.json``.
    sequence, results : sequence of mapping
        Its ``sequence`` and ``results``.

    Returns
    -------
    list of OutputTable
        None where the campaign has no gyro.
    """
    name = next((name for name, one in sensors.items() if one["kind"] == "gyro"), None)
    if name is None:
        return []
    sensor, steps = sensors[name], {step["test"]: step for step in sequence if name in step["sensors"]}
    rows = [row for row in results if row["test"] in steps and row["sensor"] in ("", "gyro") and _is_result(row)]
    by_key: dict[Key, list[tuple[int, R]]] = {}
    tests: dict[str, set[str]] = {}
    for number, row in enumerate(rows):
        key = key_of(row)._replace(sensor="")
        by_key.setdefault(key, []).append((number, row))
        tests.setdefault(key.quantity, set()).add(str(row["test"]))
    rest = {str(row["test"]) for row in rows if row["quantity"] == "bias" and reason_code(row) == REFERENCED}
    thermometer = (sensor.get("chain") or {}).get("thermometer") or {}
    suite = _Suite(tuple(sensor["axes"]), thermometer, steps, by_key, tests, rest)
    tables = []
    for condition in list(dict.fromkeys(step["condition"] for step in steps.values() if step["condition"])) or [""]:
        summary = [suite.line(one, condition) for one in SUMMARY]
        output = [suite.line(one, condition) for one in OUTPUT]
        output += [suite.matrix(axis, condition) for axis in suite.axes]
        output += [suite.line(one, condition) for one in THERMOMETER]
        tables.append(OutputTable("Summary (thesis Table 14)", condition, tuple(summary), suite.axes))
        tables.append(OutputTable("Output (thesis Table 15)", condition, tuple(output), suite.axes))
    return tables


def _is_result(row: WrittenRow) -> bool:
    case = case_of(row)
    return case.at is None and case.method is Method.RESULT and (
        case.member is None or case.member.kind == "requirement"
    )  # fmt: skip


@dataclass(frozen=True)
class _Suite(Generic[R]):
    """Where the figures are found."""

    axes: tuple[str, ...]
    thermometer: Mapping[str, Any]  # Of the chain
    steps: Mapping[str, Mapping[str, Any]]  # Test -> its entry in ``sequence``
    rows: Mapping[Key, Sequence[tuple[int, R]]]  # By key without the sensor, each with its number in the results
    tests_of: Mapping[str, set[str]]  # Tests that give a quantity
    rest: set[str]  # Tests where the readings at rest were subtracted

    def line(self, one: Wanted, condition: str) -> Line[R]:
        found = {axis: self._row(one, axis, condition) for axis in self.axes}
        unit = one.unit or next((row["unit"] for row in found.values() if row["unit"]), "")
        return Line(one.group, one.name, unit, found, self._taken(found, condition))

    def matrix(self, moved: str, condition: str) -> Line[R]:
        """Return what each sensor reads of the motion along one axis, less its own in full."""
        own = Wanted("", "", "scale_factor_error", kind="scale_factor")
        other = Wanted("", "", "cross_axis_sensitivity", kind="misalignment")
        found = {
            axis: self._row(own, axis, condition) if axis == moved else self._row(other, axis + moved, condition)
            for axis in self.axes
        }
        return Line("Rate", f"M from {moved}", "%", found, self._taken(found, condition))

    def _taken(self, found: Mapping[str, R | Mapping[str, Any]], condition: str) -> dict[str, str]:
        """Return the condition of each test that is of another one, and whose figures are there by decision."""
        stated = {row["test"]: str(self.steps[row["test"]]["condition"]) for row in found.values() if row["test"]}
        return {test: own for test, own in stated.items() if own not in (condition, "")}

    def _row(self, one: Wanted, axis: str, condition: str) -> R | Mapping[str, Any]:
        """Return the row of an axis: of a test with an estimate; first one that the model takes it from."""
        given = [self.tests_of.get(quantity, set()) for quantity in one.beside]
        keys = dict.fromkeys(Key(one.quantity, name, power=one.power) for name in (axis, ""))
        ordered = sorted((pair for key in keys for pair in self.rows.get(key, ())), key=lambda pair: pair[0])
        every = [
            row
            for _, row in ordered
            if (not given or any(row["test"] in tests for tests in given))
            and (one.referenced is None or (row["test"] in self.rest) == one.referenced)
        ]

        made_of = self._made_of(one.kind, condition)

        def place(row: R) -> tuple[bool, bool, bool, int, int]:
            step = self.steps[row["test"]]
            use, beside = ORDER[step["use"]], next((i for i, tests in enumerate(given) if row["test"] in tests), 0)
            return (
                row["status"] == "not_estimated", row["test"] not in made_of, not step["condition"], beside,
                -use if one.held_out else use,
            )  # fmt: skip

        tests = self._tests(made_of, condition)
        there = sorted((row for row in every if row["test"] in tests), key=place)
        estimated = [row for row in there if row["status"] != "not_estimated"]
        if estimated or (there and not one.stated):
            return [*estimated, *there][0]
        if one.stated:
            return self._stated(one, axis)
        elsewhere = {self.steps[row["test"]]["condition"]: None for row in every if row["status"] != "not_estimated"}
        text = f"tests give it only in condition {', '.join(elsewhere)}" if elsewhere else NOTHING
        return NO_ROW | {"reason": {"code": "no_test", "text": text}}

    def _made_of(self, kind: str, condition: str) -> set[str]:
        """Return the tests that the model of a condition takes a kind of term from."""
        return {test for test, step in self.steps.items() if kind in step["terms"].get(condition, [])}

    def _tests(self, made_of: set[str], condition: str) -> set[str]:
        """Return the tests of a condition; those of others that its model takes a term from by decision, instead."""
        own = {test for test, step in self.steps.items() if step["condition"] in (condition, "")}
        return own if made_of & own or not made_of else made_of

    def _stated(self, one: Wanted, axis: str) -> Mapping[str, Any]:
        """Return a constant of the temperature channel as the campaign states it."""
        given = self.thermometer.get(one.stated)
        text = given.get(axis) if isinstance(given, Mapping) else given
        if text is None:
            return NO_ROW | {"reason": NO_THERMOMETER}
        return NO_ROW | {"value": parse_quantity(str(text)).to(one.unit), "stated": str(text), "reason": STATED}

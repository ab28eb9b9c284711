"""The two tables of a suite: which test each figure comes from, in which condition, and what is not estimated."""

from __future__ import annotations

from typing import Any

from inertialcal.cli.shown.summary import tables_text
from inertialcal.core.show.output_tables import OutputTable, output_tables
from written_rows import fields


def step(test: str, use: str, condition: str, sensor: str = "suite", **terms: list[str]) -> dict[str, Any]:
    """Return a test; terms are the kinds that the model of a condition takes from it."""
    return {"test": test, "use": use, "condition": condition, "sensors": [sensor], "terms": terms}


STEPS = [
    step("air", "fit", "air", air=["bias"]), step("air_check", "hold_out", "air"),
    step("vacuum", "fit", "vacuum", vacuum=["bias"]),
    step("table", "fit", "air", air=["scale_factor", "misalignment"]), step("at_rest", "report_only", "air"),
    step("still", "fit", ""),
]  # fmt: skip
DECIDED = [*STEPS[:3], step("table", "fit", "air", air=["scale_factor"], vacuum=["scale_factor"]), *STEPS[4:]]
CHAIN = {"thermometer": {"slope": "26.4 mV/degC", "voltage": {"x": "-0.5042 V"}, "temperature": {"x": "25.7 degC"}}}
SENSOR = {"kind": "gyro", "axes": ["x", "y"], "chain": CHAIN}


def row(test: str, quantity: str, axis: str, value: float | None, unit: str, power: int = 0) -> dict[str, Any]:
    own = {"test": test, "quantity": quantity, "axis": axis, "power": power, "value": value, "unit": unit}
    more: dict[str, Any] = {
        "u": 0.1,
        "dof": None,
        "status": "estimated",
        "reason": None,
        "interval": None,
        "sensor": "",
    }
    if value is None:
        more |= {"u": None, "status": "not_estimated", "reason": {"code": "referenced", "text": "subtracted"}}
    found: dict[str, Any] = fields("") | own | more
    return found


ROWS = [
    row("air", "hysteresis", "x", 1.0, "deg/s"), row("air", "scatter_run", "x", 2.0, "deg/s"),
    row("air_check", "hysteresis", "x", 9.0, "deg/s"), row("air_check", "residual_bias", "x", 3.0, "deg/s"),
    row("air", "bias_voltage", "x", 4.0, "1/V", power=2), row("vacuum", "hysteresis", "x", 5.0, "deg/s"),
    row("table", "scatter_run", "x", 8.0, "deg/s"), row("table", "scale_factor", "x", 0.5, "V/(deg/s)"),
    row("table", "scale_factor_error", "x", 0.6, "%"), row("table", "cross_axis_sensitivity", "yx", 0.7, "%"),
    row("table", "bias", "x", 0.01, "deg/s"), row("table", "resolution", "x", 1.5, "deg/s"),
    row("at_rest", "bias", "x", None, "deg/s"), row("at_rest", "resolution", "x", 0.1, "deg/s"),
    row("at_rest", "residual_bias", "x", 7.0, "deg/s"), row("still", "angle_random_walk", "x", 0.2, "deg/sqrt(h)"),
]  # fmt: skip
TABLES = output_tables({"suite": SENSOR}, STEPS, ROWS)


def value(table: OutputTable[Any], name: str, axis: str = "x") -> Any:
    (line,) = [one for one in table.lines if one.name == name]
    found = line.rows[axis]
    return found["value"] if found["value"] is not None else found["reason"]["text"]


def test_each_figure_is_that_of_its_test_and_condition() -> None:
    air, air_output, vacuum, vacuum_output = TABLES
    assert [one.condition for one in (air, air_output, vacuum, vacuum_output)] == ["air", "air", "vacuum", "vacuum"]
    figures = {
        "hysteresis": 1.0, "bias run to run": 2.0, "residual settled": 3.0, "scale factor": 0.5,
        "resolution direct": 1.5, "resolution less rest": 0.1, "angle random walk": 0.2,
    }  # fmt: skip
    assert {name: value(air, name) for name in figures} == figures
    assert value(vacuum, "hysteresis") == 5.0
    assert value(vacuum, "angle random walk") == 0.2
    assert value(vacuum, "scale factor") == "tests give it only in condition air"
    assert value(air, "vacuum offset") == value(air, "hysteresis", "y") == "no test of the campaign gives it"


def test_output_has_the_units_of_the_equation_and_a_column_a_sensor() -> None:
    output = TABLES[1]
    units = {line.name: line.unit for line in output.lines}
    assert [units[name] for name in ("B", "m1", "m2", "m3", "b_cons")] == ["V", "V/V", "V/V^2", "V/V^3", "deg/s"]
    assert (value(output, "m2"), value(output, "b_cons")) == (4.0, 0.01)
    assert (value(output, "M from x"), value(output, "M from x", "y")) == (0.6, 0.7)
    assert [value(output, name) for name in ("T_ref", "V_nominal", "slope")] == [25.7, -0.5042, 0.0264]
    assert value(output, "T_ref", "y") == "the chain of the campaign has no temperature channel"
    rows = output.to_dict()["rows"]
    assert len(rows) == len(output.lines) * 2
    assert {"name": "M from x", "axis": "y", "value": 0.7, "test": "table"}.items() <= rows[11].items()


def test_what_a_condition_takes_from_another_one_is_there_and_marked() -> None:
    """The model in vacuum takes the scale factor made in air; misalignment and bias of the table it does not take."""
    air, _, vacuum, output = output_tables({"suite": SENSOR}, DECIDED, ROWS)
    lines = {line.name: line for line in (*vacuum.lines, *output.lines)}
    assert value(vacuum, "scale factor") == 0.5
    assert (value(vacuum, "scale factor error"), value(output, "M from x")) == (0.6, 0.6)
    assert lines["scale factor"].taken == lines["M from x"].taken == {"table": "air"}
    assert value(output, "M from x", "y") == "tests give it only in condition air"
    assert value(output, "b_cons") == "tests give it only in condition air"
    assert lines["hysteresis"].taken == {}
    assert all(not line.taken for line in air.lines)
    found = [row for row in vacuum.to_dict()["rows"] if row["taken_from"]]
    assert {(row["name"], row["taken_from"]) for row in found} == {
        ("scale factor", "air"), ("scale factor error", "air"),
    }  # fmt: skip
    shown: list[OutputTable[Any]] = [vacuum]
    assert "taken from air" in tables_text(shown)


def test_a_condition_with_a_test_of_its_own_takes_none() -> None:
    own = step("table_vacuum", "fit", "vacuum", vacuum=["scale_factor"])
    rows = [*ROWS, row("table_vacuum", "scale_factor", "x", 0.51, "V/(deg/s)")]
    *_, vacuum, _ = output_tables({"suite": SENSOR}, [*DECIDED, own], rows)
    assert value(vacuum, "scale factor") == 0.51


def test_figures_are_those_of_the_test_that_the_model_takes_them_from() -> None:
    """A test that is reported only gives what no other does, though it comes first; one of the model is preferred."""
    first = step("first", "fit", "air")
    rows = [row("first", name, "x", 99.0, unit) for name, unit in (("scale_factor_error", "%"), ("bias", "deg/s"))]
    air, output, *_ = output_tables({"suite": SENSOR}, [first, *STEPS], [*rows, *ROWS])
    assert (value(air, "scale factor error"), value(output, "M from x")) == (0.6, 0.6)


def test_readings_in_units_of_the_rate_have_b_cons_and_run_to_run_too() -> None:
    """Without volts there is no scale factor in V/(deg/s); without a thermal test the rate table says run to run."""
    rows = [one for one in ROWS if one["quantity"] not in ("scale_factor", "hysteresis", "residual_bias")]
    rows = [one for one in rows if (one["test"], one["quantity"]) != ("air", "scatter_run")]
    air, output, *_ = output_tables({"suite": SENSOR}, STEPS, rows)
    assert (value(output, "b_cons"), value(air, "bias run to run")) == (0.01, 8.0)


def test_sensitivity_to_the_supply_and_a_time_of_all_axes_are_there() -> None:
    steps = [*STEPS, step("supply", "fit", "vacuum", vacuum=["sensitivity", "warm_up"])]
    rows = [row("supply", "bias_supply", "x", 0.017, "deg/s/V"), row("supply", "warm_up_time", "", 200.0, "s", 1)]
    *_, vacuum, _ = output_tables({"suite": SENSOR}, steps, [*ROWS, *rows])
    assert value(vacuum, "bias by supply") == 0.017
    assert value(vacuum, "time constant 1") == value(vacuum, "time constant 1", "y") == 200.0


def test_other_sensors_have_no_part_in_it() -> None:
    steps = [*STEPS, step("faces", "fit", "upright", sensor="head")]
    rows = [row("faces", quantity, "x", 9.0, "m/s2") for quantity in ("bias", "scale_factor")]
    both = row("table", "bias", "x", 9.0, "m/s2") | {"sensor": "accelerometer"}
    tables = output_tables({"head": SENSOR | {"kind": "accelerometer"}, "suite": SENSOR}, steps, [both, *rows, *ROWS])
    assert [one.condition for one in tables] == ["air", "air", "vacuum", "vacuum"]
    assert value(tables[1], "b_cons") == 0.01


def test_a_campaign_without_a_gyro_has_none() -> None:
    assert output_tables({"head": SENSOR | {"kind": "accelerometer"}}, [], []) == []


def test_a_calibrated_thermometer_takes_the_place_of_what_is_stated() -> None:
    assert value(TABLES[0], "thermometer nominal") == -0.5042
    found = row("air", "thermometer_voltage", "x", -0.51, "V"), row("air", "thermometer_slope", "x", 0.027, "V/degC")
    summary, output, *_ = output_tables({"suite": SENSOR}, STEPS, [*ROWS, *found])
    assert value(summary, "thermometer nominal") == value(output, "V_nominal") == -0.51
    assert (value(output, "slope"), value(output, "slope", "y")) == (0.027, 0.0264)
    said = "stated in campaign.toml, without uncertainty"
    assert dict(output.reasons)[said] == ["T_ref (x)", "slope (y)"]
    once = row("air", "thermometer_voltage", "x", None, "V")
    assert value(output_tables({"suite": SENSOR}, STEPS, [*ROWS, once])[1], "V_nominal") == -0.5042

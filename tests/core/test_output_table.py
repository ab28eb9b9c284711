"""The output table: which rows it takes, and in which order."""

from __future__ import annotations

from typing import Any

from inertialcal.core.show.rows import note, output_rows, quantity_name
from written_rows import fields


def row(test: str, quantity: str, axis: str, condition: str = "") -> dict[str, Any]:
    name, _, power = quantity.partition("_voltage_")
    own = {"quantity": f"{name}_voltage", "power": int(power)} if power else {"quantity": quantity}
    return fields(condition) | {"test": test, "axis": axis} | own


STEPS = [
    {"test": "air", "use": "fit", "after": []},
    {"test": "table", "use": "fit", "after": ["air"], "procedure": "rate_table"},
    {"test": "table_check", "use": "hold_out", "after": ["air"], "procedure": "rate_table"},
]
ROWS = [
    row("air", "bias_voltage_0", "y", "ambient"), row("air", "bias_voltage_1", "x", "ambient"),
    row("air", "bias_voltage_0", "x", "ambient"), row("air", "bias_voltage_0", "x", "as_published"),
    row("air", "bias", "x", "20 degC"), row("air", "bias", "x", "ambient"), row("table", "bias", "x"),
    row("table", "misalignment", "xz"), row("table", "scale_factor", "x"), row("table_check", "bias", "x"),
    row("vacuum", "vacuum_offset", "x", "vacuum"), row("vacuum", "vacuum_offset", "x", "60 degC"),
    row("table_check", "residual_bias", "x"),
    row("air_check", "residual_bias", "x", "ambient"), row("noise", "angle_random_walk", "y"),
    row("noise", "rate_random_walk", "y"), row("model", "bias", "x"),
]  # fmt: skip


def test_it_goes_sensor_by_sensor_from_polynomial_to_noise() -> None:
    assert [(one["axis"], one["test"], quantity_name(one)) for one in output_rows(ROWS, STEPS)] == [
        ("x", "air", "bias_voltage_0"),
        ("x", "air", "bias_voltage_1"),
        ("x", "table", "bias"),
        ("x", "table", "scale_factor"),
        ("xz", "table", "misalignment"),
        ("x", "vacuum", "vacuum_offset"),
        ("x", "air_check", "residual_bias"),
        ("y", "air", "bias_voltage_0"),
        ("y", "noise", "angle_random_walk"),
    ]


def test_without_a_rate_table_after_a_thermal_test_there_is_none() -> None:
    assert output_rows(ROWS, STEPS[:1]) == []
    assert output_rows(ROWS, [{"test": "table", "use": "fit"}]) == []


def test_the_bias_is_told_to_be_what_is_left() -> None:
    assert [note(row("table", name, "x")) for name in ("bias", "scale_factor")] == [
        "residual, on the rate table",
        "",
    ]

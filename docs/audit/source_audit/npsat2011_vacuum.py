"""Temperature channel, vacuum, pressure and start-up."""

from __future__ import annotations

import math

from .figures import Figure, Section, figure
from .npsat2011_fits import DOC
from .npsat2011_thermal import Told
from .printed import Recomputed, printed, recompute
from .table_files import Row, by, table

REQUIRED = 0.05  # error of rate, as a part of it


def vacuum_sections(told: Told) -> tuple[Section, ...]:
    """Return the temperature channel, Table 6, and the statements on vacuum and start-up."""
    return (_channel(told), _vacuum(told), _pressure(told), _start_up(told))


def _channel(told: Told) -> Section:
    nominal = {r["axis"]: printed(r["v_nominal_volt"]) for r in table(DOC, "table02_nominal_voltage")}
    figures = [
        figure("gain old", "gain, 120 and 10 kohm", told["gain_old"], Recomputed(120.0 / 10.0 + 1.0)),
        figure("gain new", "gain, 70 and 10 kohm", told["gain_new"], Recomputed(70.0 / 10.0 + 1.0)),
        figure(
            "slope", "slope", told["slope_amplified"], recompute(lambda s: 8.0 * s, told["slope_at_sensor"]), "V/degC"
        ),
        figure("step", "converter step", told["converter_step"], Recomputed(5e3 / 4095.0), "mV"),
    ]
    for name, volts in (("old_range_low", -2.5), ("old_range_high", 2.5)):
        found = recompute(
            lambda v, s, volts=volts: 25.0 + (volts - v) / (13.0 * s), told["v_nominal_old_x"], told["slope_at_sensor"]
        )
        figures.append(figure(name, f"{name.replace('_', ' ')}, gain 13", told[name], found, "degC"))
    for axis in "XZ":
        found = recompute(lambda v: 8.0 / 13.0 * v, told[f"v_nominal_old_{axis.lower()}"])
        figures.append(
            figure(
                f"nominal {axis}",
                f"V_n, {axis}, gain 8",
                nominal[axis],
                found,
                "V",
                why="33 to 34 mV, 10 degC, at an unchanged sensor",
            )
        )
    for axis in "XYZ":
        at_sensor = recompute(lambda v: v / 8.0, nominal[axis])
        for side, limit in (("at least", told["v_data_sheet_low"]), ("at most", told["v_data_sheet_high"])):
            shown = printed(f"{at_sensor.value:.4f}")
            held = figure(
                f"limit {side} {axis}",
                f"V_n/8, {axis}, {side} {limit.text} V",
                shown,
                Recomputed(limit.value),
                "V",
                relation="at least" if side == "at least" else "at most",
            )
            figures.append(held)
    flat = recompute(lambda a, b: (b - a) / 60.0, told["flat_start"], told["flat_end"])
    figures.append(figure("flat", "flat region", told["flat_region"], flat, "h"))
    how = (
        "Gain = R2/R1 + 1; slope = 8 x 0.0033 V/degC; step = 5 V/4095. Old range: 2.5 V either side of V_n "
        "= -0.3724 V at "
        "25 degC, gain 13. V_n of the sensors that were not replaced: gain 13 to gain 8. V_n/8 within the data sheet."
    )
    return Section("channel", "Temperature channel and converter", how, tuple(figures))


def _vacuum(told: Told) -> Section:
    vacuum = by(table(DOC, "table08_poly_vacuum_degc_dps"), "axis", "coefficient")
    ambient = by(table(DOC, "table04_poly_ground_degc_dps"), "axis", "coefficient")
    figures: list[Figure] = []
    for axis in "XYZ":
        found = recompute(lambda a, b: a - b, printed(vacuum[axis, "B"]["value"]), printed(ambient[axis, "B"]["value"]))
        figures.append(
            figure(
                f"shift {axis}", f"shift of B in vacuum, {axis}", told[f"vacuum_shift_{axis.lower()}"], found, "deg/s"
            )
        )
    ramp = by(table(DOC, "appendix_b1_thermal_tests"), "test_id")["FL2-1a",]
    for name, column in (("high", "temperature_start_degc"), ("low", "temperature_end_degc")):
        found = recompute(lambda t: t, printed(ramp[column]))
        figures.append(
            figure(
                f"ramp {name}",
                f"vacuum ramp FL2-1a, {name} end",
                told[f"vacuum_ramp_{name}"],
                found,
                "degC",
                why="the cubic is extrapolated there" if name == "low" else "",
            )
        )
    sheet = recompute(lambda b: b, told["appendix_a_bias_z"])
    figures.append(figure("bias Z", "bias over temperature, Z", told["manufacturer_bias_z"], sheet, "deg/s"))
    how = "Shift: Table 8 less Table 4. Ramp: the range of the run in Appendix B. Bias over temperature: Appendix A."
    return Section("vacuum", "Text: vacuum", how, tuple(figures))


def _pressure(told: Told) -> Section:
    rows = table(DOC, "table06_pressure_bias")
    std = {r["axis"]: float(r["std"]) for r in table(DOC, "residual_bias") if r["stage"] == "fit_residual_ambient"}
    figures: list[Figure] = [
        figure(
            "regions",
            "regions named in the text",
            told["pressure_regions"],
            Recomputed(float(len(rows) // 3)),
            why="Table 6 has seven rows",
        )
    ]
    figures += [_sem(row, std[row["axis"]]) for row in rows]
    for axis in "XYZ":
        low = [row for row in rows if row["axis"] == axis and float(row["pressure_high_torr"]) <= 1e-4]
        figures += [_constant(axis, one, low[0]) for one in low[1:]]
    how = (
        "STDV of the mean: the deviation of the ambient fit over the root of N, with 20 % and the 99.9 % "
        "spread of N readings. "
        "Constant below 1e-4 Torr, as the text has it: each row against the first, with 3.3 of their STDV."
    )
    return Section("table 6", "Table 6, bias over pressure", how, tuple(figures))


def _sem(row: Row, std: float) -> Figure:
    n = float(row["n_total"])
    found = std / math.sqrt(n)
    where = f"{row['pressure_low_torr']} Torr, {row['axis']}"
    return figure(
        f"sem {where}",
        f"STDV of the mean, {where}",
        row["sem_bias_volt"],
        Recomputed(found, found * (0.2 + 3.3 / math.sqrt(2.0 * (n - 1.0)))),
        "V",
    )


def _constant(axis: str, row: Row, first: Row) -> Figure:
    random = 3.3 * math.hypot(float(row["sem_bias_volt"]), float(first["sem_bias_volt"]))
    found = recompute(lambda b: b, printed(first["mean_bias_volt"]))
    where = f"from {row['pressure_low_torr']} Torr, {axis}"
    return figure(
        f"constant {where}",
        f"bias, {where}",
        row["mean_bias_volt"],
        Recomputed(found.value, found.tolerance + random),
        "V",
        why="not constant, by many times its scatter",
    )


def _start_up(told: Told) -> Section:
    stages = by(table(DOC, "residual_bias"), "stage", "axis")
    figures: list[Figure] = []
    for axis in "XYZ":
        a = axis.lower()
        vacuum = printed(stages["transient_vacuum_compensated", axis]["mean"])
        ambient = printed(stages["transient_ambient_compensated", axis]["mean"])
        transient = told[f"transient_{a}"]
        figures += [
            figure(
                f"vacuum {axis}",
                f"resolution from the vacuum transient, {axis}",
                told[f"resolution_vacuum_{a}"],
                recompute(lambda t: t / REQUIRED, vacuum),
                "deg/s",
            ),
            figure(
                f"ambient {axis}",
                f"resolution from the ambient transient, {axis}",
                told[f"resolution_ambient_{a}"],
                recompute(lambda t: t / REQUIRED, transient),
                "deg/s",
            ),
            figure(
                f"transient {axis}",
                f"ambient transient, {axis}",
                transient,
                recompute(lambda t: t, ambient),
                "deg/s",
                why="a change before compensation here, a bias after it there",
            ),
        ]
    how = (
        "Resolution: transient over the required 5 %. Transient: the one after compensation that another section gives."
    )
    return Section("start-up", "Text: start-up", how, tuple(figures))

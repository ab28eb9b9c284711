"""Tables 2 and 19 to 22: what Table 2 holds, the absolute bias, and the older ground model."""

from __future__ import annotations

import numpy as np

from inertialcal.statistics.least_squares import fit

from .figures import Figure, Section, Text, Variant, figure
from .printed import Printed, Recomputed, printed, recompute
from .sams1996_means import DOC, from_means, half_sum, means, place, values
from .table_files import table


def bias_sections() -> tuple[Section, ...]:
    """Return Tables 2, 19, 20, 21 and 22, and the sign of Y between tables."""
    return (_table2(), _table2_lines(), _table19(), _signs(), _table20(), _old_model())


def _table2_pairs() -> dict[tuple[str, str], tuple[Printed, Printed]]:
    found: dict[tuple[str, str], dict[str, Printed]] = {}
    for row in table(DOC, "table02_scale_factor"):
        found.setdefault((row["axis"], row["time_id"]), {})[row["orientation"]] = printed(
            row["scale_factor_volt_per_g"]
        )
    return {key: (pair["forward"], pair["reverse"]) for key, pair in found.items()}


def _absolute() -> dict[tuple[str, str, str], Printed]:
    return {(r["axis"], r["time_id"], r["kind"]): printed(r["bias_ug"]) for r in table(DOC, "table19_absolute_bias")}


def _table2() -> Section:
    absolute = _absolute()
    figures = []
    for (axis, time), pair in _table2_pairs().items():
        predicted = absolute.get((axis, time, "predicted"))
        if predicted is not None:
            middle = recompute(half_sum, *pair)
            shown = printed(f"{abs(middle.value):.3f}")
            variant = Variant("the predicted bias of Table 19, in ug", recompute(abs, predicted), "unit")
            scale = recompute(lambda s, axis=axis: s / 10.0 if axis == "Z" else s, _table2_pairs()["X", time][0])
            scale = Recomputed(scale.value, 0.02 * scale.value)
            figures.append(
                figure(f"{axis} {time}", f"{axis} time {time}, mean size", shown, scale, "V/g", variants=(variant,))
            )
    how = (
        "X is a scale factor: the sensors are alike, so Y (same gain) should lie within 2 % of it and Z (a "
        "tenth of the "
        "gain) within 2 % of a tenth."
    )
    return Section("table 2 unit", "Table 2, headed scale factor in V/g", how, tuple(figures))


def _table2_lines() -> Section:
    temperature = {
        (r["axis"], r["time_id"], r["orientation"]): printed(r["temperature_degc"])
        for r in table(DOC, "table01_temperature")
    }
    shown = {
        (r["axis"], r["time_id"], r["orientation"]): printed(r["scale_factor_volt_per_g"])
        for r in table(DOC, "table02_scale_factor")
    }
    suspects = [("Y", "1", "reverse"), ("Y", "1", "forward"), ("Z", "3", "reverse")]
    figures = []
    for suspect in suspects:
        others = [key for key in shown if key[0] == suspect[0] and key not in suspects]
        inputs = [temperature[suspect], *(temperature[k] for k in others), *(shown[k] for k in others)]
        name = f"{suspect[0]} {suspect[1]} {suspect[2]}"
        place_ = f"{suspect[0]} time {suspect[1]} {suspect[2]}"
        figures.append(figure(name, place_, shown[suspect], _line_with_scatter(inputs, len(others))))
    how = (
        "Straight line over temperature (Table 1) through the other entries of the axis; the tolerance adds three "
        "times their scatter about it."
    )
    return Section("table 2 line", "Table 2, entries off the line of their axis", how, tuple(figures))


def _line_with_scatter(inputs: list[Printed], n: int) -> Recomputed:
    def predicted(at: float, *numbers: float) -> float:
        t, y = np.array(numbers[:n]), np.array(numbers[n:])
        line = fit(np.column_stack([np.ones(n), t - t.mean()]), y)
        return float(line.coefficients[0] + line.coefficients[1] * (at - t.mean()))

    t, y = (np.array([one.value for one in part]) for part in (inputs[1 : n + 1], inputs[n + 1 :]))
    scatter = fit(np.column_stack([np.ones(n), t - t.mean()]), y).scatter
    found = recompute(predicted, *inputs)
    return Recomputed(found.value, found.tolerance + 3.0 * scatter)


def _table19() -> Section:
    absolute, pairs = _absolute(), _table2_pairs()
    filtered = values("table14_bias_error_filtered", "bias error")
    direct = values("table06_bias_semiprocessed", "bias")
    figures: list[Figure] = []
    for (axis, time, kind), shown in absolute.items():
        where = f"{kind}, {axis} time {time}"
        predicted = absolute[axis, time, "predicted"]
        if kind == "predicted":
            figures.append(figure(where, where, shown, recompute(half_sum, *pairs[axis, time]), "ug"))
        elif kind == "measured":
            figures.append(figure(where, where, shown, recompute(lambda b: b, direct[axis, time]), "ug"))
        else:
            added = recompute(lambda p, e: p + e, predicted, filtered[axis, time])
            taken = recompute(lambda p, e: p - e, predicted, filtered[axis, time])
            turned = Variant("predicted minus Table 14, the opposite rule of the other axis", taken, "sign")
            figures.append(figure(where, where, shown, added, "ug", variants=(turned,)))
    how = (
        "Predicted: mean of the two attitudes of Table 2. Corrected: predicted plus the bias error of Table 14. "
        "Measured: the bias of Table 6."
    )
    return Section("table 19", "Table 19, absolute bias", how, tuple(figures))


def _signs() -> Section:
    reference = values("table22_gravity_old_model", "gravity")
    figures = []
    for name, label in (
        ("table04_gravity_semiprocessed", "Table 4"),
        ("table08_gravity_unfiltered", "Table 8"),
        ("table12_gravity_filtered", "Table 12"),
    ):
        for time in ("2", "3"):
            shown = values(name, "gravity")["Y", time]
            sign = Recomputed(float(np.sign(reference["Y", "filtered", time].value)))
            text = f"{int(np.sign(shown.value))}"
            figures.append(figure(f"{label} {time}", f"{label}, Y time {time}, sign", printed(text, count=True), sign))
    how = "The sign of the same acceleration in Table 22."
    return Section("sign of Y", "Sign of the acceleration along Y", how, tuple(figures))


def _table20() -> Section:
    bias = values("table21_bias_error_old_model", "bias error")
    gravity = values("table22_gravity_old_model", "gravity")
    pairs = means("table20_mean_old_model")
    figures: list[Figure | Text] = [
        Text(
            f"heading {i}",
            f"heading of column {i}",
            row["printed_heading"],
            f"Time {row['time_id']} {row['orientation']}",
        )
        for i, row in enumerate(table(DOC, "table20_mean_old_model")[:6], start=1)
    ]
    for filtered, other in (("filtered", "unfiltered"), ("unfiltered", "filtered")):
        key = ("Y", filtered, "3")
        swapped = Recomputed(bias["Y", other, "3"].value + gravity["Y", other, "3"].value, 0.001)
        exchanged = Variant(f"the {other} mean, the two are exchanged", swapped, "misprint")
        forward, reverse = pairs[key]
        plus = recompute(lambda b, g: b + g, bias[key], gravity[key])
        minus = recompute(lambda b, g: b - g, bias[key], gravity[key])
        figures += [
            figure(f"forward {filtered}", f"forward, {place(key)}", forward, plus, "ug", variants=(exchanged,)),
            figure(f"reverse {filtered}", f"reverse, {place(key)}", reverse, minus, "ug"),
        ]
    figures.append(
        Text("last table", "Tables 20 to 23, last table", "Table 23", "Table 22", why="there is no Table 23")
    )
    how = "Headings: the three times in turn. Y time 3: B + G and B - G with B of Table 21 and G of Table 22."
    return Section("table 20", "Table 20, means with the older ground model", how, tuple(figures))


def _old_model() -> Section:
    why = dict.fromkeys(
        (("Y", "filtered", "3"), ("Y", "unfiltered", "3")), "its means in Table 20 do not hold, see there"
    )
    return Section(
        "tables 21-22",
        "Tables 21 and 22, older ground model",
        "Half sum and half difference of the means of Table 20.",
        from_means("table21_bias_error_old_model", "bias error", "table20_mean_old_model", why=why)
        + from_means("table22_gravity_old_model", "gravity", "table20_mean_old_model", why=why),
    )

"""Figures of the text: control error, scatter of the bias, t intervals, age of the calibration."""

from __future__ import annotations

import math

from inertialcal.statistics.intervals import t_quantile

from .figures import Section, Variant, figure
from .printed import Input, Printed, printed, recompute
from .sams1996_means import DOC, values
from .table_files import stated, table


def text_sections() -> tuple[Section, ...]:
    """Return the statements of the text."""
    return (_control_error(), _bias_scatter(), _t_intervals(), _conclusions())


def _mean_size(*errors: float) -> float:
    return sum(abs(e) for e in errors) / len(errors)


def _std(*numbers: float) -> float:
    middle = sum(numbers) / len(numbers)
    return math.sqrt(sum((x - middle) ** 2 for x in numbers) / (len(numbers) - 1))


def _with_time_1(kind: str, axis: str, filtered: str) -> list[Printed]:
    """Return times 1 to 3: the text takes the first from Tables 17 and 18."""
    first = {"error": "table17_error_alignment", "bias error": "table18_bias_error_alignment"}[kind]
    rest = {
        ("error", "filtered"): "table13_error_filtered",
        ("error", "unfiltered"): "table09_error_unfiltered",
        ("bias error", "filtered"): "table14_bias_error_filtered",
        ("bias error", "unfiltered"): "table10_bias_error_unfiltered",
    }[kind, filtered]
    later = values(rest, kind)
    sign = -1 if kind == "bias error" and filtered == "unfiltered" else 1  # Table 10 has Y turned
    turned = [printed(_negated(later[axis, time].text)) if sign < 0 else later[axis, time] for time in ("2", "3")]
    return [values(first, kind)[axis, filtered, "1"], *turned]


def _negated(text: str) -> str:
    return text[1:] if text.startswith("-") else f"-{text}"


def _control_error() -> Section:
    told = stated(DOC)
    largest = [one for key, one in values("table17_error_alignment", "error").items() if key[2] == "1"]
    figures = (
        figure(
            "mean filtered",
            "mean size, filtered",
            told["control_mean_filtered"],
            recompute(_mean_size, *_with_time_1("error", "X", "filtered")),
            "ug",
        ),
        figure(
            "mean unfiltered",
            "mean size, unfiltered",
            told["control_mean_unfiltered"],
            recompute(_mean_size, *_with_time_1("error", "X", "unfiltered")),
            "ug",
        ),
        figure(
            "largest", "largest", told["largest_control_error"], recompute(lambda *e: max(map(abs, e)), *largest), "ug"
        ),
        figure(
            "realistic",
            "realistic",
            told["realistic_control_error"],
            recompute(lambda e: e, values("table13_error_filtered", "error")["X", "2"]),
            "ug",
        ),
    )
    how = (
        "Mean of the sizes at times 1 (Table 17), 2 and 3 (Tables 13 and 9); the largest of Table 17; Table 13, time 2."
    )
    return Section("control error", "Text: control error", how, figures)


def _bias_scatter() -> Section:
    told, figures = stated(DOC), []
    for filtered in ("filtered", "unfiltered"):
        numbers = _with_time_1("bias error", "Y", filtered)
        all_times, two = told[f"bias_y_std_{filtered}"], told[f"bias_y_std_{filtered}_times_2_3"]
        figures += [
            figure(filtered, f"{filtered}, three times", all_times, recompute(_std, *numbers), "ug"),
            figure(f"{filtered} 2 3", f"{filtered}, times 2 and 3", two, recompute(_std, *numbers[1:]), "ug"),
        ]
    how = (
        "Standard deviation of the Y bias error: Table 18 for time 1, Tables 14 and 10 for the others, one "
        "sign for all."
    )
    return Section("scatter of bias", "Text: scatter of the Y bias", how, tuple(figures))


def _t_intervals() -> Section:
    told = stated(DOC)
    n = int(told["subset_count"].value)

    def widened(subsets: int) -> float:
        return t_quantile(subsets - 1, 0.995) / t_quantile(subsets - 1, 0.975)

    figures = []
    for side in ("forward", "reverse"):
        narrow, wide = told[f"t95_{side}"], told[f"t99_{side}"]
        fewer = Variant("what seven subsets give", recompute(lambda h: h * widened(7), narrow))
        found = recompute(lambda h: h * widened(n), narrow)
        figures.append(figure(f"t99 {side}", f"99 %, {side}", wide, found, "ug", variants=(fewer,)))
    for p in ("95", "99"):
        both: list[Input] = [told[f"t{p}_forward"], told[f"t{p}_reverse"]]
        figures.append(
            figure(f"sum {p}", f"sum, {p} %", told[f"accuracy_{p}"], recompute(lambda a, b: a + b, *both), "ug")
        )
    how = (
        "99 % from the 95 % half width by the ratio of the t quantiles of ten subsets (9 degrees of freedom); the "
        "accuracy as the plain sum of the two half widths."
    )
    return Section("t intervals", "Text: t intervals", how, tuple(figures))


def improvements() -> tuple[list[float], float]:
    """Return by how much the new model has less bias error on Y and Z at times 2 and 3, and old control is nearer 0."""
    old, new = values("table21_bias_error_old_model", "bias error"), values("table14_bias_error_filtered", "bias error")
    gains = [
        abs(old[axis, "filtered", time].value) - abs(new[axis, time].value) for axis in "YZ" for time in ("2", "3")
    ]
    first = [abs(old[axis, "filtered", "1"].value) - abs(new[axis, "1"].value) for axis in "YZ"]
    return gains, min(first)


def _conclusions() -> Section:
    told = stated(DOC)
    gains, _ = improvements()
    temperatures = [printed(r["temperature_degc"]) for r in table(DOC, "table01_temperature") if r["axis"] == "Y"]
    warmest, coldest = max(temperatures, key=lambda t: t.value), min(temperatures, key=lambda t: t.value)
    old = [one for key, one in values("table22_gravity_old_model", "gravity").items() if key[:2] == ("X", "filtered")]
    new = _with_time_1("error", "X", "filtered")
    figures = (
        figure(
            "accuracy",
            "accuracy, conclusions",
            told["conclusion_accuracy"],
            recompute(lambda e: e, told["realistic_control_error"]),
            "ug",
        ),
        figure(
            "gain least",
            "new model better by at least",
            told["new_model_improvement_least"],
            recompute(lambda g: g, printed(f"{min(gains):.3f}")),
            "ug",
        ),
        figure(
            "gain most",
            "new model better by at most",
            told["new_model_improvement_most"],
            recompute(lambda g: g, printed(f"{max(gains):.3f}")),
            "ug",
        ),
        figure(
            "old control axis",
            "control axis of the old model nearer to zero by",
            told["old_control_axis_improvement"],
            recompute(lambda *e: _mean_size(*e[:3]) - _mean_size(*e[3:]), *new, *old),
            "ug",
        ),
        figure(
            "Y temperature",
            "difference of the Y temperature",
            told["temperature_difference_y"],
            recompute(lambda a, b: a - b, warmest, coldest),
            "degC",
            why="that is the largest difference in Table 1",
        ),
    )
    how = (
        "Accuracy: the control error that the text calls realistic. Improvement: sizes of Table 21 less "
        "Table 14, filtered, "
        "times 2 and 3. Control axis: mean sizes as above and of Table 22. Temperature: Table 1."
    )
    return Section("conclusions", "Text: conclusions", how, figures)

"""Rate tests: Tables 9 to 11 refitted against Appendices E to J and Table 12, and the reports in themselves.

Percent errors are (applied - measured) / applied, so a row of Tables 9 to 11 stands for 0.5 rate (1 - error / 100) V.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache

import numpy as np
from scipy import stats

from inertialcal.statistics.least_squares import Fit, fit

from .figures import Figure, Section, Text, figure
from .printed import Recomputed, printed, recompute
from .table_files import EXAMPLE, Row, by, read, table

DOC = "npsat2011"
FILES = {"X": ("table10_x", "Table 10"), "Y": ("table11_y", "Table 11"), "Z": ("table09_z", "Table 9")}
IDEAL = 0.5  # V/(deg/s)
VOLTS = {"half of (in volts)": IDEAL}
OWN = {
    ("minus_ref", "X"): "E1",
    ("minus_ref", "Y"): "F1",
    ("minus_ref", "Z"): "G1",
    ("no_ref", "X"): "H1",
    ("no_ref", "Y"): "I1",
    ("no_ref", "Z"): "J1",
}


def rows_of(axis: str, column: str, sample: str = "", rates: tuple[str, ...] = ()) -> list[Row]:
    """Return the rows of Tables 9 to 11 that have a figure, of one sample set or both, of all rates or some."""
    return [
        row
        for row in read(EXAMPLE / f"{FILES[axis][0]}.csv")
        if row[column] and sample in ("", row["set"]) and (not rates or row["rate_dps"].lstrip("-") in rates)
    ]


def line(rates: np.ndarray, errors: np.ndarray) -> Fit:
    """Return the straight line of volts over rate."""
    volts = IDEAL * rates * (1.0 - errors / 100.0)
    return fit(np.column_stack([np.ones(rates.size), rates]), volts)


def refitted(rows: list[Row], column: str) -> dict[str, Recomputed]:
    """Return slope, intercept and their standard errors in volts, with the rounding of the percent column."""
    rates = np.array([float(row["rate_dps"]) for row in rows])
    errors = [printed(row[column]) for row in rows]

    @cache
    def refit(*numbers: float) -> Fit:
        return line(rates, np.array(numbers))

    def part(take: Callable[[Fit], float]) -> Recomputed:
        return recompute(lambda *e: take(refit(*e)), *errors)

    return {
        "intercept": part(lambda f: f.coefficients[0]),
        "slope": part(lambda f: f.coefficients[1]),
        "intercept error": part(lambda f: f.u[0]),
        "slope error": part(lambda f: f.u[1]),
    }


def reports() -> dict[str, Row]:
    """Return the fit reports of Appendices E to J by name."""
    return {row["appendix"]: row for row in table(DOC, "appendix_ej_fit_reports")}


def fit_sections() -> tuple[Section, ...]:
    """Return Appendices E to J."""
    return (_from_tables(), *_inside_reports(), _missing_reports())


def _from_tables() -> Section:
    figures: list[Figure | Text] = []
    for (column, axis), name in OWN.items():
        report, rows = reports()[name], rows_of(axis, f"error_{column}_percent")
        found = refitted(rows, f"error_{column}_percent")
        square = sum(float(row["rate_dps"]) ** 2 for row in rows)
        slope = printed(report["slope_volt_per_dps"])
        figures += [
            figure(f"{name} N", f"N, {name}", printed(report["n_points"], count=True), Recomputed(float(len(rows)))),
            figure(f"{name} slope", f"slope, {name}", slope, found["slope"], "V/(deg/s)"),
            figure(f"{name} intercept", f"intercept, {name}", report["intercept_volt"], found["intercept"], "V"),
            figure(
                f"{name} model square",
                f"model sum of squares, {name}",
                report["anova_model_ss"],
                Recomputed(found["slope"].value ** 2 * square, 2.0 * found["slope"].tolerance * square),
                "V^2",
            ),
        ]
    how = (
        "Straight line through the volts of Table 10 (X: E1, H1), Table 11 (Y: F1, I1) and Table 9 (Z: G1, "
        "J1), both sample "
        "sets; N is the number of rows. That they follow shows the sign of the percent errors: (applied - "
        "measured) / applied."
    )
    return Section("fits", "Appendices E to J from Tables 9 to 11", how, tuple(figures))


def _inside_reports() -> tuple[Section, ...]:
    told = {name: row for name, row in reports().items() if row["n_points"]}
    figures = [one for name, row in told.items() for one in _report(name, row, told)]
    how = (
        "Within each report: error mean square = error sum over its degrees of freedom; total = model + "
        "error; F = model over "
        "error mean square; r and adjusted R-square from the sums; p from F; slope = its standard error "
        "times the root of model over error mean square; "
        "standard error of the intercept = that of the slope times the root mean square of the inputs, which the other "
        "reports of the same test give."
    )
    return (Section("reports", "Appendices E to J, each report in itself", how, tuple(figures), identity=True),)


def _report(name: str, row: Row, told: dict[str, Row]) -> list[Figure]:
    model, error = printed(row["anova_model_ss"]), printed(row["anova_error_ms"])
    dof, n = float(row["degrees_of_freedom"]), float(row["n_points"])
    F = printed(row["anova_f"])
    sign = math.copysign(1.0, float(row["slope_volt_per_dps"]))

    def ratio(m: float, e: float) -> float:
        return m / (m + e * dof)

    checks: list[tuple[str, str, Recomputed]] = [
        ("error mean square", row["anova_error_ms"], recompute(lambda s: s / dof, printed(row["anova_error_ss"]))),
        ("total", row["anova_total_ss"], recompute(lambda m, e: m + e * dof, model, error)),
        ("F", row["anova_f"], recompute(lambda m, e: m / e, model, error)),
        ("r", row["pearson_r"], recompute(lambda m, e: sign * math.sqrt(ratio(m, e)), model, error)),
        (
            "adjusted R-square",
            row["adj_r_square"],
            recompute(lambda m, e: 1.0 - (1.0 - ratio(m, e)) * (n - 1.0) / dof, model, error),
        ),
        ("slope", row["slope_volt_per_dps"], slope_of(row)),
        ("intercept error", row["intercept_se_volt"], _intercept_error(name, row, told)),
    ]
    if float(row["anova_p"]) > 0.0:
        checks.append(("p", row["anova_p"], recompute(lambda f: float(stats.f.sf(f, 1.0, dof)), F)))
    return [figure(f"{name} {what}", f"{what}, {name}", text, found) for what, text, found in checks]


def _intercept_error(name: str, row: Row, told: dict[str, Row]) -> Recomputed:
    """Return slope error times root mean square input: from the rates, or from the reports of the same test."""
    slope_error = printed(row["slope_se_volt_per_dps"])
    if name in OWN.values():
        rates = [float(r["rate_dps"]) for r in rows_of(row["test_axis"], f"error_{row['data_set']}_percent")]
        mean_square = sum(r * r for r in rates) / float(row["n_points"])
        return recompute(lambda s: s * math.sqrt(mean_square), slope_error)
    others = [
        (printed(one["intercept_se_volt"]), printed(one["slope_se_volt_per_dps"]))
        for other, one in told.items()
        if other != name and one["test_axis"] == row["test_axis"] and one["sensed_axis"] != one["test_axis"]
    ]
    ratios = sorted(i.value / s.value for i, s in others)
    half = 0.5 * (ratios[-1] - ratios[0]) + 1e-5 * ratios[0]
    return recompute(lambda s, q: s * q, slope_error, Recomputed(0.5 * (ratios[0] + ratios[-1]), half))


def slope_of(row: Row) -> Recomputed:
    """Return the slope by its standard error and the mean squares of its report [V/(deg/s)]."""
    sign = math.copysign(1.0, float(row["slope_volt_per_dps"]))
    squares = printed(row["anova_model_ms"]), printed(row["anova_error_ms"])
    error = printed(row["slope_se_volt_per_dps"])
    return recompute(lambda s, m, e: sign * s * math.sqrt(m / e), error, *squares)


def _missing_reports() -> Section:
    figures = tuple(
        figure(
            f"{entry} no_ref",
            f"{entry}, no reference",
            text,
            None,
            "%",
            why=f"report {name} is a figure without numbers",
        )
        for entry, text, name in (("m_yx", _entry("Y", "x"), "I2"), ("m_yz", _entry("Y", "z"), "I3"))
    )
    how = "These two entries need the reports I2 and I3."
    return Section("missing", "Appendices I2 and I3", how, figures)


def _entry(row: str, column: str) -> str:
    return by(table(DOC, "matrix_m"), "set", "row_axis")["no_ref", row][f"col_{column}_percent"]

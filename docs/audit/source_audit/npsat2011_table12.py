"""Table 12, and what Tables 9 to 11 say of themselves: dwells that stand out, resolution."""

from __future__ import annotations

import math

import numpy as np

from .figures import Figure, Section, Variant, figure
from .npsat2011_fits import DOC, FILES, IDEAL, refitted, rows_of
from .printed import Printed, Recomputed, printed, recompute
from .table_files import EXAMPLE, Row, by, read, table

SIX = {"X": ("5", "0.5", "0.05"), "Y": ("5", "0.5", "0.06"), "Z": ("5", "0.5", "0.05")}


def table12_sections() -> tuple[Section, ...]:
    """Return Table 12."""
    return (_table12(), _table12_errors(), _table12_rest())


def _table12() -> Section:
    rows = by(table(DOC, "table12_scale_factor_bias"), "sample", "axis")
    figures: list[Figure] = []
    for sample, number, few in (
        ("rate_set_1", "1", False),
        ("rate_set_2", "2", False),
        ("rate_set_1_six_points", "1", True),
    ):
        for axis in "XYZ":
            row = rows[sample, axis]
            chosen = rows_of(axis, "error_no_ref_percent", number, SIX[axis] if few else ())
            figures += _table12_row(f"{sample.replace('_', ' ')} {axis}", row, refitted(chosen, "error_no_ref_percent"))
    how = (
        "Straight lines as above, readings without reference, a sample set at a time; six points: the "
        "rates 5, 0.5 and 0.05 "
        "(Y: 0.06) deg/s of set 1. Biases are intercepts over 0.5 V/(deg/s)."
    )
    return Section("table 12", "Table 12, scale factor and bias", how, tuple(figures))


def _table12_row(name: str, row: Row, found: dict[str, Recomputed]) -> list[Figure]:
    def scaled(what: str, factor: float) -> Recomputed:
        return Recomputed(found[what].value * factor, found[what].tolerance * factor)

    return [
        figure(
            f"S {name}", f"scale factor, {name}", row["scale_factor_mv_per_dps"], scaled("slope", 1e3), "mV/(deg/s)"
        ),
        figure(
            f"S error {name}",
            f"its STDV, {name}",
            row["scale_factor_std_mv_per_dps"],
            scaled("slope error", 1e3),
            "mV/(deg/s)",
        ),
        figure(f"bias {name}", f"bias, {name}", row["bias_dps"], scaled("intercept", 1.0 / IDEAL), "deg/s"),
        figure(
            f"bias error {name}",
            f"bias STDV, {name}",
            row["bias_std_dps"],
            scaled("intercept error", 1.0 / IDEAL),
            "deg/s",
            variants=(Variant("the same in volts", found["intercept error"], "unit"),),
        ),
    ]


def _table12_errors() -> Section:
    figures = []
    for row in table(DOC, "table12_scale_factor_bias"):
        if row["bias_std_dps"] and not row["sample"].startswith("manufacturer") and row["sample"][-1] not in "12":
            rates = [float(r) for r in (SIX[row["axis"]] if row["sample"].startswith("rate") else ("5", "0.5", "0.05"))]
            root = math.sqrt(sum(r * r for r in rates) / len(rates))
            found = recompute(lambda s, root=root: 1e-3 * s * root, printed(row["scale_factor_std_mv_per_dps"]))
            name = f"{row['sample'].replace('_', ' ')} {row['axis']}"
            figures.append(figure(name, name, row["bias_std_dps"], found, "V"))
    how = (
        "Six points: the standard error of the intercept is that of the slope times the root mean square of the rates, "
        "2.90 deg/s, in volts."
    )
    return Section("table 12 errors", "Table 12, bias STDV against the STDV of the scale factor", how, tuple(figures))


def _table12_rest() -> Section:
    figures = []
    for row in table(DOC, "table12_scale_factor_bias"):
        if "vibe" in row["sample"]:
            name = f"{row['sample'].replace('_', ' ')} {row['axis']}"
            why = "the readings are not printed"
            figures += [
                figure(
                    f"S {name}", f"scale factor, {name}", row["scale_factor_mv_per_dps"], None, "mV/(deg/s)", why=why
                ),
                figure(f"bias {name}", f"bias, {name}", row["bias_dps"], None, "deg/s", why=why),
            ]
    how = "The readings before and after vibration are not in the document."
    return Section("table 12 vibration", "Table 12, before and after vibration", how, tuple(figures))


def std_section() -> Section:
    """Return the scatter of the dwells at 5 deg/s and of the run at +2 deg/s, against the other dwells of the axis."""
    readings = 30  # 60 s saved every 2 s
    spread = 3.3 / math.sqrt(2.0 * (readings - 1))  # 99.9 %
    figures: list[Figure] = []
    for axis in "XYZ":
        rows = [row for row in read(EXAMPLE / f"{FILES[axis][0]}.csv") if row["std_dps"]]
        usual = float(np.median([float(row["std_dps"]) for row in rows]))
        for row in rows:
            if row["rate_dps"] in ("5", "-5") or (axis, row["rate_dps"]) == ("X", "2"):
                name = f"{axis} {row['rate_dps']} deg/s, set {row['set']}"
                figures.append(
                    figure(
                        f"std {name}",
                        f"STDV, {name}",
                        row["std_dps"],
                        Recomputed(usual, spread * usual),
                        "deg/s",
                        why=_scatter_why(row),
                    )
                )
    first, second = (rows_of("X", "error_no_ref_percent", s, ("2",))[0] for s in "12")
    for column, label in (("error_minus_ref_percent", "with reference"), ("error_no_ref_percent", "no reference")):
        random = 100.0 * 3.3 * math.hypot(float(first["std_dps"]), 0.005) / math.sqrt(readings) / 2.0
        found = recompute(lambda e: e, printed(first[column]))
        figures.append(
            figure(
                f"+2 {label}",
                f"error, X +2 deg/s set 2, {label}",
                second[column],
                Recomputed(found.value, found.tolerance + random),
                "%",
                why="a bad run that stays in the fits",
            )
        )
    how = (
        "Scatter: the median of the axis, with the 99.9 % spread of a standard deviation from 30 readings. "
        "Set 2 of X at "
        "+2 deg/s: set 1, with the 99.9 % spread of two means."
    )
    return Section("scatter", "Tables 9 to 11, dwells that stand out", how, tuple(figures))


def _scatter_why(row: Row) -> str:
    return (
        "a bad run that stays in the fits" if row["rate_dps"] == "2" else "5 deg/s is the end of the converter: clipped"
    )


def resolution_section(told: dict[str, Printed]) -> Section:
    """Return down to which rate every row is within 5 %."""
    figures: list[Figure] = []
    for key, column, place in (
        ("resolution_direct", "error_no_ref_percent", "direct"),
        ("resolution_with_reference", "error_minus_ref_percent", "with reference"),
    ):
        for axis in "XYZ":
            rates = _lowest(axis, column)
            figures.append(figure(f"{key} {axis}", f"{place}, {axis}", told[key], Recomputed(float(rates)), "deg/s"))
    how = "The lowest rate of Tables 9 to 11 from which on every row is within 5 %."
    return Section("resolution", "Table 14, resolution", how, tuple(figures))


def _lowest(axis: str, column: str) -> str:
    sizes = sorted({row["rate_dps"].lstrip("-") for row in rows_of(axis, column)}, key=float, reverse=True)
    lowest = sizes[0]
    for size in sizes:
        if any(abs(float(row[column])) > 5.0 for row in rows_of(axis, column, rates=(size,))):
            break
        lowest = size
    return lowest

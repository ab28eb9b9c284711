"""The matrix, the constant bias and the flight equation.

``rate = I - (b_in_run + M rate + b_cons)`` needs the sensed axis in the row of M, and (slope - 0.5) / 0.5 on its
diagonal, as equation (1) has it.
"""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from .figures import STANDS, Effect, Figure, Section, Text, Variant, figure
from .npsat2011_fits import DOC, IDEAL, VOLTS, reports, slope_of
from .printed import Printed, Recomputed, printed, recompute
from .table_files import by, table
from .verdicts import judge, one_character_away

Found = TypeVar("Found")
SETS = {"no_ref": "no reference", "minus_ref": "with reference"}


def matrix_sections() -> tuple[Section, ...]:
    """Return the matrix as written, as its equation needs it, the constant bias, and Table 15."""
    return (_as_written(), _as_needed(), _constant_bias(), _table15(), _table15_unit())


def entry(name: str, turned: str, sensed: str) -> Printed:
    """Return the entry in the row of the turned and the column of the sensed axis, in percent."""
    return printed(by(table(DOC, "matrix_m"), "set", "row_axis")[name, turned][f"col_{sensed.lower()}_percent"])


def _report(name: str, turned: str, sensed: str) -> dict[str, Printed] | None:
    """Return slope and intercept of a fit report, of the other set where it is missing and the axes are the same."""
    for row in reports().values():
        if (row["data_set"], row["test_axis"], row["sensed_axis"]) == (name, turned, sensed) and row["n_points"]:
            return {"slope": printed(row["slope_volt_per_dps"]), "intercept": printed(row["intercept_volt"])}
    return None


def _mended(name: str, turned: str, sensed: str) -> Recomputed | None:
    """Return slope in percent of 0.5 V/(deg/s), with the wrong digit mended where the report itself shows it."""
    for row in reports().values():
        if (row["data_set"], row["test_axis"], row["sensed_axis"]) == (name, turned, sensed) and row["n_points"]:
            found = slope_of(row)
            one = figure("slope", "slope", row["slope_volt_per_dps"], found)
            slope = one.printed if judge(one).word in STANDS else one_character_away(one, found)
            return recompute(lambda s: 100.0 * s / IDEAL, slope or found)
    return None


def _need(found: Found | None) -> Found:
    if found is None:
        raise ValueError("a fit report is missing")
    return found


def _as_written() -> Section:
    figures = []
    for name, label in SETS.items():
        for turned in "XYZ":
            for sensed in "XYZ":
                report = _report(name, turned, sensed)
                key = f"m_{turned.lower()}{sensed.lower()}"
                if report is not None:
                    found = _written(name, turned, sensed)
                    holds = Variant(
                        "the intercept of the same report, not the slope",
                        recompute(lambda i: 100.0 * i / IDEAL, report["intercept"]),
                        "misprint",
                    )
                    figures.append(
                        figure(
                            f"{key} {name}",
                            f"{key}, {label}",
                            entry(name, turned, sensed),
                            found,
                            "%",
                            variants=(holds,),
                        )
                    )
    how = (
        "Diagonal: (0.5 - slope) / 0.5; beside it: slope / 0.5, row the turned and column the sensed axis, "
        "as the text has it. Slopes are those of Appendices E to J, J1 and G3 with their wrong digit mended."
    )
    return Section("matrix", "Matrix M, as written", how, tuple(figures))


def _written(name: str, turned: str, sensed: str) -> Recomputed:
    found = _need(_mended(name, turned, sensed))
    if turned != sensed:
        return found
    return Recomputed(100.0 - found.value, found.tolerance)


def _as_needed() -> Section:
    figures: list[Figure] = []
    for row in "XYZ":
        for column in "XYZ":
            found = _need(_mended("no_ref", column, row) or _mended("minus_ref", column, row))
            needed = Recomputed(found.value - 100.0, found.tolerance) if row == column else found
            why = (
                ""
                if row == column
                else f"printed is what the {column.lower()} sensor reads of a turn about {row.lower()}"
            )
            figures.append(
                figure(
                    f"m_{row.lower()}{column.lower()}",
                    f"row {row}, column {column}",
                    entry("no_ref", row, column),
                    needed,
                    "%",
                    why=why,
                )
            )
    how = (
        "Equation (2) subtracts M times the rate. Its diagonal must then be (slope - 0.5) / 0.5, by "
        "equation (1), and its row "
        "the sensed axis, its column the turned one."
    )
    return Section("flight matrix", "Matrix M, as equation (2) needs it", how, tuple(figures))


def _constant_bias() -> Section:
    figures = []
    for row in table(DOC, "vector_b_cons"):
        for axis in "XYZ":
            report = _need(_report(row["set"], axis, axis))
            found = recompute(lambda i: i / IDEAL, report["intercept"])
            figures.append(
                figure(
                    f"{row['set']} {axis}", f"{axis}, {SETS[row['set']]}", row[f"{axis.lower()}_dps"], found, "deg/s"
                )
            )
    return Section("constant bias", "Constant bias b_cons", "Intercept over 0.5 V/(deg/s).", tuple(figures))


def _table15() -> Section:
    """Table 15 repeats Tables 2 and 7, the matrix and the vector without reference."""
    vacuum = by(table(DOC, "table07_poly_vacuum_volt"), "axis", "coefficient")
    nominal = by(table(DOC, "table02_nominal_voltage"), "axis")
    bias = by(table(DOC, "vector_b_cons"), "set")["no_ref",]
    figures: list[Figure] = []
    for row in table(DOC, "table15_mems_output"):
        for axis in "XYZ":
            term = row["term"]
            if (axis, term) in vacuum:
                source = printed(vacuum[axis, term]["value"])
            elif term == "b_cons":
                source = printed(bias[f"{axis.lower()}_dps"])
            elif term.startswith("M_row"):
                source = entry("no_ref", term[-1].upper(), axis)
            elif term == "slope":
                source = printed("0.0264")
            else:
                column = {"t_reference": "temperature_mean_degc", "v_nominal": "v_nominal_volt"}[term]
                source = printed(nominal[axis,][column])
            found = Recomputed(source.value)
            figures.append(figure(f"{term} {axis}", f"{term}, {axis}", row[axis.lower()], found))
    how = "Repeats Table 7, Table 2, the matrix and the vector without reference."
    return Section("table 15", "Table 15, constants of the flight equation", how, tuple(figures), identity=True)


def _table15_unit() -> Section:
    figures: list[Figure | Text] = []
    row = by(table(DOC, "table15_mems_output"), "term")["B",]
    vacuum = by(table(DOC, "table07_poly_vacuum_volt"), "axis", "coefficient")
    for axis in "XYZ":
        needed = recompute(lambda b: b / IDEAL, printed(vacuum[axis, "B"]["value"]))
        figures.append(figure(f"B {axis}", f"B, {axis}", row[axis.lower()], needed, "deg/s", factors=VOLTS))
    how = (
        "The flight equation takes b_in-run from a rate in deg/s: the cubic of Table 7 is in volts and lacks "
        "the division by 0.5."
    )
    return Section("table 15 unit", "Table 15, unit of the bias over temperature", how, tuple(figures))


def _forward() -> NDArray[np.float64]:
    """Return what the suite does, row the sensed and column the turned axis, in percent of the rate."""
    M = np.empty((3, 3))
    for i, row in enumerate("XYZ"):
        for j, column in enumerate("XYZ"):
            found = _need(_mended("no_ref", column, row) or _mended("minus_ref", column, row))
            M[i, j] = found.value
    return M / 100.0


def matrix_effect() -> Effect:
    """Return what the flight equation, solved for the rate, does to the unit's own slopes, as printed and mended."""
    printed_M = np.array([[entry("no_ref", r, c).value for c in "XYZ"] for r in "XYZ"]) / 100.0
    F = _forward()
    before, after = F - np.eye(3), np.linalg.solve(np.eye(3) + printed_M, F) - np.eye(3)
    turned = printed_M.T.copy()
    np.fill_diagonal(turned, -np.diag(printed_M))
    mended = np.linalg.solve(np.eye(3) + turned, F) - np.eye(3)

    def worst(M: NDArray[np.float64]) -> float:
        return 100.0 * float(np.max(np.abs(M - np.diag(np.diag(M)))))

    scale = [", ".join(f"{round(100.0 * x, 3) + 0.0:+.3f}" for x in np.diag(M)) for M in (before, after, mended)]
    return Effect(
        "The matrix of the flight equation has its diagonal with the wrong sign and its rows and columns exchanged.",
        f"Applied to the unit's own slopes it makes scale errors of {scale[0]} % into {scale[1]} %, and the "
        "worst cross term "
        f"from {worst(before):.3f} into {worst(after):.3f} %: worse than no correction. With both mended: {scale[2]} % "
        f"and {worst(mended):.3f} %.",
    )

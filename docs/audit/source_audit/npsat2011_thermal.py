"""Random vibration, and the bias over temperature: cubics in volts and in deg/s."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise

import numpy as np

from .figures import Figure, Section, Text, Variant, figure
from .npsat2011_fits import DOC, IDEAL
from .printed import Input, Printed, Recomputed, printed, recompute
from .table_files import by, table

SLOPE = 0.0264  # V/degC, as printed; 8 times 0.0033
TERMS = ("B", "m1", "m2", "m3")
Told = dict[str, Printed]


def thermal_sections(told: Told) -> tuple[Section, ...]:
    """Return Tables 1, 3, 4, 7 and 8."""
    return (
        _random_vibration(told),
        _residual_sums(),
        _in_degrees(
            "table 4",
            "Table 4 from Table 3, cubic at ambient pressure",
            "table03_poly_ground_volt",
            "table04_poly_ground_degc_dps",
        ),
        _in_degrees(
            "table 8",
            "Table 8 from Table 7, cubic in vacuum",
            "table07_poly_vacuum_volt",
            "table08_poly_vacuum_degc_dps",
        ),
        _column_heads(),
    )


def _random_vibration(told: Told) -> Section:
    low, plateau = 0.01, 0.04  # g^2/Hz, Table 1
    end = 20.0 * (plateau / low) ** (10.0 * math.log10(2.0) / 3.0)  # 3 dB an octave
    figures = (
        figure(
            "rise",
            "end of the rising part",
            told["asd_rise_end"],
            recompute(lambda x: x, end),
            "Hz",
            why="0.01 at 20 Hz reaches 0.04 at 80 Hz with 3 dB an octave",
        ),
        figure(
            "overall", "overall level, corners 20, 50, 500, 2000 Hz", told["asd_overall"], Recomputed(_rms(50.0)), "g"
        ),
        figure("overall 80", "overall level, with 80 Hz", told["asd_overall"], Recomputed(_rms(80.0)), "g"),
    )
    how = (
        "From 0.01 g^2/Hz at 20 Hz with +3 dB an octave to 0.04 g^2/Hz; the level from the integral over "
        "straight lines in both logarithms."
    )
    return Section("table 1", "Table 1, random vibration", how, figures)


def _rms(rise: float) -> float:
    corners = ((20.0, 0.01), (rise, 0.04), (500.0, 0.04), (2000.0, 0.01))
    total = 0.0
    for (f1, s1), (f2, s2) in pairwise(corners):
        n = math.log(s2 / s1) / math.log(f2 / f1)
        total += (
            s1 * f1 * math.log(f2 / f1)
            if abs(n + 1.0) < 1e-9
            else s1 / f1**n * (f2 ** (n + 1.0) - f1 ** (n + 1.0)) / (n + 1.0)
        )
    return math.sqrt(total)


def _sum(name: str, axis: str) -> Printed:
    return printed(by(table(DOC, name), "axis", "coefficient")[axis, "B"]["residual_sum_of_squares"])


def _residual_sums() -> Section:
    std = {r["axis"]: printed(r["std"]) for r in table(DOC, "residual_bias") if r["stage"] == "fit_residual_ambient"}
    ambient, vacuum = (
        ("table03_poly_ground_volt", "table04_poly_ground_degc_dps"),
        ("table07_poly_vacuum_volt", "table08_poly_vacuum_degc_dps"),
    )
    figures: list[Figure] = []
    for axis in "YZ":
        found = recompute(lambda s, x, a: s * (a / x) ** 2, _sum(ambient[0], "X"), std["X"], std[axis])
        figures.append(figure(f"table 3 {axis}", f"Table 3, {axis}", _sum(ambient[0], axis), found, "V^2"))
    for label, (volts, degrees) in (("Table 4", ambient), ("Table 8", vacuum)):
        for axis in "XYZ":
            found = recompute(lambda s: s / IDEAL**2, _sum(volts, axis))
            figures.append(
                figure(f"{label.lower()} {axis}", f"{label}, {axis}", _sum(degrees, axis), found, "(deg/s)^2")
            )
    how = (
        "Table 3: the residual sum of X, scaled by the squares of the stated residual deviations (same "
        "number of points). "
        "Tables 4 and 8: four times the sums of Tables 3 and 7, since 0.5 V is 1 deg/s."
    )
    return Section("residual sums", "Tables 3, 4, 7 and 8, residual sums of squares", how, tuple(figures))


def _cubic(term: int) -> Callable[..., float]:
    """Return a coefficient over degC in deg/s from those over volts: V = v + SLOPE (T - reference)."""

    def coefficient(B: float, m1: float, m2: float, m3: float, v: float, reference: float) -> float:
        a = v - SLOPE * reference
        whole = (
            B + m1 * a + m2 * a**2 + m3 * a**3,
            SLOPE * (m1 + 2.0 * m2 * a + 3.0 * m3 * a**2),
            SLOPE**2 * (m2 + 3.0 * m3 * a),
            SLOPE**3 * m3,
        )
        return whole[term] / IDEAL

    return coefficient


def _in_degrees(key: str, title: str, source: str, target: str) -> Section:
    volts, degrees = by(table(DOC, source), "axis", "coefficient"), by(table(DOC, target), "axis", "coefficient")
    nominal = by(table(DOC, "table02_nominal_voltage"), "axis")
    figures: list[Figure] = []
    for axis in "XYZ":
        poly: list[Input] = [printed(volts[axis, term]["value"]) for term in TERMS]
        v = printed(nominal[axis,]["v_nominal_volt"])
        own, other = (
            printed(nominal[a,]["temperature_mean_degc"]) for a in (axis, {"X": "Y", "Y": "X", "Z": "Z"}[axis])
        )
        for i, term in enumerate(TERMS):
            swapped = Variant(
                "what exchanged reference temperatures of X and Y give", recompute(_cubic(i), *poly, v, other)
            )
            figures.append(
                figure(
                    f"{term} {axis}",
                    f"{term}, {axis}",
                    degrees[axis, term]["value"],
                    recompute(_cubic(i), *poly, v, own),
                    "deg/s" + ("", "/degC", "/degC^2", "/degC^3")[i],
                    variants=(swapped,) if axis != "Z" else (),
                )
            )
    how = (
        "The cubic over volts, taken to degC by Table 2 and 0.0264 V/degC (equations (10) to (12)) and to "
        "deg/s by 0.5 V/(deg/s)."
    )
    return Section(key, title, how, tuple(figures))


def cubic_gap(source: str, target: str) -> float:
    """Return the largest difference of the two forms of the cubics over -29 to 66 degC, of any axis [deg/s]."""
    volts, degrees = by(table(DOC, source), "axis", "coefficient"), by(table(DOC, target), "axis", "coefficient")
    nominal = by(table(DOC, "table02_nominal_voltage"), "axis")
    T, gaps = np.linspace(-29.0, 66.0, 96), []
    for axis in "XYZ":
        v, reference = (float(nominal[axis,][c]) for c in ("v_nominal_volt", "temperature_mean_degc"))
        poly = [float(volts[axis, term]["value"]) for term in TERMS]
        differences = [_cubic(i)(*poly, v, reference) - float(degrees[axis, t]["value"]) for i, t in enumerate(TERMS)]
        gaps.append(float(np.max(np.abs(np.polynomial.polynomial.polyval(T, differences)))))
    return max(gaps)


def _column_heads() -> Section:
    texts = tuple(
        Text(
            f"{label} {term}",
            f"{label}, {term}",
            "V",
            unit,
            is_unit=True,
            why="the values are deg/s over powers of degC",
        )
        for label in ("Table 4", "Table 8")
        for term, unit in zip(TERMS, ("deg/s", "deg/s/degC", "deg/s/degC^2", "deg/s/degC^3"), strict=True)
    )
    return Section("column heads", "Tables 4 and 8, head of the value column", "Unit of each coefficient.", texts)

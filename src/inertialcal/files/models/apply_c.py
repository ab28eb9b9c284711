"""A model as C99 that needs math.h alone: one raw reading in, the true input out.

A matrix that nothing changes is inverted beforehand, with rational numbers, and M stands beside it in a comment: each
number can be held against ``model.json``. One that changes with temperature or another channel is inverted as it is at
each reading, by elimination with exchange of rows.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from ...core.estimate import Array
from ...sensors.model.sensor_model import SensorModel
from .apply_parts import (
    MISSING,
    Constant,
    arguments,
    checked_ranges,
    code_cannot_hold,
    constants,
    diagonal_terms,
    head,
    matrix_at,
    newton,
    offset_terms,
    order,
    plain,
    range_name,
    refusal,
    single,
    thermal,
)
from .flight_c.exact import inverted
from .model_format import ModelFormat, of_one

TITLE = ["/* True input from one raw reading of a calibrated sensor; written by inertialcal.", " *"]

SIGN = """\
static double sign(double value) { return value > 0.0 ? 1.0 : value < 0.0 ? -1.0 : value; }
"""

STRAIGHTENED = """\
/* u of sensor i with u + K1'/2 |u| + K2 u^2 + K3 u^3 = y; NaN beyond the rising branch.
 * Newton's method inside a bracket that shrinks at each step. */
static double straightened(int i, double y) {
    const double k1 = SCALE_FACTOR_ASYMMETRY[i], k2 = SECOND_ORDER[i], k3 = THIRD_ORDER[i];
    const double side = y < 0.0 ? -1.0 : 1.0;
    double inner = 0.0, outer = BRANCH[i][y < 0.0 ? 0 : 1], u = y / (1.0 + 0.5 * side * k1);
    if (isinf(outer)) outer = 2.0 * y / LEAST_SLOPE[i];
    if (!(side * (outer * (1.0 + outer * (k2 + outer * k3)) + 0.5 * k1 * fabs(outer) - y) >= 0.0)) return NAN;
    if (side * u > side * outer) u = outer;
    for (int step = 0; step < 100; step++) {
        const double excess = side * (u * (1.0 + u * (k2 + u * k3)) + 0.5 * k1 * fabs(u) - y);
        const double half = u > 0.0 ? 0.5 * k1 : u < 0.0 ? -0.5 * k1 : 0.0;
        const double slope = 1.0 + half + u * (2.0 * k2 + 3.0 * k3 * u);
        double next = u - side * excess / slope;
        if (excess >= 0.0) outer = u;
        if (excess <= 0.0) inner = u;
        if (!(slope > 0.0 && side * next >= side * inner && side * next <= side * outer)) next = 0.5 * (inner + outer);
        const int still = fabs(next - u) <= 4.0 * DBL_EPSILON * fabs(next);
        u = next;
        if (still) break;
    }
    return u;
}
"""

SOLVE = """\
/* Solve m x = u by elimination with exchange of rows; m and u are used up. */
static void solve(double m[K][K], double u[K], double x[K]) {
    for (int i = 0; i < K; i++) {
        int best = i;
        for (int row = i + 1; row < K; row++)
            if (fabs(m[row][i]) > fabs(m[best][i])) best = row;
        for (int column = 0; column < K; column++) {
            const double kept = m[i][column];
            m[i][column] = m[best][column];
            m[best][column] = kept;
        }
        const double kept = u[i];
        u[i] = u[best];
        u[best] = kept;
        for (int row = i + 1; row < K; row++) {
            const double factor = m[row][i] / m[i][i];
            for (int column = i; column < K; column++) m[row][column] -= factor * m[i][column];
            u[row] -= factor * u[i];
        }
    }
    for (int i = K - 1; i >= 0; i--) {
        x[i] = u[i];
        for (int column = i + 1; column < K; column++) x[i] -= m[i][column] * x[column];
        x[i] /= m[i][i];
    }
}
"""

MULTIPLIED = [
    "    for (int i = 0; i < K; i++) {",
    "        x[i] = 0.0;",
    "        for (int j = 0; j < K; j++) x[i] += M_INVERSE[i][j] * u[j];",
    "    }",
]


def c_text(model: SensorModel) -> str:
    """Return a C99 file with ``compensate``, which applies this very model to one reading.

    Parameters
    ----------
    model : SensorModel
        Any; where its inverse is not unique the text has no function, but the reason.

    Returns
    -------
    str
        ASCII, coefficients at full digits. ``compensate`` takes outputs v [output unit] and the conditions that
        the terms need; it fills x [input unit] and ``holds``, whether the model holds there, and returns 1 where it
        holds on all axes. Compiles with ``-std=c99 -Wall -Wextra -pedantic`` and no warning.
    """
    why = refusal(model)
    comments = [f" * {line}".rstrip() for line in head(model)]
    if why:
        return "\n".join([*TITLE, *comments, f" * No function: {why} */", ""])
    lines = [*TITLE, *comments, " * To compile: cc -std=c99 ... -lm */", "#include <math.h>", ""]
    lines += [f"enum {{ K = {len(model.axes)} }}; /* sensors, in the order {order(model)} */", ""]
    beforehand = _inverted_beforehand(model)
    for constant in constants(model):
        lines += _inverse(constant) if beforehand and constant.name == "M_0" else _constant(constant)
    parts = [STRAIGHTENED.replace("DBL_EPSILON", repr(float(np.finfo(float).eps)))] if newton(model) else []
    parts += [SIGN] if model.bias_hysteresis is not None else []
    parts += [] if beforehand else [SOLVE]
    return "\n".join([*lines, "", *parts, *_function(model), ""])


def _inverted_beforehand(model: SensorModel) -> bool:
    """Return whether no condition changes M."""
    return model.matrix.shape[0] == 1 and not diagonal_terms(model)


def _inverse(matrix: Constant) -> list[str]:
    """Return M^-1 as a constant, M before it as a comment."""
    exact = inverted([[Fraction(float(entry)) for entry in row] for row in matrix.values])
    values = np.array([[float(entry) for entry in row] for row in exact])
    stated = [f" *   {_numbers(row)}" for row in matrix.values]
    return [
        "/* M, whose inverse is beneath:",
        *stated,
        " */",
        *_constant(Constant("M_INVERSE", values, matrix.comment)),
    ]


def _constant(constant: Constant) -> list[str]:
    values = constant.values
    sizes = "".join(f"[{n}]" for n in values.shape)
    start, comment = f"static const double {constant.name}{sizes} = ", f" /* {constant.comment} */"
    if values.ndim < 2:
        text = _numbers(values) if values.ndim else _number(float(values))
        return [f"{start}{text};{comment}"]
    rows = [f"    {_numbers(row)}," for row in values]
    return [f"{start}{{{comment}", *rows, "};"]


def _numbers(row: Array) -> str:
    return f"{{{', '.join(_number(float(value)) for value in row)}}}"


def _number(value: float) -> str:
    return repr(value) if np.isfinite(value) else repr(value).replace("inf", "INFINITY")


def _function(model: SensorModel) -> list[str]:
    conditions = arguments(model)
    given = ["const double v[K]", *(_argument(name) for name in conditions), "double x[K]", "int holds[K]"]
    taken = (",\n" + " " * len("int compensate(") if conditions else ", ").join(given)
    lines = [*_comment(model, conditions), f"int compensate({taken}) {{"]
    beforehand = _inverted_beforehand(model)
    lines.append("    double u[K];" if beforehand else "    double u[K], m[K][K];")
    lines += ["    int all = 1;", "    for (int i = 0; i < K; i++) {"]
    if thermal(model):
        lines.append("        const double away = temperature[i] - REFERENCE_TEMPERATURE[i];")
    force = " + ".join(f"G_SENSITIVITY[i][{j}] * specific_force[{j}]" for j in range(3))
    words = {"i": "[i]", "exp": "exp", "sign": "sign", "force": force}
    terms = [term.replace("away{i}", "away").format(**words) for term in offset_terms(model)]
    lines.append(f"        double offset = {terms[0]};")
    lines += [f"        offset += {term};" for term in terms[1:]]
    lines += ["        u[i] = v[i] / S0[i] - offset;", *_curve(model)]
    if beforehand:
        lines += ["    }", *MULTIPLIED]
    else:
        lines.append(f"        for (int j = 0; j < K; j++) m[i][j] = {matrix_at(model, '[i][j]', 'away')};")
        lines += [f"        m[i][i] += {term.format(i='[i]')};" for term in diagonal_terms(model)]
        lines += ["    }", "    solve(m, u, x);"]
    return [*lines, *_validity(model), "    return all;", "}"]


def _argument(name: str) -> str:
    if single(name):
        return f"double {name}"
    return f"const double {name}[{3 if name == 'specific_force' else 'K'}]"


def _comment(model: SensorModel, conditions: dict[str, str]) -> list[str]:
    lines = [
        f"Fill x with the true inputs [{model.unit}], and holds with 1 where the model holds, else 0.",
        f"v: output of each sensor [{plain(model.output_unit)}]",
        *(f"{name}: {text}" for name, text in conditions.items()),
        MISSING,
        "Returns 1 where the model holds on all axes.",
    ]
    return ["/* " + "\n * ".join(lines) + " */"]


def _curve(model: SensorModel) -> list[str]:
    if newton(model):
        return ["        u[i] = straightened(i, u[i]);"]
    if model.linear:
        return []
    return ["        u[i] /= 1.0 + 0.5 * SCALE_FACTOR_ASYMMETRY[i] * (u[i] < 0.0 ? -1.0 : 1.0);"]


def _validity(model: SensorModel) -> list[str]:
    lines = []
    for name in checked_ranges(model):
        each, ends = "" if single(name) else "[i]", range_name(name)
        test = f"all = all && {name}{each} >= {ends}[0] && {name}{each} <= {ends}[1];"
        lines.append(f"    for (int i = 0; i < K; i++) {test}" if each else f"    {test}")
    inside = "isfinite(x[i])"
    if model.input_range is not None:
        inside = "x[i] >= INPUT_RANGE[i][0] && x[i] <= INPUT_RANGE[i][1]"
    return [
        *lines,
        "    const int here = all;",
        "    for (int i = 0; i < K; i++) {",
        f"        holds[i] = here && {inside};",
        "        all = all && holds[i];",
        "    }",
    ]


FORMAT = ModelFormat(
    name="c", title="c", dump=of_one(c_text), cannot_hold=lambda models: code_cannot_hold(models, "c"), one_sensor=True
)

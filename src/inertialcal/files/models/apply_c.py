"""A model as C99 that needs math.h alone: one raw reading in, the true input out.

M is stated, not its inverse: each number can be held against ``model.json``; elimination with exchange of rows at
double precision costs no digit that the inverse would keep.
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ...core.axes import Kind
from ...core.errors import DataError
from ...core.estimate import Array
from ...core.remarks import Remark
from ...core.units import divide
from ...sensors.model.compensate import check_unique
from ...sensors.model.equation import Columns, curve, needed
from ...sensors.model.nonlinearity import endless_slope, rising_branch
from ...sensors.model.sensor_model import APPLY_ORDER, MATRIX_ORDER, SensorModel, equation
from .model_format import ModelFormat, of_one

TITLE = ["/* True input from one raw reading of a calibrated sensor; written by inertialcal.", " *"]
SINGLE = {"pressure", "time"}  # conditions that are one number; the others are arrays

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
    lines += [line for constant in constants(model) for line in _constant(constant)]
    parts = [STRAIGHTENED.replace("DBL_EPSILON", repr(float(np.finfo(float).eps)))] if newton(model) else []
    parts += [SIGN] if model.bias_hysteresis is not None else []
    return "\n".join([*lines, "", *parts, SOLVE, *_function(model), ""])


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
    arguments = [name for name in CONDITIONS if name in needed(model)]
    given = ["const double v[K]", *(_argument(name) for name in arguments), "double x[K]", "int holds[K]"]
    taken = (",\n" + " " * len("int compensate(") if arguments else ", ").join(given)
    lines = [*_comment(model, arguments), f"int compensate({taken}) {{"]
    lines += ["    double u[K], m[K][K];", "    int all = 1;", "    for (int i = 0; i < K; i++) {"]
    if thermal(model):
        lines.append("        const double away = temperature[i] - REFERENCE_TEMPERATURE[i];")
    force = " + ".join(f"G_SENSITIVITY[i][{j}] * specific_force[{j}]" for j in range(3))
    words = {"i": "[i]", "exp": "exp", "sign": "sign", "force": force}
    terms = [term.replace("away{i}", "away").format(**words) for term in offset_terms(model)]
    lines.append(f"        double offset = {terms[0]};")
    lines += [f"        offset += {term};" for term in terms[1:]]
    lines += ["        u[i] = v[i] / S0[i] - offset;", *_curve(model)]
    lines.append(f"        for (int j = 0; j < K; j++) m[i][j] = {matrix_at(model, '[i][j]', 'away')};")
    return [*lines, "    }", "    solve(m, u, x);", *_validity(model), "    return all;", "}"]


def _argument(name: str) -> str:
    if name in SINGLE:
        return f"double {name}"
    return f"const double {name}[{3 if name == 'specific_force' else 'K'}]"


def _comment(model: SensorModel, arguments: list[str]) -> list[str]:
    lines = [
        f"Fill x with the true inputs [{model.unit}], and holds with 1 where the model holds, else 0.",
        f"v: output of each sensor [{plain(model.output_unit)}]",
        *(f"{name}: {CONDITIONS[name]}" for name in arguments),
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
        each, ends = "" if name in SINGLE else "[i]", f"{name.upper()}_RANGE"
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


LONGEST = 200  # characters of a text from the model


WIDTH = 96  # of a comment


_MEANS_SOMETHING = re.compile(r"""[^ -~]|["'\\?]|\*(?=/)|(?<=/)\*""")


CONDITIONS = {
    "temperature": "of each sensor [degC]",
    "pressure": "[Pa]",
    "time": "since power-up [s]",
    "temperature_rate": "dT/dt of each sensor, positive when warming [degC/s]",
    "specific_force": "along the body axes x, y, z [m/s^2]",
}


MISSING = "Where a reading is missing, or no input gives it, x is NaN; the other axes may be NaN with it."


RANGES = {"temperature": "degC", "pressure": "Pa"}


@dataclass(frozen=True, eq=False)
class Constant:
    """A named array of the code, with what it is."""

    name: str
    values: Array
    comment: str


def plain(text: str) -> str:
    """Return a text that can neither end a comment nor a line: ASCII, other characters as ``<U+0000>``.

    The asterisk goes only beside a slash; question marks go because of the trigraphs of C.
    """
    cut = text if len(text) <= LONGEST else f"{text[:LONGEST]}... ({len(text)} characters)"
    return _MEANS_SOMETHING.sub(lambda found: f"<U+{ord(found[0]):04X}>", cut)


def order(model: SensorModel) -> str:
    """Return the axes in the order of all arrays."""
    return ", ".join(plain(axis) for axis in model.axes)


def refusal(model: SensorModel) -> str:
    """Return why no code can invert a model, the same reason as that of `sensors.model.compensate`; else nothing."""
    here: Columns = {}
    if model.matrix.shape[0] > 1:
        here = {"temperature": model.terms["reference_temperature"][np.newaxis]}
    try:
        check_unique(model, here)
    except DataError as error:
        return plain(str(error))
    return ""


def head(model: SensorModel) -> list[str]:
    """Return lines of comment: whose model, equation, order of the steps, what is left out."""
    item = model.item
    parts = (("maker", item.maker), ("part", item.part), ("serial", item.serial))
    named = [f"{word} {plain(text)}" for word, text in parts if text]
    lines = [f"Sensor: {', '.join(named) or 'unnamed'} ({model.kind}, axes in this order: {order(model)})"]
    if model.source:
        lines.append(f"Source: {plain(model.source)}")
    if not model.judged:
        lines.append("This model was not judged on recordings held out.")
    lines += ["Equation, forward:", *(f"  {row}" for row in equation(model)[:3])]
    lines += [f"Steps: {'; '.join(APPLY_ORDER)}.", *_left_out(model)]
    return [part for line in lines for part in _wrapped(line)]


def _left_out(model: SensorModel) -> list[str]:
    lines = []
    if model.bias_run_to_run is not None:
        sizes = ", ".join(repr(float(size)) for size in model.bias_run_to_run)
        lines.append(
            "Not here, because no code can remove it: the bias changes from power-up to power-up, "
            f"with a standard deviation of {sizes} {model.unit}."
        )
    for name, unit in RANGES.items():
        ends = getattr(model, f"{name}_range")
        if ends is not None and name not in needed(model):
            lines.append(
                f"Holds for a {name} of {ends[0]!r} to {ends[1]!r} {unit}: no term needs it, not checked here."
            )
    if model.matrix.shape[0] > 1 and model.temperature_range is None:
        lines.append("No temperature range is stated: whether M(T) can be inverted was looked at for T_ref alone.")
    lines.append("With uncertainties, on whole recordings: inertialcal compensate MODEL DATA -o OUT --uncertainty")
    return lines


def _wrapped(line: str) -> list[str]:
    indent = "    " if line.startswith(" ") else "  "
    return textwrap.wrap(line, WIDTH, subsequent_indent=indent, drop_whitespace=True, break_on_hyphens=False)


def constants(model: SensorModel) -> list[Constant]:
    """Return the numbers of the code, in the order of the equation."""
    unit, terms = model.unit, model.terms
    scale = divide(model.output_unit, unit)
    found = [Constant("S0", model.scale_factor, f"ideal scale factor [{scale}]")]
    for j, matrix in enumerate(model.matrix):
        found.append(Constant(f"M_{j}", matrix, f"[1/degC^{j}]" if j else MATRIX_ORDER))
    comments = {
        "bias": f"K0 at the reference conditions [{unit}]",
        "reference_temperature": "T_ref [degC]",
        "bias_temperature": f"b_1, b_2, ... a row each [({unit})/degC^j]",
        "bias_pressure": f"b_p [({unit})/Pa]",
        "bias_warm_up": f"A_1, A_2, ... a row each [{unit}]",
        "warm_up_time": "tau_1, tau_2, ... [s]",
        "bias_temperature_rate": f"b_r [({unit})/(degC/s)]",
        "bias_hysteresis": f"b_h [{unit}]",
        "g_sensitivity": f"G [({unit})/(m/s^2)]; row = sensor, column = force along x, y, z",
        **_curve_comments(model),
        "input_range": f"lowest and highest input along each axis that the model holds for [{unit}]",
    }
    unused = set() if thermal(model) else {"reference_temperature"}
    found += [Constant(n.upper(), terms[n], c) for n, c in comments.items() if n in terms and n not in unused]
    return found + _branch(model) + _conditions(model)


def thermal(model: SensorModel) -> bool:
    """Return whether the code needs T - T_ref."""
    return model.bias_temperature is not None or model.matrix.shape[0] > 1


def newton(model: SensorModel) -> bool:
    """Return whether a sensor has K2 or K3, so that its inverse has no simple closed form."""
    return bool(np.any(curve(model).second) or np.any(curve(model).third))


def _curve_comments(model: SensorModel) -> dict[str, str]:
    if model.linear:
        return {}
    comments = {"scale_factor_asymmetry": "K1'"}
    if newton(model):
        comments |= {"second_order": f"K2 [1/({model.unit})]", "third_order": f"K3 [1/({model.unit})^2]"}
    return comments


def _branch(model: SensorModel) -> list[Constant]:
    """Return where the curve of each sensor stops rising, and K1', K2, K3 that are zero."""
    if not newton(model):
        return []
    bent = curve(model)
    missing = [name for name in _curve_comments(model) if name not in model.terms]
    ends = rising_branch(bent)
    return [
        *(Constant(name.upper(), np.zeros(len(model.axes)), "absent") for name in missing),
        Constant("BRANCH", ends, f"ends of the branch around zero where the curve rises [{model.unit}]"),
        Constant("LEAST_SLOPE", endless_slope(bent, ends), "of the curve, on sides where it rises without end"),
    ]


def _conditions(model: SensorModel) -> list[Constant]:
    found = []
    if model.bias_pressure is not None:
        found.append(Constant("REFERENCE_PRESSURE", np.array(model.reference_pressure, dtype=float), "p_ref [Pa]"))
    for name in checked_ranges(model):
        ends = np.array(getattr(model, f"{name}_range"), dtype=float)
        found.append(Constant(f"{name.upper()}_RANGE", ends, f"that the model holds for [{RANGES[name]}]"))
    return found


def checked_ranges(model: SensorModel) -> list[str]:
    """Return the conditions that the code takes and that the model has a validity range of."""
    return [name for name in RANGES if name in needed(model) and getattr(model, f"{name}_range") is not None]


def offset_terms(model: SensorModel) -> list[str]:
    """Return K0 + G f as templates of summands."""
    terms = ["BIAS{i}"]
    if model.bias_temperature is not None:
        terms.append(_polynomial(len(model.bias_temperature)))
    if model.bias_pressure is not None:
        terms.append("BIAS_PRESSURE{i} * (pressure - REFERENCE_PRESSURE)")
    if model.bias_warm_up is not None:
        each = range(len(model.bias_warm_up))
        terms += [f"BIAS_WARM_UP[{m}]{{i}} * {{exp}}(-time / WARM_UP_TIME[{m}])" for m in each]
    if model.bias_temperature_rate is not None:
        terms.append("BIAS_TEMPERATURE_RATE{i} * temperature_rate{i}")
    if model.bias_hysteresis is not None:
        terms.append("BIAS_HYSTERESIS{i} * {sign}(temperature_rate{i})")
    return [*terms, "{force}"] if model.g_sensitivity is not None else terms


def _polynomial(count: int) -> str:
    """Horner's rule, from the highest power down."""
    text = f"BIAS_TEMPERATURE[{count - 1}]{{i}}"
    for j in range(count - 2, -1, -1):
        text = f"({text} * away{{i}} + BIAS_TEMPERATURE[{j}]{{i}})"
    return f"{text} * away{{i}}"


def matrix_at(model: SensorModel, entry: str, away: str) -> str:
    """Return M(T) by Horner's rule; ``entry`` picks a place in M_j, ``away`` is T - T_ref of a row."""
    count = model.matrix.shape[0]
    text = f"M_{count - 1}{entry}"
    for j in range(count - 2, -1, -1):
        text = f"{text} * {away} + M_{j}{entry}"
        text = f"({text})" if j else text
    return text


def code_cannot_hold(models: Mapping[Kind, SensorModel], language: str) -> tuple[Remark, ...]:
    """Return what of these models code leaves out."""
    return tuple(
        Remark("not_held", "info", f"{model.kind}: code in {language} cannot hold: uncertainties")
        for model in models.values()
        if model.estimate is not None
    )

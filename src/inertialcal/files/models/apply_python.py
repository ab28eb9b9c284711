"""A model as Python that needs numpy alone: one raw reading in, the true input out.

M is stated, not its inverse: each number can be held against ``model.json``; solving at double precision costs no
digit that the inverse would keep.
"""

from __future__ import annotations

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
    thermal,
)
from .model_format import ModelFormat, of_one

TITLE = '"""True input from one raw reading of a calibrated sensor; written by inertialcal."""'

CLOSED = """\
    u = u / (1.0 + 0.5 * SCALE_FACTOR_ASYMMETRY * np.where(u < 0.0, -1.0, 1.0))"""

STRAIGHTENED = '''\
def straightened(i, y):
    """Return u of sensor i with u + K1'/2 |u| + K2 u^2 + K3 u^3 = y; NaN beyond the rising branch.

    Newton's method inside a bracket that shrinks at each step.
    """
    k1, k2, k3 = SCALE_FACTOR_ASYMMETRY[i], SECOND_ORDER[i], THIRD_ORDER[i]
    side = -1.0 if y < 0.0 else 1.0
    inner, outer = 0.0, BRANCH[i, 0 if y < 0.0 else 1]
    if np.isinf(outer):
        outer = 2.0 * y / LEAST_SLOPE[i]
    if not side * (outer * (1.0 + outer * (k2 + outer * k3)) + 0.5 * k1 * abs(outer) - y) >= 0.0:
        return np.nan
    u = side * min(side * y / (1.0 + 0.5 * side * k1), side * outer)
    for _ in range(100):
        excess = side * (u * (1.0 + u * (k2 + u * k3)) + 0.5 * k1 * abs(u) - y)
        outer = u if excess >= 0.0 else outer
        inner = u if excess <= 0.0 else inner
        slope = 1.0 + 0.5 * k1 * np.sign(u) + u * (2.0 * k2 + 3.0 * k3 * u)
        new = u - side * excess / slope if slope > 0.0 else np.nan
        if not side * inner <= side * new <= side * outer:
            new = 0.5 * (inner + outer)
        still = abs(new - u) <= 4.0 * np.finfo(float).eps * abs(new)
        u = new
        if still:
            break
    return u
'''


def python_text(model: SensorModel) -> str:
    """Return a Python module with ``compensate(v, ...)``, which applies this very model to one reading.

    Parameters
    ----------
    model : SensorModel
        Any; where its inverse is not unique the text has no function, but the reason.

    Returns
    -------
    str
        ASCII, coefficients at full digits. ``compensate`` takes outputs v, shape (k,) [output unit], and the
        conditions that the terms need; it returns x, shape (k,) [input unit], and whether the model holds there,
        shape (k,).
    """
    why = refusal(model)
    comments = [f"# {line}".rstrip() for line in head(model)]
    if why:
        return "\n".join([TITLE, "", *comments, f"# No function: {why}", ""])
    numbers = [line for constant in constants(model) for line in _constant(constant)]
    parts = [TITLE, "", *comments, "", "import numpy as np", "", *numbers, ""]
    parts += ["", STRAIGHTENED, ""] if newton(model) else [""]
    return "\n".join([*parts, *_function(model), ""])


def _constant(constant: Constant) -> list[str]:
    values = constant.values
    comment = f"  # {constant.comment}"
    if values.ndim < 2:
        text = f"np.array({_numbers(values)})" if values.ndim else _number(float(values))
        return [f"{constant.name} = {text}{comment}"]
    rows = [f"    {_numbers(row)}," for row in values]
    return [f"{constant.name} = np.array([{comment}", *rows, "])"]


def _numbers(row: Array) -> str:
    return f"[{', '.join(_number(float(value)) for value in row)}]"


def _number(value: float) -> str:
    return repr(value) if np.isfinite(value) else repr(value).replace("inf", "np.inf")


def _function(model: SensorModel) -> list[str]:
    conditions = arguments(model)
    lines = [f"def compensate({', '.join(['v', *conditions])}):", *_docstring(model, conditions)]
    lines.append("    r = np.asarray(v, dtype=float) / S0")
    if thermal(model):
        lines.append("    away = temperature - REFERENCE_TEMPERATURE")
    words = {"i": "", "exp": "np.exp", "sign": "np.sign", "force": "G_SENSITIVITY @ specific_force"}
    first, *others = [term.format(**words) for term in offset_terms(model)]
    lines += [f"    offset = {first}", *(f"    offset = offset + {term}" for term in others), "    u = r - offset"]
    if newton(model):
        lines.append("    u = np.array([straightened(i, y) for i, y in enumerate(u)])")
    elif not model.linear:
        lines.append(CLOSED)
    matrix = matrix_at(model, "", "away[:, np.newaxis]")
    matrix += "".join(f" + np.diag({term.format(i='')})" for term in diagonal_terms(model))
    return [*lines, f"    x = np.linalg.solve({matrix}, u)", *_validity(model), "    return x, holds"]


def _docstring(model: SensorModel, conditions: dict[str, str]) -> list[str]:
    return [
        f'    """Return the true inputs [{model.unit}], and for each whether the model holds there.',
        "",
        f"    v: output of each sensor [{plain(model.output_unit)}], in the order {order(model)}",
        *(f"    {name}: {text}" for name, text in conditions.items()),
        f"    {MISSING}",
        '    """',
    ]


def _validity(model: SensorModel) -> list[str]:
    if model.input_range is None:
        lines = ["    holds = np.isfinite(x)"]
    else:
        lines = ["    holds = (INPUT_RANGE[:, 0] <= x) & (x <= INPUT_RANGE[:, 1])"]
    for name in checked_ranges(model):
        ends = range_name(name)
        lines.append(f"    holds &= np.all(({ends}[0] <= {name}) & ({name} <= {ends}[1]))")
    return lines


FORMAT = ModelFormat(
    name="python",
    title="python",
    dump=of_one(python_text),
    cannot_hold=lambda models: code_cannot_hold(models, "python"),
    one_sensor=True,
)

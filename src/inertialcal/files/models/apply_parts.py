"""What code that applies a model needs, whatever the language: constants, conditions, K0, words, refusal.

An expression is a template: ``{i}`` stands where a language picks the sensor, ``{exp}``, ``{sign}`` and ``{force}``
for what it calls these. Terms are added in the order of ``sensors.model.equation``, so that the code agrees with
``sensors.model.compensate`` to rounding.

Texts of a model (serial, axes, citations) are anybody's: in a comment they keep only characters that mean nothing
in Python and C; any other is written as its code point, ``<U+000A>``.
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.key import Kind
from ...core.remarks import Remark
from ...core.units import divide
from ...sensors.model.compensate import channel_range, check_unique
from ...sensors.model.equation import curve, needed
from ...sensors.model.nonlinearity import endless_slope, rising_branch
from ...sensors.model.sensitivity import Sensitivity, parameter_unit, quantity_of
from ...sensors.model.sensor_model import APPLY_ORDER, MATRIX_ORDER, SensorModel, formulas
from ...sensors.model.serial import model_checksum

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
SEVERAL = {"temperature", "temperature_rate", "specific_force"}  # conditions that are an array of one reading


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
    here = {one.channel: np.array([[one.reference]]) for one in model.sensitivities}
    if model.matrix.shape[0] > 1:
        here["temperature"] = model.terms["reference_temperature"][np.newaxis]
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
    lines += [f"Condition: {plain(model.condition)}"] if model.condition else []
    alone = " with this condition alone" if model.condition else ""
    lines.append(f"Checksum of model.json{alone}: {model_checksum(model)}")
    if model.source:
        lines.append(f"Source: {plain(model.source)}")
    if not model.judged:
        lines.append("Hold-out recordings have not confirmed this model.")
    lines += ["Equation, forward:", *(f"  {row}" for row in formulas(model))]
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
    lines += [
        f"No range of {one.channel} is stated: whether M can be inverted was looked at for its reference alone."
        for one in model.sensitivities
        if one.scale_factor is not None and channel_range(model, one) is None
    ]
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
    found += [
        Constant(quantity_of(part, one.channel).upper(), array, f"[{parameter_unit(part, unit, one.unit)}]")
        for one in model.sensitivities
        for part, array in one.parts.items()
    ]
    return found + _branch(model) + _conditions(model)


def thermal(model: SensorModel) -> bool:
    """Return whether the code needs T - T_ref."""
    with_channel = any(one.bias_temperature is not None for one in model.sensitivities)
    return model.bias_temperature is not None or model.matrix.shape[0] > 1 or with_channel


def arguments(model: SensorModel) -> dict[str, str]:
    """Return the conditions that the code takes, in order, with what each is."""
    found = {name: text for name, text in CONDITIONS.items() if name in needed(model)}
    return found | {_argument(one): f"{one.channel} [{one.unit}]" for one in model.sensitivities
                    if one.channel not in CONDITIONS}  # fmt: skip


def single(name: str) -> bool:
    """Return whether a condition is one number for all sensors."""
    return name not in SEVERAL


def _argument(one: Sensitivity) -> str:
    """Return the name of a channel in the code, where it may be no word of the language."""
    return one.channel if one.channel in CONDITIONS else f"channel_{one.channel}"


def _away(one: Sensitivity) -> str:
    return f"({_argument(one)} - CHANNEL_{one.channel.upper()}_REFERENCE)"


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
    for one in model.sensitivities:
        named = Constant(f"CHANNEL_{one.channel.upper()}_REFERENCE", np.array(float(one.reference)), f"[{one.unit}]")
        found.append(named)
    for name, (ends, unit) in checked_ranges(model).items():
        found.append(Constant(range_name(name), np.array(ends, dtype=float), f"that the model holds for [{unit}]"))
    return found


def checked_ranges(model: SensorModel) -> dict[str, tuple[tuple[float, float], str]]:
    """Return the conditions that the code takes and that the model has a validity range of, with it and its unit."""
    own = {name: (getattr(model, f"{name}_range"), unit) for name, unit in RANGES.items() if name in needed(model)}
    own |= {_argument(one): (one.range, one.unit) for one in model.sensitivities if one.channel not in CONDITIONS}
    return {name: (ends, unit) for name, (ends, unit) in own.items() if ends is not None}


def range_name(argument: str) -> str:
    """Return the name of the range of a condition in the code."""
    return f"{argument.upper()}_RANGE"


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
    terms += ["{force}"] if model.g_sensitivity is not None else []
    for one in model.sensitivities:
        for part in [part for part in ("bias", "bias_temperature") if part in one.parts]:
            own = f"{quantity_of(part, one.channel).upper()}{{i}} * {_away(one)}"
            terms.append(own if part == "bias" else f"{own} * away{{i}}")
    return terms


def diagonal_terms(model: SensorModel) -> list[str]:
    """Return what channels add to the diagonal of M, as templates of summands."""
    return [
        f"{quantity_of('scale_factor', one.channel).upper()}{{i}} * {_away(one)}"
        for one in model.sensitivities
        if one.scale_factor is not None
    ]


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

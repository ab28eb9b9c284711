"""A model in words: the equation with the terms that it has, and each parameter as a sentence with its figure."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...core.estimate import Array
from ...core.show.rounding import number, with_uncertainty
from ...core.show.tables import Folded, Grid, Part
from ...core.units import convert, divide, factor
from .sensor_model import SensorModel
from .serial import WORDS
from .terms import Parameter, values

FIELD_UNIT = {"gyro": "deg/s", "accelerometer": "ug"}  # in which people think of a bias
RANGE_UNIT = {"gyro": "deg/s", "accelerometer": "g"}  # and of a range or scale factor
PERCENT_DIGITS = 4

SENTENCES = {
    "bias_temperature": "{axis} bias, term in {power}",
    "bias_pressure": "{axis} bias, change with pressure",
    "bias_warm_up": "{axis} bias, part that dies away after power-up ({j})",
    "warm_up_time": "time constant of warm-up ({j})",
    "bias_temperature_rate": "{axis} bias, change with dT/dt",
    "bias_hysteresis": "{axis} bias, more by this when warming and less when cooling",
    "scale_factor_asymmetry": "{axis} scale factor, excess of positive over negative input",
    "second_order": "{axis} sensor, term in u^2",
    "third_order": "{axis} sensor, term in u^3",
}


@dataclass(frozen=True)
class Line:
    """One parameter.

    Parameters
    ----------
    name : str
        ``"misalignment_zx"``.
    words : str
        ``"z sensor reads 1.298 % of x motion"``.
    value, u : float
        Value and standard uncertainty; ``u`` is None where there is none.
    unit : str
        SI, and degC.
    note : str
        Why it has no uncertainty.
    origin : str
        Test and recordings, or citation.
    """

    name: str
    words: str
    value: float
    u: float | None
    unit: str
    note: str
    origin: str


def lines(model: SensorModel) -> tuple[Line, ...]:
    """Return every parameter of a model, in the order of the equation."""
    held = {} if model.estimate is None else dict(zip(model.estimate.names, model.estimate.u, strict=True))
    found = []
    for one, value in zip(model.parameters, values(model.parameters, model.terms), strict=True):
        u = held.get(one.name)
        note = "" if one.name in held else model.not_estimated.get(one.name, "no uncertainty")
        found.append(
            Line(
                one.name,
                _sentence(model, one),
                float(value),
                None if u is None else float(u),
                one.unit,
                note,
                _origin(model, one.name),
            )
        )
    return tuple(found)


def show(model: SensorModel) -> str:
    """Return a model as text: what it belongs to, its equation, its parameters in words, where it holds."""
    parts = [_head(model), "", "Equation (forward)", *(f"  {row}" for row in equation(model)), ""]
    parts += [f"Matrix M ({WORDS['matrix_order']})", *_matrix(model), ""]
    parts += _table(lines(model)) + _run_to_run(model)
    parts += ["", "Compensation: " + "; ".join(WORDS["apply_order"])]
    return "\n".join([*parts, *_validity(model)])


def parts(model: SensorModel) -> tuple[Part, ...]:
    """Return a model as tables: whose it is, equation, matrix, a row a parameter, where it holds."""
    order = WORDS["matrix_order"]
    entries = [(axis, *(f"{x:.8f}" for x in row)) for axis, row in zip(model.axes, model.matrix[0], strict=True)]
    matrix = Grid(("", *model.axes), entries, f"Matrix M_0 ({order})", tuple(range(1, len(model.axes) + 1)))
    rows = [(row.name, with_uncertainty(row.value, row.u), row.unit) for row in lines(model)]
    table = Grid(("parameter", "value ± u", "unit"), rows, "Parameters, SI and degC", (1,))
    words = Folded("In words: inertialcal show", tuple(f"{row.name}: {row.words}" for row in lines(model)))
    bare = sum(row.u is None for row in lines(model))
    missing = (f"{bare} of {len(rows)} parameters have no uncertainty",) if bare else ()
    said = [_head(model), *(f"  {row}" for row in equation(model))]
    ends = [*missing, *(row.strip() for row in _run_to_run(model)), *_validity(model)]
    return ("\n".join(said), matrix, table, words, *ends)


def _table(rows: tuple[Line, ...]) -> list[str]:
    """Words, name and figure of each parameter; what is the same for all stands once, at the top."""
    width = max(len(row.words) for row in rows)
    tails = ["; ".join(text for text in (row.note, row.origin) if text) for row in rows]
    common = tails[0] if len(set(tails)) == 1 else ""
    parts = [f"Parameters ({common})" if common else "Parameters"]
    for row, tail in zip(rows, tails, strict=True):
        unit = "" if row.unit == "1" else f" {row.unit}"
        figure = f"{row.name} = {with_uncertainty(row.value, row.u)}{unit}"
        parts.append(f"  {row.words:<{width}}  {figure}" + (f"  ({tail})" if tail and not common else ""))
    return parts


def equation(model: SensorModel) -> list[str]:
    """Return the equation with only the terms that the model has."""
    in_temperature = model.matrix.shape[0] > 1
    terms = ["K0", "u"]
    terms += ["K1'/2 |u|"] if model.scale_factor_asymmetry is not None else []
    terms += ["K2 u^2"] if model.second_order is not None else []
    terms += ["K3 u^3"] if model.third_order is not None else []
    terms += ["G f"] if model.g_sensitivity is not None else []
    offset = ["bias"]
    offset += [f"b_{j} {_power(j)}" for j in range(1, len(_rows(model.bias_temperature)) + 1)]
    offset += ["b_p (p - p_ref)"] if model.bias_pressure is not None else []
    offset += [f"A_{m + 1} exp(-t / tau_{m + 1})" for m in range(len(_rows(model.warm_up_time)))]
    offset += ["b_r dT/dt"] if model.bias_temperature_rate is not None else []
    offset += ["b_h sign(dT/dt)"] if model.bias_hysteresis is not None else []
    matrix = " + ".join(["M_0", *(f"M_{j} {_power(j)}" for j in range(1, model.matrix.shape[0]))])
    rows = ["u = M(T) x,  M(T) = " + matrix if in_temperature else "u = M x"]
    return [*rows, f"v = S0 * {{ {' + '.join(terms)} }} + noise", f"K0 = {' + '.join(offset)}", *_symbols(model)]


def _power(j: int) -> str:
    return "(T - T_ref)" if j == 1 else f"(T - T_ref)^{j}"


def _symbols(model: SensorModel) -> list[str]:
    """Return what the symbols stand for, where that is a number."""
    unit = model.unit if model.output_unit == model.unit else RANGE_UNIT[model.kind]
    told = divide(model.output_unit, unit)
    scale = model.scale_factor * factor(divide(model.output_unit, model.unit), told)
    rows = [
        f"x in {model.unit}, v in {model.output_unit}",
        f"S0 = {_per_axis(model, scale)} {'' if told == '1' else told}".rstrip(),
    ]
    if model.reference_temperature is not None:
        rows.append(f"T_ref = {_per_axis(model, model.reference_temperature)} degC")
    if model.bias_pressure is not None:
        rows.append(f"p_ref = {model.reference_pressure:g} Pa")
    return rows


def _per_axis(model: SensorModel, figures: Array) -> str:
    """One figure where all sensors have the same, else one a sensor."""
    texts = [number(figure) for figure in figures]
    if len(set(texts)) == 1:
        return texts[0]
    return ", ".join(f"{axis} {text}" for axis, text in zip(model.axes, texts, strict=True))


def _head(model: SensorModel) -> str:
    item = " ".join(text for text in (model.item.maker, model.item.part) if text) or "unnamed sensor"
    serial = f", serial {model.item.serial}" if model.item.serial else ""
    judged = "judged on held-out recordings" if model.judged else "not judged on held-out recordings"
    source = f"\nSource: {model.source}" if model.source else ""
    return f"{item}{serial}: {model.kind}, axes {', '.join(model.axes)}; {judged}{source}"


def _matrix(model: SensorModel) -> list[str]:
    rows = ["     " + "".join(f"{axis:>14}" for axis in model.axes)]
    for axis, row in zip(model.axes, model.matrix[0], strict=True):
        rows.append(f"  {axis:<3}" + "".join(f"{entry:>14.8f}" for entry in row))
    return rows


def _sentence(model: SensorModel, one: Parameter) -> str:
    if one.field == "matrix":
        return _matrix_sentence(model, one)
    if one.field == "bias":
        unit = FIELD_UNIT[model.kind]
        bias = float(convert(model.bias[one.index[0]], model.unit, unit))
        place = " and T_ref" if model.bias_temperature is not None else ""
        return f"{one.axis} sensor reads {number(bias, PERCENT_DIGITS)} {unit} at no input{place}"
    if one.field == "g_sensitivity":
        return f"{model.axes[one.index[0]]} sensor's reading of force along {one.axis[-1]}"
    return SENTENCES[one.field].format(axis=one.axis, j=one.index[0] + 1, power=_power(one.index[0] + 1))


def _matrix_sentence(model: SensorModel, one: Parameter) -> str:
    power, row, column = one.index
    sensor, moves = model.axes[row], model.axes[column]
    entry = 100.0 * float(model.matrix[one.index])
    if power:
        return f"{sensor} sensor and {moves} motion, term in {_power(power)}"
    if row != column and not entry and one.name in model.not_estimated:
        return f"{sensor} sensor and {moves} motion: not estimated, taken as none"
    if row != column:
        return f"{sensor} sensor reads {number(entry, PERCENT_DIGITS)} % of {moves} motion"
    excess = entry - 100.0
    sense = "too much" if excess >= 0.0 else "too little"
    return f"{sensor} sensor reads {number(abs(excess), PERCENT_DIGITS)} % {sense} of {moves} motion"


def _origin(model: SensorModel, name: str) -> str:
    one = model.provenance.get(name)
    if one is None:
        return ""
    recordings = f" on {', '.join(one.recordings)}" if one.recordings else ""
    return f"from {one.test}{recordings}" if one.test else one.source


def _run_to_run(model: SensorModel) -> list[str]:
    if model.bias_run_to_run is None:
        return []
    sizes = convert(model.bias_run_to_run, model.unit, FIELD_UNIT[model.kind])
    text = _per_axis(model, sizes)
    return [f"  bias from power-up to power-up, standard deviation: {text} {FIELD_UNIT[model.kind]}"]


def _validity(model: SensorModel) -> list[str]:
    rows = []
    if model.input_range is not None:
        unit = RANGE_UNIT[model.kind]
        ends = [f"{number(lo)} to {number(hi)}" for lo, hi in convert(model.input_range, model.unit, unit)]
        each = ", ".join(f"{axis} {text}" for axis, text in zip(model.axes, ends, strict=True))
        rows.append(f"inputs {ends[0] if len(set(ends)) == 1 else each} {unit}")
    if model.temperature_range is not None:
        rows.append("temperatures {:g} to {:g} degC".format(*model.temperature_range))
    if model.pressure_range is not None:
        rows.append("pressures {:g} to {:g} Pa".format(*model.pressure_range))
    return ["Holds for: " + ("; ".join(rows) if rows else "no range stated")]


def _rows(term: Array | None) -> Array:
    return np.empty(0) if term is None else term

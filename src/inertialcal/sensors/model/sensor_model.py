"""The sensor model: every term of the sensor equation, with covariance, validity and provenance; and it in words.

Forward, elementwise per sensor::

    u = M(T) x                                                 x: true input, angular rate or acceleration
    r = v / S0 = K0(T, p, t) + u + K1'/2 |u| + K2 u^2 + K3 u^3 + G f + noise
    K0 = bias + sum_j b_j (T - T_ref)^j + b_p (p - p_ref) + sum_m A_m exp(-t / tau_m)
              + b_r dT/dt + b_h sign(dT/dt) + sum_c (b_c + b_cT (T - T_ref)) d_c + run-to-run (random)
    M(T) = sum_j M_j (T - T_ref)^j + sum_c diag(s_c) d_c

Conventions, which hold wherever a model is used:

- ``r`` is the reading, in the input unit: the output ``v`` (volts or pulses a second) over the ideal scale
  factor ``S0``. All functions of readings take and give ``r``; ``to_readings`` and ``to_output`` cross over.
- Row = the sensor that reads, column = the axis that moves. ``scale_factor_error_x = M_xx - 1``, positive when
  the sensor reads too much. ``misalignment_xz = M_xz / M_xx``, positive when the x sensor reads more as z moves
  more.
- Bias, and every term of K0, is positive when it adds to the reading.
- x of a gyro is the rate against inertial space: it contains earth rate.
- f is the specific force along the body axes x, y, z [m/s2], whatever axes the model has.
- t is the time since power-up [s]; temperatures are in degC, pressures in Pa; T may differ per sensor.
- d_c = channel - reference, of each other channel c that bias or scale factor change with (`Sensitivity`).

References
----------
.. [1] IEEE Std 1293, section 8.3 (model equation of a linear accelerometer); IEEE Std 1431 and 952 (gyros);
   terms as in IEEE Std 528.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, dataclass, field
from dataclasses import fields as dataclass_fields
from functools import cache, cached_property

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array, Estimate
from ...core.figure import markup_of
from ...core.influence import Influence, Occasion, Selection
from ...core.key import Kind
from ...core.show.rounding import number, with_uncertainty
from ...core.show.tables import SHORT, Block, Details, Table, aligned, clean, html, text, wrapped
from ...core.units import convert, divide, factor, normalise, same_dimension
from ..chain.converter import Chain
from .sensitivity import Sensitivity
from .terms import (
    SHAPES,
    Parameter,
    check_axes,
    check_estimate,
    check_needs,
    check_ranges,
    check_sensitivities,
    parameters,
    read_only_term,
    values,
)

INPUT_UNIT: dict[str, str] = {"gyro": "rad/s", "accelerometer": "m/s^2"}

MATRIX_ORDER = "row = the sensor that reads, column = the axis that moves"
APPLY_ORDER = (
    "divide the output by scale_factor",
    "subtract K0 and G f",
    "invert the curve of each sensor",
    "multiply by the inverse of M",
)

FIELD_UNIT = {"gyro": "deg/s", "accelerometer": "ug"}  # in which people think of a bias
RANGE_UNIT = {"gyro": "deg/s", "accelerometer": "g"}  # and of a range or scale factor
NAMED = 3  # recordings behind a parameter; more are counted
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
SENSITIVITIES = {  # part of a sensitivity -> sentence
    "bias": "{axis} bias, change with {channel}",
    "bias_temperature": "{axis} bias, change with {channel} and T - T_ref together",
    "scale_factor": "{axis} scale factor, change with {channel}",
}


@dataclass(frozen=True)
class Item:
    """Which unit it is: maker, part number, serial number."""

    maker: str = ""
    part: str = ""
    serial: str = ""


@dataclass(frozen=True)
class Provenance:
    """Where a parameter comes from: identifier of the test, identifiers of its recordings, or a citation."""

    test: str = ""
    recordings: tuple[str, ...] = ()
    source: str = ""


@dataclass(frozen=True, eq=False)
class SensorModel:
    """Terms of the sensor equation of one unit; a term that is None is absent.

    Raises
    ------
    DataError
        If a shape does not fit, a number is not finite, or a term lacks what it needs.
    """

    kind: Kind  # What it senses; fixes the input unit, rad/s or m/s2
    axes: tuple[str, ...]  # One a sensor: ``("x", "y", "z")``
    scale_factor: Array  # shape (k,): ideal scale factor S0 [output unit / input unit]
    output_unit: str  # ``"V"``, ``"count/s"``, or the input unit where S0 is 1
    matrix: Array  # shape (q, k, k): m_0, M_1, ... [1/degC^j].
    bias: Array  # shape (k,): k0 at the reference conditions [input unit]
    item: Item = field(default_factory=Item)  # Which unit
    condition: str = ""  # Of the campaign, that the model is for; empty where none is told apart
    bias_temperature: Array | None = None  # shape (q, k): b_1, b_2, ... [input unit/degC^j].
    bias_pressure: Array | None = None  # shape (k,): b_p [input unit/Pa]
    bias_warm_up: Array | None = None  # shape (m, k): a_m [input unit]
    warm_up_time: Array | None = None  # shape (m,): tau_m [s]
    bias_temperature_rate: Array | None = None  # shape (k,): b_r [input unit/(degC/s)]
    bias_hysteresis: Array | None = None  # shape (k,): b_h, half the gap between warming and cooling [input unit]
    # shape (k,): standard deviation of the bias from power-up to power-up [input unit]; only in uncertainties
    bias_run_to_run: Array | None = None
    scale_factor_asymmetry: Array | None = None  # shape (k,): k1' [1]
    second_order: Array | None = None  # shape (k,): k2 [1/input unit]
    third_order: Array | None = None  # shape (k,): K3 [1/input unit^2]
    g_sensitivity: Array | None = None  # shape (k, 3): g [input unit/(m/s2)]
    sensitivities: tuple[Sensitivity, ...] = ()  # Change of bias and scale factor with other channels
    reference_temperature: Array | None = None  # shape (k,): t_ref [degC]; needed with terms in temperature
    reference_pressure: float | None = None  # p_ref [Pa]; needed with ``bias_pressure``
    # shape (k, 2): lowest and highest input along each axis that the model holds for [input unit]; both zero for
    # an axis that was never turned
    input_range: Array | None = None
    temperature_range: tuple[float, float] | None = None  # The same for temperature [degC]
    pressure_range: tuple[float, float] | None = None  # The same for pressure [Pa]
    # Values and covariance of the parameters, names as ``terms.parameters`` gives them
    estimate: Estimate | None = None
    chain: Chain | None = None  # From codes to readings, of the same axes; None where the model starts from readings
    # Noise terms by axis, SI, as the noise test names them; they take no part in compensation
    noise: Estimate | None = None
    not_estimated: Mapping[str, str] = field(default_factory=dict)  # Parameter -> why it has no uncertainty
    provenance: Mapping[str, Provenance] = field(default_factory=dict)  # Parameter -> where it comes from
    judged: bool = False  # Whether the closed loop has passed on recordings held out
    source: str = ""  # Citation, for published models
    # What another model, or another test, can share with it: influences that the estimate draws on, by name, as stated;
    # what drew their errors; its tests, and what they take of recordings
    influences: Mapping[str, Influence] = field(default_factory=dict)
    occasion: Occasion = field(default_factory=Occasion)
    tests: tuple[str, ...] = ()
    selections: tuple[Selection, ...] = ()

    def __post_init__(self) -> None:
        if self.kind not in INPUT_UNIT:
            raise DataError(f"kind {self.kind!r} is not known", do=f"Use one of: {', '.join(INPUT_UNIT)}")
        check_axes(self.axes)
        object.__setattr__(self, "output_unit", normalise(self.output_unit))
        for name in SHAPES:
            value = getattr(self, name)
            if value is not None:
                object.__setattr__(self, name, read_only_term(name, value, len(self.axes)))
        check_sensitivities(self.sensitivities, len(self.axes))
        terms = self.terms
        check_needs(terms, self.reference_pressure, self.sensitivities)
        ranges = {"temperature": self.temperature_range, "pressure": self.pressure_range}
        check_ranges(self.axes, terms, ranges | {one.channel: one.range for one in self.sensitivities if one.range})
        if self.estimate is not None:
            check_estimate(self.parameters, terms, self.estimate)
        if self.chain is not None:
            self._check_chain(self.chain)

    @classmethod
    def of_own(cls, fields: Mapping[str, object], own: tuple[Parameter, ...]) -> SensorModel:
        """Return one of terms that were checked, read-only (`are_plain`); ranges and the chain are checked here.

        Parameters
        ----------
        fields : mapping of str to object
            By name; the rest by default.
        own : tuple of Parameter
            Its `parameters`.

        Raises
        ------
        DataError
            As the class.
        """
        found: SensorModel = object.__new__(cls)
        found.__dict__.update({**_absent(), **fields, "parameters": own})
        ranges = {"temperature": found.temperature_range, "pressure": found.pressure_range}
        check_ranges(found.axes, {}, ranges)
        if found.chain is not None:
            found._check_chain(found.chain)
        return found

    def _check_chain(self, chain: Chain) -> None:
        """Refuse a chain that gives other readings than the model takes."""
        if (chain.axes, chain.unit) != (self.axes, self.unit) or chain.scale_factor is None:
            what = f"the chain gives {', '.join(chain.axes)} in {chain.unit or 'no unit'}"
            raise DataError(what, why=f"the model takes {', '.join(self.axes)} in {self.unit}", code="wrong_chain")
        scaled = np.broadcast_to(chain.scale_factor, len(self.axes))
        if chain.output_unit == self.output_unit and not np.array_equal(scaled, self.scale_factor):
            what = f"scale factor of the chain {scaled.tolist()}, of the model {self.scale_factor.tolist()}"
            raise DataError(what, why="readings from codes and from volts would differ", code="wrong_chain")

    @property
    def unit(self) -> str:
        """Input unit, SI: ``"rad/s"`` or ``"m/s^2"``."""
        return INPUT_UNIT[self.kind]

    @property
    def terms(self) -> dict[str, Array]:
        """Terms that are present, by name; those of sensitivities by the name of their quantity."""
        own = {name: getattr(self, name) for name in SHAPES if getattr(self, name) is not None}
        return own | {name: array for one in self.sensitivities for name, array in one.terms.items()}

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """Every number of the equation that a test can give, with name and unit."""
        return parameters(self.axes, self.unit, self.terms, self.sensitivities)

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: whose it is, equation, matrix, a row a parameter, where it holds."""
        return _parts(self)

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook, with its figure."""
        return html(self.parts(), markup_of(self))

    @property
    def linear(self) -> bool:
        """Whether the reading is a straight line in the input."""
        return all(
            term is None or not np.any(term)
            for term in (self.scale_factor_asymmetry, self.second_order, self.third_order)
        )


@cache
def _absent() -> dict[str, object]:
    """Return what fields of a model are by default."""
    return {
        one.name: one.default if one.default_factory is MISSING else one.default_factory()
        for one in dataclass_fields(SensorModel)
        if one.default is not MISSING or one.default_factory is not MISSING
    }


def to_readings(model: SensorModel, output: Array) -> Array:
    """Return readings v / S0 [input unit] of outputs v [output unit], shape (n, k)."""
    return np.asarray(output, dtype=float) / model.scale_factor


def to_output(model: SensorModel, readings: Array) -> Array:
    """Return outputs v = S0 r [output unit] of readings [input unit], shape (n, k)."""
    return np.asarray(readings, dtype=float) * model.scale_factor


def check_item(model: SensorModel, serial: str | None = None, unit: str | None = None) -> None:
    """Check that a model belongs to the unit at hand.

    Parameters
    ----------
    serial : str, optional
        Serial number of the sensor that gave the data.
    unit : str, optional
        Unit of the data: one of input or of output, at any scale.

    Raises
    ------
    DataError
        ``wrong_serial`` or ``wrong_unit``, with what the model is for.
    """
    if serial is not None and serial != model.item.serial:
        raise DataError(
            f"the model is for serial {model.item.serial!r}, the data are from serial {serial!r}",
            why="bias, scale factor and misalignment differ from unit to unit",
            do="Give the model of this sensor",
            code="wrong_serial",
        )
    if unit is not None and not any(same_dimension(unit, own) for own in (model.unit, model.output_unit)):
        raise DataError(
            f"the data are in {unit!r}, the model takes units like {model.unit!r} or {model.output_unit!r}",
            why=f"it is the model of a {model.kind}",
            do="Convert the data, or give the model of this sensor",
            code="wrong_unit",
        )


@dataclass(frozen=True)
class Line:
    """One parameter."""

    name: str  # ``"misalignment_zx"``
    words: str  # ``"z sensor reads 1.298 % of x motion"``
    # Value and standard uncertainty; ``u`` is None where there is none
    value: float
    u: float | None
    unit: str  # SI, and degC
    note: str  # Why it has no uncertainty
    origin: str  # Test and recordings, or citation


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
    parts = [*_head(model), "", "Equation (forward)", *(f"  {row}" for row in equation(model)), ""]
    parts += [f"Matrix M ({MATRIX_ORDER})"]
    above = "\n".join(wrapped(part, "    ") for part in parts)
    below = [*_run_to_run(model), *_noise(model), "", "Compensation: " + "; ".join(APPLY_ORDER), *_validity(model)]
    said = [above, *map(clean, _matrix(model)), "", _table(lines(model)), *(wrapped(part, "    ") for part in below)]
    return "\n".join(said)


def _parts(model: SensorModel) -> tuple[Block, ...]:
    """Return a model as tables: whose it is, equation, matrix, a row a parameter, where it holds."""
    order = MATRIX_ORDER
    entries = [(axis, *(f"{x:.8f}" for x in row)) for axis, row in zip(model.axes, model.matrix[0], strict=True)]
    matrix = Table(("", *model.axes), entries, f"Matrix M_0 ({order})", tuple(range(1, len(model.axes) + 1)))
    rows = [(row.name, with_uncertainty(row.value, row.u), row.unit) for row in lines(model)]
    table = Table(("parameter", "value ± u", "unit"), rows, "Parameters, SI and degC", (1,), len(rows) > SHORT)
    words = Details("In words: inertialcal show", tuple(f"{row.name}: {row.words}" for row in lines(model)))
    bare = sum(row.u is None for row in lines(model))
    missing = (f"{bare} of {len(rows)} parameters have no uncertainty",) if bare else ()
    said = [*_head(model), *(f"  {row}" for row in equation(model))]
    more = (*_run_to_run(model), *_noise(model))
    ends = [*missing, *(row.strip() for row in more), *_validity(model)]
    return (*said, matrix, table, words, *ends)


def _table(rows: tuple[Line, ...]) -> str:
    """Words, name and figure of each parameter; what several have in common stands once, above them."""
    groups: dict[str, list[Line]] = {}
    tails = ["; ".join(text for text in (row.note, row.origin) if text) for row in rows]
    for row, tail in zip(rows, tails, strict=True):
        groups.setdefault(tail if tails.count(tail) > 1 else "", []).append(row)
    parts = []
    for common, own in groups.items():
        parts.append(wrapped(f"Parameters ({common})" if common else "Parameters", "    "))
        cells = []
        for row in own:
            unit = "" if row.unit == "1" else f" {row.unit}"
            tail = "" if common else "; ".join(text for text in (row.note, row.origin) if text)
            figure = f"{row.name} = {with_uncertainty(row.value, row.u)}{unit}"
            cells.append([f"  {row.words}", figure + (f"  ({tail})" if tail else "")])
        parts.append(aligned(cells))
    return "\n".join(parts)


def equation(model: SensorModel) -> list[str]:
    """Return the equation with only the terms that the model has, and what its symbols stand for."""
    return [*formulas(model), *_symbols(model)]


def formulas(model: SensorModel) -> list[str]:
    """Return the equation with only the terms that the model has."""
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
    for one in model.sensitivities:
        name = one.channel
        offset += [f"b_{name} d_{name}"] if one.bias is not None else []
        offset += [f"b_{name}_T d_{name} (T - T_ref)"] if one.bias_temperature is not None else []
    rows = [_matrix_formula(model), f"v = S0 * {{ {' + '.join(terms)} }} + noise", f"K0 = {' + '.join(offset)}"]
    return rows + [f"d_{one.channel} = {one.channel} - {one.reference:g} {one.unit}" for one in model.sensitivities]


def _matrix_formula(model: SensorModel) -> str:
    scaled = [one.channel for one in model.sensitivities if one.scale_factor is not None]
    of = (["T"] if model.matrix.shape[0] > 1 else []) + scaled
    if not of:
        return "u = M x"
    terms = ["M_0", *(f"M_{j} {_power(j)}" for j in range(1, model.matrix.shape[0]))]
    terms += [f"diag(s_{name}) d_{name}" for name in scaled]
    matrix = f"M({', '.join(of)})"
    return f"u = {matrix} x,  {matrix} = {' + '.join(terms)}"


def _power(j: int) -> str:
    return "(T - T_ref)" if j == 1 else f"(T - T_ref)^{j}"


def _symbols(model: SensorModel) -> list[str]:
    """Return what the symbols stand for, where that is a number."""
    unit = model.unit if model.output_unit == model.unit else RANGE_UNIT[model.kind]
    scale_unit = divide(model.output_unit, unit)
    scale = model.scale_factor * factor(divide(model.output_unit, model.unit), scale_unit)
    rows = [
        f"x in {model.unit}, v in {model.output_unit}",
        f"S0 = {_per_axis(model, scale)} {'' if scale_unit == '1' else scale_unit}".rstrip(),
    ]
    if model.reference_temperature is not None:
        rows.append(f"T_ref = {_per_axis(model, model.reference_temperature)} degC")
    if model.bias_pressure is not None:
        rows.append(f"p_ref = {model.reference_pressure:g} Pa")
    return rows


def _per_axis(model: SensorModel, figures: Array, digits: int = 6) -> str:
    """One figure where all sensors have the same, else one a sensor."""
    texts = [number(figure, digits) for figure in figures]
    if len(set(texts)) == 1:
        return texts[0]
    return ", ".join(f"{axis} {text}" for axis, text in zip(model.axes, texts, strict=True))


def _head(model: SensorModel) -> list[str]:
    item = " ".join(text for text in (model.item.maker, model.item.part) if text) or "unnamed sensor"
    serial = f", serial {model.item.serial}" if model.item.serial else ""
    judged = "judged on held-out recordings" if model.judged else "not confirmed by held-out recordings"
    source = [f"Source: {model.source}"] if model.source else []
    condition = f"; condition {model.condition}" if model.condition else ""
    return [f"{item}{serial}: {model.kind}, axes {', '.join(model.axes)}{condition}; {judged}", *source]


def _matrix(model: SensorModel) -> list[str]:
    rows = ["     " + "".join(f"{axis:>14}" for axis in model.axes)]
    for axis, row in zip(model.axes, model.matrix[0], strict=True):
        rows.append(f"  {axis:<3}" + "".join(f"{entry:>14.8f}" for entry in row))
    return rows


def _sentence(model: SensorModel, one: Parameter) -> str:
    value = float(values([one], model.terms)[0])
    over_temperature = one.field == "matrix" and one.index[0]
    if one.name in model.not_estimated and value == 0.0 and not over_temperature:
        words = {"scale_factor_error": "scale factor"}.get(one.key.quantity, one.key.quantity.replace("_", " "))
        return f"{one.axis} {words}: not estimated"
    if one.field == "matrix":
        return _matrix_sentence(model, one)
    if one.field == "bias":
        unit = FIELD_UNIT[model.kind]
        bias = float(convert(model.bias[one.index[0]], model.unit, unit))
        place = " and T_ref" if model.bias_temperature is not None else ""
        place = " and reference conditions" if model.sensitivities else place
        return f"{one.axis} sensor reads {number(bias, PERCENT_DIGITS)} {unit} at no input{place}"
    if one.field == "g_sensitivity":
        return f"{model.axes[one.index[0]]} sensor's reading of force along {one.axis[-1]}"
    if one.channel:
        return SENSITIVITIES[one.part].format(axis=one.axis, channel=one.channel.replace("_", " "))
    return SENTENCES[one.field].format(axis=one.axis, j=one.index[0] + 1, power=_power(one.index[0] + 1))


def _matrix_sentence(model: SensorModel, one: Parameter) -> str:
    power, row, column = one.index
    sensor, moves = model.axes[row], model.axes[column]
    entry = 100.0 * float(model.matrix[one.index])
    if power:
        lacking = ": not estimated" if one.name in model.not_estimated and entry == 0.0 else ""
        return f"{sensor} sensor and {moves} motion, term in {_power(power)}{lacking}"
    if row != column:
        return f"{sensor} sensor reads {number(entry, PERCENT_DIGITS)} % of {moves} motion"
    excess = entry - 100.0
    sense = "too much" if excess >= 0.0 else "too little"
    return f"{sensor} sensor reads {number(abs(excess), PERCENT_DIGITS)} % {sense} of {moves} motion"


def _origin(model: SensorModel, name: str) -> str:
    one = model.provenance.get(name)
    if one is None:
        return ""
    several = len(one.recordings) > NAMED
    named = f"{len(one.recordings)} recordings" if several else ", ".join(one.recordings)
    recordings = f" on {named}" if named else ""
    return f"from {one.test}{recordings}" if one.test else one.source


def _run_to_run(model: SensorModel) -> list[str]:
    if model.bias_run_to_run is None:
        return []
    sizes = convert(model.bias_run_to_run, model.unit, FIELD_UNIT[model.kind])
    text = _per_axis(model, sizes, PERCENT_DIGITS)
    return [f"  bias from power-up to power-up, standard deviation: {text} {FIELD_UNIT[model.kind]}"]


def _noise(model: SensorModel) -> list[str]:
    """Return each kind of noise, all axes on a line."""
    if model.noise is None:
        return []
    found: dict[str, list[str]] = {}
    for key, value, u, unit in zip(model.noise.keys, model.noise.values, model.noise.u, model.noise.units, strict=True):
        text = f"{key.axis} {with_uncertainty(float(value), float(u))} {'' if unit == '1' else unit}"
        found.setdefault(key.name.replace("_", " "), []).append(text.strip())
    return [f"  noise, {name}: {', '.join(texts)}" for name, texts in found.items()]


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
    rows += [f"{one.channel} {one.range[0]:g} to {one.range[1]:g} {one.unit}" for one in model.sensitivities
             if one.range is not None]  # fmt: skip
    return [*_chain(model), "Holds for: " + ("; ".join(rows) if rows else "no range stated")]


def _chain(model: SensorModel) -> list[str]:
    """Return what the chain of the model starts from."""
    chain = model.chain
    if chain is None:
        return []
    words = [f"one count {number(chain.step)} {chain.output_unit}"]
    words += [f"codes {chain.codes[0]} to {chain.codes[1]}"] if chain.codes else []
    if chain.reference == "channel":
        words.append("less the reference channel")
    elif chain.reference:
        words.append(f"less {number(float(chain.reference))} {chain.output_unit}")
    words += ["temperature from its channel"] if chain.thermometer is not None else []
    words += (
        [f"good while the built-in test is {number(chain.validity_minimum)} V or more"]
        if chain.validity_minimum
        else []
    )
    return ["Starts from counts: " + ", ".join(words)]


def _rows(term: Array | None) -> Array:
    return np.empty(0) if term is None else term

"""The sensor model: every term of the sensor equation, with covariance, validity and provenance.

Forward, elementwise per sensor::

    u = M(T) x                                                 x: true input, angular rate or acceleration
    r = v / S0 = K0(T, p, t) + u + K1'/2 |u| + K2 u^2 + K3 u^3 + G f + noise
    K0 = bias + sum_j b_j (T - T_ref)^j + b_p (p - p_ref) + sum_m A_m exp(-t / tau_m)
              + b_r dT/dt + b_h sign(dT/dt) + run-to-run (random)
    M(T) = sum_j M_j (T - T_ref)^j

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

References
----------
.. [1] IEEE Std 1293, section 8.3 (model equation of a linear accelerometer); IEEE Std 1431 and 952 (gyros);
   terms as in IEEE Std 528.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...core.axes import Kind
from ...core.errors import DataError
from ...core.estimate import Array, Estimate
from ...core.show.tables import Part, html, text
from ...core.units import normalise, same_dimension
from .terms import FORCE_AXES, Parameter, parameters, values

INPUT_UNIT: dict[str, str] = {"gyro": "rad/s", "accelerometer": "m/s^2"}

AGREEMENT = 1e-9  # largest relative difference of a term from the same number in the estimate
SMALLEST = 1e-4  # below this a difference is absolute: M_xx - 1 has no more digits than M_xx

# Shapes of the terms: k sensors, q powers of temperature, m warm-up exponentials, f force axes.
SHAPES: dict[str, tuple[str, ...]] = {
    "scale_factor": ("k",),
    "matrix": ("q", "k", "k"),
    "bias": ("k",),
    "bias_temperature": ("q", "k"),
    "bias_pressure": ("k",),
    "bias_warm_up": ("m", "k"),
    "warm_up_time": ("m",),
    "bias_temperature_rate": ("k",),
    "bias_hysteresis": ("k",),
    "bias_run_to_run": ("k",),
    "scale_factor_asymmetry": ("k",),
    "second_order": ("k",),
    "third_order": ("k",),
    "g_sensitivity": ("k", "f"),
    "reference_temperature": ("k",),
    "input_range": ("k", "2"),
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

    Parameters
    ----------
    kind : {"gyro", "accelerometer"}
        What it senses; fixes the input unit, rad/s or m/s2.
    axes : tuple of str
        One a sensor: ``("x", "y", "z")``.
    item : Item
        Which unit.
    scale_factor : ndarray, shape (k,)
        Ideal scale factor S0 [output unit / input unit].
    output_unit : str
        ``"V"``, ``"count/s"``, or the input unit where S0 is 1.
    matrix : ndarray, shape (q, k, k) or (k, k)
        M_0, M_1, ... [1/degC^j].
    bias : ndarray, shape (k,)
        K0 at the reference conditions [input unit].
    bias_temperature : ndarray, shape (q, k), optional
        b_1, b_2, ... [input unit/degC^j].
    bias_pressure : ndarray, shape (k,), optional
        b_p [input unit/Pa].
    bias_warm_up : ndarray, shape (m, k), optional
        A_m [input unit].
    warm_up_time : ndarray, shape (m,), optional
        tau_m [s].
    bias_temperature_rate : ndarray, shape (k,), optional
        b_r [input unit/(degC/s)].
    bias_hysteresis : ndarray, shape (k,), optional
        b_h, half the gap between warming and cooling [input unit].
    bias_run_to_run : ndarray, shape (k,), optional
        Standard deviation of the bias from power-up to power-up [input unit]; only in uncertainties.
    scale_factor_asymmetry : ndarray, shape (k,), optional
        K1' [1].
    second_order, third_order : ndarray, shape (k,), optional
        K2 [1/input unit] and K3 [1/input unit^2].
    g_sensitivity : ndarray, shape (k, 3), optional
        G [input unit/(m/s2)].
    reference_temperature : ndarray, shape (k,), or float, optional
        T_ref [degC]; needed with terms in temperature.
    reference_pressure : float, optional
        p_ref [Pa]; needed with ``bias_pressure``.
    input_range : ndarray, shape (k, 2), optional
        Lowest and highest input along each axis that the model holds for [input unit]; both zero for an axis that
        was never turned.
    temperature_range, pressure_range : (float, float), optional
        The same for temperature [degC] and pressure [Pa].
    estimate : Estimate, optional
        Values and covariance of the parameters, names as ``terms.parameters`` gives them.
    not_estimated : mapping of str to str
        Parameter -> why it has no uncertainty.
    provenance : mapping of str to Provenance
        Parameter -> where it comes from.
    judged : bool
        Whether the closed loop has passed on recordings held out.
    source : str
        Citation, for published models.

    Raises
    ------
    DataError
        If a shape does not fit, a number is not finite, or a term lacks what it needs.
    """

    kind: Kind
    axes: tuple[str, ...]
    scale_factor: Array
    output_unit: str
    matrix: Array
    bias: Array
    item: Item = field(default_factory=Item)
    bias_temperature: Array | None = None
    bias_pressure: Array | None = None
    bias_warm_up: Array | None = None
    warm_up_time: Array | None = None
    bias_temperature_rate: Array | None = None
    bias_hysteresis: Array | None = None
    bias_run_to_run: Array | None = None
    scale_factor_asymmetry: Array | None = None
    second_order: Array | None = None
    third_order: Array | None = None
    g_sensitivity: Array | None = None
    reference_temperature: Array | None = None
    reference_pressure: float | None = None
    input_range: Array | None = None
    temperature_range: tuple[float, float] | None = None
    pressure_range: tuple[float, float] | None = None
    estimate: Estimate | None = None
    not_estimated: Mapping[str, str] = field(default_factory=dict)
    provenance: Mapping[str, Provenance] = field(default_factory=dict)
    judged: bool = False
    source: str = ""

    def __post_init__(self) -> None:
        if self.kind not in INPUT_UNIT:
            raise DataError(f"kind {self.kind!r} is not known", do=f"Use one of: {', '.join(INPUT_UNIT)}")
        _check_axes(self.axes)
        object.__setattr__(self, "output_unit", normalise(self.output_unit))
        sizes = {"k": len(self.axes), "f": len(FORCE_AXES), "2": 2}
        for name, letters in SHAPES.items():
            value = getattr(self, name)
            if value is not None:
                object.__setattr__(self, name, _frozen(name, value, letters, sizes))
        _check_needs(self)
        if self.estimate is not None:
            _check_estimate(self, self.estimate)

    @property
    def unit(self) -> str:
        """Input unit, SI: ``"rad/s"`` or ``"m/s^2"``."""
        return INPUT_UNIT[self.kind]

    @property
    def terms(self) -> dict[str, Array]:
        """Terms that are present, by name."""
        return {name: getattr(self, name) for name in SHAPES if getattr(self, name) is not None}

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Every number of the equation that a test can give, with name and unit."""
        return parameters(self.axes, self.unit, self.terms)

    def parts(self) -> tuple[Part, ...]:
        """Return what is shown: whose it is, equation, matrix, a row a parameter, where it holds."""
        from .words import parts  # noqa: PLC0415 - words are written about a model, and import it

        return parts(self)

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook."""
        return html(self.parts())

    @property
    def linear(self) -> bool:
        """Whether the reading is a straight line in the input."""
        return all(
            term is None or not np.any(term)
            for term in (self.scale_factor_asymmetry, self.second_order, self.third_order)
        )


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


def _check_axes(axes: tuple[str, ...]) -> None:
    pairs = [a + b for a in axes for b in axes]
    if not axes or "" in axes or any("_" in axis for axis in axes) or len(set(pairs)) != len(pairs):
        raise DataError(f"axes {axes!r} cannot be told apart", do='Name them like ("x", "y", "z")')


def _frozen(name: str, value: Any, letters: tuple[str, ...], sizes: Mapping[str, int]) -> Array:
    """Read-only copy of a term; a constant matrix becomes M_0, one number serves all sensors."""
    array = np.array(value, dtype=float)
    if array.ndim == 0 and letters == ("k",):
        array = np.full(sizes["k"], float(array))
    if name == "matrix" and array.ndim == len(letters) - 1:
        array = array[np.newaxis]
    fits = array.ndim == len(letters) and all(
        sizes.get(letter, length) == length and length > 0 for letter, length in zip(letters, array.shape, strict=True)
    )
    if not fits:
        need = ", ".join(str(sizes.get(letter, letter)) for letter in letters)
        raise DataError(f"{name}: shape {array.shape}, need ({need})")
    if not np.all(np.isfinite(array)):
        raise DataError(f"{name}: not finite", do="Leave out a term that is not known")
    array.setflags(write=False)
    return array


def _check_needs(model: SensorModel) -> None:
    """Refuse a term without what it needs beside itself."""
    if np.any(model.scale_factor == 0.0):
        raise DataError(f"scale_factor {model.scale_factor.tolist()}: zero", do="Give the ideal scale factor")
    in_temperature = model.bias_temperature is not None or model.matrix.shape[0] > 1
    if in_temperature and model.reference_temperature is None:
        raise DataError("terms in temperature without reference_temperature", do="Give T_ref [degC]")
    if model.bias_pressure is not None and model.reference_pressure is None:
        raise DataError("bias_pressure without reference_pressure", do="Give p_ref [Pa]")
    amplitudes = 0 if model.bias_warm_up is None else model.bias_warm_up.shape[0]
    times = np.empty(0) if model.warm_up_time is None else model.warm_up_time
    if amplitudes != len(times) or np.any(times <= 0.0):
        raise DataError(
            f"bias_warm_up has {amplitudes} term(s), warm_up_time is {times.tolist()}",
            do="Give one positive time constant [s] a term",
        )
    if model.bias_run_to_run is not None and np.any(model.bias_run_to_run < 0.0):
        raise DataError("bias_run_to_run: a standard deviation is negative")
    _check_ranges(model)


def _check_ranges(model: SensorModel) -> None:
    ranges = {"temperature_range": model.temperature_range, "pressure_range": model.pressure_range}
    if model.input_range is not None:
        ranges |= {f"input_range of {a}": (lo, hi) for a, (lo, hi) in zip(model.axes, model.input_range, strict=True)}
    for name, ends in ranges.items():
        if ends is not None and not ends[0] <= ends[1]:
            raise DataError(f"{name}: {ends[0]:g} to {ends[1]:g}", do="Give the lower end first")


def _check_estimate(model: SensorModel, estimate: Estimate) -> None:
    """Refuse an estimate that holds other numbers, or other units, than the terms."""
    known = {one.name: one for one in model.parameters}
    strangers = [name for name in estimate.names if name not in known]
    if strangers:
        raise DataError(
            f"the estimate has {', '.join(strangers)}, which the model has not", do=f"It has: {', '.join(known)}"
        )
    chosen = [known[name] for name in estimate.names]
    for one, unit in zip(chosen, estimate.units, strict=True):
        if unit != one.unit:
            raise DataError(f"{one.name} is estimated in {unit!r}, the model needs {one.unit!r}", code="wrong_unit")
    for one, own, other in zip(chosen, values(chosen, model.terms), estimate.values, strict=True):
        if not abs(own - other) <= AGREEMENT * max(abs(own), SMALLEST):
            raise DataError(f"{one.name} is {own:.12g} in the model and {other:.12g} in its estimate")

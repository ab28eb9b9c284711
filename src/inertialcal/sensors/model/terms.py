"""Parameters of the sensor equation: the name, unit and place of every number in the terms of a model.

The matrix at the reference temperature has the field's words: ``scale_factor_error_x = M_xx - 1`` and
``misalignment_xz = M_xz / M_xx``. Its coefficients in temperature are plain entries of M_j:
``scale_factor_error_temperature_1_x``, ``cross_axis_sensitivity_temperature_1_xz`` (not divided by M_xx).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array, Estimate
from ...core.key import Key
from ...core.unit.magnitudes import CODE, LARGEST, is_possible
from ...core.unit.magnitudes import SMALLEST as TINIEST
from ...core.units import normalise
from .sensitivity import HIGHEST, PARTS, Sensitivity, parameter_unit, quantity_of

FORCE_AXES = ("x", "y", "z")

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

# field of the model -> quantity and unit; U is the input unit, j counts powers or exponentials from 1.
PER_AXIS = {
    "bias": ("bias", "{U}"),
    "bias_pressure": ("bias_pressure", "{U}/Pa"),
    "bias_temperature_rate": ("bias_temperature_rate", "({U})/(degC/s)"),
    "bias_hysteresis": ("bias_hysteresis", "{U}"),
    "scale_factor_asymmetry": ("scale_factor_asymmetry", "1"),
    "second_order": ("second_order", "1/({U})"),
    "third_order": ("third_order", "1/({U})^2"),
}
PER_POWER = {
    "bias_temperature": ("bias_temperature", "{U}/degC"),
    "bias_warm_up": ("bias_warm_up", "{U}"),
}
COUNTED = {
    "bias_temperature": "bias_temperature", "bias_warm_up": "bias_warm_up", "warm_up_time": "bias_warm_up",
    "scale_factor_error_temperature": "matrix", "cross_axis_sensitivity_temperature": "matrix",
}  # terms of which there are several: whose number they have  # fmt: skip
AGREEMENT = 1e-9  # largest relative difference of a term from the same number in the estimate
SMALLEST = 1e-4  # below this a difference is absolute: M_xx - 1 has no more digits than M_xx


@dataclass(frozen=True)
class Parameter:
    """One number of a model."""

    key: Key
    unit: str  # SI, and degC
    field: str  # term that holds it: attribute of the model, or quantity of a sensitivity
    index: tuple[int, ...]  # where in that array
    channel: str = ""  # of a sensitivity: to what
    part: str = ""  # of a sensitivity: which of its arrays

    @cached_property
    def name(self) -> str:
        """Its name for people, and in files: ``"misalignment_xz"``."""
        return str(self.key)

    @property
    def axis(self) -> str:
        """Of the sensor; two letters for an entry of the matrix."""
        return self.key.axis


def parameters(
    axes: Sequence[str], unit: str, arrays: Mapping[str, Array], sensitivities: Iterable[Sensitivity] = ()
) -> tuple[Parameter, ...]:
    """Return the parameters of the terms that are present."""
    lengths = tuple((name, len(array)) for name, array in arrays.items())
    channels = tuple((one.channel, one.unit, tuple(one.parts)) for one in sensitivities)
    return _parameters(tuple(axes), unit, lengths, channels)


@lru_cache(maxsize=64)
def _parameters(
    axes: tuple[str, ...],
    unit: str,
    lengths: tuple[tuple[str, int], ...],
    sensitivities: tuple[tuple[str, str, tuple[str, ...]], ...],
) -> tuple[Parameter, ...]:
    arrays = dict(lengths)
    found = _matrix(axes, arrays["matrix"])
    for name, (quantity, form) in PER_AXIS.items():
        if name in arrays:
            found += [_parameter(Key(quantity, a), form, unit, name, (i,)) for i, a in enumerate(axes)]
    for name, (quantity, form) in PER_POWER.items():
        for j in range(arrays.get(name, 0)):
            power = f"^{j + 1}" if j and name == "bias_temperature" else ""
            keys = [Key(quantity, a, power=j + 1) for a in axes]
            found += [_parameter(key, form + power, unit, name, (j, i)) for i, key in enumerate(keys)]
    for m in range(arrays.get("warm_up_time", 0)):
        found.append(_parameter(Key("warm_up_time", power=m + 1), "s", unit, "warm_up_time", (m,)))
    if "g_sensitivity" in arrays:
        pairs = [(i, a, j, f) for i, a in enumerate(axes) for j, f in enumerate(FORCE_AXES)]
        found += [
            _parameter(Key("g_sensitivity", a + f), "({U})/(m/s^2)", unit, "g_sensitivity", (i, j))
            for i, a, j, f in pairs
        ]
    for channel, its, parts in sensitivities:
        for part in parts:
            name, per_channel = quantity_of(part, channel), parameter_unit(part, unit, its)
            found += [Parameter(Key(name, a), per_channel, name, (i,), channel, part) for i, a in enumerate(axes)]
    return tuple(found)


def _parameter(key: Key, form: str, unit: str, field: str, index: tuple[int, ...]) -> Parameter:
    return Parameter(key, normalise(form.replace("{U}", unit)), field, index)


def _matrix(axes: Sequence[str], powers: int) -> list[Parameter]:
    found = []
    for j in range(powers):
        diagonal = "scale_factor_error_temperature" if j else "scale_factor_error"
        cross = "cross_axis_sensitivity_temperature" if j else "misalignment"
        unit = f"1/degC^{j}" if j > 1 else "1/degC" if j else "1"
        for i, row in enumerate(axes):
            found.append(_parameter(Key(diagonal, row, power=j), unit, "", "matrix", (j, i, i)))
        for i, row in enumerate(axes):
            for column_at, column in enumerate(axes):
                if i != column_at:
                    key = Key(cross, row + column, power=j)
                    found.append(_parameter(key, unit if j else "rad", "", "matrix", (j, i, column_at)))
    return found


def values(wanted: Iterable[Parameter], arrays: Mapping[str, Array]) -> Array:
    """Return the values of parameters, each in its unit."""
    return np.array([_value(one, arrays[one.field]) for one in wanted])


def _value(one: Parameter, array: Array) -> float:
    if one.field == "matrix" and one.index[0] == 0:
        _, row, column = one.index
        diagonal = float(array[0, row, row])
        return diagonal - 1.0 if row == column else float(array[0, row, column]) / diagonal
    return float(array[one.index])


def with_values(arrays: Mapping[str, Array], changes: Mapping[Parameter, Array | float]) -> dict[str, Array]:
    """Return the arrays with some parameters set; the others keep their values.

    A misalignment is a ratio, so a new scale factor error takes its row of the matrix along. Of one model, or of many
    along the first axis of arrays and values.
    """
    new = {name: np.array(array) for name, array in arrays.items()}
    at_reference = {one: value for one, value in changes.items() if one.field == "matrix" and one.index[0] == 0}
    for one, value in changes.items():
        if one not in at_reference:
            at: Any = (..., *one.index)
            new[one.field][at] = value
    matrix = new["matrix"][..., 0, :, :] if at_reference else np.empty(0)
    for one, value in at_reference.items():
        _, row, column = one.index
        if row == column:
            matrix[..., row, :] *= np.asarray((1.0 + value) / matrix[..., row, row])[..., np.newaxis]
            matrix[..., row, row] = 1.0 + value
    for one, value in at_reference.items():
        _, row, column = one.index
        if row != column:
            matrix[..., row, column] = value * matrix[..., row, row]
    return new


def parameter_keys(names: Iterable[str], axes: Sequence[str], channels: Iterable[str] = ()) -> list[Key]:
    """Return the keys of the names that are parameters of a model with these axes, of any order up to `HIGHEST`.

    Parameters
    ----------
    channels : iterable of str
        Names of the channels that the model has sensitivities to.
    """
    known = dict(_every_key(tuple(axes)))
    for channel in channels:
        for part in PARTS:
            keys = [Key(quantity_of(part, channel), axis) for axis in axes]
            known |= {str(key): key for key in keys}
    return [known[name] for name in names if name in known]


@lru_cache(maxsize=64)
def _every_key(axes: tuple[str, ...]) -> Mapping[str, Key]:
    """Return the keys of all terms of models with these axes but sensitivities to channels, by their names."""
    blank = {name: np.zeros((HIGHEST, *(len(axes) for side in shape[1:]))) for name, shape in SHAPES.items()}
    return {one.name: one.key for one in parameters(axes, "rad/s", blank)}  # in whatever unit


def orders(keys: Iterable[Key]) -> dict[str, int]:
    """Highest power of temperature, or number of exponentials, of the counted terms among the keys.

    Returns
    -------
    dict of str to int
        ``matrix`` (0 when constant), ``bias_temperature`` and ``bias_warm_up``.
    """
    found = {"matrix": 0, "bias_temperature": 0, "bias_warm_up": 0}
    for key in keys:
        if key.quantity in COUNTED:
            found[COUNTED[key.quantity]] = max(found[COUNTED[key.quantity]], key.power)
    return found


def check_axes(axes: tuple[str, ...]) -> None:
    """Refuse axes whose pairs are ambiguous.

    Raises
    ------
    DataError
        As said.
    """
    pairs = [a + b for a in axes for b in axes]
    if not axes or "" in axes or any("_" in axis for axis in axes) or len(set(pairs)) != len(pairs):
        raise DataError(f"axes {axes!r} are ambiguous", do='Name them like ("x", "y", "z")')


def read_only_term(name: str, value: object, sensors: int) -> Array:
    """Return a read-only copy of a term; a constant matrix becomes M_0, one number serves all sensors.

    Raises
    ------
    DataError
        If its shape does not fit, or a number is not finite.
    """
    array: Array = stacked_term(name, [value], sensors)[0]
    check_size(name, array)
    array.setflags(write=False)
    return array


def stacked_term(name: str, each: Sequence[object], sensors: int) -> Array:
    """Return a term of many models, given in one shape, along the first axis; as `read_only_term` takes it.

    Raises
    ------
    DataError
        If its shape does not fit.
    """
    letters = SHAPES[name]
    sizes = {"k": sensors, "f": len(FORCE_AXES), "2": 2}
    array = np.array(each, dtype=float)
    if array.ndim == 1 and letters == ("k",):
        array = np.repeat(array[:, np.newaxis], sizes["k"], axis=1)
    if name == "matrix" and array.ndim == len(letters):
        array = array[:, np.newaxis]
    shape = array.shape[1:]
    fits = len(shape) == len(letters) and all(
        sizes.get(letter, length) == length and length > 0 for letter, length in zip(letters, shape, strict=True)
    )
    if not fits:
        need = ", ".join(str(sizes.get(letter, letter)) for letter in letters)
        raise DataError(f"{name}: shape {shape}, need ({need})")
    return array


def are_plain(axes: Sequence[str], terms: Mapping[str, Array]) -> bool:
    """Return whether a look at the terms of many models, along the first axis, finds nothing to refuse.

    That is what `check_axes`, `check_size`, `check_needs` but for the pressure, `check_ranges` of inputs and
    `check_estimate` look for, where the terms were made of the values of the estimate.
    """
    try:
        check_axes(tuple(axes))
    except DataError:
        return False
    if not all(array.size == 0 or np.abs(array).max() <= LARGEST for array in terms.values()):
        return False
    diagonal = terms["matrix"][:, 0].diagonal(axis1=1, axis2=2)
    if not (np.abs(terms["scale_factor"]) >= TINIEST).all() or not (np.abs(diagonal) >= TINIEST).all():
        return False
    in_temperature = "bias_temperature" in terms or terms["matrix"].shape[1] > 1
    ends = terms.get("input_range")
    return (
        not (in_temperature and "reference_temperature" not in terms)
        and ("bias_warm_up" in terms) == ("warm_up_time" in terms)
        and not ("warm_up_time" in terms and terms["bias_warm_up"].shape[1] != terms["warm_up_time"].shape[1])
        and not np.any(terms.get("warm_up_time", 1.0) <= 0.0)
        and not np.any(terms.get("bias_run_to_run", 0.0) < 0.0)
        and (ends is None or bool((ends[..., 0] <= ends[..., 1]).all()))
    )


def check_sensitivities(sensitivities: Sequence[Sensitivity], sensors: int) -> None:
    """Refuse sensitivities of another shape, of which two are to one channel, or whose names another term has.

    Raises
    ------
    DataError
        As said.
    """
    names = [*SHAPES, *(name for one in sensitivities for name in one.terms)]
    channels = [one.channel for one in sensitivities]
    for listed, what in ((channels, "sensitivities"), (names, "terms")):
        twice = sorted({name for name in listed if listed.count(name) > 1})
        if twice:
            raise DataError(f"two {what} of one name: {', '.join(twice)}", do="Give the channel another name")
    for one in sensitivities:
        for name, array in one.terms.items():
            if array.shape != (sensors,):
                raise DataError(f"{name}: shape {array.shape}, need ({sensors},)")
            check_size(name, array)


def check_size(name: str, array: Array) -> None:
    """Refuse a term with a number that is not finite, or larger than anything is.

    Raises
    ------
    DataError
        As said.
    """
    if not array.size or np.abs(array).max() <= LARGEST:
        return
    if not np.all(np.isfinite(array)):
        raise DataError(f"{name}: not finite", do="Leave out a term that is not known")
    raise DataError(f"{name}: larger than {LARGEST:g}", do="Correct the unit or the exponent", code=CODE)


def check_needs(
    terms: Mapping[str, Array], reference_pressure: float | None, sensitivities: Sequence[Sensitivity] = ()
) -> None:
    """Refuse a term without what it needs.

    Raises
    ------
    DataError
        As said.
    """
    if not all(one and is_possible(one) for one in terms["scale_factor"].tolist()):
        raise DataError(f"scale_factor {terms['scale_factor'].tolist()}: zero", do="Give the ideal scale factor")
    in_temperature = "bias_temperature" in terms or terms["matrix"].shape[0] > 1
    in_temperature |= any(one.bias_temperature is not None for one in sensitivities)
    if in_temperature and "reference_temperature" not in terms:
        raise DataError("terms in temperature without reference_temperature", do="Give T_ref [degC]")
    if "bias_pressure" in terms and reference_pressure is None:
        raise DataError("bias_pressure without reference_pressure", do="Give p_ref [Pa]")
    amplitudes = len(terms["bias_warm_up"]) if "bias_warm_up" in terms else 0
    times = terms.get("warm_up_time", np.empty(0))
    if amplitudes != len(times) or np.any(times <= 0.0):
        raise DataError(
            f"bias_warm_up has {amplitudes} term(s), warm_up_time is {times.tolist()}",
            do="Give one positive time constant [s] a term",
        )
    if np.any(terms.get("bias_run_to_run", 0.0) < 0.0):
        raise DataError("bias_run_to_run: a standard deviation is negative")


def check_ranges(
    axes: Sequence[str], terms: Mapping[str, Array], conditions: Mapping[str, tuple[float, float] | None]
) -> None:
    """Refuse a range whose lower end does not come first.

    Raises
    ------
    DataError
        As said.
    """
    ranges = {f"{name}_range": ends for name, ends in conditions.items()}
    if "input_range" in terms:
        ranges |= {f"input_range of {a}": (lo, hi) for a, (lo, hi) in zip(axes, terms["input_range"], strict=True)}
    for name, ends in ranges.items():
        if ends is not None and not ends[0] <= ends[1]:
            raise DataError(f"{name}: {ends[0]:g} to {ends[1]:g}", do="Give the lower end first")


def check_estimate(own: Sequence[Parameter], terms: Mapping[str, Array], estimate: Estimate) -> None:
    """Refuse an estimate that holds other numbers, or other units, than the terms.

    Raises
    ------
    DataError
        As said; ``wrong_unit``.
    """
    known = {one.name: one for one in own}
    strangers = [name for name in estimate.names if name not in known]
    if strangers:
        raise DataError(
            f"the estimate has {', '.join(strangers)}, which the model has not", do=f"It has: {', '.join(known)}"
        )
    chosen = [known[name] for name in estimate.names]
    for one, unit in zip(chosen, estimate.units, strict=True):
        if unit != one.unit:
            raise DataError(f"{one.name} is estimated in {unit!r}, the model needs {one.unit!r}", code="wrong_unit")
    for one, value, other in zip(chosen, values(chosen, terms), estimate.values, strict=True):
        if not abs(value - other) <= AGREEMENT * max(abs(value), SMALLEST):
            raise DataError(f"{one.name} is {value:.12g} in the model and {other:.12g} in its estimate")

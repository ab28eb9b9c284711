"""What the terms of a sensor model must be: of their shape, finite, ranges in order, as their estimate has them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array, Estimate
from .terms import FORCE_AXES, SHAPES, Parameter, values

AGREEMENT = 1e-9  # largest relative difference of a term from the same number in the estimate
SMALLEST = 1e-4  # below this a difference is absolute: M_xx - 1 has no more digits than M_xx


def check_axes(axes: tuple[str, ...]) -> None:
    """Refuse axes whose pairs cannot be told apart.

    Raises
    ------
    DataError
        As said.
    """
    pairs = [a + b for a in axes for b in axes]
    if not axes or "" in axes or any("_" in axis for axis in axes) or len(set(pairs)) != len(pairs):
        raise DataError(f"axes {axes!r} cannot be told apart", do='Name them like ("x", "y", "z")')


def read_only_term(name: str, value: object, sensors: int) -> Array:
    """Return a read-only copy of a term; a constant matrix becomes M_0, one number serves all sensors.

    Raises
    ------
    DataError
        If its shape does not fit, or a number is not finite.
    """
    letters = SHAPES[name]
    sizes = {"k": sensors, "f": len(FORCE_AXES), "2": 2}
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


def check_needs(terms: Mapping[str, Array], reference_pressure: float | None) -> None:
    """Refuse a term without what it needs beside itself.

    Raises
    ------
    DataError
        As said.
    """
    if np.any(terms["scale_factor"] == 0.0):
        raise DataError(f"scale_factor {terms['scale_factor'].tolist()}: zero", do="Give the ideal scale factor")
    in_temperature = "bias_temperature" in terms or terms["matrix"].shape[0] > 1
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

"""The signal chain: counts -> output (volts or counts a second) -> reading in the input unit, and back.

For each sensor, sample by sample::

    V  = step * code                              V_ref = step * reference code, or a fixed voltage
    v  = (V - V_ref - Z(T)) / gain                v: the sensor's output
    r  = v / S0                                   r: reading, in the input unit
    T  = (V_T - V_ref - V_0) / slope + T_0        temperature channel

The published rate suite [1]_ is the case step = 5 V / 4095, a reference measured with each signal, gain 1,
Z = 0; the triaxial head [2]_ has step = 10 V / 65536, gains of 100, 100 and 10, and the zero Z(T) of its
electronics, which stands before the gain is divided out. A pulse-rate converter [3]_ is the same with step =
1 / gate: whole pulses of one gate time, as counts a second. Readings that were recorded in volts, or that a sensor
gives as numbers itself, are the same with a step of 1 and no ends.

``from_counts.convert`` and ``to_counts`` apply a chain, each the other's inverse.

References
----------
.. [1] Badescu, NPS thesis, 2011, equations (4) to (12), Tables 2 and 15.
.. [2] Chestney and Sicker, NASA TM-106980, 1996.
.. [3] Reinel, NASA TM X-53857, 1969.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from ...core.errors import DataError, PlanError
from ...core.estimate import Array


@dataclass(frozen=True, eq=False)
class Thermometer:
    """Linear temperature channel of k sensors."""

    slope: Array | float  # shape (k,): [V/degC]
    voltage: Array | float  # shape (k,): V_0, what it gives above the reference at ``temperature`` [V]
    temperature: Array | float  # shape (k,): T_0 [degC]
    own_reference: bool = field(default=False, kw_only=True)  # read against a reference recorded for it alone

    def __post_init__(self) -> None:
        if np.any(np.asarray(self.slope) == 0.0):
            raise PlanError(f"thermometer slope {self.slope}: need a number other than 0 [V/degC]")

    def degrees(self, volts: Array) -> Array:
        """Temperature [degC] of volts above the reference, shape (n, k)."""
        return np.asarray((volts - self.voltage) / self.slope + self.temperature)

    def volts(self, temperature: ArrayLike) -> Array:
        """Volts above the reference at a temperature [degC], shape (n, k)."""
        return np.asarray((np.asarray(temperature) - self.temperature) * self.slope + self.voltage)


@dataclass(frozen=True, eq=False)
class Chain:
    """From codes to readings, for k sensors.

    Raises
    ------
    PlanError
        If a number cannot be: step or scale factor of zero, ends in the wrong order, ...
    """

    axes: tuple[str, ...]  # One a sensor
    step: float  # Output a count [V], or 1/gate [1/s] of a pulse-rate converter
    codes: tuple[int, int] | None = None  # Lowest and highest code; None where the converter has no ends
    unit: str = ""  # Input unit, SI
    output_unit: str = "V"  # ``"V"``, ``"count/s"``, or ``"count"`` of a sensor that gives numbers itself
    # shape (k,): Ideal S0 [output unit / input unit]; None leaves the output without a reading
    scale_factor: Array | float | None = None
    reference: Literal["channel"] | float = 0.0  # Measured with the signal, or a fixed voltage [V]
    # shape (k,) or (q, k): Z [V] at the converter, or its coefficients of 1, T, T^2, ... in degC
    zero: Array | float = 0.0
    gain: Array | float = 1.0  # shape (k,): Of the amplifier; over time it is given to ``convert``
    # shape (k,): Gain -> Z [V] at that gain, where gains are given over time
    zero_at: Mapping[float, Array] | None = None
    thermometer: Thermometer | None = None  # Temperature channel
    validity_minimum: float | None = None  # Lowest voltage of the built-in test at which readings are good [V]
    input_unit: str = "count"  # What it starts from: ``"count"``, ``"V"`` at the converter, or ``"count/s"``

    def __post_init__(self) -> None:
        if not (np.isfinite(self.step) and self.step > 0.0):
            raise PlanError(f"step {self.step:g}: need a positive number a count")
        if self.codes is not None and not self.codes[0] < self.codes[1]:
            raise PlanError(f"codes {self.codes}: the first must be the smaller")
        nonzero("gain", self.gain, len(self.axes))
        for name in ("slope", "voltage", "temperature") if self.thermometer is not None else ():
            shape = np.shape(getattr(self.thermometer, name))
            if shape not in {(), (len(self.axes),)}:
                raise PlanError(f"thermometer {name}: shape {shape}, need one number, or one of {len(self.axes)}")
        if self.scale_factor is not None:
            nonzero("scale_factor", self.scale_factor, len(self.axes))
        if np.ndim(self.zero) > 2 or (np.ndim(self.zero) and np.shape(self.zero)[-1] != len(self.axes)):
            raise PlanError(f"zero: shape {np.shape(self.zero)}, need ({len(self.axes)},) or (q, {len(self.axes)})")


def pulse_counter(
    axes: tuple[str, ...], gate: float, unit: str = "", scale_factor: Array | float | None = None
) -> Chain:
    """Return the chain of a pulse-rate converter.

    Parameters
    ----------
    gate : float
        Time over which pulses are counted [s].
    scale_factor : ndarray, shape (k,), or float, optional
        [count/s / input unit], of the range in use.

    Raises
    ------
    PlanError
        If the gate is not positive.
    """
    if not gate > 0.0:
        raise PlanError(f"gate {gate:g} s: need a positive time")
    return Chain(axes, 1.0 / gate, unit=unit, output_unit="count/s", scale_factor=scale_factor)


def from_output(chain: Chain) -> Chain:
    """Return the chain as it starts from its output unit (volts at the converter), one a code, without ends."""
    return replace(chain, step=1.0, codes=None, input_unit=chain.output_unit)


def zero_volts(chain: Chain, degrees: Array | None) -> Array | float:
    """Z [V] of the electronics at temperatures [degC], of a shape that broadcasts to (n, k).

    Raises
    ------
    DataError
        ``missing_temperature`` if Z depends on it and there is none.
    """
    zero = np.asarray(chain.zero, dtype=float)
    if zero.ndim < 2:
        return zero
    if len(zero) == 1:
        return np.asarray(zero[0])
    if degrees is None:
        raise missing_channel(chain, "temperature", "the zero of the electronics depends on it")
    total = np.zeros_like(degrees)
    for coefficient in zero[::-1]:
        total = total * degrees + coefficient
    return total


def zero_at_gains(chain: Chain, degrees: Array | None, gains: Array | None) -> Array | float:
    """Z [V] as `zero_volts`, of gains over time, shape (n, k), where the chain knows it by gain.

    Raises
    ------
    DataError
        ``no_zero`` if there is none for a gain; and as `zero_volts`.
    """
    if gains is None or not chain.zero_at:
        return zero_volts(chain, degrees)
    total = np.full(gains.shape, np.nan)
    for gain, zeros in chain.zero_at.items():
        total = np.where(np.isclose(gains, gain, rtol=1e-9, atol=0.0), zeros, total)
    unknown = np.isnan(total) & np.isfinite(gains)
    if unknown.any():
        row, axis = (int(at[0]) for at in np.nonzero(unknown))
        raise DataError(
            f"no zero of the electronics of {chain.axes[axis]} at gain {gains[row, axis]:g}",
            why="it differs from gain to gain",
            do=f"Known are gains {', '.join(f'{one:g}' for one in chain.zero_at)}",
            code="no_zero",
        )
    return total


def missing_channel(chain: Chain, name: str, why: str) -> DataError:
    """Return the error of a channel that the chain needs and that is not there."""
    return DataError(
        f"no {name} channel for {', '.join(chain.axes)}", why=why, do=f"Name its column: {name}", code=f"missing_{name}"
    )


def wide(name: str, values: ArrayLike, k: int, n: int | None = None) -> Array:
    """Values as float64 of shape (n, k); with counts of n rows one column serves all sensors.

    Raises
    ------
    DataError
        ``wrong_shape``.
    """
    array = np.asarray(values, dtype=float)
    if array.ndim == 1:
        array = array[:, np.newaxis]
    if n is not None and array.shape[1:] == (1,):
        array = np.broadcast_to(array, (len(array), k))
    if array.ndim != 2 or array.shape[1] != k or (n is not None and len(array) != n):
        need = f"({'n' if n is None else n}, {k})"
        raise DataError(f"{name}: shape {np.shape(values)}, need {need}", code="wrong_shape")
    return array


def nonzero(name: str, value: ArrayLike, k: int) -> Array:
    """Factors as an array, one for all or one of k.

    Raises
    ------
    PlanError
        If one is zero or not finite, or the number of them does not fit.
    """
    array = np.asarray(value, dtype=float)
    if np.any(array == 0.0) or not np.all(np.isfinite(array)) or (array.ndim and array.shape[-1] != k):
        raise PlanError(f"{name} {array.tolist()}: need finite numbers other than 0, one for all or one of {k}")
    return array

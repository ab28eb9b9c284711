"""The flight equation of the published rate suite, step by step, from counts to compensated rates [1]_.

With I the rate that a sensor indicates, codes c of its rate, temperature and reference channels, and lsb one code::

    V   = (c_rate - c_reference) lsb              I = V / S_f
    V_T = (c_temperature - c_reference) lsb       T = (V_T - V_nominal) / slope + T_ref
    b_in_run = (B + m1 V_T + m2 V_T^2 + m3 V_T^3) / S_f
    rate = I - (b_in_run + M I + b_cons)

It is of first order: it takes M I for what the matrix makes of the true rate. The inverse of the sensor equation,
which compensation applies, differs by the square of the errors.

As printed, the polynomial in volts is taken for a rate: the division of b_in_run by S_f is missing, and M has the
wrong sign on its diagonal and is transposed. `catalogue` has both states.

References
----------
.. [1] Badescu, NPS thesis, 2011, equation (2), equations (4) to (12), Table 15.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..core.estimate import Array
from ..core.units import factor
from .chain.converter import Chain

VOLTS, DEGREES, RATES = 7, 4, 7  # decimals
MEANS = 6  # decimals of counts that are means, at most


@dataclass(frozen=True)
class Step:
    """One line of the calculation: a figure a sensor."""

    name: str  # As the equation has it
    values: Array  # shape (k,)
    unit: str
    decimals: int  # With which it is shown
    group: str  # What it belongs to

    def to_dict(self, axes: tuple[str, ...]) -> dict[str, object]:
        """Return it as the objects of ``--json`` are, a value a sensor."""
        values = {axis: float(value) for axis, value in zip(axes, self.values, strict=True)}
        return {"group": self.group, "name": self.name, "unit": self.unit, "values": values}


@dataclass(frozen=True, eq=False)
class FlightEquation:
    """Constants of the equation for k sensors."""

    axes: tuple[str, ...]  # One a sensor
    polynomial: Array  # shape (k, 4): B, m1, m2, m3 [V, V/V, ...]
    volts_per_rate: float  # By which b_in_run is divided [V/(deg/s)]: S_f; 1 as printed
    b_cons: Array  # shape (k,) [deg/s]
    matrix: Array  # shape (k, k): M, row = the sensor that reads [1]
    source: str  # Citation


def steps(equation: FlightEquation, chain: Chain, codes: ArrayLike, reference: ArrayLike, temperature: ArrayLike,
          temperature_reference: ArrayLike | None = None) -> tuple[Step, ...]:  # fmt: skip
    """Return every step from the codes of one reading to compensated rates.

    Parameters
    ----------
    chain : Chain
        Of the suite: lsb, scale factor, thermometer.
    codes, reference, temperature : array_like, shape (k,)
        Codes of the rate, reference and temperature channels.
    temperature_reference : array_like, shape (k,), optional
        Codes of the reference of the temperature channels, where they have one of their own.

    Returns
    -------
    tuple of Step
        In the order of the calculation; the last is the compensated rate [deg/s].

    Raises
    ------
    ValueError
        If the chain has no thermometer or scale factor: it is not that of the suite.
    """
    if chain.thermometer is None or chain.scale_factor is None:
        raise ValueError("the chain of the suite has a thermometer and a scale factor")
    k = len(equation.axes)
    found: list[Step] = []

    def step(group: str, name: str, values: ArrayLike, unit: str, decimals: int) -> Array:
        array = np.broadcast_to(np.asarray(values, dtype=float), (k,))
        found.append(Step(name, array, unit, decimals, group))
        return array

    constants, thermometer = "Constants", chain.thermometer
    for i, (name, unit) in enumerate((("B", "V"), ("m1", "V/V"), ("m2", "V/V^2"), ("m3", "V/V^3"))):
        step(constants, name, equation.polynomial[:, i], unit, 5)
    step(constants, "b_cons", equation.b_cons, "deg/s", 5)
    for axis, column in zip(equation.axes, equation.matrix.T, strict=True):
        step(constants, f"M, from {axis}", column * factor("1", "%"), "%", 3)
    step(constants, "T_ref", thermometer.temperature, "degC", 1)
    step(constants, "V_nominal", thermometer.voltage, "V", 4)
    step(constants, "slope", thermometer.slope, "V/degC", 4)
    s_f = step(constants, "S_f", np.asarray(chain.scale_factor) * factor("V/(rad/s)", "V/(deg/s)"), "V/(deg/s)", 1)

    counted, given = "Codes", [one for one in (codes, reference, temperature, temperature_reference) if one is not None]
    places = max(_decimals(one) for one in given)
    rate = step(counted, "rate", codes, "count", places)
    ref = step(counted, "reference", reference, "count", places)
    warm = step(counted, "temperature", temperature, "count", places)
    own = ref
    if temperature_reference is not None:
        own = step(counted, "its reference", temperature_reference, "count", places)

    rates = "Indicated rate"
    away = step(rates, "rate - reference", rate - ref, "count", places)
    volts = step(rates, f"V = that * {_lsb(chain)}", away * chain.step, "V", VOLTS)
    indicated = step(rates, "I = V / S_f", volts / s_f, "deg/s", RATES)

    warmth = "Temperature"
    away = step(warmth, "temperature - reference", warm - own, "count", places)
    v_t = step(warmth, f"V_T = that * {_lsb(chain)}", away * chain.step, "V", VOLTS)
    step(warmth, "T = (V_T - V_nominal) / slope + T_ref", thermometer.degrees(v_t), "degC", DEGREES)

    bias = "Bias in run"
    step(bias, "B", equation.polynomial[:, 0], "V", VOLTS)
    for i, name in enumerate(("m1 V_T", "m2 V_T^2", "m3 V_T^3"), 1):
        step(bias, name, equation.polynomial[:, i] * v_t**i, "V", VOLTS)
    total = sum(equation.polynomial[:, i] * v_t**i for i in range(4))
    step(bias, "sum", total, "V", VOLTS)
    over = "sum, taken for deg/s" if equation.volts_per_rate == 1.0 else "b_in_run = sum / S_f"
    in_run = step(bias, over, np.asarray(total) / equation.volts_per_rate, "deg/s", RATES)

    mixed = "Matrix"
    for j, axis in enumerate(equation.axes):
        step(mixed, f"M, from {axis}, times I of {axis}", equation.matrix[:, j] * indicated[j], "deg/s", RATES)
    m_i = step(mixed, "M I = their sum", equation.matrix @ indicated, "deg/s", RATES)

    last = "Rate"
    b_cons = step(last, "b_cons", equation.b_cons, "deg/s", RATES)
    errors = step(last, "b_in_run + M I + b_cons", in_run + m_i + b_cons, "deg/s", RATES)
    step(last, "rate = I - that", indicated - errors, "deg/s", RATES)
    return tuple(found)


def _decimals(codes: ArrayLike) -> int:
    """Return how many decimals codes have: none, unless they are means."""
    values = np.asarray(codes, dtype=float)
    return next((n for n in range(MEANS) if np.all(np.abs(values - np.round(values, n)) < 0.5 * 10.0**-MEANS)), MEANS)


def _lsb(chain: Chain) -> str:
    """One code as the document prints it: the span over the highest code."""
    highest = 0 if chain.codes is None else chain.codes[1]
    return f"{chain.step * highest:g} V / {highest}" if highest else f"{chain.step:g} V"

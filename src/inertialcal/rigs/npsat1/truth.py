"""True values behind the simulated campaign, named as the rows of the results name them, SI.

The bias is a mean over many power-ups, settled, midway between warming and cooling, without the rate of the earth, at
the true temperature. The bias on the rate table is what is left there after the bias in air was taken off.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from ...core.axes import AXES
from ...core.estimate import Array
from ..protocol import Drawn, TrueValue
from .campaign import AT_DEGC, NAMES, REFERENCE_DEGC, degrees
from .reading import polynomial_bias
from .setup import AIR, AVERAGING, VACUUM
from .unit import Unit, reference_volts

MODEL_DEGC = np.array([-30.0, 0.0, 40.0, 70.0])  # four points tell a cubic


def true_values(unit: Unit, parts: tuple[str, ...]) -> tuple[TrueValue, ...]:
    """Return the quantities of a unit that the tests of these parts find."""
    found = {"thermal": _thermal, "rate_table": _on_table, "noise": _noise}
    each = [value for part in parts for value in found[part](unit)]
    return (*each, *(_model(unit) if {"thermal", "rate_table"} <= set(parts) else ()))


def _model(unit: Unit) -> Iterator[TrueValue]:
    """Yield the bias over temperature of the model: in air, with what the installation on the rate table adds."""
    bias = polynomial_bias(unit, AIR, MODEL_DEGC)
    for i, axis in enumerate(AXES):
        powers = np.polynomial.Polynomial.fit(MODEL_DEGC - REFERENCE_DEGC, bias[:, i], 3).convert()
        constant, *others = powers.coef
        yield TrueValue("bias", axis, float(constant + unit.installation[i]), "rad/s", "model")
        for j, value in enumerate(others, 1):
            name = "rad/s/degC" if j == 1 else f"rad/s/degC^{j}"
            yield TrueValue(f"bias_temperature_{j}", axis, float(value), name, "model")


def _thermal(unit: Unit) -> Iterator[TrueValue]:
    bias = {where: polynomial_bias(unit, where, [REFERENCE_DEGC, *AT_DEGC]) for where in (AIR, VACUUM)}
    conditions = ["", *map(degrees, AT_DEGC)]
    for where in (AIR, VACUUM):
        test = NAMES[where]
        for row, condition in enumerate(conditions):
            yield from _each("bias", bias[where][row], "rad/s", test, condition)
        yield from _each("hysteresis", 2.0 * unit.hysteresis, "rad/s", test)
        yield from _each("thermal_lag", np.full(3, unit.lag), "s", test)
        yield from _each("warm_up_change", unit.start_up[where], "rad/s", test)
        yield from _each("warm_up_time_constant", np.full(3, unit.start_up_time[where]), "s", test)
        for which, quantity in enumerate(("reference_voltage", "temperature_reference_voltage")):
            yield from _each(quantity, reference_volts(unit, which, REFERENCE_DEGC), "V", test)
    for row, condition in enumerate(conditions):
        offset = bias[VACUUM][row] - bias[AIR][row]
        yield from _each("vacuum_offset", offset, "rad/s", NAMES[VACUUM], condition)


def _on_table(unit: Unit) -> Iterator[TrueValue]:
    model = unit.model
    matrix, own = model.matrix[0], np.diag(model.matrix[0])
    yield from _each("bias", unit.installation, "rad/s", NAMES["rate_table"])
    yield from _each("scale_factor", model.scale_factor * own, "V/(rad/s)")
    yield from _each("scale_factor_error", own - 1.0, "1")
    if model.scale_factor_asymmetry is not None:
        yield from _each("scale_factor_asymmetry", model.scale_factor_asymmetry, "1")
    for i, axis in enumerate(AXES):
        for j, other in enumerate(AXES):
            if j != i:
                yield TrueValue("cross_axis_sensitivity", axis + other, float(matrix[i, j]), "1")
                yield TrueValue("misalignment", axis + other, float(matrix[i, j] / own[i]), "rad")


def _noise(unit: Unit) -> Iterator[TrueValue]:
    yield from _each("angle_random_walk", unit.white * np.sqrt(AVERAGING), "rad/sqrt(s)")
    yield from _each("rate_random_walk", unit.walk, "rad/s/sqrt(s)")


def _each(quantity: str, values: Array, unit: str, test: str = "", condition: str = "") -> Iterator[TrueValue]:
    for axis, value in zip(AXES, values, strict=True):
        yield TrueValue(quantity, axis, float(value), unit, test, condition)


def drawn_of(unit: Unit) -> Drawn:
    """Return what else was drawn of a unit, for the file of the truth."""
    found: Mapping[str, Array] = {
        **{f"bias_volts_{where}": coefficients for where, coefficients in unit.bias_volts.items()},
        **{f"start_up_{where}": change for where, change in unit.start_up.items()},
        "installation": unit.installation,
        "hysteresis": unit.hysteresis,
        "reference_volts_of_rate": unit.reference_volts[0],
        "reference_volts_of_temperature": unit.reference_volts[1],
    }
    times = {f"start_up_time_{where}": float(time) for where, time in unit.start_up_time.items()}
    return {**{name: values.tolist() for name, values in found.items()}, **times, "lag": unit.lag}

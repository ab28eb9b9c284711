"""The signal chain that a campaign describes, as ``sensors.chain`` wants it."""

from __future__ import annotations

from collections.abc import Iterable, Set
from dataclasses import replace

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.schema.quantities import Axis, PerAxis
from ...core.units import kind, parse_quantity, same_dimension, si_unit
from ...sensors.chain.converter import Chain, Thermometer, from_output, pulse_counter
from ..file.sensors import Chain as Chain_
from ..file.sensors import Sensor

TEMPERATURE = ("temperature",)
RAW = ("count", "voltage")
INPUT = {"accelerometer": "m/s^2", "gyro": "rad/s"}


def build_chain(sensor: Sensor, axes: tuple[str, ...] | None = None) -> Chain:
    """Return the chain of a sensor with a converter.

    Raises
    ------
    DataError
        If a quantity cannot be read.
    PlanError
        If a number cannot be, as `sensors.chain.Chain` says.
    """
    given, axes = sensor.chain, axes or tuple(sensor.axes)
    si = si_unit(sensor.unit)
    if given.kind == "pulse_rate":
        factor = None if given.scale_factor is None else per_axis(given.scale_factor, f"count/s/({si})", axes)
        return pulse_counter(axes, float(given.gate or 0.0), si, factor)
    thermometer, output = given.thermometer, output_unit(sensor)
    return Chain(
        axes=axes,
        step=1.0 if given.lsb is None else given.lsb,
        codes=given.counts,
        unit=si,
        output_unit=output,
        input_unit="count" if given.kind == "adc" else output,
        scale_factor=scale_factors(sensor, axes),
        reference=given.reference if given.reference is not None else 0.0,
        zero=_zeros(given, axes, output),
        gain=gains(given.gain, axes),
        zero_at=_zeros_by_gain(given, axes),
        thermometer=None
        if thermometer is None
        else Thermometer(
            slope=per_axis(thermometer.slope, "V/degC", axes),
            voltage=per_axis(thermometer.voltage, "V", axes),
            temperature=per_axis(thermometer.temperature, "degC", axes),
        ),
        validity_minimum=given.validity_minimum,
    )


def output_unit(sensor: Sensor) -> str:
    """Return the unit of what leaves a sensor: ``V``, ``count/s``, or ``count`` where it gives numbers itself."""
    given = sensor.chain
    if given.kind == "pulse_rate":
        return "count/s"
    text = next(iter(given.scale_factor.values()), "") if isinstance(given.scale_factor, dict) else given.scale_factor
    if given.kind != "output" or not text:
        return "V"
    try:
        counted = same_dimension(parse_quantity(text).unit, f"count/({si_unit(sensor.unit)})")
    except DataError:  # said where the chain is built
        return "V"
    return "count" if counted else "V"


def raw_kinds(sensor: Sensor) -> tuple[str, ...]:
    """Return the kinds of unit that the recordings of a sensor with a chain may be in."""
    if sensor.chain.kind == "adc":
        return RAW
    if sensor.chain.kind == "pulse_rate":
        return "count", kind("count/s")
    return ("voltage",) if output_unit(sensor) == "V" else ("count",)


def in_input_units(sensor: Sensor, units: Iterable[str]) -> bool:
    """Whether readings are in units of input already, as some recordings of a sensor with a chain may be."""
    given = list(units)
    return bool(given) and all(one and kind(one) == kind(sensor.unit) for one in given)


def model_chain(
    sensor: Sensor, axes: tuple[str, ...], recorded: Set[str], output_unit: str | None, scale_factor: Array
) -> Chain | None:
    """Return the chain that leads to the readings of a model along some axes; None where codes alone do not.

    So it is without a converter, where a model of the ground or a recorded gain comes between, where no scale factor
    is known, and where the mounting exchanges or mixes sensors. One that turns axes turns the sign of their scale
    factor.

    Parameters
    ----------
    recorded : set of str
        What the recordings have besides the signals: ``gain``, ``temperature_reference``.
    output_unit, scale_factor : str or None, ndarray
        Of the model; its scale factor is that of the chain where it takes the output of the sensor.
    """
    given, signs = sensor.chain, np.ones(len(axes))
    if given.kind == "none" or given.ground is not None or given.model is not None or "gain" in recorded:
        return None
    if sensor.mounting is not None:
        mounting = np.array(sensor.mounting)
        if not np.array_equal(np.abs(mounting), np.eye(3)):
            return None
        signs = np.array([mounting["xyz".index(axis), "xyz".index(axis)] for axis in axes])
    chain = build_chain(sensor, axes)
    known = scale_factor if output_unit == chain.output_unit else chain.scale_factor
    warm = chain.thermometer
    if warm is not None and "temperature_reference" in recorded:
        warm = replace(warm, own_reference=True)
    return None if known is None else replace(chain, scale_factor=signs * known, zero_at=None, thermometer=warm)


def scale_factors(sensor: Sensor, axes: tuple[str, ...]) -> Array | None:
    """Return the ideal scale factor of each axis, shape (k,); None where there is none.

    Of a chain [its output unit/SI unit]; of readings that stay in counts or volts [count or V/SI unit].
    """
    given, si, output = sensor.chain.scale_factor, si_unit(sensor.unit), "V"
    if sensor.chain.kind == "none" and kind(sensor.unit) in RAW and sensor.kind in INPUT:
        si, output = INPUT[sensor.kind], si  # as the readings are given to a test
    if sensor.chain.kind != "none":
        output = output_unit(sensor)
    return None if given is None else per_axis(given, f"{output}/({si})", axes)


def body_scale_factors(sensor: Sensor) -> dict[str, float] | None:
    """Return the ideal scale factor behind each body axis, as `scale_factors`.

    With a mounting that only exchanges or turns axes, that of the sensor that feels the body axis; None where there
    is none, or where the mounting mixes sensors.
    """
    factors = scale_factors(sensor, tuple(sensor.axes))
    if factors is None:
        return None
    own = dict(zip(sensor.axes, factors.tolist(), strict=True))
    if sensor.mounting is None:
        return own
    mounting = np.abs(np.array(sensor.mounting))
    if not np.all(np.isclose(mounting, 0.0) | np.isclose(mounting, 1.0)):
        return None
    letters = ("x", "y", "z")
    felt = {letters[body]: letters[int(np.argmax(mounting[:, body]))] for body in range(3)}
    return {body: own[sensed] for body, sensed in felt.items() if sensed in own}


def recorded_chain(chain: Chain, units: Iterable[str]) -> Chain:
    """Return the chain of a recording: from its output where its signals are in volts, or in pulses a second."""
    given = [one for one in units if one]
    if chain.output_unit == "V" and any(kind(one) == "voltage" for one in given):
        return from_output(chain)
    pulses = chain.output_unit == "count/s" and given and all(same_dimension(one, "count/s") for one in given)
    return from_output(chain) if pulses else chain


def per_axis(given: PerAxis, unit: str, axes: tuple[str, ...]) -> Array:
    """Return a quantity of each axis in a unit, shape (k,).

    Raises
    ------
    DataError
        If it is no quantity of that kind, or an axis is missing.
    """
    texts: dict[str, str] = dict(given.items()) if isinstance(given, dict) else dict.fromkeys(axes, given)
    missing = [axis for axis in axes if axis not in texts]
    if missing:
        raise DataError(f"no value for axis {', '.join(missing)}", do="Give one for each axis, or one for all")
    return np.array([_quantity(texts[axis], unit) for axis in axes])


def _quantity(text: str, unit: str) -> float:
    return float(parse_quantity(str(text)).to(unit))


def _zeros(given: Chain_, axes: tuple[str, ...], unit: str) -> Array:
    """Return the zero of each axis at its gain [unit of the output]: that of its gain, else that of the chain."""
    found = np.array(np.broadcast_to(_own_zeros(given, axes, unit), len(axes)))
    stated = np.broadcast_to(gains(given.gain, axes), len(axes))
    for gain, zeros in (_zeros_by_gain(given, axes) or {}).items():
        found = np.where(stated == gain, zeros, found)
    return found


def _own_zeros(given: Chain_, axes: tuple[str, ...], unit: str = "V") -> Array | float:
    return 0.0 if given.zero is None else per_axis(given.zero, unit, axes)


def _zeros_by_gain(given: Chain_, axes: tuple[str, ...]) -> dict[float, Array] | None:
    """Return the zero of each axis at each gain of the ground model [V]; None where none says one."""
    if given.ground is None or all(one.zero is None for one in given.ground.gains.values()):
        return None
    found = {}
    for gain, one in given.ground.gains.items():
        zeros = np.array(np.broadcast_to(_own_zeros(given, axes), len(axes)))
        texts = one.zero if isinstance(one.zero, dict) else dict.fromkeys(axes, one.zero)
        for axis, text in texts.items():
            if axis in axes and text is not None:
                zeros[axes.index(axis)] = _quantity(text, "V")
        found[float(gain)] = zeros
    return found


def gains(given: float | dict[Axis, float], axes: tuple[str, ...]) -> Array | float:
    """Return the gain of the amplifier of each axis, shape (k,), or of all.

    Raises
    ------
    DataError
        If there is one for some axes only.
    """
    if not isinstance(given, dict):
        return float(given)
    known: dict[str, float] = dict(given.items())
    missing = [axis for axis in axes if axis not in known]
    if missing:
        raise DataError(f"no gain for axis {', '.join(missing)}", do="Give one for each axis, or one for all")
    return np.array([float(known[axis]) for axis in axes])

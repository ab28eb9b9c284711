"""Chain and model applied to recordings: columns in, channels out; time, gaps and other channels stay.

Columns are named by what they are: an axis (``"x"``), or ``"reference_x"``, ``"temperature_x"``,
``"temperature_reference_x"`` (where the temperature channel has a reference of its own), ``"validity_x"``;
``"reference"`` without an axis serves all.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Unpack

import numpy as np
from numpy.typing import ArrayLike

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.recording import Channel, Recording
from ...core.units import convert as to_unit
from ...core.units import same_dimension
from ..chain.conversion import convert
from ..chain.converter import Chain
from .compensate import beyond, compensate, counted
from .equation import Conditions
from .sensitivity import PRESSURE
from .sensor_model import SensorModel, check_item, to_readings

QUANTITY = {"rad/s": "gyro", "m/s^2": "acc"}
CONDITIONS = (
    "reference",
    "temperature",
    "temperature_reference",
    "validity",
)  # channels that a chain takes besides the axes


def apply_chain(
    chain: Chain, recording: Recording, columns: Mapping[str, str], gain: ArrayLike | None = None
) -> Recording:
    """Return the recording with readings in place of counts.

    Parameters
    ----------
    columns : mapping of str to str
        What it is -> name of the column.
    gain : array_like, shape (n,) or (n, k), optional
        Of the amplifier over time; instead of the chain's.

    Returns
    -------
    Recording
        A channel for each axis, named by it, in the input unit of the chain (in its output unit without a scale
        factor), empty (NaN) where not valid; ``temperature_x``, ... [degC] where there is a thermometer; then the
        columns that were not used, as they are. Remarks are added to those of the recording.

    Raises
    ------
    DataError
        ``wrong_column`` for a column that is not there; ``wrong_unit`` for one that is not in counts; and as
        ``from_counts.convert``.
    """
    counts = _counts(chain, recording, [_column(columns, axis) for axis in chain.axes])
    conditions = {kind: _condition(chain, recording, columns, kind) for kind in CONDITIONS}
    try:
        converted = convert(chain, counts, **conditions, gain=gain, place=recording.place)
    except DataError as error:
        named = [replace(one, where=one.where or recording.source.path) for one in error.problems]
        raise DataError(named) from None
    values, unit = (converted.output, chain.output_unit)
    if converted.readings is not None:
        values, unit = converted.readings, chain.unit
    made = [
        Channel(axis, values[:, i].copy(), unit, "chain", axis, QUANTITY.get(unit, ""))
        for i, axis in enumerate(chain.axes)
    ]
    if converted.temperature is not None:
        made += [
            Channel(f"temperature_{axis}", converted.temperature[:, i].copy(), "degC", "chain", axis, "temperature")
            for i, axis in enumerate(chain.axes)
        ]
    others = [channel for channel in recording.channels if channel.name not in set(columns.values())]
    return replace(recording, channels=(*made, *others), remarks=(*recording.remarks, *converted.remarks))


def compensate_recording(
    model: SensorModel,
    recording: Recording,
    columns: Mapping[str, str],
    part: bool = False,
    **conditions: Unpack[Conditions],
) -> Recording:
    """Return the recording with compensated inputs in place of readings.

    Parameters
    ----------
    columns : mapping of str to str
        What it is -> name of the column: each axis, and ``"temperature"`` or ``"temperature_x"``, ...,
        ``"pressure"`` and other channels by their names where the model needs them.
    part : bool
        Whether these are some rows of a record: what lies beyond its ranges is then not said of how many
        (``compensate.counted``).
    **conditions
        See ``equation.Conditions``; what is not in a column.

    Returns
    -------
    Recording
        Same channels in the same order. Those of the axes hold the true input in the unit in which they came, or
        in the input unit (SI) if they came as outputs; empty (NaN) where there is none. Remarks count them.

    Raises
    ------
    DataError
        ``wrong_column``; ``wrong_unit`` or no unit at all (``no_unit``); and as ``compensate``.
    """
    names = [_column(columns, axis) for axis in model.axes]
    channels = [recording.channel(name) for name in names]
    readings = to_input_unit(model, channels)
    temperature = _temperature(model, recording, columns)
    if temperature is not None:
        conditions["temperature"] = temperature
    if "pressure" in columns:
        conditions["pressure"] = _in_unit(recording.channel(columns["pressure"]), "Pa")
    others = {
        one.channel: _in_unit(recording.channel(columns[one.channel]), one.unit)
        for one in model.sensitivities
        if one.channel in columns and one.channel != PRESSURE
    }
    conditions["channels"] = {**conditions.get("channels", {}), **others}
    x = compensate(model, readings, **conditions)
    made = {}
    for i, channel in enumerate(channels):
        unit = channel.unit if channel.unit and same_dimension(channel.unit, model.unit) else model.unit
        made[channel.name] = replace(
            channel, data=to_unit(x[:, i], model.unit, unit).copy(), unit=unit, quantity=QUANTITY[model.unit]
        )
    remarks = [
        replace(remark if part else counted(remark, len(x)), where=recording.place(remark.index))
        for remark in beyond(model, x, readings, **conditions)
    ]
    return replace(
        recording,
        channels=tuple(made.get(channel.name, channel) for channel in recording.channels),
        remarks=(*recording.remarks, *remarks),
    )


def to_input_unit(model: SensorModel, channels: list[Channel]) -> Array:
    """Return readings r [input unit] of channels in units of input or of output, shape (n, k).

    Raises
    ------
    DataError
        ``wrong_unit``, ``no_unit``, or channels of both kinds.
    """
    readings = np.empty((len(channels[0].data), len(channels)))
    for i, channel in enumerate(channels):
        unit = _unit(channel, model.unit)
        check_item(model, unit=unit)
        if same_dimension(unit, model.unit):
            readings[:, i] = to_unit(channel.data, unit, model.unit)
        else:
            output = np.zeros((len(channel.data), len(model.axes)))
            output[:, i] = to_unit(channel.data, unit, model.output_unit)
            readings[:, i] = to_readings(model, output)[:, i]
    return readings


def _unit(channel: Channel, like: str) -> str:
    """Return the unit of a channel; Raises ``no_unit`` where it has none."""
    if not channel.unit:
        raise DataError(f"column {channel.name!r} has no unit", do=f"Give it, like {like}", code="no_unit")
    return channel.unit


def _in_unit(channel: Channel, unit: str) -> Array:
    return to_unit(channel.data, _unit(channel, unit), unit)


def _temperature(model: SensorModel, recording: Recording, columns: Mapping[str, str]) -> Array | None:
    names = [columns.get(f"temperature_{axis}", columns.get("temperature")) for axis in model.axes]
    if any(name is None for name in names):
        return None
    found = [recording.channel(str(name)) for name in names]
    return np.column_stack([to_unit(channel.data, channel.unit or "degC", "degC") for channel in found])


def _condition(chain: Chain, recording: Recording, columns: Mapping[str, str], kind: str) -> Array | None:
    names = [columns.get(f"{kind}_{axis}", columns.get(kind)) for axis in chain.axes]
    if all(name is None for name in names):
        return None
    for axis, name in zip(chain.axes, names, strict=True):
        if name is None:
            raise DataError(
                f"no {kind} channel for {axis}", do=f"Name its column: {kind}_{axis}", code=f"missing_{kind}"
            )
    return _counts(chain, recording, [str(name) for name in names])


def _counts(chain: Chain, recording: Recording, names: list[str]) -> Array:
    """Return columns as the chain takes them: counts as they are, others in its unit."""
    counts, made = chain.input_unit == "count", []
    for name in names:
        channel = recording.channel(name)
        unit = channel.unit or "count"
        if not same_dimension(unit, chain.input_unit):
            takes = "counts" if counts else "volts" if chain.input_unit == "V" else chain.input_unit
            raise DataError(
                f"column {name!r} is in {channel.unit or 'no unit'}, the chain takes {takes}",
                where=recording.source.path,
                why="what the chain takes together is all in one unit",
                do="Correct the unit of the column, or the chain",
                code="wrong_unit",
            )
        made.append(channel.data if counts else to_unit(channel.data, unit, chain.input_unit))
    return recording.array(names) if counts else np.column_stack(made)


def _column(columns: Mapping[str, str], axis: str) -> str:
    try:
        return columns[axis]
    except KeyError:
        raise DataError(
            f"no column named for axis {axis}", do=f"Given: {', '.join(columns)}", code="wrong_column"
        ) from None

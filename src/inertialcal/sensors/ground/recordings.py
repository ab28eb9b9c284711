"""A ground model applied to the recording of a head: corrected axes, and beside them the bias that it predicts."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ...core.estimate import Array
from ...core.recording import Channel, Recording
from ...core.units import convert
from .correction import correct
from .model import GroundModel

PREDICTED = "predicted_"  # before the axis: bias that the ground model predicts
TEMPERATURE, GAIN = "temperature", "gain"


def correct_recording(
    ground: GroundModel,
    recording: Recording,
    gains: Mapping[str, float],
    *,
    applied: Collection[str] = (),
    keep_bias: bool = False,
) -> Recording:
    """Return the recording of a head after a ground model.

    Parameters
    ----------
    recording : Recording
        Axes in the input unit; ``temperature_x``, ... or ``temperature`` [degC], and ``gain_x``, ... or ``gain`` over
        time, where they are there.
    gains : mapping of str to float
        Of the axes whose gain was not recorded; empty where it is not known.
    applied, keep_bias
        As ``ground_correction.correct`` takes them.

    Returns
    -------
    Recording
        The axes corrected, and ``predicted_x``, ... [input unit] of each; the other channels as they are.

    Raises
    ------
    DataError
        As ``ground_correction.correct``.
    """
    n = len(recording)
    read = [axis for axis in ground.axes if axis in recording.names]
    readings = np.full((n, len(ground.axes)), np.nan)
    for axis in read:
        readings[:, ground.axes.index(axis)] = recording.channel(axis).data
    done = correct(
        ground,
        readings,
        temperature=_each(recording, ground.axes, TEMPERATURE, "degC"),
        gain=_gain(recording, ground.axes, gains),
        applied=applied,
        keep_bias=keep_bias,
    )
    unit = ground.base.unit
    made = {}
    for axis in read:
        own = done.readings[:, ground.axes.index(axis)].copy()
        made[axis] = replace(recording.channel(axis), data=own)
    told = tuple(
        Channel(PREDICTED + axis, done.predicted[:, ground.axes.index(axis)].copy(), unit, "model", axis)
        for axis in read
    )
    channels = tuple(made.get(channel.name, channel) for channel in recording.channels)
    return replace(recording, channels=(*channels, *told), remarks=(*recording.remarks, *done.remarks))


def _each(recording: Recording, axes: Sequence[str], what: str, unit: str) -> Array | None:
    """Return a channel of each axis, or one for all, shape (n, k); NaN for an axis that has none."""
    names = [next((one for one in (f"{what}_{axis}", what) if one in recording.names), "") for axis in axes]
    if not any(names):
        return None
    found = np.full((len(recording), len(axes)), np.nan)
    for i, name in enumerate(names):
        if name:
            channel = recording.channel(name)
            found[:, i] = convert(channel.data, channel.unit or unit, unit)
    return found


def _gain(recording: Recording, axes: Sequence[str], stated: Mapping[str, float]) -> Array | None:
    """Return the gain of each axis, over time where it was recorded, shape (k,) or (n, k)."""
    recorded = _each(recording, axes, GAIN, "1")
    fixed = np.array([stated.get(axis, np.nan) for axis in axes])
    if recorded is None:
        return fixed if stated else None
    has = [any(name in recording.names for name in (f"{GAIN}_{axis}", GAIN)) for axis in axes]
    return np.where(has, recorded, fixed)

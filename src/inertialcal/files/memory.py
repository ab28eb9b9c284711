"""Recordings of what is in memory: arrays with their sample rate, Recordings with units said for their channels."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from ..core.batches import adopt, made
from ..core.errors import DataError, UsageError
from ..core.estimate import Array
from ..core.key import AXES
from ..core.recording import Channel, Recording
from ..core.unit.magnitudes import check_sample_rate
from ..core.units import normalise
from .info.describe import overridden
from .text.headers import heading

Taken = str | Path | Recording | Array


def recording_of(
    given: Recording | Array | Sequence[float],
    units: Mapping[str, str] | str | None = None,
    sample_rate: float | None = None,
) -> Recording:
    """Return a Recording, or an array of shape (n,) or (n, axes), as a recording with the units that are said.

    Parameters
    ----------
    given : Recording or array_like
        A stored or mapped array is not copied, where its columns are contiguous.
    units : mapping of str to str, or str, optional
        By column or group; one alone is that of all columns of an array.
    sample_rate : float, optional
        [Hz]; needed with an array.

    Raises
    ------
    UsageError
        ``wrong_type``, if it is neither, or no path; ``sample_rate``.
    DataError
        ``no_time``, ``wrong_value``, if an array has no sample rate, or another shape.
    """
    if isinstance(given, Recording):
        return with_named_units(given, units if isinstance(units, Mapping) else {})
    if not isinstance(given, np.ndarray | list | tuple):
        what = f"a recording of type {type(given).__name__}"
        raise UsageError(what, do="Give a path, a Recording, or an array with its sample_rate", code="wrong_type")
    said = units if isinstance(units, str) else next(iter((units or {}).values()), None)
    return of_array(numbers_of(given), sample_rate, said)


def the_only(given: object) -> Taken:
    """Return the recording of a list of one, be it a path, a Recording or an array; anything else as it is.

    Raises
    ------
    UsageError
        ``wrong_type``, of several: each is read by itself.
    """
    held = given if isinstance(given, list | tuple) else ()
    if not any(isinstance(one, str | PathLike | Recording | np.ndarray) for one in held):
        return cast("Taken", given)  # one recording, or numbers
    if len(held) == 1:
        return cast("Taken", held[0])
    raise UsageError(f"{len(held)} recordings at once", do="Give them one by one", code="wrong_type")


def numbers_of(given: object) -> NDArray[Any]:
    """Return an array of numbers that was given; a stored or mapped one is not copied.

    Raises
    ------
    DataError
        ``wrong_value``, if it holds anything but numbers.
    """
    try:
        values = np.asarray(given)
    except ValueError:  # rows of different length
        values = np.asarray(None)
    if values.dtype.kind not in "biuf":
        what = "an array of anything but real numbers"
        raise DataError(what, do="Give numbers, shape (n,) or (n, axes)", code="wrong_value")
    return values


def of_array(values: Array, sample_rate: float | None, unit: str | None) -> Recording:
    """Return an array of shape (n,) or (n, k) as a recording with channels x, y, z, or numbered ones.

    Raises
    ------
    DataError
        ``no_time``, ``wrong_value``.
    UsageError
        ``sample_rate``.
    """
    columns = values[:, None] if values.ndim == 1 else values
    if columns.ndim != 2 or not columns.size:
        raise DataError(f"array of shape {values.shape}, need (n,) or (n, axes)", code="wrong_value")
    count = columns.shape[1]
    names = AXES[:count] if count <= len(AXES) else [f"column_{i + 1}" for i in range(count)]
    if sample_rate is None:
        raise DataError("an array has no time", do="Add sample_rate=... [Hz]", code="no_time")
    if wrong := check_sample_rate(sample_rate):
        raise UsageError(wrong, code="sample_rate")
    spoken = None if unit is None else normalise(unit)
    adopt(columns)
    channels = tuple(
        Channel(name, _contiguous(columns[:, i], columns), spoken, "flag", name if name in AXES else "")
        for i, name in enumerate(names)
    )
    return Recording(channels, sample_interval=1.0 / sample_rate, interval_from="flag")


def _as_named(recording: Recording) -> Recording:
    """Return a recording whose channels are what their names say, where nobody has said it."""
    channels = list(recording.channels)
    for i, one in enumerate(channels):
        if not one.axis and not one.quantity:
            said = heading(one.name, one.unit)
            channels[i] = replace(one, axis=said.axis, quantity=said.quantity)
            if one.unit is None and said.unit is not None:
                channels[i] = replace(channels[i], unit=said.unit, unit_from="header")
    return replace(recording, channels=tuple(channels))


def _contiguous(column: NDArray[Any], whole: NDArray[Any]) -> NDArray[Any]:
    """Return a column in one piece: itself where it is, else copied, a long one a batch at a time to the disk."""
    if column.flags.c_contiguous:
        return column
    return made(len(column), column.dtype, lambda first, stop: column[first:stop], whole)


def with_named_units(recording: Recording, units: Mapping[str, str]) -> Recording:
    """Return a recording in memory with the units of its columns or groups that were said.

    What the maker of a recording left out (sensor, axis, unit of a channel) its names say, as in a file.
    """
    recording = recording if recording.source.path else _as_named(recording)
    said = [units.get(one.name) or units.get(one.quantity) for one in recording.channels]
    stated = [None if unit is None else normalise(unit) for unit in said]
    channels = [one if unit is None else replace(one, unit=unit, unit_from="flag")
                for one, unit in zip(recording.channels, stated, strict=True)]  # fmt: skip
    overruled = [(one.name, one.unit, unit) for one, unit in zip(recording.channels, stated, strict=True)]
    remarks = overridden(overruled, recording.source.path)
    return replace(recording, channels=tuple(channels), remarks=(*recording.remarks, *remarks))

"""Recordings of a sensor at rest, from files, Recordings or arrays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.axes import AXES
from ...core.errors import DataError, UsageError
from ...core.recording import Channel, Recording
from ...core.units import normalise, parse_quantity
from ...files import read

Source = str | Path | Recording | NDArray[Any]


def recordings_of(
    sources: Source | Sequence[Source],
    *,
    units: Mapping[str, str] | None = None,
    unit: str | None = None,
    sample_rate: float | None = None,
    averaging: str | None = None,
    **part: Any,
) -> list[Recording]:
    """Return the recordings: read from files, or as given.

    Parameters
    ----------
    sources : path, Recording, array, or sequence of path or Recording
        An array is (n,) or (n, axes), one sample interval apart.
    units : mapping of str to str, optional
        By column or group, as ``read`` takes them.
    unit : str, optional
        Of an array.
    sample_rate : float, optional
        [Hz]
    averaging : str, optional
        What each sample is the mean of, where that is less than the sample interval: ``"1 s"``.
    **part
        As ``read`` takes it: ``time_column``, ``start``, ``stop``, ``mission_start``, ``frame``.

    Raises
    ------
    DataError, UsageError
        As ``files.read``; or if a file is given twice (``duplicate_id``), or an array has no sample rate (``no_time``).
    """
    several = [sources] if isinstance(sources, str | Path | Recording | np.ndarray) else list(sources)
    if not several:
        raise UsageError("no file", do="Name a recording of a sensor at rest", code="wrong_value")
    paths = [Path(one).resolve() for one in several if isinstance(one, str | Path)]
    twice = [str(path) for path in paths if paths.count(path) > 1]
    if twice:
        raise UsageError(f"{twice[0]}: given twice", why="its samples would count twice", code="duplicate_id")
    window = None if averaging is None else quantity(averaging, "s", "averaging", "1 s")
    found = []
    for one in several:
        if isinstance(one, str | Path):
            recording = read(one, units=units, sample_rate=sample_rate, **part)
        else:
            recording = one if isinstance(one, Recording) else _of_array(np.asarray(one), unit, sample_rate)
        found.append(recording if window is None else replace(recording, averaging_time=window))
    return found


def _of_array(values: NDArray[Any], unit: str | None, sample_rate: float | None) -> Recording:
    """Return an array as a recording: axes x, y, z, or channels by number where there are more."""
    columns = values[:, None] if values.ndim == 1 else values
    if columns.ndim != 2 or not columns.size:
        raise DataError(f"an array of shape {values.shape}", do="Need (n,) or (n, axes)", code="wrong_shape")
    if sample_rate is None:
        do = "Give sample_rate [Hz]"
        raise DataError("an array has no time of its own", do=do, code="no_time")
    said = None if unit is None else normalise(unit)
    count = columns.shape[1]
    names = AXES[:count] if count <= len(AXES) else tuple(f"column_{i + 1}" for i in range(count))
    channels = tuple(
        Channel(name, np.ascontiguousarray(columns[:, i]), said, "flag" if said else "", name if name in AXES else "")
        for i, name in enumerate(names)
    )
    return Recording(channels, sample_interval=1.0 / sample_rate, interval_from="flag")


def one_of(given: str, known: Sequence[str], what: str) -> str:
    """Return a word.

    Parameters
    ----------
    given : str
        By the user.
    known : sequence of str
        Words that there are.
    what : str
        Name of the setting, for the message.

    Raises
    ------
    UsageError
        If it is none of them.
    """
    if given not in known:
        raise UsageError(f"{what}: {given!r}", do=f"There are: {', '.join(known)}", code="wrong_value")
    return given


def quantity(given: str, unit: str, what: str, like: str) -> float:
    """Return a number in a unit.

    Parameters
    ----------
    given : str
        By the user: ``"10 min"``.
    unit : str
        Of the number.
    what : str
        Name of the setting, for the message.
    like : str
        How to write it.

    Raises
    ------
    UsageError
        If it has no unit, or another one.
    """
    try:
        return float(parse_quantity(given).to(unit, difference=True))
    except DataError:
        do = f'Write a number with its unit, like "{like}"'
        raise UsageError(f"{what}: {given!r}", do=do, code="no_unit") from None

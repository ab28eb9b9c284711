"""Axes of archive data: those that the header says the data are in, or those of the sensor itself."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import numpy as np

from ...core.errors import DataError, UsageError
from ...core.estimate import Array, Numbers
from ...core.remarks import Remark
from ...physics.attitude import between
from .header import PadHeader, read_header
from .pairs import pairs_of

Frame = Literal["data", "sensor"]
FRAMES = ("data", "sensor")
SAME = 1e-9  # of the elements of a matrix, from which two systems have the same axes
BLOCK = 2**18  # samples


def check_frame(frame: str | None) -> None:
    """Refuse a word that names no coordinate system.

    Raises
    ------
    UsageError
        ``wrong_frame``.
    """
    if frame is not None and frame not in FRAMES:
        raise UsageError(f"frame {frame!r}", do=f"Say one of: {', '.join(FRAMES)}", code="wrong_frame")


def C_sensor_data(header: PadHeader) -> Array | None:
    """Return the matrix that takes components in data axes to those of the sensor; None where axes are not said."""
    if header.sensor_system is None or header.data_system is None:
        return None
    return between(header.sensor_system.C_station_system, header.data_system.C_station_system)


def turned(
    values: list[Numbers], header: PadHeader, frame: str | None, where: str
) -> tuple[list[Numbers], tuple[Remark, ...]]:
    """Return the columns with the first three in the axes asked for, in the type that they had.

    Parameters
    ----------
    values : list of ndarray, shape (n,)
        In data axes; changed in place.
    header : PadHeader
        Which says both coordinate systems.
    frame : {"data", "sensor"} or None
        None is as the data are.
    where : str
        File, for messages.

    Raises
    ------
    DataError
        ``no_frames``, if sensor axes are asked for and the header does not say them.
    """
    C = C_sensor_data(header)
    if C is None and frame == "sensor":
        raise DataError(
            "sensor axes requested, but the header gives no coordinate systems",
            where=where,
            do="Read it without --frame",
            code="no_frames",
        )
    if C is None or np.abs(C - np.eye(3)).max() < SAME:
        return values, ()
    if frame != "sensor":
        what = f"x, y, z are the axes of {header.data_system}, not those of the sensor {header.sensor_system}"
        do = "For sensor axes, in which its bias and scale factor are defined, add --frame sensor"
        return values, (Remark("not_sensor_axes", "info", what, where, do=do),)
    for first in range(0, len(values[0]), BLOCK):
        part = slice(first, first + BLOCK)
        vectors = [column[part].astype(np.float64) for column in values[:3]]
        for axis in range(3):
            turned_part = C[axis, 0] * vectors[0]
            for other in (1, 2):
                turned_part += C[axis, other] * vectors[other]
            values[axis][part] = turned_part
    what = f"x, y, z turned from {header.data_system} to the axes of the sensor {header.sensor_system}"
    return values, (Remark("turned_to_sensor_axes", "info", what, where),)


def sensor_frame(path: str | Path) -> Frame | None:
    """Return ``"sensor"`` for archive records whose axes are not those of their sensor, by the headers alone.

    None for all others, and where a header does not say both systems.

    Raises
    ------
    DataError
        If a header is missing or damaged.
    """
    turns = [C_sensor_data(read_header(pair.header)) for pair in pairs_of(path)]
    known = [C for C in turns if C is not None]
    differ = any(np.abs(C - np.eye(3)).max() >= SAME for C in known)
    return "sensor" if differ and len(known) == len(turns) else None

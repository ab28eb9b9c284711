"""Files of a logger that writes pairs of 64-bit floats, time [s] and rate [deg/s], behind the four bytes ``TOY1``."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from inertialcal.files.binary.arrays import number_column
from inertialcal.files.columns import Content
from inertialcal.files.reader import Reader
from inertialcal.files.source import Loaded


def recognises(data: bytes, path: str) -> bool:
    """Tell a file of this logger by its first bytes."""
    return data.startswith(b"TOY1")


def read(loaded: Loaded, variables: Sequence[str] | None) -> Content:
    """Return its two columns."""
    table = np.frombuffer(loaded.data[4:], dtype="<f8").reshape(-1, 2)
    columns = (number_column("time [s]", table[:, 0], None), number_column("gyro_x", table[:, 1], "deg/s"))
    return Content(columns, "Toy, little endian")


READER = Reader("toy", "Toy logger", (".toy",), recognises, read)

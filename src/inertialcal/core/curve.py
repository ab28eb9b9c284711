"""Curve: figures over a range, as equally long columns with units; a procedure's Result gives them, SI.

A column of numbers has the unit that its values stand in; labels, flags and degrees of freedom have none.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .errors import DataError
from .results import finite

Cell = float | str | bool | None  # of a column, as JSON has it


@dataclass(frozen=True, eq=False)
class Column:
    """Values of one column."""

    values: Sequence[Any] | NDArray[Any]  # In ``unit``; absent numbers are None or NaN
    unit: str = ""  # As ``core.units`` prints it; empty for what has none
    shown: str = ""  # Unit that people speak it in; empty for that of the campaign

    def plain(self) -> list[Cell]:
        """Return the values as ``results.json`` holds them: plain Python, not finite numbers null."""
        values = self.values.tolist() if isinstance(self.values, np.ndarray) else self.values
        if {*map(type, values)} <= {float} and np.isfinite(values).all():
            return list(values)
        return [finite(value) if isinstance(value, float) else value for value in values]


@dataclass(frozen=True, eq=False)
class Curve:
    """One curve.

    Raises
    ------
    DataError
        If the columns differ in length.
    """

    name: str  # What it shows: ``"input_output"``
    axis: str  # Of the sensor
    columns: Mapping[str, Column]  # All equally long
    of: str = ""  # What of it: ``"dwell_mean"``; empty where there is one only
    recording: str = ""  # Where it belongs to one recording: the name of it
    picture: bool = False  # Only a picture shows it: ten digits are enough
    sensor: str = ""  # Kind of sensor, where one test has several

    def __post_init__(self) -> None:
        lengths = {name: len(column.values) for name, column in self.columns.items()}
        if len(set(lengths.values())) > 1:
            raise DataError(f"curve {self.name!r}: columns of different length: {lengths}")

    def to_dict(self, test: str = "") -> dict[str, Any]:
        """Return the curve as ``results.json`` holds it; not finite numbers are null."""
        head = {"name": self.name, "test": test, "axis": self.axis}
        head |= {"of": self.of} if self.of else {}
        head |= {"recording": self.recording} if self.recording else {}
        head |= {"sensor": self.sensor} if self.sensor else {}
        columns = {name: {"unit": one.unit, "values": one.plain()} for name, one in self.columns.items()}
        return {**head, "columns": columns}

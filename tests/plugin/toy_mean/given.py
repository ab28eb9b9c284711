"""What a file given to the command is: a table of means, or a recording."""

from __future__ import annotations

from dataclasses import replace

from inertialcal.procedures.given import Described, GivenFile, sensor_said
from inertialcal.procedures.given import described as described_channels
from inertialcal.procedures.protocol import InputSpec

COLUMNS = {"x": "mean_x", "y": "mean_y"}


def described(given: GivenFile, spec: InputSpec) -> Described:
    """Return a table where the file has columns of means, else a recording of channels."""
    if given.has_rows and set(COLUMNS.values()) <= set(given.table.names):
        unit = next(iter(given.said.units.values()), "deg/s")
        means = {**COLUMNS, "unit": unit}
        return Described({"mean_table": means}, sensor_said(given, "gyro", [*COLUMNS], unit), dict(COLUMNS))
    found = described_channels(given, spec)
    return replace(found, entry=found.entry | ({"upside_down": True} if given.own.get("upside_down") else {}))

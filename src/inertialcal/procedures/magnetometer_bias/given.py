"""What a file of a gyro and a magnetometer in orbit is taken for: both triads, and where the spacecraft was."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from ...core.errors import UsageError
from ...core.key import AXES
from ...core.recording import Recording
from ...files.text.headers import bare_name
from ..given import Described, GivenFile
from ..given import described as described_channels
from ..protocol import InputSpec

GEODETIC = {
    "latitude": ("latitude", "lat", "gps_lat", "geodetic_latitude"),
    "longitude": ("longitude", "lon", "long", "lng", "gps_lon"),
    "height": ("height", "altitude", "alt", "hgt", "gps_alt", "geodetic_height"),
}
FIXED = ("position_{}", "ecef_{}", "{}_ecef", "r_ecef_{}", "pos_{}", "pos_ecef_{}", "r{}_ecef")


def described(given: GivenFile, spec: InputSpec) -> Described:
    """Return gyro, magnetometer and position of a file.

    Raises
    ------
    UsageError
        ``no_column`` where it cannot be told which column is the magnetometer, or where the spacecraft was.
    """
    columns = dict(given.said.columns)
    columns |= {role: name for role, name in found_columns(given.recording).items() if role not in columns}
    if said := given.own.get("magnetometer"):
        names = [one.strip() for one in str(said).split(",")]
        if len(names) != len(AXES):
            raise UsageError(f"magnetometer {said!r}: {len(names)} columns", do="Name three: x,y,z", code="no_column")
        columns |= {f"magnetometer_{axis}": name for axis, name in zip(AXES, names, strict=True)}
    have = ", ".join(given.recording.names)
    if not all(f"magnetometer_{axis}" in columns for axis in AXES):
        what = f"{given.name}: cannot tell which columns are the magnetometer; it has {have}"
        raise UsageError(what, do=f"Add: {given.add('magnetometer', 'BX,BY,BZ')}", code="no_column")
    places = {*GEODETIC, *(f"position_{axis}" for axis in AXES)}
    if tle := given.own.get("tle"):
        columns = {role: name for role, name in columns.items() if role not in places}
        found = described_channels(replace(given, said=replace(given.said, columns=columns)), spec)
        return replace(found, entry={**found.entry, "tle": _elements(given, str(tle))})
    if given.own.get("satellite"):
        raise UsageError("a satellite, and no elements of it", do="Name the file with its two-line elements, too",
                         code="missing")  # fmt: skip
    fixed = all(f"position_{axis}" in columns for axis in AXES)
    if not fixed and not all(name in columns for name in GEODETIC):
        what = f"{given.name}: cannot tell where the spacecraft was; it has {have}"
        do = f"Add: {given.add('column', 'latitude=COLUMN')}, longitude and height alike; or earth-fixed position_x, "
        do += "position_y, position_z; or the two-line elements of the satellite"
        raise UsageError(what, why="the field of the earth is taken along the orbit", do=do, code="no_column")
    unused = GEODETIC if fixed else [f"position_{axis}" for axis in AXES]
    columns = {role: name for role, name in columns.items() if role not in unused}
    return described_channels(replace(given, said=replace(given.said, columns=columns)), spec)


def like(given: GivenFile, entry: Mapping[str, Any]) -> dict[str, Any]:
    """Return an entry of another campaign, with the elements that are given of this file."""
    if tle := given.own.get("tle") or entry.get("tle", {}).get("file"):
        return {**entry, "tle": {**entry.get("tle", {}), **_elements(given, str(tle))}}
    return dict(entry)


def _elements(given: GivenFile, file: str) -> dict[str, str]:
    satellite = given.own.get("satellite")
    return {"file": file} | ({"satellite": str(satellite)} if satellite else {})


def found_columns(recording: Recording) -> dict[str, str]:
    """Return columns of the magnetometer and of the position by role, as far as names tell."""
    found = {f"magnetometer_{one.axis}": one.name for one in recording.channels
             if one.quantity == "magnetometer" and one.axis in AXES}  # fmt: skip
    own = {bare_name(one.name).lower(): one.name for one in recording.channels}
    for role, names in GEODETIC.items():
        if named := next((own[name] for name in names if name in own), ""):
            found[role] = named
    for form in FIXED:
        fixed = {f"position_{axis}": own[form.format(axis)] for axis in AXES if form.format(axis) in own}
        found |= fixed if len(fixed) == len(AXES) else {}
    return found

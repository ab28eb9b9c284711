"""What a file is taken for: a table of flips, a row an axis and flip; results of flips; or a recording of a flip."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from ...core.errors import InertialcalError, UsageError
from ...core.units import kind, normalise
from ..flip.given import described as described_flip
from ..given import Described, GivenFile, bare, sensor_said
from ..protocol import InputSpec
from .readings import read_ground

PATTERNS = {
    "flight": r"^(flight|mission|launch|sortie)$",
    "date": r"^(date|time|when|day|utc)$",
    "axis": r"^(axis|channel|sensor)$",
    "temperature": r"^(temperature|temp|t)$",
    "bias": r"^(bias|value)$",
    "u": r"^(u|u_bias|bias_u|uncertainty|standard_uncertainty)$",
    "dof": r"^(dof|degrees_of_freedom)$",
    "serial": r"^(serial|serial_number|unit_serial|sn)$",
}
OPTIONAL = ("dof", "serial")


def is_recording(given: GivenFile) -> bool:
    """Tell whether a file is a recording of a flip, and no table of flips or results of them."""
    if not given.has_rows or Path(given.name).is_dir():
        return True
    if given.said.columns.get("bias") or Path(given.name).suffix.lower() == ".json":
        return False
    try:
        return _column(given.table.names, "bias") is None and _column(given.table.names, "flight") is None
    except InertialcalError:  # no table, but perhaps a record of the archive
        return True


def described_recording(given: GivenFile, spec: InputSpec) -> Described:
    """Return a recording of a flip as a test of its own: the bias is along the axes of the head by the ground model.

    Raises
    ------
    UsageError
        ``missing`` where no ground model is given; as for a flip.
    """
    ground = str(_ground(given))
    found = described_flip(given, spec)
    axes = read_ground(ground).axes
    sensor = {**found.sensor, "axes": [*axes], "chain": {"kind": "none", **found.sensor.get("chain", {}),
                                                        "model": ground}}  # fmt: skip
    return replace(found, sensor=sensor, plan=dict(given.own.get("turn", {})), procedure="flip")


def described(given: GivenFile) -> Described:
    """Return columns, unit and sensor of a table of flips.

    Raises
    ------
    UsageError
        If a column or the unit is not clear, or no ground model is given.
    DataError
        As ``readings.read_ground``.
    """
    ground = _ground(given)
    table, said = given.table, given.said.columns
    if strange := [what for what in said if what not in PATTERNS]:
        raise UsageError(f"column {strange[0]!r}", do=f"There are: {', '.join(PATTERNS)}", code="unknown_name")
    columns = {what: said.get(what) or _column(table.names, what) for what in PATTERNS}
    for what, name in columns.items():
        if name is None and what not in OPTIONAL:
            text = f"{given.name}: cannot tell which column is the {what}; it has {', '.join(table.names)}"
            raise UsageError(text, do=f"Add: {given.add('column', f'{what}=COLUMN')}", code="no_column")
    found = {what: name for what, name in columns.items() if name is not None}
    units = given.said.units
    unit = units.get("bias") or units.get(found["bias"]) or bare(units) or table.unit(found["bias"])
    if unit is None:
        what = f"{given.name}: unit of {found['bias']!r} not given"
        raise UsageError(what, do=f"Add: {given.add('unit', 'bias=ug')}", code="no_unit")
    if kind(normalise(unit)) != "acceleration":
        what = f"{given.name}: {found['bias']!r} is in {unit}: not a unit of acceleration"
        raise UsageError(what, do="Give the biases in ug, g or m/s2", code="unit_mismatch")
    axes = read_ground(str(ground)).axes
    flips = {**found, "unit": normalise(unit), "file": str(ground)}
    return Described({"flips": flips}, sensor_said(given, "accelerometer", axes, normalise(unit), {}), found)


def like(given: GivenFile, entry: Mapping[str, Any]) -> dict[str, Any]:
    """Return the entry of another campaign, with the ground model that is given."""
    ground = given.own.get("ground")
    return {**entry, "flips": {**entry["flips"], "file": str(ground)}} if ground and "flips" in entry else dict(entry)


def _ground(given: GivenFile) -> object:
    ground = given.own.get("ground")
    if not ground:
        what = f"{given.name}: the ground model is missing"
        raise UsageError(what, "", "flips shift it", f"Add: {given.add('ground', 'ground.json')}", "missing")
    return ground


def _column(names: Sequence[str], what: str) -> str | None:
    found = [name for name in names if re.fullmatch(PATTERNS[what], _plain(name))]
    return found[0] if len(found) == 1 else None


def _plain(name: str) -> str:
    """Return a name in small letters, without the unit in brackets."""
    return re.sub(r"[^a-z0-9]+", "_", re.sub(r"\s*[\[(].*$", "", name.lower())).strip("_")

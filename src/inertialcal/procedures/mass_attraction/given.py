"""What a record of a moved mass is taken for by its noun: pulses of one axis, and the schedule of the mass."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import PurePath
from typing import Any

from ...core.errors import UsageError
from ...core.key import AXES
from ...core.units import same_dimension
from ..given import Described, GivenFile
from ..given import described as described_by_unit
from ..protocol import InputSpec

UNIT = "ug"  # of readings, where no scale factor shows another one


def described(given: GivenFile, spec: InputSpec) -> Described:
    """Return the channels of a record, with its schedule.

    Raises
    ------
    UsageError
        If schedule or gate is missing, or it is not clear which column holds the pulses.
    """
    own, said = given.own, given.said
    if not own.get("schedule"):
        do = f"Add: {given.add('schedule', 'schedule.csv')}"
        raise UsageError("the schedule of the mass is missing", do=do, code="missing")
    chain = said.chain
    if chain is None:
        if said.lsb is not None or said.reference:
            what = "mass_attraction needs pulses, counted over a gate: lsb and reference are of readings in volts"
            raise UsageError(what, given.name, do="Leave it out, and give the pulses", code="option_without_effect")
        if own.get("gate") is None:
            what, do = (
                f"{given.name}: pulses without the time over which they are counted",
                given.add("gate", "GATE s"),
            )
            raise UsageError(what, do=f"Add: {do}", code="no_gate")
        chain = f'{{ kind = "pulse_rate", gate = "{own["gate"]}" }}'
    columns = _columns(given, spec)
    found = described_by_unit(replace(given, said=replace(said, columns=columns, chain=chain)), spec)
    if not found.sensor["chain"].get("scale_factor"):
        found.sensor["unit"] = UNIT
    mass: dict[str, object] = _schedule(given)
    if _at_rest(given):
        mass["moved"] = False
    entry = found.entry | {"mass": mass}
    if own.get("stamp") is not None:
        gate = {} if own.get("gate") is None else {"averaging": own["gate"]}
        entry["clock"] = {"stamp": own["stamp"]} | gate
    return replace(found, entry=entry)


def like(given: GivenFile, entry: Mapping[str, Any]) -> dict[str, Any]:
    """Return the entry of another campaign, with the schedule, its start, the stamps and the runs at rest of this file.

    Raises
    ------
    UsageError
        If a gate is given: it belongs to the chain of the sensor, which the campaign states.
    """
    own, found = given.own, dict(entry)
    if own.get("gate") is not None:
        what = f"{given.add('gate', own['gate'])}: the campaign states the gate"
        raise UsageError(what, do="Leave it out, or change the chain of its sensor", code="option_without_effect")
    mass = _schedule(given)
    if own.get("null"):
        mass["moved"] = not _at_rest(given)
    if mass:
        found["mass"] = {**entry.get("mass", {}), **mass}
    if own.get("stamp") is not None:
        found["clock"] = {**entry.get("clock", {}), "stamp": own["stamp"]}
    return found


def _schedule(given: GivenFile) -> dict[str, object]:
    """Return schedule and begin of a file: of several schedules, the files take one after the other.

    Raises
    ------
    UsageError
        If the files cannot take the schedules equally often.
    """
    own = given.own
    found = {"begin": own["begin"]} if own.get("begin") is not None else {}
    schedules = _several(own.get("schedule"))
    if not schedules:
        return found
    if len(given.names) % len(schedules):
        what = f"{len(given.names)} file(s), {len(schedules)} schedules: the files take one after the other"
        raise UsageError(what, do="Give one schedule for all, or one for each file in their order", code="no_file")
    return {"schedule": schedules[(given.number - 1) % len(schedules)]} | found


def _several(said: Any) -> list[Any]:
    """Return what may be said once or several times as a list."""
    return [] if said is None else list(said) if isinstance(said, list | tuple) else [said]


def _at_rest(given: GivenFile) -> bool:
    """Return whether the mass was at rest in a file."""
    at_rest = set(_several(given.own.get("null")))
    if unknown := at_rest.difference(*map(_called, given.names)):
        do = "Name files that are given; the order does not matter"
        raise UsageError(f"{given.add('null', unknown.pop())}: no such file among those given", do=do, code="no_file")
    return bool(at_rest & _called(given.name))


def _columns(given: GivenFile, spec: InputSpec) -> dict[str, str]:
    """Return the columns by channel: as given, or the one column in pulses as x."""
    known = (*AXES, *(role.name for role in spec.roles))
    columns = {what: name for what, name in given.said.columns.items() if what != name or what in known}
    if any(axis in columns for axis in AXES):
        return columns
    bare = [name for what, name in given.said.columns.items() if what not in columns]
    channels = given.recording.channels
    pulses = bare or [one.name for one in channels if one.unit and same_dimension(one.unit, "count")]
    if len(pulses) != 1:
        have = ", ".join(given.recording.names)
        what = f"{given.name}: cannot tell which column holds the pulses; it has {have}"
        raise UsageError(what, do=f"Add: {given.add('column', 'x=COLUMN')}", code="no_column")
    return columns | {"x": pulses[0]}


def _called(name: str) -> set[str]:
    """Return path, name and name without suffix of a file."""
    return {name, PurePath(name).name, PurePath(name).stem}

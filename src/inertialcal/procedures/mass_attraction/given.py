"""What a record of a moved mass is taken for by its noun: the output of one axis, and the schedule of the mass.

The output is pulses counted over a gate or their rate, volts, codes of a converter or numbers of a digital sensor
through the chain, or readings in a unit of acceleration, of which the scale factor is that of the readings. Volts need
nothing said: their scale factor is what the test finds.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import PurePath
from typing import Any

from ...core.errors import UsageError
from ...core.key import AXES
from ...core.units import same_dimension
from ..given import Described, GivenFile, named_columns, raw_advice
from ..given import described as described_by_unit
from ..protocol import InputSpec

UNIT = "ug"  # of readings, where no scale factor shows another one
OUTPUTS = ("count", "count/s", "V", "m/s^2")  # units that the output of a sensor may be in, the first one found


def described(given: GivenFile, spec: InputSpec) -> Described:
    """Return the channels of a record, with its schedule.

    Raises
    ------
    UsageError
        If schedule or gate is missing, or it is not clear which column holds the output of the sensor.
    """
    own = given.own
    if not own.get("schedule"):
        do = f"Add: {given.add('schedule', 'schedule.csv')}"
        raise UsageError("the schedule of the mass is missing", do=do, code="missing")
    columns = _columns(given, spec)
    chain = _chain(given, columns)
    found = described_by_unit(replace(given, said=replace(given.said, columns=columns, chain=chain)), spec)
    own_chain = found.sensor.get("chain", {})
    if own_chain.get("kind") == "pulse_rate" and not own_chain.get("scale_factor"):
        found.sensor["unit"] = UNIT
    mass: dict[str, object] = _schedule(given)
    if _at_rest(given):
        mass["moved"] = False
    entry = found.entry | {"mass": mass}
    if own.get("stamp") is not None:
        gate = {} if own.get("gate") is None else {"averaging": own["gate"]}
        if own["stamp"] != "middle" and not (gate or given.said.averaging):
            what = f"{given.name}: {given.add('stamp', own['stamp'])} without what each sample is the mean of"
            raise UsageError(what, do=f"Add: {given.add('averaging', 'TIME s')}", code="missing")
        entry["clock"] = {"stamp": own["stamp"]} | gate
    return replace(found, entry=entry)


def _chain(given: GivenFile, columns: Mapping[str, str]) -> str | None:
    """Return the chain as text: as said, of a gate, else None.

    Raises
    ------
    UsageError
        ``no_gate`` for counts of which nothing says what they are; ``option_without_effect`` for a gate of volts, or
        beside parts of a converter.
    """
    said, gate = given.said, given.own.get("gate")
    named = named_columns(given.recording, {axis: columns[axis] for axis in AXES if axis in columns})
    units = [given.recording.channel(one).unit for one in named.values()]
    pulses = all(unit is None or same_dimension(unit, "count") or same_dimension(unit, "count/s") for unit in units)
    idle = [name for name in ("lsb", "counts", "reference", "gain") if getattr(said, name)]
    if said.chain is not None or gate is None:
        rates = pulses and any(unit and same_dimension(unit, "count/s") for unit in units)
        if said.chain is None and pulses and (rates or not (idle or said.scale_factor)):
            what = f"{given.name}: pulses without the time over which they are counted"
            do = f"Add: {given.add('gate', 'GATE s')}"
            do += "" if rates else f". No pulses? {raw_advice(given, ['count'], 'g')}"
            raise UsageError(what, do=do, code="no_gate")
        return said.chain
    if not pulses or idle:
        other = idle[0] if idle else f"readings in {units[0]}"
        what = f"{given.name}: {given.add('gate', gate)} is of pulses, {other} is of none"
        raise UsageError(what, do="Leave out what is wrong", code="option_without_effect")
    return f'{{ kind = "pulse_rate", gate = "{gate}" }}'


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
    """Return the columns by channel: as given, or the one column in pulses, else in another output, as x."""
    known = (*AXES, *(role.name for role in spec.roles))
    columns = {what: name for what, name in given.said.columns.items() if what != name or what in known}
    if any(axis in columns for axis in AXES):
        return columns
    bare = [name for what, name in given.said.columns.items() if what not in columns]
    channels = given.recording.channels
    taken = {*named_columns(given.recording, columns).values()}
    outputs = [bare] if bare else [
        [one.name for one in channels if one.unit and same_dimension(one.unit, unit) and one.name not in taken]
        for unit in OUTPUTS
    ]  # fmt: skip
    found = next((names for names in outputs if names), [])
    if len(found) != 1:
        have = ", ".join(given.recording.names)
        what = f"{given.name}: cannot tell which column holds the output of the sensor; it has {have}"
        raise UsageError(what, do=f"Add: {given.add('column', 'x=COLUMN')}", code="no_column")
    return columns | {"x": found[0]}


def _called(name: str) -> set[str]:
    """Return path, name and name without suffix of a file."""
    return {name, PurePath(name).name, PurePath(name).stem}

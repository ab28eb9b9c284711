"""The campaign entry of a run: control channels by name, responses by the names of their columns, what was asked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from ...core.errors import UsageError
from ...core.key import AXES
from ...core.units import kind
from ...files.text.headers import bare_name, full_name, in_brackets
from ..given import GROUP, KIND_OF_UNIT, Described, GivenFile
from ..given import described as described_by_unit
from ..protocol import InputSpec
from ..sine_survey.given import controls as named_controls
from .density import plain
from .plan import CONTROLS, DEVIATION, LEVEL_DEVIATION

ACCELERATION = KIND_OF_UNIT["accelerometer"]


def described(given: GivenFile, spec: InputSpec) -> Described:
    """Return a run: which columns are control, which are responses; tolerances as requirements.

    Raises
    ------
    UsageError
        ``missing`` without a profile; ``no_column``, ``too_many``; as ``given.described``.
    """
    given = _in_g(given)
    profile = given.own.get("profile")
    if not profile:
        do = f"Add: {given.add('profile', 'FILE.csv')}, with the nodes of the profile"
        raise UsageError(f"{given.name}: no profile", why="a run is judged against one", do=do, code="missing")
    named = _names(given, "control") or [given.said.columns[one] for one in CONTROLS if one in given.said.columns]
    controls = [_column(given, name) for name in named] or _controls_by_name(given)
    if len(controls) > len(CONTROLS):
        what = f"{given.name}: {len(controls)} control channels, {len(CONTROLS)} at most"
        raise UsageError(what, do="Name those that the table was controlled by", code="too_many")
    if len(set(controls)) < len(controls):
        raise UsageError(f"{given.name}: a control channel is given twice", code="duplicate_id")
    responses = [_column(given, name) for name in _names(given, "response")]
    columns = {what: name for what, name in given.said.columns.items() if what not in CONTROLS}
    axes = columns or _axes(given, responses, controls)
    accelerations = [name for name in axes.values() if given.recording.channel(_column(given, name)).quantity != "gyro"]
    if not controls and axes and len(accelerations) != 1:
        have = ", ".join(given.recording.names)
        what = f"{given.name}: cannot tell which column is the control accelerometer; it has {have}"
        known = any((one.unit and kind(one.unit) == ACCELERATION) or not one.unit for one in given.recording.channels)
        do = f"Add: {given.add('control', 'COLUMN')}" if known else "Record the control accelerometer on the same clock"
        raise UsageError(what, do=do, code="no_column")
    if not axes:  # the control accelerometers are the sensor
        axes, controls = _alone(given, controls), controls[1:]
        roles = dict(zip(CONTROLS[1:], controls, strict=False))
    else:
        roles = dict(zip(CONTROLS, controls, strict=False))
    said = replace(given.said, columns={**axes, **roles})
    taken = set(roles)
    kept = tuple(role for role in spec.roles if role.name in taken)
    found = described_by_unit(replace(given, said=said), replace(spec, roles=kept))
    entry: dict[str, Any] = {"profile": str(profile)}
    test = f"vibration_{given.number}" if len(given.together) > 1 else ""
    return replace(found, entry=found.entry | entry, test=test, requirements=_requirements(given))


def _controls_by_name(given: GivenFile) -> list[str]:
    """Return the columns whose names say that they are control accelerometers, as a survey finds them."""
    taken = {*given.said.columns.values(), *_names(given, "response")}
    return [one for one in named_controls(given.recording) if one not in taken and bare_name(one) not in taken]


def _in_g(given: GivenFile) -> GivenFile:
    """Return a file with g as the unit of columns that are headed ``[G]`` or ``[grms]``: here that is no gauss."""
    own = given.recording
    channels = tuple(replace(one, unit="g") if one.unit is None and plain(in_brackets(one.name) or "") == "g" else one
                     for one in own.channels)  # fmt: skip
    found = replace(own, channels=channels)
    return replace(given, read=lambda: found)


def _names(given: GivenFile, name: str) -> Sequence[str]:
    said = given.own.get(name) or ()
    return [said] if isinstance(said, str) else list(said)


def _column(given: GivenFile, name: str) -> str:
    """Return the full name of a column."""
    found = full_name(given.recording.names, name)
    if found is None or found not in given.recording.names:
        do = f"It has: {', '.join(given.recording.names)}"
        raise UsageError(f"{given.name}: no column {name!r}", do=do, code="no_column")
    return found


def _axes(given: GivenFile, responses: Sequence[str], controls: Sequence[str]) -> dict[str, str]:
    """Return the columns of the sensor by axis: the responses as said, else those whose names say it."""
    channels = [one for one in given.recording.channels if one.name not in controls]
    if responses:
        channels = [given.recording.channel(name) for name in responses]
    else:
        of = given.said.sensor
        groups = [GROUP.get(of, of)] if of else ["acc", "gyro"]
        named = [one for one in channels if one.axis in AXES and one.quantity in ("acc", "gyro")]
        quantity = next((one for one in groups if any(c.quantity == one for c in named)), None)
        channels = [one for one in named if one.quantity == quantity]
        if not controls and not channels:
            channels = [one for one in given.recording.channels if one.unit and kind(one.unit) == ACCELERATION][:1]
    found: dict[str, str] = {}
    for one in channels[: len(AXES)]:
        free = [axis for axis in (one.axis, *AXES) if axis in AXES and axis not in found]
        found[free[0]] = one.name
    if len(channels) > len(AXES):
        what = f"{given.name}: {len(channels)} responses, a sensor has {len(AXES)} axes"
        raise UsageError(what, do="Name up to three", code="too_many")
    return found


def _alone(given: GivenFile, controls: Sequence[str]) -> dict[str, str]:
    """Return the first control channel as the axis of the sensor."""
    if not controls:
        have = ", ".join(given.recording.names)
        what = f"{given.name}: cannot tell which column is the control accelerometer; it has {have}"
        do = f"Add: {given.add('control', 'COLUMN')} {given.add('unit', 'COLUMN=UNIT')}"
        raise UsageError(what, do=do, code="no_column")
    axis = given.recording.channel(controls[0]).axis
    return {axis if axis in AXES else "x": controls[0]}


def _requirements(given: GivenFile) -> list[dict[str, Any]]:
    """Return what was asked as a campaign has it."""
    found = []
    for name, quantity in (("tolerance", DEVIATION), ("overall", LEVEL_DEVIATION)):
        limit = given.own.get(name)
        if limit is not None:
            found.append({"id": name, "quantity": quantity, "limit": str(limit)})
    return found


__all__ = ["described"]

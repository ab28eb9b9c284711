"""What a file of a sensor on a shaker is taken for: its axes, the control, the direction of vibration."""

from __future__ import annotations

from dataclasses import replace

from ...core.errors import UsageError
from ...core.key import AXES
from ...files.text.headers import bare_name
from ..given import Described, GivenFile
from ..given import described as described_channels
from ..protocol import InputSpec
from ..sine_survey.given import controls as named_controls

ROLES = ("control", "control_rms")


def described(given: GivenFile, spec: InputSpec) -> Described:
    """Return the channels of a file, with the axis that was vibrated along.

    Raises
    ------
    UsageError
        If there is no such axis, or no control.
    """
    axis = given.own.get("axis")
    if axis is not None and axis not in AXES:
        raise UsageError(f"axis {axis!r}", do=f"There are: {', '.join(AXES)}", code="unknown_name")
    own = {bare_name(one.name).lower(): one.name for one in given.recording.channels}
    columns = dict(given.said.columns)
    if control := given.own.get("control"):
        columns.setdefault(ROLES[0], str(control))
    if not any(name in columns for name in ROLES):
        columns |= {name: own[name] for name in ROLES if name in own}
    if not any(name in columns for name in ROLES) and (named := named_controls(given.recording)):
        columns[ROLES[0]] = named[0]
    found = described_channels(replace(given, said=replace(given.said, columns=columns)), spec)
    if not any(name in found.columns for name in ROLES):
        what = f"{given.name}: cannot tell which column is the acceleration of the control"
        do = f"Add: {given.add('control', 'COLUMN')}"
        raise UsageError(what, why="nothing else says how strong the vibration was", do=do, code="no_column")
    return replace(found, entry=found.entry | ({"axis": axis} if axis else {}))

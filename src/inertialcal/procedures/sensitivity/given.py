"""What a file is: channels by role, any other channel that ``--to`` names; whether conditions were stepped in it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from ...core.batches import thinned
from ...core.errors import UsageError
from ...core.estimate import Array
from ...core.key import AXES
from ...core.recording import Recording
from ...core.units import kind, normalise
from ...files.info.survey import Survey
from ...files.text.headers import full_name
from ..given import Described, GivenFile
from ..given import described as described_channels
from ..protocol import InputSpec
from ..suggestions import Strength, Suggestion
from .plan import APPLIED, PRESSURE, PUMP, REFERENCE, SUPPLY, WARM_UP
from .readings import stays

INPUTS = ("applied", "table")  # that the name of a column with the true input begins with
NO_UNIT = {PUMP: "1"}  # on or off
FOLLOWS = 0.9  # correlation of an axis with it
KINDS = {"voltage": SUPPLY, "pressure": PRESSURE}
LEVELS = (3, 200)  # that are steps: a pump-down has two, a ramp or a noise many
SHORTEST = 5  # samples of a level
ENOUGH = 2**22  # samples in which levels are looked for; of a longer record every so manieth
MOST = 0.8  # of the samples, that stand at levels


def split_label(given: str) -> tuple[str, str]:
    """Return the power-up that a caller names a file by, and the file: ``"A=level1.csv"``."""
    label, equals, path = given.partition("=")
    if not equals or not label or Path(given).exists() or "/" in label:
        return "", given
    return label.strip(), path


def described(given: GivenFile, spec: InputSpec) -> Described:
    """Return a recording of channels; conditions without a role by the column that has their name, or is given.

    Raises
    ------
    UsageError
        If that is not clear, or a unit is missing.
    """
    roles = {role.name for role in spec.roles}
    asked = given.plan.get("to") or [SUPPLY]
    names = [asked] if isinstance(asked, str) else [str(one) for one in asked]
    columns = dict(given.said.columns)
    others = {name: columns.pop(name, name) for name in names if name not in (*roles, WARM_UP)}
    if SUPPLY in names and SUPPLY not in columns:
        columns |= _only(given, SUPPLY)
    if REFERENCE in names and REFERENCE not in given.said.columns:
        others |= _only(given, REFERENCE)
    applied = _applied(given)
    columns |= {APPLIED: applied} if applied else {}
    others = {name: full_name(given.recording.names, column) or column for name, column in others.items()}
    # No other column is taken for the true input, nor one that was asked for by its name for the supply
    dropped = {*(() if applied else (APPLIED,)), *((SUPPLY,) if others and SUPPLY not in (*names, *columns) else ())}
    spec = replace(spec, roles=tuple(role for role in spec.roles if role.name not in dropped))
    found = described_channels(replace(given, said=replace(given.said, columns=columns)), spec)
    conditions = {}
    for name, column in others.items():
        if column not in given.recording.names:
            do = f"Add: {given.add('column', f'{name}=COLUMN')}; it has {', '.join(given.recording.names)}"
            raise UsageError(f"{given.name}: no column {column!r} for {name}", do=do, code="no_column")
        if column in {found.columns.get(axis) for axis in AXES}:
            what = f"{given.name}: {column!r} is what the sensor reads, and no condition"
            raise UsageError(what, do="Name another column", code="no_column")
        unit = given.recording.channel(column).unit or given.said.units.get(name) or NO_UNIT.get(name)
        if unit is None:
            do = f"Add: {given.add('unit', f'{column}=V')}"
            raise UsageError(f"{given.name}: unit missing: {column!r}", do=do, code="no_unit")
        conditions[name] = {"column": column, "unit": normalise(unit)}
    entry = found.entry | ({"conditions": conditions} if conditions else {})
    entry |= {"run": given.label} if given.label else {}
    entry |= {"axis": _turned(given, found, applied)} if applied else {}
    return replace(found, entry=entry, columns={**found.columns, **others})


def _only(given: GivenFile, stem: str) -> dict[str, str]:
    """Return the column whose name begins so, where there is one alone."""
    found = [one.name for one in given.recording.channels if one.name.lower().startswith(stem)]
    return {stem: found[0]} if len(found) == 1 else {}


def _applied(given: GivenFile) -> str | None:
    """Return the column of the true input: as said, else the one whose name begins so."""
    said = given.own.get(APPLIED) or given.said.columns.get(APPLIED)
    named = [one.name for one in given.recording.channels if one.name.lower().startswith(INPUTS)]
    return str(said) if said else named[0] if len(named) == 1 else None


def _turned(given: GivenFile, found: Described, applied: str) -> str:
    """Return the axis along the true input: as said, the only one, or the one that follows it.

    Raises
    ------
    UsageError
        ``no_axis`` where none clearly does.
    """
    axes = {axis: name for axis, name in found.columns.items() if axis in AXES}
    if (said := given.own.get("axis")) or len(axes) == 1:
        return str(said or next(iter(axes)))
    true = np.asarray(given.recording.channel(applied).data, dtype=float)
    following = []
    for axis, name in axes.items():
        values = np.asarray(given.recording.channel(name).data, dtype=float)
        use = np.isfinite(true) & np.isfinite(values)
        if use.any() and np.ptp(true[use]) > 0.0 and np.ptp(values[use]) > 0.0:
            following += [axis] if abs(float(np.corrcoef(true[use], values[use])[0, 1])) > FOLLOWS else []
    if len(following) != 1:
        what = f"{given.name}: cannot tell which axis is along {applied!r}"
        raise UsageError(what, do=f"Add: {given.add('axis', 'x')}", code="no_axis")
    return following[0]


def suggests(recording: Recording, survey: Survey) -> Suggestion | None:
    """Return ``sensitivity`` where sensors with a unit were read while a supply or a pressure was stepped."""
    if not any(one.axis and one.quantity in ("gyro", "acc") and one.unit not in (None, "count")
               for one in recording.channels):  # fmt: skip
        return None
    for one in recording.channels:
        name = KINDS.get(kind(one.unit) if one.unit else "")
        if name is None or one.axis:
            continue
        values = thinned(one.data, max(1, len(one.data) // ENOUGH)).astype(np.float64)
        if _stepped(values[np.isfinite(values)], decades=name == PRESSURE):
            return Suggestion(("sensitivity",), Strength.STEPPED, options=f"--to {name}")
    return None


def _stepped(values: Array, *, decades: bool) -> bool:
    """Tell whether values stand at levels; the noise of a gauge goes with its decades."""
    if not len(values):
        return False
    found = stays(np.log10(values) if decades and values.min() > 0.0 else values)
    long = found[found >= SHORTEST]
    return LEVELS[0] <= len(long) <= LEVELS[1] and int(long.sum()) >= MOST * len(values)


__all__ = ["described", "split_label", "suggests"]

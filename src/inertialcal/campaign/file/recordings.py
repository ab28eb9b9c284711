"""[recordings] of campaign.toml: reduced tables, recordings of channels, and how the unit was moved meanwhile.

What is said of every recording stands here; the keys of reduced tables, and of how the unit was moved, are those that
the procedures declare (`procedures.entries`).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any, Literal, cast, get_type_hints

from pydantic import Field, create_model, field_validator, model_validator

from ...core.key import AXES
from ...core.schema.quantities import Axis, Duration, Frequency, Name, Strict, Text, UnitOrNone
from ...core.times import read_instant
from ...core.units import divide, parse_quantity
from ...procedures import loaded_procedures
from ...procedures.entries import EntryKey
from ...procedures.protocol import Role


class Clock(Strict):
    """clock = {...}: which column is time, what a stamp means, which part of the recording is read."""

    column: Text | None = None
    stamp: Literal["start", "middle", "end"] = "middle"
    interval: Duration | None = None
    averaging: Duration | None = None
    sample_rate: Frequency | None = None
    start: str | None = None
    stop: str | None = None
    mission_start: str | None = None

    @field_validator("mission_start")
    @classmethod
    def _instant(cls, given: str | None) -> str | None:
        if given is not None:
            read_instant(given)
        return given

    @field_validator("start", "stop")
    @classmethod
    def _bound(cls, given: str | None) -> str | None:
        """Take an instant, elapsed time of a mission, or seconds on the clock of the file."""
        if given is not None and not _is_number(given):
            read_instant(given, mission_start=0)
        return given


def _is_number(text: str) -> bool:
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False


class TextLayout(Strict):
    """text = {...}: how a text is to be read, where the file does not say it."""

    decimal: Literal["comma", "point"] | None = None
    skip: Annotated[int, Field(ge=0)] | None = None
    dates: Literal["day-first", "month-first"] | None = None


class ChannelEntry(Strict):
    """NAME = { column, unit } in ``channels``; what a sample adds up to, and a scale factor, of a sensor at rest."""

    column: Text
    unit: UnitOrNone = ""
    quantity: Literal["increment", "angle"] | None = None
    scale_factor: str | None = None

    @model_validator(mode="after")
    def _scaled(self) -> ChannelEntry:
        if self.scale_factor is not None and not parse_quantity(self.scale_factor).value:
            raise ValueError(f"scale_factor = {self.scale_factor!r}: write output over input, like 131 count/(deg/s)")
        return self

    @property
    def reading_unit(self) -> str:
        """Unit of a sample over its scale factor; empty where nobody said."""
        if self.scale_factor is None:
            return self.unit
        return divide(self.unit or "count", parse_quantity(self.scale_factor).unit)


OF_CHAIN = ("reference", "temperature", "temperature_reference", "gain")  # channels that readings are made with
OF_AXES = ("reference", "temperature", "temperature_reference", "validity", "gain")  # the same, of one axis each


def _own_keys() -> dict[str, EntryKey]:
    """Return the keys that procedures declare, by name; the first that declares one has it."""
    found: dict[str, EntryKey] = {}
    for procedure in loaded_procedures():
        for key in procedure.entry_keys():
            found.setdefault(key.name, key)
    return found


def _roles() -> dict[str, Role]:
    """Return the channels that procedures read beside the axes, by name; those of one axis each too."""
    named = {role.name: role for procedure in loaded_procedures() for role in procedure.inputs.roles}
    by_axis = [role for role in named.values() if role.by_axis and role.name not in OF_CHAIN]
    return named | {f"{role.name}_{axis}": role for role in by_axis for axis in AXES}


OWN_KEYS, ROLES = _own_keys(), _roles()
TABLE_KEYS = tuple(name for name, key in OWN_KEYS.items() if key.table)


def _channel_names() -> str:
    added = [name for name in ROLES if name not in OF_CHAIN]
    return f"^({'|'.join([*added, *OF_CHAIN])}|(({'|'.join(OF_AXES)})_)?[xyz])$"


ChannelName = Annotated[str, Field(pattern=_channel_names())]
Step = Literal["bias", "scale_factor", "misalignment"]  # of a ground model


class CommonKeys(Strict):
    """What is said of every recording, whichever procedure reads it."""

    sensor: Name
    file: Text
    channels: dict[ChannelName, ChannelEntry] | None = None
    clock: Clock | None = None
    text: TextLayout | None = None
    frame: Literal["data", "sensor"] | None = None
    topics: list[Text] | None = None
    axis: Axis | None = None
    run: Text | None = None
    applied: list[Step] | None = None
    source: Text = ""


class _Checked(Strict):
    if TYPE_CHECKING:
        channels: object

    @model_validator(mode="after")
    def _one_kind(self) -> _Checked:
        if [getattr(self, name) for name in (*TABLE_KEYS, "channels")].count(None) != len(TABLE_KEYS):
            tables = f"{', '.join(TABLE_KEYS[:-1])} or {TABLE_KEYS[-1]}"
            raise ValueError(f"needs {tables} (a reduced table) or channels (a recording), one of them")
        extra = [name for name in _ONLY_WITH_CHANNELS if getattr(self, name) is not None]
        if self.channels is None and extra:
            raise ValueError(f"{', '.join(extra)}: only with channels; a reduced table names its columns")
        for name, key in OWN_KEYS.items():
            value = getattr(self, name)
            if key.wrong is not None and value is not None and (what := key.wrong(value)):
                raise ValueError(what)
        return self


_MOVED = [name for name in OWN_KEYS if name not in TABLE_KEYS]
_ONLY_WITH_CHANNELS = ("clock", "frame", *_MOVED, "axis", "run", "applied")
_ORDER = (
    "sensor",
    "file",
    *TABLE_KEYS,
    "channels",
    "clock",
    "text",
    "frame",
    "topics",
    *_MOVED,
    "axis",
    "run",
    "applied",
    "source",
)


def _recording_entry() -> type[CommonKeys]:
    """Return the schema of an entry: the common keys, and those of all procedures."""
    fields: dict[str, Any] = {name: (cast("Any", key.kind) | None, None) for name, key in OWN_KEYS.items()}
    hints = get_type_hints(CommonKeys, include_extras=True)  # with their limits, for whoever walks the schema
    common = CommonKeys.model_fields
    fields |= {name: (hints[name], ... if one.is_required() else one.default) for name, one in common.items()}
    described = "[recordings.NAME]: a reduced table or a recording of channels."
    made: Any = create_model(
        "RecordingEntry", __base__=_Checked, __doc__=described, **{name: fields[name] for name in _ORDER}
    )
    found: type[CommonKeys] = made
    return found


if TYPE_CHECKING:
    RecordingEntry = CommonKeys
else:
    RecordingEntry = _recording_entry()


def table_of(entry: CommonKeys) -> tuple[EntryKey, object] | None:
    """Return which key of an entry says the columns of a reduced table, and what it says; None for a recording."""
    return next(((OWN_KEYS[name], said) for name in TABLE_KEYS if (said := getattr(entry, name)) is not None), None)


def own_keys(entry: CommonKeys) -> list[tuple[EntryKey, object]]:
    """Return the keys of procedures that an entry has, and what they say."""
    return [(key, said) for name, key in OWN_KEYS.items() if (said := getattr(entry, name)) is not None]

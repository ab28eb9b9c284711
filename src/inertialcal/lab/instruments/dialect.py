"""Dialect: what an instrument says and what is said to it, as data in a TOML file.

A dialect describes the rows that come (lines of text, packets of bytes, or answers to questions), the commands that
identify, start, stop and make safe, and the quantities that can be set. A number in a command stands as ``{value}``,
with a format behind a colon, ``{value:.4f}``; any other name in braces is a parameter that LAB.toml gives.

Dialects that are built in stand in ``lab/dialects``, each with its source.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from importlib import resources
from pathlib import PurePath
from typing import Annotated, Literal

from pydantic import Field, model_validator
from pydantic import Strict as Strictly

from ...core.errors import DataError
from ...core.schema.quantities import Duration, Strict, Text, UnitOrNone
from ...core.units import parse_quantity, same_dimension
from ...files.loggers.rows import RowChannel, RowLayout

Type = Literal[
    "int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64", "float32", "float64", "pad"
]  # fmt: skip
Checksum = Literal["none", "xor8", "sum8", "crc16_ccitt", "crc16_modbus", "crc32"]
SUM_BYTES: Mapping[str, int] = {"none": 0, "xor8": 1, "sum8": 1, "crc16_ccitt": 2, "crc16_modbus": 2, "crc32": 4}
ChannelName = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]*$", max_length=64)]
PLACE = re.compile(r"\{(\w+)(?::([.0-9]*[dfeg]))?\}")
Texts = Annotated[tuple[Text, ...], Strictly(False)]
NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
MOST_CHANNELS = 256


class FieldEntry(Strict):
    """A number of a row."""

    name: ChannelName = "pad"
    type: Type = "float64"
    bytes: int = Field(default=1, ge=1, le=4096)  # of a pad
    unit: UnitOrNone = ""
    scale: float = Field(default=1.0, allow_inf_nan=False)
    offset: float = Field(default=0.0, allow_inf_nan=False)
    axis: Literal["", "x", "y", "z"] = ""
    role: Literal["reading", "time", "counter"] = "reading"
    ask: Text = ""  # of answers: the question


class FrameEntry(Strict):
    """How rows are told apart."""

    kind: Literal["lines", "packets", "answers"]
    separator: Annotated[str, Field(min_length=1, max_length=4)] = ","  # of a line; a blank: any number of blanks
    prefix: Annotated[str, Field(max_length=64)] = ""  # that a line begins with; others are passed over
    comment: Annotated[str, Field(max_length=4)] = "#"
    sync: Annotated[str, Field(pattern=r"^([0-9A-Fa-f]{2}\s?){1,8}$")] = "AA"  # bytes that a packet begins with
    byte_order: Literal["little", "big"] = "little"
    checksum: Checksum = "none"  # of a line: in hexadecimal behind a ``*``, over what stands between prefix mark and it
    checksum_over: Literal["all", "after_sync"] = "after_sync"
    every: Duration = 1.0  # of answers: how often is asked [s]


class CommandsEntry(Strict):
    """What is sent; each list in order."""

    identify: Text = ""
    start: Texts = ()
    stop: Texts = ()
    safe: Texts = ()


class SettingEntry(Strict):
    """A quantity that can be set."""

    unit: UnitOrNone
    set: Annotated[Texts, Field(min_length=1)]
    read: Text = ""
    limit: Texts = ()  # tells the instrument its own limits: ``{low}``, ``{high}``, ``{largest}``


class InterlockEntry(Strict):
    """A question whose answer says whether anything may move."""

    ask: Text
    closed: Text  # what the answer is then, as a regular expression


class Dialect(Strict):
    """All of it."""

    title: Text = ""
    source: Text = ""  # where it is described
    terminator: Annotated[str, Field(min_length=1, max_length=4)] = "\n"
    pause: Duration = 0.0  # after each command [s]
    timeout: Duration = 2.0  # for an answer [s]
    answer: Text = NUMBER  # how a number is found in an answer, as a regular expression; the last match is taken
    error: Text = r"(?i)\berr(or)?\b|fault"  # what an answer says that is a refusal, as a regular expression
    frame: FrameEntry | None = None
    fields: Annotated[tuple[FieldEntry, ...], Strictly(False), Field(max_length=MOST_CHANNELS)] = ()
    commands: CommandsEntry = CommandsEntry()
    settings: dict[ChannelName, SettingEntry] = Field(default_factory=dict)
    interlock: InterlockEntry | None = None

    @model_validator(mode="after")
    def _fits(self) -> Dialect:
        """Refuse what contradicts itself."""
        wrong = next((what for holds, what in (*self._rules_of_rows(), *self._rules_of_words()) if not holds), "")
        if wrong:
            raise ValueError(wrong)
        return self

    def _rules_of_rows(self) -> Iterator[tuple[bool, str]]:
        """Yield whether rules on rows hold, and what is wrong where one does not."""
        rows = [one for one in self.fields if one.type != "pad"]
        kind = self.frame.kind if self.frame is not None else ""
        yield (bool(kind) == bool(rows)), "frame and fields belong together: rows need both"
        yield all("name" in one.model_fields_set for one in rows), "each field but a pad needs its name"
        yield len({one.name for one in rows}) == len(rows), "a name stands twice in fields"
        for role in ("time", "counter"):
            yield sum(one.role == role for one in rows) < 2, f"more than one field has the role {role}"
        counters = [one.type for one in rows if one.role == "counter"]
        yield not any(one.startswith("float") for one in counters), "a counter is a whole number: give it such a type"
        yield all(one.unit for one in rows if one.role == "time"), "the time of an instrument needs its unit"
        yield kind == "packets" or len(rows) == len(self.fields), "only packets have pads"
        yield kind != "answers" or all(one.ask for one in rows), "each field of answers needs its question: ask"

    def _rules_of_words(self) -> Iterator[tuple[bool, str]]:
        """Yield whether rules on what is said hold, and what is wrong where one does not."""
        asked = self.interlock is not None or any(one.read for one in self.settings.values())
        streams = self.frame is not None and self.frame.kind != "answers"
        yield (
            not (streams and asked),
            ("what sends rows by itself cannot be asked: leave out interlock and settings.*.read"),
        )
        for pattern in (self.answer, self.error, *([self.interlock.closed] if self.interlock else [])):
            yield _is_pattern(pattern), f"{pattern!r} is not a regular expression"
        yield not self.settings or bool(self.commands.safe), "what can be set needs a safe state: commands.safe"

    @property
    def layout(self) -> RowLayout | None:
        """Channels of its rows."""
        if self.frame is None:
            return None
        return RowLayout(
            tuple(
                RowChannel(one.name, one.type, one.unit, one.scale, one.offset, one.axis, one.role)
                for one in self.fields
                if one.type != "pad"
            )
        )

    @property
    def sync(self) -> bytes:
        """Bytes that a packet begins with."""
        return bytes.fromhex(self.frame.sync) if self.frame is not None else b""

    @property
    def parameters(self) -> frozenset[str]:
        """Names in braces that LAB.toml has to give."""
        texts = [*self.commands.start, *self.commands.stop, *self.commands.safe, self.commands.identify]
        for one in self.settings.values():
            texts += [*one.set, *one.limit, one.read]
        texts += [one.ask for one in self.fields]
        texts += [self.interlock.ask] if self.interlock else []
        return frozenset(match[1] for text in texts for match in PLACE.finditer(text)) - {
            "value",
            "low",
            "high",
            "largest",
        }


def _is_pattern(text: str) -> bool:
    try:
        re.compile(text)
    except re.error:
        return False
    return True


def filled(text: str, parameters: Mapping[str, str | float]) -> str:
    """Return a command with its numbers and parameters in place."""

    def put(match: re.Match[str]) -> str:
        value = parameters[match[1]]
        return format(value, match[2]) if match[2] else repr(value) if isinstance(value, float) else value

    return PLACE.sub(put, text)


def built_in() -> tuple[str, ...]:
    """Return the names of the dialects that are built in."""
    folder = resources.files(__package__.rpartition(".")[0]) / "dialects"
    files = [PurePath(str(one)) for one in folder.iterdir()]
    return tuple(sorted(one.stem for one in files if one.suffix == ".toml"))


def built_in_text(name: str) -> bytes:
    """Return the text of a dialect that is built in."""
    return (resources.files(__package__.rpartition(".")[0]) / "dialects" / f"{name}.toml").read_bytes()


def value_in(text: str, unit: str, difference: bool = False) -> float:
    """Return a quantity in the unit of a setting or a channel; as it stands where that has none.

    Raises
    ------
    DataError
        If it is none, or of another kind.
    """
    read = parse_quantity(text)
    if not unit:
        return read.to(read.unit)
    if not same_dimension(read.unit, unit):
        raise DataError(f"{text!r} is not in a unit like {unit}", do=f'Write it like "1 {unit}"', code="wrong_value")
    return read.to(unit, difference=difference)

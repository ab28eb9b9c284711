"""LAB.toml: which instruments, on which links, in which dialects, within which limits, and what they are told in turn.

::

    schema = 1

    [lab]
    title = "gyro suite on the rate table"

    [instruments.imu]
    link = "serial"
    address = "/dev/ttyUSB0"
    dialect = "imu.toml"
    interval = "2 s"

    [instruments.table]
    link = "visa"
    address = "GPIB0::1::INSTR"
    dialect = "acutrol"
    parameters = { axis = "1" }
    limits = { rate = ["-100 deg/s", "100 deg/s"] }

    [[steps]]
    set = { "table.rate" = "10 deg/s" }
    hold = "60 s"
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, ValidationError
from pydantic import Strict as Strictly

from ...core.errors import DataError, InertialcalError, PlanError, Problem, UsageError
from ...core.schema.problems import model_problems
from ...core.schema.quantities import Duration, Name, Relative, Strict, Text
from ...core.schema.toml import At, key_lines, nearest_line, parse_toml
from ...files.budget import parse_size
from ...files.source import read_bytes
from ..clock import Clock
from ..instruments.device import Device
from ..instruments.dialect import Dialect, built_in, built_in_text, value_in
from ..instruments.links import LINKS
from ..instruments.links.link import LinkEntry, LinkKind
from ..instruments.protocol import Say
from ..sequence.campaign_entries import campaign_problems
from ..sequence.entries import SequenceEntry
from ..sequence.steps import SequenceStep, read_steps

MOST = 100  # problems that are listed
DIALECT_ENDING = ".toml"
OF_LINKS = frozenset(LinkEntry.model_fields)


class LabEntry(Strict):
    """What holds for all."""

    title: Text = ""
    operator: Text = ""
    sync: Annotated[Duration, Field(gt=0.0, le=60.0)] = 0.5  # from one writing to the disk to the next [s]
    duration: Duration | None = None  # None: until it is interrupted, or the last step is done [s]
    keep_free: Text = "200 MB"  # of the disk: before less is free, it ends
    warn_before: Duration = 3600.0  # that the disk will be full [s]
    speed: Annotated[int, Field(ge=1, le=1_000_000)] = 1  # of the clock, for rehearsals


class InstrumentEntry(LinkEntry):
    """An instrument."""

    link: Text
    dialect: Text = ""
    interval: Annotated[Duration, Field(gt=0.0)] | None = None  # from row to row [s]
    clock_within: Annotated[Relative, Field(gt=0.0, le=0.5)] | None = (
        None  # what its clock, or the interval, may be off
    )
    parameters: dict[Name, Text] = Field(default_factory=dict)
    limits: dict[Name, Annotated[list[Text], Field(min_length=2, max_length=2)]] = Field(default_factory=dict)


class StepEntry(Strict):
    """What is set, and how long it is held."""

    name: Text = ""
    set: dict[Text, Text] = Field(default_factory=dict)
    hold: Duration = 0.0  # [s]


class LabFile(Strict):
    """All of it."""

    version: Literal[1] = Field(alias="schema")
    lab: LabEntry = LabEntry()
    instruments: Annotated[dict[Name, InstrumentEntry], Field(min_length=1, max_length=64)]
    steps: Annotated[tuple[StepEntry, ...], Strictly(False), Field(max_length=10_000)] = ()
    sequence: SequenceEntry | None = None


@dataclass(frozen=True)
class Step:
    """What is set, in the unit of each setting, and how long it is held."""

    name: str
    values: tuple[tuple[str, str, float], ...]  # Instrument, quantity, value
    hold: float  # [s]


@dataclass(frozen=True)
class Lab:
    """A LAB.toml that was read and judged."""

    file: LabFile
    folder: Path  # In which files that it names stand
    text: str
    sha256: str
    keep_free: int  # [byte]
    dialects: dict[str, Dialect]  # By instrument
    dialect_texts: dict[str, str]  # By instrument, of those that stand in a file
    limits: dict[str, dict[str, tuple[float, float]]]  # By instrument and quantity, in the unit of the setting
    steps: tuple[Step, ...]
    sequence: tuple[SequenceStep, ...]  # Of ``inertialcal sequence``
    place: At  # Of a key path in LAB.toml, for messages

    def clock(self) -> Clock:
        """Return the clock of an acquisition."""
        return Clock(self.file.lab.speed)

    def devices(self, clock: Clock, say: Say) -> list[Device]:
        """Return its instruments, not yet connected.

        Raises
        ------
        InertialcalError
            Where what one replays cannot be read.
        """
        return [
            Device(name, LINKS[one.link].make(one, self.folder, clock), self.dialects[name], clock, say,
                   self.limits[name], one.parameters)
            for name, one in self.file.instruments.items()
        ]  # fmt: skip


def load_lab(path: str | Path) -> Lab:
    """Read LAB.toml.

    Raises
    ------
    PlanError
        With every problem, each with its line: what is not TOML, unknown keys, wrong values, links and dialects that
        are not there, limits and steps that do not fit.
    """
    path = Path(path)
    try:
        raw = read_bytes(path)
    except DataError as error:
        raise PlanError(list(error.problems)) from None
    return lab_of(raw, path.name, path.parent)


def lab_of(raw: bytes, name: str, folder: Path) -> Lab:
    """Return what the bytes of a LAB.toml say; files that it names stand in the folder. Raises as `load_lab`."""
    text, document = parse_toml(raw, name)
    at = _places(name, text)
    try:
        file = LabFile.model_validate(document)
    except ValidationError as error:
        raise PlanError(list(islice(model_problems(error, LabFile, document, at), MOST))) from None
    reading = _Reading(file, folder, at)
    problems = list(islice(reading.problems(), MOST))
    if problems:
        raise PlanError(problems)
    return Lab(
        file, folder, text, hashlib.sha256(raw).hexdigest(), parse_size(file.lab.keep_free), reading.dialects,
        reading.texts, reading.limits, tuple(reading.steps), tuple(reading.sequence), at,
    )  # fmt: skip


def _places(name: str, text: str) -> At:
    lines = key_lines(text)

    def at(*path: str | int) -> str:
        line = nearest_line(lines, path)
        return f"{name}:{line}" if line else name

    return at


class _Reading:
    """What is looked up and converted while problems are looked for."""

    def __init__(self, file: LabFile, folder: Path, at: At) -> None:
        self.file, self.folder, self.at = file, folder, at
        self.dialects: dict[str, Dialect] = {}
        self.texts: dict[str, str] = {}
        self.limits: dict[str, dict[str, tuple[float, float]]] = {}
        self.steps: list[Step] = []
        self.sequence: list[SequenceStep] = []

    def problems(self) -> Iterator[Problem]:
        """Yield what is wrong, and keep what is right."""
        try:
            parse_size(self.file.lab.keep_free)
        except UsageError:
            what = f"lab.keep_free: {self.file.lab.keep_free!r} is not a size"
            yield Problem(what, self.at("lab", "keep_free"), do='Write it like "200 MB"', code="wrong_value")
        for name, one in self.file.instruments.items():
            where = ("instruments", name)
            if one.link not in LINKS:
                do = f"There are: {', '.join(LINKS)}"
                yield Problem(f"no link {one.link!r}", self.at(*where, "link"), do=do, code="unknown_name")
                continue
            kind = LINKS[one.link]
            yield from self._link_problems(name, one, kind)
            yield from self._dialect_problems(name, one, kind)
        if self.dialects.keys() == self.file.instruments.keys():
            for name, one in self.file.instruments.items():
                yield from self._limit_problems(name, one)
            for number, step in enumerate(self.file.steps):
                values, problems = self._values(step.set, f"steps.{number}", ("steps", number, "set"))
                yield from problems
                self.steps.append(Step(step.name or f"step {number + 1}", values, step.hold))
            if self.file.sequence is not None:
                found = read_steps(self.file.sequence, self.folder, self.dialects, self._values, self.at)
                self.sequence, problems = found
                yield from problems
                yield from self._sequence_problems(self.file.sequence)

    def _link_problems(self, name: str, one: InstrumentEntry, kind: LinkKind) -> Iterator[Problem]:
        where = ("instruments", name)
        for key in sorted(one.model_fields_set & OF_LINKS - set(kind.takes)):
            do = f"It takes: {', '.join(kind.takes)}"
            what = f"link {kind.name} takes no {key}"
            yield Problem(what, self.at(*where, key), "it would have no effect", do, "unknown_key")
        for key in kind.takes[: kind.needs]:
            if not getattr(one, key):
                what = f"instruments.{name}: link {kind.name} needs {key}"
                yield Problem(what, self.at(*where), do=f'Add: {key} = "..."', code="missing_key")
        if self.file.lab.speed != 1 and not kind.paced:
            what = f"lab.speed = {self.file.lab.speed}: instrument {name} has a clock of its own"
            do = "Leave speed out: only replays and rigs can be faster than time"
            yield Problem(what, self.at("lab", "speed"), do=do, code="wrong_value")
        if kind.name in ("tcp", "udp"):
            host, colon, port = one.address.rpartition(":")
            if one.address and not (host and colon and port.isdecimal() and int(port) < 2**16):
                what, do = f"address {one.address!r} is not HOST:PORT", 'Write it like "192.168.1.5:5025"'
                yield Problem(what, self.at(*where, "address"), do=do, code="wrong_value")

    def _dialect_problems(self, name: str, one: InstrumentEntry, kind: LinkKind) -> Iterator[Problem]:
        where = ("instruments", name)
        if kind.dialect is not None:
            if one.dialect:
                why = "a recording brings its own"
                yield Problem(f"link {kind.name} takes no dialect", self.at(*where, "dialect"), why, code="unknown_key")
                return
            try:
                self.dialects[name] = kind.dialect(one, self.folder)
            except InertialcalError as error:
                yield from (Problem(p.what, self.at(*where), p.why, p.do, p.code) for p in error.problems)
            return
        if not one.dialect:
            do = f'Add: dialect = "NAME", one of {", ".join(built_in())} or a file that ends in {DIALECT_ENDING}'
            yield Problem(f"instruments.{name}: a dialect is missing", self.at(*where), do=do, code="missing_key")
            return
        try:
            self.dialects[name] = self._dialect(name, one.dialect)
        except InertialcalError as error:
            here = self.at(*where, "dialect")
            yield from (Problem(p.what, p.where or here, p.why, p.do, p.code) for p in error.problems)
            return
        missing = self.dialects[name].parameters - one.parameters.keys()
        for key in sorted(missing):
            what = f"instruments.{name}: dialect {one.dialect} needs the parameter {key}"
            yield Problem(what, self.at(*where), do=f'Add: parameters = {{ {key} = "..." }}', code="missing_key")

    def _dialect(self, name: str, said: str) -> Dialect:
        if not said.endswith(DIALECT_ENDING):
            if said not in built_in():
                do = f"There are: {', '.join(built_in())}; a file ends in {DIALECT_ENDING}"
                raise PlanError(f"no dialect {said!r}", do=do, code="unknown_name")
            raw = built_in_text(said)
        else:
            try:
                raw = read_bytes(self.folder / said)
            except DataError as error:
                own = error.problems[0]
                raise PlanError(f"dialect {said}: {own.what}", do=own.do, code=own.code) from None
        text, document = parse_toml(raw, said)
        self.texts[name] = text
        try:
            return Dialect.model_validate(document)
        except ValidationError as error:
            raise PlanError(list(islice(model_problems(error, Dialect, document, _places(said, text)), MOST))) from None

    def _limit_problems(self, name: str, one: InstrumentEntry) -> Iterator[Problem]:
        settings = self.dialects[name].settings
        self.limits[name] = {}
        for quantity, (low, high) in one.limits.items():
            where = self.at("instruments", name, "limits", quantity)
            if quantity not in settings:
                what = f"instruments.{name}.limits.{quantity}: nothing of that name can be set"
                yield Problem(what, where, do=f"There are: {', '.join(settings) or 'none'}", code="unknown_key")
                continue
            try:
                ends = (value_in(low, settings[quantity].unit), value_in(high, settings[quantity].unit))
            except DataError as error:
                what = f"instruments.{name}.limits.{quantity}: {error.problems[0].what}"
                yield Problem(what, where, do=error.problems[0].do, code="wrong_value")
                continue
            if not ends[0] < ends[1]:
                what = f"instruments.{name}.limits.{quantity}: {low} is not below {high}"
                yield Problem(what, where, do="Write the lower one first", code="wrong_value")
            self.limits[name][quantity] = ends

    def _sequence_problems(self, entry: SequenceEntry) -> Iterator[Problem]:
        """Yield what does not go with a sequence."""
        if self.file.steps:
            do = "Write them as [[sequence.steps]]"
            yield Problem("[[steps]] beside [sequence]: one of them would not be done", self.at("steps"), do=do,
                          code="unknown_key")  # fmt: skip
        if self.file.lab.duration is not None:
            what, why = "lab.duration beside [sequence]", "it would cut the sequence off"
            yield Problem(what, self.at("lab", "duration"), why, "Leave it out", "unknown_key")
        if entry.campaign and self.sequence:
            place = self.at("sequence", "campaign")
            yield from campaign_problems(self.folder / entry.campaign, self.sequence, place)

    def _values(
        self, asked: Mapping[str, str], step: str, path: tuple[str | int, ...]
    ) -> tuple[tuple[tuple[str, str, float], ...], list[Problem]]:
        """Return what a step sets, in the unit of each setting, and what is wrong with it."""
        values: list[tuple[str, str, float]] = []
        problems: list[Problem] = []
        for target, said in asked.items():
            where = self.at(*path, target)
            name, _, quantity = target.partition(".")
            settings = self.dialects[name].settings if name in self.dialects else {}
            if quantity not in settings:
                can = [f"{one}.{each}" for one, dialect in self.dialects.items() for each in dialect.settings]
                do = f"There are: {', '.join(can) or 'none'}"
                problems.append(Problem(f"{step}: nothing is called {target}", where, do=do, code="unknown_name"))
                continue
            try:
                value = value_in(said, settings[quantity].unit)
            except DataError as error:
                what = f"{step}: {target}: {error.problems[0].what}"
                problems.append(Problem(what, where, do=error.problems[0].do, code="wrong_value"))
                continue
            limits, unit = self.limits[name].get(quantity), settings[quantity].unit
            if limits is None:
                do = f'Add to instruments.{name}: limits = {{ {quantity} = ["LOW {unit}", "HIGH {unit}"] }}'
                what, why = f"{step}: no limits for {target}", "nothing moves without stated limits"
                problems.append(Problem(what, where, why, do, "missing_key"))
            elif not limits[0] <= value <= limits[1]:
                allowed = f"{limits[0]:g} to {limits[1]:g} {unit}"
                what = f"{step}: {target} = {said}: beyond the limits, {allowed}"
                problems.append(Problem(what, where, do="Change the step, or the limits", code="beyond_limits"))
            values.append((name, quantity, value))
        return tuple(values), problems

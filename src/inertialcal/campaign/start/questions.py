"""What a first campaign.toml cannot be told by the files: one question after the other, each with what was seen.

A question that an option or an earlier answer has settled is not asked. Numbers of a data sheet are asked for, never
suggested: Enter leaves them to be filled in.
"""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from ...core.errors import InertialcalError
from ...core.key import AXES, Kind
from ...core.recording import Channel, Recording
from ...core.units import kind, normalise
from ...files.info.channel_survey import unit_hints
from ...files.time.dates import ORDERS
from ...procedures import procedure_of
from ...procedures.given import GROUP, RAW, Said, bare
from ...procedures.suggestions import Question, one_of, quantity
from .folder import FolderContents
from .settled import OF_TABLE, plain_table

ITEM = {"maker": "Who made the sensor", "part": "Its part number", "serial": "Its serial number"}
UNITS = {"gyro": "deg/s, rad/s, count, V", "acc": "g, m/s2, count, V"}
PER = {"gyro": "(deg/s)", "acc": "g"}
NOMINAL = {"gyro": {"V": "0.02", "count": "131"}, "acc": {"V": "0.5", "count": "16384"}}  # examples


Answers = Mapping[str, str]
Contents = Mapping[str, Mapping[str, object]]  # what procedures make of files, by procedure and file


def questions(contents: FolderContents, said: Said, axis: str | None, item: Answers) -> Iterator[Question]:
    """Yield what is to be asked, as far as answers and options leave it open.

    Parameters
    ----------
    contents : FolderContents
        What a folder holds.
    said : Said
        Options and answers so far.
    axis, item
        Axis that was turned, and what the sensor is, as far as they were said.
    """
    if contents.ambiguous and said.dates is None:
        what = f"{', '.join(contents.ambiguous)}: dates like 3/4/2024"
        yield Question("dates", what, f"Day or month first? ({' or '.join(ORDERS)})", wrong=one_of(ORDERS))
    yield from _of_topics(contents, said)
    for group in ("gyro", "acc"):
        yield from _of_readings(contents, group, said)
    for procedure, own in contents.found.items():
        for question in procedure_of(procedure).asks(own) if own else ():
            known: Any = axis if question.name == "axis" else getattr(said, question.name, None)
            if question.group:
                known = known.get(question.group, bare(known))
            if known is None:
                yield question
    for name, ask in ITEM.items():
        if name not in item:
            yield Question(name, "", f"{ask}? (Enter: leave it out)")


def _of_topics(contents: FolderContents, said: Said) -> Iterator[Question]:
    """Yield the question which of several sensors of a kind is meant, of each file."""
    for file, sets in contents.choices.items():
        names = tuple(name for one in sets for name in one)
        if not set(names) & set(said.topics):
            what = f"{file}: sensors of a kind, recorded at the same time: {'; '.join(map(shlex.join, sets))}"
            ask = "Which? (in quotes, where a name has blanks)"
            yield Question("topics", what, ask, shlex.join(sets[0]), wrong=_topics(names))


def _of_readings(contents: FolderContents, group: str, said: Said) -> Iterator[Question]:
    """Yield the questions on the unit of a kind of sensors, and on the chain of those in counts or volts."""
    own = [*_channels(contents.found, group), *_columns(contents, group)]
    if not own:
        return
    unsaid = [(file, one) for file, one in own if one.unit is None]
    answer = said.units.get(group) or bare(said.units)
    if unsaid and not answer:
        if group in said.units:  # left to be filled in
            return
        hints = [hint for file in dict.fromkeys(file for file, _ in unsaid)
                 for hint in _hints([one for of, one in unsaid if of == file])]  # fmt: skip
        names = ", ".join(dict.fromkeys(one.name for _, one in unsaid))
        reason = f": {hints[0][1]}" if hints else ""
        seen = f"{', '.join(dict.fromkeys(file for file, _ in unsaid))}: {names} without a unit{reason}"
        suggestion = hints[0][0] if hints else ""
        yield Question("units", seen, f"Unit? ({UNITS[group]}, ...)", suggestion, group, _unit)
        return  # what follows depends on it
    units = {answer if one.unit is None else one.unit for _, one in own}
    raw = [normalise(unit) for unit in units if unit and kind(unit) in RAW]
    if not raw or said.chain is not None:
        return
    counted, per = any(kind(unit) == "count" for unit in raw), PER[group]
    seen = f"{', '.join(dict.fromkeys(file for file, _ in own))}: readings in {' and '.join(sorted(raw))}"
    if counted and said.lsb is None:
        ask = "Voltage of one count of the converter, like 5 V / 4095? (Enter: none, the sensor gives numbers itself)"
        yield Question("lsb", seen, ask, wrong=quantity("V", optional=True))
    volts = not counted or bool(said.lsb)
    if volts and not _answered(said.reference, group):
        ask = "Voltage without input, like 2.5 V, or x=2.5 V, y=2.4 V, z=2.6 V? (channel: it was recorded)"
        wrong = _of_each(quantity("V", optional=True, words=("channel",)))
        yield Question("reference", seen, ask, group=group, wrong=wrong)
    if not _answered(said.scale_factor, group):
        output = "V" if volts else "count"
        unit = f"{output}/{per}"
        ask = f"Scale factor of the data sheet, like {NOMINAL[group][output]} {unit}, or x=..., y=..., z=...?"
        yield Question("scale_factor", seen, ask, group=group, wrong=_of_each(quantity(unit, optional=True)))


def answered(said: Said, question: Question, text: str) -> Said:
    """Return what was said with one more answer; an empty one counts as said."""
    if question.name == "topics":
        return replace(said, topics=[*said.topics, *shlex.split(text)])
    answer: Any = {**getattr(said, question.name), **_by_axis(text, question.group)} if question.group else text
    return replace(said, **{question.name: answer})


def _topics(known: Sequence[str]) -> Callable[[str], str]:
    """Return what is wrong with text that names other topics than these."""

    def wrong(text: str) -> str:
        try:
            named = shlex.split(text)
        except ValueError as error:
            return str(error)
        other = [one for one in named if one not in known]
        return f"no topic {other[0]!r}: {shlex.join(known)}" if other else ""

    return wrong


def _by_axis(text: str, group: str) -> dict[str, str]:
    """Return an answer by what it holds for: each axis, ``x=2.5 V, y=2.4 V``, or the group."""
    parts = [part.partition("=") for part in text.split(",")]
    by_axis = {axis.strip(): value.strip() for axis, _, value in parts}
    return by_axis if by_axis.keys() <= set(AXES) and len(by_axis) == len(parts) else {group: text}


def _of_each(wrong: Callable[[str], str]) -> Callable[[str], str]:
    """Return what is wrong with an answer for all axes, or for each."""
    return lambda text: next(filter(None, map(wrong, _by_axis(text, "").values())), "")


def _answered(values: Mapping[str, str], group: str) -> bool:
    return group in values or bare(values) is not None or any(axis in values for axis in AXES)


def _channels(found: Contents, group: str) -> Iterator[tuple[str, Channel]]:
    """Yield the readings of a kind of sensors, with their file."""
    for files in found.values():
        for file, one in files.items():
            if isinstance(one, Recording):
                yield from ((file, channel) for channel in one.channels if channel.quantity == group and channel.axis)


def _columns(contents: FolderContents, group: str) -> Iterator[tuple[str, Channel]]:
    """Yield the readings of a kind of sensors in tables of means, with their file."""
    for procedure, files in contents.found.items():
        tables = {file: one for file, one in files.items() if file in contents.tables}
        for entry, sensor, columns in _entries(procedure, tables):
            unit = str(columns["unit"])
            reading = columns["reading"]
            names = reading.items() if isinstance(reading, Mapping) else [("", str(reading))]
            for axis, name in names if GROUP[sensor] == group else ():
                data = contents.tables[entry].numbers(name, required=False)
                yield entry, Channel(name, data, None if unit == "?" else unit, "", axis, group)


def _entries(procedure: str, tables: Mapping[str, object]) -> Iterator[tuple[str, Kind, dict[str, Any]]]:
    """Yield what a draft says of tables: file, kind of sensor, columns; none where the procedure asks for itself."""
    if not tables:
        return
    own = procedure_of(procedure)
    if any(one.name == "units" for one in own.asks(tables)):
        return
    draft = own.draft(tables)
    for entry in map(plain_table, draft.recordings.values()):
        word = plain_table(draft.sensors[entry["sensor"]])["kind"]
        for name in OF_TABLE:
            if name in entry:
                yield str(entry["file"]), getattr(word, "value", word), plain_table(entry[name])


def _hints(channels: Sequence[Channel]) -> list[tuple[str, str]]:
    """Return units that the readings of a file suggest, each with why: gravity shows in all axes together."""
    each = {one.name: one for one in channels}.values()  # as often as procedures take the file
    part = Recording(tuple(each), None, None, None, "elapsed", "")
    return [(hint.unit, hint.reason) for hint in unit_hints(part) if hint.unit]


def _unit(text: str) -> str:
    try:
        normalise(text)
    except InertialcalError as error:
        return error.problems[0].what
    return ""

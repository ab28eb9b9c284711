"""What was said of a folder, put into the draft of its campaign: units, chain, axis, site, item."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from ...core.campaign_text import FILL_IN, Noted
from ...core.key import AXES, Kind
from ...core.units import kind, normalise
from ...procedures.given import GROUP, RAW, GivenFile, Said, bare, chain_of_units, chain_said, raw_units, spoken_unit
from ...procedures.suggestions import fill_in
from ..calls.given import text_said
from .folder import Part

OF_TABLE = ("rows", "rests")  # columns of a table of means, with one unit
OPEN = {"", "?"}  # texts that say nothing
Parts = dict[str, dict[str, object]]


def settle(parts: Parts, tests: Sequence[object], said: Said, axis: str, of_files: Mapping[str, Part]) -> None:
    """Put what was said into sensors, recordings, tests and site of a draft; what is then complete is not marked.

    ``of_files``: topics of files, by the label that the draft has in place of the file.

    Raises
    ------
    UsageError
        ``option_without_effect`` for a chain where every reading is in a unit of input.
    """
    recordings = parts["recordings"]
    every: list[str] = []
    for name, table in parts["sensors"].items():
        sensor = plain_table(table)
        word = sensor["kind"]
        sensor_kind: Kind = getattr(word, "value", word)
        own = {key: entry for key, entry in recordings.items() if plain_table(entry)["sensor"] == name}
        stated = said.units.get(GROUP[sensor_kind]) or bare(said.units)
        settled = {key: _with_unit(entry, None if stated is None else normalise(stated)) for key, entry in own.items()}
        recordings |= settled
        units = [unit for entry in settled.values() for unit in _units(entry)]
        every += units
        found = _with_chain(sensor, sensor_kind, units, said)
        parts["sensors"][name] = Noted(found, table.note, table.above) if isinstance(table, Noted) else found
    if every and not any(unit in OPEN or kind(unit) in RAW for unit in every):
        files = ", ".join(str(plain_table(entry)["file"]) for entry in recordings.values())
        given = GivenFile(files, said, {}, {}, _never, _never)
        chain_of_units(given, chain_said(given), every)
    reading = _reading(said)
    for key, entry in recordings.items():
        recordings[key] = _read_as(_of_file(entry, of_files), reading)
    _turn(recordings, tests, axis)
    site = {"latitude": said.latitude, "gravity": said.gravity, "height": said.height}
    parts["site"] |= {name: value for name, value in site.items() if value is not None}


def _with_chain(sensor: dict[str, Any], sensor_kind: Kind, units: Sequence[str], said: Said) -> dict[str, Any]:
    """Return a sensor with readings in counts or volts with its chain: as said, else to be filled in.

    Recordings of it in units of input go beside it: what they are in is that of the chain's readings.
    """
    known = [unit for unit in units if unit not in OPEN]
    raw = [unit for unit in known if kind(unit) in RAW]
    plain = [unit for unit in known if kind(unit) not in RAW]
    if not raw:
        open_unit = isinstance(sensor.get("unit"), Noted)
        return sensor | ({"unit": plain[0]} if open_unit and plain else {})
    given = GivenFile("", said, {}, {}, _never, _never)
    chain = chain_said(given, sensor_kind)
    if chain.get("scale_factor"):
        chain = chain_of_units(given, chain, raw)
        if raw_units(chain):
            spoken = plain[0] if plain else spoken_unit(sensor_kind, chain)
            kept = {name: one for name, one in sensor.items() if name != "chain"}
            return kept | {"unit": spoken, "chain": Noted(chain, above=_equation(chain))}
    per = spoken_unit(sensor_kind, {})
    volts = {"reference": "? V", "scale_factor": f"? V/({per})"}
    wanted = (
        {"kind": "adc", "lsb": "? V"} | volts
        if any(kind(one) == "count" for one in raw)
        else {"kind": "output"} | volts
    )
    return sensor | {"unit": plain[0] if plain else fill_in(per), "chain": fill_in(wanted | chain)}


def _equation(chain: Mapping[str, Any]) -> str:
    """Return how a chain makes a reading, as a comment."""
    output = f"lsb * count{'' if 'reference' not in chain else ' - reference'}" if chain["kind"] == "adc" else "output"
    output += " - reference" if chain["kind"] == "output" and "reference" in chain else ""
    output = f"{output} - zero" if "zero" in chain else output
    gain = " / gain" if "gain" in chain else ""
    return f"A reading is ({output}){gain} / scale_factor, nominal values of the data sheet."


def _never(*_: object, **__: object) -> Any:
    raise AssertionError("no file is read for its chain")


def _with_unit(entry: object, unit: str | None) -> object:
    """Return the entry of a recording with the unit that was said in place of those that are open."""
    if isinstance(entry, Noted):
        return Noted(_with_unit(entry.value, unit), entry.note, "" if unit else entry.above, entry.example)
    table = plain_table(entry)
    if unit is None:
        return table
    if "channels" in table:
        channels = {
            what: _closed(one, unit) if what in AXES else one for what, one in plain_table(table["channels"]).items()
        }
        return table | {"channels": channels}
    return table | {name: _closed(table[name], unit) for name in OF_TABLE if name in table}


def _closed(entry: object, unit: str) -> object:
    """Return the entry of a column with a unit where it has none; no longer marked where nothing else is open."""
    table = plain_table(entry)
    if table.get("unit") not in OPEN:
        return entry
    closed = table | {"unit": unit}
    return closed if all(one not in OPEN for one in closed.values() if isinstance(one, str)) else fill_in(closed)


def _units(entry: object) -> Iterator[str]:
    """Yield the units of readings of an entry."""
    table = plain_table(entry)
    if "channels" in table:
        for what, one in plain_table(table["channels"]).items():
            if what in AXES:
                yield str(plain_table(one).get("unit", "?"))
    else:
        yield from (str(plain_table(table[name]).get("unit", "?")) for name in OF_TABLE if name in table)


def _reading(said: Said) -> dict[str, Any]:
    """Return how files are read, as an entry says it."""
    clock = {
        "column": said.time_column,
        "sample_rate": None if said.sample_rate is None else f"{said.sample_rate!r} Hz",
        "start": said.start, "stop": said.stop, "mission_start": said.mission_start,
    }  # fmt: skip
    found: dict[str, Any] = {"text": text_said(said), "frame": said.frame}
    found["clock"] = {name: value for name, value in clock.items() if value is not None}
    return {name: table for name, table in found.items() if table}


def _of_file(entry: object, of_files: Mapping[str, Part]) -> object:
    """Return an entry with its file and topics where it has the label of a part."""
    if isinstance(entry, Noted):
        return Noted(_of_file(entry.value, of_files), entry.note, entry.above, entry.example)
    table = plain_table(entry)
    part = of_files.get(str(table.get("file")))
    own = {} if part is None else {"file": part.file, "topics": list(part.topics)}
    return {key: value for name, old in table.items() for key, value in
            (own.items() if own and name == "file" else [(name, old)])}  # fmt: skip


def _read_as(entry: object, reading: Mapping[str, Any]) -> object:
    """Return an entry with how its file is read; a table of dwells has no clock."""
    if isinstance(entry, Noted):
        return Noted(_read_as(entry.value, reading), entry.note, entry.above, entry.example)
    table = plain_table(entry)
    for name, own in reading.items():
        if name == "text" or "channels" in table:
            table[name] = plain_table(table.get(name, {})) | own if isinstance(own, dict) else own
    return table


def _turn(recordings: dict[str, object], tests: Sequence[object], axis: str) -> None:
    """Put the axis that was turned where a recording or a test leaves it open; several that are seen stay as they are.

    One answer is not right for recordings of which each was turned about an axis of its own.
    """
    marked = {key: str(table["axis"].value) for key, entry in recordings.items()
              if _is_marked((table := plain_table(entry)).get("axis"))}  # fmt: skip
    plans = [test for test in tests if isinstance(test, dict) and _is_marked(test.get("plan"))]
    plans = [test for test in plans if "axis" in plain_table(test["plan"])]
    seen = {*marked.values(), *(plain_table(test["plan"])["axis"] for test in plans)} - {"?"}
    for key, own in marked.items():
        turned = own if own != "?" and len(seen) > 1 else axis
        recordings[key] = plain_table(recordings[key]) | {"axis": turned} if turned else recordings[key]
    for test in plans:
        own = str(plain_table(test["plan"])["axis"])
        turned = own if own != "?" and len(seen) > 1 else axis
        test["plan"] = plain_table(test["plan"]) | {"axis": turned} if turned else test["plan"]


def _is_marked(value: object) -> bool:
    return isinstance(value, Noted) and value.note == FILL_IN


def plain_table(value: object) -> dict[str, Any]:
    """Return a table of a draft without its marks."""
    plain = value.value if isinstance(value, Noted) else value
    return dict(plain) if isinstance(plain, Mapping) else {}

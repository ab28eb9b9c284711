"""The campaign that a call stands for, as text: what `run` would read from campaign.toml.

Every way in becomes this document: what a noun was given is described by its procedure (`Procedure.described`), or
taken from another campaign (``like``). It says all that was used, so from a folder it gives the same figures.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path, PurePath
from typing import Any

from ...core.campaign_text import FILE, SCHEMA
from ...core.errors import UsageError
from ...core.influence import standard_of
from ...core.recording import ClockRate
from ...core.remarks import Remark
from ...procedures.given import GROUP, Described, GivenFile, Said
from ...procedures.protocol import Procedure
from ..file.load import clock_standard, load
from ..file.recordings import OWN_KEYS
from .given import text_said

Document = dict[str, Any]
INNER_FILES = ("file", "schedule")  # keys of tables in an entry that name another file


def document_of(
    procedure: Procedure[Any, Any, Any],
    given: Sequence[GivenFile],
    plan: Mapping[str, Any],
    held_out: Sequence[str] = (),
) -> tuple[Document, dict[str, str], list[Remark]]:
    """Return a campaign with a test of all files, and one of those held out; which column is what; and remarks.

    Parameters
    ----------
    procedure : Procedure
        Of the tests.
    given : sequence of GivenFile
        Files, with what was said.
    plan : mapping
        Settings, as text.
    held_out : sequence of str
        Names of the files that the model is judged on.

    Raises
    ------
    UsageError
        If it is not clear what a file holds.
    """
    said = given[0].said
    like = None if said.like is None else _Like(said.like)
    sensors: dict[str, dict[str, Any]] = {} if like is None else like.document["sensors"]
    document: Document = {
        "schema": SCHEMA, "campaign": {"id": procedure.name}, "site": _site(said),
        "standards": _standards(said), "sensors": sensors, "recordings": {}, "tests": [],
    }  # fmt: skip
    if like is not None:
        for table in ("site", "standards"):
            document[table] = _over(like.document.get(table, {}), document[table])
    columns: dict[str, str] = {}
    clocks: list[ClockRate | None] = []
    uses: dict[tuple[str, str], dict[str, Any]] = {}
    requirements: list[dict[str, Any]] = []
    parts: list[dict[str, Any]] = []
    remarks: list[Remark] = []
    for one in given:
        found = like.entries(one, procedure) if like is not None else list(procedure.described(one))
        for each in found:
            remarks += each.remarks
            requirements += [one for one in each.requirements if one not in requirements]
            name = _named(one, each, document["recordings"], several=len(found) > 1)
            sensor = each.entry.get("sensor") or _sensor(sensors, each)
            own = {"sensor": sensor, "file": one.name} | each.entry | _reading(one.said, each.entry)
            document["recordings"][name] = own
            if "channels" in own:
                clocks.append(one.recording.clock)
            columns |= {what: column for what, column in each.columns.items() if what not in columns}
            use = "hold_out" if one.name in held_out else "fit"
            test = uses.setdefault((use, each.test), {"recordings": [], "plan": {}})
            test["recordings"].append(name)
            if each.procedure:  # a test of its own, that the one of the call is made of
                parts.append({"id": name, "procedure": each.procedure, "recordings": [name], "plan": each.plan})
                test.setdefault("after", []).append(name)
            else:
                test["plan"] |= each.plan
            if each.windows:
                test.setdefault("windows", []).extend(each.windows)
    if "rate" not in document["standards"].get("clock", {}) and (said_by_them := clock_standard(clocks)):
        document["standards"]["clock"] = said_by_them
    used = {entry["sensor"] for entry in document["recordings"].values()}
    document["sensors"] = {name: sensor for name, sensor in sensors.items() if name in used}
    document["tests"] = [*_tests_of(procedure, uses, plan), *parts]
    if requirements:
        document["requirements"] = requirements
    return document, columns, remarks


def _tests_of(
    procedure: Procedure[Any, Any, Any], uses: Mapping[tuple[str, str], dict[str, Any]], plan: Mapping[str, Any]
) -> Iterator[dict[str, Any]]:
    """Yield the tests of the call, by use and name."""
    for (use, test_id), test in uses.items():
        stem = test_id or procedure.name
        head = {"id": stem if use == "fit" else f"{stem}_held_out", "procedure": procedure.name}
        yield {**head, "use": use, **test, "plan": test["plan"] | dict(plan)}


def _reading(said: Said, entry: Mapping[str, Any]) -> dict[str, Any]:
    """Return how the file is read, and the power-up, as an entry says them."""
    text = text_said(said)
    topics = {"topics": list(said.topics)} if said.topics else {}
    if "channels" not in entry:
        return ({"text": text} if text else {}) | topics
    clock = {
        "column": said.time_column, "averaging": said.averaging, "start": said.start, "stop": said.stop,
        "sample_rate": None if said.sample_rate is None else f"{said.sample_rate!r} Hz",
        "mission_start": said.mission_start,
    }  # fmt: skip
    clock = {**entry.get("clock", {}), **{name: value for name, value in clock.items() if value is not None}}
    found: dict[str, Any] = ({"clock": clock} if clock else {}) | ({"text": text} if text else {})
    if said.frame is not None:
        found["frame"] = said.frame
    return found | topics | ({"run": "1"} if said.one_run else {})


def _site(said: Said) -> dict[str, str]:
    given = {"latitude": said.latitude, "gravity": said.gravity, "height": said.height}
    return {name: value for name, value in given.items() if value is not None}


def _standards(said: Said) -> dict[str, Any]:
    found: dict[str, dict[str, Any]] = {}
    for name, text in said.standards.items():
        standard, quantity = standard_of(name)
        entry: object = {"u": text}
        if text.lstrip().startswith("{"):
            try:
                entry = tomllib.loads(f"entry = {text}")["entry"]
            except tomllib.TOMLDecodeError as error:
                do = f'Write it like --standard \'{name}={{ u = "0.1 %", certificate = "C-1" }}\''
                raise UsageError(f"standard {name}: not TOML: {error}", do=do, code="not_toml") from None
        found.setdefault(standard, {})[quantity] = entry
    return found


def _over(below: Mapping[str, Any], above: Mapping[str, Any]) -> dict[str, Any]:
    """Return one table over another, tables inside them too."""
    merged = dict(below)
    for name, value in above.items():
        own = merged.get(name)
        nested = isinstance(value, Mapping) and isinstance(own, Mapping) and "u" not in value
        merged[name] = _over(own, value) if nested and isinstance(own, Mapping) else value
    return merged


def _named(one: GivenFile, each: Described, taken: Mapping[str, Any], several: bool) -> str:
    """Return a name for a recording: that of its file, with the kind of sensor where a file has several."""
    file = PurePath(one.name).name
    for _ in range(2):  # .csv.gz
        file = file.removesuffix(PurePath(file).suffix)
    stem = re.sub(r"[^A-Za-z0-9_.-]", "_", file).strip("_.-")[:40] or "recording"
    wanted = f"{stem}_{each.test or each.sensor['kind']}" if several else stem
    count = 2
    name = wanted
    while name in taken:
        name, count = f"{wanted}_{count}", count + 1
    return name


def _sensor(sensors: dict[str, dict[str, Any]], each: Described) -> str:
    """Return the sensor of a recording: the one of its kind, with all axes that any file has."""
    name = each.test or str(each.sensor["kind"])
    known = sensors.setdefault(name, dict(each.sensor))
    if "chain" not in known and "chain" in each.sensor:  # files in units of input beside others in counts or volts
        known["chain"] = each.sensor["chain"]
    known["axes"] = [axis for axis in ("x", "y", "z") if axis in {*known["axes"], *each.sensor["axes"]}]
    return name


class _Like:
    """A campaign whose sensors, channels, site, standards and plans other files have."""

    def __init__(self, folder: str | Path) -> None:
        self.folder = Path(folder)
        load(self.folder)  # refuses what is wrong with it
        self.document: Document = tomllib.loads((self.folder / FILE).read_text(encoding="utf-8-sig"))

    def entries(self, one: GivenFile, procedure: Procedure[Any, Any, Any]) -> list[Described]:
        """Return the entry of a file, one of each sensor: those of its file name, else of its columns.

        Raises
        ------
        UsageError
            If none fits, or several of one sensor that differ.
        """
        entries: dict[str, dict[str, Any]] = self.document["recordings"]
        tests = [test for test in self.document["tests"] if test["procedure"] in (procedure.name, procedure.made_of)]
        tests.sort(key=lambda test: (test["procedure"] != procedure.made_of, test.get("use", "fit") != "fit"))
        read = {name: test for test in reversed(tests) for name in test["recordings"]}
        fits = {name: entries[name] for name in read if PurePath(entries[name]["file"]).name == PurePath(one.name).name}
        named = bool(fits)
        fits = fits or {name: entries[name] for name in read if self._has_columns(one, entries[name])}
        alone = set() if named else {"run", *(key for key, own in OWN_KEYS.items() if own.alone)}
        kept = {
            name: {key: value for key, value in entry.items() if key not in {"file", *alone}}
            for name, entry in fits.items()
        }
        by_sensor: dict[str, list[str]] = {}
        for name, entry in kept.items():
            by_sensor.setdefault(entry["sensor"] if procedure.inputs.several_sensors else "", []).append(name)
        differ = [
            names for names in by_sensor.values() if len({repr(kept[n] | {"run": "", "source": ""}) for n in names}) > 1
        ]
        if not kept or differ:
            fit = f"recordings {', '.join(differ[0])} fit, and differ" if differ else "no recording fits"
            do = f"Tests of {procedure.name} read: {', '.join(read) or 'nothing'}. Give the file one of their names"
            raise UsageError(f"{one.name}: {fit} in {self.folder}", do=do, code="unknown_name")
        several = len(by_sensor) > 1
        return [self._described(one, kept[n], read[n], procedure, several) for n, *_ in by_sensor.values()]

    def _described(
        self,
        one: GivenFile,
        entry: dict[str, Any],
        test: dict[str, Any],
        procedure: Procedure[Any, Any, Any],
        several: bool,
    ) -> Described:
        for key, value in entry.items():  # other files lie in the folder of that campaign
            own = value if isinstance(value, Mapping) else {}
            inner = {what: str(self.folder / own[what]) for what in INNER_FILES if isinstance(own.get(what), str)}
            entry[key] = {**own, **inner} if inner else value
            if key in OWN_KEYS and isinstance(value, str) and (self.folder / value).is_file():
                entry[key] = str(self.folder / value)
        sensor = self.document["sensors"][entry["sensor"]]
        self._check_own_model(sensor)
        stem = f"{GROUP.get(sensor['kind'], sensor['kind'])}_" if several else ""
        taken = {f"{stem}{what}": str(channel["column"]) for what, channel in entry.get("channels", {}).items()}
        entry, remarks = procedure.like(one, entry)
        part = "" if test["procedure"] == procedure.name else test["procedure"]
        return Described(entry, sensor, taken, test.get("plan", {}), remarks=tuple(remarks), procedure=part)

    def _has_columns(self, one: GivenFile, entry: Mapping[str, Any]) -> bool:
        names = set(one.recording.names) if "channels" in entry else set(one.table.names)
        wanted = [one["column"] for one in entry.get("channels", {}).values()]
        return bool(wanted) and names.issuperset(wanted)

    def _check_own_model(self, sensor: dict[str, Any]) -> None:
        """Let a ground model be found: its file lies in the folder of that campaign."""
        chain = sensor.get("chain", {})
        if "model" in chain and not Path(chain["model"]).is_absolute():
            chain["model"] = str((self.folder / chain["model"]).resolve())


__all__ = ["Document", "document_of"]

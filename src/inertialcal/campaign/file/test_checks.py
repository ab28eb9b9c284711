"""Checks of the tests of a campaign: recordings that the procedure can use, tests that compare with each other."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import combinations
from typing import Any

from ...core.errors import Problem
from ...core.key import AXES
from ...core.schema.toml import At
from ...core.units import kind
from ...procedures import procedure_names, procedure_of
from ...procedures.entries import SaidTest
from ...procedures.protocol import Procedure
from .plans import plan_values
from .recordings import OWN_KEYS, TABLE_KEYS, CommonKeys, RecordingEntry, table_of
from .schema import CampaignFile, Test
from .sensors import RAW


def procedure_checks(file: CampaignFile, number: int, test: Test, at: At) -> Iterator[Problem]:
    """Find a test that its procedure cannot carry out."""
    where = at("tests", number, "procedure")
    if test.procedure not in procedure_names():
        do = f"There are: {', '.join(procedure_names())}"
        yield Problem(f"test {test.id!r}: no procedure {test.procedure!r}", where, do=do, code="unknown_name")
        return
    procedure = procedure_of(test.procedure)
    if test.use not in procedure.uses:
        what = f'test {test.id!r}: use = "{test.use}", but no model is made of a {test.procedure} and none judged on it'
        do = 'Give it use = "report_only", or leave use out'
        yield Problem(what, at("tests", number, "use"), "it would have no effect", do, "wrong_value")
    for name in test.recordings:
        if name not in file.recordings:
            do = f"There are: {', '.join(file.recordings)}"
            what = f"test {test.id!r}: no recording {name!r}"
            yield Problem(what, at("tests", number, "recordings"), do=do, code="unknown_name")
    yield from _test_sensor(file, number, test, at)
    yield from _test_recordings(file, number, test, at)
    several = len({file.recordings[name].sensor for name in test.recordings if name in file.recordings}) > 1
    if several and not procedure.inputs.several_sensors:
        yield Problem(f"test {test.id!r}: recordings of different sensors", at("tests", number, "recordings"))
    elif several:
        yield from _same_kind(file, test, at("tests", number, "recordings"))
    values, problems = plan_values(test.procedure, test.plan, at("tests", number, "plan"))
    yield from problems
    axis = values.get("axis")
    sensors = [file.sensors[file.recordings[n].sensor] for n in test.recordings if n in file.recordings
               and file.recordings[n].sensor in file.sensors]  # fmt: skip
    if axis and sensors and axis not in sensors[0].axes:
        what = f"test {test.id!r}: plan.axis = {axis!r}, the sensor has {', '.join(sensors[0].axes)}"
        yield Problem(what, at("tests", number, "plan", "axis"), code="unknown_name")


def _same_kind(file: CampaignFile, test: Test, where: str) -> Iterator[Problem]:
    """Find two sensors of one kind in a test: their rows would be ambiguous."""
    named = dict.fromkeys(file.recordings[name].sensor for name in test.recordings if name in file.recordings)
    by_kind: dict[str, list[str]] = {}
    for name in named:
        if name in file.sensors:
            by_kind.setdefault(file.sensors[name].kind, []).append(name)
    for each, names in by_kind.items():
        if len(names) > 1:
            what = f"test {test.id!r}: {len(names)} {each}s: {', '.join(names)}"
            yield Problem(what, where, "a test takes one sensor of each kind", "Make a test for each", "wrong_value")


def _test_sensor(file: CampaignFile, number: int, test: Test, at: At) -> Iterator[Problem]:
    """Find a kind of sensor that the procedure does not test, and pulses without the scale factor that it needs."""
    where, inputs = at("tests", number, "procedure"), procedure_of(test.procedure).inputs
    named = {file.recordings[n].sensor for n in test.recordings if n in file.recordings}
    sensors = {name: file.sensors[name] for name in sorted(named) if name in file.sensors}
    others = {one.kind for one in sensors.values()} - {*inputs.kinds, *(["other"] if inputs.bare else [])}
    if others:
        what = f"test {test.id!r}: {test.procedure} tests {inputs.kinds[0]}s, the sensor is of kind {others.pop()!r}"
        yield Problem(what, where, code="wrong_value")
    for name, one in sensors.items():
        if one.kind != "other" and kind(one.unit) in RAW and not inputs.raw:
            what = f"test {test.id!r}: sensor {name!r} is in {one.unit}"
            do = "Give its unit, and a chain with a scale factor"
            yield Problem(what, where, f"a {test.procedure} needs readings in its unit", do, "wrong_value")
        if one.chain.kind == "pulse_rate" and one.chain.scale_factor is None and not inputs.pulses:
            what = f"sensors.{name}.chain: {test.procedure} needs scale_factor"
            yield Problem(what, at("sensors", name, "chain"), code="missing_key")


def _test_recordings(file: CampaignFile, number: int, test: Test, at: At) -> Iterator[Problem]:
    """Find recordings that a test names twice, cannot choose groups from, or that turn another axis."""
    procedure = procedure_of(test.procedure)
    named = [file.recordings[n] for n in test.recordings if n in file.recordings]
    files = [(one.file, _columns(one), one.sensor if procedure.inputs.several_sensors else "") for one in named]
    if len(set(files)) < len(files):
        what = f"test {test.id!r}: a recording appears twice"
        yield Problem(what, at("tests", number, "recordings"), "its readings would count twice", code="duplicate_id")
    said = SaidTest(test.id, test.windows, test.plan, file.sensors, file.site.latitude, at, number)
    yield from procedure.check(said)
    for name in test.recordings:
        entry = file.recordings.get(name)
        if entry is None:
            continue
        own_key = procedure.inputs.table
        needs = f"{own_key} or channels" if own_key else "channels"
        for key in TABLE_KEYS:
            if key != own_key and getattr(entry, key) is not None:
                what = f"test {test.id!r}: recording {name!r} has {key}, a {test.procedure} needs {needs}"
                yield Problem(what, at("recordings", name, key), code="wrong_value")
        yield from procedure.check_recording(said, name, entry)
        for channel, one in (entry.channels or {}).items():
            if not procedure.inputs.bare and (one.quantity or one.scale_factor):
                key = "quantity" if one.quantity else "scale_factor"
                what = f"test {test.id!r}: recording {name!r} has channels with {key}, a {test.procedure} takes none"
                yield Problem(what, at("recordings", name, "channels", channel), code="wrong_value")
        if test.groups is not None and not _by_row(entry):
            what = f"test {test.id!r}: groups, but recording {name!r} names no column of groups"
            yield Problem(what, at("tests", number, "groups"), do=procedure.chosen_by, code="wrong_value")
        own = test.plan.get("axis")
        if own and entry.axis not in (None, own):
            what = f"test {test.id!r}: plan.axis = {own!r}, but recording {name!r} says axis = {entry.axis!r}"
            yield Problem(what, at("tests", number, "plan", "axis"), do="Say it in one place", code="wrong_value")


def _columns(entry: CommonKeys) -> str:
    """Return what tells a table from another one of the same file; empty where nothing does."""
    return repr([getattr(entry, name) for name, key in OWN_KEYS.items() if key.apart])


def _by_row(entry: CommonKeys) -> bool:
    """Tell whether rows of a table can be chosen by their group, flip or run."""
    table = table_of(entry)
    return table is not None and (table[0].grouped is None or table[0].grouped(table[1]))


def _with(able: Callable[[Procedure[Any, Any, Any]], bool]) -> list[str]:
    """Return the names of the procedures that can do something."""
    return [name for name in procedure_names() if able(procedure_of(name))]


def against_checks(file: CampaignFile, number: int, test: Test, at: At) -> Iterator[Problem]:
    """Find a test that is set beside none, beside itself, or beside one of another procedure."""
    if test.against is None:
        return
    where = at("tests", number, "against")
    others = {one.id: one for one in file.tests if one.id != test.id and one.procedure == test.procedure}
    able = _with(lambda procedure: procedure.set_against or procedure.changes)
    if test.procedure not in able:
        what = f"test {test.id!r}: against, but only {' and '.join(able)} tests are set side by side"
        yield Problem(what, where, do="Leave it out, or compare two campaigns: compare A B", code="wrong_value")
    elif test.against not in others:
        what = f"test {test.id!r}: against = {test.against!r} is no other {test.procedure} test of this campaign"
        yield Problem(what, where, do=f"There are: {', '.join(others) or 'none'}", code="unknown_name")
    elif procedure_of(test.procedure).changes:
        mine, its = ({file.recordings[name].sensor for name in one.recordings if name in file.recordings}
                     for one in (test, others[test.against]))  # fmt: skip
        if mine and its and mine != its:
            of = " and ".join(sorted(its))
            what = f"test {test.id!r}: against = {test.against!r}, a test of {of}, not of {' and '.join(sorted(mine))}"
            yield Problem(
                what, where, "what two sensors differ by is no change", "Name a test of the same sensor", "wrong_value"
            )


def after_checks(file: CampaignFile, number: int, test: Test, at: At) -> Iterator[Problem]:
    """Find a test that comes after none, after itself, or after one that finds no bias over temperature."""
    where = at("tests", number, "after")
    made_of = procedure_of(test.procedure).made_of if test.procedure in procedure_names() else ""
    if made_of:
        yield from _parts_checks(file, test, made_of, where)
    elif test.after:
        yield from _correction_checks(file, test, where)


def _correction_checks(file: CampaignFile, test: Test, where: str) -> Iterator[Problem]:
    """Find a test whose readings nothing is taken off, or nothing that the tests before it find."""
    matrix = test.procedure in _with(lambda procedure: procedure.takes_matrix)
    corrects = _with(lambda procedure: procedure.corrects == "bias" or (matrix and procedure.corrects == "matrix"))
    corrected = _with(lambda procedure: procedure.takes_corrections)
    tables = [procedure_of(name).inputs.table for name in corrected]
    others = {one.id: one for one in file.tests
              if one.id != test.id and one.procedure in corrects and one.use == "fit"}  # fmt: skip
    if _comes_after_itself(file, test):
        what = f"test {test.id!r} comes after itself, by way of {', '.join(test.after)}"
        yield Problem(what, where, "none of them could be the first", "Leave one after out", "wrong_value")
    biases = [name for name in test.after if name in others and procedure_of(others[name].procedure).corrects == "bias"]
    if len(biases) > 1:
        what = f"test {test.id!r}: after = {biases}, each of which found the bias"
        yield Problem(what, where, "it would be taken off twice", "Name one of them", "wrong_value")
    for name in test.after:
        if test.procedure not in corrected:
            what = f"test {test.id!r}: after, but nothing is taken off the readings of a {test.procedure} test"
            why = _said(test.procedure) or "it would have no effect"
            yield Problem(what, where, why, "Leave it out", "wrong_value")
        elif name not in others:
            what = f"test {test.id!r}: after = {name!r} is no {' or '.join(corrects)} test of this campaign"
            what = f'{what} with use = "fit"'
            yield Problem(what, where, do=f"There are: {', '.join(others) or 'none'}", code="unknown_name")
        elif not _sensors(file, test) & _sensors(file, others[name]):
            what = f"test {test.id!r}: after = {name!r} is a test of another sensor"
            yield Problem(what, where, do="Leave it out, or name a test of its own sensor", code="another_sensor")
        for recording in test.recordings:
            entry = file.recordings.get(recording)
            table = None if entry is None else table_of(entry)
            if table is not None and table[0].name in tables:
                what = f"test {test.id!r}: after = {name!r}, but recording {recording!r} is a table without temperature"
                yield Problem(what, where, do="Leave after out, or give the recording itself", code="wrong_value")


def _parts_checks(file: CampaignFile, test: Test, made_of: str, where: str) -> Iterator[Problem]:
    """Find a test made of others that names none, or one of another procedure or sensor, or leaves out recordings."""
    others = {one.id: one for one in file.tests if one.procedure == made_of}
    known = [file.recordings[name] for name in test.recordings if name in file.recordings]
    if any(one.channels is not None for one in known) and not test.after:
        what = f"test {test.id!r}: it has recordings, but after names no {made_of} test of them"
        do = f"Give it after = [...]; there are: {', '.join(others) or 'none'}"
        yield Problem(what, where, f"a {test.procedure} is made of what {made_of} tests find", do, "missing_key")
    if len(set(test.after)) < len(test.after):
        what = f"test {test.id!r}: after names a test twice"
        yield Problem(what, where, "it would count twice", "Name each once", "duplicate_id")
    for name in dict.fromkeys(test.after):
        if name not in others:
            what = f"test {test.id!r}: after = {name!r} is no {made_of} test of this campaign"
            yield Problem(what, where, do=f"There are: {', '.join(others) or 'none'}", code="unknown_name")
        elif not _sensors(file, test) & _sensors(file, others[name]):
            what = f"test {test.id!r}: after = {name!r} is a test of another sensor"
            yield Problem(what, where, do="Leave it out, or name a test of its own sensor", code="another_sensor")
        elif lacking := [one for one in others[name].recordings if one not in test.recordings]:
            what = f"test {test.id!r}: after = {name!r}, whose recording {lacking[0]!r} is not among its own"
            yield Problem(what, where, "they say what it rests on", "Add it to recordings", "missing_key")
        elif others[name].plan.get("corrected"):
            what = f"test {test.id!r}: after = {name!r}, whose bias was subtracted before (corrected = true)"
            why = "what is left is the error of that model, not the bias of the head"
            yield Problem(what, where, why, "Leave corrected out of its plan", "wrong_value")


def _said(procedure: str) -> str:
    """Return why nothing is taken off the readings of a procedure."""
    return procedure_of(procedure).no_corrections if procedure in procedure_names() else ""


def _sensors(file: CampaignFile, test: Test) -> set[str]:
    return {file.recordings[name].sensor for name in test.recordings if name in file.recordings}


def _comes_after_itself(file: CampaignFile, test: Test) -> bool:
    """Whether a ring of tests leads back to this one; one that names itself is no other test, which is said below."""
    after = {one.id: one.after for one in file.tests}
    reached: set[str] = set()
    left = [*test.after]
    while left:
        name = left.pop()
        if name not in reached:
            reached.add(name)
            left += after.get(name, [])
    return test.id in reached and test.id not in test.after


def overlap_checks(file: CampaignFile, at: At) -> Iterator[Problem]:
    """Find readings that the model is fitted on twice, or fitted on and judged by."""
    do = "Give them different recordings, groups or windows"
    for other, one in combinations(file.tests, 2):
        if counts_twice(file, one, other) and _same_readings(file, one, other):
            number = file.tests.index(one)
            what = f"tests {other.id!r} ({other.use}) and {one.id!r} ({one.use}) use the same readings"
            judging = "hold_out" in (one.use, other.use)
            why = "a model must be judged on data held out" if judging else "they would count twice"
            yield Problem(what, at("tests", number), why, do, "overlap")


def counts_twice(file: CampaignFile, one: Test, other: Test) -> bool:
    """Return whether readings that two tests share would be fitted on twice, or fitted on and judged by."""
    uses = {one.use, other.use}
    if one.id == other.id or one.procedure != other.procedure or "report_only" in uses or uses == {"hold_out"}:
        return False
    procedure = procedure_of(one.procedure) if one.procedure in procedure_names() else None
    if procedure is None or "hold_out" not in procedure.uses:
        return False
    return not procedure.inputs.several_sensors or _sensor_of(file, one) == _sensor_of(file, other)


def _sensor_of(file: CampaignFile, test: Test) -> str:
    """Return the name of the sensor that a test is about: that of its first recording."""
    entry = file.recordings.get(test.recordings[0])
    return "" if entry is None else entry.sensor


def _same_readings(file: CampaignFile, one: Test, other: Test) -> bool:
    """Tell by the files, not by the names of recordings, whether two tests share readings."""
    entries = [[file.recordings[n] for n in test.recordings if n in file.recordings] for test in (one, other)]
    return any(_of_one_sensor(file, a, b) for a in entries[0] for b in entries[1]) and _share(one, other)


def _of_one_sensor(file: CampaignFile, one: RecordingEntry, other: RecordingEntry) -> bool:
    """Whether two entries read the same rows of a file; columns of their axes that are others are other readings."""
    if one.file != other.file:
        return False
    axes = [{entry.channels[axis].column for axis in AXES if axis in entry.channels} if entry.channels else set()
            for entry in (one, other)]  # fmt: skip
    return not all(axes) or one.topics != other.topics or bool(axes[0] & axes[1])


def _share(one: Test, other: Test) -> bool:
    if one.groups and other.groups and not set(one.groups) & set(other.groups):
        return False
    if one.windows and other.windows:
        return any(a < d and c < b for a, b in one.windows for c, d in other.windows)
    return True

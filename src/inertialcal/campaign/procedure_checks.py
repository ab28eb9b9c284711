"""Tests of a campaign: whether the procedure can do with its recordings what the test asks, and beside which others."""

from __future__ import annotations

from collections.abc import Iterator

from ..core.errors import Problem
from ..procedures import procedure_names
from .mass_checks import mass_checks
from .plans import plan_values
from .schema import CampaignFile, Test
from .schema_recordings import RecordingEntry
from .toml_lines import At

SENSORS: dict[str, tuple[str, ...]] = {  # that a procedure tests
    "rate_table": ("gyro",),
    "flip": ("accelerometer",),
    "thermal": ("gyro",),
    "static_noise": ("gyro", "accelerometer"),
    "sine": ("accelerometer", "gyro"),
    "mass_attraction": ("accelerometer",),
    "positions": ("accelerometer", "gyro"),
}
TABLES = {"rate_table": "rows", "flip": "means", "mass_attraction": "lines"}  # the key of its reduced tables
WITHOUT_GROUPS = {  # how a part of a recording is chosen
    "rate_table": "Choose by windows, or give rows.group",
    "flip": "Choose by positions",
}
AFTER, CORRECTED = "thermal", ("rate_table",)  # whose bias is taken off, and of what
AGAINST = ("flip", "thermal")  # procedures whose tests are set beside each other
HELD_OUT = ("rate_table", "thermal", "positions")  # procedures whose tests judge what another one found


def procedure_checks(file: CampaignFile, number: int, test: Test, at: At) -> Iterator[Problem]:
    """Find a test that its procedure cannot carry out."""
    where = at("tests", number, "procedure")
    if test.procedure not in procedure_names():
        do = f"There are: {', '.join(procedure_names())}"
        yield Problem(f"test {test.id!r}: no procedure {test.procedure!r}", where, do=do, code="unknown_name")
        return
    if test.use == "hold_out" and test.procedure not in HELD_OUT:
        what = f'test {test.id!r}: use = "hold_out", but no model is made of a {test.procedure} and none judged on it'
        do = 'Give it use = "report_only", or leave use out'
        yield Problem(what, at("tests", number, "use"), "it would have no effect", do, "wrong_value")
    for name in test.recordings:
        if name not in file.recordings:
            do = f"There are: {', '.join(file.recordings)}"
            what = f"test {test.id!r}: no recording {name!r}"
            yield Problem(what, at("tests", number, "recordings"), do=do, code="unknown_name")
    yield from _test_sensor(file, number, test, at)
    yield from _test_recordings(file, number, test, at)
    if test.plan.get("attitude") is not None and file.site.latitude is None:
        what = f"test {test.id!r}: plan.attitude needs site.latitude"
        yield Problem(what, at("tests", number, "plan", "attitude"), "earth rate depends on both", code="missing_key")
    several = len({file.recordings[name].sensor for name in test.recordings if name in file.recordings}) > 1
    if several and test.procedure != "positions":
        yield Problem(f"test {test.id!r}: recordings of different sensors", at("tests", number, "recordings"))
    values, problems = plan_values(test.procedure, test.plan, at("tests", number, "plan"))
    yield from problems
    axis = values.get("axis")
    sensors = [file.sensors[file.recordings[n].sensor] for n in test.recordings if n in file.recordings
               and file.recordings[n].sensor in file.sensors]  # fmt: skip
    if axis and sensors and axis not in sensors[0].axes:
        what = f"test {test.id!r}: plan.axis = {axis!r}, the sensor has {', '.join(sensors[0].axes)}"
        yield Problem(what, at("tests", number, "plan", "axis"), code="unknown_name")


def _test_sensor(file: CampaignFile, number: int, test: Test, at: At) -> Iterator[Problem]:
    """Find a kind of sensor that the procedure does not test."""
    where = at("tests", number, "procedure")
    kinds = {file.sensors[file.recordings[n].sensor].kind for n in test.recordings if n in file.recordings
             and file.recordings[n].sensor in file.sensors}  # fmt: skip
    others = kinds - {*SENSORS[test.procedure]}
    if others:
        tested = f"{SENSORS[test.procedure][0]}s"
        what = f"test {test.id!r}: {test.procedure} tests {tested}, the sensor is of kind {others.pop()!r}"
        yield Problem(what, where, code="wrong_value")


def _test_recordings(file: CampaignFile, number: int, test: Test, at: At) -> Iterator[Problem]:
    """Find recordings that a test names twice, cannot choose groups from, or that turn another axis."""
    named = [file.recordings[n] for n in test.recordings if n in file.recordings]
    files = [(one.file, repr(one.rows), one.sensor if test.procedure == "positions" else "") for one in named]
    if len(set(files)) < len(files):
        what = f"test {test.id!r}: a recording appears twice"
        yield Problem(what, at("tests", number, "recordings"), "its readings would count twice", code="duplicate_id")
    if test.procedure == "flip" and test.windows is not None:
        what = f"test {test.id!r}: windows, but a flip is read where its recordings say (positions), or by groups"
        yield Problem(
            what, at("tests", number, "windows"), "they would have no effect", "Leave them out", "wrong_value"
        )
    for name in test.recordings:
        entry = file.recordings.get(name)
        if entry is None:
            continue
        own_key = TABLES.get(test.procedure, "")
        needs = f"{own_key} or channels" if own_key else "channels"
        for key in TABLES.values():
            if key != own_key and getattr(entry, key) is not None:
                what = f"test {test.id!r}: recording {name!r} has {key}, a {test.procedure} needs {needs}"
                yield Problem(what, at("recordings", name, key), code="wrong_value")
        yield from _how_it_was_moved(file, test, name, entry, at)
        if test.groups is not None and not _by_row(entry):
            what = f"test {test.id!r}: groups, but recording {name!r} names no column of groups"
            do = WITHOUT_GROUPS.get(test.procedure, "Choose by windows")
            yield Problem(what, at("tests", number, "groups"), do=do, code="wrong_value")
        own = test.plan.get("axis")
        if own and entry.axis not in (None, own):
            what = f"test {test.id!r}: plan.axis = {own!r}, but recording {name!r} says axis = {entry.axis!r}"
            yield Problem(what, at("tests", number, "plan", "axis"), do="Say it in one place", code="wrong_value")


def _how_it_was_moved(file: CampaignFile, test: Test, name: str, entry: RecordingEntry, at: At) -> Iterator[Problem]:
    """Find a recording of a flip or of a moved mass that does not say what was done when."""
    if test.procedure == "flip" and entry.channels is not None and entry.positions is None:
        what = f"recordings.{name}: nothing says how the head was turned, and when"
        do = 'Give positions = [{ start = ..., stop = ..., angle = "0 deg" }, ...]'
        yield Problem(what, at("recordings", name), do=do, code="missing_key")
    if test.procedure == "mass_attraction":
        yield from mass_checks(file, test, name, entry, at)


def _by_row(entry: RecordingEntry) -> bool:
    """Tell whether rows of a table can be chosen by their group, flip or run."""
    grouped = entry.rows is not None and entry.rows.group is not None
    return grouped or entry.means is not None or entry.lines is not None


def against_checks(file: CampaignFile, number: int, test: Test, at: At) -> Iterator[Problem]:
    """Find a test that is set beside none, beside itself, or beside one of another procedure."""
    if test.against is None:
        return
    where = at("tests", number, "against")
    others = {one.id: one for one in file.tests if one.id != test.id and one.procedure == test.procedure}
    if test.procedure not in AGAINST:
        what = f"test {test.id!r}: against, but only {' and '.join(AGAINST)} tests are set side by side"
        yield Problem(what, where, do="Leave it out, or compare two campaigns: compare A B", code="wrong_value")
    elif test.against not in others:
        what = f"test {test.id!r}: against = {test.against!r} is no other {test.procedure} test of this campaign"
        yield Problem(what, where, do=f"There are: {', '.join(others) or 'none'}", code="unknown_name")


def after_checks(file: CampaignFile, number: int, test: Test, at: At) -> Iterator[Problem]:
    """Find a test that comes after none, after itself, or after one that finds no bias over temperature."""
    where = at("tests", number, "after")
    others = [one.id for one in file.tests if one.id != test.id and one.procedure == AFTER and one.use == "fit"]
    for name in test.after:
        if test.procedure not in CORRECTED:
            what = f"test {test.id!r}: after, but only a {' or '.join(CORRECTED)} has a bias taken off its readings"
            yield Problem(what, where, "it would have no effect", "Leave it out", "wrong_value")
        elif name not in others:
            what = f'test {test.id!r}: after = {name!r} is no {AFTER} test of this campaign with use = "fit"'
            yield Problem(what, where, do=f"There are: {', '.join(others) or 'none'}", code="unknown_name")
        for recording in test.recordings:
            entry = file.recordings.get(recording)
            if entry is not None and entry.rows is not None:
                what = f"test {test.id!r}: after = {name!r}, but recording {recording!r} is a table without temperature"
                yield Problem(what, where, do="Leave after out, or give the recording itself", code="wrong_value")


def overlap_checks(file: CampaignFile, at: At) -> Iterator[Problem]:
    """Find readings that the model is fitted on twice, or fitted on and judged by."""
    do = "Give them different recordings, groups or windows"
    modelled = [test for test in file.tests if test.procedure in HELD_OUT]
    for one in modelled:
        number = file.tests.index(one)
        for other in (test for test in modelled[: modelled.index(one)] if test.procedure == one.procedure):
            uses = {one.use, other.use}
            if "report_only" in uses or uses == {"hold_out"} or not _same_readings(file, one, other):
                continue
            if one.procedure == "positions" and _sensor_of(file, one) != _sensor_of(file, other):
                continue
            what = f"tests {other.id!r} ({other.use}) and {one.id!r} ({one.use}) use the same readings"
            why = "a model must be judged on data held out" if "hold_out" in uses else "they would count twice"
            yield Problem(what, at("tests", number), why, do, "overlap")


def _sensor_of(file: CampaignFile, test: Test) -> str:
    """Return the name of the sensor that a test is about: that of its first recording."""
    entry = file.recordings.get(test.recordings[0])
    return "" if entry is None else entry.sensor


def _same_readings(file: CampaignFile, one: Test, other: Test) -> bool:
    """Tell by the files, not by the names of recordings, whether two tests share readings."""
    files = [{file.recordings[n].file for n in test.recordings if n in file.recordings} for test in (one, other)]
    return bool(files[0] & files[1]) and _share(one, other)


def _share(one: Test, other: Test) -> bool:
    if one.groups and other.groups and not set(one.groups) & set(other.groups):
        return False
    if one.windows and other.windows:
        return any(a < d and c < b for a, b in one.windows for c, d in other.windows)
    return True

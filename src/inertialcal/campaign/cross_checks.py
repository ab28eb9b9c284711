"""What one key of a campaign file says about another: names that lead somewhere, files that are there."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from difflib import get_close_matches
from pathlib import Path

from ..core.errors import DataError, InertialcalError, Problem
from ..core.units import kind, normalise, parse_quantity, same_dimension
from ..files.pad_pairs import pairs_of
from ..procedures import PROCEDURES
from . import noise_units as noise
from .chains import build_chain, scale_factors
from .conditions import parse_condition
from .ground_checks import ground_checks
from .mass_checks import line_units, mass_checks
from .plans import plan_values
from .schema import CampaignFile, RecordingEntry, Requirement, Rows, Sensor, Test

At = Callable[..., str]

RATE = ("angular_rate", "acceleration")
RELATIVE = ("dimensionless",)
# Quantities that tests give, with the kinds of unit that their limits can have.
QUANTITIES: dict[str, tuple[str, ...]] = {
    "rate_error": RELATIVE,
    "bias": RATE,
    "scale_factor": ("other",),
    "scale_factor_error": RELATIVE,
    "scale_factor_asymmetry": RELATIVE,
    "cross_axis_sensitivity": RELATIVE,
    "misalignment": ("angle",),
    "linearity_error": RELATIVE,
    "scatter_sample": RATE,
    "scatter_dwell": RATE,
    "scatter_run": RATE,
    "scatter_recording": RATE,
    "ambient_acceleration": RATE,
    "model_bias_error": RATE,
    "control_error": RATE,
    "reading": RATE,
    "bias_shift": RATE,
    "corrected_bias": RATE,
    "model_bias_error_change": RATE,
    "model_bias_error_reduction": RATE,
    "path_difference": RATE,
    "hysteresis": RATE,
    "vacuum_offset": RATE,
    "residual_bias": RATE,
    "warm_up_change": RATE,
    "warm_up_time": ("time",),
    "warm_up_time_constant": ("time",),
    "thermal_lag": ("time",),
    "high_g_difference": RELATIVE,
    "null_response": RATE,
    "reference_voltage": ("voltage",),
    "temperature_reference_voltage": ("voltage",),
    "g_sensitivity": ("other",),
    "scatter_position": RATE,
    "scatter_rotation": ("angle",),
    "transition_error": ("angle",),
}
NOISE = {sensor: noise.data_sheet_units(sensor) for sensor in noise.SENSORS}  # quantities of noise, and their units
SENSORS: dict[str, tuple[str, ...]] = {  # that a procedure tests
    "rate_table": ("gyro",),
    "flip": ("accelerometer",),
    "thermal": ("gyro",),
    "static_noise": ("gyro", "accelerometer"),
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
WHERE = {"rate_error": "rate", "bias": "temperature"}  # quantities over a range, and what the range is of
RESERVED = "model"  # test that the rows of the model of the sensor carry in results.json
MODELLED = ("rate_table", "positions")  # procedures whose results become a model


def cross_checks(folder: Path, file: CampaignFile, at: At) -> list[Problem]:
    """Return everything that does not fit together.

    Parameters
    ----------
    folder : Path
        Of the campaign.
    file : CampaignFile
        Valid by itself.
    at : callable
        Place of a key path, for messages.
    """
    return [
        *(p for name, sensor in file.sensors.items() for p in _sensor(name, sensor, at)),
        *(p for name, entry in file.recordings.items() for p in _recording(folder, file, name, entry, at)),
        *(p for number, test in enumerate(file.tests) for p in _test(file, number, test, at)),
        *(p for number, test in enumerate(file.tests) for p in _against(file, number, test, at)),
        *(p for number, test in enumerate(file.tests) for p in _after(file, number, test, at)),
        *_duplicates("tests", [test.id for test in file.tests], at),
        *_reserved(file, at),
        *_duplicates("requirements", [one.id for one in file.requirements], at),
        *_apart(file, at),
        *_model_terms(file, at),
        *ground_checks(folder, file, at),
        *_requirements(file, at),
    ]


def _sensor(name: str, sensor: Sensor, at: At) -> Iterator[Problem]:
    for text in sensor.range or []:
        try:
            parse_quantity(text).to(sensor.unit)
        except DataError as error:
            what = f"sensors.{name}.range: {error.problems[0].what}"
            yield Problem(what, at("sensors", name, "range"), code="wrong_value")
    if sensor.chain.kind != "none" and sensor.chain.scale_factor is None:
        what = f"sensors.{name}.chain: kind = {sensor.chain.kind!r} needs scale_factor"
        yield Problem(what, at("sensors", name, "chain"), code="missing_key")
        return
    try:
        build_chain(sensor) if sensor.chain.kind != "none" else scale_factors(sensor, tuple(sensor.axes))
    except InertialcalError as error:
        what = f"sensors.{name}.chain: {error.problems[0].what}"
        yield Problem(what, at("sensors", name, "chain"), do=error.problems[0].do, code="wrong_value")


def _recording(folder: Path, file: CampaignFile, name: str, entry: RecordingEntry, at: At) -> Iterator[Problem]:
    if entry.sensor not in file.sensors:
        do = f"There are: {', '.join(file.sensors)}"
        where = at("recordings", name, "sensor")
        yield Problem(f"recordings.{name}: no sensor {entry.sensor!r}", where, do=do, code="unknown_name")
    yield from _file(folder, name, entry.file, at("recordings", name, "file"))
    yield from _schedules(folder, name, entry, at)
    sensor = file.sensors.get(entry.sensor)
    if sensor is not None and entry.rows is not None and sensor.mounting is not None:
        what = f"recordings.{name}: the sensor has a mounting, which is for recordings of channels"
        do = "Give the table in body axes, and another sensor without mounting for it"
        yield Problem(what, at("recordings", name, "rows"), "the columns' axes would be ambiguous", do, "wrong_value")
    clock = entry.clock
    if clock is not None and clock.stamp != "middle" and clock.averaging is None:
        what = f"recordings.{name}: stamp = {clock.stamp!r} needs averaging: by how much is the stamp off the middle?"
        yield Problem(what, at("recordings", name, "clock"), code="missing_key")
    if (
        clock is not None
        and clock.averaging is not None
        and clock.interval is not None
        and clock.averaging > clock.interval * 1.001
    ):
        what = f"recordings.{name}: averaging over {clock.averaging:g} s, but saved every {clock.interval:g} s"
        yield Problem(what, at("recordings", name, "clock"), code="wrong_value")
    if sensor is not None:
        yield from _units(name, entry, sensor, at)


def _schedules(folder: Path, name: str, entry: RecordingEntry, at: At) -> Iterator[Problem]:
    if entry.schedule is not None:
        yield from _file(folder, name, entry.schedule.file, at("recordings", name, "schedule"))
    if entry.mass is not None:
        yield from _file(folder, name, entry.mass.schedule, at("recordings", name, "mass"))


def _units(name: str, entry: RecordingEntry, sensor: Sensor, at: At) -> Iterator[Problem]:
    if entry.rows is not None:
        yield from _row_units(name, entry.rows, sensor, at)
    elif entry.means is not None:
        if kind(entry.means.unit) != kind(sensor.unit):
            what = f"recordings.{name}: means in {entry.means.unit!r}, need a unit of {kind(sensor.unit)}"
            yield Problem(what, at("recordings", name, "means"), code="wrong_value")
    elif entry.lines is not None:
        yield from line_units(name, entry.lines, at)
    else:
        yield from _channel_units(name, entry, sensor, at)


def _file(folder: Path, name: str, given: str, where: str) -> Iterator[Problem]:
    try:
        root = folder.resolve()
        path = (root / given).resolve()
        exists = path.is_file() or (path.is_dir() and bool(pairs_of(path)))  # a folder of archive records
    except DataError:  # one member of a pair is not there, which its reader tells
        return
    except (OSError, ValueError, RuntimeError):
        yield Problem(f"recordings.{name}: {given!r} is no file name", where, code="missing_file")
        return
    if not path.is_relative_to(root):
        why = "a campaign must be complete in its folder"
        do = "Copy the file into the campaign folder"
        yield Problem(f"recordings.{name}: {given!r} lies outside the campaign folder", where, why, do, "outside")
    elif not exists:
        yield Problem(f"recordings.{name}: file {given!r} does not exist", where, code="missing_file")


def _channel_units(name: str, entry: RecordingEntry, sensor: Sensor, at: At) -> Iterator[Problem]:
    wanted = kind(sensor.unit)
    for channel, one in (entry.channels or {}).items():
        where = at("recordings", name, "channels", channel)
        axis = channel.rpartition("_")[2]
        if axis in {"x", "y", "z"} and axis not in sensor.axes:
            yield Problem(f"recordings.{name}: the sensor has no axis {axis!r}", where, code="unknown_name")
        need = _kinds(channel, sensor, wanted)
        if need and kind(one.unit) not in need:
            what = f"recordings.{name}: channel {channel} in {one.unit!r}, need a unit of {' or '.join(need)}"
            yield Problem(what, where, code="wrong_value")


def _kinds(channel: str, sensor: Sensor, wanted: str) -> tuple[str, ...]:
    """Return the kinds of unit that a channel may have; none where it is not used."""
    counted = sensor.chain.kind != "none"
    if channel in ("temperature", "pressure"):
        return (channel,)
    if channel == "tilt":
        return ("angle",)
    if channel.startswith("temperature"):
        return ("temperature", "count") if counted else ("temperature",)
    if channel.startswith("gain"):
        return ("dimensionless",)
    if "_" in channel and not counted:
        return ()
    return (wanted,) if channel == "applied" or not counted else ("count",)


def _row_units(name: str, rows: Rows, sensor: Sensor, at: At) -> Iterator[Problem]:
    wanted = kind(sensor.unit)
    where = at("recordings", name, "rows")
    applied = rows.applied_unit or (sensor.unit if kind(rows.unit) in {"count", "voltage"} else rows.unit)
    if kind(applied) != wanted:
        yield Problem(f"recordings.{name}: applied in {applied!r}, need a unit of {wanted}", where, code="wrong_value")
    if kind(rows.unit) == "count" and sensor.chain.kind != "adc":
        yield Problem(f"recordings.{name}: counts, but the sensor's chain has no converter", where, code="wrong_value")
    elif kind(rows.unit) == "voltage" and sensor.chain.scale_factor is None:
        what = f"recordings.{name}: volts, but the sensor's chain has no scale_factor"
        yield Problem(what, where, code="wrong_value")
    elif kind(rows.unit) not in {"count", "voltage", wanted}:
        yield Problem(f"recordings.{name}: unit {rows.unit!r}, need a unit of {wanted}", where, code="wrong_value")
    for axis in [*(rows.reading if isinstance(rows.reading, dict) else ())]:
        if axis not in sensor.axes:
            yield Problem(f"recordings.{name}: the sensor has no axis {axis!r}", where, code="unknown_name")


def _test(file: CampaignFile, number: int, test: Test, at: At) -> Iterator[Problem]:
    where = at("tests", number, "procedure")
    if test.procedure not in PROCEDURES:
        do = f"There are: {', '.join(PROCEDURES)}"
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


def _against(file: CampaignFile, number: int, test: Test, at: At) -> Iterator[Problem]:
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


def _after(file: CampaignFile, number: int, test: Test, at: At) -> Iterator[Problem]:
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


def _duplicates(table: str, ids: list[str], at: At) -> Iterator[Problem]:
    for number, one in enumerate(ids):
        if one in ids[:number]:
            what = f"duplicate id {one!r} in {table}: used before"
            why = "results could not be told apart"
            yield Problem(what, at(table, number, "id"), why, "Give each its own", "duplicate_id")


def _reserved(file: CampaignFile, at: At) -> Iterator[Problem]:
    names = {RESERVED, *(f"{RESERVED}_{sensor}" for sensor in file.sensors)}
    for number, test in enumerate(file.tests):
        if test.id in names:
            what = f"tests: id {test.id!r}: results have the rows of the model of the sensor under this name"
            yield Problem(what, at("tests", number, "id"), "they could not be told apart", "Rename it", "duplicate_id")


def _apart(file: CampaignFile, at: At) -> Iterator[Problem]:
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


def _model_terms(file: CampaignFile, at: At) -> Iterator[Problem]:
    uses = {test.id: test.use for test in file.tests if test.procedure in MODELLED}
    lists = {}
    for term, names in file.model.terms.items():
        where = at("model", "terms", term)
        for name in names:
            if uses.get(name) != "fit":
                what = f"model.terms.{term}: {name!r} is no test with use = 'fit' that a model is made of"
                have = ", ".join(test for test, use in uses.items() if use == "fit")
                yield Problem(what, where, do=f"There are: {have or 'none'}", code="unknown_name")
        if term != "bias":
            lists[term] = set(names)
    if len({frozenset(names) for names in lists.values()}) > 1:
        what = f"model.terms: {', '.join(lists)} come from one reduction and need the same tests"
        yield Problem(what, at("model", "terms"), code="wrong_value")


def _share(one: Test, other: Test) -> bool:
    if one.groups and other.groups and not set(one.groups) & set(other.groups):
        return False
    if one.windows and other.windows:
        return any(a < d and c < b for a, b in one.windows for c, d in other.windows)
    return True


def _requirements(file: CampaignFile, at: At) -> Iterator[Problem]:
    ids = {test.id for test in file.tests}
    for number, one in enumerate(file.requirements):
        for name in one.tests or []:
            if name not in ids:
                do = f"There are: {', '.join(sorted(ids))}"
                what = f"requirement {one.id!r}: no test {name!r}"
                yield Problem(what, at("requirements", number, "tests"), do=do, code="unknown_name")
        for key in ("limit", "lower", "upper"):
            text = getattr(one, key)
            if text is not None:
                yield from _limit(one, text, at("requirements", number, key))
        yield from _spelling(one, at("requirements", number, "quantity"))
        yield from _where(one, at("requirements", number, "where"))


def _where(one: Requirement, where: str) -> Iterator[Problem]:
    """Find a condition that cannot be read, or that is about something else than the quantity is told over."""
    try:
        condition = parse_condition(one.where)
    except DataError as error:
        what = f"requirement {one.id!r}: {error.problems[0].what}"
        yield Problem(what, where, do=error.problems[0].do, code="wrong_value")
        return
    over = WHERE.get(one.quantity)
    others = {part.name for every in condition.alternatives for part in every} - {over}
    if over is not None and others:
        what = f"requirement {one.id!r}: where names {' and '.join(sorted(others))}, {one.quantity} is over {over}"
        yield Problem(what, where, "it would have no effect", f"Write it in terms of {over}", "wrong_value")


def _limit(one: Requirement, text: str, where: str) -> Iterator[Problem]:
    try:
        unit = normalise(parse_quantity(text).unit)
    except DataError as error:
        yield Problem(f"requirement {one.id!r}: {error.problems[0].what}", where, code="wrong_value")
        return
    if text == one.limit and parse_quantity(text).value <= 0.0:
        what = f"requirement {one.id!r}: limit = {text!r} is the size of both limits, it must be above zero"
        yield Problem(what, where, do="For one side give lower or upper", code="wrong_value")
    what = f"requirement {one.id!r}: {one.quantity} cannot be compared with {text!r}"
    needed = QUANTITIES.get(one.quantity)
    if needed is not None and kind(unit) not in needed:
        yield Problem(what, where, do=f"Give a limit of kind {' or '.join(needed)}", code="wrong_value")
    shown = [units[one.quantity] for units in NOISE.values() if one.quantity in units]
    if shown and not any(same_dimension(unit, other) for other in shown):
        yield Problem(what, where, do=f"Give a limit in {' or '.join(shown)}", code="wrong_value")


def _spelling(one: Requirement, where: str) -> Iterator[Problem]:
    """Tell a misspelt quantity from one that no test here gives (which is OPEN)."""
    known = [*QUANTITIES, *(name for units in NOISE.values() for name in units)]
    near = get_close_matches(one.quantity, known, n=1, cutoff=0.8)
    if one.quantity not in known and near:
        what = f"requirement {one.id!r}: no quantity {one.quantity!r}"
        yield Problem(what, where, "it would stay OPEN for ever", f"Did you mean {near[0]}?", "unknown_name")
    about = WHERE.get(one.quantity)
    if one.where and about is None:
        what = f"requirement {one.id!r}: where is about {' or '.join(WHERE)}, not {one.quantity}"
        yield Problem(what, where, "it would have no effect", code="wrong_value")

"""What one key of a campaign file says about another: names that lead somewhere, files that are there."""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Iterator, Mapping
from difflib import get_close_matches
from pathlib import Path

from ...core.errors import DataError, InertialcalError, Problem
from ...core.judging import parse_condition
from ...core.key import AXES
from ...core.schema.toml import At
from ...core.units import kind, normalise, parse_quantity, same_dimension
from ...procedures import all_quantities, procedure_names, procedure_of
from ...procedures.protocol import Quantity
from ..inputs.chains import RAW, in_input_units
from ..inputs.ground import chain_model, has_model
from .conditions import after_condition, condition_checks, conditions_of
from .decisions import fit_problems, key_problems
from .recording_checks import recording_checks, sensor_checks
from .schema import CampaignFile, Requirement
from .sensors import Sensor
from .test_checks import after_checks, against_checks, overlap_checks, procedure_checks

Known = Mapping[str, Quantity]
RESERVED = "model"  # test that the rows of the model of the sensor carry in results.json


def cross_checks(folder: Path | None, file: CampaignFile, at: At, elsewhere: bool = False) -> list[Problem]:
    """Return everything that does not fit together; a folder of None allows files anywhere.

    ``elsewhere``: recordings lie in no folder that is known yet.
    """
    own = None if elsewhere else folder
    found = [
        *(p for name, sensor in file.sensors.items() for p in sensor_checks(name, sensor, at)),
        *(p for name, entry in file.recordings.items() for p in recording_checks(own, file, name, entry, at)),
        *(p for number, test in enumerate(file.tests) for p in procedure_checks(file, number, test, at)),
        *(p for number, test in enumerate(file.tests) for p in against_checks(file, number, test, at)),
        *(p for number, test in enumerate(file.tests) for p in after_checks(file, number, test, at)),
        *(p for number, test in enumerate(file.tests) for p in after_condition(file, number, test, at)),
        *_duplicates("tests", [test.id for test in file.tests], at),
        *_reserved(file, at),
        *_one_file(file, at),
        *_idle_chains(file, at),
        *_duplicates("requirements", [one.id for one in file.requirements], at),
        *overlap_checks(file, at),
        *condition_checks(file, at),
        *ground_checks(folder, file, at),
        *requirement_checks(file, at),
        *decision_checks(file, at),
    ]
    return list(dict.fromkeys(found))  # what several recordings of a test show is said once


def _duplicates(table: str, ids: list[str], at: At) -> Iterator[Problem]:
    for number, one in enumerate(ids):
        if one in ids[:number]:
            what = f"duplicate id {one!r} in {table}: used before"
            why = "results would be ambiguous"
            yield Problem(what, at(table, number, "id"), why, "Give each its own", "duplicate_id")


def model_name(sensor: str, condition: str) -> str:
    """Return what the rows of a model are named: of a sensor, but for the first one; of a condition, where one is."""
    return "_".join(filter(None, (RESERVED, sensor, condition)))


def _reserved(file: CampaignFile, at: At) -> Iterator[Problem]:
    names = {model_name(sensor, condition) for sensor in ("", *file.sensors)
             for condition in ("", *(one for name in file.sensors for one in conditions_of(file, name)))}  # fmt: skip
    for number, test in enumerate(file.tests):
        if test.id in names:
            what = f"tests: id {test.id!r}: results have the rows of the model of the sensor under this name"
            yield Problem(what, at("tests", number, "id"), "results would be ambiguous", "Rename it", "duplicate_id")


def _one_file(file: CampaignFile, at: At) -> Iterator[Problem]:
    """Find sensors whose models would be one file where upper and lower case are the same."""
    known: dict[str, str] = {}
    for name in file.sensors:
        first = known.setdefault(name.casefold(), name)
        if first != name:
            what = f"sensors {first!r} and {name!r} differ in upper and lower case alone"
            why = "on Windows and macOS the files of their models would be one"
            yield Problem(what, at("sensors", name), why, "Rename one", "duplicate_id")


def _idle_chains(file: CampaignFile, at: At) -> Iterator[Problem]:
    """Find chains through which no recording of the sensor goes: all are in units of input already."""
    for name, sensor in file.sensors.items():
        entries = [one for one in file.recordings.values() if one.sensor == name]
        if sensor.chain.kind == "none" or not entries or any(one.channels is None for one in entries):
            continue
        channels = [{what: one.unit for what, one in (entry.channels or {}).items()} for entry in entries]
        axes = [[unit for what, unit in units.items() if what in AXES] for units in channels]
        raw = any(unit and kind(unit) in RAW for units in channels for unit in units.values())
        if not raw and all(in_input_units(sensor, units) for units in axes):
            what = f"sensors.{name}: a chain, and every recording is in units of input ({normalise(axes[0][0])})"
            do = "Leave the chain out, or say that the columns are in count or V"
            yield Problem(what, at("sensors", name, "chain"), "it would have no effect", do, "wrong_value")


def requirement_checks(file: CampaignFile, at: At) -> Iterator[Problem]:
    """Find requirements on tests, quantities, limits or conditions that cannot be judged."""
    ids = {test.id for test in file.tests}
    known = _quantities(file) if file.requirements else {}
    for number, one in enumerate(file.requirements):
        for name in one.tests or []:
            if name not in ids:
                do = f"There are: {', '.join(sorted(ids))}"
                what = f"requirement {one.id!r}: no test {name!r}"
                yield Problem(what, at("requirements", number, "tests"), do=do, code="unknown_name")
        for key in ("limit", "lower", "upper"):
            text = getattr(one, key)
            if text is not None:
                yield from _limit(one, known, text, at("requirements", number, key))
        yield from _spelling(one, known, _given(file), at("requirements", number, "quantity"))
        yield from _where(one, known, at("requirements", number, "where"))
        if one.of == "change":
            yield from _change(file, one, at("requirements", number, "of"))
        if one.readings == "compensated":
            yield from _compensated(file, one, at("requirements", number, "readings"))


def _change(file: CampaignFile, one: Requirement, where: str) -> Iterator[Problem]:
    """Find a requirement on a change where no test is set against another, or of a change over a range."""
    what = f"requirement {one.id!r}: of = 'change'"
    changing = {name for name in procedure_names() if procedure_of(name).changes}
    about = [test for test in file.tests if one.tests is None or test.id in one.tests]
    if not any(test.against is not None and test.procedure in changing for test in about):
        names = " or ".join(sorted(changing))
        why, do = "no test that it is about is set against another", f'Give a {names} test against = "the earlier test"'
        own = next((test.procedure for test in about if test.against is not None), "")
        if own:  # it tells its changes as quantities of their own
            why = f"{own} tells changes as quantities of their own"
            do = "Leave of out, and give the change as quantity"
        yield Problem(what, where, why, do, "wrong_value")
    if one.where or one.readings == "compensated":
        said = "where" if one.where else "readings"
        yield Problem(f"{what} with {said}", where, "it would have no effect", f"Leave {said} out", "wrong_value")


def _compensated(file: CampaignFile, one: Requirement, where: str) -> Iterator[Problem]:
    """Find quantities that are not told of compensated readings, and tests that are not held out."""
    able = {name: procedure_of(name).compensated for name in procedure_names()}
    what = f"requirement {one.id!r}: readings = 'compensated'"
    if one.quantity not in {quantity for each in able.values() for quantity in each}:
        given = ", ".join(f"{quantity} of {name}" for name, each in able.items() for quantity in each)
        why = "only of these is it known what compensation leaves"
        yield Problem(f"{what} of {one.quantity}", where, why, f"There are: {given}", "wrong_value")
        return
    for test in file.tests:
        if test.id in (one.tests or ()) and test.use != "hold_out":
            why = "a model does well on the readings that it was fitted on"
            do = 'Name tests with use = "hold_out"'
            yield Problem(f"{what} of test {test.id!r}, use = {test.use!r}", where, why, do, "wrong_value")
    held = (test for test in file.tests if test.use == "hold_out")
    if one.tests is None and not any(one.quantity in able.get(test.procedure, ()) for test in held):
        do = 'Hold out power-ups: a test with use = "hold_out"'
        yield Problem(f"{what}: no test is held out that gives {one.quantity}", where, do=do, code="wrong_value")


def decision_checks(file: CampaignFile, at: At) -> Iterator[Problem]:
    """Find decision rules that are not complete, and those that cannot judge a requirement."""
    yield from key_problems(file.decision, ("decision",), at)
    quantities = _quantities(file) if file.requirements else {}  # those of all procedures start slowly
    for number, one in enumerate(file.requirements):
        if one.decision is not None:
            yield from key_problems(one.decision, ("requirements", number, "decision"), at)
        known = _of(one, quantities)
        pair = (None, one.limit) if known.size and one.of != "change" else (one.limit, one.limit)
        limits = (one.lower, one.upper) if one.limit is None else pair
        over = known.over if one.where or known.over == "rate" else ""
        key = ("id",) if one.decision is None else ("decision", "rule")
        where = at("requirements", number, *key)
        yield from fit_problems(one.decision or file.decision, one.id, limits, over, known.size, where)


def _where(one: Requirement, known: Known, where: str) -> Iterator[Problem]:
    """Find a condition that cannot be read, or that is about something else than the quantity is told over."""
    try:
        condition = parse_condition(one.where)
    except DataError as error:
        what = f"requirement {one.id!r}: {error.problems[0].what}"
        yield Problem(what, where, do=error.problems[0].do, code="wrong_value")
        return
    over = _of(one, known).over
    others = {part.name for every in condition.alternatives for part in every} - {over}
    if over and others:
        what = f"requirement {one.id!r}: where names {' and '.join(sorted(others))}, {one.quantity} is over {over}"
        yield Problem(what, where, "it would have no effect", f"Write it in terms of {over}", "wrong_value")


def _limit(one: Requirement, known: Known, text: str, where: str) -> Iterator[Problem]:
    try:
        unit = normalise(parse_quantity(text).unit)
    except DataError as error:
        yield Problem(f"requirement {one.id!r}: {error.problems[0].what}", where, code="wrong_value")
        return
    if text == one.limit and parse_quantity(text).value <= 0.0:
        what = f"requirement {one.id!r}: limit = {text!r} is the size of both limits, it must be above zero"
        yield Problem(what, where, do="For one side give lower or upper", code="wrong_value")
    what = f"requirement {one.id!r}: {one.quantity} cannot be compared with {text!r}"
    if one.of == "change" and same_dimension(unit, "1"):  # of the figure as it was
        return
    needed, shown = _of(one, known).kinds, _of(one, known).shown_by_kind.values()
    if needed and kind(unit) not in needed:
        kinds = [one for one in needed if one != "other"]
        do = f"Give a limit of kind {' or '.join(kinds)}" if kinds else "Give a limit in the unit that its row has"
        yield Problem(what, where, do=do, code="wrong_value")
    if shown and not any(same_dimension(unit, other) for other in shown):
        yield Problem(what, where, do=f"Give a limit in {' or '.join(shown)}", code="wrong_value")


def _spelling(one: Requirement, known: Known, given: set[str], where: str) -> Iterator[Problem]:
    """Find a quantity that no procedure gives, tested or not; one that no test of this campaign gives is OPEN."""
    if one.quantity not in known:
        near = get_close_matches(one.quantity.lower(), known, n=3, cutoff=0.6)
        do = f"Did you mean {' or '.join(near)}?" if near else f"The tests here give: {', '.join(sorted(given))}"
        what = f"requirement {one.id!r}: no procedure gives a quantity {one.quantity!r}"
        yield Problem(what, where, "it would stay OPEN for ever", do, "unknown_quantity")
    if one.where and not _of(one, known).over:
        ranged = [name for name, quantity in known.items() if quantity.over]
        what = f"requirement {one.id!r}: where is about {' or '.join(ranged)}, not {one.quantity}"
        yield Problem(what, where, "it would have no effect", code="wrong_value")


def _quantities(file: CampaignFile) -> Known:
    """Return what there is to say of all figures that a test of this campaign, or of another, can give."""
    names = procedure_names()
    own = [procedure_of(one.procedure).quantities_of(one.plan) for one in file.tests if one.procedure in names]
    return ChainMap({}, *map(dict, own), dict(all_quantities()))


def _given(file: CampaignFile) -> set[str]:
    """Return the quantities that the tests of this campaign and their recordings can give."""
    from ...procedures.recorded import QUANTITIES as RECORDED  # noqa: PLC0415 - numpy starts slowly

    names = procedure_names()
    tests = [one for one in file.tests if one.procedure in names]
    own = [{**procedure_of(one.procedure).quantities(), **procedure_of(one.procedure).quantities_of(one.plan)}
           for one in tests]  # fmt: skip
    return set(RECORDED).union(*own)


def _of(one: Requirement, known: Known) -> Quantity:
    return known.get(one.quantity, Quantity())


def ground_checks(folder: Path | None, file: CampaignFile, at: At) -> Iterator[Problem]:
    """Yield what is wrong with ground models, or with what is done with them."""
    for name, sensor in file.sensors.items():
        if has_model(sensor):
            yield from _model(folder, name, sensor, at)
    for number, test in enumerate(file.tests):
        sensors = {file.recordings[one].sensor for one in test.recordings if one in file.recordings}
        modelled = [name for name in sorted(sensors) if name in file.sensors and has_model(file.sensors[name])]
        if modelled and not _takes_model(test.procedure):
            what = f"test {test.id!r}: sensor {modelled[0]!r} has a ground model in its chain"
            why = f"a {test.procedure} is made of readings that no model has changed"
            do = "Give the recordings another sensor without it"
            yield Problem(what, at("tests", number, "recordings"), why, do, "wrong_value")


def _takes_model(procedure: str) -> bool:
    return procedure in procedure_names() and procedure_of(procedure).inputs.ground_model != "refused"


def _model(folder: Path | None, name: str, sensor: Sensor, at: At) -> Iterator[Problem]:
    key = "model" if sensor.chain.model is not None else "ground"
    where = at("sensors", name, "chain", key)
    if sensor.kind != "accelerometer":
        what = f"sensors.{name}.chain.{key}: a ground model is of a head of accelerometers"
        yield Problem(what, where, do="Leave it out; for a gyro: inertialcal compensate", code="wrong_value")
        return
    if folder is not None and sensor.chain.model is not None and not _is_inside(folder, sensor.chain.model):
        what = f"sensors.{name}.chain.model: {sensor.chain.model!r} lies outside the campaign folder"
        do = "Copy the file into the campaign folder"
        yield Problem(what, where, "a campaign must be complete in its folder", do, "outside")
        return
    try:
        chain_model(sensor, folder or Path())
    except InertialcalError as error:
        first = error.problems[0]
        file = f" = {sensor.chain.model!r}" if sensor.chain.model is not None else ""
        what = f"sensors.{name}.chain.{key}{file}: {first.what}"
        yield Problem(what, where, first.why, first.do, first.code or "wrong_value")


def _is_inside(folder: Path, given: str) -> bool:
    try:
        root = folder.resolve()
        return (root / given).resolve().is_relative_to(root)
    except (OSError, ValueError, RuntimeError):
        return False

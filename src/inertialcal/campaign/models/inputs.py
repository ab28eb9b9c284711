"""Which column of a recording is which input of a model.

A column is taken for an axis if its header says so (quantity and axis), or if it is named; a column that could be
two things is not taken.
"""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Mapping, Sequence, Set
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.batches import every
from ...core.errors import DataError, Problem
from ...core.recording import Channel, Recording
from ...core.remarks import Remark
from ...core.units import convert, parse_quantity, same_dimension
from ...files.text.headers import full_name
from ...sensors.chain.converter import Chain, from_output
from ...sensors.model.equation import needed
from ...sensors.model.on_recordings import CONDITIONS as CHANNELS
from ...sensors.model.on_recordings import QUANTITY, apply_chain
from ...sensors.model.sensor_model import RANGE_UNIT, SensorModel
from ...sensors.model.terms import FORCE_AXES

CONDITIONS = {"temperature": "degC", "temperature_rate": "degC/s", "pressure": "Pa", "time": "s"}
USUAL = {"degC": ("degC", "K", "degF"), "Pa": ("Pa", "hPa", "Torr"), "V": ("V", "mV"), "m/s^2": ("m/s2", "g")}
FORCES = tuple(f"force_{axis}" for axis in FORCE_AXES)
UNCERTAINTY = "u_"  # before the name of a column that holds standard uncertainties
RECORDED = {
    "reference": "ref",
    "temperature": "temp",
    "validity": "bit",
    "temperature_reference": "temp_ref",
}  # ``x_ref``


@dataclass(frozen=True)
class Taken:
    """What is used of a recording."""

    # What it is -> name of the column: each axis, and conditions (``temperature``, ``temperature_x``,
    # ``pressure``, ``force_x``, ...)
    columns: Mapping[str, str] = field(default_factory=dict)
    temperature: float | None = None  # The same for all rows [degC], where no column gives it


def taken(
    model: SensorModel,
    recording: Recording,
    columns: Mapping[str, str] | None = None,
    temperature: str | float | None = None,
) -> Taken:
    """Return which columns are used for what, of readings.

    Parameters
    ----------
    columns : mapping of str to str, optional
        What it is -> name of the column; an axis, or a channel that the model has a sensitivity to, is found by its
        header where it is not in it.
    temperature : str or float, optional
        Column, or temperature of all rows: ``"25 degC"``, or a number [degC].

    Raises
    ------
    DataError
        ``wrong_column`` where an axis has no column or several, or a name is not known.
    """
    named = dict(columns or {})
    channels = [one.channel for one in model.sensitivities]
    known = {*model.axes, *CONDITIONS, *FORCES, *(f"temperature_{axis}" for axis in model.axes), *channels}
    strangers = [f"{what}={name}" for what, name in named.items() if what not in known]
    if strangers:
        raise DataError(
            f"{', '.join(strangers)}: the model has no such input",
            do=f"It takes: {', '.join(model.axes)}, and {', '.join(sorted(known - set(model.axes)))}",
            code="wrong_column",
        )
    named = {what: full_name(recording.names, name) or recording.channel(name).name for what, name in named.items()}
    by_axis = {axis: [named[axis]] if axis in named else _columns_of(model, recording, axis) for axis in model.axes}
    found = {axis: names[0] for axis, names in by_axis.items() if len(names) == 1}
    asked = temperature is None and "temperature" not in named and "temperature" in needed(model)
    found |= _warm(model, recording) if asked else {}
    found |= _pressure(recording) if "pressure" in needed(model) and "pressure" not in named else {}
    found |= _force(recording) if "specific_force" in needed(model) and not {*named} & {*FORCES} else {}
    found |= {
        name: column for name in channels if name not in CONDITIONS and (column := full_name(recording.names, name))
    }
    column = full_name(recording.names, temperature) if isinstance(temperature, str) else None
    if column is not None:
        chosen = Taken({**found, "temperature": column, **named})
    else:
        chosen = Taken(found | named, None if temperature is None else _fixed_temperature(recording, temperature))
    unclear = {axis: names for axis, names in by_axis.items() if axis not in found}
    problems = [_unclear(model, recording, unclear)] if unclear else []
    problems += [*_missing_conditions(model, recording, chosen), *_without_unit(model, recording, chosen)]
    if problems:
        raise DataError(problems)
    return chosen


def all_missing(
    model: SensorModel,
    recording: Recording,
    columns: Mapping[str, str] | None = None,
    temperature: str | float | None = None,
) -> list[Problem]:
    """Return what `from_chain` and `taken` would refuse of readings."""
    try:
        taken(model, *from_chain(model, recording, columns), temperature)
    except DataError as error:
        return list(error.problems)
    return []


def _missing_conditions(model: SensorModel, recording: Recording, chosen: Taken) -> list[Problem]:
    """Return a problem for each condition that a term of the model needs and nothing gives, with what to add."""
    found = []
    units = CONDITIONS | dict.fromkeys(("specific_force",), "m/s^2") | {
        one.channel: one.unit for one in model.sensitivities}  # fmt: skip
    for name, term in needed(model).items():
        each = [f"{name}_{axis}" for axis in model.axes] if name in CONDITIONS else []
        wanted = FORCES if name == "specific_force" else (name,)
        if all(one in chosen.columns for one in wanted) or (each and all(one in chosen.columns for one in each)):
            continue
        if name != "temperature":
            do = f"Say it: {' '.join(f'--column {one}=NAME' for one in wanted)}"
            if not any(one.unit and same_dimension(one.unit, units[name]) for one in recording.channels):
                do += f"; and its unit: --unit NAME=UNIT (UNIT: {', '.join(USUAL.get(units[name], (units[name],)))})"
            what = f"the model needs {name.replace('_', ' ')}"
            found.append(Problem(what, recording.source.path, f"it has the term {term}", do, "missing_condition"))
        elif chosen.temperature is None:
            known = [channel.name for channel in recording.channels if channel.quantity == "temperature"]
            column = shlex.quote(known[0]) if len(known) == 1 else "COLUMN"
            do = f'Say it: --temperature {column}, or --temperature "NUMBER degC"'
            if len(known) > 1:
                do += f"; of each axis: --column temperature_x=COLUMN. Columns: {', '.join(known)}"
            what = "the model needs the temperature of the sensor"
            found.append(Problem(what, recording.source.path, f"it has the term {term}", do, "no_temperature"))
    return found


def _without_unit(model: SensorModel, recording: Recording, chosen: Taken) -> list[Problem]:
    """Return the problem of axes whose column has no unit, and one for each such column of a condition."""
    found = []
    axes = dict.fromkeys(chosen.columns[axis] for axis in model.axes if axis in chosen.columns)
    if bare := [name for name in axes if recording.channel(name).unit is None]:
        options = " ".join(f"--unit {shlex.quote(f'{name}=UNIT')}" for name in bare)
        what = f"unit of column {bare[0]!r} not given{', nor of ' * (len(bare) > 1)}{', '.join(map(repr, bare[1:]))}"
        why, do = f"the model takes {_takes(model)}", f"Say what it is: {options} (UNIT: {_takes(model)})"
        found.append(Problem(what, recording.source.path, why, do, "no_unit"))
    needs = needed(model)
    units = {one.channel: one.unit for one in model.sensitivities if one.channel not in CONDITIONS}
    units |= {name: unit for name, unit in CONDITIONS.items() if name in needs}
    units |= dict.fromkeys(FORCES, "m/s^2") if "specific_force" in needs else {}
    units |= {f"temperature_{axis}": "degC" for axis in model.axes} if "temperature" in needs else {}
    others = {name: units[what] for what, name in chosen.columns.items() if what in units and name not in axes}
    return found + [no_unit(recording, name, unit) for name, unit in others.items()
                    if recording.channel(name).unit is None]  # fmt: skip


def no_unit(recording: Recording, name: str, unit: str) -> Problem:
    """Return the problem of a column of a condition that has no unit."""
    do = f"Add --unit {shlex.quote(f'{name}=UNIT')} (UNIT: {', '.join(USUAL.get(unit, (unit,)))})"
    return Problem(f"unit of column {name!r} not given", recording.source.path, do=do, code="no_unit")


def _takes(model: SensorModel) -> str:
    """Return the units that a model takes readings in, for people."""
    words = ["deg/s", "rad/s"] if model.kind == "gyro" else ["m/s2", "g"]
    words += [model.output_unit] if model.output_unit not in (model.unit, *words) else []
    counted = model.chain is not None and model.chain.input_unit == "count"
    return ", ".join([*words, *(["count"] if counted and "count" not in words else [])])


def chain_columns(chain: Chain, recording: Recording, columns: Mapping[str, str] | None = None) -> dict[str, str]:
    """Return the columns that a chain starts from, by what they are: axes, ``reference_x``, ``temperature_x``, ...

    Those that are named, those whose header is the word, or the recorder's (``x_ref``), and of an axis the only one in
    counts or volts whose header says it; empty where the axes are
    neither in counts nor in the output of the chain. Columns without a unit count as counts beside the reference that
    the chain subtracts; where it subtracts none, if they hold whole numbers. A temperature in degC is none of them.
    """
    words = [*chain.axes, *CHANNELS, *(f"{what}_{axis}" for what in CHANNELS for axis in chain.axes)]
    named = {
        what: full_name(recording.names, name) or recording.channel(name).name
        for what, name in (columns or {}).items() if what in words
    }  # fmt: skip
    recorded = {f"{what}_{axis}": f"{axis}_{short}" for what, short in RECORDED.items() for axis in chain.axes}
    found = {}
    for word in words:
        headers = (full_name(recording.names, one) for one in (word, recorded.get(word)) if one is not None)
        name = named.get(word) or next((one for one in headers if one is not None), None)
        if name is not None:
            found[word] = recording.channel(name)
    for axis in chain.axes:
        if axis not in found and (alike := _raw_column(chain, recording, axis, {one.name for one in found.values()})):
            found[axis] = alike
    if not all(axis in found for axis in chain.axes):
        return {}
    axes = [found[axis] for axis in chain.axes]
    references = {"reference", *(f"reference_{axis}" for axis in chain.axes)} & set(found)
    subtracted = chain.reference == "channel"
    counted = all(
        one.unit == "count" or (one.unit is None and bool(references if subtracted else _are_whole(one.data)))
        for one in axes
    )
    counted = counted and chain.input_unit == "count"
    raw = counted or all(one.unit is not None and same_dimension(one.unit, chain.output_unit) for one in axes)
    warm = [word for word, one in found.items() if one.unit is not None and same_dimension(one.unit, "degC")]
    return {word: one.name for word, one in found.items() if word not in warm} if raw else {}


def _are_whole(values: NDArray[Any]) -> bool:
    """Whether values are whole numbers, in whichever type; missing ones aside."""
    if values.dtype.kind in "iu":
        return True
    return values.dtype.kind == "f" and every(values, lambda part: np.all(~np.isfinite(part) | (part == np.rint(part))))


def _raw_column(chain: Chain, recording: Recording, axis: str, taken: Set[str]) -> Channel | None:
    """Return the only column of an axis, by its header, in counts, in the output of the chain, or without a unit."""
    own = QUANTITY.get(chain.unit, "")
    found = [one for one in recording.channels if one.axis == axis and one.name not in taken
             and one.quantity in (own, "") and not one.name.startswith(UNCERTAINTY)
             and (one.unit in (None, "count") or same_dimension(one.unit, chain.output_unit))]  # fmt: skip
    found = [one for one in found if one.quantity] or found
    found = found or _only_column(recording, chain.axes, ["count", chain.output_unit], taken)
    return found[0] if len(found) == 1 else None


def _warm(model: SensorModel, recording: Recording) -> dict[str, str]:
    """Return the only column of temperature, or the one of each axis, as the tests take them."""
    warm = [one for one in recording.channels if one.unit and same_dimension(one.unit, "degC")]
    if len(warm) == 1:
        return {"temperature": warm[0].name}
    by_axis = {f"temperature_{one.axis}": one.name for one in warm if one.axis in model.axes}
    return by_axis if len(by_axis) == len(warm) == len(model.axes) else {}


def _pressure(recording: Recording) -> dict[str, str]:
    """Return the column that is called pressure, or the only one of its quantity."""
    column = full_name(recording.names, "pressure")
    gauges = [one.name for one in recording.channels if one.quantity == "pressure" and one.unit]
    return {"pressure": column or gauges[0]} if column or len(gauges) == 1 else {}


def _force(recording: Recording) -> dict[str, str]:
    """Return the columns of the only triad of accelerometers: beside gyros, they read the specific force."""
    felt = [one for one in recording.channels
            if one.quantity == "acc" and one.unit and same_dimension(one.unit, "m/s^2")]  # fmt: skip
    by_axis = {f"force_{one.axis}": one.name for one in felt if one.axis in FORCE_AXES}
    return by_axis if len(by_axis) == len(felt) == len(FORCES) else {}


def from_chain(
    model: SensorModel, recording: Recording, columns: Mapping[str, str] | None = None
) -> tuple[Recording, dict[str, str]]:
    """Return a recording of counts or volts as readings, and which column is which input of the model.

    A recording in units of input, or a model without a chain, comes back as it is.

    Parameters
    ----------
    columns : mapping of str to str, optional
        What it is -> name of the column, as `chain_columns` and `taken` take them.

    Raises
    ------
    DataError
        As ``sensors.model.on_recordings.apply_chain``.
    """
    chain, named = model.chain, dict(columns or {})
    found = {} if chain is None else chain_columns(chain, recording, named)
    if not found:
        _check_raw(model, recording, named)
    if chain is None or not found:
        return recording, named
    remarks = recording.remarks
    _one_kind(recording, [recording.channel(name) for name in found.values()], found[chain.axes[0]])
    unsaid = [name for axis in chain.axes if recording.channel(name := found[axis]).unit is None]
    if unsaid:
        what = f"columns without a unit, taken for counts of the model's chain: {', '.join(unsaid)}"
        remarks = (*remarks, Remark("taken_for_counts", "info", what, recording.source.path, len(unsaid)))
    if recording.channel(found[chain.axes[0]]).unit not in {None, "count"}:
        chain = from_output(chain)
    tested = {"validity", *(f"validity_{axis}" for axis in chain.axes)} & set(found)
    if chain.validity_minimum is not None and not tested:
        chain = replace(chain, validity_minimum=None)
        what = "no column of the built-in test: whether readings were good was not looked at"
        remarks = (*remarks, Remark("no_built_in_test", "info", what, recording.source.path))
    if missing := _missing_channels(chain, recording, found):
        raise DataError([missing, *_missing_conditions(model, recording, Taken({**found, **named}))])
    done = apply_chain(chain, replace(recording, remarks=remarks), found)
    unit = RANGE_UNIT[model.kind]
    shown = tuple(
        replace(one, data=convert(one.data, chain.unit, unit).copy(), unit=unit) if one.name in chain.axes else one
        for one in done.channels
    )
    inputs = {*chain.axes, *(f"temperature_{axis}" for axis in chain.axes)}
    made = {name: name for name in done.names if name in inputs}
    return replace(done, channels=shown), {what: name for what, name in named.items() if what not in found} | made


def _missing_channels(chain: Chain, recording: Recording, found: Mapping[str, str]) -> Problem | None:
    """Return the problem of channels of a chain that some axes have and others lack, or that none has."""
    missing = []
    for kind in CHANNELS:
        lack = [axis for axis in chain.axes if not {kind, f"{kind}_{axis}"} & set(found)]
        if kind == "reference" and chain.reference == "channel" and len(lack) == len(chain.axes):
            missing.append(kind)
        elif len(lack) < len(chain.axes):
            missing += [f"{kind}_{axis}" for axis in lack]
    if not missing:
        return None
    code = f"missing_{next(kind for kind in reversed(CHANNELS) if missing[0].startswith(kind))}"
    what, why = f"no channel {', '.join(missing)}", "the chain of the model takes one for each axis, or one for all"
    return Problem(what, recording.source.path, why, said_by_column(missing, recording), code)


def _check_raw(model: SensorModel, recording: Recording, named: Mapping[str, str]) -> None:
    """Refuse codes that the model does not start from, and codes of some axes only.

    Raises
    ------
    DataError
        ``no_chain``, ``wrong_column``.
    """
    columns = {axis: full_name(recording.names, named.get(axis, axis)) for axis in model.axes}
    if model.chain is not None:
        for axis in (axis for axis, name in columns.items() if name is None):
            alike = _raw_column(model.chain, recording, axis, {name for name in columns.values() if name})
            columns[axis] = None if alike is None else alike.name
    raw = [axis for axis, name in columns.items() if name and recording.channel(name).unit == "count"]
    if not raw or model.output_unit == "count":
        return
    where = recording.source.path
    if model.chain is None:
        raise DataError(
            f"the readings are in counts, and the model starts from {model.unit}: it has no chain", where,
            do="Make the model from a campaign that states its chain, or convert the readings", code="no_chain",
        )  # fmt: skip
    others = [axis for axis in model.axes if axis not in raw]
    raise DataError(
        f"{', '.join(raw)}: counts; {', '.join(others)}: none", where,
        why="the model takes all axes together, in the same unit",
        do=said_by_column(others, recording),
        code="wrong_column",
    )  # fmt: skip


def _one_kind(recording: Recording, used: Sequence[Channel], signal: str) -> None:
    """Refuse columns in volts and columns in counts beside each other.

    Raises
    ------
    DataError
        ``wrong_unit``.
    """
    counted = recording.channel(signal).unit in {None, "count"}
    kinds = {None, "count"} if counted else {one.unit for one in used if one.unit not in {None, "count"}}
    wrong = [f"{one.name} [{one.unit or 'no unit'}]" for one in used if one.unit not in kinds]
    if wrong:
        unit = recording.channel(signal).unit or "count"
        raise DataError(
            f"{', '.join(wrong)} beside {signal} [{unit}]", recording.source.path,
            why="what the chain takes together is all in counts, or all in volts",
            do="Convert them, or say the unit of those that have none: --unit NAME=V",
            code="wrong_unit",
        )  # fmt: skip


def _columns_of(model: SensorModel, recording: Recording, axis: str) -> list[str]:
    """Return the columns whose header tells quantity and axis; of the axis alone if their unit is one of input."""
    own = QUANTITY[model.unit]
    candidates = [c for c in recording.channels if c.axis == axis and not c.name.startswith(UNCERTAINTY)]
    found = [c for c in candidates if c.quantity == own]
    found = found or [c for c in candidates if not c.quantity and c.unit and same_dimension(c.unit, model.unit)]
    found = found or _only_column(recording, model.axes, [model.unit, model.output_unit])
    return [one.name for one in found]


def _only_column(
    recording: Recording, axes: Sequence[str], units: Sequence[str], taken: Set[str] = frozenset()
) -> list[Channel]:
    """Return the column of a model of one axis: the only one in such a unit, whose header names no other axis."""
    found = [one for one in recording.channels if one.unit and one.name not in taken
             and any(same_dimension(one.unit, unit) for unit in units)]  # fmt: skip
    return found if len(axes) == len(found) == 1 and found[0].axis in ("", *axes) else []


def _unclear(model: SensorModel, recording: Recording, unclear: Mapping[str, Sequence[str]]) -> Problem:
    """Return the problem of axes that have no column, or several."""
    none = [axis for axis, names in unclear.items() if not names]
    sensor = f"{'an' if model.kind == 'accelerometer' else 'a'} {model.kind}"
    said = [f"{len(names)} columns ({', '.join(names)}) can be the {axis} axis of {sensor}"
            for axis, names in unclear.items() if names]  # fmt: skip
    if none:
        axes = f"{none[0]} axis" if len(none) == 1 else f"axes {', '.join(none)}"
        said.append(f"no column is clearly the {axes} of {sensor}")
    return Problem("; ".join(said), recording.source.path, do=said_by_column(unclear, recording), code="wrong_column")


def said_by_column(inputs: Iterable[str], recording: Recording) -> str:
    """Return how the columns of inputs are named, all at once, and which columns there are."""
    return f"Say it: {' '.join(f'--column {one}=NAME' for one in inputs)}. The file has: {', '.join(recording.names)}"


def _fixed_temperature(recording: Recording, given: str | float) -> float:
    if not isinstance(given, str):
        return float(given)
    try:
        return parse_quantity(given).to("degC")
    except DataError:
        raise DataError(
            f"{given!r} is neither a column nor a temperature",
            where=recording.source.path,
            do=f'Name a column ({", ".join(recording.names)}), or write one like "25 degC"',
            code="no_temperature",
        ) from None

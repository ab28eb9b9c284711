"""A model applied to a recording, with what else the model needs to know, and with uncertainties if asked for.

Standard uncertainties stand in columns of their own, ``u_`` before the name.
"""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...core.batches import batches, empty, release
from ...core.errors import DataError, InertialcalError
from ...core.estimate import Array
from ...core.influence import lasting
from ...core.key import Reason
from ...core.recording import MARK, Channel, Recording
from ...core.remarks import Remark, gather
from ...core.results import Row, finite
from ...core.units import convert, factor, same_dimension
from ...files import read
from ...files.text.headers import full_name
from ...sensors.model.compensate import counted
from ...sensors.model.equation import Conditions, by_name, needed
from ...sensors.model.model_set import ModelSet
from ...sensors.model.on_recordings import compensate_recording, to_input_unit
from ...sensors.model.sensor_model import SensorModel, check_item, lines
from ...sensors.model.serial import model_checksum
from ...sensors.model.terms import values
from ...sensors.model.uncertainty import compensated_uncertainty, without_uncertainty
from ...statistics.intervals import t_interval
from .find import load_models
from .inputs import CONDITIONS, FORCES, UNCERTAINTY, Taken, all_missing, from_chain, no_unit, taken

FAR = 3.0  # times the largest input of a model, beyond which whole numbers are no inputs
CUT = "Cut out the rows of one condition: inertialcal convert DATA OUT --from --to"


def compensate(
    model: SensorModel | ModelSet | str | Path,
    recording: Recording | str | Path | Array,
    columns: Mapping[str, str] | None = None,
    *,
    units: Mapping[str, str] | None = None,
    sample_rate: float | None = None,
    temperature: str | float | None = None,
    serial: str | None = None,
    uncertainty: bool = False,
    condition: str | None = None,
) -> Recording:
    """Return the recording with the true inputs in place of the readings; time, gaps and other channels stay.

    Parameters
    ----------
    model : SensorModel, ModelSet or path
        As ``load_model`` gives it, or ``load_models``: the one of the condition is applied; or the file of either.
    recording : Recording, path, or array of shape (n, axes)
        With readings in units of input (deg/s, g, ...) or output (V, count/s); in counts where the model has a chain.
    columns, temperature
        As `taken`.
    units, sample_rate
        Of a file or an array, as ``read`` takes them.
    serial : str, optional
        Serial number of the sensor that gave the data, to be checked against that of the model.
    uncertainty : bool
        Add a column with the standard uncertainty of each compensated one.
    condition : str, optional
        Whose model is applied; needed where there are several and the pressure of the data does not say.

    Raises
    ------
    UsageError
        ``condition_needed``, ``no_such_condition``.
    DataError
        ``wrong_condition``, ``already_compensated``, ``wrong_serial``, ``wrong_unit``, ``no_unit``,
        ``wrong_column``, ``no_temperature``, ``missing_condition``, ``not_unique``, ``not_invertible``,
        ``no_validity_range``, ``no_covariance``.
    """
    if isinstance(model, str | Path):
        model = load_models(model)
    recording = read(recording, units=units, sample_rate=sample_rate)
    if recording.compensated_by:
        raise DataError(
            f"already compensated by model {recording.compensated_by}",
            where=recording.source.path,
            why="a second compensation would subtract the bias and divide by the scale factor again",
            do="Compensate the raw recording",
            code="already_compensated",
        )
    model = settled_model(model, recording, columns, temperature, condition)
    check_item(model, serial=serial)
    recording, columns = from_chain(model, recording, columns)
    chosen = taken(model, recording, columns, temperature)
    axes = {axis: chosen.columns[axis] for axis in model.axes}
    # Refuse axes in a unit of another kind, with the file and the way out
    for name in axes.values():
        try:
            check_item(model, unit=recording.channel(name).unit)
        except DataError as error:
            problem = replace(error.problems[0], where=recording.source.path)
            raise DataError(replace(problem, what=f"column {name!r}: {problem.what}")) from None
    _check_whole_numbers(model, recording, axes)
    done = _in_batches(model, recording, chosen, axes, uncertainty)
    unchecked = _unchecked(model, recording, columns or {})
    remarks = (*done.remarks, *unchecked, *_about(model, chosen), *(_about_uncertainty(model) if uncertainty else ()))
    by = model_checksum(model).removeprefix("sha256:")[:MARK]
    return replace(done, remarks=remarks, compensated_by=by)


def _check_whole_numbers(model: SensorModel, recording: Recording, axes: Mapping[str, str]) -> None:
    """Refuse whole numbers in a unit of input that lie far beyond the inputs of the model: counts under that header.

    Raises
    ------
    DataError
        ``not_readings``.
    """
    if model.input_range is None:
        return
    largest = float(np.abs(model.input_range).max())
    channels = [recording.channel(name) for name in axes.values()]
    far = [one for one in channels
           if one.data.dtype.kind in "iu" and one.unit and same_dimension(one.unit, model.unit) and len(one.data)
           and float(np.median(np.abs(convert(one.data, one.unit, model.unit)))) > FAR * largest > 0.0]  # fmt: skip
    if far:
        unit = str(far[0].unit)
        units = " ".join(f"--unit {shlex.quote(f'{one.name}=count')}" for one in channels)
        names, level = ", ".join(one.name for one in far), np.median(np.abs(far[0].data))
        raise DataError(
            f"{names}: whole numbers of {level:g} {unit} and more, "
            f"where the model was made for up to {convert(largest, model.unit, unit):.4g} {unit}",
            recording.source.path,
            why=f"they are counts rather than {unit}",
            do=f"Correct the header, or say: {units}",
            code="not_readings",
        )


def _in_batches(
    model: SensorModel, recording: Recording, chosen: Taken, axes: Mapping[str, str], uncertainty: bool
) -> Recording:
    """Return the recording with true inputs: no row needs another one, so a batch of them is in memory at once."""
    columns: dict[str, Channel] = {}
    outside: list[Remark] = []
    lost: list[Remark] = []
    bare = replace(recording, remarks=(), time_ns=None)
    for first, stop in batches(*(one.data for one in recording.channels)):
        part = replace(bare, channels=tuple(replace(one, data=one.data[first:stop]) for one in recording.channels))
        conditions = _conditions(model, part, chosen)
        done = compensate_recording(model, part, axes, part=True, **conditions)
        for found, own in ((outside, done.remarks), (lost, emptied(part, done, axes, conditions))):
            found += [replace(one, where=recording.place(first + one.index), index=first + one.index) for one in own]
        made = [done.channel(name) for name in axes.values()]
        made += _uncertainties(model, part, done, axes, conditions) if uncertainty else []
        for one in made:
            known = columns.setdefault(one.name, replace(one, data=empty(len(recording), one.data.dtype)))
            known.data[first:stop] = one.data
            release(known.data[first:stop])
    channels = [columns.pop(one.name, one) for one in recording.channels]
    remarks = (*recording.remarks, *(counted(one, len(recording)) for one in gather(outside)), *gather(lost))
    return replace(recording, channels=(*channels, *columns.values()), remarks=remarks)


def settled_model(
    models: SensorModel | ModelSet,
    recording: Recording,
    columns: Mapping[str, str] | None,
    temperature: str | float | None,
    condition: str | None,
) -> SensorModel:
    """Return the model of the condition, as `model_for`; where it is not known, refuse all else that is missing too."""
    try:
        return model_for(models, recording, columns, condition)
    except InertialcalError as error:
        if not {one.code for one in error.problems} & {"condition_needed", "no_unit", "wrong_column"}:
            raise
        first = next(iter(models.values())) if isinstance(models, ModelSet) else models
        said = {one.what for one in error.problems}
        others = [one for one in all_missing(first, recording, columns, temperature) if one.what not in said]
        raise type(error)([*error.problems, *others]) from None


def model_for(
    models: SensorModel | ModelSet,
    recording: Recording,
    columns: Mapping[str, str] | None = None,
    condition: str | None = None,
) -> SensorModel:
    """Return the model of the condition that a recording was made in.

    It is the one that is named; else the only one; else the one whose range of pressure holds every pressure of the
    recording. Pressure is the column named for it, that of the name ``pressure``, or the only one whose header says so.

    Raises
    ------
    UsageError
        ``condition_needed`` where there are several and the pressure does not say; ``no_such_condition``.
    DataError
        ``wrong_condition`` for pressures outside the range of the model's condition, or of every model; ``no_unit`` for
        a pressure without one; ``wrong_column`` where several columns can be the pressure.
    """
    every = models if isinstance(models, ModelSet) else ModelSet((models,))
    ranged = any(one.pressure_range is not None for one in every.values())
    pressure = _pressure(recording, columns or {}) if ranged else None
    known = np.empty(0) if pressure is None else pressure[np.isfinite(pressure)]
    fitting = [name for name, one in every.items() if len(known) and not _outside(one, known).any()]
    fitting = [name for name in fitting if every[name].pressure_range is not None]
    if condition is None and len(every) > 1 and len(fitting) == 1:
        return every[fitting[0]]
    if (
        condition is None
        and len(every) > 1
        and len(known)
        and all(_outside(one, known).any() for one in every.values())
    ):
        inside = {name: int(np.count_nonzero(~_outside(one, known))) for name, one in every.items()}
        counts = ", ".join(f"{count} in {name}" for name, count in inside.items())
        raise DataError(
            f"no model holds for all pressures, {known.min():.4g} to {known.max():.4g} Pa: of {len(known)} row(s) lie "
            f"{counts}",
            recording.source.path,
            why="bias and its change with temperature differ between conditions",
            do=CUT if any(inside.values()) else "Test the sensor at these pressures",
            code="wrong_condition",
        )
    model = every.only(condition, recording.source.path)
    beyond = _outside(model, known) if model.condition else np.zeros(0, dtype=bool)
    if beyond.any() and model.pressure_range is not None:
        lo, hi = model.pressure_range
        count, at = int(np.count_nonzero(beyond)), float(known[np.argmax(beyond)])
        fits = (
            f"These data fit: --condition {fitting[0]}" if len(fitting) == 1 else f"No condition fits all rows. {CUT}"
        )
        raise DataError(
            f"{count} of {len(recording)} row(s) were not made in condition {model.condition!r}: pressure {at:.4g} Pa, "
            f"the model holds for {lo:.4g} to {hi:.4g} Pa",
            recording.source.path,
            why="bias and its change with temperature differ between conditions",
            do=fits if len(every) > 1 else f"The file has no other model than that of {model.condition!r}",
            code="wrong_condition",
        )
    return model


def _pressure(recording: Recording, columns: Mapping[str, str]) -> Array | None:
    """Return pressures [Pa] of the column named for it, of that name, or of the only one; None without one."""
    named = columns.get("pressure", "pressure")
    column = full_name(recording.names, named)
    names = [one.name for one in recording.channels if one.quantity == "pressure" and one.unit]
    if column is None and "pressure" in columns:
        column = recording.channel(named).name
    if column is None and len(names) > 1:
        raise DataError(
            f"{len(names)} columns ({', '.join(names)}) can be the pressure",
            recording.source.path,
            why="it says which model holds",
            do="Say it: --column pressure=NAME",
            code="wrong_column",
        )
    column = column or next(iter(names), None)
    return None if column is None else _in_unit(recording, column, "Pa")


def _unchecked(model: SensorModel, recording: Recording, columns: Mapping[str, str]) -> list[Remark]:
    """Return the remark that counts the rows whose pressure, and so whose condition, is not known."""
    if not model.condition or model.pressure_range is None:
        return []
    pressure = _pressure(recording, columns)
    rows = len(recording) if pressure is None else int(np.count_nonzero(~np.isfinite(pressure)))
    what = f"pressure not known: that the readings were made in {model.condition} was not checked"
    return [Remark("condition_not_checked", "info", what, recording.source.path, rows)] if rows else []


def _outside(model: SensorModel, pressure: Array) -> NDArray[np.bool_]:
    if model.pressure_range is None:
        return np.zeros(len(pressure), dtype=bool)
    return (pressure < model.pressure_range[0]) | (pressure > model.pressure_range[1])


def emptied(raw: Recording, done: Recording, axes: Mapping[str, str], conditions: Conditions) -> tuple[Remark, ...]:
    """Return remarks that count the readings lost because something else of their row is missing.

    Parameters
    ----------
    raw, done : Recording
        Before and after compensation.
    axes : mapping of str to str
        Axis -> name of the column.
    conditions : Conditions
        As they were used.
    """
    names = list(axes.values())
    missing = np.isnan(raw.array(names))
    lost = np.isnan(done.array(names)) & ~missing
    unknown = np.zeros(len(raw), dtype=bool)
    for given in by_name(conditions).values():
        columns = np.asarray(given, dtype=float)
        if columns.ndim and len(columns) == len(raw):
            unknown |= np.isnan(columns.reshape(len(raw), -1)).any(axis=1)
    by_axis = lost.any(axis=1) & missing.any(axis=1) & ~unknown
    found = []
    for code, text, rows in (
        ("axis_missing", "the reading of one axis is missing, so others that it enters are left empty", by_axis),
        ("condition_missing", "a condition is missing that the model needs: left empty", lost.any(axis=1) & unknown),
    ):
        if rows.any():
            first = int(np.argmax(rows))
            found.append(Remark(code, "warning", text, raw.place(first), int(np.count_nonzero(rows)), index=first))
    return tuple(found)


def _conditions(model: SensorModel, recording: Recording, chosen: Taken) -> Conditions:
    """Return what the terms of the model need, from columns or fixed."""
    needs = needed(model)
    found: Conditions = {}
    for name, unit in CONDITIONS.items():
        if name not in needs:
            continue
        values = _condition(recording, chosen.columns, name, unit, model.axes)
        if values is not None:
            found[name] = values  # type: ignore[literal-required]
    if "temperature" in needs and "temperature" not in found:
        assert chosen.temperature is not None  # noqa: S101 - else it is missing
        found["temperature"] = chosen.temperature
    if "specific_force" in needs and all(name in chosen.columns for name in FORCES):
        columns = [_in_unit(recording, chosen.columns[name], "m/s^2") for name in FORCES]
        found["specific_force"] = np.column_stack(columns)
    channels = {
        one.channel: _in_unit(recording, chosen.columns[one.channel], one.unit)
        for one in model.sensitivities
        if one.channel in chosen.columns and one.channel not in CONDITIONS
    }
    if channels:
        found["channels"] = channels
    return found


def _condition(
    recording: Recording, columns: Mapping[str, str], name: str, unit: str, axes: tuple[str, ...]
) -> Array | None:
    """Return a condition, one for all sensors, shape (n,), or one a sensor, shape (n, k); None where not told."""
    each = [columns.get(f"{name}_{axis}", columns.get(name)) for axis in axes]
    if any(column is None for column in each):
        return None
    if len(set(each)) == 1:
        return _in_unit(recording, str(each[0]), unit)
    return np.column_stack([_in_unit(recording, str(column), unit) for column in each])


def _in_unit(recording: Recording, name: str, unit: str) -> Array:
    channel = recording.channel(name)
    if channel.unit is None:
        raise DataError(no_unit(recording, name, unit))
    values = recording.array([name])[:, 0]
    if unit == "degC/s":
        return values * factor(channel.unit, unit, difference=True)
    try:
        return convert(values, channel.unit, unit)
    except DataError as error:
        what = f"column {name!r}: {error.problems[0].what}"
        raise DataError(replace(error.problems[0], what=what, where=recording.source.path)) from None


def _about(model: SensorModel, chosen: Taken) -> list[Remark]:
    """Remarks on the model: not judged, or without a term in what was given."""
    remarks = []
    if not model.judged:
        what = "recordings held out have not confirmed the model: how well it does on other data is not known"
        remarks.append(Remark("unjudged_model", "info", what))
    ends = [] if model.input_range is None else zip(model.axes, model.input_range, strict=True)
    if still := [axis for axis, (low, high) in ends if low == high]:
        what = f"{', '.join(still)}: no input was applied in the test, so the scale factor is the nominal one"
        remarks.append(Remark("axis_not_moved", "info", what, do="Move these axes, too"))
    given = set(chosen.columns) - set(model.axes) | ({"temperature"} if chosen.temperature is not None else set())
    needs = {*needed(model), *(() if model.pressure_range is None else ("pressure",))}
    own = {f"temperature_{axis}": "temperature" for axis in model.axes} | dict.fromkeys(FORCES, "specific_force")
    unused = sorted(name for name in given if own.get(name, name) not in needs)
    if unused:
        what = f"not used, because the model has no term in it: {', '.join(unused)}"
        remarks.append(Remark("condition_not_used", "info", what, count=len(unused)))
    return remarks


def _uncertainties(
    model: SensorModel, raw: Recording, done: Recording, axes: Mapping[str, str], conditions: Conditions
) -> list[Channel]:
    """Return the standard uncertainty of each compensated channel."""
    readings = to_input_unit(model, [raw.channel(name) for name in axes.values()])
    u = compensated_uncertainty(model, readings, **conditions)
    made = []
    for i, (axis, name) in enumerate(axes.items()):
        unit = str(done.channel(name).unit)
        made.append(Channel(f"{UNCERTAINTY}{name}", u[:, i] * factor(model.unit, unit), unit, "model", axis))
    return made


def _about_uncertainty(model: SensorModel) -> list[Remark]:
    """Remarks on what the uncertainties hold."""
    exact = without_uncertainty(model)
    remarks = [Remark("noise_not_included", "info", "uncertainties are those of the model: noise of the reading, and "
                      "the uncertainty of the conditions, come on top")]  # fmt: skip
    if exact:
        what = f"parameters without uncertainty, which count as exact: {', '.join(exact)}"
        remarks.append(Remark("counted_as_exact", "warning", what, count=len(exact)))
    return remarks


def model_rows(model: SensorModel) -> tuple[Row, ...]:
    """Return a row a parameter, in SI and with full digits, in the order of the equation."""
    dofs = {} if model.estimate is None else dict(zip(model.estimate.names, model.estimate.dof, strict=True))
    numbers = values(model.parameters, model.terms)
    rows = []
    for one, value, line in zip(model.parameters, numbers, lines(model), strict=True):
        dof = float(dofs.get(one.name, np.nan))
        origin = model.provenance.get(one.name)
        rows.append(
            Row(
                one.key,
                float(value),
                line.u,
                one.unit,
                finite(dof),
                (t_interval(float(value), line.u, dof) if line.u is not None and dof > 0.0 else None),
                "not_estimated" if line.u is None else "estimated",
                Reason("note", line.note),
                condition=model.condition,
                test=origin.test if origin is not None else "",
                shared={}
                if model.estimate is None or line.u is None
                else lasting(model.estimate.shared(one.name), line.u, model.influences),
                curvature={} if model.estimate is None or line.u is None else model.estimate.curvature(one.name),
            )
        )
    return tuple(rows)

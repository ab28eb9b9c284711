"""Readings of a mass-attraction calibration: recordings with the schedule of the mass, or a table of reduced runs."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ..core.errors import DataError, PlanError
from ..core.influence import Standards
from ..core.recording import Channel, Recording
from ..core.times import read_elapsed, read_instant
from ..core.units import factor, parse_quantity
from ..files.source import load
from ..files.text.table import Table, read_table
from ..procedures.mass_attraction import reduction as procedure
from ..procedures.mass_attraction.recordings import READING, TEMPERATURE, TILT
from ..procedures.mass_attraction.schedule_csv import read_schedule
from ..sensors.chain.converter import Chain
from .chains import build_chain
from .channels import chain_of, in_body_axes, raw_recording
from .load import Campaign
from .modelling import Prepared
from .origins import Origin
from .plans import plan_values
from .schema import Test
from .schema_recordings import Lines, RecordingEntry
from .schema_sensors import Sensor

SAME = 0.01  # relative difference of gate and averaging time that is none
YES, NO = ("yes", "true", "1"), ("no", "false", "0")


def prepared_mass_attraction(campaign: Campaign, test: Test, sensor: Sensor) -> Prepared:
    """Return a mass-attraction calibration ready to be reduced.

    Raises
    ------
    PlanError, DataError
        If a recording, a schedule or the plan cannot be read.
    """
    plan = mass_plan(test, sensor, campaign.standards)
    moved: list[procedure.Moved] = []
    lines: list[procedure.Line] = []
    inputs: dict[str, str] = {}
    origins: list[Origin] = []
    for name in test.recordings:
        entry = campaign.file.recordings[name]
        if entry.lines is not None:
            table = read_table(campaign.folder / entry.file)
            found = lines_of(table, entry.lines, entry.file)
            chosen = [one for one in found if test.groups is None or one.name in test.groups]
            lines += chosen
            inputs[entry.file] = table.source.sha256
            origins.append(Origin(name, entry.file, table.source.sha256, "table", len(table), len(chosen)))
            continue
        raw = raw_recording(campaign.folder, entry, complete=False)
        raw = replace(raw, source=replace(raw.source, path=entry.file))
        assert entry.mass is not None  # noqa: S101 - the cross checks ask for it
        path = campaign.folder / entry.mass.schedule
        moved.append(moved_mass(raw, name, entry, sensor, chain_of(entry, sensor), read_schedule(path)))
        inputs[entry.file] = raw.source.sha256
        inputs[entry.mass.schedule] = load(path).sha256
        origins.append(Origin(name, entry.file, raw.source.sha256, "recording", len(raw), len(raw)))
    if not moved and not lines:
        raise DataError(f"test {test.id!r}: no row is in its groups", code="nothing_left")
    readings = procedure.readings_from(plan, moved)
    return Prepared(test, plan, replace(readings, lines=tuple(lines)), inputs, tuple(origins))


def mass_plan(test: Test, sensor: Sensor, standards: Standards) -> procedure.Plan:
    """Return the plan of a test, with the sensor and the standards of the campaign.

    Raises
    ------
    PlanError
        If a setting is wrong.
    """
    values, problems = plan_values(test.procedure, test.plan, "")
    if problems:
        raise PlanError(problems)
    axis = sensor.axes[0]
    return procedure.Plan(**values, axis=axis, nominal=_nominal(sensor), standards=standards)


def _nominal(sensor: Sensor) -> float | None:
    """Return the scale factor of the chain [count/s/(m/s^2)]; None where there is none."""
    if sensor.chain.kind != "pulse_rate":
        return None
    given = build_chain(sensor).scale_factor
    return None if given is None else float(np.ravel(given)[0])


def moved_mass(
    raw: Recording, name: str, entry: RecordingEntry, sensor: Sensor, chain: Chain | None, schedule: procedure.Schedule
) -> procedure.Moved:
    """Return a recording as ``mass_attraction`` wants it: pulses a second, tilt [rad], temperature [degC].

    Parameters
    ----------
    raw : Recording
        As the file has it.
    name, entry : str, RecordingEntry
        Of the recording.
    sensor : Sensor
        Whose chain applies.
    chain : Chain or None
        Of the axes that it has.
    schedule : Schedule
        Of the mass.

    Raises
    ------
    DataError
        ``gate_disagrees`` if gate and averaging time differ; as ``channels.in_body_axes``.
    """
    gate = float(sensor.chain.gate or 0.0)
    averaging = None if entry.clock is None else entry.clock.averaging
    if averaging is not None and abs(averaging / gate - 1.0) > SAME:
        what = f"recordings.{name}: clock.averaging is {averaging:g} s, the gate of the chain {gate:g} s"
        why = "pulses are counted for the gate: the scale factor would be wrong by their ratio"
        raise DataError(what, entry.file, why, "Mend the one that is wrong", "gate_disagrees")
    body = in_body_axes(raw, name, entry, sensor, chain)
    axis = next(one for one in sensor.axes if one in (entry.channels or {}))
    rate = np.asarray(body.channel(axis).data, dtype=np.float64) * (_nominal(sensor) or 1.0)
    kept = tuple(body.channel(one) for one in (TILT, TEMPERATURE) if one in body.names)
    made = (Channel(READING, rate, "count/s", "chain", axis), *kept)
    found = replace(body, channels=made, averaging_time=averaging or gate)
    assert entry.mass is not None  # noqa: S101 - the cross checks ask for it
    begin = _begin(entry.mass.begin, found, name)
    return procedure.Moved(found, schedule, begin, entry.run or name, entry.mass.moved)


def _begin(given: str | int | float | None, recording: Recording, name: str) -> int | None:
    """Return when the schedule starts, on the clock of the recording [ns]."""
    if given is None:
        return None
    try:
        return read_instant(given) if recording.epoch == "utc" else read_elapsed(given)
    except ValueError as error:
        clock = "UTC" if recording.epoch == "utc" else "elapsed time, without a date"
        why = f"the clock of {recording.source.path or name} is {clock}"
        raise DataError(f"recordings.{name}.mass.begin: {error}", why=why, code="wrong_time") from None


def lines_of(table: Table, lines: Lines, file: str) -> list[procedure.Line]:
    """Return the runs of a table that was reduced before, a row each, SI.

    Raises
    ------
    DataError
        If a column is missing, or a cell that is needed is empty or no number.
    """
    applied = table.numbers(lines.applied) * factor(lines.applied_unit, "m/s^2")
    scale = factor(lines.unit, "count/s")
    columns = {
        what: np.full(len(table), math.nan) if column is None else table.numbers(column) * scale
        for what, column in (
            ("response", lines.response), ("noise", lines.noise), ("psd_response", lines.psd_response),
            ("psd_noise", lines.psd_noise), ("scatter", lines.scatter),
        )
    }  # fmt: skip
    u = 0.0 if lines.u_applied is None else parse_quantity(lines.u_applied).to("m/s^2", difference=True)
    moved = table.text(lines.moved) if lines.moved else ("yes",) * len(table)
    strokes = [a for a, cell in zip(applied.tolist(), moved, strict=True) if cell.lower() in YES and a > 0.0]
    found = []
    for i, name in enumerate(table.text(lines.run)):
        where = f"{file}:{table.rows[i]}"
        is_moved = _is_yes(moved[i], lines.moved or "", where)
        amplitude = float(applied[i]) if is_moved else (strokes[0] if strokes else math.nan)
        _check_row(amplitude, columns["response"][i], columns["noise"][i], where)
        found.append(
            procedure.Line(
                name, amplitude, beside=lines.beside, u_applied=u / amplitude, moved=is_moved, where=where,
                **{what: float(values[i]) for what, values in columns.items()},
            )
        )  # fmt: skip
    return found


def _is_yes(cell: str, column: str, where: str) -> bool:
    word = cell.strip().lower()
    if word not in (*YES, *NO):
        raise DataError(f"column {column!r}: {cell!r}", where, do="Write yes or no", code="wrong_value")
    return word in YES


def _check_row(applied: float, response: float, noise: float, where: str) -> None:
    if not (applied > 0.0 and math.isfinite(response) and noise > 0.0):
        what = f"applied {applied:g} m/s^2, response {response:g}, noise {noise:g} count/s"
        raise DataError(what, where, "a run needs all three, noise and applied above zero", code="missing_value")

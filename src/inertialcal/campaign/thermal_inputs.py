"""Readings of a thermal test: recordings of a unit at rest, with temperatures and reference voltages of its sensors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ..core.axes import AXES
from ..core.errors import DataError, PlanError
from ..core.influence import Standards
from ..core.recording import Channel, Recording
from ..procedures.thermal import reduction as thermal
from ..procedures.thermal.recordings import REFERENCES, Warmed, readings_from
from ..sensors.chain.converter import Chain
from .chains import body_scale_factors, build_chain
from .channels import TEMPERATURE, chain_of, in_body_axes, raw_recording, windowed
from .load import Campaign
from .modelling import Prepared
from .origins import Origin
from .plans import plan_values
from .schema import CampaignFile, Test
from .schema_recordings import RecordingEntry
from .schema_sensors import Sensor

COUNTED = dict(zip(REFERENCES, ("reference", "temperature_reference"), strict=True))  # voltage -> channel of its codes


def prepared_thermal(campaign: Campaign, test: Test, sensor: Sensor) -> Prepared:
    """Return a thermal test ready to be reduced.

    Raises
    ------
    PlanError, DataError
        If a recording cannot be read, or the plan.
    """
    plan = thermal_plan(campaign.file, campaign.standards, test, sensor)
    warmed, inputs, origins = [], {}, []
    for name in test.recordings:
        entry = campaign.file.recordings[name]
        raw = raw_recording(campaign.folder, entry)
        whole = warmed_recording(raw, name, entry, sensor, chain_of(entry, sensor))
        one = windowed(whole.recording, test)
        one = replace(one, source=replace(one.source, path=entry.file))
        warmed.append(replace(whole, recording=one))
        inputs[entry.file] = raw.source.sha256
        origins.append(Origin(name, entry.file, raw.source.sha256, "recording", len(raw), len(one)))
    return Prepared(test, plan, readings_from(warmed), inputs, tuple(origins))


def thermal_plan(file: CampaignFile, standards: Standards, test: Test, sensor: Sensor) -> thermal.Plan:
    """Return the plan of a test, with what the sensor and the campaign say.

    Raises
    ------
    PlanError
        If a setting is wrong.
    """
    values, problems = plan_values(test.procedure, test.plan, "")
    if problems:
        raise PlanError(problems)
    return thermal.Plan(
        **values,
        latitude=file.site.latitude,
        thermometers=_thermometers(sensor),
        scale_factor=body_scale_factors(sensor),
        standards=standards,
    )


def warmed_recording(raw: Recording, name: str, entry: RecordingEntry, sensor: Sensor, chain: Chain | None) -> Warmed:
    """Return a recording as ``thermal`` wants it: body axes, SI, temperature and reference voltages by body axis.

    Parameters
    ----------
    raw : Recording
        As the file has it.
    name, entry : str, RecordingEntry
        Of the recording.
    sensor : Sensor
        Whose chain and mounting apply.
    chain : Chain or None
        Of the axes that it has, as `chain_of` gives it.

    Raises
    ------
    DataError
        As ``channels.in_body_axes``; or if the mounting mixes sensors, so that no temperature is that of a body axis.
    """
    body = in_body_axes(raw, name, entry, sensor, chain)
    made = (*body.channels, *_reference_voltages(raw, entry, chain))
    return Warmed(felt_in_body(replace(body, channels=made), entry, sensor), entry.run or "", name)


def felt_in_body(recording: Recording, entry: RecordingEntry, sensor: Sensor) -> Recording:
    """Return a recording with temperatures and reference voltages named by the body axis of their sensor.

    Raises
    ------
    DataError
        If the mounting mixes sensors, so that no temperature is that of a body axis.
    """
    felt = felt_axes(sensor)
    if felt is None and any(name.startswith(f"{TEMPERATURE}_") for name in recording.names):
        what = "the mounting mixes sensors: no thermometer is that of one body axis"
        raise DataError(what, entry.file, do="Give one channel temperature, or a mounting without mixing")
    names = _renamed(felt or {})
    return replace(
        recording, channels=tuple(replace(one, name=names.get(one.name, one.name)) for one in recording.channels)
    )


def felt_axes(sensor: Sensor) -> dict[str, str] | None:
    """Return the sensor that feels each body axis; None where the mounting mixes them."""
    if sensor.mounting is None:
        return {axis: axis for axis in sensor.axes}
    size = np.abs(np.array(sensor.mounting))
    if not np.all(np.isclose(size, 0.0) | np.isclose(size, 1.0)):
        return None
    return {AXES[body]: AXES[int(np.argmax(size[:, body]))] for body in range(3)}


def _renamed(felt: Mapping[str, str]) -> dict[str, str]:
    """Return the new names of channels of one sensor each."""
    return {
        f"{stem}_{sensed}": f"{stem}_{body}" for stem in (TEMPERATURE, *REFERENCES) for body, sensed in felt.items()
    }


def _reference_voltages(raw: Recording, entry: RecordingEntry, chain: Chain | None) -> list[Channel]:
    """Return the reference voltages of the sensors [V], NaN at the ends of the converter."""
    if chain is None or chain.output_unit != "V":
        return []
    found = []
    for voltage, counted in COUNTED.items():
        for axis in chain.axes:
            named = (entry.channels or {}).get(f"{counted}_{axis}")
            if named is not None:
                codes = np.asarray(raw.channel(named.column).data, dtype=np.float64)
                volts = chain.step * codes
                if chain.codes is not None:
                    volts = np.where((codes > chain.codes[0]) & (codes < chain.codes[1]), volts, np.nan)
                found.append(Channel(f"{voltage}_{axis}", volts, "V", "chain", axis))
    return found


def _thermometers(sensor: Sensor) -> dict[str, thermal.Thermometer] | None:
    """Temperature channels by body axis; None where there is none, or the mounting mixes sensors."""
    felt = felt_axes(sensor)
    if sensor.chain.kind != "adc" or sensor.chain.thermometer is None or felt is None:
        return None
    chain = build_chain(sensor)
    given = chain.thermometer
    if given is None:
        return None
    k = len(chain.axes)
    columns = (np.broadcast_to(one, k) for one in (given.slope, given.voltage, given.temperature))
    own = {axis: thermal.Thermometer(*map(float, row)) for axis, *row in zip(chain.axes, *columns, strict=True)}
    return {body: own[sensed] for body, sensed in felt.items() if sensed in own}

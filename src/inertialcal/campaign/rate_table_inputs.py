"""Readings of a rate table: of reduced tables, of recordings, or of both."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..core.errors import PlanError
from ..core.influence import Standards
from ..core.units import parse_quantity, si_unit
from ..files.text.table import Table
from ..procedures.rate_table import reduction as rate_table
from ..procedures.rate_table.recordings import Turned, readings_from
from .after import Bias, without_bias
from .chains import body_scale_factors
from .channels import turned_recording
from .load import Campaign
from .modelling import Prepared
from .origins import Origin
from .plans import plan_values
from .schema import CampaignFile, Test
from .schema_recordings import RecordingEntry
from .schema_sensors import Sensor
from .tables import rate_table_readings, together
from .thermal_inputs import felt_in_body


def prepared_rate_table(campaign: Campaign, test: Test, sensor: Sensor, bias: Bias | None = None) -> Prepared:
    """Return a rate-table test ready to be reduced.

    Raises
    ------
    PlanError, DataError
        If a recording cannot be read, or the plan.
    """
    plan = rate_table_plan(campaign.file, campaign.standards, test, sensor)
    readings, inputs, origins = test_readings(campaign, test, sensor, plan, bias)
    return Prepared(test, plan, readings, inputs, origins)


def test_readings(
    campaign: Campaign, test: Test, sensor: Sensor, plan: rate_table.Plan, bias: Bias | None
) -> tuple[rate_table.Readings, dict[str, str], tuple[Origin, ...]]:
    """Return the readings of all recordings of a test, SHA-256 of their files by path, and the recordings.

    `bias` is what is taken off recordings first.
    """
    parts: list[rate_table.Readings] = []
    turned: list[Turned] = []
    inputs: dict[str, str] = {}
    origins: list[Origin] = []
    for name in test.recordings:
        entry = campaign.file.recordings[name]
        if entry.rows is None:
            one, hashes, origin = turned_recording(campaign.folder, name, entry, sensor, test)
            if bias is not None:
                one = replace(one, recording=felt_in_body(one.recording, entry, sensor))
            turned.append(one)
            origins.append(origin)
            inputs |= hashes
        else:
            readings, table = rate_table_readings(campaign.folder, name, entry, sensor, test)
            parts.append(readings)
            inputs[entry.file] = table.source.sha256
            origins.append(_of_table(name, entry, table, len(readings)))
    if turned:
        parts.append(readings_from(plan, turned if bias is None else without_bias(turned, bias)))
    return together(parts), inputs, tuple(origins)


def _of_table(name: str, entry: RecordingEntry, table: Table, chosen: int) -> Origin:
    assert entry.rows is not None  # noqa: S101 - for the type checker
    without = int(np.count_nonzero(~np.isfinite(table.numbers(entry.rows.applied))))
    return Origin(name, entry.file, table.source.sha256, "table", len(table), chosen, without)


def rate_table_plan(file: CampaignFile, standards: Standards, test: Test, sensor: Sensor) -> rate_table.Plan:
    """Return the plan of a test, with what the sensor and the campaign say.

    Raises
    ------
    PlanError
        If a setting is wrong.
    """
    values, problems = plan_values(test.procedure, test.plan, "")
    if problems:
        raise PlanError(problems)
    si = si_unit(sensor.unit)
    ends = None if sensor.range is None else [parse_quantity(text).to(si) for text in sensor.range]
    volts = body_scale_factors(sensor)
    return rate_table.Plan(
        **values,
        input_range=None if ends is None else (min(ends), max(ends)),
        scale_factor=volts,
        latitude=file.site.latitude,
        standards=standards,
    )

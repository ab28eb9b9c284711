"""A simulated campaign reduced without files: the campaign file read from its text, the recordings from memory.

The steps are those of ``channels`` and ``run``: stamps to the middle of the averages, counts through the chain,
sensor axes to body axes, the plan of the test. A test holds both ways to the same figures.
"""

from __future__ import annotations

import tomllib
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from ..core.recording import SECOND, Channel, Recording
from ..core.units import factor, parse_quantity, si_unit
from ..procedures import rate_table
from ..procedures.rate_table.recordings import APPLIED, Turned, readings_from
from ..rigs.twin import SEED, Twin
from ..sensors.chain import Chain
from ..sensors.on_recordings import apply_chain
from .chains import build_chain, scale_factors
from .channels import AXES
from .plans import plan_values
from .schema import STANDARDS, CampaignFile, Clock, RecordingEntry, Sensor, Test


@dataclass(frozen=True, eq=False)
class _Fit:
    """A test of which a model is made, ready for recordings."""

    plan: rate_table.Plan
    sensor: Sensor
    chain: Chain
    entries: tuple[RecordingEntry, ...]


def fit_results(twin: Twin) -> list[rate_table.Result]:
    """Return the results of the tests of a twin that a model would be fitted on.

    Raises
    ------
    DataError
        As the chain and the procedure say, where the twin has a fault.
    """
    return [_result(twin, fit) for fit in _fits(twin.campaign)]


@lru_cache(4)
def _fits(text: str) -> tuple[_Fit, ...]:
    """Read the campaign file, which all seeds of a rig share."""
    file = CampaignFile.model_validate(tomllib.loads(text.replace(SEED, "0")))
    found = []
    for test in file.tests:
        if test.use == "fit":
            entries = tuple(file.recordings[name] for name in test.recordings)
            sensor = file.sensors[entries[0].sensor]
            found.append(_Fit(_plan(file, test, sensor), sensor, build_chain(sensor), entries))
    return tuple(found)


def _plan(file: CampaignFile, test: Test, sensor: Sensor) -> rate_table.Plan:
    values, _ = plan_values(test.procedure, test.plan, "")
    si = si_unit(sensor.unit)
    ends = sorted(parse_quantity(text).to(si) for text in sensor.range or ())
    factors = scale_factors(sensor, tuple(sensor.axes))
    return rate_table.Plan(
        **values,
        input_range=(ends[0], ends[-1]) if ends else None,
        scale_factor=None if factors is None else dict(zip(sensor.axes, factors.tolist(), strict=True)),
        latitude=file.site.latitude,
        standards={
            f"{standard}.{name}": entry.influence(STANDARDS[standard][name])
            for standard, quantities in file.standards.items()
            for name, entry in quantities.items()
        },
    )


def _result(twin: Twin, fit: _Fit) -> rate_table.Result:
    turned = [
        Turned(_body_rates(twin.recordings[entry.file], entry, fit), entry.axis or "", entry.run or "")
        for entry in fit.entries
    ]
    return rate_table.reduce(fit.plan, readings_from(fit.plan, turned))


def _body_rates(saved: Recording, entry: RecordingEntry, fit: _Fit) -> Recording:
    """Return saved codes as rates along the body axes, and the applied rate, SI, stamped in the middle."""
    channels, unit = entry.channels or {}, fit.chain.unit
    counts = {what: one.column for what, one in channels.items() if what != APPLIED}
    read = apply_chain(fit.chain, saved.with_unit(tuple(counts.values()), "count", "campaign"), counts)
    body = read.array(AXES)
    if fit.sensor.mounting is not None:
        body = body @ np.array(fit.sensor.mounting)  # sensor from body, so its transpose, on rows
    applied = saved.channel(channels[APPLIED].column).data * factor(channels[APPLIED].unit, unit)
    made = [Channel(axis, body[:, i].copy(), unit, "chain", axis) for i, axis in enumerate(AXES)]
    clock = entry.clock or Clock()
    shift = {"start": 0.5, "middle": 0.0, "end": -0.5}[clock.stamp] * (clock.averaging or 0.0)
    return replace(
        read,
        channels=(*made, Channel(APPLIED, applied, unit, "campaign")),
        time_ns=None if saved.time_ns is None else saved.time_ns + round(shift * SECOND),
        sample_interval=clock.interval,
        averaging_time=clock.averaging,
    )

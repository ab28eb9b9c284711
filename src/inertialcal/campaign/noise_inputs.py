"""Records of a sensor at rest, for its noise: recordings of channels, whole or in windows."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ..core.axes import AXES
from ..core.errors import DataError, PlanError
from ..core.influence import Standards
from ..core.recording import Recording
from ..core.remarks import Remark
from ..procedures.static_noise import reduction as static_noise
from .channels import prepare_recording, windowed
from .load import Campaign
from .modelling import Prepared
from .origins import Origin
from .plans import plan_values
from .schema import Test
from .schema_sensors import Sensor

MIXED = 1e-6  # of a direction cosine that is neither 0 nor 1


def prepared_static_noise(campaign: Campaign, test: Test, sensor: Sensor) -> Prepared:
    """Return a test of noise ready to be reduced.

    Parameters
    ----------
    campaign : Campaign
        As read.
    test : Test
        Its entry.
    sensor : Sensor
        That it is about.

    Raises
    ------
    PlanError, DataError
        If a recording cannot be read, or the plan.
    """
    plan = noise_plan(test, sensor, campaign.standards)
    found: list[static_noise.AtRest] = []
    inputs: dict[str, str] = {}
    origins: list[Origin] = []
    for name in test.recordings:
        entry = campaign.file.recordings[name]
        whole = prepare_recording(campaign.folder, name, entry, sensor, keep_bias=True, complete=False)
        own = records_at_rest(whole, name, sensor.unit, test)
        chosen = sum(len(one.recording) for one in own)
        found += own
        inputs[entry.file] = whole.source.sha256
        origins.append(Origin(name, entry.file, whole.source.sha256, "recording", len(whole), chosen))
    readings = static_noise.readings_from(plan, found)
    static_noise.check(plan, readings)
    readings = replace(readings, remarks=(*readings.remarks, *_mixed(sensor)))
    return Prepared(test, plan, readings, inputs, tuple(origins))


def noise_plan(test: Test, sensor: Sensor, standards: Standards) -> static_noise.Plan:
    """Return the plan of a test, with the sensor and the standards of the campaign.

    Parameters
    ----------
    test : Test
        Its entry.
    sensor : Sensor
        That it is about.
    standards : mapping of Influence
        Uncertainties of the standards.

    Raises
    ------
    PlanError
        If a setting is wrong.
    """
    values, problems = plan_values(test.procedure, test.plan, "")
    if problems:
        raise PlanError(problems)
    return static_noise.Plan(**values, kind=sensor.kind, standards=standards)


def _parts(recording: Recording, test: Test) -> Iterator[Recording]:
    """Yield the recording, or its part in each window of the test."""
    if not test.windows:
        yield recording
        return
    for window in test.windows:
        try:
            yield windowed(recording, _with_window(test, window))
        except DataError as error:
            if error.problems[0].code != "nothing_left" or len(test.recordings) == 1:
                raise


def _with_window(test: Test, window: tuple[int, int]) -> Test:
    """Return the test with one window alone."""
    return test.model_copy(update={"windows": [window]})


def records_at_rest(whole: Recording, name: str, unit: str, test: Test | None = None) -> list[static_noise.AtRest]:
    """Return a recording in body axes as a record, or as one for each window of a test.

    Parameters
    ----------
    whole : Recording
        In body axes.
    name : str
        Of it, in the campaign.
    unit : str
        Of the sensor, that readings are told in.
    test : Test, optional
        Its windows.

    Raises
    ------
    DataError
        ``nothing_left``, if no sample lies in a window.
    """
    parts = [whole] if test is None else list(_parts(whole, test))
    labels = [f"{name}, window {number}" for number in range(1, len(parts) + 1)] if len(parts) > 1 else [name]
    return [
        static_noise.AtRest(part, {axis: axis for axis in AXES if axis in part.names}, name=label, shown=unit)
        for part, label in zip(parts, labels, strict=True)
    ]


def _mixed(sensor: Sensor) -> list[Remark]:
    """Say where body axes are mixtures of the sensor's: their noise is one, too."""
    if sensor.mounting is None:
        return []
    cosines = np.abs(np.array(sensor.mounting))
    if np.all((cosines < MIXED) | (cosines > 1.0 - MIXED)):
        return []
    what = "the mounting is oblique: noise of body axes is a mixture of that of the sensors"
    return [Remark("axes_mixed", "info", what, do="Leave mounting out for the noise of each sensor")]

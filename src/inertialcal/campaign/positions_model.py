"""The model of accelerometers, or of gyros, from a test of positions, judged on positions held out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..core.errors import PlanError
from ..core.remarks import Remark
from ..procedures.positions.of_sensor import OfSensor
from ..procedures.rate_table.closed_loop import overall
from ..sensors.model.assemble import model_from
from ..sensors.model.sensor_model import Item, Provenance, SensorModel
from .chains import body_scale_factors
from .load import Campaign
from .modelling import Modelled
from .positions_loop import loops_of
from .requirements import Tested
from .schema_sensors import Sensor

UNIT = {"accelerometer": "m/s^2", "gyro": "rad/s"}
NOT_RUN = "not run"


def make_positions_model(
    campaign: Campaign, tested: Sequence[Tested], sensor: Sensor, share: float = 1.0
) -> Modelled | None:
    """Make and judge the model of one sensor; None where no test is for a fit or nothing could be estimated.

    Parameters
    ----------
    campaign : Campaign
        As read.
    tested : sequence of Tested
        Tests of positions of the sensor.
    sensor : Sensor
        Which.
    share : float
        Of the risk of a wrong verdict that is left to this sensor.

    Raises
    ------
    PlanError
        ``plans_differ`` if several tests are for a fit.
    """
    fitted = [one for one in tested if one.test.use == "fit"]
    held = [one for one in tested if one.test.use == "hold_out"]
    if not fitted:
        return None
    if len(fitted) > 1:
        names = ", ".join(one.test.id for one in fitted)
        what = f"tests {names} are all for a fit of the positions of one sensor"
        do = 'Name all recordings in one test, or give the others use = "report_only"'
        raise PlanError(what, why="what they share would be counted twice", do=do, code="plans_differ")
    result: OfSensor = fitted[0].result
    if result.estimate is None or result.model is None:
        return None
    model = _model(campaign, sensor, fitted[0], result)
    if not held:
        return Modelled(model, None, (), NOT_RUN, (), unit=UNIT[sensor.kind])
    loops, units = loops_of(result.whole, [one.result.readings for one in held], sensor.kind, share)
    if not loops:
        what = "what is held out has fewer than two positions: nothing is judged by them"
        remark = Remark("not_judged", "warning", what, do="Hold out a recording of more positions")
        return Modelled(model, None, (), NOT_RUN, (remark,), unit=UNIT[sensor.kind])
    verdict = overall(loops)
    judged = replace(model, judged=verdict == "PASS")
    return Modelled(judged, None, loops, verdict, (), unit=UNIT[sensor.kind], loop_units=units)


def _model(campaign: Campaign, sensor: Sensor, fitted: Tested, result: OfSensor) -> SensorModel:
    """Return the model for the output of the sensor: volts where its chain has them and its axes are the body's."""
    found = result.model
    assert found is not None and found.estimate is not None  # noqa: S101, PT018 - the caller has looked
    told = Provenance(fitted.test.id, tuple(fitted.test.recordings))
    volts = None if sensor.mounting is not None else body_scale_factors(sensor)
    item = campaign.file.item
    return model_from(
        found.estimate,
        sensor.kind,
        found.axes,
        scale_factor=found.scale_factor if volts is None else np.array([volts[axis] for axis in found.axes]),
        output_unit=None if volts is None else "V",
        source="" if sensor.mounting is None else f"readings in body axes, after mounting {sensor.mounting}",
        item=Item(item.maker, item.part, item.serial),
        input_range=found.input_range,
        not_estimated=found.not_estimated,
        provenance=dict.fromkeys(found.estimate.names, told),
    )

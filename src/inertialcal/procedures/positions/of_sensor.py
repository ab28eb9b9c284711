"""A test of positions seen from one of its sensors: its rows, its estimate, its curves."""

from __future__ import annotations

from dataclasses import dataclass, replace

from ...core.axes import Kind
from ...core.curve import Curve
from ...core.estimate import Estimate
from ...core.remarks import Remark
from ...core.results import Row, by_quantity
from ...sensors.model.sensor_model import SensorModel
from . import reduction as positions
from .curves import curves

OWN = {"accelerometer": "positions", "gyro": "transitions"}  # curve that is about a sensor


@dataclass(frozen=True, eq=False)
class OfSensor:
    """What a test of positions gives of one sensor.

    Parameters
    ----------
    whole : positions.Result
        Of accelerometers, and of gyros where there are any.
    kind : {"accelerometer", "gyro"}
        Which.
    """

    whole: positions.Result
    kind: Kind

    @property
    def plan(self) -> positions.Plan:
        """As given."""
        return self.whole.plan

    @property
    def readings(self) -> positions.Readings:
        """As given."""
        return self.whole.readings

    @property
    def remarks(self) -> tuple[Remark, ...]:
        """Findings."""
        return self.whole.remarks

    @property
    def estimate(self) -> Estimate | None:
        """What is told of the sensor, SI; None where nothing is."""
        return self.whole.estimates.get(self.kind)

    @property
    def model(self) -> SensorModel | None:
        """The same as a model."""
        return self.whole.models.get(self.kind)

    def rows(self) -> tuple[Row, ...]:
        """Rows of ``results.json`` of the sensor, SI."""
        mine = (row for row in self.whole.rows() if row.key.sensor == self.kind)
        return tuple(by_quantity([replace(row, key=row.key._replace(sensor="")) for row in mine]))

    def curves(self) -> list[Curve]:
        """Curves of ``results.json`` of the sensor, SI."""
        return [one for one in curves(self.whole) if one.name == OWN[self.kind]]

"""Rig of an IMU on its six faces at several temperatures: that of ``six_faces`` in a chamber, up and down again.

A record at each temperature, of which the last three are held out. Matrix and bias of the accelerometers change in
proportion to the temperature; the thermometer on the unit is off by one error at all temperatures.
"""

from __future__ import annotations

from ..hand_held.rig import Bench, build
from ..protocol import Rig, on_bench
from ..six_faces.rig import FAULTS as OF_FACES
from ..twin import Fault
from . import TITLE

__all__ = ["FAULTS", "RIG"]

TEMPERATURES = (-20.0, 20.0, 60.0, 40.0, 0.0, 50.0, -10.0, 30.0)  # [degC]
FAULTS: dict[str, Fault] = {
    "one_temperature": Fault(
        "the chamber was never switched on", "too_few_temperatures", {"temperatures": (20.0,) * len(TEMPERATURES)}
    ),
    **OF_FACES,
}
BENCH = Bench(variant="ferraris", temperatures=TEMPERATURES, held_out=3, dwell=2.5, first=5.0, sample_rate=50.0)

RIG = Rig("six_faces_over_temperature", TITLE, on_bench(build, BENCH), FAULTS, tests=("positions", "faces"))

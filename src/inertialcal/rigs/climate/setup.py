"""How the simulated test of sensitivities is set up: what each power-up goes through, with which standards."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from ...core.influence import Influence
from ..parts.gyro_bench import STANDARDS

INTERVAL = AVERAGING = 4.0  # [s]
VOLTS, DEGREES = 5.0, 20.0  # nominal supply [V], temperature of the laboratory [degC]
AIR_PA, VACUUM_PA = 101_325.0, 1e-3
AIR, VACUUM = "air", "vacuum"
PARTS = ("supply", "scale", "table", "warm_up", "pressure")


@dataclass(frozen=True)
class Bench:
    """The test as it is made."""

    parts: tuple[str, ...] = PARTS  # of the campaign
    conditions: tuple[str, ...] = (AIR, VACUUM)  # in which the supply is stepped
    # power-ups of a test at changing supply, and more of them, which no fit sees
    runs: int = 5
    held_out: int = 3
    # the same of the test at the laboratory's temperature
    table_runs: int = 8
    table_held_out: int = 6
    temperatures: tuple[float, ...] = (-10.0, 20.0, 50.0)  # of each power-up [degC]
    supplies: tuple[float, ...] = (5.0, 4.85, 5.15, 5.0)  # at each of them [V]
    dwell: float = 240.0  # at each supply [s]
    # rates of the table at each supply, and of the test at the laboratory's temperature [deg/s]; each for ``turn`` [s]
    rates_deg_s: tuple[float, ...] = (0.0, 3.0, -3.0, 0.0)
    table_deg_s: tuple[float, ...] = (0.0, 0.5, -0.5, 1.5, -1.5, 4.5, -4.5, 0.0)
    turn: float = 60.0
    ramp: float = 3.0  # of the chamber [degC/min]
    soak: float = 900.0  # until the unit has followed [s]
    time_constant: float = 150.0  # of the unit following the chamber [s]
    starts: tuple[float, ...] = (-20.0, 20.0, 50.0)  # temperatures that the unit is switched on at [degC]
    # power-ups at each of them, and more, held out
    warm_up_runs: int = 2
    warm_up_held_out: int = 2
    warm_up_time: float = 7_200.0  # length of these recordings [s]
    levels: tuple[float, ...] = (AIR_PA, VACUUM_PA)  # of the pressure, at each temperature [Pa]
    level_dwell: float = 600.0  # [s]
    warmed: float = 10_800.0  # from power-up to the first reading of the other recordings [s]
    volts_per_unit: float = 1.0  # what the logger saves of the supply, over volts
    exchanged: bool = False  # whether the campaign has the recordings of air and vacuum exchanged
    unplugged: bool = False  # whether the supply was never stepped
    latitude_deg: float = 36.6
    tilt_deg: float = 0.0  # of the table's axis, and of the unit in the chamber
    u_tilt_deg: float = 0.5
    azimuth_deg: float = 30.0
    u_azimuth_deg: float = 2.0
    standards: Mapping[str, Influence] = field(
        default_factory=lambda: (
            {name: STANDARDS[name] for name in ("rate_table.rate", "rate_table.mounting", "site.latitude")}
            | {"thermometer.temperature": Influence(0.1, "degC", certificate="simulated")}
        )
    )

"""How the simulated campaign of the rate suite is set up: which tests, how long, which standards, which chain."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ...core.influence import Influence
from ...core.key import AXES
from ...sensors.catalogue import SLOPE, T_REFERENCE, V_NOMINAL
from ...sensors.chain.converter import Chain, Thermometer
from ..parts.gyro_bench import CODES, INVERTED, STANDARDS, STEP, VALID_VOLTS, VOLTS_PER_RAD_S

INTERVAL, AVERAGING, AVERAGED = 2, 1.0, 200  # [s], [s], conversions
PARTS = ("thermal", "rate_table", "noise")
AIR, VACUUM = "ambient", "vacuum"

LATE = {3: 0.018, 5: 1e-3, 6: 3e-4}  # steps [s] between saves and their share: ACS 206 and 238; the others are 2 s
APPLIED, PRESSURE = "rate_dps", "pressure_torr"  # columns besides those of the sensors

# The same rate again and again is one longer dwell: some 260 s at low rates, as in the thesis, between rests as long.
LOW_RATES, RATES, LONGER = (0.05, 0.1), (0.5, 1.5, 3.0, 4.5), 4
RATES_DEG_S: tuple[float, ...] = (
    *(rate for low in LOW_RATES for step in (0.0, low, -low) for rate in (step,) * LONGER),
    *(0.0,) * LONGER,
    *(rate for high in RATES for rate in (high, -high, 0.0)),
)


@dataclass(frozen=True)
class Chamber:
    """How the thermal chamber is run in one condition."""

    # time at the first set-point after power-up, and at each other one [s]
    hold: float
    soak: float
    time_constant: float  # of the unit following the chamber [s]
    torr: tuple[float, float]  # pressure at the start and at the end of a run [Torr]


@dataclass(frozen=True)
class Bench:
    """The campaign as it is made."""

    parts: tuple[str, ...] = PARTS  # parts of the campaign, of `PARTS`
    # by condition: air, vacuum
    chambers: Mapping[str, Chamber] = field(
        default_factory=lambda: {
            AIR: Chamber(900.0, 900.0, 400.0, (760.0, 760.0)),
            VACUUM: Chamber(9000.0, 1200.0, 600.0, (1e-5, 1e-6)),  # some units warm up for more than two hours
        }
    )
    set_points: tuple[float, ...] = (23.0, -30.0, 67.0, 23.0)  # chamber set-points in order [degC]
    ramps: tuple[float, ...] = (3.0, 1.5)  # ramp rate of each run in turn [degC/min]
    # Power-ups in each condition, and those used for the fit. Five held out: four degrees of freedom, so that the bias
    # left over temperature, of which power-ups differ by 0.006 deg/s, is decided against 0.05 deg/s.
    chamber_runs: int = 10
    chamber_fit_runs: int = 5
    copied: bool = False  # whether the second file in air is a copy of the first
    # shift of the temperature channels' voltage at their reference temperature; stated in the campaign [V]
    nominal_shift: float = 0.0
    # rates of the dwells on the rate table, in order; equal neighbours are one dwell [deg/s]
    rates_deg_s: tuple[float, ...] = RATES_DEG_S
    dwell: int = 64  # length of each dwell [s]
    longest_ramp: int = 3  # a ramp takes one to this many intervals
    # Power-ups on the rate table, and those used for the fit. With seven, 5 % of 0.1 deg/s is decided; without the
    # reading at rest, in which power-ups differ, five held out show that the matrix helps.
    table_runs: int = 12
    table_fit_runs: int = 7
    warmed: float = 900.0  # time from power-up to the first rate-table recording, and to the static one [s]
    set_up: float = 3600.0  # time from axis to axis [s]
    # temperature of the unit in the laboratory, and its scatter from run to run [degC]
    lab_degc: float = 22.0
    u_lab_degc: float = 0.5
    # length [h] and number of static records
    static_hours: float = 8.0
    static_runs: int = 1
    # off-nominal steps between saves [s], and their share
    steps: Mapping[int, float] = field(default_factory=lambda: dict(LATE))
    latitude_deg: float = 36.6  # latitude of the site [deg]
    # tilt of the table axis from the vertical, azimuth of that tilt, and their uncertainties [deg]
    tilt_deg: float = -36.4
    azimuth_deg: float = 0.0
    u_tilt_deg: float = 1.0
    u_azimuth_deg: float = 2.0
    # the same for body z and body x, in the chamber and at rest [deg]
    chamber_tilt_deg: float = 0.0
    chamber_azimuth_deg: float = 30.0
    u_chamber_tilt_deg: float = 1.0
    u_chamber_azimuth_deg: float = 2.0
    standards: Mapping[str, Influence] = field(
        default_factory=lambda: STANDARDS | {"thermometer.temperature": Influence(0.1, "degC", certificate="simulated")}
    )  # uncertainties of the other standards
    table_gain: float = 1.0  # true over commanded table rate, apart from the error of the standard
    wiring: tuple[str, ...] = AXES  # sensor that the columns x, y, z really hold
    # true mounting: -1 for inverted; the campaign states ``INVERTED``
    inverted: tuple[int, ...] = INVERTED
    reference_saved: bool = True  # whether the logger saves the reference voltages of the rates
    zero_reference: bool = True  # whether the rate-table tests subtract the reading at rest
    overlapping: bool = False  # whether the windows of a fit and of a hold-out test overlap
    required_degc: tuple[float, float] = (-20.0, 60.0)  # temperature range of the bias requirement [degC]


def nominal_volts(bench: Bench) -> np.ndarray:
    """Return the voltage of each temperature channel at its reference temperature, above its reference, (3,) [V]."""
    return np.array(V_NOMINAL) + bench.nominal_shift


def thermometer(bench: Bench) -> Thermometer:
    """Return the temperature channels."""
    return Thermometer(SLOPE, nominal_volts(bench), np.array(T_REFERENCE))


def chain(bench: Bench) -> Chain:
    """Return the signal chain of the three sensors, as the campaign says it."""
    return Chain(
        AXES,
        STEP,
        CODES,
        "rad/s",
        scale_factor=VOLTS_PER_RAD_S,
        reference="channel",
        thermometer=thermometer(bench),
        validity_minimum=VALID_VOLTS,
    )

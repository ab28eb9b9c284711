"""How the simulated campaign of the rate suite is set up: which tests, how long, which standards, which chain."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ...core.axes import AXES
from ...core.influence import Influence
from ...sensors.catalogue import SLOPE, T_REFERENCE, V_NOMINAL
from ...sensors.chain.converter import Chain, Thermometer

INVERTED = (-1, 1, -1)  # x and z sensors are mounted against the body axes
STEP = 5.0 / 4095.0  # [V]
CODES = (0, 4095)
REFERENCE = 2.5  # [V]
SCALE_FACTOR_V_PER_DEG_S = 0.5
VOLTS_PER_RAD_S = float(SCALE_FACTOR_V_PER_DEG_S / np.radians(1.0))
VALID_VOLTS = 2.4  # of the built-in test
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


def _standards() -> dict[str, Influence]:
    return {
        "rate_table.rate": Influence(3e-4, "1", certificate="simulated"),
        "rate_table.mounting": Influence(1e-3, "rad", certificate="simulated"),
        "converter.reference": Influence(1e-4, "1", certificate="simulated"),
        "site.latitude": Influence(1e-4, "rad", certificate="simulated"),
        "thermometer.temperature": Influence(0.1, "degC", certificate="simulated"),
    }


@dataclass(frozen=True)
class Chamber:
    """How the thermal chamber is run in one condition.

    Parameters
    ----------
    hold, soak : float
        At the first set-point after power-up, and at each of the others [s].
    time_constant : float
        With which the unit follows the chamber [s].
    torr : (float, float)
        Pressure at the start and at the end of a run [Torr].
    """

    hold: float
    soak: float
    time_constant: float
    torr: tuple[float, float]


@dataclass(frozen=True)
class Bench:
    """The campaign as it is made.

    Parameters
    ----------
    parts : tuple of str
        Tests that are in it, of `PARTS`.
    chambers : mapping of Chamber
        By condition: air, vacuum.
    set_points : tuple of float
        Of the chamber, one after the other [degC].
    ramps : tuple of float
        Of its set-point, run after run in turn [degC/min].
    chamber_runs, chamber_fit_runs : int
        Power-ups in each condition, and how many of them are for the fit.
    copied : bool
        Whether the file of the second run in air is a copy of that of the first.
    nominal_shift : float
        Of the voltage of the temperature channels at their reference temperature; the campaign knows it [V].
    rates_deg_s : tuple of float
        Of the dwells of every recording on the rate table, in order; neighbours that are equal are one dwell [deg/s].
    dwell : int
        Length of each of them [s].
    longest_ramp : int
        A ramp takes one to so many intervals.
    table_runs, table_fit_runs : int
        Power-ups on the rate table, and how many of them are for the fit.
    warmed : float
        From power-up to the first recording on the rate table, and to the static one [s].
    set_up : float
        From one axis to the next [s].
    lab_degc, u_lab_degc : float
        Temperature of the unit beside the chamber, and by how much it differs from run to run [degC].
    static_hours, static_runs : float, int
        Length of the static record [h], and how many there are.
    steps : mapping of int to float
        Steps between saves other than the nominal one [s], and their share.
    latitude_deg : float
        Of the site [deg].
    tilt_deg, azimuth_deg, u_tilt_deg, u_azimuth_deg : float
        Of the table axis from the vertical, of the direction of the tilt, and how well they are known [deg].
    chamber_tilt_deg, chamber_azimuth_deg, u_chamber_tilt_deg, u_chamber_azimuth_deg : float
        Of the body's z axis from the vertical and of its x axis from north, in the chamber and at rest [deg].
    standards : mapping of Influence
        How well the others are known.
    table_gain : float
        Rate of the table over the commanded one, but for the error of the standard.
    wiring : tuple of str
        Sensor that each of the columns x, y, z really shows.
    inverted : tuple of int
        -1 for each sensor that is really mounted inverted; the campaign file says ``INVERTED``.
    reference_saved : bool
        Whether the logger saves the reference voltages of the rates.
    zero_reference : bool
        Whether the rate table is reduced with the reading at rest taken off.
    overlapping : bool
        Whether the windows of a fit and of a hold-out test overlap.
    required_degc : (float, float)
        Temperatures that the requirement on the bias is for [degC].
    """

    parts: tuple[str, ...] = PARTS
    chambers: Mapping[str, Chamber] = field(
        default_factory=lambda: {
            AIR: Chamber(900.0, 1200.0, 400.0, (760.0, 760.0)),
            VACUUM: Chamber(5400.0, 1800.0, 600.0, (1e-5, 1e-6)),
        }
    )
    set_points: tuple[float, ...] = (23.0, -30.0, 67.0, 23.0)
    ramps: tuple[float, ...] = (1.5, 0.75)
    chamber_runs: int = 7
    chamber_fit_runs: int = 5
    copied: bool = False
    nominal_shift: float = 0.0
    rates_deg_s: tuple[float, ...] = RATES_DEG_S
    dwell: int = 64
    longest_ramp: int = 3
    table_runs: int = 8
    table_fit_runs: int = 5
    warmed: float = 900.0
    set_up: float = 3600.0
    lab_degc: float = 22.0
    u_lab_degc: float = 0.5
    static_hours: float = 8.0
    static_runs: int = 1
    steps: Mapping[int, float] = field(default_factory=lambda: dict(LATE))
    latitude_deg: float = 36.6
    tilt_deg: float = -36.4
    azimuth_deg: float = 0.0
    u_tilt_deg: float = 1.0
    u_azimuth_deg: float = 2.0
    chamber_tilt_deg: float = 0.0
    chamber_azimuth_deg: float = 30.0
    u_chamber_tilt_deg: float = 1.0
    u_chamber_azimuth_deg: float = 2.0
    standards: Mapping[str, Influence] = field(default_factory=_standards)
    table_gain: float = 1.0
    wiring: tuple[str, ...] = AXES
    inverted: tuple[int, ...] = INVERTED
    reference_saved: bool = True
    zero_reference: bool = True
    overlapping: bool = False
    required_degc: tuple[float, float] = (-20.0, 60.0)


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

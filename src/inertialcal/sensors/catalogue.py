"""Published sensors as data, each with its source.

Figures stand as printed, in the printed unit (spelled as ``core.units`` prints it). Chains and models are in SI.

The flight unit's model exists twice. As printed, its numbers are taken as the text says: matrix and volts straight
into ``rate = reading - (b + M reading)`` [1]_. That makes its own scale errors twice as large, because the printed
M has the sign of the correction, not of the error; it is also transposed (row = the axis that is turned), and the
bias polynomial of Table 15 gives volts where the equation needs deg/s. Corrected, these three are mended, in the
conventions of ``sensors.model``: entry m_xz of the thesis (1.298 %) is ``misalignment_zx`` here. Its m_yx of
-0.156 %, where the set with zero reference has -0.23 %, has no known correction and stays as printed.

References
----------
.. [1] Badescu, NPS thesis, 2011, equation (2), Table 15, section IV.E.2.a, Appendix A.
.. [2] Chestney and Sicker, NASA TM-106980, 1996.
.. [3] Reinel, NASA TM X-53857, 1969.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from numpy.polynomial import Polynomial

from ..core.constants import REINEL_GRAVITY
from ..core.errors import UsageError
from ..core.key import Kind
from ..core.units import factor
from .chain.converter import Chain, Thermometer, pulse_counter
from .flight import FlightEquation
from .model.sensor_model import Item, Provenance, SensorModel

XYZ = ("x", "y", "z")
BADESCU = "Badescu, NPS thesis, 2011"
CHESTNEY = "Chestney and Sicker, NASA TM-106980, 1996"
REINEL = "Reinel, NASA TM X-53857, 1969"
CORRECTED, AS_PRINTED = "corrected", "as_printed"  # States of a published model

Relation = Literal["at most", "less than", "at least", "more than", "plus or minus", "equals"]


@dataclass(frozen=True)
class Figure:
    """One printed figure: a data-sheet limit or a stated property."""

    quantity: str  # In the field's words
    relation: Relation  # How the value limits the quantity
    value: float  # In ``unit``, as printed
    unit: str  # As ``core.units`` prints it
    note: str = ""  # Conditions
    judged_by: str = ""  # Quantity of the results that says it; empty where no test does
    where: str = ""  # Range that the limit holds over, as a requirement has it
    source: str = ""  # Where that is not the one of its sensor

    @property
    def said(self) -> str:
        """What is printed, in words."""
        words = f"{self.quantity} {self.relation} {self.value:g} {self.unit.removesuffix('1')}".rstrip()
        return f"{words}, {self.note}" if self.note else words


@dataclass(frozen=True, eq=False)
class PublishedSensor:
    """A sensor that a document describes."""

    item: Item  # Maker, part and serial as far as the document has them
    kind: Kind  # What it senses
    axes: tuple[str, ...]  # One a sensor
    source: str  # Citation
    figures: tuple[Figure, ...] = ()  # Data sheet and text
    chains: Mapping[str, Chain] = field(default_factory=dict)  # By range or purpose
    models: Mapping[str, SensorModel] = field(default_factory=dict)  # By state of correction
    equations: Mapping[str, FlightEquation] = field(default_factory=dict)  # Of flight software, likewise

    def figure(self, quantity: str) -> Figure:
        """One figure by its quantity; KeyError names those there are."""
        for one in self.figures:
            if one.quantity == quantity:
                return one
        raise KeyError(f"{quantity}; there are: {', '.join(one.quantity for one in self.figures)}")


QRS11_FIGURES = (
    Figure("supply_voltage", "plus or minus", 5.0, "V", "regulation 3 %"),
    Figure("supply_current", "at most", 80.0, "mA", "each supply"),
    Figure("supply_noise", "less than", 10.0, "mV", "rms, wideband except at 8.7 kHz"),
    Figure("supply_noise_at_8.7_kHz", "less than", 1.0, "mV", "rms, within 0.5 kHz"),
    Figure("input_range", "plus or minus", 5.0, "deg/s"),
    Figure("full_scale_output", "plus or minus", 2.5, "V", "nominal"),
    Figure("scale_factor_error", "at most", 1.0, "%", "of value, at 22 degC, typical", "scale_factor_error"),
    Figure(
        "scale_factor_over_temperature",
        "at most",
        0.03,
        "%/degC",
        "from 22 degC, typical",
        "scale_factor_error_temperature_1",
    ),
    Figure("bias", "at most", 0.131, "deg/s", "at 22 degC", "bias"),
    Figure(
        "bias_over_temperature",
        "at most",
        0.117,
        "deg/s",
        "deviation from 22 degC",
        "bias_over_temperature",
        "temperature >= -40 degC and temperature <= 80 degC",
    ),
    Figure("g_sensitivity", "at most", 0.02, "deg/s/g", "typical", "g_sensitivity"),
    Figure("turn_on_time", "less than", 1.0, "s", "typical"),
    Figure("bandwidth", "more than", 60.0, "Hz", "90 deg phase"),
    Figure("nonlinearity", "at most", 0.05, "%", "of full range, typical", "linearity_error"),
    Figure(
        "output_noise", "at most", 0.004, "deg/s/sqrt(Hz)", "to 100 Hz; printed one row higher", "angle_random_walk"
    ),
    Figure("operating_temperature_low", "at least", -40.0, "degC"),
    Figure("operating_temperature_high", "at most", 80.0, "degC"),
    Figure("storage_temperature_low", "at least", -55.0, "degC"),
    Figure("storage_temperature_high", "at most", 100.0, "degC"),
    Figure("vibration_operating", "at most", 8.0, "g", "rms, 20 Hz to 2 kHz random"),
    Figure("vibration_survival", "at most", 20.0, "g", "rms, 20 Hz to 2 kHz random, 5 min an axis"),
    Figure("shock", "at most", 200.0, "g", "any axis"),
    Figure("mass", "at most", 60.0, "gram"),
)

SAMS_FIGURES = (
    Figure("bandwidth", "equals", 5.0, "Hz", "of the head"),
    Figure("scale_factor_x", "equals", 938.264, "V/g", "Table 2, time 1; its Y and Z rows hold biases in ug"),
    Figure("model_order_in_temperature", "equals", 4.0, "1", "bias, scale factor and misalignment"),
)

MESA_FIGURES = (
    Figure("scale_factor_low_range", "equals", 10.21, "count/s/ug"),
    Figure("scale_factor_high_range", "equals", 1.024, "count/s/ug"),
    Figure("null_stability", "equals", 0.163, "ug", "4 h"),
    Figure("scale_factor_stability", "equals", 0.01758, "%"),
    Figure("scale_factor_stability_limit", "at most", 0.1, "%", "4 h"),
    Figure("sample_time", "equals", 100.0, "s"),
)

# What the satellite asks of the suite, in the text of the thesis
FLIGHT_FIGURES = (
    Figure("rate_accuracy", "at most", 5.0, "%", "", "rate_error", "abs(rate) >= 0.1 deg/s"),
    Figure("temperature_accuracy", "at most", 2.0, "%", "taken as part of the range", "temperature_error_of_range"),
    Figure("built_in_test_good", "at least", 2.4, "V", "validity_minimum of the chain; its share is built_in_test"),
    Figure("built_in_test_bad", "at most", 0.8, "V"),
    Figure("save_interval", "equals", 2.0, "s"),
)

# Table 15 of the thesis, rows x, y, z as printed.
B_IN_RUN = (  # volts over volts of the temperature channel: B, m1, m2, m3
    (-0.00809, -0.05675, -0.0107, -0.00503),
    (0.0038, -0.01519, -0.0037, -0.00402),
    (0.03219, -0.01581, -0.01039, -0.00796),
)
B_CONS_DEG_S = (7.18e-3, -8.12e-3, 7.00e-3)
M_PERCENT = ((0.042, 0.102, 1.298), (-0.156, -0.4, 0.128), (-0.2, -0.139, 0.506))
T_REFERENCE = (25.7, 25.4, 25.3)  # [degC]
V_NOMINAL = (-0.5042, -0.4909, -0.5071)  # [V]
SLOPE = 0.0264  # [V/degC]
IDEAL_V_PER_DEG_S = 0.5
TEMPERATURES = (-21.0, 66.0)  # [degC] where text and Appendix B both have the vacuum ramp


def qrs11() -> PublishedSensor:
    """Return the rate sensor of the flight unit with its data-sheet limits (Appendix A, third column)."""
    item = Item("Systron Donner", "QRS11-00005-565")
    return PublishedSensor(item, "gyro", ("z",), f"{BADESCU}, Appendix A", QRS11_FIGURES)


def sams_head() -> PublishedSensor:
    """Return the triaxial head; its electronics' zero and ground model are not printed."""
    chain = Chain(XYZ, 10.0 / 65536, (-32768, 32767), unit="m/s^2", gain=np.array([100.0, 100.0, 10.0]))
    item = Item("Sundstrand", "QA-2000")
    return PublishedSensor(item, "accelerometer", XYZ, CHESTNEY, SAMS_FIGURES, {"flight": chain})


def mesa() -> PublishedSensor:
    """Return the electrostatic accelerometer, a chain for each of its ranges; g is that of the report."""
    in_si = REINEL_GRAVITY.value * factor(REINEL_GRAVITY.unit, "m/s^2")  # [m/s2] in one g of the report
    per_ug = {"low": 10.21, "high": 1.024}  # [count/s/ug]
    chains = {
        name: pulse_counter(("x",), 100.0, "m/s^2", pulses / (factor("ug", "g") * in_si))
        for name, pulses in per_ug.items()
    }
    return PublishedSensor(Item(part="MESA"), "accelerometer", ("x",), REINEL, MESA_FIGURES, chains)


def flight_unit() -> PublishedSensor:
    """Return the rate suite: chain, and its published model as printed and corrected."""
    scale_factor = IDEAL_V_PER_DEG_S * factor("V/(deg/s)", "V/(rad/s)")
    chain = Chain(
        XYZ,
        5.0 / 4095,
        (0, 4095),
        unit="rad/s",
        scale_factor=scale_factor,
        reference="channel",
        thermometer=Thermometer(SLOPE, np.array(V_NOMINAL), np.array(T_REFERENCE)),
        validity_minimum=2.4,
    )
    printed = np.array(M_PERCENT) * factor("%", "1")
    mended = np.where(np.eye(3, dtype=bool), -printed, printed.T)
    states = {CORRECTED: (mended, IDEAL_V_PER_DEG_S), AS_PRINTED: (printed, 1.0)}  # M; volts in one deg/s of b_in_run
    models = {
        name: _flight_model(chain, matrix, 1.0 / volts, _source(name)) for name, (matrix, volts) in states.items()
    }
    equations = {
        name: FlightEquation(XYZ, np.array(B_IN_RUN), volts, np.array(B_CONS_DEG_S), matrix, _source(name))
        for name, (matrix, volts) in states.items()
    }
    item, source = Item("Systron Donner", "3 x QRS11-00005-565", "flight"), f"{BADESCU}, Table 15"
    sheet = qrs11()
    figures = tuple(replace(one, source=BADESCU) for one in FLIGHT_FIGURES)
    figures += tuple(replace(one, source=sheet.source) for one in sheet.figures)
    return PublishedSensor(item, "gyro", XYZ, source, figures, {"flight": chain}, models, equations)


def _source(state: str) -> str:
    return f"{BADESCU}, Table 15, {state.replace('_', ' ')}"


def _flight_model(chain: Chain, errors: np.ndarray, deg_s_per_volt: float, source: str) -> SensorModel:
    """M = I + errors, and K0(T) = b_in_run + b_cons in powers of T - T_ref of each axis."""
    to_rad = factor("deg/s", "rad/s")
    nominal = zip(
        B_IN_RUN, V_NOMINAL, strict=True
    )  # volts over volts of the temperature channel, to powers of T - T_ref
    powers = np.array([Polynomial(row)(Polynomial([v, SLOPE])).coef for row, v in nominal])
    in_run = powers * deg_s_per_volt * to_rad
    span = 5.0 * to_rad
    model = SensorModel(
        kind="gyro",
        axes=XYZ,
        item=Item("Systron Donner", "3 x QRS11-00005-565", "flight"),
        scale_factor=np.full(3, IDEAL_V_PER_DEG_S / to_rad),
        output_unit="V",
        matrix=np.eye(3) + errors,
        bias=in_run[:, 0] + np.array(B_CONS_DEG_S) * to_rad,
        bias_temperature=in_run[:, 1:].T,
        reference_temperature=np.array(T_REFERENCE),
        input_range=np.array([[-span, span]] * 3),
        temperature_range=TEMPERATURES,
        chain=chain,
        source=source,
    )
    names = [one.name for one in model.parameters]
    return replace(
        model,
        not_estimated=dict.fromkeys(names, "published without covariance"),
        provenance=dict.fromkeys(names, Provenance(source=model.source)),
    )


def published_sensor(name: str) -> PublishedSensor:
    """Return a published sensor by its name here, or by the part that its document names, in any case.

    Raises
    ------
    UsageError
        ``unknown_sensor``, with those there are.
    """
    for key, made in CATALOGUE.items():
        sensor = made()
        if _plain(name) in {_plain(key), _plain(sensor.item.part), _plain(sensor.item.part.partition("-")[0])}:
            return sensor
    parts = (f"{key} ({made().item.part})" for key, made in CATALOGUE.items())
    raise UsageError(f"No published sensor {name!r}", do=f"There are: {', '.join(parts)}", code="unknown_sensor")


def _plain(name: str) -> str:
    return "".join(letter for letter in name.lower() if letter.isalnum())


CATALOGUE: Mapping[str, Callable[[], PublishedSensor]] = {
    "qrs11": qrs11,
    "sams_head": sams_head,
    "mesa": mesa,
    "flight_unit": flight_unit,
}

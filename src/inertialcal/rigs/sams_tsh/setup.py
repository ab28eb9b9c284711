"""How the simulated flip is set up: the orbit, the standards, the head that is drawn for it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ...core.constants import STANDARD_GRAVITY
from ...core.estimate import Array
from ...core.influence import Influence
from ...core.key import AXES
from ...sensors.chain.converter import Chain, Thermometer

G = STANDARD_GRAVITY.value  # [m/s^2]
UG = 1e-6 * G
STEP = 10.0 / 65536.0  # [V]
CODES = (-32768, 32767)
GAINS = (1.0, 10.0, 100.0, 1000.0)
SCALE_FACTOR_V_PER_G = (9.38, 9.70, 9.55)  # at the reference temperature, before the amplifier
THERMOMETER_V_PER_DEGC = 0.1
REFERENCE_TEMPERATURE = 18.0  # [degC]
POLES_BEFORE, POLES_MAIN = 1, 7
CUT_OFF_BEFORE, CUT_OFF_MAIN = 0.4, 0.2  # of the low-passes, in sample rates: 5 Hz at 25 samples/s


def _standards() -> dict[str, Influence]:
    return {
        "turn.angle": Influence(float(np.radians(0.2)), "rad", certificate="simulated"),
        "turn.axis": Influence(float(np.radians(0.2)), "rad", certificate="simulated"),
        "converter.zero": Influence(0.05 * UG, "m/s^2", certificate="simulated"),
        "sensor.scale_factor": Influence(1e-4, "1", certificate="simulated"),
    }


@dataclass(frozen=True)
class Bench:
    """The flip as it is made."""

    rate: float = 25.0  # [Hz]
    duration: float = 3600.0  # length of the record [s]
    # start of each turn [s], and its nominal end angle [deg]
    turn_starts: tuple[float, ...] = (1200.0, 2400.0)
    positions_deg: tuple[float, ...] = (180.0, 0.0)
    stopped_deg: tuple[float, ...] = (0.0, 0.0)  # overshoot of each turn [deg]
    turn_time: float = 5.0  # length of a turn [s]
    turn_axis: str = "x"  # true axis of the turn; the campaign states x
    # length of the windows before and after a turn, and settling time after it [s]
    window: float = 300.0
    settle: float = 20.0
    density_ug: float = 1.0  # white noise of the sensor [ug/sqrt(Hz)]
    corner: float = 0.01  # frequency below which its 1/f noise is larger [Hz]
    # spread of the drawn quasi-steady acceleration and biases [ug]
    ambient_ug: float = 4.0
    bias_ug: float = 1000.0
    # amplitude [ug] and period [s] of the ambient wave
    swing_ug: float = 0.02
    orbit: float = 5400.0
    # frequency [Hz] and size [ug] of vibration lines; those above half the sample rate are filtered out
    lines: tuple[tuple[float, float], ...] = ((3.6, 2.0), (4.7, 4.0), (17.0, 40.0))
    pushes: float = 6.0  # crew disturbances per hour, outside the windows
    arm: tuple[float, float] | None = None  # when the robot arm moves [s]
    # range of the drawn size [ug] and frequency [Hz]
    arm_ug: tuple[float, float] = (10.0, 40.0)
    arm_frequency: tuple[float, float] = (0.1, 0.4)
    lever: float = 0.02  # spread of the distance of the proof masses from the turn axis [m]
    # warming during the record [degC], and its time constant [s]
    warming: float = 0.02
    warming_time: float = 3600.0
    temperature_swing: float = 0.005  # temperature wave once per orbit [degC]
    hysteresis_ug: float = 0.01  # extra bias while warming, the negative while cooling [ug]
    drift_ug: float = 0.05  # bias drift per hour [ug]
    filtered: bool = True  # whether the low-pass filters are present
    gains: tuple[float, ...] = (100.0, 100.0, 10.0)  # gain of each axis
    gain_change: tuple[float, str, float] | None = None  # time, axis and factor of a gain change
    # whether the gain of each axis is recorded; the zero of the electronics then changes with it
    gain_recorded: bool = False
    lost: tuple[float, float] | None = None  # gap in the record [s]
    signs: tuple[int, ...] = (1, 1, 1)  # -1 for an axis wired the wrong way
    ground: str = ""  # {"", "jointly", "bias_first"}: order of the ground model in the campaign; empty for none
    # spread of the model errors: bias [ug], its slope [ug/degC], misalignments [rad]
    model_ug: float = 20.0
    model_slope_ug: float = 1.0
    model_misalignment: float = 1e-4
    saved: str = "count"  # {"count", "g"}: what is recorded
    said: str = "count"  # its unit as stated in the campaign
    # other standards; an error of each is drawn
    standards: Mapping[str, Influence] = field(default_factory=_standards)


@dataclass(frozen=True, eq=False)
class Head:
    """A triaxial head; powers of the temperature are those of its distance from the reference, 0 to 4."""

    bias: Array  # (5, 3) [m/s^2/degC^i]
    scale: Array  # scale factor at each of the `GAINS` relative to the ideal one, (4, 5, 3) [1/degC^i]
    matrix: Array  # M_0 with the misalignment, and its change [1/degC]; row = the sensor that reads, (2, 3, 3)
    zero: Array  # zero of the electronics at each of the `GAINS`, (4, 3) [V at the converter]
    arms: Array  # from the turn axis to the proof mass of each sensor, (3, 3) [m]


@dataclass(frozen=True, eq=False)
class Drawing:
    """What the engineer knows of a head, from the ground; powers of the temperature as those of `Head`."""

    bias: Array  # (5, 3) [m/s^2/degC^i]
    scale: Array  # scale factor at each of the `GAINS`, (4, 5, 3) [V/g/degC^i]
    cross: Array  # misalignment [rad/degC^i]; row = the sensor that reads, (2, 3, 3)


def draw_head(bench: Bench, rng: np.random.Generator) -> Head:
    """Return a head of the family: bias of some 1000 ug and 5 ug/degC, scale factor 1e-4 a degC, 2 mrad off."""
    powers = np.array([1.0, 5e-3, 1e-3, 1e-4, 1e-5])[:, None]  # of the bias, relative
    bias = rng.choice([-1.0, 1.0], 3) * bench.bias_ug * (1.0 + 0.25 * rng.normal(size=3)) * UG
    slopes = rng.normal(size=(5, 3)) * powers * bench.bias_ug * UG
    sensitivity = np.array([0.0, 1.1e-4, 1e-6, 1e-8, 1e-10])[:, None] * rng.uniform(0.5, 1.5, (4, 5, 3))
    sensitivity[:, 0] = 1.0
    matrix = np.stack([np.eye(3) + rng.normal(0.0, 2e-3, (3, 3)), rng.normal(0.0, 1e-5, (3, 3))])
    zero = rng.normal(0.0, 1e-3, (4, 3)) * np.sqrt(np.array(GAINS))[:, None]
    slopes[0] = bias
    return Head(slopes, sensitivity, matrix, zero, rng.normal(0.0, bench.lever, (3, 3)))


def chain(bench: Bench, head: Head) -> Chain:
    """Return the signal chain of the three sensors, ideal scale factors, with the zeros as a shorted input has them."""
    at = [GAINS.index(gain) for gain in bench.gains]
    return Chain(
        AXES,
        STEP,
        CODES,
        "m/s^2",
        scale_factor=np.array(SCALE_FACTOR_V_PER_G) / G,
        zero=head.zero[at, range(3)],
        gain=np.array(bench.gains),
        zero_at=dict(zip(GAINS, head.zero, strict=True)) if bench.gain_recorded else None,
        thermometer=Thermometer(THERMOMETER_V_PER_DEGC, 0.0, 0.0),
    )

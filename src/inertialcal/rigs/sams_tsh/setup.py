"""How the simulated flip is set up: the orbit, the standards, the head that is drawn for it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ...core.axes import AXES
from ...core.constants import STANDARD_GRAVITY
from ...core.estimate import Array
from ...core.influence import Influence
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
    """The flip as it is made.

    Parameters
    ----------
    rate : float
        Samples a second.
    duration : float
        Of the record [s].
    turn_starts, positions_deg : tuple of float
        When each turn begins [s], and the angle that it should end at [deg].
    stopped_deg : tuple of float
        By how much each turn really goes further than that [deg].
    turn_time : float
        Of a turn [s].
    turn_axis : str
        Head axis about which it is really turned; the campaign says x.
    window, settle : float
        Length of the windows beside a turn, and what is left out after it [s].
    density_ug : float
        Of the sensor's white noise [ug/sqrt(Hz)].
    corner : float
        Frequency below which its 1/f noise is larger [Hz].
    ambient_ug, bias_ug : float
        Spread of the quasi-steady acceleration and of the biases that are drawn [ug].
    swing_ug, orbit : float
        Wave of the ambient acceleration [ug], and its period [s].
    lines : tuple of (float, float)
        Frequency [Hz] and size [ug] of vibration lines; those beyond half the sample rate are filtered away.
    pushes : float
        Disturbances by the crew, an hour; they stay off the windows.
    arm : (float, float), optional
        When the robot arm moves [s].
    arm_ug, arm_frequency : (float, float)
        Ends of the size [ug] and frequency [Hz] that are drawn.
    lever : float
        Spread of the distance of each proof mass from the axis of the turn [m].
    warming, warming_time : float
        By how much the head warms during the record [degC], and with which time constant [s].
    temperature_swing : float
        Wave of the temperature once an orbit [degC].
    hysteresis_ug : float
        More bias by this while warming, less while cooling [ug].
    drift_ug : float
        Of the bias, an hour [ug].
    filtered : bool
        Whether the low-passes are there.
    gains : tuple of float
        Of each axis.
    gain_change : (float, str, float), optional
        When, of which axis and by which factor the gain changes.
    lost : (float, float), optional
        What is not recorded [s].
    gain_recorded : bool
        Whether the gain of each axis is recorded beside it; the zero of the electronics then changes with it.
    signs : tuple of int
        -1 for an axis that is wired the wrong way.
    ground : {"", "jointly", "bias_first"}
        Order of the ground model in the campaign; empty for none.
    model_ug, model_slope_ug, model_misalignment : float
        Spread of the errors of the model: bias [ug], its slope [ug/degC], each misalignment [rad].
    saved : {"count", "g"}
        What is recorded.
    said : str
        Unit of it that the campaign states.
    standards : mapping of Influence
        How well the others are known; an error of each is drawn.
    """

    rate: float = 25.0
    duration: float = 3600.0
    turn_starts: tuple[float, ...] = (1200.0, 2400.0)
    positions_deg: tuple[float, ...] = (180.0, 0.0)
    stopped_deg: tuple[float, ...] = (0.0, 0.0)
    turn_time: float = 5.0
    turn_axis: str = "x"
    window: float = 300.0
    settle: float = 20.0
    density_ug: float = 1.0
    corner: float = 0.01
    ambient_ug: float = 4.0
    bias_ug: float = 1000.0
    swing_ug: float = 0.02
    orbit: float = 5400.0
    lines: tuple[tuple[float, float], ...] = ((3.6, 2.0), (4.7, 4.0), (17.0, 40.0))
    pushes: float = 6.0
    arm: tuple[float, float] | None = None
    arm_ug: tuple[float, float] = (10.0, 40.0)
    arm_frequency: tuple[float, float] = (0.1, 0.4)
    lever: float = 0.02
    warming: float = 0.02
    warming_time: float = 3600.0
    temperature_swing: float = 0.005
    hysteresis_ug: float = 0.01
    drift_ug: float = 0.05
    filtered: bool = True
    gains: tuple[float, ...] = (100.0, 100.0, 10.0)
    gain_change: tuple[float, str, float] | None = None
    gain_recorded: bool = False
    lost: tuple[float, float] | None = None
    signs: tuple[int, ...] = (1, 1, 1)
    ground: str = ""
    model_ug: float = 20.0
    model_slope_ug: float = 1.0
    model_misalignment: float = 1e-4
    saved: str = "count"
    said: str = "count"
    standards: Mapping[str, Influence] = field(default_factory=_standards)


@dataclass(frozen=True, eq=False)
class Head:
    """A triaxial head; powers of the temperature are those of its distance from the reference, 0 to 4.

    Parameters
    ----------
    bias : ndarray, shape (5, 3)
        [m/s^2/degC^i]
    scale : ndarray, shape (4, 5, 3)
        Scale factor at each of the `GAINS` over the ideal one [1/degC^i].
    matrix : ndarray, shape (2, 3, 3)
        M_0 with the misalignment, and its change [1/degC]; row = the sensor that reads.
    zero : ndarray, shape (4, 3)
        Of the electronics at each of the `GAINS` [V at the converter].
    arms : ndarray, shape (3, 3)
        From the axis of the turn to the proof mass of each sensor [m].
    """

    bias: Array
    scale: Array
    matrix: Array
    zero: Array
    arms: Array


@dataclass(frozen=True, eq=False)
class Drawing:
    """What the engineer knows of a head, from the ground; powers of the temperature as those of `Head`.

    Parameters
    ----------
    bias : ndarray, shape (5, 3)
        [m/s^2/degC^i]
    scale : ndarray, shape (4, 5, 3)
        Scale factor at each of the `GAINS` [V/g/degC^i].
    cross : ndarray, shape (2, 3, 3)
        Misalignment [rad/degC^i]; row = the sensor that reads.
    """

    bias: Array
    scale: Array
    cross: Array


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

"""How the simulated vibration test is set up: the item, the sweep, what is recorded."""

from __future__ import annotations

from dataclasses import dataclass, field

from ...core.influence import Influence

SURVEYS = ("before", "after")
CONTROLS = ("control_1", "control_2")
COLUMNS = {"x": "acc_x", "y": "acc_y"}  # accelerometer on the item: along the drive, and across
RUN, PROFILE = "run", "profile.csv"
# [Hz], [g^2/Hz]: table 1 of the thesis, as printed, and with a notch where the first mode of the item may lie
PLAIN = ((20.0, 0.01), (50.0, 0.04), (500.0, 0.04), (2000.0, 0.01))
NOTCH = ((120.0, 0.04), (132.0, 0.01), (154.0, 0.01), (168.0, 0.04))
NODES = (*PLAIN[:2], *NOTCH, *PLAIN[2:])
GYRO = {"x": "gyro_x", "y": "gyro_y"}
RESTS = ("before", "after")
STEPS_DB = (-12.0, -6.0)  # of the level before it is full
CLOCK = Influence(2e-5, "1", certificate="data sheet of the recorder", standard="clock", quantity="rate")

GAINS = Influence(0.01, "1", certificate="simulated", standard="control_accelerometer", quantity="scale_factor")

LATITUDE = 36.6  # [deg]
TABLE = {
    f"rate_table.{quantity}": Influence(u, unit, certificate="simulated", standard="rate_table", quantity=quantity)
    for quantity, u, unit in (("rate", 3e-4, "1"), ("mounting", 1e-3, "rad"))
}


@dataclass(frozen=True)
class Bench:
    """The test as it is made."""

    start: float = 20.0  # of the sweep [Hz]
    stop: float = 1000.0
    per_minute: float = 4.0  # octaves, as they are said
    speed: float = 1.0  # of the sweep over that
    level: float = 0.25  # of the sweep [g]; it is said to have ``said_level``
    said_level: float = 0.25
    sample_rate: float = 5120.0  # [Hz]
    survey_rate: float = 2560.0  # of the surveys, behind a filter that passes no harmonic beyond 0.45 of it [Hz]
    quiet: float = 0.5  # before and after the sweep [s]
    ramp: float = 0.05  # of the level at both ends [s]
    # nominal modes: frequency [Hz], Q, part in the response along and across the drive
    modes: tuple[tuple[float, float, float, float], ...] = (
        (142.0, 28.0, 1.15, 0.10),
        (396.0, 40.0, -0.35, 0.30),
        (710.0, 22.0, 0.25, -0.15),
    )
    spread: float = 0.05  # of frequency and Q from unit to unit (1)
    settling: float = 0.002  # change of frequencies and, tenfold, of Q by a vibration that does no harm (1)
    crack: float = 0.0  # of the frequency of the first mode by the vibration (1); its Q falls by five times as much
    ripple: float = 0.03  # what the controller leaves of the level (1)
    distortion: float = 0.004  # second and third harmonic over the drive (1)
    noise: float = 0.0015  # of an accelerometer, in a sample [g]
    resolution: float = 1e-4  # of what is saved [g]
    fixture: tuple[float, float] = (6000.0, 20.0)  # its own mode at the second control accelerometer [Hz], Q
    clipped: float = 0.0  # where the drive is cut off, over its amplitude; 0 for nowhere
    full_level: float = 20.0  # of the random run at full level, after steps of `step`; 0 for no random run [s]
    step: float = 2.0  # [s]
    random_db: float = 0.0  # of its level over the profile
    unevenness_db: float = 0.3  # what the controller leaves between lines of 25 Hz
    notched: bool = True  # whether the drive of the random run has the notch of its profile
    rest: float = 4.0  # of the record of the gyro before and after the random run [s]
    # gyro beside the first control accelerometer: N [deg/s/sqrt(Hz)], and nominal sensitivities to vibration
    gyro_noise: float = 0.001
    sensitivity: float = 6.0  # with the acceleration [deg/h/g]
    rectification: float = 5.0  # with its square [deg/h/g^2]
    turn_on: float = 0.005  # standard deviation of its bias from power-up to power-up [deg/s]
    power_ups: int = 5  # at rest, before and after the vibration each; 0 for none
    rest_seconds: float = 60.0  # of each
    rest_rate: float = 100.0  # samples [Hz]
    # on a rate table, before and after the vibration in each power-up: rates of the dwells [deg/s], their length [s]
    rates_deg_s: tuple[float, ...] = (0.0, 20.0, -20.0, 60.0, -60.0, 100.0, -100.0, 0.0)
    dwell: float = 6.0
    rate_interval: float = 0.1  # of the averages that are saved [s]
    scale_error: float = 0.005  # standard deviation of the scale factors from unit to unit (1)
    scale_turn_on: float = 1e-4  # from power-up to power-up (1)
    tilt: float = 0.1  # standard uncertainty of how upright the axis of the table stands [deg]
    bias_shift: float = 0.0  # of the gyro's x by the vibration [deg/s]
    scale_shift: float = 0.0  # of its scale factor (1)
    noisier: float = 1.0  # times as much noise in it after the vibration
    swapped: bool = False  # whether the columns of control and response have changed places
    lost: int = 0  # samples that the recorder drops once, without a word
    clock: Influence = field(default_factory=lambda: CLOCK)
    gains: Influence = field(default_factory=lambda: GAINS)  # of the control accelerometers

    @property
    def standards(self) -> dict[str, Influence]:
        """By the names that results give them."""
        run = {"control_accelerometer.scale_factor": self.gains} if self.full_level else {}
        return {"clock.rate": self.clock, **run, **(TABLE if self.power_ups else {})}

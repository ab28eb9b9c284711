"""The rig of a turned mass as it is flown: orbit, masses, programme, noise, errors of the standards, and mistakes.

Sizes follow Figure 15 of [1]_, made whole: 4 kg turn at 0.2 m in a satellite of 1000 kg, 560 km up. The attraction is
0.68 ng; what the orbit does at its rate and twice that is thirty times as large, the gradient of gravity at the head
hundreds of times. Six runs of a day, at four rates of turn and in both senses.

References
----------
.. [1] K. Reinel, NASA TM X-53857, 1969, Figure 15; 10.21 pulses a second and ug in the low range.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from ...core.constants import STANDARD_GRAVITY
from ...core.influence import Influence
from ..twin import Fault

UG = 1e-6 * STANDARD_GRAVITY.value  # [m/s^2]
HOUR, DAY = 3600.0, 86_400.0
NOMINAL = 10.21 / UG  # [pulses/s/(m/s^2)]
PERIODS = (1.0, -1.0, 2.0, -2.0, 0.75, -1.25)  # of the runs; + in the sense of the orbit [h]
MASS = Influence(1e-3, "kg", certificate="balance")
RADIUS = Influence(1e-4, "m", certificate="coordinate measuring machine")
HEIGHT = Influence(2e-3, "m", certificate="drawing of the head")
SATELLITE = Influence(2.0, "kg", certificate="propellant book-keeping")
ORBIT = Influence(1e-4, certificate="orbit determination")


@dataclass(frozen=True)
class Bench:
    """The campaign as it is flown."""

    periods: tuple[float, ...] = PERIODS
    length: float = DAY  # of a run [s]
    pause: float = 3600.0  # from run to run [s]
    gate: float = 100.0  # over which pulses are counted [s]
    mass: float = 4.0  # that turns [kg]
    radius: float = 0.2  # [m]
    satellite: float = 1000.0  # [kg]
    altitude: float = 560e3  # [m]
    offset: float = 2e-3  # scatter of the axis of rotation about the proof mass, in each direction [m]
    zero: float = math.radians(1.0)  # scatter of the zero of the angle [rad]
    alignment: float = math.radians(1.0)  # of the input axis in the plane of the orbit [rad]
    bias_ug: float = 17.0  # bias input that keeps the pulses coming [ug]
    head: float = 1.0  # distance of the head from the centre of mass along the vertical [m]
    lines: tuple[float, ...] = (2e-8, 1e-8)  # that the orbit gives at its rate and twice that [m/s^2]
    # noise of a gate: standard deviation, step of a random walk; range of a smooth drift [pulses/s]
    white: float = 3e-3
    walk: float = 1e-4
    cubic: float = 0.1
    lost: float = 0.01  # fraction of gates that were not saved (1)
    u_mass: Influence = MASS
    u_radius: Influence = RADIUS
    u_height: Influence = HEIGHT
    u_satellite: Influence = SATELLITE
    u_orbit: Influence = ORBIT
    # what the campaign says, where that is something else
    mass_said: float | None = None  # [kg]
    radius_said: float | None = None  # [m]
    gate_said: float | None = None  # [s]
    sense_said: int | None = None  # number of the run whose rate has the wrong sign
    rates_times: float = 1.0  # rates of the programme over true ones
    exchanged: tuple[int, int] | None = None  # numbers of runs whose files were exchanged
    stalled: int | None = None  # number of a run in which the mass did not turn
    disturbed: tuple[int, float] | None = None  # number of a run, and what follows its turn over A (1)
    glitches: tuple[int, int] | None = None  # number of a run, and how many of its readings are false
    jumped: tuple[int, float] | None = None  # number of a run, and a jump of its level [pulses/s]


FAULTS: dict[str, Fault] = {
    "wrong_sense": Fault("the programme has the wrong sense for one run", "wrong_sense", {"sense_said": 2}, "refused"),
    "one_speed": Fault("all runs turn at one rate and in one sense", "one_speed", {"periods": (1.0,) * 5}, "refused"),
    "wrong_mass": Fault("the mass that flew is 3 kg, not 4", "disagrees_with_high_g", {"mass": 3.0, "mass_said": 4.0}),
    "wrong_radius": Fault("the arm is 0.2 m, the campaign states 0.25 m", "recoil_disagrees", {"radius_said": 0.25}),
    "wrong_units": Fault("rates in deg/s are headed rad/s", "nyquist", {"rates_times": math.degrees(1.0)}, "refused"),
    "wrong_gate": Fault(
        "pulses were counted for 100 s, but the campaign states 10 s", "gate_disagrees", {"gate_said": 10.0}, "refused"
    ),
    "exchanged": Fault("the files of two runs were exchanged", "runs_exchanged", {"exchanged": (0, 2)}, "refused"),
    "stalled": Fault("in one run the mass did not turn", "drift_at_turn", {"stalled": 1}),
    "drift_at_turn": Fault("in one run the temperature follows the turn", "drift_at_turn", {"disturbed": (3, 1.0)}),
    "at_the_orbit": Fault(
        "one run turns once an orbit", "orbit_line", {"periods": (1.0, -1.0, 2.0, -2.0, 0.75, 1.5951)}
    ),
    "false_readings": Fault(
        "some readings of one run are far off", "reading_left_out", {"glitches": (1, 6)}, also=("glitch",)
    ),
    "jumped": Fault("the level jumps in one run", "jump", {"jumped": (4, 0.1)}, also=("level_step",)),
}

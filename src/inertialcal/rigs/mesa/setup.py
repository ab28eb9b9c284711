"""The mesa rig as it is built: runs, timing, noise, tilt, errors of the standards, and the mistakes that it can hold.

Sizes follow [1]_: dwells of 100 s with 20 s to move the mass between them, four dwells a cycle, an amplitude of 23 ng
beside a drift of more than 1 ug a run, 10.21 pulses a second and ug in the low range. Noise of a dwell is that which
the noise lines of its best run tell, 0.12 pulses a second; in work hours it is twice as large.

References
----------
.. [1] K. Reinel, NASA TM X-53857, 1969: body text, Table 4, Appendices B and C.
"""

from __future__ import annotations

from dataclasses import dataclass

from ...core.constants import STANDARD_GRAVITY
from ...core.influence import Influence
from ..protocol import Fault

RANGES = {"low": 10.21, "high": 1.024}  # pulses/s/ug
UG = 1e-6 * STANDARD_GRAVITY.value  # [m/s^2]
GATE = 100.0  # over which pulses are counted [s]
WORK = 2.07  # noise in work hours over that after them
LEAD = 11_340.0  # [kg/m^3]
STAND_OFF = 0.076  # from the proof mass to the face of the mass [m]
MASS = 1353.8  # of 100 cubes of 10.2 cm and 100 of 5.1 cm [kg]
STOPS = (0.127, 0.432)  # of the vertical travel [m]
DENSITY = Influence(0.003, certificate="weighed cubes")
PLACING = Influence(0.004, certificate="tape and plumb line")
CONSTANT = Influence(2.2e-5, certificate="CODATA 2022")
MERCURY = Influence(3e-10, "rad", certificate="computed from the shape of the pools")
MERCURY_AMPLITUDE = 9.2e-10  # by which the mass tilts the mercury [rad]


@dataclass(frozen=True)
class Run:
    """One run: its name, whether the mass is moved, and whether people work in the house."""

    name: str
    moved: bool = True
    work: bool = False


RUNS = (
    Run("run1"), Run("run2"), Run("run3"), Run("run4"), Run("run5"), Run("null1", moved=False),
    Run("null2", moved=False, work=True),
)  # fmt: skip


@dataclass(frozen=True)
class Bench:
    """The campaign as it is made.

    Parameters
    ----------
    runs : tuple of Run
        In order.
    dwells : int
        Of each run.
    dwell, move : float
        [s].
    drive : {"sine", "ABAB"}
        Order of the places.
    range : {"low", "high"}
        Of the accelerometer.
    bias_ug : float
        Input that keeps the pulses coming [ug].
    white, flicker, walk : float
        Of a dwell after hours: standard deviation, flicker floor, and step of a random walk [pulses/s].
    cubic, thermostat : float
        Size of the smooth drift, and swing of the thermostat [pulses/s].
    run_to_run : float
        Scatter of the scale factor from run to run, relative (1).
    pad_tilt, pad_noise, meter_noise : float
        Of the pad: tilt in phase with the mass, and by itself; of the meter [rad].
    stop_scatter : float
        Of each stop of the mass, anew for each move [m].
    lost : float
        Part of the dwells whose reading is an error (1).
    density, placing, gravitational_constant : Influence
        Of what is applied, relative.
    mercury : Influence
        Of the tilt that the mass gives to the mercury.
    lighter : float
        Mass of the cubes over that of lead (1).
    slipped : (str, int) or None
        Run, and its dwell from which the mass comes one dwell late.
    no_tilt : str
        Run whose tilt is not recorded; none where empty.
    cut : (str, int) or None
        Run, and the number of dwells after which its record ends.
    gate_said : float
        Gate that the campaign says [s].
    stand_off_said : float
        Stand-off that the campaign says [m].
    """

    runs: tuple[Run, ...] = RUNS
    dwells: int = 100
    dwell: float = 100.0
    move: float = 20.0
    drive: str = "sine"
    range: str = "low"
    bias_ug: float = 17.0
    white: float = 0.105
    flicker: float = 0.060
    walk: float = 0.01
    cubic: float = 0.5
    thermostat: float = 0.3
    run_to_run: float = 0.0
    pad_tilt: float = 1.5e-9
    pad_noise: float = 5e-9
    meter_noise: float = 2e-9
    stop_scatter: float = 1e-3
    lost: float = 0.01
    density: Influence = DENSITY
    placing: Influence = PLACING
    gravitational_constant: Influence = CONSTANT
    mercury: Influence = MERCURY
    lighter: float = 1.0
    slipped: tuple[str, int] | None = None
    no_tilt: str = ""
    cut: tuple[str, int] | None = None
    gate_said: float = GATE
    stand_off_said: float = STAND_OFF


FAULTS: dict[str, Fault] = {
    "slipped": Fault("one move is missed: the mass comes a dwell late", "schedule_slip", {"slipped": ("run2", 40)}),
    "not_whole_cycles": Fault("the runs end within a cycle", "not_whole_cycles", {"dwells": 98}),
    "no_tilt": Fault("the tilt meter of a run was not recorded", "missing_tilt", {"no_tilt": "run3"}),
    "cut_off": Fault("a record ends before its schedule does", "length_differs", {"cut": ("run4", 60)}),
    "wrong_gate": Fault("pulses were counted for 100 s, not 10 s", "gate_disagrees", {"gate_said": 10.0}),
    "wooden": Fault("the cubes are of wood", "below_floor", {"lighter": 0.05}),
    "overlap": Fault("the mass stands where the instrument is", "overlap", {"stand_off_said": -0.02}),
}

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
from ..twin import Fault

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
    """The campaign as it is made."""

    runs: tuple[Run, ...] = RUNS  # in order
    dwells: int = 100  # of each run
    # [s]
    dwell: float = 100.0
    move: float = 20.0
    drive: str = "sine"  # {"sine", "ABAB"}: order of the places
    range: str = "low"  # {"low", "high"}: of the accelerometer
    bias_ug: float = 17.0  # bias input that keeps the pulses coming [ug]
    # noise of a dwell after hours: standard deviation, flicker floor, random-walk step [pulses/s]
    white: float = 0.105
    flicker: float = 0.060
    walk: float = 0.01
    # size of the smooth drift, and swing of the thermostat [pulses/s]
    cubic: float = 0.5
    thermostat: float = 0.3
    run_to_run: float = 0.0  # scatter of the scale factor from run to run, relative (1)
    # pad tilt in phase with the mass, its own noise, and noise of the meter [rad]
    pad_tilt: float = 1.5e-9
    pad_noise: float = 5e-9
    meter_noise: float = 2e-9
    stop_scatter: float = 1e-3  # scatter of each stop of the mass [m]
    lost: float = 0.01  # fraction of dwells with a failed reading (1)
    # relative uncertainty of the applied input
    density: Influence = DENSITY
    placing: Influence = PLACING
    gravitational_constant: Influence = CONSTANT
    mercury: Influence = MERCURY  # uncertainty of the mercury tilt caused by the mass
    lighter: float = 1.0  # mass of the cubes relative to lead (1)
    slipped: tuple[str, int] | None = None  # run, and the dwell from which the mass is one dwell late
    no_tilt: str = ""  # run without a tilt record; empty for none
    cut: tuple[str, int] | None = None  # run, and the dwell at which its record ends
    gate_said: float = GATE  # gate stated in the campaign [s]
    stand_off_said: float = STAND_OFF  # stand-off stated in the campaign [m]


FAULTS: dict[str, Fault] = {
    "slipped": Fault("one move is missed: the mass is a dwell late", "schedule_slip", {"slipped": ("run2", 40)}),
    "not_whole_cycles": Fault("the runs end within a cycle", "not_whole_cycles", {"dwells": 98}),
    "no_tilt": Fault("the tilt of one run is missing", "missing_tilt", {"no_tilt": "run3"}),
    "cut_off": Fault("a record ends before its schedule does", "length_differs", {"cut": ("run4", 60)}),
    "wrong_gate": Fault(
        "pulses were counted for 100 s, but the campaign states 10 s", "gate_disagrees", {"gate_said": 10.0}
    ),
    "wooden": Fault("the cubes are of wood", "below_floor", {"lighter": 0.05}, "covered"),
    "overlap": Fault("the mass stands where the instrument is", "overlap", {"stand_off_said": -0.02}),
}

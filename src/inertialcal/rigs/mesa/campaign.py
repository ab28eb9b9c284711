"""campaign.toml of a simulated mass-attraction test, as its engineer would write it: without a word of the truth."""

from __future__ import annotations

from ...core.influence import Influence
from ...core.recording import SECOND
from ...core.times import instant_text
from ..protocol import SEAL, SEED
from .setup import LEAD, MASS, MERCURY_AMPLITUDE, RANGES, Bench, Run

TIME, PULSES, TILT, TEMPERATURE = "unix_s", "pulses", "tilt_rad", "case_degc"
SCHEDULE = "schedule.csv"
BEGIN = 1_272_412_800  # 2010-04-28 00:00:00 UTC [s]
APART = 86_400  # from run to run [s]
START_OF_DAY = {True: 10 * 3600, False: 20 * 3600}  # start of a run in work hours, and after them [s]


def recording_file(run: Run) -> str:
    """Return the file of a run, in the campaign folder."""
    return f"recordings/{run.name}.csv"


def begin(number: int, run: Run) -> int:
    """Return when the first dwell of a run starts, counted from 0 [s, UNIX]."""
    return BEGIN + number * APART + START_OF_DAY[run.work]


def campaign_text(bench: Bench) -> str:
    """Return the text of campaign.toml, with the marks for the seed and for the seal of the truth."""
    runs = "\n".join(_recording(bench, number, run) for number, run in enumerate(bench.runs))
    return f"{_head(bench)}\n{runs}\n{_test(bench)}"


def _stated(one: Influence, unit: str = "%") -> str:
    u = f"{100.0 * one.u:.6g} %" if unit == "%" else f"{one.u:.6g} {unit}"
    return f'{{ u = "{u}", certificate = "{one.certificate}" }}'


def _head(bench: Bench) -> str:
    return f"""\
# A simulated campaign: an accelerometer is calibrated with the attraction of lead that is moved before it.
# The true values lie in .truth/, which nothing but `inertialcal score` reads. Delete it, and `run` gives the same.
schema = 1

[campaign]
id = "mesa-{SEED}"
title = "Scale factor of a simulated accelerometer from a moved mass"
source = "simulated: rig mesa, seed {SEED}; truth sealed with SHA-256 {SEAL}"

[item]
maker = "inertialcal"
part = "simulated electrostatic accelerometer"
serial = "{SEED}"

[standards.source_mass]
density = {_stated(bench.density)}
placing = {_stated(bench.placing)}
gravitational_constant = {_stated(bench.gravitational_constant)}

[standards.tilt_meter]
mercury = {_stated(bench.mercury, "rad")}

[sensors.mesa]
kind = "accelerometer"
axes = ["x"]
unit = "ug"
chain = {{ kind = "pulse_rate", gate = "{bench.gate_said:g} s", scale_factor = "{RANGES[bench.range]:g} count/s/ug" }}

# A row is a dwell: {bench.dwell:g} s of pulses, then {bench.move:g} s to move the mass.
# Some readings were errors and are not there.
"""


def _recording(bench: Bench, number: int, run: Run) -> str:
    clock = f'column = "{TIME}", stamp = "end", interval = "{bench.dwell + bench.move:g} s"'
    moved = "" if run.moved else ", moved = false"
    return f"""\
[recordings.{run.name}]
sensor = "mesa"
file = "{recording_file(run)}"
run = "{run.name}"
clock = {{ {clock}, averaging = "{bench.dwell:g} s" }}
mass = {{ schedule = "{SCHEDULE}", begin = "{instant_text(begin(number, run) * SECOND)}"{moved} }}
[recordings.{run.name}.channels]
x = {{ column = "{PULSES}", unit = "count" }}
tilt = {{ column = "{TILT}", unit = "rad" }}
temperature = {{ column = "{TEMPERATURE}", unit = "degC" }}
"""


def _test(bench: Bench) -> str:
    names = ", ".join(f'"{run.name}"' for run in bench.runs)
    stated = RANGES[bench.range]
    return f"""\
[[tests]]
id = "calibration"
procedure = "mass_attraction"
recordings = [{names}]
[tests.plan]
tilt = "known"                 # a tilt of the pad is felt as gravity times it
mercury = "{bench.lighter * MERCURY_AMPLITUDE:g} rad"  # that the mass tilts the mercury of the meter by
source = {{ mass = "{MASS:g} kg", density = "{LEAD:g} kg/m^3", stand_off = "{bench.stand_off_said:g} m" }}
high_g = {{ scale_factor = "{stated:g} count/s/ug", u = "{0.005 * stated:.4g} count/s/ug" }}

[[requirements]]
id = "R1"
text = "scale factor within 10 % of the data sheet"
quantity = "scale_factor"
lower = "{0.9 * stated:.4g} count/s/ug"
upper = "{1.1 * stated:.4g} count/s/ug"
"""

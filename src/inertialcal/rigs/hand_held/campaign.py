"""campaign.toml of an IMU laid by hand, as its engineer would write it: without a word of the truth."""

from __future__ import annotations

from collections.abc import Sequence

from ..protocol import SEAL, SEED
from .setup import Bench

TIME = "unix_s"
TITLES = {"hand_held": "Positions of a simulated IMU", "six_faces": "Six faces and three turns of a simulated IMU"}
LAID = {"hand_held": "into many positions", "six_faces": "on its six faces, and turned about its axes"}
REQUIRED = {
    "hand_held": """\
text = "gravity, carried by the gyros through a turn by hand, arrives within half a degree (rms)"
quantity = "transition_error"
upper = "0.5 deg"
""",
    "six_faces": """\
text = "scale factors within 5 % of the nominal ones"
quantity = "scale_factor_error"
lower = "-5 %"
upper = "5 %"
""",
}
SENSORS = {"acc": ("accelerometer", "m/s^2"), "gyro": ("gyro", "rad/s")}  # kind, and unit of the channels


def recording_name(number: int) -> str:
    """Return the name of a record in the campaign."""
    return f"hand{number}"


def recording_file(number: int) -> str:
    """Return the file of a record, in the campaign folder."""
    return f"recordings/{recording_name(number)}.csv"


def protocol_file(number: int) -> str:
    """Return the file of the protocol of a record, in the campaign folder."""
    return f"protocols/{recording_name(number)}.csv"


def campaign_text(bench: Bench, rig: str, count: int) -> str:
    """Return the text of campaign.toml, with the marks for the seed and for the seal of the truth.

    Parameters
    ----------
    rig : str
        Its name.
    count : int
        Recordings.
    """
    held = (count,) if bench.records > 1 and bench.copies == 1 else ()
    fitted = [number for number in range(1, count + 1) if number not in held]
    records = "\n".join(_entry(bench, number, sensor) for number in range(1, count + 1) for sensor in SENSORS)
    fixture = ""
    if bench.variant == "ferraris":
        fixture = f"""
[standards.turn]
angle = {{ u = "{bench.angle.u:g} rad", certificate = "{bench.angle.certificate}" }}

[standards.fixture]
orientation = {{ u = "{bench.orientation.u:g} rad", certificate = "{bench.orientation.certificate}" }}
mounting = {{ u = "{bench.mounting.u:g} rad", certificate = "{bench.mounting.certificate}" }}
"""
    return f"""\
# A simulated campaign: an IMU laid by hand {LAID[rig]}.
# The true values lie in .truth/, which nothing but `inertialcal score` reads. Delete it, and `run` gives the same.
schema = 1

[campaign]
id = "{rig}-{SEED}"
title = "{TITLES[rig]}"
source = "simulated: rig {rig}, seed {SEED}; truth sealed with SHA-256 {SEAL}"

[item]
maker = "inertialcal"
part = "simulated IMU"
serial = "{SEED}"

[site]
gravity = "{bench.gravity:g} m/s2"
latitude = "{bench.latitude:g} rad"

[standards.gravity]
value = {{ u = "{bench.gravity_error.u:g} m/s2", certificate = "{bench.gravity_error.certificate}" }}

[standards.clock]
rate = {{ u = "{1e6 * bench.clock.u:g} ppm", certificate = "{bench.clock.certificate}" }}
{fixture}
[sensors.acc]
kind = "accelerometer"
axes = ["x", "y", "z"]
unit = "m/s2"

[sensors.gyro]
kind = "gyro"
axes = ["x", "y", "z"]
unit = "deg/s"

{records}
{_test("imu", fitted, "fit")}
{_test("imu_held_out", held, "hold_out") if held else ""}\
[[requirements]]
id = "R1"
{REQUIRED[rig]}"""


def _entry(bench: Bench, number: int, sensor: str) -> str:
    """Return the entry of the channels of one sensor in a record."""
    unit = SENSORS[sensor][1]
    interval = f"{bench.pace / bench.sample_rate:g} s"
    clock = f'column = "{TIME}", stamp = "end", interval = "{interval}", averaging = "{interval}"'
    sections = f'sections = "{protocol_file(number)}"\n' if bench.variant == "ferraris" else ""
    channels = ", ".join(f'{axis} = {{ column = "{sensor}_{axis}", unit = "{unit}" }}' for axis in "xyz")
    return (
        f'[recordings.{sensor}{number}]\nsensor = "{sensor}"\nfile = "{recording_file(number)}"\n'
        f"clock = {{ {clock} }}\nchannels = {{ {channels} }}\n{sections}"
    )


def _test(name: str, numbers: Sequence[int], use: str) -> str:
    """Return a test of both sensors on some of the records."""
    names = ", ".join(f'"{sensor}{number}"' for number in numbers for sensor in SENSORS)
    return f'[[tests]]\nid = "{name}"\nprocedure = "positions"\nrecordings = [{names}]\nuse = "{use}"\n'

"""campaign.toml of a simulated gyro that stands still, as its engineer would write it: without a word of the truth."""

from __future__ import annotations

from ...core.axes import AXES
from ..protocol import SEAL, SEED
from .setup import Bench

TIME = "unix_s"


def recording_name(number: int) -> str:
    """Return the name of a record in the campaign."""
    return f"still{number}"


def recording_file(number: int) -> str:
    """Return the file of a record, in the campaign folder."""
    return f"recordings/{recording_name(number)}.csv"


def campaign_text(bench: Bench) -> str:
    """Return the text of campaign.toml, with the marks for the seed and for the seal of the truth."""
    numbers = range(1, bench.records + 1)
    names = ", ".join(f'"{recording_name(number)}"' for number in numbers)
    channels = ", ".join(f'{axis} = {{ column = "{axis}", unit = "deg/s" }}' for axis in AXES)
    clock = f'column = "{TIME}", stamp = "end", interval = "{bench.interval:g} s", averaging = "{bench.averaging:g} s"'
    records = "\n".join(
        f'[recordings.{recording_name(number)}]\nsensor = "suite"\nfile = "{recording_file(number)}"\n'
        f"clock = {{ {clock} }}\nchannels = {{ {channels} }}\n"
        for number in numbers
    )
    return f"""\
# A simulated campaign: a three-axis rate gyro that stands still.
# The true values lie in .truth/, which nothing but `inertialcal score` reads. Delete it, and `run` gives the same.
schema = 1

[campaign]
id = "still_gyro-{SEED}"
title = "Noise of a simulated three-axis gyro"
source = "simulated: rig still_gyro, seed {SEED}; truth sealed with SHA-256 {SEAL}"

[item]
maker = "inertialcal"
part = "simulated rate gyro"
serial = "{SEED}"

[standards.sensor]
scale_factor = {{ u = "{100.0 * bench.scale_factor.u:g} %", certificate = "{bench.scale_factor.certificate}" }}

[sensors.suite]
kind = "gyro"
axes = ["x", "y", "z"]
unit = "deg/s"

# Each average lasts {bench.averaging:g} s, and one is saved every {bench.interval:g} s.
{records}
[[tests]]
id = "noise"
procedure = "static_noise"
recordings = [{names}]

[[requirements]]
id = "R1"
text = "angle random walk at most 0.36 deg/sqrt(h)"
quantity = "angle_random_walk"
upper = "0.36 deg/sqrt(h)"

[[requirements]]
id = "R2"
text = "bias instability at most 20 deg/h"
quantity = "bias_instability"
upper = "20 deg/h"
"""

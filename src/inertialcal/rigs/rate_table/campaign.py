"""campaign.toml of the simulated rate-table test, as its engineer would write it: without a word of the truth."""

from __future__ import annotations

import json
from collections.abc import Iterable

import numpy as np

from ...core.axes import AXES
from ...core.influence import Influence
from ..parts.standards import standard_tables
from ..protocol import SEAL, SEED
from .setup import CODES, INVERTED, SCALE_FACTOR_V_PER_DEG_S, VALID_VOLTS, Bench

TIME = "unix_s"
APPLIED = "rate_dps"


def recording_name(axis: str, run: int) -> str:
    """Return the name of a recording in the campaign."""
    return f"{axis}_run{run}"


def recording_file(axis: str, run: int) -> str:
    """Return the file of a recording, in the campaign folder."""
    return f"recordings/{recording_name(axis, run)}.csv"


def reference_column(axis: str) -> str:
    """Return the column of the reference voltage of a sensor."""
    return f"{axis}_ref"


def validity_column(axis: str) -> str:
    """Return the column of the built-in test of a sensor."""
    return f"{axis}_bit"


def campaign_text(bench: Bench) -> str:
    """Return the text of campaign.toml, with the marks for the seed and for the seal of the truth."""
    runs = range(1, bench.runs + 1)
    held = runs[bench.fit_runs :]
    parts = [
        _head(bench),
        _standards(bench),
        _sensor(bench),
        *(_recording(bench, axis, run) for run in runs for axis in bench.turned),
        _test(bench, "fit", "fit", runs[: bench.fit_runs], "the model is fitted on the first power-ups"),
        *([_test(bench, "check", "hold_out", held, "and judged by power-ups that it has not seen")] if held else []),
        REQUIREMENT,
    ]
    return "\n".join(parts)


def _head(bench: Bench) -> str:
    return f"""\
# A simulated campaign: a three-axis rate gyro on a stepped rate table.
# The true values lie in .truth/, which nothing but `inertialcal score` reads. Delete it, and `run` gives the same.
schema = 1

[campaign]
id = "rate_table-{SEED}"
title = "Rate table test of a simulated three-axis gyro"
source = "simulated: rig rate_table, seed {SEED}; truth sealed with SHA-256 {SEAL}"

[item]
maker = "inertialcal"
part = "simulated rate gyro"
serial = "{SEED}"

[site]
latitude = "{bench.latitude_deg:g} deg"  # geodetic
"""


def _standards(bench: Bench) -> str:
    """Return the tables of the standards; an error of each was drawn with this uncertainty."""
    return "# Each error is one unknown value for the whole campaign.\n" + standard_tables(bench.standards, _entry)


def _entry(influence: Influence) -> str:
    key, size = ("u", influence.u)
    if influence.distribution == "rectangular":
        key, size = "half_width", influence.u * float(np.sqrt(3.0))
    text = f"{100.0 * size:.12g} %" if influence.unit == "1" else f"{size:.12g} {influence.unit}"
    dof = f", dof = {influence.dof:g}" if np.isfinite(influence.dof) else ""
    return f"{{ {key} = {json.dumps(text)}{dof}, certificate = {json.dumps(influence.certificate)} }}"


def _sensor(bench: Bench) -> str:
    rows = ", ".join(str([sign if i == j else 0 for j in range(3)]) for i, sign in enumerate(INVERTED))
    return f"""\
[sensors.suite]
kind = "gyro"
axes = ["x", "y", "z"]
unit = "deg/s"
range = ["-5 deg/s", "5 deg/s"]
mounting = [{rows}]  # sensor from body: x and z are mounted inverted
# Codes are means of {bench.averaged} conversions. A reading counts while its built-in test is high.
chain = {{ kind = "adc", lsb = "5 V / 4095", counts = {list(CODES)}, reference = "channel", \
scale_factor = "{SCALE_FACTOR_V_PER_DEG_S:g} V/(deg/s)", validity_minimum = "{VALID_VOLTS:g} V" }}
"""


def _recording(bench: Bench, axis: str, run: int) -> str:
    return f"""\
[recordings.{recording_name(axis, run)}]
sensor = "suite"
file = "{recording_file(axis, run)}"
axis = "{axis}"
run = "{run}"  # power-up
clock = {{ column = "{TIME}", stamp = "end", interval = "{bench.interval:g} s", averaging = "{bench.averaging:g} s" }}
channels = {{ {_channels(bench)} }}
"""


def _channels(bench: Bench) -> str:
    columns = {axis: axis for axis in AXES}
    if bench.reference_saved:
        columns |= {f"reference_{axis}": reference_column(axis) for axis in AXES}
    columns |= {f"validity_{axis}": validity_column(axis) for axis in AXES}
    texts = [f'{what} = {{ column = "{column}", unit = "count" }}' for what, column in columns.items()]
    return ", ".join([f'applied = {{ column = "{APPLIED}", unit = "deg/s" }}', *texts])


def _test(bench: Bench, name: str, use: str, runs: Iterable[int], why: str) -> str:
    names = ",\n".join("  " + ", ".join(f'"{recording_name(axis, run)}"' for axis in bench.turned) for run in runs)
    attitude = f'tilt = "{bench.tilt_deg:g} deg", u = "{bench.u_tilt_deg:g} deg"'
    attitude += f', azimuth = "{bench.azimuth_deg:g} deg", u_azimuth = "{bench.u_azimuth_deg:g} deg"'
    return f"""\
[[tests]]  # {why}
id = "{name}"
procedure = "rate_table"
use = "{use}"
recordings = [
{names},
]
plan = {{ attitude = {{ {attitude} }} }}
"""


REQUIREMENT = """\
[[requirements]]
id = "R1"
text = "expected error of rate within 5 % from 1.5 deg/s on"
quantity = "rate_error"
of = "expected"
limit = "5 %"
where = "abs(rate) >= 1.5 deg/s"
"""

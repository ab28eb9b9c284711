"""campaign.toml of the simulated rate suite, as its engineer would write it: without a word of the truth."""

from __future__ import annotations

import json
from collections.abc import Iterable

from ...core.axes import AXES
from ...core.influence import Influence
from ...sensors.catalogue import SLOPE, T_REFERENCE
from ..parts.standards import standard_tables
from ..protocol import SEAL, SEED
from .logger import APPLIED, PRESSURE, column
from .names import recording_file, recording_name
from .setup import (
    AVERAGED,
    AVERAGING,
    CODES,
    INTERVAL,
    INVERTED,
    SCALE_FACTOR_V_PER_DEG_S,
    VALID_VOLTS,
    Bench,
    nominal_volts,
)
from .tests import requirements_of, tests_of

TIME = "unix_s"


def campaign_text(bench: Bench) -> str:
    """Return the text of campaign.toml, with the marks for the seed and for the seal of the truth."""
    recordings = [text for part in bench.parts for text in _recordings(bench, part)]
    tests = [text for part in bench.parts for text in tests_of(bench, part)]
    return "\n".join([_head(bench), _standards(bench), _sensor(bench), *recordings, *tests, *requirements_of(bench)])


def _head(bench: Bench) -> str:
    return f"""\
# A simulated campaign: three rate sensors in a thermal chamber, on a rate table and at rest.
# The true values lie in .truth/, which nothing but `inertialcal score` reads. Delete it, and `run` gives the same.
schema = 1

[campaign]
id = "npsat1-{SEED}"
title = "Thermal, vacuum, rate table and noise tests of a simulated rate-sensor suite"
source = "simulated: rig npsat1, seed {SEED}; truth sealed with SHA-256 {SEAL}"

[item]
maker = "inertialcal"
part = "simulated rate-sensor suite"
serial = "{SEED}"

[site]
latitude = "{bench.latitude_deg:g} deg"  # geodetic
"""


def _standards(bench: Bench) -> str:
    """Return the tables of the standards; an error of each was drawn with this uncertainty."""
    return "# Each error is one unknown value for the whole campaign.\n" + standard_tables(bench.standards, _entry)


def _entry(influence: Influence) -> str:
    text = f"{100.0 * influence.u:.12g} %" if influence.unit == "1" else f"{influence.u:.12g} {influence.unit}"
    return f"{{ u = {json.dumps(text)}, certificate = {json.dumps(influence.certificate)} }}"


def _sensor(bench: Bench) -> str:
    rows = ", ".join(str([sign if i == j else 0 for j in range(3)]) for i, sign in enumerate(INVERTED))
    voltage = ", ".join(f'{axis} = "{volts:g} V"' for axis, volts in zip(AXES, nominal_volts(bench), strict=True))
    at = ", ".join(f'{axis} = "{degc:g} degC"' for axis, degc in zip(AXES, T_REFERENCE, strict=True))
    return f"""\
[sensors.suite]
kind = "gyro"
axes = ["x", "y", "z"]
unit = "deg/s"
range = ["-5 deg/s", "5 deg/s"]
mounting = [{rows}]  # sensor from body: x and z are mounted inverted

# Codes are means of {AVERAGED} conversions. A reading counts while its built-in test is high.
[sensors.suite.chain]
kind = "adc"
lsb = "5 V / 4095"
counts = {list(CODES)}
reference = "channel"
scale_factor = "{SCALE_FACTOR_V_PER_DEG_S:g} V/(deg/s)"
validity_minimum = "{VALID_VOLTS:g} V"
thermometer = {{ slope = "{SLOPE:g} V/degC", voltage = {{ {voltage} }}, temperature = {{ {at} }} }}
"""


def _recordings(bench: Bench, part: str) -> list[str]:
    """Return the recordings of a part of the campaign, a table each."""
    if part == "thermal":
        gauge = [f'pressure = {{ column = "{PRESSURE}", unit = "Torr" }}']
        named = [(where, number) for where in bench.chambers for number in range(1, bench.chamber_runs + 1)]
        return [_recording(bench, where, number, recording_name(where, number), gauge) for where, number in named]
    if part == "rate_table":
        applied = [f'applied = {{ column = "{APPLIED}", unit = "deg/s" }}']
        runs = range(1, bench.table_runs + 1)
        return [_recording(bench, axis, number, f"table_{number}", applied) for number in runs for axis in AXES]
    runs = range(1, bench.static_runs + 1)
    return [_recording(bench, "static", number, recording_name("static", number), []) for number in runs]


def _recording(bench: Bench, what: str, number: int, run: str, others: Iterable[str]) -> str:
    channels = ", ".join([*others, *_channels(bench)])
    axis = f'axis = "{what}"\n' if what in AXES else ""
    return f"""\
[recordings.{recording_name(what, number)}]
sensor = "suite"
file = "{recording_file(what, number)}"
{axis}run = "{run}"  # power-up
clock = {{ column = "{TIME}", stamp = "end", interval = "{INTERVAL} s", averaging = "{AVERAGING:g} s" }}
channels = {{ {channels} }}
"""


def _channels(bench: Bench) -> list[str]:
    kinds = {"": "rate", "reference_": "ref", "temperature_": "temp", "temperature_reference_": "temp_ref"}
    kinds |= {"validity_": "bit"}
    if not bench.reference_saved:
        del kinds["reference_"]
    return [
        f'{prefix}{axis} = {{ column = "{column(what, axis)}", unit = "count" }}'
        for prefix, what in kinds.items()
        for axis in AXES
    ]

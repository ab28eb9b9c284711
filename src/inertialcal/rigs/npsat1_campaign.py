"""campaign.toml of the simulated rate suite, as its engineer would write it: without a word of the truth."""

from __future__ import annotations

import json
from collections.abc import Iterable

from ..core.influence import Influence
from ..sensors.catalogue import SLOPE, T_REFERENCE
from .npsat1_logger import APPLIED, BEGIN, DAY, PRESSURE, column
from .npsat1_setup import (
    AIR,
    AVERAGED,
    AVERAGING,
    AXES,
    CODES,
    INTERVAL,
    INVERTED,
    SCALE_FACTOR_V_PER_DEG_S,
    VACUUM,
    VALID_VOLTS,
    Bench,
    nominal_volts,
)
from .twin import SEAL, SEED

TIME = "unix_s"
REFERENCE_DEGC = 20.0  # of the powers of temperature
AT_DEGC = (-20.0, 0.0, 20.0, 60.0)  # where the bias is told too
NAMES = {AIR: "thermal_ambient", VACUUM: "thermal_vacuum", "rate_table": "rate", "noise": "noise"}
WORDS = {AIR: "in air", VACUUM: "in vacuum"}


def test_name(what: str) -> str:
    """Return the name of the test that fits a condition or a part."""
    return NAMES[what]


def degrees(temperature: float) -> str:
    """Return a temperature as a condition and a setting have it."""
    return f"{temperature:g} degC"


def recording_name(what: str, number: int) -> str:
    """Return the name of a recording: of a condition, of an axis that is turned, at rest."""
    return f"{what}_run{number}" if what in AXES else f"{what}_{number}"


def recording_file(what: str, number: int) -> str:
    """Return the file of a recording, in the campaign folder."""
    return f"recordings/{recording_name(what, number)}.csv"


def campaign_text(bench: Bench) -> str:
    """Return the text of campaign.toml, with the marks for the seed and for the seal of the truth."""
    parts = {"thermal": _thermal, "rate_table": _rate_table, "noise": _noise}
    recordings, tests = [], []
    for part in bench.parts:
        named, tested = parts[part](bench)
        recordings += named
        tests += tested
    return "\n".join([_head(bench), _standards(bench), _sensor(bench), *recordings, *tests, *_requirements(bench)])


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
    tables: dict[str, list[str]] = {}
    for name, influence in bench.standards.items():
        standard, _, quantity = name.partition(".")
        tables.setdefault(standard, []).append(f"{quantity} = {_entry(influence)}")
    blocks = ["\n".join([f"[standards.{name}]", *lines]) for name, lines in tables.items()]
    return "# Each error is one unknown value for the whole campaign.\n" + "\n\n".join(blocks) + "\n"


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


def _test(name: str, procedure: str, use: str, recordings: Iterable[str], plan: str, why: str, *lines: str) -> str:
    names = ", ".join(f'"{one}"' for one in recordings)
    more = "".join(f"{line}\n" for line in lines)
    return f"""\
[[tests]]  # {why}
id = "{name}"
procedure = "{procedure}"
use = "{use}"
recordings = [{names}]
{more}plan = {{ {plan} }}
"""


def _thermal(bench: Bench) -> tuple[list[str], list[str]]:
    pressure = [f'pressure = {{ column = "{PRESSURE}", unit = "Torr" }}']
    runs = range(1, bench.chamber_runs + 1)
    recordings = [
        _recording(bench, where, number, recording_name(where, number), pressure)
        for where in bench.chambers
        for number in runs
    ]
    at = ", ".join(f'"{degrees(one)}"' for one in AT_DEGC)
    attitude = _attitude(
        bench.chamber_tilt_deg, bench.u_chamber_tilt_deg, bench.chamber_azimuth_deg, bench.u_chamber_azimuth_deg
    )
    plan = f'at = [{at}], reference_temperature = "{degrees(REFERENCE_DEGC)}", {attitude}'
    return recordings, [text for where in bench.chambers for text in _thermal_tests(bench, where, plan)]


def _thermal_tests(bench: Bench, where: str, plan: str) -> list[str]:
    names = [recording_name(where, number) for number in range(1, bench.chamber_runs + 1)]
    fit, held = names[: bench.chamber_fit_runs], names[bench.chamber_fit_runs :]
    lines = [f'condition = "{where}"']
    against = [f'against = "{NAMES[AIR]}"'] if where == VACUUM and AIR in bench.chambers else []
    windows = _windows(bench) if bench.overlapping and where == AIR else ([], [])
    if windows[1]:
        held = [*held, fit[-1]]
    name = NAMES[where]
    found = [
        _test(name, "thermal", "fit", fit, plan, f"bias over temperature {WORDS[where]}", *lines, *against, *windows[0])
    ]
    if held:
        why = "and judged on power-ups that it has not seen"
        found.append(_test(f"{name}_check", "thermal", "hold_out", held, plan, why, *lines, *windows[1]))
    return found


def _windows(bench: Bench) -> tuple[list[str], list[str]]:
    """Windows of a fit and of a hold-out test on the same recordings that have some hours in common."""
    first = BEGIN
    last = BEGIN + DAY * (bench.chamber_runs + 1)
    shared = BEGIN + DAY * (bench.chamber_fit_runs - 1) + 7_200
    return [f"windows = [[{first}, {last}]]"], [f"windows = [[{shared}, {last}]]"]


def _rate_table(bench: Bench) -> tuple[list[str], list[str]]:
    runs = range(1, bench.table_runs + 1)
    applied = [f'applied = {{ column = "{APPLIED}", unit = "deg/s" }}']
    recordings = [_recording(bench, axis, number, f"table_{number}", applied) for number in runs for axis in AXES]
    attitude = _attitude(bench.tilt_deg, bench.u_tilt_deg, bench.azimuth_deg, bench.u_azimuth_deg)
    names = {number: [recording_name(axis, number) for axis in AXES] for number in runs}
    fit, held = runs[: bench.table_fit_runs], runs[bench.table_fit_runs :]
    fitted = [name for number in fit for name in names[number]]
    rest = f"{attitude}, zero_reference = true"
    tests = [
        _test(NAMES["rate_table"], "rate_table", "fit", fitted, attitude, "the model is fitted on these power-ups")
    ]
    if held:
        left = [name for number in held for name in names[number]]
        why = "and judged by power-ups that it has not seen"
        tests.append(_test("rate_check", "rate_table", "hold_out", left, attitude, why))
    if bench.zero_reference:
        every = [name for number in runs for name in names[number]]
        why = "all of them with the reading at rest taken off"
        tests.append(_test("rate_from_rest", "rate_table", "report_only", every, rest, why))
    return recordings, tests


def _noise(bench: Bench) -> tuple[list[str], list[str]]:
    names = [recording_name("static", number) for number in range(1, bench.static_runs + 1)]
    recordings = [_recording(bench, "static", number, name, []) for number, name in enumerate(names, 1)]
    return recordings, [_test(NAMES["noise"], "static_noise", "fit", names, "", "noise of the unit at rest")]


def _attitude(tilt: float, u_tilt: float, azimuth: float, u_azimuth: float) -> str:
    return (
        f'attitude = {{ tilt = "{tilt:g} deg", u = "{u_tilt:g} deg", '
        f'azimuth = "{azimuth:g} deg", u_azimuth = "{u_azimuth:g} deg" }}'
    )


def _requirements(bench: Bench) -> list[str]:
    found = []
    if "rate_table" in bench.parts:
        found += [FROM_REST, AS_IT_IS] if bench.zero_reference else [AS_IT_IS]
    if "thermal" in bench.parts:
        low, high = bench.required_degc
        found.append(OVER_TEMPERATURE.format(low=low, high=high))
    return found


FROM_REST = """\
[[requirements]]
id = "R1"
text = "error of rate within 5 % from 0.1 deg/s on, means over 60 s less the reading at rest"
quantity = "rate_error"
of = "dwell_mean"
zero_reference = true
limit = "5 %"
where = "abs(rate) >= 0.1 deg/s"
"""
AS_IT_IS = """\
[[requirements]]
id = "R2"
text = "the same without a reading at rest"
quantity = "rate_error"
of = "dwell_mean"
zero_reference = false
limit = "5 %"
where = "abs(rate) >= 0.1 deg/s"
"""
OVER_TEMPERATURE = """\
[[requirements]]
id = "R3"
text = "bias within 0.4 deg/s over temperature"
quantity = "bias"
limit = "0.4 deg/s"
tests = ["thermal_ambient"]
where = "temperature >= {low:g} degC and temperature <= {high:g} degC"
"""

"""Tests and requirements in campaign.toml of the simulated rate suite."""

from __future__ import annotations

from collections.abc import Iterable

from ...core.axes import AXES
from .logger import BEGIN, DAY
from .names import NAMES, degrees, recording_name
from .setup import AIR, VACUUM, Bench

REFERENCE_DEGC = 20.0  # of the powers of temperature
AT_DEGC = (-20.0, 0.0, 20.0, 60.0)  # where the bias is told too
WORDS = {AIR: "in air", VACUUM: "in vacuum"}


def tests_of(bench: Bench, part: str) -> list[str]:
    """Return the tests of a part of the campaign, a table each."""
    return {"thermal": _thermal, "rate_table": _rate_table, "noise": _noise}[part](bench)


def requirements_of(bench: Bench) -> list[str]:
    """Return the requirements, a table each."""
    found = []
    if "rate_table" in bench.parts:
        found += [FROM_REST, AS_IT_IS] if bench.zero_reference else [AS_IT_IS]
    if "thermal" in bench.parts:
        low, high = bench.required_degc
        found.append(OVER_TEMPERATURE.format(low=low, high=high))
    return found


def _test(name: str, procedure: str, use: str, recordings: Iterable[str], plan: str, why: str, *lines: str) -> str:
    names = ", ".join(f'"{one}"' for one in recordings)
    settings = [f"plan = {{ {plan} }}"] if plan else []
    more = "".join(f"{line}\n" for line in [*lines, *settings])
    return f"""\
[[tests]]  # {why}
id = "{name}"
procedure = "{procedure}"
use = "{use}"
recordings = [{names}]
{more}"""


def _thermal(bench: Bench) -> list[str]:
    at = ", ".join(f'"{degrees(one)}"' for one in AT_DEGC)
    attitude = _attitude(
        bench.chamber_tilt_deg, bench.u_chamber_tilt_deg, bench.chamber_azimuth_deg, bench.u_chamber_azimuth_deg
    )
    plan = f'at = [{at}], reference_temperature = "{degrees(REFERENCE_DEGC)}", {attitude}'
    return [text for where in bench.chambers for text in _thermal_in(bench, where, plan)]


def _thermal_in(bench: Bench, where: str, plan: str) -> list[str]:
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


def _rate_table(bench: Bench) -> list[str]:
    runs = range(1, bench.table_runs + 1)
    attitude = _attitude(bench.tilt_deg, bench.u_tilt_deg, bench.azimuth_deg, bench.u_azimuth_deg)
    names = {number: [recording_name(axis, number) for axis in AXES] for number in runs}
    fit, held = runs[: bench.table_fit_runs], runs[bench.table_fit_runs :]
    fitted = [name for number in fit for name in names[number]]
    rest = f"{attitude}, zero_reference = true"
    after = [f'after = ["{NAMES[AIR]}"]'] if "thermal" in bench.parts and AIR in bench.chambers else []
    why = "the model is fitted on these power-ups"
    tests = [_test(NAMES["rate_table"], "rate_table", "fit", fitted, attitude, why, *after)]
    if held:
        left = [name for number in held for name in names[number]]
        why = "and judged by power-ups that it has not seen"
        tests.append(_test("rate_check", "rate_table", "hold_out", left, attitude, why, *after))
    if bench.zero_reference:
        every = [name for number in runs for name in names[number]]
        why = "all of them with the reading at rest taken off"
        tests.append(_test("rate_from_rest", "rate_table", "report_only", every, rest, why))
    return tests


def _noise(bench: Bench) -> list[str]:
    names = [recording_name("static", number) for number in range(1, bench.static_runs + 1)]
    return [_test(NAMES["noise"], "static_noise", "fit", names, "", "noise of the unit at rest")]


def _attitude(tilt: float, u_tilt: float, azimuth: float, u_azimuth: float) -> str:
    return (
        f'attitude = {{ tilt = "{tilt:g} deg", u = "{u_tilt:g} deg", '
        f'azimuth = "{azimuth:g} deg", u_azimuth = "{u_azimuth:g} deg" }}'
    )


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

"""campaign.toml of the simulated rate-table test, as its engineer would write it: without a word of the truth."""

from __future__ import annotations

from collections.abc import Iterable

from ...core.campaign_text import Noted, toml_text
from ...core.key import AXES
from ..parts.campaign import EACH_ERROR, Content, attitude, campaign_head, channel_entries, standard_tables
from ..parts.gyro_bench import suite_table
from .setup import Bench

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
    title, about = "Rate table test of a simulated three-axis gyro", "a three-axis rate gyro on a stepped rate table"
    runs = range(1, bench.runs + 1)
    tests = [_test(bench, "fit", "fit", runs[: bench.fit_runs], "The model is fitted on the first power-ups")]
    if held := runs[bench.fit_runs :]:
        about_held = "Hold-out: the model is judged on power-ups that the fit does not use"
        tests.append(_test(bench, "check", "hold_out", held, about_held))
    requirement = {
        "id": "R1",
        "text": "expected error of rate within 5 % from 1.5 deg/s on",
        "quantity": "rate_error",
        "of": "expected",
        "limit": "5 %",
        "where": "abs(rate) >= 1.5 deg/s",
        "tests": ["fit", "check"] if held else ["fit"],
    }
    return toml_text(
        {
            **campaign_head("rate_table", "simulated rate gyro", title, about),
            "site": {"latitude": Noted(f"{bench.latitude_deg:g} deg", "geodetic")},
            "standards": Noted(standard_tables(bench.standards), above=EACH_ERROR),
            "sensors": {"suite": suite_table(bench.averaged)},
            "recordings": {
                recording_name(axis, run): _entry(bench, axis, run) for run in runs for axis in bench.turned
            },
            "tests": tests,
            "requirements": [requirement],
        }
    )


def _entry(bench: Bench, axis: str, run: int) -> Content:
    """Return the entry of the recording in which an axis is turned."""
    columns = {axis: axis for axis in AXES}
    if bench.reference_saved:
        columns |= {f"reference_{axis}": reference_column(axis) for axis in AXES}
    columns |= {f"validity_{axis}": validity_column(axis) for axis in AXES}
    times = {"interval": f"{bench.interval:g} s", "averaging": f"{bench.averaging:g} s"}
    return {
        "sensor": "suite",
        "file": recording_file(axis, run),
        "axis": axis,
        "run": Noted(str(run), "power-up"),
        "clock": {"column": "unix_s", "stamp": "end", **times},
        "channels": {"applied": {"column": APPLIED, "unit": "deg/s"}, **channel_entries(columns, "count")},
    }


def _test(bench: Bench, name: str, use: str, runs: Iterable[int], about: str) -> Noted:
    recordings = [recording_name(axis, run) for run in runs for axis in bench.turned]
    stands = attitude(bench.tilt_deg, bench.u_tilt_deg, bench.azimuth_deg, bench.u_azimuth_deg)
    test: Content = {"id": name, "procedure": "rate_table", "use": use, "recordings": recordings}
    return Noted(test | {"plan": {"attitude": stands}}, above=about)

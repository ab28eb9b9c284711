"""campaign.toml of the simulated rate suite, as its engineer would write it: without a word of the truth."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from ...core.campaign_text import Noted, toml_text
from ...core.key import AXES
from ...sensors.catalogue import SLOPE, T_REFERENCE
from ..parts.campaign import (
    CERTIFIED,
    EACH_ERROR,
    LABORATORY,
    Content,
    attitude,
    campaign_head,
    channel_entries,
    standard_tables,
)
from ..parts.gyro_bench import suite_table
from .recordings import BEGIN, DAY, column
from .setup import (
    AIR,
    APPLIED,
    AVERAGED,
    AVERAGING,
    INTERVAL,
    PRESSURE,
    VACUUM,
    Bench,
    nominal_volts,
)

NAMES = {AIR: "thermal_ambient", VACUUM: "thermal_vacuum", "rate_table": "rate", "noise": "noise"}  # tests for the fit
IN = {AIR: "air", VACUUM: "vacuum"}  # names of the conditions
MODELS = {AIR: "model", VACUUM: "model_vacuum"}  # as results name them
CONDITIONS: dict[str, Content] = {
    AIR: {"pressure": ["80 kPa", "120 kPa"]},
    VACUUM: {"pressure": ["0 Pa", "0.053 Pa"], "text": "the bias is constant below 4e-4 Torr"},
}
CHECK = "rate_check"
REFERENCE_DEGC = 20.0  # of the powers of temperature
AT_DEGC = (-20.0, 0.0, 20.0, 60.0)  # where the bias is also reported
CHANNELS = {"": "rate", "reference_": "ref", "temperature_": "temp", "temperature_reference_": "temp_ref"}
CHANNELS |= {"validity_": "bit"}


def degrees(temperature: float) -> str:
    """Return a temperature as conditions and settings write it."""
    return f"{temperature:g} degC"


def recording_name(what: str, number: int) -> str:
    """Return the name of a recording: of a condition, of an axis that is turned, at rest."""
    return f"{what}_run{number}" if what in AXES else f"{what}_{number}"


def recording_file(what: str, number: int) -> str:
    """Return the file of a recording, in the campaign folder."""
    return f"recordings/{recording_name(what, number)}.csv"


def campaign_text(bench: Bench) -> str:
    """Return the text of campaign.toml, with the marks for the seed and for the seal of the truth."""
    parts = {"thermal": (_chamber_entries, _thermal_tests), "rate_table": (_table_entries, _rate_table_tests)}
    parts |= {"noise": (_static_entries, _noise_tests)}
    recordings: Content = {}
    tests: list[Noted] = []
    for part in bench.parts:
        entries_of, tests_of = parts[part]
        recordings |= entries_of(bench)
        tests += tests_of(bench)
    thermometer = {
        "slope": f"{SLOPE:g} V/degC",
        "voltage": {axis: f"{one:g} V" for axis, one in zip(AXES, nominal_volts(bench), strict=True)},
        "temperature": {axis: degrees(one) for axis, one in zip(AXES, T_REFERENCE, strict=True)},
    }
    title = "Thermal, vacuum, rate table and noise tests of a simulated rate-sensor suite"
    about = "three rate sensors in a thermal chamber, on a rate table and at rest"
    return toml_text(
        {
            **campaign_head("npsat1", "simulated rate-sensor suite", title, about),
            "site": {"latitude": Noted(f"{bench.latitude_deg:g} deg", "geodetic")},
            "standards": Noted(standard_tables(bench.standards), above=EACH_ERROR),
            "sensors": {"suite": suite_table(AVERAGED, thermometer=thermometer)},
            "conditions": {IN[where]: one for where, one in CONDITIONS.items()},
            "recordings": recordings,
            "tests": tests,
            **_model(bench),
            "requirements": list(_requirements(bench)),
            "certificate": Noted(LABORATORY, above=CERTIFIED),
        }
    )


def _chamber_entries(bench: Bench) -> Content:
    gauge = {PRESSURE: ("pressure", "Torr")}
    return {
        recording_name(where, number): _entry(bench, where, number, recording_name(where, number), gauge)
        for where in bench.chambers
        for number in range(1, bench.chamber_runs + 1)
    }


def _table_entries(bench: Bench) -> Content:
    applied = {APPLIED: ("applied", "deg/s")}
    return {
        recording_name(axis, number): {"axis": axis} | _entry(bench, axis, number, f"table_{number}", applied)
        for number in range(1, bench.table_runs + 1)
        for axis in AXES
    }


def _static_entries(bench: Bench) -> Content:
    names = {number: recording_name("static", number) for number in range(1, bench.static_runs + 1)}
    return {name: _entry(bench, "static", number, name, {}) for number, name in names.items()}


def _entry(bench: Bench, what: str, number: int, run: str, others: dict[str, tuple[str, str]]) -> Content:
    """Return the entry of a recording; ``others``: columns -> channel and unit, besides those of the sensors."""
    kinds = {prefix: name for prefix, name in CHANNELS.items() if bench.reference_saved or prefix != "reference_"}
    columns = {f"{prefix}{axis}": column(name, axis) for prefix, name in kinds.items() for axis in AXES}
    return {
        "sensor": "suite",
        "file": recording_file(what, number),
        "run": Noted(run, "power-up"),
        "clock": {"column": "unix_s", "stamp": "end", "interval": f"{INTERVAL} s", "averaging": f"{AVERAGING:g} s"},
        "channels": {channel: {"column": name, "unit": unit} for name, (channel, unit) in others.items()}
        | channel_entries(columns, "count"),
    }


def _test(name: str, procedure: str, use: str, recordings: Sequence[str], about: str, **settings: object) -> Noted:
    test: Content = {"id": name, "procedure": procedure, "use": use, "recordings": list(recordings)}
    return Noted(test | settings, above=about)


def _thermal_tests(bench: Bench) -> Iterator[Noted]:
    """Yield the tests over temperature, in air and in vacuum, each with its hold-out test."""
    stands = attitude(
        bench.chamber_tilt_deg, bench.u_chamber_tilt_deg, bench.chamber_azimuth_deg, bench.u_chamber_azimuth_deg
    )
    at = [degrees(one) for one in AT_DEGC]
    plan = {"at": at, "reference_temperature": degrees(REFERENCE_DEGC), "attitude": stands}
    last = BEGIN + DAY * (bench.chamber_runs + 1)
    shared = BEGIN + DAY * (bench.chamber_fit_runs - 1) + 7_200  # in the last recording of the fit
    for where in bench.chambers:
        names = [recording_name(where, number) for number in range(1, bench.chamber_runs + 1)]
        fit, held = names[: bench.chamber_fit_runs], names[bench.chamber_fit_runs :]
        settings: Content = {"condition": IN[where], "mounting": "chamber"}
        against = {"against": NAMES[AIR]} if where == VACUUM and AIR in bench.chambers else {}
        early: Content = {}
        late: Content = {}
        if bench.overlapping and where == AIR:
            held = [*held, fit[-1]]
            early, late = {"windows": [[BEGIN, last]]}, {"windows": [[shared, last]]}
        about = f"Bias over temperature in {'air' if where == AIR else 'vacuum'}"
        yield _test(NAMES[where], "thermal", "fit", fit, about, **settings, **against, **early, plan=plan)
        if held:
            about = "Hold-out: the same on power-ups that the fit does not use"
            yield _test(f"{NAMES[where]}_check", "thermal", "hold_out", held, about, **settings, **late, plan=plan)


def _rate_table_tests(bench: Bench) -> Iterator[Noted]:
    """Yield the tests on the rate table: fit and hold-out, less the reading at rest or the bias of the chamber."""
    names = [recording_name(axis, number) for number in range(1, bench.table_runs + 1) for axis in AXES]
    fitted = len(AXES) * bench.table_fit_runs
    fit, held = names[:fitted], names[fitted:]
    stands = attitude(bench.tilt_deg, bench.u_tilt_deg, bench.azimuth_deg, bench.u_azimuth_deg)
    settings: Content = {"condition": IN[AIR]}
    plan: Content = {"attitude": stands}
    if bench.zero_reference:
        plan |= {"zero_reference": True}
    elif "thermal" in bench.parts and AIR in bench.chambers:
        settings |= {"after": [NAMES[AIR]]}
    about = "The model is fitted on these power-ups"
    yield _test(NAMES["rate_table"], "rate_table", "fit", fit, about, **settings, plan=plan)
    if held:
        about = "Hold-out: the model is judged on power-ups that the fit does not use"
        yield _test(CHECK, "rate_table", "hold_out", held, about, **settings, plan=plan)


def _noise_tests(bench: Bench) -> Iterator[Noted]:
    about = "Noise of the unit at rest"
    yield _test(NAMES["noise"], "static_noise", "fit", list(_static_entries(bench)), about, condition=IN[AIR])


def _model(bench: Bench) -> Content:
    """Return which tests the terms of the model in air and in vacuum come from; empty where all of them do."""
    found: dict[str, dict[str, list[str]]] = {}
    for where in bench.chambers if "thermal" in bench.parts else ():
        found[IN[where]] = {"bias": [NAMES[where]]}
    if IN[VACUUM] in found:
        others = {"rate_table": ("scale_factor", "misalignment", "asymmetry"), "noise": ("noise",)}
        taken = {kind: [NAMES[part]] for part, kinds in others.items() if part in bench.parts for kind in kinds}
        found[IN[VACUUM]] = found.get(IN[VACUUM], {}) | taken
    about = "The bias is that of the chamber. On the rate table there is air alone; its terms are taken in vacuum too."
    return {"model": Noted({"by_condition": found}, above=about)} if found else {}


def _requirements(bench: Bench) -> Iterator[Content]:
    """Yield the requirements that the tests of the campaign can judge."""
    if "rate_table" in bench.parts:
        rest = "reading at rest subtracted" if bench.zero_reference else "reading at rest not subtracted"
        yield {
            "id": "R1",
            "text": f"error of rate within 5 % from 0.1 deg/s on, {rest}",
            "quantity": "rate_error",
            "of": "dwell_mean",
            "limit": "5 %",
            "where": "abs(rate) >= 0.1 deg/s",
            "tests": [NAMES["rate_table"]],
        }
    if "thermal" not in bench.parts:
        return
    low, high = map(degrees, bench.required_degc)
    over: Content = {"where": f"temperature >= {low} and temperature <= {high}"}
    if bench.chamber_runs > bench.chamber_fit_runs:
        for number, where in enumerate(bench.chambers, 2):
            yield {
                "id": f"R{number}",
                "text": f"bias within 0.05 deg/s over temperature in {IN[where]}, compensated",
                "quantity": "bias",
                "limit": "0.05 deg/s",
                "readings": "compensated",
                "tests": [f"{NAMES[where]}_check"],
                **over,
            }
    if AIR in bench.chambers:
        yield {
            "id": "R4",
            "text": "bias within 0.4 deg/s over temperature, not compensated",
            "quantity": "bias",
            "limit": "0.4 deg/s",
            "tests": [NAMES[AIR]],
            **over,
        }

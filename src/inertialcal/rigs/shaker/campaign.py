"""campaign.toml of a simulated vibration test, as its engineer would write it: without a word of the truth."""

from __future__ import annotations

from collections.abc import Iterable

from ...core.campaign_text import Noted, toml_text
from ..parts.campaign import EACH_ERROR, Content, attitude, campaign_head, standard_tables
from .gyro import APPLIED, rate_names, rest_names
from .setup import COLUMNS, CONTROLS, GYRO, LATITUDE, PROFILE, RESTS, RUN, SURVEYS, Bench

RUN_FILE = "recordings/run.csv"
GYRO_FILE = "recordings/run_gyro.csv"

ALLOWED = (  # changes of the gyro by the vibration
    ("R5", "the reading at rest shifts by at most 0.03 deg/s", "level_at_rest", "0.03 deg/s", "rest_after"),
    ("R6", "the noise changes by at most 20 %", "angle_random_walk", "20 %", "rest_after"),
    ("R7", "the bias shifts by at most 0.03 deg/s", "bias", "0.03 deg/s", "rate_after"),
    ("R8", "the scale factor changes by at most 0.1 %", "scale_factor_error", "0.1 %", "rate_after"),
)


def survey_file(name: str) -> str:
    """Return the file of a survey, in the campaign folder."""
    return f"recordings/survey_{name}.csv"


def rest_file(name: str) -> str:
    """Return the file of a record at rest or on the rate table, in the campaign folder."""
    return f"recordings/{name}.csv"


def campaign_text(bench: Bench) -> str:
    """Return the text of campaign.toml, with the marks for the seed and for the seal of the truth."""
    title, about = "Vibration of a simulated item", "resonances of an item before and after vibration"
    requirements: list[Content] = [
        {"id": "R1", "text": "resonances move by at most 5 %", "quantity": "resonance_frequency_change",
         "limit": "5 %", "tests": ["after"]},
        {"id": "R2", "text": "amplifications change by at most 20 %", "quantity": "amplification_change",
         "limit": "20 %", "tests": ["after"]},
    ]  # fmt: skip
    run: dict[str, Content] = {}
    if bench.full_level:
        run[RUN] = _entry(RUN_FILE) | {"profile": PROFILE, "axis": "x"}
        run[f"{RUN}_gyro"] = _gyro_entry(GYRO_FILE, {"control": {"column": CONTROLS[0], "unit": "g"}}) | {"axis": "x"}
    if bench.full_level:
        requirements.append({"id": "R3", "text": "overall level within 10 % of the profile",
                             "quantity": "acceleration_rms_deviation", "limit": "10 %", "tests": [RUN]})  # fmt: skip
        requirements.append({"id": "R4", "text": "each line within 3 dB of the profile",
                             "quantity": "spectral_density_deviation", "limit": "3 dB", "tests": [RUN]})  # fmt: skip
    rests = {when: rest_names(bench, when) for when in RESTS} if bench.power_ups else {}
    rates = {when: rate_names(bench, when) for when in RESTS} if bench.power_ups else {}
    for name, text, quantity, limit, test in ALLOWED if rests else ():
        requirements.append({"id": name, "text": text, "quantity": quantity, "of": "change", "limit": limit,
                             "tests": [test]})  # fmt: skip
    gyro: Content = {"kind": "gyro", "axes": list(GYRO), "unit": "deg/s"}
    item: Content = {"kind": "accelerometer", "axes": list(COLUMNS), "unit": "g"}
    return toml_text(
        {
            **campaign_head("shaker", "simulated item on a shaker", title, about),
            **({"site": {"latitude": Noted(f"{LATITUDE:g} deg", "geodetic")}} if rests else {}),
            "standards": Noted(standard_tables(bench.standards), above=EACH_ERROR),
            "sensors": {"item": item} | ({"gyro": gyro} if rests or run else {}),
            "recordings": {
                **{f"survey_{name}": _entry(survey_file(name)) for name in SURVEYS},
                **run,
                **{name: _gyro_entry(rest_file(name)) for names in rests.values() for name in names},
                **{name: _turned_entry(name, *of) for names in rates.values() for name, of in names.items()},
            },
            "tests": [
                *(_test(bench, name) for name in SURVEYS),
                *_random(bench),
                *(_at_rest(when, names) for when, names in rests.items()),
                *(_turned(bench, when, names) for when, names in rates.items()),
            ],
            "requirements": requirements,
        }
    )


def _random(bench: Bench) -> list[Noted]:
    """Return the random run between the surveys, where there is one."""
    if not bench.full_level:
        return []
    plan = {"resolution": "2.5 Hz", "duration": f"{bench.full_level:g} s"}
    one: Content = {"id": RUN, "procedure": "vibration", "recordings": [RUN], "plan": plan}
    effects: Content = {"id": "effects", "procedure": "vibration_effects", "recordings": [f"{RUN}_gyro"],
                        "plan": {"block": "0.25 s"}}  # fmt: skip
    return [Noted(one, above="Random vibration between the surveys"), Noted(effects, above="What it does to the gyro")]


def _at_rest(when: str, names: list[str]) -> Noted:
    """Return the functional test before or after the vibration: the gyro stays where it is."""
    one: Content = {"id": f"rest_{when}", "procedure": "static_noise", "recordings": names, "mounting": "fixture"}
    later: Content = {} if when == "before" else {"use": "report_only", "against": "rest_before"}
    return Noted(one | later, above=f"Gyro at rest {when} vibration, a record each power-up")


def _turned(bench: Bench, when: str, names: Iterable[str]) -> Noted:
    """Return the functional test before or after the vibration on the rate table."""
    plan: Content = {"attitude": attitude(0.0, bench.tilt, 0.0, 180.0)}
    one: Content = {"id": f"rate_{when}", "procedure": "rate_table", "recordings": list(names)}
    later: Content = {} if when == "before" else {"use": "report_only", "against": "rate_before"}
    return Noted(one | later | {"plan": plan}, above=f"Gyro on the rate table {when} vibration, two axes each power-up")


def _turned_entry(name: str, axis: str, run: int) -> Content:
    entry = _gyro_entry(rest_file(name), {"applied": {"column": APPLIED, "unit": "deg/s"}})
    return {**entry, "axis": axis, "run": str(run)}


def _gyro_entry(file: str, beside: Content | None = None) -> Content:
    channels = {axis: {"column": column, "unit": "deg/s"} for axis, column in GYRO.items()}
    return {"sensor": "gyro", "file": file, "clock": {"column": "unix_s"}, "channels": {**(beside or {}), **channels}}


def _entry(file: str) -> Content:
    channels = {"control": CONTROLS[0], "control_2": CONTROLS[1], **COLUMNS}
    return {
        "sensor": "item",
        "file": file,
        "clock": {"column": "unix_s"},
        "channels": {role: {"column": column, "unit": "g"} for role, column in channels.items()},
    }


def _test(bench: Bench, name: str) -> Noted:
    plan = {
        "sweep": f"{bench.start:g} Hz to {bench.stop:g} Hz",
        "rate": f"{bench.per_minute:g} oct/min",
        "level": f"{bench.said_level:g} g",
    }
    beside: Content = {} if name == "before" else {"against": "before"}
    one: Content = {"id": name, "procedure": "sine_survey", "recordings": [f"survey_{name}"], **beside, "plan": plan}
    return Noted(one, above=f"Sine survey {name} vibration")

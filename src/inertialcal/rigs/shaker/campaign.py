"""campaign.toml of a simulated vibration test, as its engineer would write it: without a word of the truth."""

from __future__ import annotations

from ...core.campaign_text import Noted, toml_text
from ..parts.campaign import EACH_ERROR, Content, campaign_head, standard_tables
from .setup import COLUMNS, CONTROLS, PROFILE, RUN, SURVEYS, Bench

RUN_FILE = "recordings/run.csv"


def survey_file(name: str) -> str:
    """Return the file of a survey, in the campaign folder."""
    return f"recordings/survey_{name}.csv"


def campaign_text(bench: Bench) -> str:
    """Return the text of campaign.toml, with the marks for the seed and for the seal of the truth."""
    title, about = "Vibration of a simulated item", "resonances of an item before and after vibration"
    requirements: list[Content] = [
        {"id": "R1", "text": "resonances move by at most 5 %", "quantity": "resonance_frequency_change",
         "limit": "5 %", "tests": ["after"]},
        {"id": "R2", "text": "amplifications change by at most 20 %", "quantity": "amplification_change",
         "limit": "20 %", "tests": ["after"]},
    ]  # fmt: skip
    run = {RUN: _entry(RUN_FILE) | {"profile": PROFILE, "axis": "x"}} if bench.full_level else {}
    if bench.full_level:
        requirements.append({"id": "R3", "text": "overall level within 10 % of the profile",
                             "quantity": "acceleration_rms_deviation", "limit": "10 %", "tests": [RUN]})  # fmt: skip
    return toml_text(
        {
            **campaign_head("shaker", "simulated item on a shaker", title, about),
            "standards": Noted(standard_tables(bench.standards), above=EACH_ERROR),
            "sensors": {"item": {"kind": "accelerometer", "axes": list(COLUMNS), "unit": "g"}},
            "recordings": {**{f"survey_{name}": _entry(survey_file(name)) for name in SURVEYS}, **run},
            "tests": [_test(bench, name) for name in SURVEYS] + _random(bench),
            "requirements": requirements,
        }
    )


def _random(bench: Bench) -> list[Noted]:
    """Return the random run between the surveys, where there is one."""
    if not bench.full_level:
        return []
    plan = {"resolution": "2.5 Hz", "duration": f"{bench.full_level:g} s"}
    one: Content = {"id": RUN, "procedure": "vibration", "recordings": [RUN], "plan": plan}
    return [Noted(one, above="Random vibration between the surveys")]


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
        "rate": f"{bench.said:g} oct/min",
        "level": f"{bench.said_level:g} g",
    }
    beside: Content = {} if name == "before" else {"against": "before"}
    one: Content = {"id": name, "procedure": "sine_survey", "recordings": [f"survey_{name}"], **beside, "plan": plan}
    return Noted(one, above=f"Sine survey {name} vibration")

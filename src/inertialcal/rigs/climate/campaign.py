"""campaign.toml of the simulated test of sensitivities, as its engineer would write it: without a word of the truth."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from ...core.campaign_text import Noted, toml_text
from ...core.key import AXES
from ..parts.campaign import EACH_ERROR, Content, attitude, campaign_head, channel_entries, standard_tables
from .recordings import file_of, names_of, power_ups
from .setup import AIR, AVERAGING, INTERVAL, VACUUM, Bench


def groups_of(bench: Bench) -> list[str]:
    """Return the groups of recordings that a bench makes."""
    found = [f"supply_{condition}" for condition in bench.conditions] if "supply" in bench.parts else []
    return [*found, *(part for part in bench.parts if part != "supply")]


def campaign_text(bench: Bench) -> str:
    """Return the text of campaign.toml, with the marks for the seed and for the seal of the truth."""
    title, about = "Sensitivities of a simulated rate-sensor suite", "supply, temperature, pressure and warm-up"
    groups = groups_of(bench)
    recordings = {name: _entry(group, name, run, axis) for group in groups
                  for name, (run, axis) in names_of(bench, group).items()}  # fmt: skip
    decided: Content = {"scale_factor": ["table"], "misalignment": ["table"]} if "table" in groups else {}
    decided |= {"warm_up": ["warm_up"]} if "warm_up" in groups else {}
    sensitive = [group for group in groups if group in ("supply_air", "supply_vacuum", "scale")]
    terms: Content = {"sensitivity": sensitive} if sensitive else {}
    terms |= {"warm_up": ["warm_up"]} if "warm_up" in groups else {}
    return toml_text(
        {
            **campaign_head("climate", "simulated rate-sensor suite", title, about),
            "site": {"latitude": Noted(f"{bench.latitude_deg:g} deg", "geodetic")},
            "standards": Noted(standard_tables(bench.standards), above=EACH_ERROR),
            "sensors": {"suite": {"kind": "gyro", "axes": list(AXES), "unit": "deg/s"}},
            "conditions": {
                AIR: {"pressure": ["80 kPa", "120 kPa"]},
                VACUUM: {"pressure": ["0 Pa", "0.01 Pa"]},
            },
            "recordings": recordings,
            "tests": [test for group in groups for test in _tests(bench, group)],
            "model": {"terms": terms, "by_condition": {VACUUM: decided} if "supply_vacuum" in groups else {}},
            "requirements": list(_requirements(groups)),
        }
    )


def _requirements(groups: Sequence[str]) -> Iterator[Content]:
    """Yield the requirements that the tests of the campaign can judge."""
    supplied = [group for group in groups if group.startswith("supply_")]
    if supplied:
        yield {
            "id": "R1",
            "text": "bias changes by at most 0.05 deg/s for a volt of supply",
            "quantity": "bias_supply",
            "limit": "0.05 deg/s/V",
            "tests": supplied,
        }
    if "scale" in groups:
        yield {
            "id": "R2",
            "text": "scale factor changes by at most 0.05 % for a degree",
            "quantity": "scale_factor_error_temperature_1",
            "limit": "0.05 %/degC",
            "tests": ["scale"],
        }


def _entry(group: str, name: str, run: int, axis: str) -> Content:
    columns = {one: (one, unit) for one, unit in (("supply", "V"), ("pressure", "Pa"), ("temperature", "degC"))}
    columns |= {f"reference_{one}": (f"{one}_ref", "V") for one in AXES}
    turned: Content = {"axis": axis} if axis else {}
    columns |= {"applied": ("applied", "deg/s")} if axis else {}
    return {
        "sensor": "suite",
        "file": file_of(name),
        **turned,
        "run": Noted(f"{group}_{run}", "power-up"),
        "clock": {"column": "unix_s", "stamp": "end", "interval": f"{INTERVAL:g} s", "averaging": f"{AVERAGING:g} s"},
        "channels": {channel: {"column": column, "unit": unit} for channel, (column, unit) in columns.items()}
        | channel_entries({one: one for one in AXES}, "deg/s"),
    }


ABOUT = {
    "supply_air": "Bias against supply and temperature, in air",
    "supply_vacuum": "The same in vacuum",
    "scale": "Scale factor against supply and temperature",
    "table": "Scale factors and misalignment at the temperature of the laboratory",
    "warm_up": "What dies away after power-up, from several temperatures",
    "pressure": "From air to vacuum and back",
}
TO = {"supply_air": ["supply", "temperature"], "supply_vacuum": ["supply", "temperature"],
      "scale": ["supply", "temperature"], "warm_up": ["warm_up"], "pressure": ["pressure"]}  # fmt: skip


def _tests(bench: Bench, group: str) -> Iterator[Noted]:
    """Yield the tests of a group: for the fit, and on power-ups held out."""
    names = names_of(bench, group)
    fitted, _ = power_ups(bench, group)
    fit = [name for name, (run, _) in names.items() if run <= fitted]
    held = [name for name, (run, _) in names.items() if run > fitted]
    plan: Content = {"attitude": attitude(bench.tilt_deg, bench.u_tilt_deg, bench.azimuth_deg, bench.u_azimuth_deg)}
    if group in TO:
        plan = {"to": TO[group], **plan}
    settings: Content = {} if group == "pressure" else {"condition": VACUUM if group == "supply_vacuum" else AIR}
    procedure = "rate_table" if group == "table" else "sensitivity"

    def test(suffix: str, use: str, recordings: Sequence[str], about: str) -> Noted:
        one: Content = {"id": f"{group}{suffix}", "procedure": procedure, "use": use, "recordings": list(recordings)}
        return Noted(one | settings | {"plan": plan}, above=about)

    yield test("", "report_only" if group == "pressure" else "fit", fit, ABOUT[group])
    if held:
        yield test("_check", "hold_out", held, "Hold-out: the same on power-ups that the fit does not use")

"""campaign.toml of a simulated turned-mass test, as its engineer would write it: without a word of the truth."""

from __future__ import annotations

from collections.abc import Mapping

from ...core.campaign_text import Noted, toml_text
from ...core.influence import Influence
from ...core.recording import SECOND
from ...core.times import instant_text
from ..parts.campaign import Content, campaign_head, standard_tables
from .record import begin_of
from .setup import NOMINAL, UG, Bench

PULSES = "pulses"
SCHEDULE = "schedule.csv"
BEGIN = 1_772_323_200  # 2026-03-01 00:00:00 UTC [s]


def recording_file(number: int) -> str:
    """Return the file of a run, in the campaign folder."""
    return f"recordings/run{number + 1}.csv"


def campaign_text(bench: Bench, standards: Mapping[str, Influence]) -> str:
    """Return the text of campaign.toml, with the marks for the seed and for the seal of the truth."""
    title = "Scale factor of a simulated accelerometer in orbit from a turned mass"
    about = "an accelerometer in orbit is calibrated with a mass that turns around it"
    stated, unit = NOMINAL * UG, "count/s/ug"
    gate = bench.gate if bench.gate_said is None else bench.gate_said
    chain = {"kind": "pulse_rate", "gate": f"{gate:g} s", "scale_factor": f"{stated:g} {unit}"}
    mass = bench.mass if bench.mass_said is None else bench.mass_said
    radius = bench.radius if bench.radius_said is None else bench.radius_said
    plan = {
        "mass": Noted(f"{mass:g} kg", "with the arm, and all that turns with it"),
        "radius": f"{radius:g} m",
        "altitude": f"{bench.altitude / 1e3:g} km",
        "satellite": Noted(f"{bench.satellite:g} kg", "to check the recoil arm; it is found from the runs"),
        "alignment": "1 deg",
        "high_g": Noted(
            {"scale_factor": f"{stated:g} {unit}", "u": f"{0.01 * stated:.4g} {unit}"}, "by a flip on ground"
        ),
    }
    runs = [f"run{number + 1}" for number in range(len(bench.periods))]
    test = {"id": "calibration", "procedure": "turned_mass", "recordings": runs}
    requirement = {
        "id": "R1",
        "text": "scale factor within 20 % of the data sheet",
        "quantity": "scale_factor",
        "lower": f"{0.8 * stated:.4g} {unit}",
        "upper": f"{1.2 * stated:.4g} {unit}",
    }
    recordings = {run: _entry(bench, number) for number, run in enumerate(runs)}
    return toml_text(
        {
            **campaign_head("turned_mass", "simulated electrostatic accelerometer", title, about),
            "standards": standard_tables(standards),
            "sensors": {"head": {"kind": "accelerometer", "axes": ["x"], "unit": "ug", "chain": chain}},
            "recordings": Noted(recordings, above="A row is one gate. Gates that were not saved are missing.\n"),
            "tests": [test | {"plan": plan}],
            "requirements": [requirement],
        }
    )


def _entry(bench: Bench, number: int) -> Content:
    """Return the entry of the recording of a run."""
    return {
        "sensor": "head",
        "file": recording_file(number),
        "run": "orbit",
        "clock": {
            "column": "unix_s",
            "stamp": "end",
            "interval": f"{bench.gate:g} s",
            "averaging": f"{bench.gate:g} s",
        },
        "turned": {"schedule": SCHEDULE, "run": f"run{number + 1}", "begin": instant_text(BEGIN * SECOND)},
        "channels": {"x": {"column": PULSES, "unit": "count"}},
    }


def begin(bench: Bench, number: int) -> int:
    """Return when a run starts [s, UNIX]."""
    return BEGIN + round(begin_of(bench, number))

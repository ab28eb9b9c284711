"""campaign.toml of a simulated mass-attraction test, as its engineer would write it: without a word of the truth."""

from __future__ import annotations

from ...core.campaign_text import Noted, toml_text
from ...core.recording import SECOND
from ...core.times import instant_text
from ..parts.campaign import Content, campaign_head, standard_tables
from .setup import LEAD, MASS, MERCURY_AMPLITUDE, RANGES, Bench, Run

PULSES, TILT, TEMPERATURE = "pulses", "tilt_rad", "case_degc"
SCHEDULE = "schedule.csv"
BEGIN = 1_272_412_800  # 2010-04-28 00:00:00 UTC [s]
APART = 86_400  # from run to run [s]
START_OF_DAY = {True: 10 * 3600, False: 20 * 3600}  # start of a run in work hours, and after them [s]


def recording_file(run: Run) -> str:
    """Return the file of a run, in the campaign folder."""
    return f"recordings/{run.name}.csv"


def begin(number: int, run: Run) -> int:
    """Return when the first dwell of a run starts, counted from 0 [s, UNIX]."""
    return BEGIN + number * APART + START_OF_DAY[run.work]


def campaign_text(bench: Bench) -> str:
    """Return the text of campaign.toml, with the marks for the seed and for the seal of the truth."""
    title = "Scale factor of a simulated accelerometer from a moved mass"
    about = "an accelerometer is calibrated with the attraction of a moved mass of lead"
    stated, unit = RANGES[bench.range], "count/s/ug"
    standards = {
        "source_mass.density": bench.density,
        "source_mass.placing": bench.placing,
        "source_mass.gravitational_constant": bench.gravitational_constant,
        "tilt_meter.mercury": bench.mercury,
    }
    chain = {"kind": "pulse_rate", "gate": f"{bench.gate_said:g} s", "scale_factor": f"{stated:g} {unit}"}
    rows = f"A row is one dwell: {bench.dwell:g} s of pulses, then {bench.move:g} s to move the mass.\n"
    mercury = f"{bench.lighter * MERCURY_AMPLITUDE:g} rad"
    plan = {
        "tilt": Noted("known", "the accelerometer feels a tilt of the pad as gravity times the tilt"),
        "mercury": Noted(mercury, "tilt of the meter's mercury caused by the mass"),
        "source": {"mass": f"{MASS:g} kg", "density": f"{LEAD:g} kg/m^3", "stand_off": f"{bench.stand_off_said:g} m"},
        "high_g": {"scale_factor": f"{stated:g} {unit}", "u": f"{0.005 * stated:.4g} {unit}"},
    }
    test = {"id": "calibration", "procedure": "mass_attraction", "recordings": [run.name for run in bench.runs]}
    requirement = {
        "id": "R1",
        "text": "scale factor within 20 % of the data sheet",
        "quantity": "scale_factor",
        "lower": f"{0.8 * stated:.4g} {unit}",
        "upper": f"{1.2 * stated:.4g} {unit}",
    }
    recordings = {run.name: _entry(bench, number, run) for number, run in enumerate(bench.runs)}
    return toml_text(
        {
            **campaign_head("mesa", "simulated electrostatic accelerometer", title, about),
            "standards": standard_tables(standards),
            "sensors": {"mesa": {"kind": "accelerometer", "axes": ["x"], "unit": "ug", "chain": chain}},
            "recordings": Noted(recordings, above=f"{rows}Rows that the counter failed to read are missing."),
            "tests": [test | {"plan": plan}],
            "requirements": [requirement],
        }
    )


def _entry(bench: Bench, number: int, run: Run) -> Content:
    """Return the entry of the recording of a run."""
    moved: Content = {} if run.moved else {"moved": False}
    times = {"interval": f"{bench.dwell + bench.move:g} s", "averaging": f"{bench.dwell:g} s"}
    return {
        "sensor": "mesa",
        "file": recording_file(run),
        "run": run.name,
        "clock": {"column": "unix_s", "stamp": "end", **times},
        "mass": {"schedule": SCHEDULE, "begin": instant_text(begin(number, run) * SECOND), **moved},
        "channels": {
            "x": {"column": PULSES, "unit": "count"},
            "tilt": {"column": TILT, "unit": "rad"},
            "temperature": {"column": TEMPERATURE, "unit": "degC"},
        },
    }

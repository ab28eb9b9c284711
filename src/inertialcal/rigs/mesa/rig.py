"""Rig of a mass-attraction calibration: a pulse-rate accelerometer on a pad, and lead that is moved before it.

The tilt of the pad in phase with the mass, the mercury of the tilt meter and what is wrong with the mass are drawn as
their certificates say; so is the scale factor of the instrument, about that of its data sheet.

References
----------
.. [1] K. Reinel, NASA TM X-53857, 1969.
"""

from __future__ import annotations

import numpy as np

from ...core.recording import SECOND, Channel, Recording
from ...physics.motion.schedule import Schedule
from ..parts.campaign import drawn_error, drawn_errors
from ..protocol import Rig, on_bench
from ..twin import Extra, TrueValue, Twin
from . import TITLE
from .campaign import PULSES, SCHEDULE, TEMPERATURE, TILT, begin, campaign_text, recording_file
from .record import Drawn, amplitude_of_mercury, dwells_a_cycle, nominal, record, schedule_table
from .setup import FAULTS, RUNS, Bench, Run

__all__ = ["FAULTS", "RIG", "RUNS", "Bench", "Run", "build"]

SPREAD = 0.01  # of the scale factor about the data sheet, from unit to unit (1)


def build(bench: Bench, seed: int) -> Twin:
    """Return the campaign that a bench gives.

    Parameters
    ----------
    bench : Bench
        The campaign as it is made.
    seed : int
        Of all draws.
    """
    of_unit, of_bench, *of_runs = np.random.default_rng(seed).spawn(2 + len(bench.runs))
    drawn = _drawn(bench, of_unit, of_bench)
    own = bench.run_to_run * of_unit.standard_normal(len(bench.runs))
    recordings = {
        recording_file(run): _recording(bench, drawn, number, float(own[number]), of_runs[number])
        for number, run in enumerate(bench.runs)
    }
    truth = (TrueValue("scale_factor", "x", drawn.scale_factor, "count/s/(m/s^2)"),)
    known = {
        "applied_error": drawn.applied_error, "pad_tilt": drawn.pad_tilt, "mercury": drawn.mercury,
        "run_to_run": own.tolist(),
    }  # fmt: skip
    planned = _planned(bench)
    extras = {SCHEDULE: Extra(planned, planned.csv({}))}
    return Twin(campaign_text(bench), recordings, truth, known, extras, drawn.errors)


def _drawn(bench: Bench, of_unit: np.random.Generator, of_bench: np.random.Generator) -> Drawn:
    parts = {
        "source_mass.density": bench.density, "source_mass.placing": bench.placing,
        "source_mass.gravitational_constant": bench.gravitational_constant,
    }  # fmt: skip
    off = {name: drawn_error(one, of_bench) for name, one in parts.items()}
    error = sum(off.values())
    off["tilt_meter.mercury"] = drawn_error(bench.mercury, of_bench)
    mercury = amplitude_of_mercury(bench, off["tilt_meter.mercury"])
    errors = drawn_errors(parts | {"tilt_meter.mercury": bench.mercury}, {name: -one for name, one in off.items()})
    tilt = float(of_bench.normal(0.0, bench.pad_tilt))
    return Drawn(nominal(bench) * (1.0 + float(of_unit.normal(0.0, SPREAD))), error, tilt, mercury, errors)


def _planned(bench: Bench) -> Schedule:
    start, position, applied = schedule_table(bench)
    return Schedule(
        start, bench.dwell, bench.move, position, applied,
        "abab" if bench.drive == "ABAB" else "sine", dwells_a_cycle(bench),
    )  # fmt: skip


def _recording(bench: Bench, drawn: Drawn, number: int, own: float, rng: np.random.Generator) -> Recording:
    """Return one run, as the logger saves it: a row a dwell, stamped at its end."""
    run = bench.runs[number]
    saved = record(bench, drawn, run, own, rng)
    step = bench.dwell + bench.move
    ends = begin(number, run) * SECOND + np.rint((saved.dwell * step + bench.dwell) * SECOND).astype(np.int64)
    tilt = np.full(len(saved.tilt), np.nan) if run.name == bench.no_tilt else saved.tilt
    channels = (
        Channel(PULSES, saved.pulses, "count", "campaign", "x", "acc"),
        Channel(TILT, tilt, "rad", "campaign"),
        Channel(TEMPERATURE, saved.temperature, "degC", "campaign"),
    )
    return Recording(channels, ends, step, bench.dwell, "utc", "column", time_column="unix_s")


RIG = Rig("mesa", TITLE, on_bench(build, Bench()), FAULTS, tests=("mass_attraction",))

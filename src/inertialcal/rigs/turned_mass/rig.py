"""Rig of a turned mass: a pulse-rate accelerometer in orbit, and a mass that goes round it at several rates.

Mass, distance, height, satellite and orbit are drawn as their certificates say; so are the places of axis and input
axis, and the scale factor of the instrument about that of its data sheet.

References
----------
.. [1] K. Reinel, NASA TM X-53857, 1969, Figure 15.
"""

from __future__ import annotations

import numpy as np

from ...core.recording import SECOND, Channel, Recording
from ...physics.motion.turns import Turn, programme_text
from ...physics.orbit import orbital_rate
from ..parts.campaign import drawn_error, drawn_errors
from ..protocol import Rig, on_bench
from ..twin import Extra, TrueValue, Twin
from . import TITLE
from .campaign import PULSES, SCHEDULE, begin, campaign_text, recording_file
from .record import Drawn, begin_of, record, start_angle, turn_rate
from .setup import FAULTS, NOMINAL, Bench

__all__ = ["FAULTS", "RIG", "Bench", "build"]

SPREAD = 0.01  # of the scale factor about the data sheet, from unit to unit (1)


def build(bench: Bench, seed: int) -> Twin:
    """Return the campaign that a bench gives.

    Parameters
    ----------
    bench : Bench
        The campaign as it is flown.
    seed : int
        Of all draws.
    """
    of_unit, of_bench, *of_runs = np.random.default_rng(seed).spawn(2 + len(bench.periods))
    standards = {
        "turned_mass.mass": bench.u_mass, "turned_mass.radius": bench.u_radius, "turned_mass.height": bench.u_height,
        "satellite.mass": bench.u_satellite, "orbit.rate": bench.u_orbit,
    }  # fmt: skip
    off = {name: drawn_error(one, of_bench) for name, one in standards.items()}
    along, across = of_bench.normal(0.0, bench.offset, 2)
    zero, direction = of_bench.normal(0.0, bench.zero), of_bench.normal(0.0, bench.alignment)
    drawn = Drawn(
        NOMINAL * (1.0 + float(of_unit.normal(0.0, SPREAD))), bench.mass + off["turned_mass.mass"],
        bench.radius + off["turned_mass.radius"], bench.satellite + off["satellite.mass"],
        orbital_rate(bench.altitude).value("orbital_rate") * (1.0 + off["orbit.rate"]),
        (float(along), float(across), off["turned_mass.height"]), float(zero), float(direction),
        drawn_errors(standards, {name: -one for name, one in off.items()}),
    )  # fmt: skip
    numbers = list(range(len(bench.periods)))
    if bench.exchanged is not None:
        one, other = bench.exchanged
        numbers[one], numbers[other] = other, one
    recordings = {
        recording_file(number): _recording(bench, drawn, number, made, of_runs[made])
        for number, made in enumerate(numbers)
    }
    truth = (
        TrueValue("scale_factor", "x", drawn.scale_factor, "count/s/(m/s^2)"),
        TrueValue("recoil_arm", "x", drawn.recoil_arm, "m"),
        TrueValue("axis_offset", "x", drawn.offset[0], "m"),
        TrueValue("axis_offset_across", "x", drawn.offset[1], "m"),
        TrueValue("angle_zero", "x", drawn.zero, "rad"),
    )
    known: dict[str, float | list[float] | list[list[float]]] = {
        "offset": list(drawn.offset),
        "direction": drawn.direction,
        "mass": drawn.mass,
        "radius": drawn.radius,
    }
    turns = _programme(bench)
    extras = {SCHEDULE: Extra(turns, programme_text(turns))}
    return Twin(campaign_text(bench, standards), recordings, truth, known, extras, drawn.errors)


def _programme(bench: Bench) -> tuple[Turn, ...]:
    """Return the programme as the campaign says it."""
    turns = []
    for number in range(len(bench.periods)):
        rate = turn_rate(bench, number) * bench.rates_times * (-1.0 if bench.sense_said == number else 1.0)
        start = begin_of(bench, number)
        turns.append(Turn(f"run{number + 1}", start, start + bench.length, rate, start_angle(number)))
    return tuple(turns)


def _recording(bench: Bench, drawn: Drawn, number: int, made: int, rng: np.random.Generator) -> Recording:
    """Return the file of a run, a row a gate, stamped at its end; ``made`` is the run whose readings it has."""
    saved, pulses = record(bench, drawn, made, rng)
    ends = begin(bench, number) * SECOND + np.rint((saved + 1) * bench.gate * SECOND).astype(np.int64)
    channel = Channel(PULSES, pulses, "count", "campaign", "x", "acc")
    return Recording((channel,), ends, bench.gate, bench.gate, "utc", "column", time_column="unix_s")


RIG = Rig("turned_mass", TITLE, on_bench(build, Bench()), FAULTS, tests=("turned_mass",))

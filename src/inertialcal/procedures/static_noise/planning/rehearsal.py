"""A planned record at rest rehearsed: a sensor with the noise terms that the plan was made for."""

from __future__ import annotations

import numpy as np

from ....files.text.table import Table
from ....rigs.twin import TrueValue
from ....sensors.noise.terms import parameter_unit, quantity_name
from ...rehearsed import Rehearsal, Way, course_of, entry_of, interval_of, noise_of, recorded, steps_of
from .planner import UNITS, Known

AXIS = "x"
SAVED = {"gyro": "deg/s", "accelerometer": "m/s^2"}


def rehearse(known: Known, table: Table, seed: int) -> Rehearsal:
    """Return what a schedule gives on a drawn unit, and its campaign.

    Raises
    ------
    DataError
        If the schedule cannot be read.
    """
    rng, kind = np.random.default_rng(seed), known.kind
    steps, way, si, saved = list(steps_of(table)), Way(""), UNITS[known.kind], SAVED[known.kind]
    interval = interval_of(steps, known.interval)
    recordings, stretches, entries = {}, {}, {}
    for number, one in enumerate(steps):
        course = course_of(one, way, interval)
        recordings[one.name] = recorded(number, course, {AXIS: (noise_of(known.all_terms, course, rng), si, saved)})
        stretches[one.name] = course.stretches
        entries[one.name] = entry_of("sensor", one, interval, {AXIS: saved})
    content = {
        "sensors": {"sensor": {"kind": kind, "axes": [AXIS], "unit": saved}},
        "recordings": entries,
        "tests": [{"id": "noise", "procedure": "static_noise", "recordings": list(entries)}],
    }
    truth = tuple(
        TrueValue(quantity_name(one.name, "coefficient", kind), AXIS, float(one.coefficient),  # type: ignore[union-attr]
                  parameter_unit(one.name, "coefficient", si))
        for one in known.all_terms
    )  # fmt: skip
    return Rehearsal(way, recordings, stretches, content, truth=truth)

"""Planned positions rehearsed: a triad that is laid as the schedule says, with the scatter that the plan states."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ....core.errors import UsageError
from ....core.estimate import Array
from ....core.influence import Influence
from ....core.key import AXES
from ....files.text.table import Table
from ....rigs.parts.campaign import Content, standard_tables
from ....rigs.twin import TrueValue
from ...planned import settings_said
from ...rehearsed import Course, Rehearsal, Way, course_of, entry_of, interval_of, recorded, steps_of
from ..plan import Wanted

POSITION, UNIT = "position", "m/s^2"
SCALE, CROSS, BIAS = 0.003, 0.003, 0.05  # of a unit: relative, rad, m/s^2
STEADY, LET_GO = 5.0, 2.0  # [s]
SHAKEN, SHAKEN_AT = 0.5, (0.7, 1.9, 3.7)  # while it is laid [m/s^2], [Hz]
FIRST = 0.0  # before it is laid
WHITE = 2.0  # of a sample, beside the scatter of a position


def rehearse(given: Mapping[str, Any], table: Table, seed: int) -> Rehearsal:
    """Return what the positions of a schedule give on a drawn triad, and its campaign.

    Raises
    ------
    DataError
        If the schedule cannot be read.
    UsageError
        ``contradiction`` if positions are there already.
    """
    said, words = settings_said(Wanted, given, options=True)
    if said.have != "none":
        what = f"{words['have']}: positions already taken have no recording here"
        raise UsageError(what, do="Plan all positions to rehearse them: leave it out", code="contradiction")
    of_unit, of_bench, of_runs = np.random.default_rng(seed).spawn(3)
    way = Way(POSITION, "", STEADY, first=FIRST, longest=LET_GO)
    steps = list(steps_of(table, POSITION))
    interval = interval_of(steps, 0.02)
    up = np.column_stack([table.numbers(axis) for axis in AXES])
    own, cross = of_unit.normal(0.0, SCALE, 3), of_unit.normal(0.0, CROSS, (3, 3))
    matrix: Array = np.eye(3) + np.diag(own) + (np.triu(cross, 1) if said.known else 0.0) + np.tril(cross, -1)
    bias = of_unit.normal(0.0, BIAS, 3)
    gravity = said.gravity + of_bench.normal(0.0, said.gravity_u)
    recordings, stretches, entries = {}, {}, dict[str, Content]()
    for number, one in enumerate(steps):
        course = course_of(one, way, interval)
        laid = up[one.rows.start : one.rows.stop] + (of_bench.normal(0.0, said.pose, (len(one.rows), 3)))
        laid = laid / np.linalg.norm(laid, axis=1, keepdims=True)
        scatter = of_runs.normal(0.0, said.scatter, laid.shape)
        before, moved = np.vstack([np.eye(3)[2], laid[:-1]]), _moved(one.value, course)
        way_up = laid[course.step] * moved[:, None] + before[course.step] * (1.0 - moved[:, None])
        way_up /= np.linalg.norm(way_up, axis=1, keepdims=True)
        read = gravity * way_up @ matrix.T + bias + scatter[course.step]
        read = read + of_runs.normal(0.0, WHITE * said.scatter, read.shape)
        time = np.arange(len(course))[:, None] * interval
        for hertz in SHAKEN_AT:
            turns = hertz * time + of_runs.uniform(0.0, 1.0, 3)
            read = read + SHAKEN * np.sin(np.pi * moved)[:, None] * np.sin(2.0 * np.pi * turns)
        channels = {f"acc_{name}": (read[:, k], UNIT, UNIT) for k, name in enumerate(AXES)}
        recordings[one.name] = recorded(number, course, channels)
        stretches[one.name] = course.stretches
        more = {"orientations": [" ".join(f"{x:g}" for x in up[row]) for row in one.rows]} if said.known else {}
        entry = entry_of("acc", one, interval, {}, **more)
        entries[one.name] = entry | {"channels": {name: {"column": f"acc_{name}", "unit": UNIT} for name in AXES}}
    stated = {"gravity.value": Influence(said.gravity_u, UNIT), "fixture.orientation": Influence(said.pose, "rad")}
    content: Content = {
        "site": {"gravity": f"{said.gravity:.9g} {UNIT}"},
        "standards": standard_tables({name: one for name, one in stated.items() if one.u > 0.0}),
        "sensors": {"acc": {"kind": "accelerometer", "axes": list(AXES), "unit": UNIT}},
        "recordings": entries,
        "tests": [{"id": "positions", "procedure": "positions", "recordings": list(entries)}],
    }
    stable = {"still": [f"acc_{name}" for name in AXES], "for": f"{STEADY:g} s"}
    return Rehearsal(way, recordings, stretches, content, {"stable": stable}, _truth(matrix, bias, said.known))


def _moved(value: Array, course: Course) -> Array:
    """Return how far it has been moved to its next position: 1 there, shape (n,)."""
    before = np.concatenate([[FIRST], value[:-1]])
    return np.asarray((course.value - before[course.step]) / (value - before)[course.step])


def _truth(matrix: Array, bias: Array, known: bool) -> tuple[TrueValue, ...]:
    own, sensor = np.diag(matrix), "accelerometer"
    found = [TrueValue("bias", axis, float(bias[i]), UNIT, sensor=sensor) for i, axis in enumerate(AXES)]
    found += [TrueValue("scale_factor_error", axis, float(own[i] - 1.0), "1", sensor=sensor)
              for i, axis in enumerate(AXES)]  # fmt: skip
    pairs = [(i, j) for i in range(3) for j in range(3) if i > j or (known and i != j)]
    found += [TrueValue("misalignment", AXES[i] + AXES[j], float(matrix[i, j] / own[i]), "rad", sensor=sensor)
              for i, j in pairs]  # fmt: skip
    return tuple(found)

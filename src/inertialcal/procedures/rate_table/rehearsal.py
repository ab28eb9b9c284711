"""A planned rate table rehearsed: a gyro with the noise, power-ups and standards that the plan was made for."""

from __future__ import annotations

import numpy as np

from ...core.estimate import Array
from ...core.key import AXES
from ...core.units import factor
from ...files.text.table import Table
from ...rigs.parts.campaign import Content, attitude, standard_tables
from ...rigs.parts.gyro_bench import Motion, draw_world
from ...rigs.twin import TrueValue
from ..rehearsed import (
    Course,
    Rehearsal,
    Way,
    course_of,
    entry_of,
    interval_of,
    noise_of,
    recorded,
    steps_of,
    terms_of,
)
from .plan import PlannedRates
from .planning import plan_of

SCALE, CROSS, BIAS = 0.003, 0.003, 3e-4  # of a unit: relative, rad, rad/s
RATE, UNIT = "rate", "deg/s"
LEAST_STEADY = 1.0  # [s]


def rehearse(said: PlannedRates, table: Table, seed: int) -> Rehearsal:
    """Return what the steps of a schedule give on a drawn unit, and its campaign.

    Raises
    ------
    DataError
        If the schedule cannot be read.
    """
    of_unit, of_bench, of_runs = np.random.default_rng(seed).spawn(3)
    way = Way(RATE, UNIT, max(said.settle, LEAST_STEADY), first=0.0)
    steps = list(steps_of(table, RATE))
    interval = interval_of(steps)
    standards = dict(plan_of(said).standards)
    latitude = 0.0 if said.latitude is None else float(np.degrees(said.latitude))  # there no rate along the table
    stands = {"table": (0.0, float(np.degrees(said.u_tilt)), 0.0, 0.0)}
    world, _ = draw_world(standards, latitude, 1.0, stands, of_bench)
    matrix: Array = np.eye(3) + np.where(
        np.eye(3) > 0, of_unit.normal(0, SCALE, (3, 3)), of_unit.normal(0, CROSS, (3, 3))
    )
    bias = of_unit.normal(0.0, BIAS, 3)
    terms = terms_of(said.noise, said.instability, said.walk)
    recordings, stretches, entries = {}, {}, dict[str, Content]()
    for number, one in enumerate(steps):
        course, axis = course_of(one, way, interval), one.text("axis")
        rate = world.body_rate(_motion(course), axis) @ matrix.T
        scale = 1.0 + of_runs.normal(0.0, said.turn_on_scale, 3)
        dwells = of_runs.normal(0.0, said.dwell_scatter, (len(one.value), 3))[course.step]
        noise = np.column_stack([noise_of(terms, course, of_runs) for _ in AXES])
        read = world.converter_gain * (scale * rate + bias + of_runs.normal(0.0, said.turn_on, 3) + dwells + noise)
        channels = {name: (read[:, k], "rad/s", UNIT) for k, name in enumerate(AXES)}
        recordings[one.name] = recorded(number, course, channels | {RATE: (course.value, UNIT, UNIT)})
        stretches[one.name] = course.stretches
        entries[one.name] = entry_of(
            "gyro", one, interval, dict.fromkeys(AXES, UNIT), axis=axis, run=one.text("run"),
            schedule={"file": f"schedules/{one.name}.csv", "unit": UNIT},
        )  # fmt: skip
    test: Content = {"id": "rate", "procedure": "rate_table", "recordings": list(entries)}
    content: Content = {}
    if said.latitude is not None:
        content["site"] = {"latitude": f"{latitude:.9g} deg"}
        test["plan"] = {"attitude": attitude(0.0, stands["table"][1], 0.0, 0.0)}
    content |= {
        "standards": standard_tables(standards),
        "sensors": {"gyro": {"kind": "gyro", "axes": list(AXES), "unit": UNIT}},
        "recordings": entries,
        "tests": [test],
    }
    stable = {"channel": RATE, "follows": f"bench.{RATE}", "within": f"0.001 {UNIT}", "for": f"{way.steady:g} s"}
    return Rehearsal(way, recordings, stretches, content, {"stable": stable}, _truth(matrix, bias))


def _motion(course: Course) -> Motion:
    rate: Array = np.asarray(course.value * factor(UNIT, "rad/s"), dtype=np.float64)
    turned: Array = rate * course.interval
    start: Array = np.arange(len(course), dtype=np.float64) * course.interval
    return Motion(start, rate, np.cumsum(turned) - turned, turned, course.step)


def _truth(matrix: Array, bias: Array) -> tuple[TrueValue, ...]:
    own = np.diag(matrix)
    found = [TrueValue("bias", axis, float(bias[i]), "rad/s") for i, axis in enumerate(AXES)]
    found += [TrueValue("scale_factor_error", axis, float(own[i] - 1.0), "1") for i, axis in enumerate(AXES)]
    found += [TrueValue("scale_factor_asymmetry", axis, 0.0, "1") for axis in AXES]
    found += [TrueValue("misalignment", a + b, float(matrix[i, j] / own[i]), "rad")
              for i, a in enumerate(AXES) for j, b in enumerate(AXES) if i != j]  # fmt: skip
    return tuple(found)

"""A planned thermal test rehearsed: a sensor in a chamber, with the coefficient and scatter that the plan states."""

from __future__ import annotations

import numpy as np

from ...core.key import At
from ...files.text.table import Table
from ...physics.earth import earth_rate
from ...rigs.parts.campaign import Content, standard_tables
from ...rigs.parts.gyro_bench import draw_world
from ...rigs.twin import TrueValue
from ..rehearsed import Rehearsal, Way, course_of, entry_of, interval_of, noise_of, recorded, steps_of
from .planning import AXIS, Known

TEMPERATURE, UNIT = "temperature", "degC"
SAVED = {"rad/s": "deg/s", "m/s^2": "m/s^2"}
BIAS = {"rad/s": 3e-4, "m/s^2": 0.02}  # of a unit


def rehearse(known: Known, table: Table, seed: int) -> Rehearsal:
    """Return what the steps of a schedule give on a drawn unit, and its campaign.

    Raises
    ------
    DataError
        If the schedule cannot be read.
    """
    said, si = known.said, known.unit
    of_unit, of_bench, of_runs = np.random.default_rng(seed).spawn(3)
    way = Way(TEMPERATURE, UNIT, during=True, first=said.room)
    steps = list(steps_of(table, TEMPERATURE))
    interval = interval_of(steps, said.interval)
    standards = dict(known.plan.standards)
    latitude = 0.0 if said.latitude is None else float(np.degrees(said.latitude))
    tilt = float(np.degrees(said.u_tilt))
    heading = float(np.degrees(of_bench.uniform(0.0, 2.0 * np.pi)))
    world, _ = draw_world(standards, latitude, 1.0, {"chamber": (0.0, tilt, heading, 0.0)}, of_bench)
    earth = float((world.levels["chamber"] @ earth_rate(world.latitude))[0]) if said.latitude is not None else 0.0
    earth = earth if si == "rad/s" else 0.0
    bias = float(of_unit.normal(0.0, BIAS[si]))
    recordings, stretches, entries = {}, {}, dict[str, Content]()
    for number, one in enumerate(steps):
        course = course_of(one, way, interval)
        away = course.value - said.reference_temperature
        slope = known.coefficient + of_runs.normal(0.0, known.turn_on_slope)
        read = earth + bias + of_runs.normal(0.0, known.turn_on) + slope * away
        read = read + noise_of(known.terms, course, of_runs)
        shown = course.value + world.thermometer
        channels = {AXIS: (read, si, SAVED[si]), TEMPERATURE: (shown, UNIT, UNIT)}
        recordings[one.name] = recorded(number, course, channels)
        stretches[one.name] = course.stretches
        columns = {AXIS: SAVED[si], TEMPERATURE: UNIT}
        entries[one.name] = entry_of("sensor", one, interval, columns, run=one.text("run"))
    inside = 3.0 * said.u_thermometer  # as it is read
    ends = (said.coldest + inside, said.hottest - inside)
    at = [f"{one:.9g} degC" for one in ends]
    plan: Content = {"at": at, "reference_temperature": f"{said.reference_temperature:g} degC", "order": said.order,
                     "warm_up": f"{said.warm_up:g} s"}  # fmt: skip
    content: Content = {}
    if said.latitude is not None and si == "rad/s":
        content["site"] = {"latitude": f"{latitude:.9g} deg"}
        plan["attitude"] = {"tilt": "0 deg", "u": f"{tilt:g} deg"}
    kind = "gyro" if si == "rad/s" else "accelerometer"
    content |= {
        "standards": standard_tables(standards),
        "sensors": {"sensor": {"kind": kind, "axes": [AXIS], "unit": SAVED[si]}},
        "recordings": entries,
        "tests": [{"id": "thermal", "procedure": "thermal", "recordings": list(entries), "plan": plan}],
    }
    truth = [TrueValue("bias", AXIS, bias, si)]
    truth += [TrueValue("bias", AXIS, bias + known.coefficient * (one - said.reference_temperature), si,
                        at=At("temperature", one, "degC")) for one in ends]  # fmt: skip
    return Rehearsal(way, recordings, stretches, content, truth=tuple(truth))

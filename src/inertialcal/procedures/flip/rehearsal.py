"""Planned flips rehearsed: a head that is turned, with the ambient acceleration and noise that the plan states."""

from __future__ import annotations

import numpy as np

from ...core.estimate import Array
from ...core.key import AXES
from ...files.text.table import Table
from ...rigs.parts.campaign import Content, standard_tables
from ...rigs.parts.head_turn import felt
from ...rigs.twin import TrueValue
from ..rehearsed import Rehearsal, Way, course_of, entry_of, interval_of, noise_of, recorded, steps_of, terms_of
from .plan import PlannedFlips
from .planning import UNIT, plan_of
from .simulation import draw

ANGLE, DEGREES = "angle", "deg"
BIAS = 1e-3  # of a unit [m/s^2]
STEADY = 10.0  # [s]


def rehearse(said: PlannedFlips, table: Table, seed: int) -> Rehearsal:
    """Return what the steps of a schedule give on a drawn head, and its campaign.

    Raises
    ------
    DataError
        If the schedule cannot be read.
    """
    of_unit, of_bench, of_runs = np.random.default_rng(seed).spawn(3)
    plan = plan_of(said)
    way = Way(ANGLE, DEGREES, min(STEADY, 0.5 * said.turn), first=0.0)
    steps = list(steps_of(table, ANGLE))
    interval = interval_of(steps)
    bias = of_unit.normal(0.0, BIAS, 3)
    turned = [AXES.index(name) for name in plan.turned]
    ambient: Array = np.zeros(3)
    heading = of_bench.uniform(0.0, 2.0 * np.pi)
    ambient[turned] = said.ambient * np.array([np.cos(heading), np.sin(heading)])
    along = np.eye(3)[AXES.index(plan.axis)]
    for k in turned:
        along[k] = draw(plan, "turn.axis", of_bench)
    along /= np.linalg.norm(along)
    off, zero = draw(plan, "turn.angle", of_bench), np.array([draw(plan, "converter.zero", of_bench) for _ in AXES])
    recordings, stretches, entries = {}, {}, dict[str, Content]()
    means: dict[str, list[Array]] = {"bias": [], "ambient": []}
    for number, one in enumerate(steps):
        course = course_of(one, way, interval)
        time = (np.arange(len(course)) + 0.5) * interval
        swing = said.swing * np.cos(2.0 * np.pi * (time / said.orbit + of_runs.uniform()))
        fixed = ambient + np.where(np.isin(np.arange(3), turned), 1.0, 0.0) * swing[:, None]
        angle = np.radians(course.value)
        angle = angle + off * (np.abs(angle) > 0.0)
        slow = np.column_stack([noise_of(terms_of(0.0, said.instability, said.walk), course, of_runs) for _ in AXES])
        white = np.column_stack([noise_of(terms_of(said.noise), course, of_runs) for _ in AXES])
        own = bias + of_runs.normal(0.0, said.turn_on, 3)
        read = felt(fixed, angle, along) + own + zero + slow + white
        means["bias"].append(own + slow.mean(axis=0))
        means["ambient"].append(fixed.mean(axis=0))
        channels = {name: (read[:, k], UNIT, UNIT) for k, name in enumerate(AXES)}
        recordings[one.name] = recorded(number, course, channels | {ANGLE: (course.value, DEGREES, DEGREES)})
        stretches[one.name] = course.stretches
        dwells = {
            "file": f"schedules/{one.name}.csv",
            "angle": ANGLE,
            "unit": DEGREES,
            "dwell": "dwell",
            "flip": "flip",
        }
        entries[one.name] = entry_of("head", one, interval, dict.fromkeys(AXES, UNIT), dwells=dwells)
    content: Content = {
        "standards": standard_tables(dict(plan.standards), {"m/s^2": "ug", "rad": "deg"}),
        "sensors": {"head": {"kind": "accelerometer", "axes": list(AXES), "unit": UNIT}},
        "recordings": entries,
        "tests": [{"id": "flip", "procedure": "flip", "recordings": list(entries)}],
    }
    true = {"bias": np.mean(means["bias"], axis=0), "ambient_acceleration": np.mean(means["ambient"], axis=0)}
    if said.turn_on:
        true["bias"] = bias
    truth = [TrueValue(name, AXES[k], float(values[k]), UNIT) for name, values in true.items() for k in turned]
    stable = {"channel": ANGLE, "follows": f"bench.{ANGLE}", "within": f"0.01 {DEGREES}", "for": f"{way.steady:g} s"}
    return Rehearsal(way, recordings, stretches, content, {"stable": stable, "keep": ["flip", "dwell"]}, tuple(truth))

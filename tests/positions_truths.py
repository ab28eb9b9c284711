"""Simulated units whose truth is known, and what an estimate should be of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from inertialcal.core.estimate import Array
from inertialcal.core.influence import Influence
from inertialcal.procedures.positions.fit.gyro import problem_of
from inertialcal.procedures.positions.fit.rotations import angles
from inertialcal.procedures.positions.readings import local_gravity
from inertialcal.procedures.positions.reduction import Plan, Readings, Truth, reduce
from inertialcal.procedures.positions.simulation import FACES, spread
from inertialcal.rigs.hand_held.rig import Bench, build, draw_unit, held

G = 9.8
LOWER = np.array([[1.01, 0.0, 0.0], [0.008, 0.99, 0.0], [-0.012, 0.006, 1.02]])
FULL = np.array([[1.01, 0.004, -0.006], [0.008, 0.99, 0.01], [-0.012, 0.006, 1.02]])
SIGNS = [(a, b) for a in (1.0, -1.0) for b in (1.0, -1.0)]
EDGES = np.array([(a, b, 0.0) for a, b in SIGNS] + [(a, 0.0, b) for a, b in SIGNS] + [(0.0, a, b) for a, b in SIGNS])
BODY = Truth(
    acc_matrix=LOWER,
    gyro_matrix=FULL,
    acc_bias=np.array([0.1, -0.2, 0.15]),
    gyro_bias=np.array([0.01, -0.02, 0.005]),
    g_sensitivity=np.array([[1e-4, -2e-4, 5e-5], [1.5e-4, 3e-5, -1e-4], [-8e-5, 1e-4, 6e-5]]),
)
BY_HAND = replace(BODY, directions=spread(20))  # only gravity is known
CUBE = replace(BODY, acc_matrix=FULL, known=True, directions=np.vstack([FACES, EDGES / np.sqrt(2.0)]))
TURNED = replace(
    CUBE, directions=np.vstack([FACES, FACES]), turns=2.0 * np.pi * np.vstack([np.eye(3), -np.eye(3)])
)  # six faces twice, a whole turn each way
PLAN = Plan(gravity=G)
BY_HAND_PLAN = Plan(gravity=G, standards={"gravity.value": Influence(3e-4, "m/s^2"), "clock.rate": Influence(1e-4)})
FIXTURE_PLAN = Plan(
    gravity=G,
    standards={
        "gravity.value": Influence(3e-4, "m/s^2"),
        "fixture.orientation": Influence(2e-3, "rad"),
        "fixture.mounting": Influence(5e-4, "rad", distribution="rectangular"),
        "turn.angle": Influence(3e-3, "rad"),
        "clock.rate": Influence(1e-4),
    },
)


def true_values(truth: Truth, kind: str) -> dict[str, float]:
    """True value of each quantity of one kind of sensor, by name."""
    gyro = kind == "gyro"
    matrix, bias = (truth.gyro_matrix, truth.gyro_bias) if gyro else (truth.acc_matrix, truth.acc_bias)
    found = {}
    for i, a in enumerate("xyz"):
        found[f"bias_{a}"] = float(bias[i])
        found[f"scale_factor_error_{a}"] = float(matrix[i, i] - 1.0)
        for j, b in enumerate("xyz"):
            if i != j:
                found[f"misalignment_{a}{b}"] = float(matrix[i, j] / matrix[i, i])
            if gyro:
                found[f"g_sensitivity_{a}{b}"] = float(truth.g_sensitivity[i, j])
    return found


def changed(readings: Readings, acc: Array, gyro: Array, time: float = 1.0) -> Readings:
    """Readings as they would be with other columns or units: rows of acc and gyro times these matrices."""
    assert readings.gyro is not None
    rotations = tuple(
        replace(one, seconds=one.seconds * time, gyro=one.gyro @ gyro, acc=None if one.acc is None else one.acc @ acc)
        for one in readings.rotations
    )
    return replace(
        readings,
        acc=replace(readings.acc, mean=readings.acc.mean @ acc),
        gyro=replace(readings.gyro, mean=readings.gyro.mean @ gyro),
        rotations=rotations,
    )


def held_out(plan: Plan, readings: Readings, first: int) -> tuple[float, float]:
    """Fit the first positions; return the errors of the others, rms: lengths [m/s^2], angles of transitions [rad]."""
    result = reduce(plan, readings.take(0, first))
    rest = readings.take(first, len(readings))
    lengths = np.linalg.norm(result.acc.sensor.applied(rest.acc.mean), axis=1) - local_gravity(plan)
    gyro = result.gyro
    assert gyro is not None
    assert gyro.rotated is not None
    problem = problem_of(plan, rest, result.acc, gyro.rest, gyro.sensor.ideal, gyro.sensor.zero)
    missed = angles(problem, gyro.rotated.W)
    return float(np.sqrt(np.mean(lengths**2))), float(np.sqrt(np.mean(missed**2)))


def protocol(bench: Bench, seed: int = 1) -> dict[str, dict[str, int]]:
    """Which samples of the first record of a bench are which face or turn, as a file of sections says it."""
    of_unit, _, of_records = np.random.default_rng(seed).spawn(3)
    drawn = build(bench, seed).drawn
    mounting, faces = np.array(drawn["mounting"]), np.reshape(drawn["faces"], (6, 3))
    parts = held(bench, draw_unit(bench, of_unit), bench.gravity, 1.0, 0, of_records, mounting, faces).parts
    sections = {}
    for part in parts:
        vector = part.axis if part.angle is not None else part.direction
        if vector is None:
            continue
        axis = "xyz"[int(np.argmax(np.abs(vector)))]
        label = f"{axis}_rot" if part.angle is not None else f"{axis}_{'p' if sum(vector) > 0 else 'a'}"
        sections[label] = {"start": part.start, "end": part.stop}
    return sections

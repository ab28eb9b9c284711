"""Runs of the independent simulator as readings, reduced and judged without the engine."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from independent.vibration.random_run import Array, G, Run, simulate
from inertialcal.core.influence import Influence
from inertialcal.core.judging import Asked, Verdict
from inertialcal.procedures.protocol import Tested
from inertialcal.procedures.vibration.judging import judge_level, judge_lines
from inertialcal.procedures.vibration.plan import CONTROL_SCALE, DEVIATION, LEVEL_DEVIATION, Plan
from inertialcal.procedures.vibration.profile_file import Node, completed
from inertialcal.procedures.vibration.readings import Readings
from inertialcal.procedures.vibration.reduction import Result, reduce
from inertialcal.statistics.decision import decide

SHORT = ((20.0, 0.01), (80.0, 0.04), (200.0, 0.04), (500.0, 0.01))  # g^2/Hz
QUICK = Run(nodes=SHORT, rate=1280.0, duration=20.0)  # 25,600 samples
PLAN = Plan(resolution=5.0)


def readings_of(
    run: Run, seed: int, control: Array | None = None, responses: Array | None = None, scale: float = 1.0
) -> Readings:
    """Return a run as readings; ``scale`` is the true scale factor of the control accelerometers."""
    x = scale * (simulate(run, seed)[0] if control is None else control)
    nodes = [Node(f, s * G * G) for f, s in run.nodes]
    stated = completed(nodes, [None] * (len(nodes) - 1))
    names = tuple(f"control_{i + 1}" for i in range(x.shape[1]))
    rest = np.zeros((len(x), 0)) if responses is None else responses
    axes = ("x", "y", "z")[: rest.shape[1]]
    return Readings("run", "run.csv", 1.0 / run.rate, x, names, rest, axes, "m/s^2", False, stated)


def reduced(run: Run, seed: int, plan: Plan = PLAN, scale: float = 1.0) -> Result:
    """Return a run reduced."""
    return reduce(plan, readings_of(run, seed, scale=scale))


def with_scale(plan: Plan, u: float) -> Plan:
    """Return a plan with a standard uncertainty of the control's scale factor."""
    return replace(plan, standards={CONTROL_SCALE: Influence(u, "1")})


def lines_verdict(result: Result, tolerance: str, where: str = "") -> Verdict:
    """Return the verdict on all lines."""
    asked = Asked("T", DEVIATION, limit=tolerance, where=where)
    (found,) = judge_lines(asked, [Tested("run", "", "fit", result.plan, result.readings, result)])
    return found


def overall_verdict(result: Result, limit: float) -> str:
    """Return the verdict on the overall level, as the general rule judges it."""
    row = next(one for one in result.rows() if one.quantity == "acceleration_rms_deviation")
    return decide(row.value, row.u, row.dof, -limit, limit).status


def step_verdict(result: Result, limit: str) -> str:
    """Return the verdict on the overall level that steps above full level make; empty where they make none."""
    asked = Asked("O", LEVEL_DEVIATION, limit=limit)
    found = judge_level(asked, [Tested("run", "", "fit", result.plan, result.readings, result)])
    return found[0].verdict if found else ""


def codes(result: Result) -> set[str]:
    """Return the codes of the remarks."""
    return {one.code for one in result.remarks}

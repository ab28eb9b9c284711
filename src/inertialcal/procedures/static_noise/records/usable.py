"""Whether terms can be told from records at all: told before anything is fitted, and why not."""

from __future__ import annotations

from collections.abc import Mapping

from ....core.errors import DataError, Problem
from ....sensors.noise.fitting.noise_fit import duration
from ....sensors.noise.fitting.problem import run_of
from ....sensors.noise.terms import sample_unit
from ....signals.allan import Allan
from ..deviations import fitted
from ..plan import Plan
from ..readings import Readings

NOISELESS = {"rate_ramp"}  # terms that scatter nothing


def check(plan: Plan, readings: Readings) -> None:
    """Refuse, at the cost of Allan deviations alone, records that no terms can be told from.

    Parameters
    ----------
    plan : Plan
        What is asked for.
    readings : Readings
        All records.

    Raises
    ------
    DataError
        As ``reduce``: if no record of any axis is long enough, with some noise, or the terms have none (``no_noise``).
    """
    if plan.terms is not None and set(plan.terms) <= NOISELESS:
        what = f"terms: {', '.join(plan.terms) or 'none'}, without noise"
        raise DataError(what, why="nothing would scatter", do='Add "random_walk"', code="no_noise")
    problems: dict[str, Problem] = {}
    for axis in readings.axes:
        for run in readings.records:
            try:
                check_usable(plan, fitted(plan, run, axis, run.there(axis)))
            except DataError as error:
                problems.setdefault(axis, error.problems[0])
            else:
                return
    raise DataError(problems_of(problems, readings))


def problems_of(found: Mapping[str, Problem], readings: Readings) -> list[Problem]:
    """Return why no axis has terms, each reason once, with the axes that it holds for.

    Parameters
    ----------
    found : mapping of str to Problem
        By axis.
    readings : Readings
        All records.
    """
    alike: dict[Problem, list[str]] = {}
    for axis, problem in found.items():
        alike.setdefault(problem, []).append(axis)
    recorded = f"{duration(readings.length)} recorded, {len(readings.records[0])} samples a record"
    return [
        Problem(
            f"no noise terms of {', '.join(names)}: {problem.what}",
            readings.records[0].name,
            problem.why or recorded,
            problem.do or "Record the sensor standing still, for longer",
            problem.code,
        )
        for problem, names in alike.items()
    ]


def check_usable(plan: Plan, curve: Allan) -> None:
    """Refuse a curve that is too short for terms, or without noise.

    Parameters
    ----------
    plan : Plan
        Whose kind of sensor says the unit.
    curve : Allan
        That terms would be fitted to.

    Raises
    ------
    DataError
        ``too_short``, ``constant``.
    """
    run_of(curve, 0, sample_unit(plan.kind, plan.unit))

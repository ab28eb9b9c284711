"""Scale factor with its budget, and what it is compared with.

Type A is the scatter of the runs (or the noise in them), with its degrees of freedom. Type B is what is uncertain of
the acceleration applied, of the mercury of the tilt meter, of a tilt that was not taken off, and what a regressed one
leaves: the same in all runs, so that more runs do not shrink it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from ....core.estimate import Array, Component, Estimate
from ....core.influence import Influence
from ....core.key import Key, Origin
from ..plan import APPLIED, Plan
from ..readings import Readings
from .of_run import G, Response, tilt_left
from .runs import Combined

SCALE, ERROR, DIFFERENCE = "scale_factor", "scale_factor_error", "high_g_difference"
UNIT = "count/s/(m/s^2)"
SOURCES = {"between_runs": "scatter between runs", "within_runs": "noise beside the line of each run"}
NAMES = {
    "source_mass.density": "density of the mass", "source_mass.placing": "places of the mass",
    "source_mass.gravitational_constant": "gravitational constant",
}  # fmt: skip


def estimate_of(
    plan: Plan, readings: Readings, responses: Sequence[Response], both: Combined, scatter: str
) -> Estimate:  # fmt: skip
    """Return the scale factor and what it is compared with, SI.

    Parameters
    ----------
    plan, readings : Plan, Readings
        Of the campaign.
    responses : sequence of Response
        Of its runs.
    both : Combined
        Of those with the mass moved [count/s/(m/s^2)].
    scatter : {"between_runs", "within_runs"}
        Which uncertainty counts.
    """
    found = both.between if scatter == "between_runs" and both.between is not None else both.within
    names, values, slopes, units = [SCALE], [found.value], [1.0], [UNIT]
    if plan.nominal:
        names, values = [*names, ERROR], [*values, found.value / plan.nominal - 1.0]
        slopes, units = [*slopes, 1.0 / plan.nominal], [*units, "1"]
    if plan.high_g is not None:
        names, values = [*names, DIFFERENCE], [*values, found.value / plan.high_g.scale_factor - 1.0]
        slopes, units = [*slopes, 1.0 / plan.high_g.scale_factor], [*units, "1"]
    way = np.array(slopes)
    type_a = Component(Origin(SOURCES[scatter], level=scatter), "A", _outer(way * found.u), found.dof, "t")
    parts = [type_a, *_type_b(plan, readings, responses, found.value, way)]
    if plan.high_g is not None and plan.high_g.u > 0.0:
        own = np.zeros(len(way))
        own[-1] = plan.high_g.u * found.value / plan.high_g.scale_factor**2
        parts.append(Component("high-g scale factor", "B", _outer(own), stated=(plan.high_g.u, UNIT)))
    return Estimate(tuple(Key(name, plan.axis) for name in names), np.array(values), tuple(units), tuple(parts))


def applied_known(plan: Plan, readings: Readings) -> dict[str, Influence]:
    """Return what is known of the amplitude applied, relative, by its name: of the standards, else of the schedules."""
    stated = {NAMES[name]: plan.standards[name] for name in APPLIED if name in plan.standards}
    if stated:
        return stated
    said = [run.schedule.u_applied for run in readings.series if run.moved]
    said += [line.u_applied or None for line in readings.lines if line.moved]
    known = [u for u in said if u is not None]
    return {"acceleration applied": Influence(float(np.mean(known)))} if known and len(known) == len(said) else {}


def _type_b(
    plan: Plan, readings: Readings, responses: Sequence[Response], scale: float, way: Array
) -> Iterator[Component]:
    for name, one in applied_known(plan, readings).items():
        yield Component(one.origin(name), "B", _outer(way * scale * one.u), one.dof, one.distribution, one.stated)
    for name, slope in _slopes(plan, responses, scale).items():
        stated = plan.standards.get(name)
        if stated is not None and slope:
            said = "mercury of the tilt meter" if name == "tilt_meter.mercury" else "tilt of the pad, not taken off"
            u = way * slope * stated.u
            yield Component(stated.origin(said), "B", _outer(u), stated.dof, stated.distribution, stated.stated)
    yield from _left(responses, scale, way)


def _left(responses: Sequence[Response], scale: float, way: Array) -> Iterator[Component]:
    """Yield the doubt of what a regressed tilt has left, all of it as one standard uncertainty."""
    left = tilt_left(responses, scale)
    if left:
        yield Component("tilt left by the noise of its meter", "B", _outer(way * left))


def _slopes(plan: Plan, responses: Sequence[Response], scale: float) -> Mapping[str, float]:
    """Return how the scale factor follows a tilt that is taken wrongly, mean over the runs [count/s/(m/s^2)/rad]."""
    moved = [one for one in responses if one.moved]
    taken = [0.0 if one.tilt_used == "ignored" else abs(one.coefficient) / one.applied for one in moved]
    left = [scale * G / one.applied if one.tilt_used == "ignored" else 0.0 for one in moved]
    return {"tilt_meter.mercury": float(np.mean(taken)), "pad.tilt": float(np.mean(left))}


def words_of(plan: Plan, estimate: Estimate | None) -> dict[str, str]:
    """Return what is to be said of figures of the estimate: what they are compared with, and how far off."""
    if estimate is None:
        return {}
    found = {}
    if plan.nominal:
        found[ERROR] = f"relative to {plan.nominal:.5g} {UNIT}, the scale factor of the chain"
    if plan.high_g is not None:
        i = len(estimate.names) - 1
        normalised = float(estimate.values[i]) / float(estimate.u[i])
        found[DIFFERENCE] = (
            f"relative to {plan.high_g.scale_factor:.5g} {UNIT} at high g; normalised difference {normalised:+.2f}"
        )
    return found


def _outer(u: Array) -> Array:
    return np.outer(u, u)

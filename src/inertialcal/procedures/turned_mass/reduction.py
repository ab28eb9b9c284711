"""Scale factor of an accelerometer in orbit from a mass that is turned around it.

Each run gives the harmonics of its turn (``response``); all runs together give scale factor, recoil arm and the offset
of the proof mass from the axis of rotation (``joining``). The proposal of 1969 [1]_ expects scale factor, nonlinearity
and bias; it leaves the recoil of the satellite out, which is as large as the attraction. What the runs do not tell:

- nonlinearity: K2 reads as an offset of the axis of rotation, K3 as attraction, and both are far below the noise;
- bias: the level is bias plus ambient acceleration, which is hundreds of times the attraction; a flip tells them apart.

The uncertainty is that of the runs (``joining``), with mass, distance, gravitational constant, orbital rate, height of
the proof mass over the plane of the turn and direction of the input axis, which are common to all runs.

References
----------
.. [1] K. Reinel, NASA TM X-53857, 1969, Figure 15 and its text.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ...core.constants import GRAVITATIONAL_CONSTANT
from ...core.curve import Curve
from ...core.errors import DataError
from ...core.estimate import Array, Component, Estimate
from ...core.influence import Influence
from ...core.key import Key, Origin
from ...core.remarks import Remark, gather
from ...core.results import Row
from ...core.show.result_tables import estimate_table, remarks_line
from ...core.show.rounding import number
from ...core.show.tables import Block, html, text
from ...physics.orbit import orbital_rate
from ...physics.turned_mass import recoil_arm, recoil_rates
from ...sensors.model.sensor_model import Provenance
from ...statistics.intervals import coverage_factor
from ..model_terms import ModelTerms
from ..protocol import Tested
from .joining import (
    ACROSS,
    ALONG,
    ARM,
    DISAGREE,
    DISTURBED,
    ZERO,
    Cause,
    Joined,
    Orbit,
    S,
    causes,
    join,
    orbit_of,
    separable,
)
from .plan import CONSTANT, HEIGHT, MASS, ORBIT, RADIUS, SATELLITE, Plan
from .readings import Readings, with_turn
from .response import Response, responses_of
from .rows import (
    ACROSS_IT,
    ANGLE,
    DIFFERENCE,
    ERROR,
    OFFSET,
    RECOIL,
    RECOIL_DIFFERENCE,
    SCALE,
    UNIT,
    curves,
    result_remarks,
    rows,
)

FLOOR = 3.0  # standard uncertainties of a scale factor, below which there is none
FARTHEST_ZERO = math.pi / 4.0  # of the angle, from which its sense is that of chance
MANY = 10  # runs, up to which pairs are tried as exchanged
ROOT_3 = math.sqrt(3.0)
LEVELS = {"between_runs": "scatter between runs", "within_runs": "noise within the runs"}


@dataclass(frozen=True, eq=False)
class Result:
    """Result of a campaign."""

    plan: Plan  # As given
    readings: Readings  # As given
    responses: tuple[Response, ...]  # Of each run
    orbit: Orbit  # What was taken as known
    joined: Joined  # All runs that do not meet the orbit
    estimate: Estimate | None  # Scale factor first, SI; None where it cannot be told from noise
    reason: str = ""  # Why there is none
    remarks: tuple[Remark, ...] = ()  # On the result

    @property
    def used(self) -> tuple[Response, ...]:
        """Runs that tell of the scale factor."""
        return tuple(one for one in self.responses if not one.met)

    def rows(self) -> tuple[Row, ...]:
        """Rows of ``results.json``, SI."""
        return tuple(rows(self))

    def curves(self) -> list[Curve]:
        """Curves of ``results.json``, SI."""
        return curves(self)

    def parts(self) -> tuple[Block, ...]:
        """Return number of runs and readings, the figures in SI, number of remarks."""
        caption = f"turned mass: {len(self.readings.series)} run(s), {len(self.readings)} reading(s)"
        found = estimate_table([row.to_dict() for row in self.rows() if not row.case.beside], caption)
        return (*found, *remarks_line(self.remarks))

    def __str__(self) -> str:
        """Return the tables as text."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return the tables for a notebook."""
        return html(self.parts())


def rate_of_orbit(plan: Plan) -> tuple[float, Influence | None]:
    """Return the orbital rate [rad/s], and its uncertainty: as stated, relative, or by the shape of the earth."""
    stated = plan.standards.get(ORBIT)
    if plan.orbit_period is not None:
        return 2.0 * math.pi / plan.orbit_period, stated
    found = orbital_rate(float(plan.altitude or 0.0))
    rate = float(found.values[0])
    return rate, stated or Influence(float(found.u[0]) / rate, distribution="rectangular")


def reduce(plan: Plan, readings: Readings) -> Result:
    """Return scale factor, recoil arm and offsets.

    Parameters
    ----------
    plan : Plan
        Settings of the campaign.
    readings : Readings
        Of its runs.

    Raises
    ------
    DataError
        ``one_speed`` if all runs have one rate of turn and the recoil is to be found; ``orbit_line`` if all runs turn
        at a multiple of the orbital rate; ``wrong_sense`` or ``runs_exchanged`` if the runs agree only so;
        ``wrong_angle`` if the mass is 45 deg or more from where the programme says; as `responses_of`.
    """
    rate, _ = rate_of_orbit(plan)
    orbit = orbit_of(plan, rate)
    responses = responses_of(readings.series, rate, plan.orbit_lines)
    used = [one for one in responses if not one.met]
    if not used:
        met = ", ".join(f"{one.run.name} meets {one.met} times the orbital rate" for one in responses)
        do = f"Turn at rates that differ from multiples of the orbit, {2.0 * math.pi / rate:.0f} s, by a turn a run"
        raise DataError(met, responses[0].run.where, "what the orbit does cannot be told apart", do, "orbit_line")
    if orbit.arm is None and not separable(used, orbit):
        raise _one_speed(used, orbit, plan)
    both = join(used, orbit)
    likely = causes(used, orbit) if both.p_value < DISAGREE else []
    if both.p_value < DISAGREE:
        _refuse(plan, used, orbit, likely)
    estimate, reason = None, ""
    if abs(both.values[S]) >= FLOOR * math.sqrt(both.within[S, S]):
        _refuse_angle(used, both)
        estimate = _estimate(plan, used, both)
    else:
        reason = f"the response of {len(used)} run(s) is below {FLOOR:g} times the noise"
    result = Result(plan, readings, tuple(responses), orbit, both, estimate, reason)
    disturbed = [one.run for one in likely]
    return replace(result, remarks=gather([*readings.remarks, *result_remarks(result, disturbed)]))


def _one_speed(used: Sequence[Response], orbit: Orbit, plan: Plan) -> DataError:
    turn = used[0].run.turn
    what = f"all runs turn once in {turn.named}: scale factor and recoil cannot be told apart"
    why = "only their sum is read"
    if plan.satellite is not None:
        share = recoil_arm(*plan.turned, plan.satellite) * float(
            recoil_rates(turn.rate, orbit.rate, orbit.axis)[0]) / orbit.attraction  # fmt: skip
        why = f"only their sum is read, and by the masses the recoil is {number(share, 3)} of the attraction"
    do = 'Add runs at another rate, or in the other sense; or state the recoil: satellite, and recoil = "stated"'
    return DataError(what, used[0].run.where, why, do, "one_speed")


def _refuse(plan: Plan, used: Sequence[Response], orbit: Orbit, likely: Sequence[Cause]) -> None:
    """Refuse runs that agree only with another sense, or with the readings of each other."""
    senses = [one for one in likely if one.kind != DISTURBED]
    if senses:
        names = " or ".join(one.run for one in senses if one.run)
        what = "the runs agree only if the mass turned in the other sense in all of them"
        if names:
            what = f"run {names}: the runs agree only if its mass turned in the other sense"
        why = "the recoil depends on the sense, with the orbit or against it"
        do = "Correct the sign of rate in the programme: + is the sense of the orbit"
        where = next((one.run.where for one in used if one.run.name == senses[0].run), used[0].run.where)
        raise DataError(what, where, why, do, "wrong_sense")
    runs = [one.run for one in used]
    pairs = [(i, j) for j in range(len(runs)) for i in range(j)] if len(runs) <= MANY else []
    for i, j in pairs:
        one, other = runs[i], runs[j]
        if (one.turn.rate, one.turn.angle) == (other.turn.rate, other.turn.angle):
            continue
        changed = list(runs)
        changed[i], changed[j] = with_turn(one, other.turn), with_turn(other, one.turn)
        try:
            again = join(responses_of(changed, orbit.rate, plan.orbit_lines), orbit)
        except DataError:
            continue
        if again.p_value > DISAGREE:
            what = f"runs {one.name} and {other.name}: the readings of each fit the turn of the other"
            do = "Exchange their files, or their rows in the programme"
            raise DataError(what, one.where, "the recordings were exchanged", do, "runs_exchanged")


def _refuse_angle(used: Sequence[Response], both: Joined) -> None:
    """Refuse angles that are surely nearer to those across the input axis: the sign would be that of chance."""
    zero, k = float(both.values[ZERO]), both.scatter
    reach = coverage_factor(float(both.dof(k)[ZERO])) * math.sqrt(both.covariance(k)[ZERO, ZERO])
    if abs(zero) - reach > FARTHEST_ZERO:
        what = f"the mass is {math.degrees(zero):+.0f} deg from where the programme says, or half a turn from that"
        why = "which of the two it is decides the sign of the scale factor, and the readings cannot tell"
        do = "Count angle from the input axis, positive in the sense of the orbit; check begin, and input_axis"
        raise DataError(what, used[0].run.where, why, do, "wrong_angle")


class Figure(NamedTuple):
    """A figure: a parameter times a factor, less a number."""

    name: str
    unit: str
    of: int  # Parameter
    times: float = 1.0
    less: float = 0.0


def figures_of(plan: Plan) -> list[Figure]:
    """Return the figures that a plan asks for, the scale factor first."""
    mass, radius = plan.turned
    found = [Figure(SCALE, UNIT, S)]
    if plan.nominal:
        found.append(Figure(ERROR, "1", S, 1.0 / plan.nominal, 1.0))
    if plan.high_g is not None:
        found.append(Figure(DIFFERENCE, "1", S, 1.0 / plan.high_g.scale_factor, 1.0))
    if plan.recoil == "found":
        found.append(Figure(RECOIL, "m", ARM))
        if plan.satellite is not None:
            found.append(Figure(RECOIL_DIFFERENCE, "1", ARM, 1.0 / recoil_arm(mass, radius, plan.satellite), 1.0))
    return [
        *found,
        Figure(OFFSET, "m", ALONG, radius),
        Figure(ACROSS_IT, "m", ACROSS, radius),
        Figure(ANGLE, "rad", ZERO),
    ]


def _values(theta: Array, figures: Sequence[Figure]) -> Array:
    return np.array([theta[one.of] * one.times - one.less for one in figures])


def _estimate(plan: Plan, used: Sequence[Response], both: Joined) -> Estimate:
    """Return the figures with their uncertainty."""
    figures, scatter = figures_of(plan), both.scatter
    at, times = [one.of for one in figures], np.array([one.times for one in figures])
    covariance = both.covariance(scatter)[np.ix_(at, at)] * np.outer(times, times)
    own = Component(Origin(LEVELS[scatter], level=scatter), "A", covariance, both.dof(scatter)[at], "t")
    keys = tuple(Key(one.name, plan.axis) for one in figures)
    parts = (own, *_type_b(plan, used, _values(both.values, figures)))
    return Estimate(keys, _values(both.values, figures), tuple(one.unit for one in figures), parts)


def _type_b(plan: Plan, used: Sequence[Response], values: Array) -> Iterator[Component]:
    """Yield what is common to all runs: each stated quantity changed by its u, and all fitted again."""
    (rate, own_rate), (mass, radius) = rate_of_orbit(plan), plan.turned
    stated, names = plan.standards, [one.name for one in figures_of(plan)]
    constant = Influence(float(GRAVITATIONAL_CONSTANT.u or 0.0) / GRAVITATIONAL_CONSTANT.value)
    changed: dict[str, tuple[str, Influence | None, Callable[[float], tuple[Plan, float, float]]]] = {
        MASS: ("turned mass", stated.get(MASS), lambda u: (replace(plan, mass=mass + u), rate, 1.0)),
        RADIUS: ("distance of the mass", stated.get(RADIUS), lambda u: (replace(plan, radius=radius + u), rate, 1.0)),
        CONSTANT: ("gravitational constant", stated.get(CONSTANT, constant), lambda u: (plan, rate, 1.0 + u)),
        ORBIT: ("orbital rate", own_rate, lambda u: (plan, rate * (1.0 + u), 1.0)),
    }
    if plan.satellite is not None:
        heavier = plan.satellite + (stated[SATELLITE].u if SATELLITE in stated else 0.0)
        changed[SATELLITE] = ("mass of the satellite", stated.get(SATELLITE),
                              lambda u: (replace(plan, satellite=heavier), rate, 1.0))  # fmt: skip
    for label, one, of in changed.values():
        if one is None or not one.u > 0.0:
            continue
        other, at_rate, gravity = of(one.u)
        known = orbit_of(other, at_rate)
        found = join(used, known._replace(attraction=known.attraction * gravity)).values
        change = _values(found, figures_of(other)) - values
        yield Component(one.origin(label), "B", np.outer(change, change), one.dof, one.distribution, one.stated,
                        change[None])  # fmt: skip
    # what is read falls with the cosine of a tilt, or the square of a height: rms of a square of a normal unknown
    relative = np.array([values[0] * one.times if one.of == S else 0.0 for one in figures_of(plan)])
    tilt = 0.5 * ROOT_3 * plan.alignment**2 * relative
    yield Component("direction of the input axis, out of the plane", "B", np.outer(tilt, tilt),
                    stated=(plan.alignment, "rad"))  # fmt: skip
    if HEIGHT in stated:
        one = stated[HEIGHT]
        change = 1.5 * ROOT_3 * (one.u / radius) ** 2 * relative
        label = "height of the proof mass over the plane of the turn"
        yield Component(one.origin(label), "B", np.outer(change, change), one.dof, stated=one.stated)
    if plan.high_g is not None and plan.high_g.u > 0.0:
        change = np.zeros(len(values))
        change[names.index(DIFFERENCE)] = plan.high_g.u * values[0] / plan.high_g.scale_factor**2
        yield Component("scale factor of the other test", "B", np.outer(change, change), stated=(plan.high_g.u, UNIT))


def model_terms(result: Result, tests: Sequence[Tested[Plan, Readings, Result]]) -> ModelTerms | None:
    """Return the scale factor error as a term of the model, for inputs as small as the mass applies.

    None where it was not estimated, or no scale factor is stated to relate it to.
    """
    key, nominal = Key(ERROR, result.plan.axis), result.plan.nominal
    if result.estimate is None or not nominal:
        return None
    applied = float(np.max(np.hypot(*result.joined.at_turn.T))) / abs(
        result.estimate.value(Key(SCALE, result.plan.axis))
    )
    origin = Provenance(", ".join(one.id for one in tests), tuple(name for one in tests for name in one.recordings))
    return ModelTerms(
        result.estimate.select([key]), (key,), (result.plan.axis,), {key: origin}, scale_factor=nominal,
        output_unit="count/s", input_range=np.array([(-applied, applied)]),
    )  # fmt: skip

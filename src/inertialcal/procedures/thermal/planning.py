"""A thermal test planned: runs and ramps, and how well the bias over temperature will be known.

What ``plan thermal`` and ``inertialcal.plan_thermal`` do. A run is laid out sample by sample: warm-up, down to the
coldest temperature, up to the hottest, back. The test cuts it into its cells and fits its law, with D and the lag as
always; the law is a combination of the cells, and the stated noise says what scatter that has. Runs are alike, so twice
as many leave half the variance. Thermometer and rate of the earth enter as in the test (``quantities.estimate``).

The order of the polynomial is given: what a higher order would add is no noise, and no forecast knows it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, cast

import numpy as np

from ...core.errors import DataError, UsageError
from ...core.estimate import Array
from ...core.influence import Influence
from ...core.key import Key
from ...core.remarks import Remark
from ...core.show.rounding import number
from ...core.show.tables import Table
from ...core.units import parse_quantity
from ...sensors.noise.simulate import simulate as noise_samples
from ...sensors.noise.terms import BiasInstability, RandomWalk, RateRandomWalk, Term
from .. import planned as shared
from ..planned import Design, Figure, Part, Slow, TestPlan
from .fit.cells import cells_of, series_of
from .fit.law import Law, unjudged_law_of
from .fit.quantities import Asked, at_degrees, change_at, earth_along, estimate
from .plan import Attitude, Plan, PlannedRamps
from .recordings import Readings, Sweep
from .reduction import bias_at, reduce

WORD = "thermal"
AXIS = "x"
BIAS, CHANGE = "bias", "bias_over_temperature"
UNITS = {"rad/s": ("deg/s", "0.001 deg/s"), "m/s^2": ("mg", "0.1 mg")}
PLACES = 9  # temperatures of the range at which the forecast is looked at
RAMPS = (1.0, 0.5, 0.25, 0.125)  # of the fastest
MORE, SLOWER = "more runs", "slower ramps, or more runs"
TINY = 1e-12  # of the unit: readings without noise
MOST_SAMPLES = 20_000  # of a run


@dataclass(frozen=True, eq=False)
class Known:
    """Settings, SI."""

    said: PlannedRamps
    unit: str
    slow: Slow
    turn_on: float
    turn_on_slope: float
    coefficient: float
    plan: Plan

    @property
    def terms(self) -> tuple[Term, ...]:
        """Noise at rest."""
        slow = self.slow
        made: list[Term] = [RandomWalk(slow.white)]
        made += [BiasInstability(slow.instability)] if slow.instability else []
        made += [RateRandomWalk(slow.walk)] if slow.walk else []
        return tuple(made)


@dataclass(frozen=True, eq=False)
class Programme:
    """One run of the chamber; all are alike."""

    knots: Array  # shape (k,): [s]
    levels: Array  # shape (k,): [degC]
    rate: float  # Of the ramps [degC/s]

    def samples(self, interval: float) -> tuple[Array, Array]:
        """Return times since power-up [s] and temperatures [degC], shapes (n,)."""
        time = np.arange(0.5 * interval, self.knots[-1], interval)
        return time, np.asarray(np.interp(time, self.knots, self.levels))


def plan_thermal(**settings: Any) -> TestPlan:
    """Plan a thermal test.

    Parameters
    ----------
    **settings
        Those of ``plan thermal``, quantities as text with a unit: ``wanted`` (a mapping), ``noise``, ``coldest``, ...

    Returns
    -------
    TestPlan
        Printable; ``.figures``, ``.time``, ``.rows``, ``.remarks``.

    Raises
    ------
    UsageError
        If a setting is wrong.
    """
    return planned(settings, options=False)


def planned(given: Mapping[str, Any], options: bool = True) -> TestPlan:
    """Return the plan that settings give, as text with units; messages speak of options, or of arguments of Python."""
    said, words = shared.settings_said(PlannedRamps, given, options)
    shared.check_order(said, words, "least_runs", "most_runs")
    if not said.hottest - said.coldest >= Plan().least_range:
        what = f"{words['coldest']} {said.coldest:g} degC, {words['hottest']} {said.hottest:g} degC"
        do = f"Give a range of {Plan().least_range:g} K or more"
        raise UsageError(what, why="so small a range carries no polynomial", do=do, code="wrong_value")
    if not said.coldest <= said.room <= said.hottest:
        what = f"{words['room']} {said.room:g} degC lies outside the range"
        raise UsageError(what, do="Widen the range, or start inside it", code="wrong_value")
    known = known_of(said, words)
    shown, example = UNITS[known.unit]
    there = dict.fromkeys((BIAS, CHANGE) if known.unit == "rad/s" else (CHANGE,), (known.unit, example))
    wanted = shared.targets(words["wanted"], said.wanted, there)
    try:
        return _planned(known, wanted, shown)
    except DataError as error:
        raise shared.refused(error) from error


def known_of(said: PlannedRamps, words: Mapping[str, str]) -> Known:
    unit = "rad/s"
    try:
        parse_quantity(said.noise).to("m/s^2/sqrt(Hz)")
        unit = "m/s^2"
    except DataError:
        pass
    per = {"noise": "/sqrt(Hz)", "walk": "/sqrt(s)", "turn_on_slope": "/degC", "coefficient": "/degC"}
    examples = {
        "rad/s": {"noise": "0.2 deg/sqrt(h)", "instability": "5 deg/h", "walk": "5 deg/h/sqrt(h)",
                  "turn_on": "0.005 deg/s", "turn_on_slope": "1e-5 deg/s/degC", "coefficient": "3e-3 deg/s/degC"},
        "m/s^2": {"noise": "100 ug/sqrt(Hz)", "instability": "10 ug", "walk": "1 ug/sqrt(s)", "turn_on": "1 mg",
                  "turn_on_slope": "1 ug/degC", "coefficient": "50 ug/degC"},
    }[unit]  # fmt: skip
    found = {
        name: 0.0 if (text := getattr(said, name)) is None
        else shared.quantity(words[name], text, unit + per.get(name, ""), examples[name])
        for name in examples
    }  # fmt: skip
    slow = Slow(found["noise"], found["instability"], found["walk"])
    thermometer = Influence(said.u_thermometer, "degC", standard="thermometer", quantity="temperature")
    standards = {"thermometer.temperature": thermometer} if said.u_thermometer else {}
    attitude = None if said.latitude is None else Attitude(0.0, said.u_tilt)
    plan = Plan(order=said.order, reference_temperature=said.reference_temperature, warm_up=said.warm_up,
                standards=standards, attitude=attitude, latitude=said.latitude)  # fmt: skip
    return Known(said, unit, slow, found["turn_on"], found["turn_on_slope"], found["coefficient"], plan)


def _planned(known: Known, wanted: Mapping[str, tuple[float, str]], shown: str) -> TestPlan:
    said = known.said
    designs = []
    for part in RAMPS:
        rate = said.ramp * part
        if part < 1.0 and rate < said.slowest * (1.0 - 1e-9):
            break
        programme = programme_of(said, rate)
        one_run = forecast(known, programme, shown)
        for runs in range(said.least_runs, said.most_runs + 1):
            own = tuple(_of_runs(one, runs, wanted) for one in one_run)
            choice = {"runs": str(runs), "ramp": f"{number(60.0 * rate, 3)} K/min"}
            time = runs * (said.power_up + float(programme.knots[-1]))
            designs.append(Design(time, choice, own, (programme, runs)))
    chosen, front, remarks = shared.choose(designs, said.available)
    programme, runs = cast("tuple[Programme, int]", chosen.detail)
    after, found = shared.checked(chosen, said.simulate, lambda rng: simulated(known, chosen, programme, runs, rng))
    remarks += [*found, *_remarks(known, runs)]
    if said.schedule is not None:
        notes = (f"thermal: {runs} runs; start and stop count from power-up; temperature at the end of each step",)
        shared.write_schedule(said.schedule, HEADS, _rows(programme, runs), notes)
    return TestPlan(WORD, after, shared.adopted(front, chosen, after), _steps(programme), said.schedule or "",
                    tuple(remarks))  # fmt: skip


def programme_of(said: PlannedRamps, rate: float) -> Programme:
    """Return one run of the chamber: warm-up, coldest, hottest, back; each end is held for the soak."""
    knots, levels = [0.0, said.warm_up], [said.room, said.room]
    for before, after in pairwise((said.room, said.coldest, said.hottest, said.room)):
        if before == after:
            continue
        knots += [knots[-1] + abs(after - before) / rate, knots[-1] + abs(after - before) / rate + said.soak]
        levels += [after, after]
    return Programme(np.array(knots), np.array(levels), rate)


def _interval(known: Known, programme: Programme) -> float:
    """Return the time from sample to sample, longer where a run has more than can be laid out."""
    return max(known.said.interval, float(programme.knots[-1]) / MOST_SAMPLES)


def _of_runs(one: Figure, runs: int, wanted: Mapping[str, tuple[float, str]]) -> Figure:
    parts = tuple(replace(part, u=part.u / math.sqrt(runs)) if part.remedy else part for part in one.parts)
    u, shown = wanted.get(one.key.quantity, (None, one.shown))
    return replace(one, parts=parts, wanted=u, shown=shown)


def law_of_run(known: Known, programme: Programme) -> tuple[Law, Array]:
    """Return the law of a run without noise, and its coefficients per reading of its cells, shape (p, c)."""
    interval = _interval(known, programme)
    time, T = programme.samples(interval)
    rng = np.random.default_rng(0)
    reading = known.coefficient * (T - known.said.reference_temperature) + rng.normal(0.0, TINY, len(T))
    sweep = Sweep("run_1", "run_1", "planned run", time, {AXIS: T}, {AXIS: reading})
    series = series_of(known.plan, Readings((sweep,), known.unit), AXIS)
    law = unjudged_law_of(cells_of(known.plan, series, known.said.warm_up), known.said.order)
    solve = law.fit.transform @ law.fit.basis.T * np.sqrt(law.cells.weight)
    return law, np.asarray(solve[: law.order + 1])


def forecast(known: Known, programme: Programme, shown: str) -> tuple[Figure, ...]:
    """Return the uncertainty of one run alone, by the law of the test, where in the range it is largest."""
    law, solve = law_of_run(known, programme)
    cells, reference = law.cells, known.said.reference_temperature
    half = 0.5 * cells.samples * _interval(known, programme)
    sources = known.slow.parts(cells.time - half, cells.time + half)
    lo, hi = law.domain
    places = np.linspace(lo, hi, PLACES)
    reference = min(max(reference, lo), hi)
    figures = []
    for quantity, rows in ((BIAS, law.basis(places)), (CHANGE, law.basis(places) - law.basis([reference]))):
        if quantity == BIAS and known.unit != "rad/s":
            continue
        squares = {label: np.einsum("ij,jk,ik->i", rows @ solve, one, rows @ solve) for label, one in sources.items()}
        level = 1.0 if quantity == BIAS else 0.0
        squares["turn-on bias"] = np.full(PLACES, level * known.turn_on**2)
        squares["turn-on temperature coefficient"] = (known.turn_on_slope * (places - reference)) ** 2
        standards = _type_b(known, law, rows, quantity)
        at = int(np.argmax(sum(squares.values()) + sum(standards.values(), np.zeros(PLACES))))
        parts = [
            Part(label, math.sqrt(max(float(one[at]), 0.0)), MORE if label.startswith("turn-on") else SLOWER)
            for label, one in squares.items()
        ]
        parts += [Part(label, math.sqrt(float(one[at]))) for label, one in standards.items()]
        key = Key(quantity, at=at_degrees(float(round(places[at], 3))))
        least = 1e-9 * max(one.u for one in parts)
        figures.append(Figure(key, known.unit, shown, tuple(one for one in parts if one.u > least)))
    return tuple(figures)


def _type_b(known: Known, law: Law, rows: Array, quantity: str) -> dict[str, Array]:
    """Return the variance at each place by thermometer and rate of the earth."""
    keys = tuple(Key(quantity, AXIS, at=at_degrees(float(k))) for k in range(len(rows)))
    one = Asked(keys, (known.unit,) * len(keys), rows)
    found = estimate(known.plan, {AXIS: law}, {AXIS: [one]}, known.unit)
    if found is None or found.keys != keys:
        return {}
    merged: dict[str, Array] = {}
    for component in found.components:
        if component.kind == "B":
            label = str(component.source) if component.origin.standard else "rate of the earth"
            merged[label] = merged.get(label, np.zeros(len(keys))) + np.diagonal(component.covariance)
    return {label: one for label, one in merged.items() if np.any(one > 0.0)}


def simulated(
    known: Known, design: Design, programme: Programme, runs: int, rng: np.random.Generator
) -> dict[Key, tuple[Array, Array]]:
    """Return errors and stated uncertainties of one simulated test, of one sensor."""
    said = known.said
    interval = _interval(known, programme)
    time, T = programme.samples(interval)
    away = T - said.reference_temperature
    earth = np.zeros(3)
    if known.unit == "rad/s":
        earth, unknown = earth_along(known.plan)
        for source in unknown.values():
            earth = earth + rng.standard_normal(len(source.patterns)) @ source.patterns
    shift = rng.normal(0.0, said.u_thermometer)
    sweeps = []
    for k in range(runs):
        y = known.coefficient * away + rng.normal(0.0, known.turn_on) + rng.normal(0.0, known.turn_on_slope) * away
        y = y + earth[0] + noise_samples(known.terms, len(time), interval, rng)
        name = f"run_{k + 1}"
        sweeps.append(Sweep(name, name, f"simulated {name}", time, {AXIS: T + shift}, {AXIS: y}))
    law = reduce(known.plan, Readings(tuple(sweeps), known.unit)).sensors[AXIS].law
    made = {}
    for figure in design.figures:
        at = figure.key.at
        assert at is not None  # noqa: S101 - as forecast
        where = np.array([min(max(at.value, law.domain[0]), law.domain[1])])
        plain = figure.key.quantity == BIAS
        found = (bias_at if plain else change_at)(known.plan, law, AXIS, known.unit, where)
        truth = known.coefficient * (where - said.reference_temperature)
        if found is not None:
            made[figure.key] = (found.values - truth, found.u)
    return made


HEADS = ("name", "recording", "power_up", "run", "start [s]", "stop [s]", "duration [s]", "temperature [degC]",
         "ramp [K/min]", "prompt")  # fmt: skip


def _rows(programme: Programme, runs: int) -> Iterator[tuple[str, ...]]:
    for run in range(1, runs + 1):
        for k, (start, stop, before, after) in enumerate(_legs(programme)):
            prompt = "Let the chamber come to the first temperature, then switch the unit on" if k == 0 else ""
            ramp = 60.0 * (after - before) / (stop - start)
            yield (f"run {run} step {k + 1}", f"run_{run}", str(run), str(run), f"{start:.1f}", f"{stop:.1f}",
                   f"{stop - start:.1f}", f"{after:g}", f"{ramp:.6g}", prompt)  # fmt: skip


def _legs(programme: Programme) -> Iterator[tuple[float, float, float, float]]:
    for (start, before), (stop, after) in pairwise(zip(programme.knots, programme.levels, strict=True)):
        if stop > start:
            yield float(start), float(stop), float(before), float(after)


def _steps(programme: Programme) -> Table:
    rows = []
    for start, stop, before, after in _legs(programme):
        what = "warming" if after > before else "cooling" if after < before else "held"
        rows.append((what, f"{before:g} degC", f"{after:g} degC", shared.hours(stop - start)))
    return Table(("step", "from", "to", "time"), rows, "each run: one power-up", (1, 2, 3))


def _remarks(known: Known, runs: int) -> Iterator[Remark]:
    said = known.said
    yield from shared.exact({"thermometer": said.u_thermometer})
    if said.u_thermometer and not known.coefficient:
        what = "the thermometer acts on a temperature coefficient that is not given"
        yield Remark("no_coefficient", "warning", what, do="Give the temperature coefficient to expect")
    if known.unit == "rad/s" and said.latitude is None:
        what = "the rate of the earth along the axis is unknown"
        yield Remark("attitude_unknown", "warning", what, do="Give the latitude")
    if known.unit == "m/s^2":
        what = "the bias itself is not told apart from gravity: its change over temperature is"
        yield Remark("gravity", "info", what, do="Take the bias from positions")
    if runs < 5:
        what = f"{runs} runs: the test knows its own scatter badly, its intervals are wide"
        yield Remark("few_runs", "warning", what, do="Plan five runs or more")


__all__ = ["Known", "Programme", "forecast", "plan_thermal", "planned", "programme_of"]

"""A rate table planned: runs, dwells, order of the rates; how well scale factor, bias, misalignment will be known.

What ``plan rate-table`` and ``inertialcal.plan_rate_table`` do. Dwells are laid out as the test reads them; its line
says which combination of the readings each figure is (``Solution.solve``), and the stated noise what scatter that has.
Standards and the rate of the earth enter as in the test (``quantities.estimate``). Runs are alike, so twice as many
leave half the variance.

The rates alternate in sense and go from large to small and back, run by run: a bias that wanders while they rise in
order looks like a scale factor. A dwell is whole turns of the table where a turn is no longer than the dwell, so that
the rate of the earth across its axis leaves no mean.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.influence import Influence
from ...core.key import AXES, Key
from ...core.remarks import Remark
from ...core.show.rounding import number
from ...core.show.tables import Table
from ...core.units import factor
from .. import planned as shared
from ..planned import Design, Figure, Part, Slow, TestPlan
from .fit.earth_input import earth_in_dwells, with_earth
from .fit.quantities import estimate, quantities_of
from .fit.regression import Line, line
from .plan import Attitude, Plan, PlannedRates
from .readings import Readings
from .reduction import reduce
from .simulation import draw, turned_axis

WORD = "rate-table"
TURN = 2.0 * math.pi
DWELLS = (5.0, 10.0, 20.0, 30.0, 60.0, 90.0, 120.0, 180.0, 300.0, 600.0, 1200.0, 1800.0, 3600.0)
SAMPLES = 100.0  # of a dwell: enough that their number does not matter
FIGURES = {
    "bias": ("rad/s", "deg/s", "0.001 deg/s"),
    "scale_factor_error": ("1", "ppm", "200 ppm"),
    "scale_factor_asymmetry": ("1", "ppm", "200 ppm"),
    "misalignment": ("rad", "deg", "0.02 deg"),
}
LONGER, MORE = "longer dwells, or more runs", "more runs"


@dataclass(frozen=True, eq=False)
class Programme:
    """Dwells about one axis in one run; all axes and runs are alike."""

    rates: Array  # shape (n,), in order [rad/s]
    start: Array  # shape (n,): since the first reading of the recording [s]
    stop: Array
    whole: bool  # Whether every dwell is whole turns


def plan_rate_table(**settings: Any) -> TestPlan:
    """Plan a rate-table test.

    Parameters
    ----------
    **settings
        Those of ``plan rate-table``, quantities as text with a unit: ``wanted`` (a mapping), ``noise``, ``fastest``.

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
    said, words = shared.settings_said(PlannedRates, given, options)
    shared.check_order(said, words, "least_runs", "most_runs")
    there = {name: (unit, example) for name, (unit, _, example) in FIGURES.items()}
    wanted = shared.targets(words["wanted"], said.wanted, there)
    try:
        return _planned(said, wanted)
    except DataError as error:
        raise shared.refused(error) from error


def _planned(said: PlannedRates, wanted: Mapping[str, tuple[float, str]]) -> TestPlan:
    plan = plan_of(said)
    designs = []
    for dwell in [one for one in DWELLS if one <= said.longest_dwell] or [said.longest_dwell]:
        programme = programme_of(said, dwell)
        figures = forecast(said, plan, programme, 2)
        for runs in range(said.least_runs, said.most_runs + 1):
            own = tuple(_of_runs(one, runs / 2.0, wanted) for one in figures)
            choice = {"runs": str(runs), "dwell": f"{number(dwell, 3)} s"}
            designs.append(Design(time_of(said, programme, runs), choice, own, (programme, runs)))
    chosen, front, remarks = shared.choose(designs, said.available)
    programme, runs = cast("tuple[Programme, int]", chosen.detail)
    after = replace(chosen, figures=tuple(
        replace(one, wanted=before.wanted, shown=before.shown)
        for one, before in zip(forecast(said, plan, programme, runs), chosen.figures, strict=True)
    ))  # fmt: skip
    after, found = shared.checked(after, said.simulate, lambda rng: simulated(said, plan, programme, runs, rng),
                                  "a curvature of the scale factor that these rates do not exclude")  # fmt: skip
    remarks += [*found, *_remarks(said, plan, programme, runs)]
    made = TestPlan(WORD, after, shared.adopted(front, chosen, after), _steps(programme), said.schedule or "",
                    tuple(remarks))  # fmt: skip
    if said.schedule is not None:
        notes = (f"rate table: {runs} runs about {', '.join(AXES)}; start and stop count in each recording by itself",)
        shared.write_schedule(said.schedule, HEADS, _rows(programme, runs), notes)
    return made


def plan_of(said: PlannedRates) -> Plan:
    """Return the plan of the test."""
    stated = {
        "rate_table.rate": Influence(said.u_rate, standard="rate_table", quantity="rate"),
        "converter.reference": Influence(said.u_converter, standard="converter", quantity="reference"),
        "rate_table.mounting": Influence(said.u_mounting, "rad", standard="rate_table", quantity="mounting"),
    }
    standards = {name: one for name, one in stated.items() if one.u > 0.0}
    attitude = None if said.latitude is None else Attitude(0.0, said.u_tilt)
    return Plan(standards=standards, attitude=attitude, latitude=said.latitude)


def programme_of(said: PlannedRates, dwell: float) -> Programme:
    """Return the dwells about an axis: large rates first and last, senses by turns."""
    sizes = said.fastest * np.arange(said.sizes, 0, -1) / said.sizes
    rates = np.array(
        [sign * one for k, one in enumerate(sizes) for sign in ((1.0, -1.0) if k % 2 == 0 else (-1.0, 1.0))]
    )
    turn = TURN / np.abs(rates)
    fits = turn <= dwell
    length = np.where(fits, turn * np.ceil(np.round(dwell / turn, 9)), dwell)
    change = np.abs(np.diff(rates, prepend=0.0)) / said.acceleration + said.settle
    stop = np.cumsum(change + length)
    return Programme(rates, stop - length, stop, bool(fits.all()))


def time_of(said: PlannedRates, programme: Programme, runs: int) -> float:
    """Return the length of a test of all axes [s]: mounted axis by axis, powered up for each run."""
    return len(AXES) * (said.mount + runs * (said.power_up + float(programme.stop[-1])))


def _of_runs(one: Figure, more: float, wanted: Mapping[str, tuple[float, str]]) -> Figure:
    parts = tuple(replace(part, u=part.u / math.sqrt(more)) if part.remedy else part for part in one.parts)
    u, shown = wanted.get(one.key.quantity, (None, one.shown))
    return replace(one, parts=parts, wanted=u, shown=shown)


def layout(plan: Plan, programme: Programme, runs: int) -> Readings:
    """Return the dwells of a test of all axes and runs as it reads them without noise, with the rate of the earth."""
    n = len(programme.rates)
    applied, axis = np.tile(programme.rates, 3 * runs), np.tile(np.repeat(AXES, n), runs)
    run = np.repeat([str(k + 1) for k in range(runs)], 3 * n)
    true = {name: np.where(axis == name, applied, 0.0) for name in AXES}
    scatter = {name: np.zeros(len(applied)) for name in AXES}
    where = tuple(f"planned dwell {k + 1}" for k in range(len(applied)))
    found = Readings(applied, axis, true, scatter, np.full(len(applied), SAMPLES), run=run, where=where,
                     sensors=AXES)  # fmt: skip
    length = np.tile(programme.stop - programme.start, 3 * runs)
    earth, sources = np.zeros((len(applied), 3)), dict[str, Array]()
    for name in AXES:  # as `recordings` does for a schedule
        own = axis == name
        known, patterns = earth_in_dwells(plan, name, np.full(own.sum(), np.nan), (applied * length)[own])
        earth[own] = known
        for source, pattern in patterns.items():
            whole = sources.setdefault(source, np.zeros((len(pattern), len(applied), 3)))
            whole[:, own] = pattern
    found = replace(found, earth=earth, earth_sources=sources)
    return replace(found, outputs={name: true[name] + earth[:, k] for k, name in enumerate(AXES)})


def noise_of(said: PlannedRates, programme: Programme, readings: Readings) -> dict[str, Array]:
    """Return the covariance of the readings of a sensor by source, shapes (n, n) [(rad/s)^2]."""
    n, whole = len(programme.rates), len(readings)
    recordings = np.eye(whole // n)
    slow = Slow(said.noise, said.instability, said.walk).parts(programme.start, programme.stop)
    found: dict[str, Array] = {
        label: np.asarray(np.kron(recordings, one), dtype=np.float64) for label, one in slow.items()
    }
    if said.dwell_scatter:
        found["scatter of dwells"] = np.asarray(said.dwell_scatter**2 * np.eye(whole))
    if said.turn_on:
        found["turn-on bias"] = np.asarray(said.turn_on**2 * np.kron(recordings, np.ones((n, n))), dtype=np.float64)
    return found


def forecast(said: PlannedRates, plan: Plan, programme: Programme, runs: int) -> tuple[Figure, ...]:
    """Return the uncertainty of the figures of a sensor, by the line of the test."""
    readings = layout(plan, programme, runs)
    sensor = AXES[0]
    drawn = noise_drawn(said, programme, len(readings), np.random.default_rng(shared.SEED))
    noisy = replace(readings, outputs={sensor: readings.outputs[sensor] + drawn})  # weighs offsets as a test does
    one = line(plan, noisy, sensor, asymmetry=True)
    keys, jacobian = quantities_of(one)
    chosen = {name: next(i for i, key in enumerate(keys) if key.quantity == name) for name in FIGURES}
    parts: dict[str, list[Part]] = {name: [] for name in FIGURES}
    rows = jacobian @ one.fit.solve
    for label, covariance in noise_of(said, programme, readings).items():
        remedy = MORE if label == "turn-on bias" else LONGER if label == "noise" else MORE
        _add(parts, chosen, np.einsum("ij,jk,ik->i", rows, covariance, rows), label, remedy)
    if said.turn_on_scale:
        _add(parts, chosen, _of_scale(said, readings, rows, sensor), "turn-on scale factor", MORE)
    for label, square in _type_b(plan, one, keys).items():
        _add(parts, chosen, square, label, "")
    return tuple(Figure(Key(name), FIGURES[name][0], FIGURES[name][1], tuple(parts[name])) for name in FIGURES)


def _add(parts: dict[str, list[Part]], chosen: Mapping[str, int], square: Array, label: str, remedy: str) -> None:
    least = 1e-9 * math.sqrt(max(float(square.max()), 0.0))
    for name, at in chosen.items():
        u = math.sqrt(max(float(square[at]), 0.0))
        if u > least:
            parts[name].append(Part(label, u, remedy))


def _of_scale(said: PlannedRates, readings: Readings, rows: Array, sensor: str) -> Array:
    """Return the variance by scale factors that differ between power-ups; each axis is a power-up of its own."""
    x = np.where(readings.axis == sensor, readings.applied, 0.0)
    assert readings.run is not None  # noqa: S101 - as laid out
    each = [rows[:, readings.run == run] @ x[readings.run == run] for run in np.unique(readings.run)]
    return np.asarray(said.turn_on_scale**2 * np.sum(np.square(each), axis=0))


def _type_b(plan: Plan, one: Line, keys: Sequence[Key]) -> dict[str, Array]:
    """Return the variance of each figure by each standard, and by the rate of the earth."""
    found = estimate(plan, {one.sensor: one})
    assert found is not None  # noqa: S101 - its dwells scatter
    at = [found.keys.index(key) for key in keys]
    merged: dict[str, Array] = {}
    for component in found.components:
        if component.kind == "B":
            label = str(component.source) if component.origin.standard else "rate of the earth"
            merged[label] = merged.get(label, np.zeros(len(keys))) + np.diagonal(component.covariance)[at]
    return merged


def noise_drawn(said: PlannedRates, programme: Programme, count: int, rng: np.random.Generator) -> Array:
    """Return what the dwells of a sensor read without any input, recording after recording, shape (count,)."""
    n = len(programme.rates)
    slow = sum(Slow(said.noise, said.instability, said.walk).parts(programme.start, programme.stop).values())
    values, axes = np.linalg.eigh(np.asarray(slow))
    root = axes * np.sqrt(np.maximum(values, 0.0))
    noise = (root @ rng.normal(size=(n, count // n))).T.ravel() + rng.normal(0.0, said.dwell_scatter, count)
    return np.asarray(noise + np.repeat(rng.normal(0.0, said.turn_on, count // n), n))


def simulated(
    said: PlannedRates, plan: Plan, programme: Programme, runs: int, rng: np.random.Generator
) -> dict[Key, tuple[Array, Array]]:
    """Return errors and stated uncertainties of one simulated test, a value a sensor."""
    readings = layout(plan, programme, runs)
    n, count = len(programme.rates), len(readings)
    turned = {name: turned_axis(plan, name, rng) for name in AXES}
    x = (1.0 + draw(plan, "rate_table.rate", rng)) * readings.applied[:, None] * np.array(
        [turned[str(name)] for name in readings.axis]
    )  # fmt: skip
    x = x + (0.0 if readings.earth is None else readings.earth)
    for patterns in readings.earth_sources.values():
        x = x + np.tensordot(rng.normal(size=len(patterns)), patterns, axes=1)
    gain = 1.0 + draw(plan, "converter.reference", rng)
    outputs = {}
    for k, name in enumerate(AXES):
        scale = 1.0 + np.repeat(rng.normal(0.0, said.turn_on_scale, count // n), n)
        outputs[name] = gain * (scale * x[:, k] + noise_drawn(said, programme, count, rng))
    scatter = {name: np.full(count, said.noise) for name in AXES}
    found = reduce(plan, replace(readings, outputs=outputs, scatters=scatter)).estimate
    assert found is not None  # noqa: S101 - its dwells scatter
    made = {}
    for name in FIGURES:
        at = [i for i, key in enumerate(found.keys) if key.quantity == name]
        made[Key(name)] = (found.values[at], found.u[at])
    return made


HEADS = (
    "name",
    "recording",
    "power_up",
    "run",
    "axis",
    "start [s]",
    "stop [s]",
    "duration [s]",
    "rate [deg/s]",
    "prompt",
)


def _rows(programme: Programme, runs: int) -> Iterator[tuple[str, ...]]:
    """Yield the programme a row a dwell: axis by axis, since mounting takes a person."""
    unit = factor("deg/s", "rad/s")
    for at, axis in enumerate(AXES):
        for run in range(1, runs + 1):
            power_up = str(runs * at + run)
            for k, (rate, start, stop) in enumerate(zip(programme.rates, programme.start, programme.stop, strict=True)):
                mount = f"Mount the unit with {axis} along the axis of the table; switch it on and let it warm up"
                again = "Switch the unit off and on and let it warm up"
                prompt = "" if k else mount if run == 1 else again
                yield (f"{axis} run {run} dwell {k + 1}", f"{axis}_run{run}", power_up, str(run), axis, f"{start:.3f}",
                       f"{stop:.3f}", f"{stop - start:.3f}", f"{rate / unit:.9g}", prompt)  # fmt: skip


def _steps(programme: Programme) -> Table:
    unit = factor("deg/s", "rad/s")
    rows = [
        (str(k + 1), f"{number(rate / unit, 5)} deg/s", f"{number(stop - start, 5)} s",
         number(abs(rate) * (stop - start) / TURN, 5))
        for k, (rate, start, stop) in enumerate(zip(programme.rates, programme.start, programme.stop, strict=True))
    ]  # fmt: skip
    return Table(("dwell", "rate", "length", "turns"), rows, "each recording: one axis, one power-up", (1, 2, 3))


def _remarks(said: PlannedRates, plan: Plan, programme: Programme, runs: int) -> Iterator[Remark]:
    yield from shared.exact({"rate of the table": said.u_rate, "mounting": said.u_mounting})
    if not programme.whole:
        slow = [one for one in np.abs(programme.rates) if TURN / one > said.longest_dwell or TURN / one > 0.0]
        least = min(slow)
        what = (
            f"a turn at {number(least / factor('deg/s', 'rad/s'), 4)} deg/s takes {number(TURN / least, 4)} s, longer"
        )
        what += " than a dwell: the rate of the earth across the axis of the table stays in its mean"
        yield Remark("part_turns", "info", what, do="Leave slow rates out, or make dwells longer")
    if plan.attitude is None:
        what = "the rate of the earth along the axis of the table is unknown"
        yield Remark("attitude_unknown", "warning", what, do="Give the latitude")
    if said.sizes < 3:
        what = f"{said.sizes} sizes of rate tell no curvature: what there is bends the scale factor unseen"
        yield Remark("few_rates", "warning", what, do="Plan three sizes or more")
    if runs < 5:
        what = f"{runs} runs: the test knows its own scatter badly, its intervals are wide"
        yield Remark("few_runs", "warning", what, do="Plan five runs or more")


__all__ = ["Programme", "forecast", "plan_rate_table", "planned", "with_earth"]

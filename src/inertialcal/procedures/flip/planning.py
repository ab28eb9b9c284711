"""Flips planned: dwells, turns, flips, where in the orbit, and how well bias and ambient acceleration will be known.

What ``plan flip`` and ``inertialcal.plan_flip`` do. A flip is laid out in its quiet record; the test separates it
(``separation.equations``), which says which combination of the dwells each figure is. As in the test, bias and ambient
acceleration are means over the quiet record of what wanders slowly; white noise is none of either. So the error is
the white noise of the dwells in full, slow noise as far as the dwells differ from the record, and what the ambient
acceleration changes by between the positions: a swing with the orbit, at any phase of it, or at the best.

Flips have records, and power-ups, of their own, so twice as many leave half the variance.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.influence import Influence
from ...core.key import AXES, Key
from ...core.recording import SECOND
from ...core.remarks import Remark
from ...core.show.rounding import number
from ...core.show.tables import Table
from ...sensors.noise.simulate import simulate as noise_samples
from ...sensors.noise.terms import BiasInstability, RateRandomWalk
from ...statistics.slow_noise import FLICKER, WALK, window_covariance
from .. import planned as shared
from ..planned import Design, Figure, Part, TestPlan
from .dwells.quiet import Window, quiet_of, stretches
from .plan import Plan, PlannedFlips
from .readings import Quiet, Readings
from .reduction import reduce
from .separation.equations import AMBIENT, BIAS, rotation, separate, slope, tilted
from .separation.uncertainty import NAMES, patterns
from .simulation import STEP, draw

WORD = "flip"
UNIT, SHOWN = "m/s^2", "ug"
POSITIONS = (2, 3, 4)
DWELLS = (60.0, 90.0, 120.0, 180.0, 300.0, 450.0, 600.0, 900.0, 1200.0, 1800.0, 3600.0, 7200.0)
LONGER, MORE = "longer dwells, or more flips", "more flips"
EARLIER = "shorter dwells, three positions, or the best phase of the orbit"


@dataclass(frozen=True, eq=False)
class Programme:
    """One flip in its record; all are alike."""

    angle: Array  # shape (n,) [rad]
    start: Array  # shape (n,): of each dwell since the start of the record [s]
    stop: Array
    length: float  # Of the record [s]

    @property
    def pieces(self) -> tuple[Array, Array]:
        """Start and stop of the quiet pieces: before, the dwells, after."""
        start = np.concatenate([[0.0], self.start, [self.stop[-1]]])
        stop = np.concatenate([[self.start[0]], self.stop, [self.length]])
        kept = stop > start
        return start[kept], stop[kept]


def plan_flip(**settings: Any) -> TestPlan:
    """Plan flips of a head in orbit.

    Parameters
    ----------
    **settings
        Those of ``plan flip``, quantities as text with a unit: ``wanted`` (a mapping), ``noise``, ``instability``, ...

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
    said, words = shared.settings_said(PlannedFlips, given, options)
    shared.check_order(said, words, "least_flips", "most_flips")
    wanted = shared.targets(words["wanted"], said.wanted, dict.fromkeys((BIAS, AMBIENT), (UNIT, "0.5 ug")))
    try:
        return _planned(said, wanted)
    except DataError as error:
        raise shared.refused(error) from error


def _planned(said: PlannedFlips, wanted: Mapping[str, tuple[float, str]]) -> TestPlan:
    plan, designs = plan_of(said), []
    for dwell in [one for one in DWELLS if one <= said.longest_dwell] or [said.longest_dwell]:
        for count in POSITIONS if said.positions is None else (said.positions,):
            programme = programme_of(said, dwell, count)
            one_flip = forecast(said, plan, programme)
            for flips in range(said.least_flips, said.most_flips + 1):
                own = tuple(_of_flips(one, flips, wanted) for one in one_flip)
                choice = {"flips": str(flips), "positions": str(count), "dwell": f"{number(dwell, 4)} s"}
                time = flips * programme.length + (flips - 1) * said.power_up
                designs.append(Design(time, choice, own, (programme, flips)))
    chosen, front, remarks = shared.choose(designs, said.available)
    programme, flips = cast("tuple[Programme, int]", chosen.detail)
    after, found = shared.checked(chosen, said.simulate, lambda rng: simulated(said, plan, programme, flips, rng))
    remarks += [*found, *_remarks(said, programme, flips)]
    if said.schedule is not None:
        notes = (f"flip: {flips} flips; start and stop count from the start of each record",)
        shared.write_schedule(said.schedule, HEADS, _rows(programme, flips), notes)
    return TestPlan(WORD, after, shared.adopted(front, chosen, after), _steps(said, programme), said.schedule or "",
                    tuple(remarks))  # fmt: skip


def plan_of(said: PlannedFlips) -> Plan:
    """Return the plan of the test."""
    stated = {"turn.angle": Influence(said.u_angle, "rad"), "turn.axis": Influence(said.u_axis, "rad"),
              "converter.zero": Influence(said.u_zero, UNIT)}  # fmt: skip
    return Plan(standards={name: one for name, one in stated.items() if one.u > 0.0})


def programme_of(said: PlannedFlips, dwell: float, positions: int) -> Programme:
    """Return a flip of dwells at 0 and 180 deg by turns, with a quiet record before and after."""
    start: Array = said.quiet + np.arange(positions, dtype=np.float64) * (dwell + said.turn)
    angle = np.where(np.arange(positions) % 2 == 0, 0.0, math.pi)
    return Programme(angle, start, start + dwell, float(start[-1] + dwell + said.quiet))


def _of_flips(one: Figure, flips: int, wanted: Mapping[str, tuple[float, str]]) -> Figure:
    parts = tuple(replace(part, u=part.u / math.sqrt(flips)) if part.remedy else part for part in one.parts)
    u, shown = wanted.get(one.key.quantity, (None, one.shown))
    return replace(one, parts=parts, wanted=u, shown=shown)


def forecast(said: PlannedFlips, plan: Plan, programme: Programme) -> tuple[Figure, ...]:
    """Return the uncertainty of the figures of one flip, by the equations of the test."""
    axis = plan.turned[0]
    turned = rotation(plan.axis, programme.angle)
    ambient = np.zeros(3)
    for name in plan.turned:
        ambient[AXES.index(name)] = said.ambient / math.sqrt(2.0)
    levels = turned @ ambient
    outputs = {name: levels[:, k] for k, name in enumerate(AXES)}
    readings = Readings(programme.angle, np.full(len(programme.angle), "1"), outputs, time=_middle(programme))
    one = separate(plan, readings, "1")
    figures = []
    start, stop = programme.pieces
    dwell = np.isin(start, programme.start)
    record = (stop - start) / np.sum(stop - start)
    sign = np.cos(programme.angle)
    stated = patterns(plan, readings, one)
    for quantity in (BIAS, AMBIENT):
        at = one.keys.index(Key(quantity, axis))
        weights = one.weights[axis][at]
        parts = [Part("noise", said.noise * math.sqrt(float(np.sum(weights**2 / (programme.stop - programme.start)))),
                      LONGER)]  # fmt: skip
        line = np.zeros(len(start))
        line[dwell] = weights
        line = line - line.sum() * record
        slow = (("bias instability", said.instability**2 / math.pi, FLICKER),
                ("random walk of the bias", said.walk**2, WALK))  # fmt: skip
        for label, size, kind in slow:
            if size:
                square = size * float(line @ window_covariance(start, stop, kind) @ line)
                parts.append(Part(label, math.sqrt(max(square, 0.0)), MORE))
        if said.turn_on and quantity == BIAS:
            parts.append(Part("turn-on bias", said.turn_on, MORE))
        if said.swing:
            waves = _waves(said, programme.start, programme.stop) @ (weights * sign)
            if quantity == AMBIENT:
                waves = waves - _waves(said, start, stop) @ record
            # Anywhere: the mean square over all phases. At the best phase the same swing is not seen at all by a flip
            # of this shape, but for what the phase is missed by: a twentieth of an orbit.
            size = float(np.linalg.norm(waves)) * said.swing / math.sqrt(2.0)
            missed = size * math.sqrt(2.0) * math.sin(math.pi / 10.0)
            parts.append(Part("swing with the orbit", size if said.phase == "any" else missed, EARLIER))
        for name, changes in stated.items():
            u = float(np.linalg.norm(changes[:, at]))
            parts.append(Part(NAMES[name], u))
        least = 1e-9 * max(part.u for part in parts)
        figures.append(Figure(Key(quantity), UNIT, SHOWN, tuple(part for part in parts if part.u > least)))
    return tuple(figures)


def _middle(programme: Programme) -> Array:
    return np.asarray(0.5 * (programme.start + programme.stop))


def _waves(said: PlannedFlips, start: Array, stop: Array) -> Array:
    """Return the means of cosine and sine of the orbit over windows, shape (2, n)."""
    rate = 2.0 * math.pi / said.orbit
    return np.array([np.sin(rate * stop) - np.sin(rate * start), np.cos(rate * start) - np.cos(rate * stop)]) / (
        rate * (stop - start)
    )


def best_phase(said: PlannedFlips, plan: Plan, programme: Programme) -> float:
    """Return when after the start of the record the swing should be largest, for the least error of the bias."""
    readings = Readings(programme.angle, np.full(len(programme.angle), "1"),
                        {name: np.zeros(len(programme.angle)) for name in AXES}, time=_middle(programme))  # fmt: skip
    one = separate(plan, readings, "1")
    weights = one.weights[plan.turned[0]][one.keys.index(Key(BIAS, plan.turned[0]))]
    c, s = _waves(said, programme.start, programme.stop) @ (weights * np.cos(programme.angle))
    # c cos p + s sin p = 0, where the swing is cos(rate t - p)
    return float((math.atan2(-c, s) % math.pi) * said.orbit / (2.0 * math.pi))


def simulated(
    said: PlannedFlips, plan: Plan, programme: Programme, flips: int, rng: np.random.Generator
) -> dict[Key, tuple[Array, Array]]:
    """Return errors and stated uncertainties of one simulated test, of both axes across the turn."""
    n = len(programme.angle)
    angles = programme.angle
    change = slope(plan.axis, angles) * (draw(plan, "turn.angle", rng) * (angles != 0.0))[:, None, None]
    for axis in plan.turned:
        change = change + tilted(plan.axis, angles, draw(plan, "turn.axis", rng) * np.eye(3)[AXES.index(axis)])
    turned = rotation(plan.axis, angles) + change
    zero = np.array([draw(plan, "converter.zero", rng) for _ in AXES])
    way = rng.uniform(0.0, 2.0 * math.pi)
    ambient = np.zeros(3)
    for k, name in enumerate(plan.turned):
        ambient[AXES.index(name)] = said.ambient * (math.cos(way), math.sin(way))[k]
    ambient[AXES.index(plan.axis)] = rng.normal(0.0, said.ambient / math.sqrt(2.0))
    outputs = {name: np.zeros(n * flips) for name in AXES}
    truth = {AMBIENT: np.zeros((flips, 3)), BIAS: np.zeros((flips, 3))}
    records = []
    best = best_phase(said, plan, programme)
    for flip in range(flips):
        own = np.arange(n) + flip * n
        record, slow, swing = _record(said, programme, own, n * flips, best, rng)
        level = turned @ ambient + zero + rng.normal(0.0, said.turn_on, 3)
        truth[AMBIENT][flip] = ambient + np.where(np.arange(3) == AXES.index(plan.axis), 0.0, swing)
        truth[BIAS][flip] = slow  # of all power-ups: 0
        means = {}
        for k, name in enumerate(AXES):
            at = np.searchsorted(programme.start, record.times, side="right") - 1
            means[name] = record.means[name] + level[np.clip(at, 0, n - 1), k]
            outputs[name][own] = record.weights[own] @ means[name]
        records.append(replace(record, means=means))
    readings = Readings(np.tile(angles, flips), np.repeat([str(k + 1) for k in range(flips)], n), outputs,
                        time=np.concatenate([_middle(programme) + k * programme.length for k in range(flips)]),
                        quiet=tuple(records))  # fmt: skip
    found = reduce(plan, readings).estimate
    if found is None:
        raise DataError("no uncertainty", code="no_noise_model")
    made = {}
    for quantity in (BIAS, AMBIENT):
        places = [found.keys.index(Key(quantity, axis)) for axis in plan.turned]
        true = np.array([truth[quantity][:, AXES.index(axis)].mean() for axis in plan.turned])
        made[Key(quantity)] = (found.values[places] - true, found.u[places])
    return made


def _record(
    said: PlannedFlips, programme: Programme, own: Any, dwells: int, best: float, rng: np.random.Generator
) -> tuple[Quiet, Array, float]:
    """Return noise and swing of a record as block means, and the means over it of slow noise (3,) and of the swing."""
    count = round(programme.length / STEP)
    time = (np.arange(count) + 0.5) * STEP
    rate = 2.0 * math.pi / said.orbit
    where = rng.uniform(0.0, said.orbit) if said.phase == "any" else best + rng.choice([-0.05, 0.05]) * said.orbit
    swing = said.swing * np.cos(rate * (time - where))
    terms = (*((BiasInstability(said.instability),) if said.instability else ()),
             *((RateRandomWalk(said.walk),) if said.walk else ()))  # fmt: skip
    channels = {"swing": swing}
    for name in AXES:
        channels[name] = rng.normal(0.0, said.noise / math.sqrt(STEP), count)
        channels[f"slow {name}"] = noise_samples(terms, count, STEP, rng) if terms else np.zeros(count)
    windows = [Window(round(a * SECOND), round(b * SECOND), float(c))
               for a, b, c in zip(programme.start, programme.stop, programme.angle, strict=True)]  # fmt: skip
    parts = stretches(windows, 0, round(programme.length * SECOND))
    time_ns = np.asarray(time * SECOND, dtype=np.int64)
    quiet, _ = quiet_of(time_ns, channels, parts, own, dwells, Plan().block)
    means = quiet.means
    slow = np.array([means[f"slow {name}"].mean() for name in AXES])
    turns = np.cos(quiet.angle)
    both = {
        name: means[name] + means[f"slow {name}"] + (means["swing"] * turns if name != "x" else 0.0) for name in AXES
    }
    return replace(quiet, means=both, name=f"flip {int(own[0]) // len(own) + 1}"), slow, float(means["swing"].mean())


HEADS = (
    "name",
    "recording",
    "power_up",
    "flip",
    "dwell",
    "start [s]",
    "stop [s]",
    "duration [s]",
    "angle [deg]",
    "prompt",
)


def _rows(programme: Programme, flips: int) -> Iterator[tuple[str, ...]]:
    """Yield each record: quiet, the dwells, quiet."""
    ends = zip(*programme.pieces, strict=True)
    pieces = list(ends)
    for flip in range(1, flips + 1):
        for k, (start, stop) in enumerate(pieces):
            at = int(np.clip(np.searchsorted(programme.start, start, side="right") - 1, 0, len(programme.angle) - 1))
            angle = math.degrees(programme.angle[at])
            inside = start in programme.start
            name = f"flip {flip} dwell {at + 1}" if inside else f"flip {flip} quiet {'before' if k == 0 else 'after'}"
            turn = at > 0 if inside else k == 0 and flip > 1
            yield (name, f"flip_{flip}", str(flip), str(flip), str(at + 1) if inside else "", f"{start:.1f}",
                   f"{stop:.1f}", f"{stop - start:.1f}", f"{angle:.6g}",
                   f"Turn the head to {angle:.6g} deg" if turn else "")  # fmt: skip


def _steps(said: PlannedFlips, programme: Programme) -> Table:
    rows = []
    for start, stop in zip(*programme.pieces, strict=True):
        at = np.flatnonzero(programme.start == start)
        what = f"dwell at {math.degrees(programme.angle[at[0]]):.4g} deg" if len(at) else "quiet"
        rows.append((what, f"{number(start, 5)} s", f"{number(stop - start, 5)} s"))
    caption = "each flip"
    if said.swing:
        best = best_phase(said, plan_of(said), programme)
        caption += (
            f"; best where the swing of the orbit is largest {number(best, 4)} s after its record begins, or half"
        )
        caption += " an orbit from there"
    return Table(("step", "begins", "length"), rows, caption, (1, 2))


def _remarks(said: PlannedFlips, programme: Programme, flips: int) -> Iterator[Remark]:
    yield from shared.exact({"angle of the turn": said.u_angle, "axis of the turn": said.u_axis,
                             "zero of the electronics": said.u_zero})  # fmt: skip
    if said.turn_on and flips == 1:
        what = "one flip: the bias is that of its power-up, another one differs by the turn-on scatter"
        yield Remark("one_power_up", "warning", what, do="Plan five flips or more")
    elif 1 < flips < 5:
        what = f"{flips} flips: the scatter between them is hardly known, intervals are wide"
        yield Remark("few_flips", "warning", what, do="Plan five flips or more, or one")
    shortest = float(np.min(programme.stop - programme.start))
    if said.quiet < shortest:
        what = f"a quiet record of {number(said.quiet, 4)} s beside dwells of {number(shortest, 4)} s hardly shows how"
        what += " the bias wanders: the test may state more than the forecast"
        yield Remark("short_record", "info", what, do="Keep the head still for longer before and after")


__all__ = ["Programme", "best_phase", "forecast", "plan_flip", "planned", "programme_of"]

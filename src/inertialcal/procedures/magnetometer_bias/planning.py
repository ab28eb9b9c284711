"""A record of gyro and magnetometer in orbit planned: orbits and sample interval, and how well the bias will be known.

What ``plan magnetometer-bias`` and ``inertialcal.plan_magnetometer_bias`` do. The body is turned along a circular orbit
in the field of the earth, and the record is cut into the arcs of the test: its own equations say what each arc knows of
the biases, so that a longer record is a longer sum. Errors of the field that differ from arc to arc, a bias that
wanders, and standards enter by the same equations.

The forecast is that of one orbit and one motion. Another node changes it by some parts in ten.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from typing import Any, cast

import numpy as np

from ...core.errors import DataError, UsageError
from ...core.estimate import Array
from ...core.influence import Influence
from ...core.key import AXES, Key
from ...core.recording import SECOND
from ...core.remarks import Remark
from ...core.show.rounding import number
from ...physics.geomagnetic import field_along
from ...physics.orbit import circular_track, orbital_rate
from ...sensors.noise.simulate import simulate as noise_samples
from ...sensors.noise.terms import BiasInstability, RandomWalk, RateRandomWalk, Term
from .. import planned as shared
from ..planned import Design, Figure, Part, Slow, TestPlan
from .arcs import Equations, Noise, equations, rotations
from .plan import Plan, PlannedOrbits
from .readings import FASTEST, Readings, Track
from .reduction import ACROSSES, BIAS, FEWEST, FIELD_BIAS, SCALES, Result, cut, reduce

WORD = "magnetometer-bias"
WANTED = {BIAS: ("rad/s", "0.001 deg/s"), FIELD_BIAS: ("T", "20 nT")}
SHOWN = {BIAS: "deg/s", FIELD_BIAS: "nT"}
INTERVALS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 30.0)  # from sample to sample [s]
LENGTHS = (0.5, 0.75, 1.0, 1.5, *range(2, 101))  # orbits
MOST_SAMPLES = 200_000
ENOUGH = 1.05  # times the least uncertainty, that rarer samples may leave where what is wanted is not reached
SLOW_ENOUGH = 0.25 * FASTEST  # turn from sample to sample [rad]
STEP = 1e-3  # of a noise, by which its change of the information is taken
OPEN = 1e12  # condition of the information, from which a bias is left open
TILT, SWAY, SLOWER = 1.2, 0.4, 0.3  # of a tumbling body: nutation angle and its sway [rad], precession over spin
LIBRATION = ((0.010, 700.0), (0.010, 1100.0), (0.010, 900.0))  # of one that points down: angle [rad], period [s]
LONGER = "a longer record, or a body that turns more"


@dataclass(frozen=True, eq=False)
class Known:
    """Settings, SI."""

    said: PlannedOrbits
    slow: Slow
    start: int  # [ns]
    period: float  # of the orbit [s]
    plan: Plan

    @property
    def noise(self) -> Noise:
        """That arcs are weighted by."""
        return Noise(math.hypot(self.said.field_noise, self.said.field_error), self.slow.white)


@dataclass(frozen=True, eq=False)
class Chosen:
    """What a design is made of."""

    track: Track
    axes: Mapping[str, int]  # of each figure, that is known worst


def plan_magnetometer_bias(**settings: Any) -> TestPlan:
    """Plan a record of gyro and magnetometer in orbit.

    Parameters
    ----------
    **settings
        Those of ``plan magnetometer-bias``, quantities as text with a unit: ``noise``, ``wanted`` (a mapping), ...

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
    said, words = shared.settings_said(PlannedOrbits, given, options)
    wanted = shared.targets(words["wanted"], said.wanted, WANTED)
    try:
        return _planned(_known(said, words), wanted)
    except DataError as error:
        raise shared.refused(error) from error


def _known(said: PlannedOrbits, words: Mapping[str, str]) -> Known:
    white = shared.quantity(words["noise"], said.noise, "rad/s/sqrt(Hz)", "0.2 deg/sqrt(h)")
    instability, walk = (
        0.0 if text is None else shared.quantity(words[name], text, unit, example)
        for name, text, unit, example in (("instability", said.instability, "rad/s", "5 deg/h"),
                                          ("walk", said.walk, "rad/s/sqrt(s)", "5 deg/h/sqrt(h)"))
    )  # fmt: skip
    try:
        when = datetime.fromisoformat(said.date)
    except ValueError:
        what = f"{words['date']} {said.date!r} is no date"
        raise UsageError(what, do='Write it like "2026-03-01"', code="wrong_value") from None
    start = int((when if when.tzinfo else when.replace(tzinfo=UTC)).timestamp()) * SECOND
    stated = {
        SCALES: Influence(said.u_scale, "1"),
        ACROSSES: Influence(said.u_misalignment, "rad"),
        "magnetometer.mounting": Influence(said.u_mounting, "rad"),
        "earth_field.uniform": Influence(said.u_field, "T"),
    }
    standards = {name: one for name, one in stated.items() if one.u > 0.0}
    period = 2.0 * math.pi / orbital_rate(said.altitude).value("orbital_rate")
    plan = Plan(arc=said.arc, magnetometer_model=said.magnetometer_model, standards=standards)
    return Known(said, Slow(white, instability, walk), start, period, plan)


def _planned(known: Known, wanted: Mapping[str, tuple[float, str]]) -> TestPlan:
    said = known.said
    most = min([said.most_orbits * known.period, *([] if said.available is None else [said.available])])
    lengths = [one * known.period for one in LENGTHS if one * known.period <= most * (1.0 + 1e-9)]
    lengths = [one for one in lengths if round(one / said.arc) >= FEWEST]
    if not lengths:
        what = f"{shared.hours(most)} is no {FEWEST} arcs of {number(said.arc, 4)} s, or less than half an orbit"
        raise UsageError(what, do="Give more time, or shorter arcs", code="not_in_time")
    fastest = float(np.max(np.linalg.norm(_motion(known, np.arange(0.0, known.period, 5.0), 5.0)[1], axis=1)))
    intervals = [one for one in ([said.interval] if said.interval else INTERVALS)
                 if one * fastest <= (FASTEST if said.interval else SLOW_ENOUGH)
                 and (one <= said.arc / 20.0 or said.interval) and lengths[-1] / one <= MOST_SAMPLES]  # fmt: skip
    if not intervals:
        what = f"a body that turns at {number(math.degrees(fastest), 3)} deg/s needs more samples than can be laid out"
        raise UsageError(what, why="from sample to sample it may turn by some degrees", do="Give a slower motion, or a"
                         " shorter interval or record", code="wrong_value")  # fmt: skip
    found: list[tuple[float, list[Design]]] = [(length, []) for length in lengths]
    for interval in sorted(intervals, reverse=True):
        track = track_of(known, lengths[-1], interval)
        arcs, less = _known_by_arcs(known, track)
        for length, designs in found:
            if designs and any(one.wanted for one in designs[-1].figures) and _ratio(designs[-1]) <= shared.REACHED:
                continue  # rarer samples are enough
            design = _design(known, wanted, track, arcs, less, length)
            if design is not None:
                designs.append(design)
    made = [next(one for one in designs if _ratio(one) <= max(float(bool(wanted)), ENOUGH * min(map(_ratio, designs))))
            for _, designs in found if designs]  # fmt: skip
    if not made:
        why = "neither the field in the body nor the attitude turns enough"
        do = "Record longer, or while turning about more axes"
        raise DataError("such a record leaves a bias open", why=why, do=do, code="not_observable")
    chosen, front, remarks = shared.choose(made, said.available)
    after, more = shared.checked(chosen, said.simulate, lambda rng: simulated(known, chosen, rng))
    remarks += [*more, *_remarks(known)]
    rows = list(_rows(known, chosen))
    if said.schedule is not None:
        notes = ("gyro, magnetometer and position (or two-line elements); magnetorquers off; start and stop in s",)
        shared.write_schedule(said.schedule, HEADS, rows, notes)
    return TestPlan(WORD, after, shared.adopted(front, chosen, after), None, said.schedule or "", tuple(remarks))


def _ratio(design: Design) -> float:
    """Return the largest uncertainty over what is wanted, of those that samples can make less."""
    lost = (one.key for one in design.figures if one.wanted and one.least > one.wanted)
    return design.ratio(frozenset(lost))


def _truth(known: Known) -> Array:
    return np.zeros(9 if known.said.magnetometer_model == "scale_factor" else 6)


def _motion(known: Known, time: Array, interval: float) -> tuple[Array, Array]:
    """Return body from axes that do not turn, (n, 3, 3), and mean rates over an interval about each time, (n, 3)."""
    half = 0.5 * interval
    before, now, after = (_attitude(known, one) for one in (time - half, time, time + half))
    step = after @ np.transpose(before, (0, 2, 1))
    angle = np.arccos(np.clip(0.5 * (np.trace(step, axis1=1, axis2=2) - 1.0), -1.0, 1.0))
    across = np.stack([step[:, 1, 2] - step[:, 2, 1], step[:, 2, 0] - step[:, 0, 2], step[:, 0, 1] - step[:, 1, 0]], 1)
    scale = np.where(angle > 1e-9, angle / (2.0 * np.maximum(np.sin(angle), 1e-12)), 0.5)
    return now, across * scale[:, None] / interval


def _attitude(known: Known, time: Array) -> Array:
    """Return body from axes that do not turn: tumbling by 3-1-3 angles, or turning once an orbit with librations."""
    said = known.said
    if said.motion == "tumbling":
        spin = said.turn_rate
        sway = TILT + SWAY * np.sin(SLOWER * spin * time + 1.0)
        steps = ((2, spin * time), (0, sway), (2, SLOWER * spin * time))
    else:
        sizes = [size * np.sin(2.0 * math.pi * time / period) for size, period in LIBRATION]
        steps = ((2, sizes[2]), (0, sizes[1]), (1, 2.0 * math.pi * time / known.period + sizes[0]))
    made = np.broadcast_to(np.eye(3), (len(time), 3, 3))
    for axis, angle in steps:
        made = made @ rotations(-angle[:, None] * np.eye(3)[axis])
    return np.asarray(made)


def track_of(known: Known, length: float, interval: float) -> Track:
    """Return the record of sensors without errors or noise."""
    said = known.said
    time = np.arange(0.0, length, interval)
    reference = field_along(time, circular_track(said.altitude, said.inclination, time), known.start)
    attitude, rates = _motion(known, time, interval)
    return Track(time, rates, np.einsum("kij,kj->ki", attitude, reference), reference, interval, "orbit")


def _known_by_arcs(known: Known, track: Track) -> tuple[list[Equations], list[Array]]:
    """Return the equations of arcs, and by how much less than their information is noise: errors of the field.

    The test weights residuals by a noise that holds the errors of the field, which are no noise within an arc. The
    information I by a covariance S changes with it as ``dI = -A^T W dS W A``: the scatter by a covariance that is less
    by E is ``I^-1 (I - A^T W E W A) I^-1``.
    """
    cuts, truth, noise = cut(track, known.said.arc), _truth(known), known.noise
    arcs = equations(cuts, truth, noise)
    if not known.said.field_error:
        return arcs, [np.zeros_like(one.information) for one in arcs]
    more = equations(cuts, truth, replace(noise, field=noise.field * (1.0 + STEP)))
    share = (known.said.field_error / noise.field) ** 2 / ((1.0 + STEP) ** 2 - 1.0)
    return arcs, [share * (one.information - other.information) for one, other in zip(arcs, more, strict=True)]


def _design(
    known: Known,
    wanted: Mapping[str, tuple[float, str]],
    track: Track,
    arcs: Sequence[Equations],
    less: Sequence[Array],
    length: float,
) -> Design | None:
    """Return a record of one length, by the arcs that it has; None where it leaves a bias open."""
    own = arcs[: round(length / track.times[-1] * len(arcs))]
    information = np.asarray(sum(one.information for one in own))
    size = np.sqrt(np.abs(np.diag(information)))
    if len(own) < FEWEST or not np.all(size > 0.0) or np.linalg.cond(information / np.outer(size, size)) > OPEN:
        return None
    inverse = np.asarray(np.linalg.inv(information))
    said = known.said
    whole = len(own) * length / len(own)
    edges = np.linspace(0.0, whole, len(own) + 1)
    noise = inverse @ (information - sum(less[: len(own)], np.zeros_like(information))) @ inverse
    squares: dict[str, Array] = {"noise of gyro and magnetometer": np.diag(noise)}
    if said.field_error:
        by_arc = [inverse @ one.others[:, 9:12] * said.field_error for one in own]
        squares["errors of the field, arc by arc"] = np.sum([np.sum(one**2, axis=1) for one in by_arc], axis=0)
    gain = np.array([inverse @ one.information[:, :3] for one in own])  # (arcs, p, 3)
    mean = np.zeros_like(gain)
    mean[:, :3] = np.eye(3) / len(own)
    for label, covariance in Slow(0.0, known.slow.instability, known.slow.walk).parts(edges[:-1], edges[1:]).items():
        squares[label] = np.einsum("apk,ab,bpk->p", gain - mean, covariance, gain - mean)
    changes = np.linalg.solve(information, np.asarray(sum(one.others for one in own))).T
    stated = {"scale factor of the gyro": (said.u_scale, changes[[0, 4, 8]]),
              "misalignment of the gyro": (said.u_misalignment, changes[[1, 2, 3, 5, 6, 7]]),
              "angle between gyro and magnetometer": (said.u_mounting, _of_mounting(changes)),
              "field of the earth, the same all along": (said.u_field, changes[9:12])}  # fmt: skip
    fixed = {label: u**2 * np.sum(rows**2, axis=0) for label, (u, rows) in stated.items() if u > 0.0}
    figures, worst = [], {}
    for k, quantity in enumerate((BIAS, FIELD_BIAS)):
        of = slice(3 * k, 3 * k + 3)
        total = sum((one[of] for one in (*squares.values(), *fixed.values())), np.zeros(3))
        at = worst[quantity] = int(np.argmax(total))
        parts = [Part(label, math.sqrt(max(float(one[of][at]), 0.0)), LONGER) for label, one in squares.items()]
        parts += [Part(label, math.sqrt(float(one[of][at]))) for label, one in fixed.items()]
        least = 1e-9 * max(one.u for one in parts)
        u, shown = wanted.get(quantity, (None, SHOWN[quantity]))
        figures.append(
            Figure(Key(quantity), WANTED[quantity][0], shown, tuple(one for one in parts if one.u > least), u)
        )
    stop = int(np.searchsorted(track.times, length - 1e-6))
    record = replace(track, times=track.times[:stop], rates=track.rates[:stop], field=track.field[:stop],
                     reference=track.reference[:stop])  # fmt: skip
    choice = {"orbits": number(length / known.period, 3), "sample interval": f"{number(track.interval, 3)} s"}
    return Design(length, choice, tuple(figures), Chosen(record, worst))


def _of_mounting(changes: Array) -> Array:
    """Return changes by small turns of the gyro against the magnetometer, shape (3, p)."""
    entry = {f"{a}{b}": changes[3 * i + j] for i, a in enumerate(AXES) for j, b in enumerate(AXES)}
    return np.array([entry["yz"] - entry["zy"], entry["zx"] - entry["xz"], entry["xy"] - entry["yx"]])


def simulated(known: Known, design: Design, rng: np.random.Generator) -> dict[Key, tuple[Array, Array]]:
    """Return errors and stated uncertainties of one simulated test, each of the axis that is known worst."""
    said, chosen = known.said, cast("Chosen", design.detail)
    one, n = chosen.track, len(chosen.track.times)
    matrix = np.eye(3) + np.diag(rng.normal(0.0, said.u_scale, 3))
    matrix += np.where(np.eye(3) > 0.0, 0.0, rng.normal(0.0, said.u_misalignment, (3, 3)))
    slow: list[Term] = [RandomWalk(known.slow.white)]
    slow += [BiasInstability(known.slow.instability)] if known.slow.instability else []
    slow += [RateRandomWalk(known.slow.walk)] if known.slow.walk else []
    noise = np.column_stack([noise_samples(tuple(slow), n, one.interval, rng) for _ in AXES])
    wander = np.zeros(3)
    if known.slow.walk or known.slow.instability:
        wander = np.mean(noise, axis=0)  # the bias that is looked for is that of the mean
    steps = np.minimum((one.times / said.arc).astype(int), max(round(design.time / said.arc) - 1, 0))
    beyond = rng.normal(0.0, said.field_error, (int(steps[-1]) + 1, 3))[steps] + rng.normal(0.0, said.u_field, 3)
    turn = rotations(rng.normal(0.0, said.u_mounting, 3))
    read = (one.field + beyond) @ turn.T + rng.normal(0.0, said.field_noise, (n, 3))
    made = replace(one, rates=one.rates @ matrix.T + noise, field=read)
    result: Result = reduce(known.plan, Readings((made,)))
    estimate = result.estimate
    truth = {BIAS: wander, FIELD_BIAS: np.zeros(3)}
    found = {}
    for k, (quantity, axis) in enumerate(chosen.axes.items()):
        error = float(estimate.values[3 * k + axis] - truth[quantity][axis])
        found[Key(quantity)] = (np.array([error]), np.array([float(estimate.u[3 * k + axis])]))
    return found


HEADS = ("name", "recording", "start [s]", "stop [s]", "duration [s]", "sample interval [s]", "prompt")


def _rows(known: Known, design: Design) -> Iterator[tuple[str, ...]]:
    interval = cast("Chosen", design.detail).track.interval
    edges = [*np.arange(0.0, design.time - 1.0, known.period).tolist(), design.time]
    for k, start in enumerate(edges[:-1]):
        prompt = "Magnetorquers off; gyro, magnetometer and position on one clock" if k == 0 else ""
        yield (f"orbit {k + 1}", "orbit", f"{start:.1f}", f"{edges[k + 1]:.1f}", f"{edges[k + 1] - start:.1f}",
               f"{interval:g}", prompt)  # fmt: skip


def _remarks(known: Known) -> Iterator[Remark]:
    said = known.said
    yield from shared.exact({"scale factor of the gyro": said.u_scale, "misalignment of the gyro": said.u_misalignment,
                             "angle between gyro and magnetometer": said.u_mounting,
                             "field of the earth": said.u_field})  # fmt: skip


__all__ = ["plan_magnetometer_bias", "planned", "simulated", "track_of"]

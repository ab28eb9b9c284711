"""Rows, curves and remarks of a turned-mass calibration."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...core.curve import Column, Curve
from ...core.key import NO_REASON, Key, Member, Reason
from ...core.remarks import Remark
from ...core.results import Row, not_estimated
from ...core.show.rounding import freedom, items, number, uncertainty, with_uncertainty
from ...core.units import factor
from ...physics.turned_mass import recoil_rates
from ...statistics.intervals import coverage_factor, t_interval
from .joining import ALONG, DISAGREE, Joined
from .plan import HEIGHT, MASS, RADIUS, SATELLITE
from .response import Response

if TYPE_CHECKING:
    from .reduction import Result

SCALE, ERROR, DIFFERENCE = "scale_factor", "scale_factor_error", "high_g_difference"
RECOIL, RECOIL_DIFFERENCE = "recoil_arm", "recoil_difference"
OFFSET, ACROSS_IT, ANGLE = "axis_offset", "axis_offset_across", "angle_zero"
UNIT = "count/s/(m/s^2)"
BINS = 24  # of a turn, in a figure
ONE_RATE = 1.01  # rates that differ by less are one
FEW_RUNS = 5
ALPHA = 0.05
FAR = 0.5  # of the nominal scale factor: more is a wrong gate or unit, not an error of the instrument
SURE = 4.0  # standard uncertainties by which the recoil arm differs from that of the masses
BIAS = Reason("needs_flip", "the level is bias plus ambient acceleration: turn the sensor by half a turn (flip)")


def rows(result: Result) -> Iterator[Row]:
    """Yield all rows, SI."""
    axis, estimate = result.plan.axis, result.estimate
    if estimate is None:
        yield not_estimated(Key(SCALE, axis), UNIT, Reason("not_told", result.reason))
    else:
        for key, value, u, unit, dof in zip(
            estimate.keys, estimate.values, estimate.u, estimate.units, estimate.dof, strict=True
        ):
            yield _row(key, float(value), float(u), unit, float(dof), _reference(result, key))
    yield not_estimated(Key("second_order", axis), "1/(m/s^2)", _hidden(result))
    yield not_estimated(Key("third_order", axis), "1/(m/s^2)^2", Reason("same_as_attraction", (
        "K3 reads as attraction: at the attraction of the mass it changes less than any noise")))  # fmt: skip
    yield not_estimated(Key("bias", axis), "m/s^2", BIAS)
    for one in result.responses:
        alone = Member("run", one.run.name)
        reason = Reason("orbit_line", "its turn meets a line of the orbit") if one.met else NO_REASON
        dof = float(one.noise.of(float(one.white[0, 0]), float(one.walk[0, 0]))[1][0])
        for at, name in enumerate(("response_amplitude", "quadrature_amplitude")):
            yield _row(Key(name, axis), float(one.values[at]), float(one.u[at]), "count/s", dof, reason, alone)


def _row(
    key: Key, value: float, u: float, unit: str, dof: float, reason: Reason = NO_REASON, member: Member | None = None
) -> Row:
    shown = dof if math.isfinite(dof) else None
    return Row(key, value, u, unit, shown, t_interval(value, u, dof), reason=reason, member=member)


def _reference(result: Result, key: Key) -> Reason:
    """Return what a difference is relative to."""
    plan = result.plan
    if key.quantity == ERROR:
        return Reason("limits", f"relative to {plan.nominal:.5g} {UNIT}, the scale factor of the chain")
    if key.quantity == DIFFERENCE and plan.high_g is not None:
        return Reason("limits", f"relative to {plan.high_g.scale_factor:.5g} {UNIT}")
    if key.quantity == RECOIL_DIFFERENCE:
        return Reason("limits", "relative to m r / (M + m) of the masses as stated")
    return NO_REASON


def _hidden(result: Result) -> Reason:
    """Return why K2 is not estimated: how large one the uncertainty of the offset hides."""
    u = float(math.sqrt(result.joined.within[ALONG, ALONG]))
    hidden = hidden_second_order(u, result.orbit.attraction) * factor("g", "m/s^2")
    text = f"K2 reads as an offset of the axis: that offset, known to {uncertainty(u)} of the radius, hides a K2"
    return Reason("same_as_offset", f"{text} of up to {number(hidden, 2)} /g")


def hidden_second_order(u_offset: float, attraction: float) -> float:
    """Return the K2 [1/(m/s^2)] whose second harmonic, K2 A^2 / 2, is that of an offset: 3 eps A / 2."""
    return 3.0 * u_offset / attraction


def curves(result: Result) -> list[Curve]:
    """Return the curves, SI: all runs over their recoil rates, then each run over a turn."""
    return [_runs(result), *(_turn(result.plan.axis, one) for one in result.responses)]


def _runs(result: Result) -> Curve:
    every, joined, orbit = result.responses, result.joined, result.orbit
    recoil = [float(recoil_rates(one.run.turn.rate, orbit.rate, orbit.axis)[0]) for one in every]
    u = np.array([one.u[0] for one in every])
    half = u * np.array([
        coverage_factor(float(one.noise.of(float(one.white[0, 0]), float(one.walk[0, 0]))[1][0])) for one in every
    ])  # fmt: skip
    cosine, sine = (np.array([one.values[at] for one in every]) for at in (0, 1))
    fitted = iter(joined.at_turn)
    lines = np.array([[np.nan, np.nan] if one.met else next(fitted) for one in every])
    columns = {
        "run": Column([one.run.name for one in every]),
        "rate": Column([one.run.turn.rate for one in every], "rad/s", shown="deg/s"),
        "period": Column([one.run.turn.period for one in every], "s", shown="h"),
        "recoil_rate": Column(recoil, "1/s^2"),
        "used": Column([not one.met for one in every]),
        "cosine": Column(cosine, "count/s"),
        "u": Column(u, "count/s"),
        "lo": Column(cosine - half, "count/s"),
        "hi": Column(cosine + half, "count/s"),
        "sine": Column(sine, "count/s"),
        "fitted_cosine": Column(lines[:, 0], "count/s"),
        "fitted_sine": Column(lines[:, 1], "count/s"),
    }
    return Curve("turned_runs", result.plan.axis, columns)


def _turn(axis: str, one: Response) -> Curve:
    """Return one run over the angle of its mass: means of what is left without drift, and the line."""
    kept = np.ones(len(one.run.times), dtype=bool)
    kept[list(one.left_out)] = False
    angle = np.mod(one.run.angle, 2.0 * np.pi)
    at = np.minimum((angle / (2.0 * np.pi) * BINS).astype(int), BINS - 1)
    counts = np.bincount(at[kept], minlength=BINS)
    there = counts > 1

    def means(values: np.ndarray[tuple[int], np.dtype[np.float64]]) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
        return np.bincount(at[kept], values[kept], BINS)[there] / counts[there]

    rest = one.run.reading - one.drift
    mean, line = means(rest), means(one.line)
    spread = np.sqrt(np.maximum(means((rest - one.line) ** 2) - (mean - line) ** 2, 0.0) / (counts[there] - 1))
    columns = {
        "angle": Column(means(angle), "rad", shown="deg"),
        "reading": Column(mean, "count/s"),
        "u": Column(spread, "count/s"),
        "line": Column(line, "count/s"),
        "count": Column(counts[there].astype(float), "1"),
    }
    return Curve("turned_turn", axis, columns, of=one.run.turn.named, recording=one.run.name)


def result_remarks(result: Result, disturbed: Sequence[str]) -> Iterator[Remark]:
    """Yield remarks on the result; ``disturbed`` names the runs without which the others agree."""
    yield from _on_runs(result)
    yield from _on_agreement(result.joined, disturbed)
    if result.estimate is None:
        yield Remark("below_floor", "warning", result.reason, do="Turn more mass, nearer, or for longer")
    else:
        yield from _on_comparisons(result)
    missing = [name for name in (MASS, RADIUS, HEIGHT) if name not in result.plan.standards]
    if result.plan.recoil == "stated" and SATELLITE not in result.plan.standards:
        missing.append(SATELLITE)
    if missing:
        what = f"{', '.join(missing)}: no uncertainty stated; the scale factor is relative to the mass as it is given"
        yield Remark("relative_to_fixture", "warning", what, do="State them under [standards]")


def _on_runs(result: Result) -> Iterator[Remark]:
    for one in result.responses:
        run = one.run
        if one.met:
            what = f"run {run.name}: a turn of {run.turn.named} meets {one.met} times the orbital rate: it is left out"
            do = "Turn at another rate: what the orbit does to the instrument looks like the mass"
            yield Remark("orbit_line", "warning", what, run.where, do=do, subject=run.name, recording=run.recording)
        if one.left_out:
            what = f"run {run.name}: {items(len(one.left_out), 'reading')} far off, left out"
            yield Remark("reading_left_out", "warning", what, run.where, len(one.left_out), "Find the cause",
                         subject=run.name, index=one.left_out[0], recording=run.recording)  # fmt: skip
        if one.jump is not None:
            size, hours = number(one.jump.size, 3), number(one.jump.time / 3600.0, 3)
            what = f"run {run.name}: the level jumps by {size} count/s, {hours} h after its start"
            yield Remark("jump", "warning", what, run.where, do="It is taken off; find its cause",
                         subject=run.name, recording=run.recording)  # fmt: skip
    used = result.used
    sizes = [abs(one.run.turn.rate) for one in used]
    if result.orbit.arm is None and max(sizes) < min(sizes) * ONE_RATE:
        what = "all runs turn at one rate: scale factor and recoil are told apart by the sense alone"
        yield Remark("one_rate", "info", what, do="Add a run at another rate, which checks the orbit")
    spare = result.joined.spare
    if len(used) < FEW_RUNS:
        what = f"{items(len(used), 'run')}: their scatter has {freedom(float(spare))}" if spare else (
            f"{items(len(used), 'run')}: nothing shows whether they agree")  # fmt: skip
        yield Remark("few_runs", "warning", what, do=f"Repeat until there are {FEW_RUNS} or more")


def _on_agreement(joined: Joined, disturbed: Sequence[str]) -> Iterator[Remark]:
    if not joined.p_value < ALPHA:
        return
    chance = f"(probability {joined.p_value:.2g})"
    if joined.p_value < DISAGREE and disturbed:
        names = " or ".join(disturbed)
        what = f"run {names}: something else follows its turn {chance}; without it the other runs agree"
        do = "Repeat it at another rate: drift, heat or a pump at the turning frequency looks like attraction"
        yield Remark("drift_at_turn", "warning", what, do=do, subject=disturbed[0])
        return
    what = f"the runs differ by more than their own noise explains {chance}"
    yield Remark("runs_differ", "info" if joined.p_value > DISAGREE else "warning", what,
                 do="The uncertainty includes it; check begin, rates, angles and the mass")  # fmt: skip


def _on_comparisons(result: Result) -> Iterator[Remark]:
    estimate = result.estimate
    assert estimate is not None  # noqa: S101 - checked before
    if estimate.values[0] * (result.plan.nominal or 1.0) < 0.0:
        what = "the readings follow the attraction with the opposite sign: the scale factor is " + (
            "negative" if estimate.values[0] < 0.0 else "positive, that of the chain negative"
        )
        do = "Check the input axis and the zero of the angle; an accelerometer that counts specific force is negative"
        yield Remark("wrong_sign", "warning", what, do=do)
    for key, value, u, dof in zip(estimate.keys, estimate.values, estimate.u, estimate.dof, strict=True):
        figure = f"{with_uncertainty(100.0 * float(value), 100.0 * float(u))} %"
        off = abs(value) > coverage_factor(float(dof)) * u
        if key.quantity == DIFFERENCE and off:
            what = f"the scale factor differs from that of the other test by {figure}"
            do = "Is the mass or its distance wrong? An instrument that is linear has one scale factor"
            yield Remark("disagrees_with_high_g", "warning", what, do=do)
        if key.quantity == ERROR and abs(value) > FAR and off:
            what = f"the scale factor differs by {100.0 * float(value):+.3g} % from the nominal one of the chain"
            yield Remark("far_from_nominal", "warning", what, do="Check gate, range, mass and radius, and their units")
        if key.quantity == RECOIL_DIFFERENCE and abs(value) > SURE * u:
            what = f"the recoil arm differs by {figure} from m r / (M + m)"
            do = "Check radius, mass of the satellite, altitude, input_axis, and the sense of all runs"
            yield Remark("recoil_disagrees", "warning", what, do=do)
        if key.quantity == RECOIL and value < -coverage_factor(float(dof)) * u:
            what = "the recoil arm is negative, which no satellite has"
            yield Remark(
                "recoil_disagrees", "warning", what, do="Check input_axis, the sense of the runs, and the altitude"
            )

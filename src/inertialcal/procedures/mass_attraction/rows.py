"""Rows, curves and remarks of a mass-attraction calibration: scale factor, comparisons, each run; checks before it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from scipy import special

from ...core.constants import GRAVITATIONAL_CONSTANT
from ...core.curve import Column, Curve
from ...core.errors import DataError
from ...core.key import NO_REASON, Key, Member, Method, Reason
from ...core.remarks import Remark
from ...core.results import Interval, Row, not_estimated
from ...core.show.rounding import freedom, number, uncertainty, with_uncertainty
from ...physics.mass_shape.bound import largest_field
from ...signals.correlation import autocorrelation
from ...statistics.intervals import coverage_factor, t_interval
from .joining import DIFFERENCE, ERROR, SCALE, applied_influences, compared_with, estimate_of
from .line import shape_of
from .plan import Plan, SourceMass
from .published import published_rows
from .readings import Readings, Run
from .response import (
    Response,
    tilt_left,
)
from .tilt import tilt_used

if TYPE_CHECKING:
    from .reduction import Result

OTHER = {
    "within_runs": "by the noise within the runs, which includes nothing that differs from run to run",
    "between_runs": "by the scatter of the runs",
}
LAGS = 0.5  # of the dwells


def rows(result: Result) -> Iterator[Row]:
    """Yield all rows, SI."""
    axis, estimate, scale_unit = result.plan.axis, result.estimate, result.plan.scale_unit
    if estimate is None:
        yield not_estimated(Key(SCALE, axis), scale_unit, Reason("not_told", result.reason))
    else:
        reference = compared_with(result.plan, estimate)
        for key, value, u, unit, dof in zip(
            estimate.keys, estimate.values, estimate.u, estimate.units, estimate.dof, strict=True
        ):
            reason = Reason("limits", reference.get(key.quantity, ""))
            yield _row(key, float(value), float(u), unit, float(dof), reason)
        if result.joined is not None and result.joined.between is not None:
            other = "within_runs" if result.scatter == "between_runs" else "between_runs"
            found = estimate_of(result.plan, result.readings, result.responses, result.joined, other)
            value, u, dof = (float(one[0]) for one in (found.values, found.u, found.dof))
            yield _row(Key(SCALE, axis), value, u, scale_unit, dof, Reason("limits", OTHER[other]), Method(other))
    yield from published_rows(result)
    for one in result.responses:
        yield from _rows_of_run(result, one)


def _row(
    key: Key, value: float, u: float, unit: str, dof: float, reason: Reason = NO_REASON,
    method: Method = Method.RESULT, member: Member | None = None,
) -> Row:  # fmt: skip
    shown = dof if math.isfinite(dof) else None
    return Row(key, value, u, unit, shown, t_interval(value, u, dof), reason=reason, method=method, member=member)


def _rows_of_run(result: Result, one: Response) -> Iterator[Row]:
    axis, alone = result.plan.axis, Member("run", one.name)
    output, scale_unit = result.plan.output_unit, result.plan.scale_unit
    if not one.moved:
        size = result.per_applied
        if size:
            reason = Reason("zero_expected", "the mass did not move: zero is expected")
            key = Key("null_response", axis)
            yield _row(key, one.amplitude / size, one.u / size, "m/s^2", one.dof, reason, member=alone)
    elif one.significant(result.plan.floor):
        noise = Reason("limits", "its own noise alone, without the uncertainty of what is applied")
        yield _row(Key("response_amplitude", axis), one.amplitude, one.u, output, one.dof, member=alone)
        yield _row(Key(SCALE, axis), one.scale_factor, one.u_scale_factor, scale_unit, one.dof, noise, member=alone)
    else:
        limit = t_interval(abs(one.amplitude), one.u, one.dof, 0.9).hi
        floor = f"{result.plan.floor:g} times the noise floor of {uncertainty(one.u)} {output}"
        below = f"below {floor}: cannot be told from noise"
        reason = Reason("not_told", below)
        yield Row(Key("response_amplitude", axis), limit, None, output, None, Interval(0.0, limit), "upper_limit",
                  reason, member=alone)  # fmt: skip
        yield not_estimated(Key(SCALE, axis), scale_unit, reason, member=alone)
    if math.isfinite(one.u_quadrature):
        ahead = Reason("zero_expected", "a quarter of a cycle ahead of the drive: zero is expected")
        key = Key("quadrature_amplitude", axis)
        yield _row(key, one.quadrature, one.u_quadrature, output, one.dof, ahead, member=alone)
    if math.isfinite(one.tilt):
        of_pad = Reason("limits", "of the pad in phase with the drive, mercury subtracted")
        yield _row(Key("tilt_amplitude", axis), one.tilt, one.u_tilt, "rad", one.dof, of_pad, member=alone)


def curves(result: Result) -> list[Curve]:
    """Return the curves, SI: each run with its line, correlation and spectrum, then all runs."""
    by_name = {one.name: one for one in result.responses}
    found = []
    for run in result.readings.series:
        if by_name[run.name].fitted is not None:
            found += _curves_of_run(result.plan, run, by_name[run.name])
    return [*found, _runs(result)]


def _curves_of_run(plan: Plan, run: Run, one: Response) -> list[Curve]:
    """Return series, autocorrelation (gaps count as zero) and Fourier amplitudes of a run; gaps are NaN."""
    schedule, fitted = run.schedule, one.fitted
    assert fitted is not None  # noqa: S101 - checked before
    reduced = np.asarray(one.series - fitted.drift)  # without drift and tilt
    series = {
        "time": Column(schedule.middle, "s", shown="h"),
        "reading": Column(run.reading, plan.output_unit),
        "drift": Column(fitted.drift, plan.output_unit),
        "reduced": Column(reduced, plan.output_unit),
        "line": Column(fitted.line, plan.output_unit),
        "shape": Column(shape_of(schedule)),
    }
    lags = int(LAGS * len(reduced))
    both = [autocorrelation(np.nan_to_num(part), lags).values for part in (reduced, reduced - fitted.line)]
    correlation = {
        "lag": Column(np.arange(lags + 1) * schedule.step, "s", shown="h"),
        "reduced": Column(both[0] / both[0][0], "1"),
        "noise": Column(both[1] / both[0][0], "1"),
    }
    there, length = np.isfinite(reduced), len(reduced) * schedule.step
    frequencies = np.arange(1, len(reduced) // 2 + 1) / length
    # amplitudes by projection: gaps have no row
    waves = np.exp(-1j * (2.0 * np.pi * np.outer(schedule.middle[there], frequencies)))
    half = np.where(np.isclose(frequencies * 2.0 * schedule.step, 1.0), 1.0, 2.0)
    amplitude = half * np.abs(waves.T @ reduced[there]) / there.sum()
    role = np.full(len(frequencies), "", dtype=object)
    for k, f in enumerate(fitted.frequencies):
        role[np.abs(frequencies - f) < 0.5 / length] = "beside" if k else "drive"
    spectrum = {
        "frequency": Column(frequencies, "Hz"),
        "amplitude": Column(amplitude, plan.output_unit),
        "role": Column(role.tolist()),
    }
    named = {"mass_series": series, "mass_correlation": correlation, "mass_spectrum": spectrum}
    return [Curve(name, plan.axis, columns, recording=run.name) for name, columns in named.items()]


def _runs(result: Result) -> Curve:
    """Return all runs with their responses, and with the figures of the published way."""
    lines = {line.name: line for line in result.published[0]}
    output, scale_unit = result.plan.output_unit, result.plan.scale_unit

    def each(value: str) -> list[float]:
        return [float(getattr(one, value)) for one in result.responses]

    def published(name: str) -> list[float]:
        return [float(getattr(lines[one.name], name)) if one.name in lines else np.nan for one in result.responses]

    scale, u = np.array(each("scale_factor")), np.array(each("u_scale_factor"))
    half = u * np.array([coverage_factor(one.dof) for one in result.responses])
    columns = {
        "run": Column([one.name for one in result.responses]),
        "moved": Column([one.moved for one in result.responses]),
        "applied": Column(each("applied"), "m/s^2"),
        "response": Column(each("amplitude"), output),
        "u": Column(each("u"), output),
        "scale_factor": Column(scale, scale_unit),
        "lo": Column(scale - half, scale_unit),
        "hi": Column(scale + half, scale_unit),
        "tilt": Column(each("tilt"), "rad"),
        "published_fourier": Column(published("response"), output),
        "published_fourier_noise": Column(published("noise"), output),
        "published_spectrum": Column(published("psd_response"), output),
        "published_spectrum_noise": Column(published("psd_noise"), output),
        "published_scatter": Column(published("scatter"), output),
    }
    return Curve("mass_runs", result.plan.axis, columns)


LIGHTEST, DENSEST = 10.0, 23_000.0  # of materials [kg/m^3]
FEW_RUNS = 5
CLEAR = 3.0  # standard uncertainties


ALPHA = 0.05


COUNTS = 0.1  # of the standard uncertainty: smaller parts of it are not remarked


FAR = 0.5  # of the nominal scale factor: more is a wrong gate or unit, not an error of the instrument


def check_source(source: SourceMass, run: Run) -> None:
    """Refuse a schedule that applies more than its mass can, or an impossible mass.

    Raises
    ------
    DataError
        ``overlap`` if the mass would stand where the instrument is, ``absurd_density``, ``too_attractive``.
    """
    if not source.stand_off > 0.0:
        what = f"stand-off {source.stand_off:g} m: the mass would overlap the instrument"
        do = "Give the distance from the proof mass to the nearest face of the mass"
        raise DataError(what, "plan.source.stand_off", do=do, code="overlap")
    if not LIGHTEST <= source.density <= DENSEST:
        what = f"density {source.density:g} kg/m^3: materials lie between {LIGHTEST:g} and {DENSEST:g} kg/m^3"
        raise DataError(what, "plan.source.density", do="Lead is 11340 kg/m^3", code="absurd_density")
    most = GRAVITATIONAL_CONSTANT.value * largest_field(source.mass, source.density, source.stand_off).field
    change = 2.0 * run.schedule.amplitude
    if change > most:
        what = (
            f"{run.name}: the schedule changes the attraction by {change:.4g} m/s^2, {source.mass:.4g} kg at"
            f" {source.stand_off:g} m cannot attract more than {most:.4g} m/s^2 in any shape"
        )
        do = "Check the units of position and applied (cm for m?), and plan.source"
        raise DataError(what, run.where, "its attraction is largest where it is nearest", do, "too_attractive")


def series_remarks(plan: Plan, readings: Readings) -> Iterator[Remark]:
    """Yield remarks on runs: incomplete cycles, missing dwells, missing tilt."""
    for run in readings.series:
        per_cycle = run.schedule.samples_per_cycle
        if len(run.schedule) % per_cycle:
            what = f"runs of {len(run.schedule)} dwells are not a whole number of cycles of {per_cycle}"
            do = "The regression allows for it; the published way does not, and is left out"
            yield Remark("not_whole_cycles", "warning", what, run.where, do=do)
        lost = len(run.schedule) - run.there
        if lost:
            what = f"{run.name}: {lost} dwell(s) of the schedule have no reading; they stay gaps"
            yield Remark("missing_dwells", "info", what, run.where)
    lacking = [run for run in readings.series if plan.tilt != "ignored" and tilt_used(plan, run) == "ignored"]
    do = 'State its size as [standards.pad] tilt, or set tilt = "ignored"'
    if lacking and not any(run.tilt is not None for run in readings.series):
        yield Remark("missing_tilt", "warning", "the tilt of the pad was not recorded, and is not subtracted", do=do)
        return
    for run in lacking:
        what = f"{run.name}: the tilt of the pad was not recorded, and is not subtracted"
        yield Remark("missing_tilt", "warning", what, run.where, do=do)


def result_remarks(result: Result) -> Iterator[Remark]:
    """Yield remarks on the result of a campaign."""
    yield from _on_nulls(result)
    yield from _on_changes(result)
    yield from _on_runs(result)
    if result.estimate is not None:
        scale, u = float(result.estimate.values[0]), float(result.estimate.u[0])
        remainder = tilt_left(result.responses)
        if abs(remainder) > COUNTS * u:
            what = f"tilt is regressed: noise of its meter adds {100.0 * remainder / abs(scale):.2g} % to u"
            do = 'tilt = "known" avoids it; it needs the sign of the meter (tilt_sign)'
            yield Remark("tilt_in_phase", "warning", what, do=do)
        yield from _on_comparisons(result)
    if not applied_influences(result.plan, result.readings):
        what = "uncertainty of the acceleration applied not given: the scale factor is relative to the schedule"
        do = (
            "State [standards.source_mass] density, placing and gravitational_constant, or u of applied in the schedule"
        )
        yield Remark("relative_to_fixture", "warning", what, do=do)


def _on_nulls(result: Result) -> Iterator[Remark]:
    """Test that null runs do not respond, over all of them at 5 % (Holm)."""
    nulls = [one for one in result.responses if not one.moved]
    p = {one.name: 2.0 * float(special.stdtr(one.dof, -abs(one.amplitude / one.u))) for one in nulls}
    for rank, name in enumerate(sorted(p, key=lambda one: p[one])):
        if p[name] > ALPHA / (len(p) - rank):
            break
        what = f"null run {name}: its response, or a larger one, has probability {p[name]:.2g}"
        do = "Something follows the schedule although the mass does not move: find it, the other runs have it too"
        yield Remark("null_run_not_zero", "warning", what, do=do)
    if not nulls and result.readings.series:
        what = "no null run: what else follows the schedule of the mass is not known"
        yield Remark("no_null_run", "info", what, do="Run the schedule once with the mass at rest")


def _on_changes(result: Result) -> Iterator[Remark]:
    """Yield the faults within runs that were subtracted."""
    size = float(np.median([abs(one.amplitude) for one in result.responses if one.moved]))
    output = result.plan.output_unit
    for response in result.responses:
        if response.changes is None or not response.changes.repairable:
            continue
        for one in response.changes.found:
            times = f", {number(abs(one.size) / size, 2)} times the response" if size else ""
            if one.kind == "kink":
                what = f"the drift bends before dwell {one.at + 1} by {number(one.size, 3)} {output} a dwell{times}"
            elif one.kind == "jump":
                what = f"the level jumps by {number(one.size, 3)} {output}{times}, before dwell {one.at + 1}"
            else:
                what = f"the reading of dwell {one.at + 1} is off by {number(one.size, 3)} {output}{times}"
            code, do = {
                "kink": ("drift_kink", "The kink is fitted with the drift"),
                "jump": ("jump", "The jump is fitted with the drift; find its cause"),
                "reading": ("reading_left_out", "It is left out; find its cause"),
            }[one.kind]
            yield Remark(code, "warning", f"run {response.name}: {what}", do=do, subject=response.name, index=one.at)


def _on_runs(result: Result) -> Iterator[Remark]:
    runs, both = sum(one.moved for one in result.responses), result.joined
    if runs == 1:
        what = "one run with the mass moved: the uncertainty does not include differences from run to run"
        yield Remark("no_runs", "warning", what, do="Repeat the run")
    elif runs < FEW_RUNS:
        spare = 0 if both is None or both.between is None else both.between.dof
        what = f"{runs} runs with the mass moved: their scatter has {freedom(spare)}"
        yield Remark("few_runs", "warning", what, do=f"Repeat until there are {FEW_RUNS} or more")
    if both is not None and both.p_value < ALPHA:
        what = f"the runs differ by more than their own noise explains (probability {both.p_value:.2g})"
        yield Remark("runs_differ", "info", what, do="The uncertainty includes it")
    if both is not None and result.estimate is not None and both.phases is not None:
        largest = float(np.max(np.abs(both.repeats)))
        if largest > CLEAR * both.u_repeats:
            share = 100.0 * largest / abs(float(result.estimate.values[0]))
            what = f"a drift that repeats in every run is as large as {number(share, 2)} % of the response at the drive"
            yield Remark("repeating_drift", "info", what, do="It cancels: the runs start at different phases")
    if result.estimate is None:
        yield Remark("below_floor", "warning", result.reason, do="Move more mass, nearer, or for longer")


def _on_comparisons(result: Result) -> Iterator[Remark]:
    assert result.estimate is not None  # noqa: S101 - checked before
    if result.estimate.values[0] < 0.0:
        what = "the response is opposite to what is applied: the scale factor is negative"
        do = "Check the input axis, and the order of the stops in the schedule"
        yield Remark("wrong_sign", "warning", what, do=do)
    for i, key in enumerate(result.estimate.keys):
        value, u, dof = (float(one[i]) for one in (result.estimate.values, result.estimate.u, result.estimate.dof))
        off = abs(value) > coverage_factor(dof) * u
        if key.quantity == DIFFERENCE and off:
            what = f"the scale factor differs from that at high g by {with_uncertainty(100.0 * value, 100.0 * u)} %"
            do = "Is the instrument not linear down to here, or does something else follow the mass: tilt of the pad?"
            yield Remark("disagrees_with_high_g", "warning", what, do=do)
        if key.quantity == ERROR and abs(value) > FAR and off:
            what = f"the scale factor differs by {100.0 * value:+.3g} % from the nominal one of the chain"
            do = "Check the gate, the range, and the units of the schedule"
            yield Remark("far_from_nominal", "warning", what, do=do)

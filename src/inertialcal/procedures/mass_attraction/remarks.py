"""Checks before a reduction, and remarks on a result: null runs that respond, runs that differ, failed comparisons."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from scipy import special

from ...core.constants import GRAVITATIONAL_CONSTANT
from ...core.errors import DataError
from ...core.remarks import Remark
from ...physics.mass_shape.bound import largest_field
from ...statistics.intervals import coverage_factor
from .plan import Plan, SourceMass
from .readings import Readings, Run
from .response import DIFFERENCE, ERROR, applied_influences, tilt_left, tilt_used

if TYPE_CHECKING:
    from .reduction import Result

LIGHTEST, DENSEST = 10.0, 23_000.0  # of materials [kg/m^3]
FEW_RUNS = 5
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
        if plan.tilt == "ignored" or tilt_used(plan, run) != "ignored":
            continue
        if plan.tilt == "known" and not plan.nominal and run.tilt is not None:
            what = f'{run.name}: tilt = "known" needs the nominal scale factor of the chain; tilt was not subtracted'
            yield Remark("missing_tilt", "warning", what, run.where, do='Give it, or set tilt = "regressed"')
            continue
        what = f"{run.name}: the tilt of the pad was not recorded, and is not subtracted"
        do = 'State its size as [standards.pad] tilt, or set tilt = "ignored"'
        yield Remark("missing_tilt", "warning", what, run.where, do=do)


def result_remarks(result: Result) -> Iterator[Remark]:
    """Yield remarks on the result of a campaign."""
    yield from _on_nulls(result)
    yield from _on_runs(result)
    if result.estimate is not None:
        scale, u = float(result.estimate.values[0]), float(result.estimate.u[0])
        remainder = tilt_left(result.responses, scale)
        if abs(remainder) > COUNTS * u:
            what = (
                f"tilt is regressed: noise of its meter leaves {100.0 * remainder / scale:+.2g} % of the scale factor,"
                f" if the meter stands along the input axis"
            )
            do = 'The uncertainty includes it. tilt = "known" subtracts it; it needs the sign of the meter (tilt_sign)'
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


def _on_runs(result: Result) -> Iterator[Remark]:
    runs = sum(one.moved for one in result.responses)
    if runs == 1:
        what = "one run with the mass moved: the uncertainty does not include differences from run to run"
        yield Remark("no_runs", "warning", what, do="Repeat the run")
    elif runs < FEW_RUNS:
        what = f"{runs} runs with the mass moved: their scatter has {runs - 1} degree(s) of freedom"
        yield Remark("few_runs", "warning", what, do=f"Repeat until there are {FEW_RUNS} or more")
    both, between = result.combined, result.scatter == "between_runs"
    if both is not None and both.p_value < ALPHA:
        what = f"the runs differ by more than their own noise explains (probability {both.p_value:.2g})"
        if between:
            yield Remark("runs_differ", "info", what, do="The uncertainty includes it")
        else:
            yield Remark("runs_differ", "warning", what, do='Set scatter = "between_runs"')
    if both is not None and both.p_value > 1.0 - ALPHA:
        what = f"the runs agree better than their own noise allows (probability {1.0 - both.p_value:.2g}): u is that of"
        what += " their scatter, and may be too small" if between else " their noise"
        do = "within_runs gives the uncertainty from the noise of each" if between else ""
        yield Remark("runs_agree_too_well", "info", what, do=do)
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
            what = f"the scale factor differs by {100.0 * value:+.3g} % from that at high g (+- {100.0 * u:.2g} %)"
            do = "Is the instrument not linear down to here, or does something else follow the mass: tilt of the pad?"
            yield Remark("disagrees_with_high_g", "warning", what, do=do)
        if key.quantity == ERROR and abs(value) > FAR and off:
            what = f"the scale factor differs by {100.0 * value:+.3g} % from the nominal one of the chain"
            do = "Check the gate, the range, and the units of the schedule"
            yield Remark("far_from_nominal", "warning", what, do=do)

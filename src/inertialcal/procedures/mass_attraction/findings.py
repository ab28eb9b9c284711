"""What is to be said of a result: null runs that are not zero, runs that disagree, comparisons that fail."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from scipy import special

from ...core.remarks import Remark
from ...statistics.intervals import coverage_factor
from .response.of_run import tilt_left
from .response.scale import DIFFERENCE, ERROR, applied_known

if TYPE_CHECKING:
    from .reduction import Result

FEW_RUNS = 5
ALPHA = 0.05
COUNTS = 0.1  # of the standard uncertainty, from which a part of it is worth a word
FAR = 0.5  # of the nominal scale factor: more is a wrong gate or a wrong unit, not an error of the instrument


def findings(result: Result) -> Iterator[Remark]:
    """Yield the remarks.

    Parameters
    ----------
    result : Result
        Of the campaign.
    """
    yield from _nulls(result)
    yield from _runs(result)
    yield from _tilt(result)
    if result.estimate is not None:
        yield from _compared(result)
    if not applied_known(result.plan, result.readings):
        what = "nothing says how well the acceleration applied is known: the scale factor is relative to the schedule"
        do = (
            "State [standards.source_mass] density, placing and gravitational_constant, or u of applied in the schedule"
        )
        yield Remark("relative_to_fixture", "warning", what, do=do)


def _nulls(result: Result) -> Iterator[Remark]:
    """Test that null runs respond with zero; over all of them at 5 % (Holm)."""
    nulls = [one for one in result.responses if not one.moved]
    p = {one.name: 2.0 * float(special.stdtr(one.dof, -abs(one.amplitude / one.u))) for one in nulls}
    for rank, name in enumerate(sorted(p, key=lambda one: p[one])):
        if p[name] > ALPHA / (len(p) - rank):
            break
        what = f"null run {name}: a response of the size that it has, or a larger one, has probability {p[name]:.2g}"
        do = "Something follows the schedule though the mass does not move: find it, it is in the other runs, too"
        yield Remark("null_run_not_zero", "warning", what, do=do)
    if not nulls and result.readings.series:
        what = "no null run: what else follows the schedule of the mass is not known"
        yield Remark("no_null_run", "info", what, do="Run the schedule once with the mass at rest")


def _runs(result: Result) -> Iterator[Remark]:
    runs = sum(one.moved for one in result.responses)
    if runs == 1:
        what = "one run with the mass moved: what differs from run to run is not in the uncertainty"
        yield Remark("no_runs", "warning", what, do="Repeat the run")
    elif runs < FEW_RUNS:
        what = f"{runs} runs with the mass moved: their scatter has {runs - 1} degree(s) of freedom"
        yield Remark("few_runs", "warning", what, do=f"Repeat until there are {FEW_RUNS} or more")
    both = result.combined
    if both is not None and both.p_value < ALPHA:
        what = f"the runs differ by more than their own noise explains (probability {both.p_value:.2g})"
        severity = "info" if result.scatter == "between_runs" else "warning"
        do = "It is in the uncertainty" if severity == "info" else 'Say scatter = "between_runs"'
        yield Remark("runs_differ", severity, what, do=do)  # type: ignore[arg-type]
    if both is not None and both.p_value > 1.0 - ALPHA:
        what = (
            f"the runs agree better than their own noise lets them (probability {1.0 - both.p_value:.2g}): u is that of"
            f" {'how they differ, and may be too small' if result.scatter == 'between_runs' else 'their noise'}"
        )
        do = (
            "The uncertainty from the noise of each stands beside: within_runs"
            if result.scatter == "between_runs"
            else ""
        )
        yield Remark("runs_agree_too_well", "info", what, do=do)
    if result.estimate is None:
        yield Remark("below_floor", "warning", result.reason, do="Move more mass, nearer, or for longer")


def _tilt(result: Result) -> Iterator[Remark]:
    """Say how much of a tilt in phase is left where it is regressed, whose meter's noise draws its share to zero."""
    if result.estimate is None:
        return
    scale = float(result.estimate.values[0])
    left = tilt_left(result.responses, scale)
    if abs(left) > COUNTS * float(result.estimate.u[0]):
        what = (
            f"tilt is regressed: noise of its meter leaves {100.0 * left / scale:+.2g} % of the scale factor in it,"
            f" if the meter stands along the input axis"
        )
        do = 'It is in the uncertainty. tilt = "known" takes it off; it needs the sense of the meter (tilt_sign)'
        yield Remark("tilt_in_phase", "warning", what, do=do)


def _compared(result: Result) -> Iterator[Remark]:
    assert result.estimate is not None  # noqa: S101 - asked before
    if result.estimate.values[0] < 0.0:
        what = "the response is opposite to what is applied: the scale factor is below zero"
        do = "Look at the input axis, and at the order of the stops in the schedule"
        yield Remark("wrong_sign", "warning", what, do=do)
    for i, key in enumerate(result.estimate.keys):
        value, u, dof = (float(one[i]) for one in (result.estimate.values, result.estimate.u, result.estimate.dof))
        off = abs(value) > coverage_factor(dof) * u
        if key.quantity == DIFFERENCE and off:
            what = f"the scale factor is {100.0 * value:+.3g} % off that at high g (+- {100.0 * u:.2g} %)"
            do = "The instrument is not linear down to here, or something beside the mass follows it: the pad's tilt?"
            yield Remark("disagrees_with_high_g", "warning", what, do=do)
        if key.quantity == ERROR and abs(value) > FAR and off:
            what = f"the scale factor is {100.0 * value:+.3g} % off the nominal one of the chain"
            do = "Look at the gate, at the range, and at the units of the schedule"
            yield Remark("far_from_nominal", "warning", what, do=do)

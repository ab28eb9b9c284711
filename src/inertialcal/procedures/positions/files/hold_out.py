"""Positions held out: how a fit of the first ones does on the others, with and without g-sensitivity."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ....core.curve import Column, Curve
from ....core.errors import DataError
from ....core.estimate import Array
from ....core.key import Key, Member, Reason
from ....core.remarks import Remark
from ....core.results import Row
from ....statistics.intervals import chi_square_interval
from ..held_out.first_positions import HeldOut
from ..held_out.first_positions import held_out as fit_and_judge
from ..plan import Plan
from ..readings import Readings

HELD, WITHOUT = Member("held_out", ""), Member("held_out", "no g-sensitivity")


@dataclass(frozen=True, eq=False)
class Held:
    """Errors on the positions that a fit of the first ones has not seen.

    Parameters
    ----------
    whole : HeldOut
        With all terms.
    without : HeldOut or None
        With g-sensitivity left out; None where it cannot be fitted.
    """

    whole: HeldOut
    without: HeldOut | None
    remarks: tuple[Remark, ...] = ()

    def rows(self) -> list[Row]:
        """Return root mean squares: of the length of gravity, and of transitions with and without g-sensitivity, SI."""
        first = f"fitted on the first {self.whole.first} positions"
        found = [_row("gravity_error", "m/s^2", self.whole.lengths, 1, HELD, first, "accelerometer")]
        if len(self.whole.angles):
            found.append(_row("transition_error", "rad", self.whole.angles, 2, HELD, first, "gyro"))
        if self.without is not None and len(self.without.angles):
            found.append(_row("transition_error", "rad", self.without.angles, 2, WITHOUT, first, "gyro"))
        return found

    def marked(self, curves: Sequence[Curve]) -> list[Curve]:
        """Return curves in which the transitions held out have their errors as such."""
        return [self._transitions(one) if one.name == "transitions" else one for one in curves]

    def _transitions(self, curve: Curve) -> Curve:
        before = np.asarray(curve.columns["before"].values, dtype=float)
        held = before > self.whole.first
        if int(held.sum()) != len(self.whole.angles):
            return curve
        columns = dict(curve.columns)
        columns["error"] = _put(columns["error"], held, self.whole.angles)
        if "error_without" in columns and self.without is not None:
            columns["error_without"] = _put(columns["error_without"], held, self.without.angles)
        columns["held_out"] = Column([bool(one) for one in held])
        return replace(curve, columns=columns)


def held_out(plan: Plan, readings: Readings, first: int) -> Held:
    """Judge a fit of the first positions by the others.

    Raises
    ------
    DataError
        As ``procedures.positions.held_out``.
    """
    try:
        whole = fit_and_judge(plan, readings, first)
    except DataError as error:
        few = f"held out are {len(readings) - first} of {len(readings)} positions; the other {first}: "
        raise DataError([replace(one, what=few + one.what, do="Hold out fewer") for one in error.problems]) from None
    without = None
    if readings.gyro is not None and plan.g_sensitivity is not False and len(whole.angles):
        try:
            without = fit_and_judge(replace(plan, g_sensitivity=False), readings, first)
        except DataError:  # what is shown beside the result, and need not be
            without = None
    return Held(whole, without)


def _row(quantity: str, unit: str, errors: Array, each: int, member: Member, reason: str, test: str) -> Row:
    dof = float(each * len(errors))
    rms = float(np.sqrt(np.mean(errors**2)))
    u = rms / float(np.sqrt(2.0 * dof))
    interval = chi_square_interval(rms, dof) if rms > 0.0 else None
    said = Reason("limits", reason)
    return Row(Key(quantity), rms, u, unit, dof, interval, reason=said, test=test, member=member)


def _put(column: Column, at: NDArray[np.bool_], values: Array) -> Column:
    made = np.array(column.values, dtype=float)
    made[at] = values
    return Column(made, column.unit)

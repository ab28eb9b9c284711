"""What there is to say of a plan of a source mass beside its figures."""

from __future__ import annotations

from collections.abc import Sequence

from ....core.remarks import Remark
from ....core.results import Row
from .drive import MassBudget
from .settings import Constants

EXCESS = 0.0  # % of a stated attraction over the bound, from which it cannot be


def body_remarks(rows: Sequence[Row], constants: Constants) -> tuple[Remark, ...]:
    """Return what there is to say of a body: a stated attraction above the bound, constants of a document."""
    found = []
    by_name = {row.quantity: row for row in rows}
    excess = by_name.get("stated_excess")
    if excess is not None and (excess.value or 0.0) > EXCESS:
        needed = by_name["mass_needed"].value or 0.0
        what = (
            f"the stated attraction is {excess.value:.2g} % above the most that {by_name['mass'].value:.6g} kg behind "
            f"that plane can attract, whatever its shape: it takes {needed:.5g} kg or more"
        )
        do = "Mass, density, distance or attraction is not as stated"
        found.append(Remark("above_bound", "error", what, do=do))
    if constants != Constants():
        what = (
            f"constants of a document: G = {constants.gravitational_constant:.6g} m^3/s^2/kg, and a g of "
            f"{constants.gravity:g} m/s^2 in every ng"
        )
        found.append(Remark("document_constants", "info", what))
    return tuple(found)


def budget_remarks(unstated: tuple[str, ...], budget: MassBudget) -> tuple[Remark, ...]:
    """Return what there is to say of a budget: doubts that nobody stated, and whether slopes are enough."""
    found = []
    if unstated:
        names = ", ".join(f"--u-{name.replace('_', '-')}" for name in unstated)
        what = f"not stated, and taken as exact: {names}"
        do = "State them: the amplitude is relative to these as they are"
        found.append(Remark("no_standard_uncertainty", "warning", what, do=do))
    if budget.agrees is False:
        what = "linear and Monte Carlo budget differ by more than a digit of u (JCGM 101, clause 8): doubts are large"
        found.append(Remark("not_linear", "warning", what, do="Take the Monte Carlo figure"))
    return tuple(found)

"""Uncertainty budgets: for each figure its sources, each with what it contributes and why (JCGM 100, 4.3, 5.1, G.4).

The contribution of a source is ``u = sensitivity * stated_u``: ``stated_u`` is the standard uncertainty of the source
itself (0.05 % of the table's rate, 0.1 deg of the mounting), the sensitivity its size, without sign. Where several
unknowns of that size enter a figure (the mounting angles, one towards each of two other axes) it is the root sum of
squares over them; terms of second order are in it. Scatter is observed in the figures themselves: sensitivity 1.

The squares of ``u`` add up to the square of the figure's uncertainty, so ``share`` is a share of the variance. A share
that is no more than the rounding of the arithmetic is no contribution and has no row.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ...core.estimate import Component, Estimate
from ...core.results import finite, key_fields
from ...core.units import divide, factor
from ...procedures.display import display_unit, stated_unit, ten_digits
from ...procedures.protocol import BudgetFigure, budget_figures

ROUNDING = 1e-20  # share of a variance that cannot be told from none: 1e-10 of u


def budget_rows(
    test: str,
    estimate: Estimate | None,
    sensor_unit: str,
    figures: Sequence[BudgetFigure] | None = None,
    sensor: str = "",
) -> list[dict[str, Any]]:
    """Return the sources of uncertainty of each figure, in the units of the campaign.

    Parameters
    ----------
    test : str
        Name of the test, or ``"model"``.
    estimate : Estimate or None
        SI.
    sensor_unit : str
        As the campaign has it: ``"deg/s"``.
    figures : sequence of BudgetFigure, optional
        Those that have a budget; all values of the estimate by default.
    sensor : str
        Kind of sensor, where the test has several.
    """
    if estimate is None:
        return []
    found = []
    for figure in budget_figures(estimate) if figures is None else figures:
        total = float(estimate.covariance[figure.at, figure.at])
        for component in estimate.components:
            share = float(component.covariance[figure.at, figure.at]) / total if total > 0.0 else 0.0
            if share > ROUNDING:
                key = key_fields(figure.key) | ({"sensor": sensor} if sensor else {})
                found.append({"test": test} | key | _row(figure, component, sensor_unit) | {"share": share})
    return found


def _row(figure: BudgetFigure, component: Component, sensor_unit: str) -> dict[str, Any]:
    unit = display_unit(figure.key.name, figure.unit, sensor_unit)
    u = float(component.u[figure.at]) * figure.times * factor(figure.unit, unit, difference=True)
    dof = component.dof if isinstance(component.dof, float) else float(component.dof[figure.at])
    return {
        "source": component.source, "influence": _influence(component), "kind": component.kind,
        "distribution": component.distribution,
        **_sensitivity(component, u, unit, sensor_unit), "u": u, "unit": unit, "dof": finite(dof),
    }  # fmt: skip


def _influence(component: Component) -> str:
    """Return the name of the influence under [standards] that a source is; empty for others."""
    origin = component.origin
    return f"{origin.standard}.{origin.quantity}" if origin.standard else ""


def _sensitivity(component: Component, u: float, unit: str, sensor_unit: str) -> dict[str, Any]:
    """Return what the source itself has, and how the figure follows it."""
    if component.stated is not None:
        own, own_unit = component.stated
        shown = stated_unit(own_unit, sensor_unit)
        if shown != own_unit:  # 3 deg went through radians and shall come out as 3
            own = ten_digits(own * factor(own_unit, shown, difference=True))
        return {
            "stated_u": own, "stated_unit": shown,
            "sensitivity": u / own, "sensitivity_unit": divide(unit, shown),
        }  # fmt: skip
    if component.kind == "A":
        return {"stated_u": u, "stated_unit": unit, "sensitivity": 1.0, "sensitivity_unit": "1"}
    return {"stated_u": None, "stated_unit": "", "sensitivity": None, "sensitivity_unit": ""}

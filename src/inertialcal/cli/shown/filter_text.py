"""Budgets of filters as text, and as the content of ``--json``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ...core.show.rounding import number
from ...core.show.tables import aligned, clean
from ...core.units import factor
from .output import wrapped
from .summary import remarks_text

if TYPE_CHECKING:
    from ...campaign.models.filter_settings import FilterSettings
    from ...sensors.noise.filter_budget import Budget, Line

DIGITS = 3
WORDS = {"white": "white noise", "walk": "random walk", "gauss_markov": "Gauss-Markov", "start": "start of the bias"}
SHOWN = {  # kind -> unit of white noise, of a walk, and of a standard deviation, with what SI calls them
    "gyro": {"white": ("rad/s/sqrt(Hz)", "deg/s/sqrt(Hz)"), "walk": ("rad/s/sqrt(s)", "deg/s/sqrt(s)"),
             "size": ("rad/s", "deg/s")},
    "accelerometer": {"white": ("m/s^2/sqrt(Hz)", "ug/sqrt(Hz)"), "walk": ("m/s^2/sqrt(s)", "ug/sqrt(s)"),
                      "size": ("m/s^2", "ug")},
}  # fmt: skip


def filter_text(found: FilterSettings) -> str:
    """Return budgets, what is not in them, settings, and remarks."""
    parts = [_budget(one) for one in found.budgets]
    parts += [f"# {target}\n{clean_block(str(block))}" for target, block in found.blocks.items()]
    remarks = "\n".join(remarks_text([one.to_dict() for one in found.remarks]))
    return "\n\n".join(part for part in (*parts, remarks) if part)


def clean_block(text: str) -> str:
    """Return a text of several lines without what a terminal could take for a command."""
    return "\n".join(clean(line) for line in text.splitlines())


def _cells(budget: Budget, what: str, values: Any) -> tuple[list[str], str]:
    inside, shown = SHOWN[budget.kind][what if what in ("white", "walk") else "size"]
    return [number(float(one), DIGITS) for one in values * factor(inside, shown)], shown


def _row(budget: Budget, line: Line) -> list[str]:
    cells, unit = _cells(budget, line.carried, line.size)
    times = "" if line.time is None else f"t_c {number(float(line.time[0]), DIGITS)} s"
    return [f"  {line.source}", WORDS[line.carried], *cells, unit, "; ".join(one for one in (line.how, times) if one)]


def _budget(budget: Budget) -> str:
    """Return the budget of a sensor as a table, its totals, and by how much they exceed the bare figures."""
    axes = list(budget.axes)
    rows = [_row(budget, line) for line in budget.lines]
    totals = (("white", "total", "white", budget.white), ("walk", "total, as one walk", "walk", budget.drive),
              ("start", "total", "start", budget.start))  # fmt: skip
    for carried, name, what, values in totals:
        cells, unit = _cells(budget, what, values)
        rows.append([f"  {name}", WORDS[carried], *cells, unit, ""])
    bare = budget.inflation
    for name, word in (("white", "white noise"), ("drive", "random walk")):
        if np.any(np.isfinite(bare[name])):
            cells = [number(float(one), DIGITS) if np.isfinite(one) else "" for one in bare[name]]
            rows.append(["  over the figure at rest", word, *cells, "times", ""])
    places = range(2, 2 + len(axes))
    text = aligned(rows, ("  source", "carried as", *axes, "unit", "how"), places)
    gone = [wrapped(f"  not counted: {clean(one)}") for one in budget.not_counted]
    return "\n".join([f"{budget.kind}", text, *gone])


def filter_content(found: FilterSettings) -> dict[str, Any]:
    """Return what ``--json`` has: budgets in SI, matrices of each axis, settings."""
    budgets = []
    for budget in found.budgets:
        dt = 1.0 / found.sample_rate if found.sample_rate else None
        spaces = []
        for i, axis in enumerate(budget.axes):
            space = None if dt is None else budget.state_space(i, dt)
            spaces.append({"axis": axis} if space is None or space.F is None or space.Q is None else {
                "axis": axis, "dt": dt, "states": list(space.names), "F": space.F.tolist(), "Q": space.Q.tolist(),
                "Phi": space.Phi.tolist(), "Qd": space.Qd.tolist(), "start": budget.start[i].item(),
            })  # fmt: skip
        inflation = {name: [_number(one) for one in values] for name, values in budget.inflation.items()}
        budgets.append({
            "sensor": budget.kind, "axes": list(budget.axes), "unit": budget.unit,
            "lines": [{"source": one.source, "carried": one.carried, "size": one.size.tolist(), "how": one.how,
                       "time": None if one.time is None else one.time.tolist()} for one in budget.lines],
            "white": budget.white.tolist(), "drive": budget.drive.tolist(), "start": budget.start.tolist(),
            "inflation": inflation, "not_counted": list(budget.not_counted), "state_space": spaces,
        })  # fmt: skip
    filters = {
        target: {"text": block.text, "cannot_hold": list(block.cannot_hold), "missing": list(block.missing)}
        for target, block in found.blocks.items()
    }
    return {"inputs": list(found.inputs), "remarks": [one.to_dict() for one in found.remarks],
            "budgets": budgets, "filters": filters}  # fmt: skip


def _number(value: Any) -> float | None:
    return float(value) if np.isfinite(value) else None

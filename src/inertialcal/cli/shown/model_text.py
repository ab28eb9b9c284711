"""A model as text: in words, then every coefficient with all its digits."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from ...campaign.compare.compare import HEADS, JUDGED, Comparison, is_beside, is_shown, line, not_compared, rule_lines
from ...campaign.models.flight_replay import FlightReplay
from ...core.results import finite, key_of
from ...core.show.rounding import dof, number, settled, settled_number, settled_u, with_uncertainty
from ...core.show.rows import names_of, reason_text
from ...core.units import factor
from ...sensors.flight import Step
from ...sensors.model.sensor_model import SensorModel, show
from ...sensors.orbit_check import DwellCheck, OrbitCheck, band_holds
from .output import clean, table, wrapped
from .summary import remarks_text

NAMED = 3  # recordings of a replay; more are counted
TOO_NARROW = (
    "fewer runs lie in the stated band than 95 % intervals let expect: what is not counted, below, moves the readings "
    "by more than u says"
)


def model_text(model: SensorModel, rows: Sequence[Mapping[str, Any]]) -> str:
    """Return what ``show`` prints.

    Parameters
    ----------
    model : SensorModel
        What to show.
    rows : sequence of mapping
        Its parameters, as rows of results.
    """
    heads = ["  name", "value", "u", "unit", "dof", "from"]
    cells = [
        [
            f"  {key_of(row)}",
            repr(row["value"]),
            "-" if row["u"] is None else settled_u(row["u"]),
            row["unit"],
            "" if row["u"] is None else dof(row["dof"]),
            "; ".join(text for text in (row["test"], reason_text(row)) if text),
        ]
        for row in rows
    ]
    return f"{show(model)}\n\nCoefficients, all digits\n{table(cells, heads, right=(1, 2))}"


def steps_text(steps: Sequence[Step], axes: Sequence[str]) -> str:
    """Return a calculation step by step: a line a step, its groups with a head."""
    cells: list[list[str]] = []
    for before, one in zip((None, *steps), steps, strict=False):
        if before is None or before.group != one.group:
            cells.append([one.group, *("" for _ in axes), ""])
        cells.append([f"  {one.name}", *(f"{value:.{one.decimals}f}" for value in one.values), one.unit])
    return table(cells, ["", *axes, "unit"], right=range(1, len(axes) + 1))


def flight_text(found: FlightReplay) -> str:
    """Return flight C beside compensation, on recordings held out."""
    of = f" in {clean(found.condition)}" if found.condition else ""
    written = f"flight C of the model{of}, written to {clean(found.folder.name)} there"
    if found.reason:
        return wrapped(f"{written}; not replayed: {found.reason}")
    more = len(found.recordings) - NAMED
    on = ", ".join(clean(one) for one in found.recordings[:NAMED]) + (f" and {more} more" if more > 0 else "")
    flags = f"; {found.flagged} more raise a flag" if found.flagged else ""
    heads = ["  axis", "compensate", "flight C", "largest difference", "proved bound", "unit"]
    arrays = (found.compensated, found.flown, found.largest, found.bound)
    cells = [
        [f"  {clean(axis)}", f"{one:.7f}", f"{other:.7f}", number(largest, 3), number(bound, 3), found.unit]
        for axis, one, other, largest, bound in zip(found.axes, *map(np.asarray, arrays), strict=True)
    ]
    said = f"{written}; compiled, and replayed on {on}: {found.rows} readings{flags}; means, and how they differ"
    return f"{wrapped(said)}\n{table(cells, heads, right=range(1, 5))}"


def orbit_text(check: OrbitCheck, condition: str, dwells: Sequence[DwellCheck] = ()) -> str:
    """Return whether each axis sees the rate of an orbit and that of the earth."""
    unit = "deg/s"
    rate, u = (value * factor("rad/s", unit) for value in (check.rate.values[0], check.rate.u[0]))
    earth, u_earth = (float(value * factor("rad/s", unit)) for value in (check.earth.values[0], check.earth.u[0]))
    where = (
        ""
        if check.latitude is None
        else f", upright at latitude {number(check.latitude * factor('rad', 'deg'), 4)} deg"
    )
    said = with_uncertainty(earth, u_earth) if u_earth else number(earth, 4)
    reads = "with its vertical part" if where else "in full, as along an axis that points to the pole"
    cells = [
        [
            f"  {one.axis}", "less rest" if one.zero_reference else "direct",
            *(settled_number(size * factor("rad/s", unit), 3) if math.isfinite(size) else "not known"
              for size in (one.u, one.half)),
            _seen(one.orbit_seen, one.orbit_ratio),
            _seen(one.earth_seen, one.earth_ratio),
        ]
        for one in check.checks
    ]  # fmt: skip
    heads = ["  axis", "reading", f"u [{unit}]", "95 % ±", "orbit (rate / ±)", "earth (rate / ±)"]
    lines = [
        *([wrapped(f"Model of condition {condition}")] if condition else []),
        f"Circular orbit at {number(check.altitude / 1e3)} km: {with_uncertainty(float(rate), float(u))} {unit}",
        f"Earth: {said} {unit}{where}",
        f"Mean over {number(check.averaging)} s:",
        table(cells, heads, right=(2, 3)),
        wrapped(
            "A rate is seen if the 95 % interval of a compensated reading does not hold zero, at the model's reference "
            f"conditions, settled and weightless; the earth's counts {reads}."
        ),
        *_dwells(dwells, unit),
    ]
    return "\n".join([*lines, *(wrapped(f"not counted: {clean(one)}", "    ") for one in check.not_counted)])


def _dwells(dwells: Sequence[DwellCheck], unit: str) -> list[str]:
    """Return dwells held out beside the stated band: a line an axis."""
    if not dwells:
        return ["Recorded: no rate-table dwells held out judge this model"]
    if not any(one.dwells for one in dwells):
        return ["Recorded: no dwell held out at a rate near the orbit's (within a factor of 1.5)"]
    k = factor("rad/s", unit)
    cells = [
        [
            f"  {one.axis}", str(one.dwells),
            settled(one.error * k, None if one.u is None else one.u * k) if one.dwells else "no dwell",
            f"± {settled_number(one.band * k, 3)}" if math.isfinite(one.band) else "not known",
            f"{one.inside} of {one.runs}" if math.isfinite(one.band) else "-",
        ]
        for one in dwells
    ]  # fmt: skip
    heads = ["  axis", "dwells", f"mean error [{unit}]", f"stated band [{unit}]", "runs inside"]
    title = "Recorded: dwells held out near the orbit's rate (within a factor of 1.5), compensated less table and earth"
    shown = [wrapped(title), table(cells, heads, right=(1, 2, 3))]
    return shown if band_holds(dwells) else [*shown, wrapped(f"warning: {TOO_NARROW}", "    ")]


def _seen(seen: bool, ratio: float) -> str:
    return f"{'seen' if seen else 'not seen'} ({settled_number(ratio, 3)})" if math.isfinite(ratio) else "not known"


def orbit_dict(check: OrbitCheck, condition: str, dwells: Sequence[DwellCheck] = ()) -> dict[str, Any]:
    """Return the same as ``--json`` prints it [rad/s]."""
    axes = [
        {
            "axis": one.axis, "zero_reference": one.zero_reference, "u": finite(one.u), "dof": finite(one.dof),
            "half_interval": finite(one.half), "orbit_ratio": finite(one.orbit_ratio),
            "orbit_seen": one.orbit_seen, "earth_ratio": finite(one.earth_ratio), "earth_seen": one.earth_seen,
        }
        for one in check.checks
    ]  # fmt: skip
    return {
        "condition": condition, "altitude": check.altitude, "rate": float(check.rate.values[0]),
        "u_rate": float(check.rate.u[0]), "earth_rate": float(check.earth.values[0]),
        "u_earth_rate": float(check.earth.u[0]), "latitude": check.latitude, "unit": "rad/s",
        "averaging": check.averaging, "axes": axes, "not_counted": list(check.not_counted),
        "dwells": [asdict(one) | {"error": finite(one.error), "band": finite(one.band)} for one in dwells],
        "band_holds": band_holds(dwells),
    }  # fmt: skip


def comparison_text(found: Comparison) -> str:
    """Return what ``compare`` prints."""
    reasons = [wrapped(f"  {reason}", "    ") for reason in not_compared(found.differences)]
    blocks = [_figures(found), *reasons, *_beside(found)]
    blocks += list(remarks_text([remark.to_dict() for remark in found.remarks]))
    blocks += [wrapped(line) for line in rule_lines(found.rule)]
    if found.verdict:
        blocks.append(f"overall: {found.verdict}")
    return "\n".join(block for block in blocks if block)


def _figures(found: Comparison) -> str:
    """One block a test."""
    compared = [one for one in found.differences if is_shown(one)]
    judged = any(one.no_change is not None for one in compared)
    blocks = []
    for test in dict.fromkeys(one.row.test for one in compared) if found.kind == "results" else [None]:
        lines = [line(one, judged) for one in compared if test is None or one.row.test == test]
        lines = [[f"  {name}", *cells] for name, *cells in lines]
        heads = [f"  {HEADS[0]}", *HEADS[1:], *(JUDGED if judged else ())]
        blocks.append((f"{wrapped(test)}\n" if test else "") + table(lines, heads))
    return "\n\n".join(blocks) or "nothing could be compared"


def _beside(found: Comparison) -> list[str]:
    left_out = [one.row.case for one in found.differences if is_beside(one) and not is_shown(one)]
    names = names_of(list(dict.fromkeys(left_out)))
    said = f"  left out: {len(left_out)} figures beside the result ({names}); --json has them"
    return [wrapped(said, "    ")] if left_out else []

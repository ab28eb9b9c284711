"""Latitude, and dwells held out near the rate of an orbit, from the results of a campaign."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ...core.units import factor, parse_quantity
from ...sensors.orbit_check import DwellCheck, OrbitCheck, dwell_check


def site_latitude(results: Mapping[str, Any] | None, given: str | None) -> tuple[float | None, float]:
    """Return the latitude with its standard uncertainty [rad]: as given, else that of the campaign."""
    if given is not None:
        return parse_quantity(given).to("rad"), 0.0
    stated = None if results is None else results["site"]["latitude"]
    if results is None or stated is None:
        return None, 0.0
    known = results["influences"].get("site.latitude")
    u = 0.0 if known is None else float(known["u"]) * factor(known["unit"], "rad")
    return parse_quantity(str(stated)).to("rad"), u


def dwells_near(results: Mapping[str, Any] | None, check: OrbitCheck, condition: str) -> list[DwellCheck]:
    """Return the dwells that the closed loop of a condition judged, near the orbit's rate, axis by axis."""
    if results is None:
        return []
    tests = {step["test"] for step in results["sequence"]}
    models = {row["test"] for row in results["results"] if row["test"] not in tests and row["condition"] == condition}
    found = []
    for curve in results.get("curves", ()):
        if curve["name"] == "compensated" and curve["test"] in models:
            columns = curve["columns"]
            applied, error = (
                np.array(columns[name]["values"], dtype=float) * factor(columns[name]["unit"], "rad/s")
                for name in ("applied", "compensated_error")
            )
            found.append(dwell_check(check, curve["axis"], applied, error, columns["run"]["values"]))
    return found

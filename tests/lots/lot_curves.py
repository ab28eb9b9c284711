"""Curves of a lot as its figures take them, made by hand."""

from __future__ import annotations

from typing import Any


def _curve(name: str, finding: str, unit_of: dict[str, str], **columns: list[Any]) -> dict[str, Any]:
    found = {key: {"unit": unit_of.get(key, ""), "values": values} for key, values in columns.items()}
    return {"name": name, "test": "rate", "axis": "x", "of": "scale factor error x", "condition": "",
            "finding": finding, "columns": found}  # fmt: skip


PERCENT = dict.fromkeys(("from", "to", "lower", "upper", "value", "offset", "u", "allowed", "mean", "low", "high"), "%")
DISTRIBUTION = _curve(
    "lot_distribution", "rate, scale factor error x: mean 0.10 %", PERCENT, **{"from": [-0.2, 0.0, 0.2]},
    to=[0.0, 0.2, 0.4], units=[3.0, 8.0, 2.0], lower=[-0.8, None, None], upper=[0.8, None, None],
)  # fmt: skip
POPULATION = _curve("lot_population", "", PERCENT, value=[-0.5, 0.1, 0.7], units=[0.1, 7.5, 0.1])
STATIONS = _curve(
    "lot_stations", "station B is off", PERCENT, level=["A", "B", "C"], units=[10.0, 11.0, 9.0],
    offset=[0.01, 0.4, -0.01], u=[0.02, 0.02, 0.03], allowed=[0.05, 0.05, 0.06], off=[False, True, False],
)  # fmt: skip
ALONG = _curve(
    "lot_along", "no drift along the lot", PERCENT | {"place": "day"}, place=[0.0, 1.0, 2.0], mean=[0.1, 0.12, 0.09],
    u=[0.02, 0.02, 0.02], low=[-0.2, -0.1, -0.2], high=[0.4, 0.5, 0.4],
)  # fmt: skip
DISTANCE = _curve("lot_distance", "1 of 4 tests are of units of another kind", {}, number=[1.0, 2.0, 3.0, 4.0],
                  distance=[0.8, 1.2, 31.0, 0.4], limit=[4.0] * 4, odd=[False, False, True, False])  # fmt: skip
CURVES = [DISTRIBUTION, POPULATION, STATIONS, ALONG, DISTANCE]

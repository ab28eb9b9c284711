"""Curves of an archive as its figures take them, made by hand."""

from __future__ import annotations

from typing import Any


def _curve(name: str, of: str, finding: str, units: dict[str, str], **columns: list[Any]) -> dict[str, Any]:
    found = {key: {"unit": units.get(key, ""), "values": values} for key, values in columns.items()}
    return {"name": name, "test": "rate", "axis": "x", "of": of, "condition": "", "finding": finding, "columns": found}


PERCENT = dict.fromkeys(
    ("value", "half", "low", "high", "mean", "lower", "upper", "spread", "spread_lower", "spread_upper"), "%"
)
HISTORY = _curve(
    "archive_history", "scale factor error x", "scale factor error x: 0.02 %/year, drift", PERCENT,
    year=[2020.5, 2021.5, 2022.5], value=[0.1, 0.12, 0.14], half=[0.01, 0.02, 0.01],
    low=[0.04] * 3, high=[0.24] * 3,
)  # fmt: skip
LINE = _curve("archive_line", "scale factor error x", "", PERCENT, year=[2020.5, 2024.5], value=[0.1, 0.18],
              half=[0.01, 0.03])  # fmt: skip
TREND = _curve(
    "archive_trend", "bias x", "bias x: 1 signal", PERCENT, unit=["A", "B", "C", "D"], value=[1.0, 1.1, 0.9, 2.0],
    mean=[1.25] * 4, lower=[0.5] * 4, upper=[1.9] * 4, signal=[False, False, False, True],
    spread=[None, 0.1, 0.2, 1.1], spread_lower=[0.0] * 4, spread_upper=[1.5] * 4,
)  # fmt: skip
CURVES = [HISTORY, LINE, TREND]

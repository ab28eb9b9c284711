"""Standards: as stated, and the missing ones that would matter to some test."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from inertialcal.campaign.engine.run import run
from ran_campaigns import Ran


def listed(rows: list[dict[str, Any]]) -> dict[str, dict[str, Any]]:
    return {f"{row['standard']}.{row['influence']}": row for row in rows}


def test_missing_standards_that_apply_are_listed(published: Ran) -> None:
    rows = listed(published.results["standards"])
    assert set(rows) == {"rate_table.rate", "converter.reference", "site.latitude"}  # one axis a test: no mounting
    for row in rows.values():
        assert (row["stated"], row["u"], row["dof"], row["certificate"]) == (False, None, None, "")
        assert row["effect"]
    missing = next(r for r in published.results["remarks"] if r["code"] == "relative_to_fixture")
    for name in ("rate_table.rate", "converter.reference"):
        assert f"{name} ({rows[name]['effect']})" in missing["what"]


def test_stated_standards_stand_as_stated(simulated: Ran) -> None:
    rows = listed(simulated.results["standards"])
    assert [(name, row["u"], row["unit"]) for name, row in rows.items()] == [
        ("rate_table.rate", 0.03, "%"),
        ("rate_table.mounting", 0.001, "rad"),
        ("converter.reference", 0.01, "%"),
        ("site.latitude", 0.0001, "rad"),
    ]
    assert all(row["stated"] and row["certificate"] == "simulated" for row in rows.values())


def test_stated_and_missing_ones_stand_together(campaign: Callable[..., Path]) -> None:
    certificate = 'rate = { u = "0.05 %", certificate = "C-1" }'
    other = 'rate = { expanded = "0.2 %", k = 2, dof = 9, certificate = "C-2" }'
    rows = listed(run(campaign((certificate, other)), write=False).results["standards"])
    assert set(rows) == {"rate_table.rate", "converter.reference"}
    rate = rows["rate_table.rate"]
    assert (rate["u"], rate["unit"], rate["dof"], rate["certificate"]) == (pytest.approx(0.1), "%", 9.0, "C-2")
    assert not rows["converter.reference"]["stated"]

"""Large records are analysed side by side: figures and remarks do not depend on the number of cores, to the bit."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import inertialcal as ic
from inertialcal.core.estimate import Array
from inertialcal.signals import threads


def disturbed(kind: str) -> Array:
    x = np.random.default_rng(1).normal(size=threads.LARGE)
    if kind == "glitch":  # left out by the screening
        x[1234] = 900.0
    if kind == "bump":  # left out behind it
        x[300_000:302_000] += 20.0
    if kind == "missing":
        x[5_000:5_100] = np.nan
    return x


def shown(found: Any) -> list[Any]:
    return [row.to_dict() for row in found.rows] + [one.to_dict() for one in found.remarks]


@pytest.mark.parametrize("kind", ["clean", "glitch", "bump", "missing"])
def test_cores_change_nothing(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    x, found = disturbed(kind), []
    for cores in (1, 2, 3):
        monkeypatch.setattr(threads, "cores", lambda number=cores: number)
        assert threads.pays(len(x)) == (cores > 1)
        found.append(shown(ic.allan(x, sample_rate=100.0)))
    assert found[0] == found[1] == found[2]
    codes = {one["code"] for one in found[0] if "code" in one}
    assert kind == "clean" or {"glitch": "glitch", "bump": "disturbed", "missing": "gaps"}[kind] in codes

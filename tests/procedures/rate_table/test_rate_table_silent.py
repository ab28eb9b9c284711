"""A gyro that reads nothing of its own rate: its bias alone is estimated, and no model is made."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from independent.case import Table
from independent.rate_table import reduced
from independent.trial import called

Y = "gy [deg/s]"
RATIOS = {"scale_factor_error", "scale_factor_asymmetry", "second_order", "third_order", "misalignment"}
NEEDS_RESPONSE = RATIOS | {"cross_axis_sensitivity", "linearity_error"}
Spoil = Callable[[Table], None]


def stuck(table: Table) -> None:
    table.columns[Y] = np.full(len(table), 0.3)


def dead(table: Table) -> None:
    table.columns[Y] = 0.3 + 0.001 * np.random.default_rng(1).standard_normal(len(table))


def wired_to_x(table: Table) -> None:
    table.columns[Y] = table.columns["gx [deg/s]"].copy()


@pytest.mark.parametrize("spoil", [stuck, dead, wired_to_x])
def test_a_gyro_that_does_not_read_its_rate_has_a_bias_alone(spoil: Spoil, tmp_path: Path) -> None:
    case = reduced(1)
    spoil(case.tables["table.csv"])
    found = called(case.write(tmp_path), tmp_path)
    assert found.codes["gain_disagrees"]
    assert found.exit == 4
    assert not found.model
    (results,) = tmp_path.rglob("results.json")
    rows = [one for one in json.loads(results.read_text(encoding="utf-8"))["results"] if one["method"] == "result"]
    of_y = [one for one in rows if one["axis"].startswith("y")]
    lost = [one for one in of_y if one["quantity"] in NEEDS_RESPONSE]
    assert {one["quantity"] for one in lost} == NEEDS_RESPONSE
    assert all(one["value"] is None and one["reason"]["code"] == "no_response" for one in lost)
    assert [one["quantity"] for one in of_y if one["quantity"] == "bias" and one["value"] is not None]
    of_x = {one["quantity"] for one in rows if one["axis"] == "x" and one["value"] is not None}
    assert {"bias", "scale_factor_error", "second_order"} <= of_x

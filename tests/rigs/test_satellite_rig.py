"""The rig of a satellite: its motion is what its rates say, its campaign holds the truth, each mistake is named."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import inertialcal as ic
from inertialcal.campaign.twins.twin import simulate
from inertialcal.core.errors import InertialcalError
from inertialcal.rigs.satellite import rig

pytest.importorskip("ppigrf")


def found(folder: Path, seed: int, fault: str = "") -> set[str]:
    """Return codes of what the run of a twin says."""
    simulate("satellite", folder, seed, fault)
    try:
        result = ic.run(folder, write=False)
    except InertialcalError as error:
        return {one.code for one in error.problems}
    return {one["code"] for one in result.results["remarks"]}


def test_rates_are_those_of_the_motion() -> None:
    time = np.arange(0.0, 60.0, 0.01)
    attitude, rates = rig._motion(time, np.random.default_rng(1))
    step = (attitude[2:] - attitude[:-2]) / 0.02
    spin = -step @ np.transpose(attitude[1:-1], (0, 2, 1))  # [w x] of axes that turn
    turned = np.column_stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]])
    assert np.max(np.abs(turned - rates[1:-1])) < 1e-9


@pytest.mark.parametrize("fault", rig.FAULTS)
def test_each_mistake_is_named(fault: str, tmp_path: Path) -> None:
    assert rig.FAULTS[fault].shows in found(tmp_path / fault, 3, fault)


def test_sound_orbits_bring_no_remark(tmp_path: Path) -> None:
    wrong = {one.shows for one in rig.FAULTS.values()}
    for seed in (1, 2):
        assert not found(tmp_path / str(seed), seed) & wrong

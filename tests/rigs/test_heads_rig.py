"""The rig of heads on one satellite: each mistake is named, sound records bring none of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import inertialcal as ic
from independent.orbit.heads import GM, RADIUS
from inertialcal.campaign.twins.twin import simulate
from inertialcal.core.errors import InertialcalError
from inertialcal.physics.motion.rigid import centripetal, cross, gradient
from inertialcal.rigs.heads import rig


def found(folder: Path, seed: int, fault: str = "") -> set[str]:
    """Return codes of what the run of a twin says."""
    simulate("heads", folder, seed, fault)
    try:
        result = ic.run(folder, write=False)
    except InertialcalError as error:
        return {one.code for one in error.problems}
    return {one["code"] for one in result.results["remarks"]}


def test_a_place_feels_its_motion() -> None:
    rng = np.random.default_rng(3)
    rate, speeding, place = rng.normal(size=(3, 3))
    by_matrix = (cross(speeding) + centripetal(np.outer(rate, rate))) @ place
    assert by_matrix == pytest.approx(np.cross(speeding, place) + np.cross(rate, np.cross(rate, place)))
    middle, off = np.array([RADIUS, 0.0, 0.0]), np.array([2.0, 1.0, -1.0])
    there = middle + off
    pull = -GM * (there / np.linalg.norm(there) ** 3 - middle / RADIUS**3)
    assert gradient(np.sqrt(GM / RADIUS**3), np.array([1.0, 0.0, 0.0])) @ off == pytest.approx(pull, rel=1e-5)


@pytest.mark.parametrize("fault", ["exchanged", "moved"])
def test_a_mistake_is_named(fault: str, tmp_path: Path) -> None:
    assert found(tmp_path / fault, 3, fault) & set(rig.FAULTS[fault].codes)


@pytest.mark.slow
@pytest.mark.parametrize("fault", rig.FAULTS)
def test_each_mistake_is_named(fault: str, tmp_path: Path) -> None:
    assert found(tmp_path / fault, 2, fault) & set(rig.FAULTS[fault].codes)


def test_sound_records_bring_no_remark(tmp_path: Path) -> None:
    wrong = {code for one in rig.FAULTS.values() for code in one.codes}
    assert not found(tmp_path / "sound", 1) & wrong

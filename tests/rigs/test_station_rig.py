"""The rig of a head in a station: its campaign holds the truth, each mistake is named."""

from __future__ import annotations

from pathlib import Path

import pytest

import inertialcal as ic
from inertialcal.campaign.twins.score import score
from inertialcal.campaign.twins.twin import simulate
from inertialcal.core.errors import InertialcalError
from inertialcal.rigs.station import rig


def found(folder: Path, seed: int, fault: str = "") -> set[str]:
    """Return codes of what the run of a twin says."""
    simulate("station", folder, seed, fault)
    try:
        result = ic.run(folder, write=False)
    except InertialcalError as error:
        return {one.code for one in error.problems}
    return {one["code"] for one in result.results["remarks"]}


@pytest.mark.parametrize(
    "fault", ["glitches", "wrong_unit", *(pytest.param(one, marks=pytest.mark.slow) for one in rig.FAULTS
                                          if one not in ("glitches", "wrong_unit"))]
)  # fmt: skip
def test_each_mistake_is_named(fault: str, tmp_path: Path) -> None:
    assert rig.FAULTS[fault].shows in found(tmp_path / fault, 3, fault)


def test_a_sound_record_brings_no_remark_and_holds_the_truth(tmp_path: Path) -> None:
    wrong = {one.shows for one in rig.FAULTS.values()}
    assert not found(tmp_path / "sound", 1) & wrong
    ic.run(tmp_path / "sound")
    assert all(one["inside"] for one in score(tmp_path / "sound").rows)

"""The rig of an alignment: each mistake is named, sound records bring none of them and hold the truth."""

from __future__ import annotations

from pathlib import Path

import pytest

import inertialcal as ic
from independent.coverage import keeps
from inertialcal.campaign.twins.score import score
from inertialcal.campaign.twins.twin import simulate
from inertialcal.core.errors import InertialcalError
from inertialcal.rigs.alignment import rig
from sized import sized


def found(folder: Path, seed: int, fault: str = "") -> set[str]:
    """Return codes of what the run of a twin says."""
    simulate("alignment", folder, seed, fault)
    try:
        result = ic.run(folder, write=False)
    except InertialcalError as error:
        return {one.code for one in error.problems}
    return {one["code"] for one in result.results["remarks"]}


@pytest.mark.parametrize("fault", ["south", "coarse"])
def test_a_mistake_is_named(fault: str, tmp_path: Path) -> None:
    assert found(tmp_path / fault, 3, fault) & set(rig.FAULTS[fault].codes)


@pytest.mark.slow
@pytest.mark.parametrize("fault", rig.FAULTS)
def test_each_mistake_is_named(fault: str, tmp_path: Path) -> None:
    for seed in (2, 3):
        assert found(tmp_path / f"{fault}_{seed}", seed, fault) & set(rig.FAULTS[fault].codes)


def test_sound_records_bring_no_remark(tmp_path: Path) -> None:
    wrong = {code for one in rig.FAULTS.values() for code in one.codes}
    assert not found(tmp_path / "sound", 1) & wrong


@pytest.mark.slow
def test_campaigns_hold_their_truth(tmp_path: Path) -> None:
    n = sized(60, 20)
    held, count = dict[str, int](), dict[str, int]()
    for seed in range(1, n + 1):
        folder = tmp_path / str(seed)
        simulate("alignment", folder, seed)
        ic.run(folder)
        for row in score(folder).rows:
            name = f"{row['quantity']}_{row['axis']}"
            if row["inside"] is not None:
                count[name] = count.get(name, 0) + 1
                held[name] = held.get(name, 0) + bool(row["inside"])
    assert all(keeps("holds", held[name], count[name]) for name in count), (held, count)

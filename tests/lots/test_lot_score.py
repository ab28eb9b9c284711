"""A simulated lot, its results against its truth: coverage, the population, mistakes named; what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import inertialcal as ic
from inertialcal.core.errors import InertialcalError
from inertialcal.lots import twin
from inertialcal.lots.lot_file import load_lot
from inertialcal.lots.score import LotScore
from inertialcal.lots.twin import line_of, write_lot


def made(root: Path, n: int, fault: str = "", seed: int = 1) -> LotScore:
    """Simulate a lot, reduce it, score it."""
    write_lot(root / "lot", line_of(n, fault), seed)
    ic.lot(root / "lot", root / "out", workers=0, report=False)
    found = ic.score(root / "out")
    assert isinstance(found, LotScore)
    return found


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, LotScore]:
    """A lot of short records."""
    root = tmp_path_factory.mktemp("scored")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(twin, "STILL", 1_000)
        patch.setattr(twin, "RAMP", 100)
        return root, made(root, 6, "lost_file=0.5", 1)


def test_intervals_of_units_are_judged_apart_from_their_station(small: tuple[Path, LotScore]) -> None:
    _, found = small
    assert {one.figure[1] for one in found.held} == {
        "bias", "bias_temperature", "scale_factor_error", "misalignment", "angle_random_walk"
    }  # fmt: skip
    assert sum(one.apart for one in found.held) >= 0.8 * sum(one.n for one in found.held)
    assert found.verdict == "PASS"
    assert "hold the truth" in str(found)
    assert json.loads(json.dumps(found.to_dict()))["units"] == 6


def test_a_mistake_is_named_and_its_tests_are_not_counted(small: tuple[Path, LotScore]) -> None:
    _, found = small
    (lost,) = found.found
    assert lost.mistake == "lost_file"
    assert lost.put_in == lost.named != ()
    assert all(one.n <= 6 - len(lost.put_in) for one in found.held)


def test_a_folder_with_a_lot_is_that_lot(small: tuple[Path, LotScore]) -> None:
    root, _ = small
    assert load_lot(root / "lot").digest() == load_lot(root / "lot" / "LOT.toml").digest()
    assert len(load_lot(root / "lot").units) == 6


def test_what_cannot_be_scored_is_said(small: tuple[Path, LotScore]) -> None:
    root, _ = small
    truth = root / "lot" / ".truth" / "truth.json"
    whole = truth.read_bytes()

    def code(folder: str = "out") -> str:
        with pytest.raises(InertialcalError) as error:
            ic.score(root / folder)
        assert error.value.exit_status == 3
        return error.value.problems[0].code

    try:
        assert code("lot") == "no_results"
        truth.write_bytes(whole.replace(b"0.1", b"0.2", 1))
        assert code() == "seal_broken"
        truth.unlink()
        assert code() == "no_truth"
    finally:
        truth.write_bytes(whole)


@pytest.mark.slow
def test_a_lot_of_every_mistake_and_a_sound_one(tmp_path: Path) -> None:
    found = made(
        tmp_path / "all", 100, "bad_station=20 odd_units=0.03 stuck_axis=0.02 lost_file=0.02 drift understated"
    )
    assert found.verdict == "PASS", str(found)
    assert [one.mistake for one in found.found if one.beside] == []
    sound = made(tmp_path / "sound", 60, "", 3)
    assert (sound.verdict, sound.found, sound.beside) == ("PASS", (), ())
    assert sum(one.inside for one in sound.population) >= 0.8 * len(sound.population)

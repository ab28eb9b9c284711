"""The list of mutants fits the tree, and its runner sees a test fail. All of them are run by `make mutants`."""

from __future__ import annotations

from pathlib import Path

import pytest

from mutants import MUTANTS, ROOT, SOURCE, Worker

NUMERICAL = {
    "core": 4, "statistics": 20, "signals": 20, "physics": 12, "sensors": 15, "rigs": 5, "procedures/flip": 5,
    "procedures/rate_table": 5, "procedures/thermal": 5, "procedures/positions": 8, "procedures/mass_attraction": 5,
    "procedures/static_noise": 2, "procedures/sine": 2,
}  # fmt: skip  # folders, and how many mutants each has at least


def test_every_mutant_stands_in_one_place_and_has_its_tests() -> None:
    missing = []
    for mutant in MUTANTS:
        try:
            mutant.place()
            assert mutant.test_files(), mutant.words
        except LookupError as error:
            missing.append(str(error))
        assert mutant.old != mutant.new, mutant.words
    assert not missing, "\n".join(missing)


def test_no_mutant_is_twice_in_the_list() -> None:
    assert len({(one.file, one.old, one.new) for one in MUTANTS}) == len(MUTANTS)


def test_every_numerical_folder_has_mutants() -> None:
    places = [mutant.place() for mutant in MUTANTS]
    there = {folder: sum(place.is_relative_to(SOURCE / folder) for place in places) for folder in NUMERICAL}
    assert not {folder: there[folder] for folder, least in NUMERICAL.items() if there[folder] < least}


@pytest.mark.slow
def test_the_runner_sees_a_mutant_caught_and_puts_the_file_back(tmp_path: Path) -> None:
    number = next(k for k, one in enumerate(MUTANTS) if one.tests == "test_quantiles")
    worker = Worker(tmp_path / "copy")
    try:
        assert worker.verdict(number).startswith("caught by test_quantiles.py")
    finally:
        worker.close()
    place = MUTANTS[number].place()
    assert (tmp_path / "copy" / place).read_bytes() == (ROOT / place).read_bytes()

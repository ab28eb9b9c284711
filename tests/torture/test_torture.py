"""The first trials of `make torture`, and the special inputs that take no gigabytes to refuse."""

from __future__ import annotations

from pathlib import Path

import pytest
from forked import warm

from sized import sized
from torture import judged_trial, seeds_in

pytestmark = pytest.mark.usefixtures("drawn_anew")  # figures that are kept would be writes outside
FEW = 8
SOME = sized(400, 100)  # with `make slow`; `make torture` has 5,000


@pytest.fixture(scope="module")
def seeds(undrawn: None, tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = seeds_in(tmp_path_factory.mktemp("torture"))
    warm()
    return made


def failed(numbers: range, seeds: Path, folder: Path) -> list[str]:
    judged = [judged_trial(number, seeds, folder / "trial") for number in numbers]
    return [f"{one.number} {one.words}: {one.failures}" for one in judged if one.failures]


def test_the_first_trials(seeds: Path, tmp_path: Path) -> None:
    assert failed(range(1, FEW + 1), seeds, tmp_path) == []


@pytest.mark.slow
def test_more_trials(seeds: Path, tmp_path: Path) -> None:
    assert failed(range(FEW + 1, SOME + 1), seeds, tmp_path) == []

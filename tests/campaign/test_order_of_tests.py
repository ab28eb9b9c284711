"""Tests that come after others: each is reduced once what it takes off is known; a ring is refused."""

from __future__ import annotations

from itertools import permutations

import pytest

from inertialcal.campaign.engine.engine import order_of
from inertialcal.campaign.file.schema import CampaignFile
from inertialcal.campaign.file.schema import Test as CampaignTest
from inertialcal.campaign.file.test_checks import after_checks

CHAIN = {"a": [], "b": ["a"], "c": ["b"], "d": []}


def made_of(after: dict[str, list[str]]) -> list[CampaignTest]:
    return [
        CampaignTest(id=name, procedure="thermal", recordings=["r"], after=before) for name, before in after.items()
    ]


@pytest.mark.parametrize("names", list(permutations(CHAIN)))
def test_each_stands_after_what_it_takes_off_however_they_are_written(names: tuple[str, ...]) -> None:
    tests = made_of({name: CHAIN[name] for name in names})
    order = [tests[number].id for number in order_of(tests)]
    assert sorted(order) == sorted(CHAIN)
    assert order.index("a") < order.index("b") < order.index("c")


def test_without_any_they_stay_as_they_are() -> None:
    assert order_of(made_of({"z": [], "y": [], "x": []})) == [0, 1, 2]


def test_a_ring_is_refused() -> None:
    tests = made_of({"a": ["c"], "b": ["a"], "c": ["b"]})
    file = CampaignFile.model_construct(tests=tests, recordings={}, sensors={})
    for number, test in enumerate(tests):
        found = [one.what for one in after_checks(file, number, test, lambda *key: "campaign.toml")]
        assert any("comes after itself" in what for what in found)

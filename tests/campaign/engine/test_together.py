"""Work on many units at once: the same as each alone; what fails in one is its own."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

from inertialcal.campaign.engine.together import Work, alone, ask, together
from inertialcal.core.errors import DataError

ASKED: list[tuple[str, list[int]]] = []


def halves(given: Sequence[int]) -> list[float | Exception]:
    ASKED.append(("halves", list(given)))
    return [DataError(f"{one} is odd") if one % 2 else one / 2 for one in given]


def inverses(given: Sequence[float]) -> list[float]:
    ASKED.append(("inverses", [int(one) for one in given]))
    return [1 / one for one in given]


def work(number: int) -> Work[float]:
    if number < 0:
        return -1.0
    half = yield from ask(halves, number)
    return (yield from ask(inverses, half))


def test_all_are_asked_about_in_one_call_and_none_ends_another() -> None:
    ASKED.clear()
    found = together([work(number) for number in (4, 3, 0, -2, 8)])
    assert found[0] == 0.5
    assert found[3:] == [-1.0, 0.25]
    assert isinstance(found[1], DataError)
    assert isinstance(found[2], ZeroDivisionError)
    # What breaks down on many is asked for each
    assert [("halves", [4, 3, 0, 8]), ("inverses", [2, 0, 4]), *(("inverses", [one]) for one in (2, 0, 4))] == ASKED


def test_one_alone_is_one_of_many() -> None:
    assert alone(work(4)) == 0.5
    assert together([]) == []
    with pytest.raises(DataError, match="3 is odd"):
        alone(work(3))


def test_a_refusal_is_for_the_work_itself_to_explain() -> None:
    def explained() -> Work[str]:
        try:
            yield from ask(halves, 3)
        except DataError as error:
            return str(error)
        return ""

    assert alone(explained()) == "3 is odd"

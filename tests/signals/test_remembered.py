"""What was found of samples before: equal samples give it back, any others are looked at."""

from __future__ import annotations

from collections.abc import Iterator, ValuesView
from dataclasses import dataclass, is_dataclass
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from inertialcal.signals import _kernels
from inertialcal.signals import remembered as module
from inertialcal.signals.remembered import forget, remembered
from inertialcal.signals.screening.screen import _searched, screen
from inertialcal.signals.segmentation.segments import detect
from inertialcal.signals.segmentation.still_stretches import Detection, still_stretches
from inertialcal.signals.sense.changes import changes

ONES = np.ones(12)


@pytest.fixture(autouse=True)
def _nothing_known() -> Iterator[None]:
    forget()
    yield
    forget()


def counted() -> tuple[Any, list[int]]:
    calls: list[int] = []

    @remembered
    def looked_at(*given: object, **more: object) -> tuple[int]:
        calls.append(len(calls))
        return (len(calls),)

    return looked_at, calls


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ((ONES,), (ONES.astype(np.float32),)),
        ((ONES,), (ONES.reshape(3, 4),)),
        ((ONES.view(np.int64),), (ONES,)),
        ((ONES, [ONES]), (ONES, ONES)),
        (([ONES, ONES], [ONES]), ([ONES], [ONES, ONES])),
        (([ONES], ""), ([ONES, ""],)),
        ((ONES[:6], ONES[6:]), (ONES[:5], ONES[5:])),
        ((ONES, "ab", "c"), (ONES, "a", "bc")),
        ((ONES, "1"), (ONES, 1)),
        ((ONES, None), (ONES, 0)),
        ((ONES, 0.1), (ONES, np.nextafter(0.1, 1.0))),
        ((np.array([0.0]),), (np.array([-0.0]),)),
    ],
)
def test_what_differs_is_another_call(one: tuple[object, ...], other: tuple[object, ...]) -> None:
    looked_at, calls = counted()
    for given_now in (one, other, one, other):
        looked_at(*given_now)
    assert len(calls) == 2


@given(st.data())
def test_any_sample_counts_whatever_the_layout(data: st.DataObject) -> None:
    looked_at, calls = counted()
    x = np.random.default_rng(data.draw(st.integers(0, 99))).normal(size=(data.draw(st.integers(1, 40)), 3))
    assert looked_at(x)[0] == looked_at(np.asfortranarray(x))[0] == looked_at(np.repeat(x, 2, axis=0)[::2])[0] == 1
    row, column = data.draw(st.integers(0, len(x) - 1)), data.draw(st.integers(0, 2))
    x[row, column] = np.nextafter(x[row, column], np.inf)  # in place
    assert looked_at(x)[0] == 2
    assert len(calls) == 2


def test_names_of_settings_count() -> None:
    looked_at, calls = counted()
    looked_at(ONES, a=1, b=2)
    looked_at(ONES, a=2, b=1)
    assert len(calls) == 2


def test_long_arrays_and_objects_are_not_remembered(monkeypatch: pytest.MonkeyPatch) -> None:
    looked_at, calls = counted()
    for x in (ONES.astype(object), np.ones(module.LONGEST // 8 + 1)):
        looked_at(x)
        looked_at(x)
    assert len(calls) == 4
    with pytest.raises(TypeError, match="object: nothing that is compared by what it holds"):
        looked_at(object())


def test_the_last_calls_are_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    looked_at, calls = counted()
    monkeypatch.setattr(module, "MOST", 2)
    for k in (0, 1, 0, 2, 0, 1):
        looked_at(k)
    assert len(calls) == 4  # 1 went when 2 came, as 0 had been asked for since


@dataclass(frozen=True)
class Asked:
    size: float
    weights: NDArray[np.float64]


def arrays_in(found: object) -> list[NDArray[Any]]:
    if isinstance(found, np.ndarray):
        return [found]
    parts = vars(found).values() if is_dataclass(found) else found.values() if isinstance(found, dict) else found
    return [x for one in parts for x in arrays_in(one)] if isinstance(parts, list | tuple | ValuesView) else []


@pytest.mark.parametrize("samples", [600, module.LONGEST // 8 + 1])
def test_nobody_writes_into_what_others_get(samples: int) -> None:
    held = {"flat": np.zeros(2), "deep": [(Asked(1.0, np.zeros(3)), np.zeros(4))]}
    looked_at = remembered(lambda x: (held, np.zeros(len(x))))
    x = np.linspace(0.0, 50.0, samples)
    still = x[:600, None] // 30.0
    for found in (looked_at(x), still_stretches(still, None, Detection())):
        for one in arrays_in(found):
            with pytest.raises(ValueError, match="read-only"):
                one[...] = 1
    assert [len(one) for one in arrays_in(looked_at(x))] == [2, 3, 4, samples]
    assert x.flags.writeable


@given(st.integers(0, 999))
def test_a_screening_is_that_of_the_samples_now(seed: int) -> None:
    rng = np.random.default_rng(seed)
    x: NDArray[np.float64] = np.round(rng.normal(size=300), 2)
    x[rng.integers(300)] = 1e3  # sizes are told of findings alone
    for at_rest in (True, False):
        for _ in range(2):
            assert repr(screen(x, at_rest)) == repr(_searched(x, at_rest))
    x[rng.integers(300)] = -1e3
    assert repr(screen(x)) == repr(_searched(x, True))


def test_a_dataclass_is_what_its_fields_hold() -> None:
    looked_at, calls = counted()
    for one in (Asked(1.0, ONES), Asked(1.0, ONES.copy()), Asked(2.0, ONES), Asked(1.0, 2.0 * ONES)):
        looked_at(ONES, one)
    assert len(calls) == 3


def test_stretches_at_rest_are_those_of_the_samples_and_the_plan_now() -> None:
    x = np.random.default_rng(4).normal(size=(600, 3))
    assert len(detect(x)) == 1
    x[300:] += 5.0
    assert len(detect(x)) == 2
    assert len(detect(x, plan=Detection(noise=(5.0, 5.0, 5.0)))) == 1


def test_changes_are_those_of_the_samples_now() -> None:
    rng = np.random.default_rng(3)
    x = 0.2 + rng.normal(0.0, 0.01, (3, 2_000))
    assert changes(list(x), "xyz", "angular_rate", 0.01) == ()
    x[:, 1_000:] *= 180.0 / np.pi
    assert [one.code for one in changes(list(x), "xyz", "angular_rate", 0.01)] == ["unit_changed"]


@pytest.mark.parametrize("samples", [512, 777, 20_000])
def test_any_changed_bit_is_another_array(samples: int) -> None:
    rng = np.random.default_rng(5)
    words = rng.integers(0, 2**63, samples, dtype=np.uint64)
    lanes = np.zeros((200, 8), dtype=np.uint64)
    for own in lanes:
        assert _kernels.fill_mixed(words, own)
        for at in rng.integers(samples, size=2).tolist():  # signs of two numbers, then another bit
            words[at] ^= np.uint64(1) << np.uint64(63)
        words[rng.integers(samples)] ^= np.uint64(1) << np.uint64(rng.integers(64))
    assert len({own.tobytes() for own in lanes}) == len(lanes)
    again = np.zeros(8, dtype=np.uint64)
    _kernels.fill_mixed(words.copy(), again)
    _kernels.fill_mixed(words, lanes[0])
    assert (again == lanes[0]).all()

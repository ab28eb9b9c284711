"""Frozen results as bytes: what comes back equals what went in, to the last bit, and nothing else can come of bytes."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from inertialcal.core.key import At, Key, Method
from inertialcal.core.remarks import Remark
from inertialcal.files.binary.objects import HOUSE, NotStorableError, digest, encode
from inertialcal.files.binary.objects import decode as decoded

PACKAGES = ("inertialcal", __name__.partition(".")[0])
DTYPES = ["<f8", "<f4", "<i8", "u1", "?", "<c16", "<M8[ns]", "<U5"]


def decode(data: bytes | bytearray, packages: tuple[str, ...] = HOUSE) -> Any:
    return decoded(data, packages)


@dataclass(frozen=True, eq=False)
class Held:
    """What holds an array, and works something out of it."""

    data: np.ndarray[Any, Any]
    more: dict[str, Any] = field(default_factory=dict)

    @cached_property
    def total(self) -> float:
        return float(self.data.sum())


SCALARS = st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text()
THINGS = st.recursive(
    SCALARS | st.sampled_from([Key("bias", "x", at=At("temperature", -20.0, "degC")), Method.TEXTBOOK]) | st.binary(),
    lambda inner: st.lists(inner) | st.lists(inner).map(tuple) | st.dictionaries(st.text() | st.integers(), inner),
    max_leaves=20,
)


@given(THINGS)
def test_what_comes_back_is_what_went_in(thing: Any) -> None:
    back = decode(encode(thing))
    assert back == thing
    assert repr(back) == repr(thing)  # types too: 1 is not 1.0


@given(st.sampled_from(DTYPES).flatmap(lambda d: arrays.arrays(d, arrays.array_shapes(min_dims=0, min_side=0))))
def test_arrays_come_back_bit_by_bit(array: np.ndarray[Any, Any]) -> None:
    back = decode(encode(array))
    assert back.dtype == array.dtype
    assert back.shape == array.shape
    assert back.tobytes() == array.tobytes()


def test_order_and_rights_of_arrays_stay() -> None:
    turned = np.asfortranarray(np.arange(6.0).reshape(2, 3))
    turned.flags.writeable = False
    back = decode(encode(turned))
    assert back.flags.f_contiguous
    assert not back.flags.c_contiguous
    assert not back.flags.writeable
    assert decode(encode(np.arange(3.0))).flags.writeable


def test_one_object_in_two_places_is_one_again_and_equal_ones_stay_two() -> None:
    shared, other = np.arange(4.0), np.arange(4.0)
    first, second, third = decode(encode([shared, shared, other]))
    assert first is second
    first[0] = 9.0
    assert third[0] == 0.0
    assert len(encode([shared, other])) < len(encode([shared, np.arange(4.0) + 1.0]))  # the same bytes stand once


def test_what_a_class_works_out_is_left_out() -> None:
    held = Held(np.arange(3.0), {"r": Remark("code", "info", "what")})
    assert held.total == 3.0
    back = decode(encode(held, PACKAGES), PACKAGES)
    assert "total" not in vars(back)
    assert back.total == 3.0
    assert back.more == held.more


def test_kinds_of_python() -> None:
    thing = [slice(1, None, 2), frozenset({3}), {"a"}, MappingProxyType({"k": 1}), np.float32(0.1), float("inf")]
    back = decode(encode(thing))
    assert back[:4] == thing[:4]
    assert [type(one) for one in back] == [type(one) for one in thing]
    assert back[4] == np.float32(0.1)
    assert back[5] == float("inf")


@pytest.mark.parametrize(
    "thing", [object(), lambda: 0, np.array([object()]), open], ids=["object", "function", "array", "open"]
)
def test_what_cannot_be_kept_is_said(thing: object) -> None:
    with pytest.raises(NotStorableError):
        encode([thing])


def test_classes_of_others_are_neither_written_nor_made() -> None:
    held = Held(np.arange(3.0))
    with pytest.raises(NotStorableError):
        encode(held)
    with pytest.raises(ValueError, match="no class"):
        decode(encode(held, PACKAGES))


@given(st.data())
def test_damaged_bytes_give_a_value_error_or_data(data: st.DataObject) -> None:
    whole = bytearray(encode({"a": np.arange(3.0), "k": Key("bias", "x"), "r": Remark("c", "info", "w")}))
    at = data.draw(st.integers(0, len(whole) - 1))
    whole[at] ^= data.draw(st.integers(1, 255))
    cut = data.draw(st.integers(0, len(whole)))
    for one in (whole, whole[:cut]):
        try:
            decode(one)
        except ValueError:
            continue


def painter(data: list[float], factor: float = 1.0) -> Any:
    def paint() -> float:
        return sum(data) * factor

    return paint


def test_functions_count_by_what_they_hold() -> None:
    known = digest(painter([1.0, 2.0]), PACKAGES)
    assert known == digest(painter([1.0, 2.0]), PACKAGES)
    assert known != digest(painter([1.0, 2.5]), PACKAGES)
    assert known != digest(painter([1.0, 2.0], 2.0), PACKAGES)

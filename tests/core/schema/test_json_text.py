"""JSON as files hold it, and in canonical form: byte for byte that of the standard library."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from inertialcal.core.key import Method
from inertialcal.core.schema.checksum import CHECKSUM, checksum, sealed_text, sealed_texts
from inertialcal.core.schema.json_text import (
    MANY,
    Filled,
    Frame,
    Hole,
    json_text,
    json_texts,
    json_texts_many,
    number_texts,
)

PLAIN = st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | st.text()
NUMBERS = st.lists(st.floats(allow_nan=False, allow_infinity=False), max_size=4)
CONTENT = st.recursive(
    PLAIN | NUMBERS,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(), inner, max_size=4) | st.tuples(inner, inner),
    max_leaves=20,
)


def by_standard_library(content: Any) -> tuple[str, str]:
    canonical = json.dumps(content, sort_keys=True, separators=(",", ":"), ensure_ascii=False, allow_nan=False)
    return json_text(content).removesuffix("\n"), canonical


@given(CONTENT)
def test_every_content_is_as_json_writes_it(content: Any) -> None:
    assert json_texts(content) == by_standard_library(content)


@given(st.dictionaries(st.text(), CONTENT, min_size=1, max_size=4))
def test_a_sealed_content_carries_the_checksum_of_its_canonical_form(content: dict[str, Any]) -> None:
    content.pop(CHECKSUM, None)
    assume(content)
    assert sealed_text(content) == json_text({**content, CHECKSUM: checksum(content)})


def test_a_list_that_stands_in_two_places_is_written_as_deep_as_each() -> None:
    row = [0.0, -0.0]
    content = {"a": row, "b": {"c": row, "d": [row, row]}, "e": [0.0, 0.0]}
    assert json_texts(content) == by_standard_library(content)


@given(arrays(float, array_shapes(max_dims=3, max_side=4), elements=st.sampled_from([0.0, -0.0, 0.1, -2e-300, 1e22])))
def test_an_array_is_written_as_the_lists_of_its_numbers(array: Any) -> None:
    content = {"a": array, "b": [array.T, {"c": array}], "d": np.arange(3), "e": np.zeros((0, 2))}
    lists = {"a": array.tolist(), "b": [array.T.tolist(), {"c": array.tolist()}], "d": [0, 1, 2], "e": []}
    assert json_texts(content) == by_standard_library(lists)


@given(
    st.lists(
        st.tuples(
            arrays(float, (2, 3), elements=st.sampled_from([0.0, -0.0, 0.1, -2e-300, 1e22])),
            st.sampled_from([None, 0.0, -0.0, 5e-324]) | arrays(float, 2, elements=st.sampled_from([math.inf, 3.5])),
            st.sampled_from([None, 0.0, 0.03]),
        ),
        min_size=1,
        max_size=4,
    )
)
def test_frames_with_their_numbers_are_written_as_the_dicts_that_they_make(filled: list[tuple[Any, Any, Any]]) -> None:
    frame = Frame(
        {"z": Hole("changes"), "dof": Hole("dof"), "50 %": "as %s", "stated": {"unit": "rad", "u": Hole("u")}},
        endless=frozenset({"dof"}),
    )
    made = [Filled(frame, {"dof": dof, "changes": changes, "u": u}) for changes, dof, u in filled]
    plain = [
        {
            "z": changes.tolist(),
            "dof": [None if one == math.inf else one for one in dof] if isinstance(dof, np.ndarray) else dof,
            "50 %": "as %s",
            "stated": {"unit": "rad", "u": u},
        }
        for changes, dof, u in filled
    ]
    assert json_texts({"a": made, "b": {"c": made[0]}}) == by_standard_library({"a": plain, "b": {"c": plain[0]}})
    assert [one.content for one in made] == plain


@pytest.mark.parametrize("number", [math.nan, math.inf, -math.inf])
def test_a_number_that_json_has_not_is_refused_in_a_frame(number: float) -> None:
    frame = Frame({"a": Hole("a"), "dof": Hole("dof")}, endless=frozenset({"dof"}))
    with pytest.raises(ValueError, match="NaN"):
        json_texts([Filled(frame, {"a": np.array([0.0, number]), "dof": None})])
    if number != math.inf:
        with pytest.raises(ValueError, match="NaN"):
            json_texts([Filled(frame, {"a": None, "dof": np.array([number])})])


def test_many_contents_with_frames_in_frames_are_written_as_each_alone() -> None:
    """Of other shapes, with zeros in other places, with and without inner frames; sealed, too."""
    inner = Frame({"c": Hole("c"), "u": Hole("u")}, endless=frozenset({"c"}))
    outer = Frame({"name": Hole("name"), "own": {"rows": Hole("rows"), "n": 3}, "parts": Hole("parts")})
    rng = np.random.default_rng(1)
    contents = []
    for i in range(8):
        parts = [
            Filled(inner, {"c": rng.integers(0, 2, 3 + i % 2) * rng.normal(size=3 + i % 2), "u": 0.5 * k or None})
            for k in range(i % 3)
        ]
        rows = rng.integers(0, 2, (2, 2)) * rng.normal(size=(2, 2))
        contents.append({"b": i, "a": {"": Filled(outer, {"name": f"unit {i}", "rows": rows, "parts": parts})}})
    plain = [
        {
            "b": one["b"],
            "a": {
                "": {
                    "name": given["name"],
                    "own": {"rows": given["rows"].tolist(), "n": 3},
                    "parts": [{"c": part.values["c"].tolist(), "u": part.values["u"]} for part in given["parts"]],
                }
            },
        }
        for one in contents
        for given in [one["a"][""].values]  # type: ignore[index]
    ]
    assert json_texts_many(contents) == [by_standard_library(one) for one in plain]
    assert [json_texts(one) for one in contents] == json_texts_many(contents)
    assert sealed_texts(contents) == [json_text({**one, CHECKSUM: checksum(one)}) for one in plain]


def test_many_numbers_have_the_text_that_python_gives_them() -> None:
    """Over all sizes, whole ones, and those beside which Arrow changes its form."""
    rng = np.random.default_rng(2)
    edges = [10.0**k for k in range(-20, 24)]
    beside = [np.nextafter(edge, far) for edge in edges for far in (0.0, np.inf)]
    sizes = rng.normal(size=20 * MANY) * 10.0 ** rng.integers(-30, 30, 20 * MANY)
    whole = np.concatenate([np.arange(1.0, 400.0), 2.0 ** np.arange(-1074, 1024), np.rint(sizes[np.abs(sizes) > 1.0])])
    numbers = np.concatenate([sizes, whole, -whole, edges, beside, [-0.1, 5e-324, 1.7976931348623157e308]])
    assert number_texts([numbers[:7], numbers[7:]]) == [*map(float.__repr__, numbers.tolist())]


def test_kinds_that_are_more_than_plain_ones() -> None:
    content = {
        "numpy": np.float64(0.1),
        "row": [np.float64(1e-7), -0.0, 1e22],
        "way": Method.MEDIAN,
        "one": [True, 1.0],
    }
    assert json_texts(content) == by_standard_library(content)


@pytest.mark.parametrize("number", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize(
    "made",
    [lambda one: one, lambda one: [1.0, one], lambda one: {"a": [one, "n"]}, lambda one: np.array([[0.0, one]])],
)
def test_a_number_that_json_has_not_is_refused(made: Any, number: float) -> None:
    with pytest.raises(ValueError, match="NaN"):
        json_texts(made(number))


@pytest.mark.parametrize("content", [{1: 2}, {"a": {2}}, [1j], {"a": np.int64(3)}, b"raw"])
def test_what_json_has_not_is_refused(content: Any) -> None:
    with pytest.raises(TypeError):
        json_texts(content)

from __future__ import annotations

import copy
import json
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from inertialcal.core.errors import DataError
from inertialcal.sensors.model.serial import from_dict, to_dict
from inertialcal.sensors.model.terms import SHAPES
from random_models import random_model

SEEDS = st.integers(0, 2**32 - 1)


@settings(max_examples=50, deadline=None)
@given(SEEDS)
def test_there_and_back_keeps_every_bit(seed: int) -> None:
    model = random_model(seed, estimated=True)
    content = to_dict(model)
    again = from_dict(json.loads(json.dumps(content, allow_nan=False))).only()
    assert to_dict(again) == content
    for name in SHAPES:
        one, other = getattr(model, name), getattr(again, name)
        assert (one is None) == (other is None)
        assert one is None or one.tobytes() == other.tobytes()
    assert model.estimate is not None
    assert again.estimate is not None
    assert again.estimate.names == model.estimate.names
    assert again.estimate.values.tobytes() == model.estimate.values.tobytes()
    assert again.estimate.covariance.tobytes() == model.estimate.covariance.tobytes()
    assert again.estimate.dof.tobytes() == model.estimate.dof.tobytes()
    for field in ("kind", "axes", "item", "unit", "output_unit", "judged", "provenance", "not_estimated", "source"):
        assert getattr(again, field) == getattr(model, field)
    assert (again.temperature_range, again.pressure_range) == (model.temperature_range, model.pressure_range)


def test_words_that_fix_the_meaning_stand_in_it() -> None:
    content = to_dict(random_model(1))
    assert content["direction"].startswith("forward")
    assert content["matrix_order"] == "row = the sensor that reads, column = the axis that moves"
    assert content["apply_order"][-1] == "multiply by the inverse of M"
    assert content["models"][""]["judged"] is False
    assert content["schema_version"] == 2


def test_infinite_degrees_of_freedom_are_null() -> None:
    content = to_dict(random_model(1, estimated=True))
    assert [one["dof"] is None for one in content["models"][""]["estimate"]["components"]] == [False, True]
    text = json.dumps(content)
    assert "Infinity" not in text
    assert "NaN" not in text


def test_some_infinite_degrees_of_freedom() -> None:
    model = random_model(1, k=1, estimated=True)
    content = to_dict(model)
    content["models"][""]["estimate"]["components"][0]["dof"][0] = None
    again = from_dict(content).only()
    assert again.estimate is not None
    assert np.isinf(np.asarray(again.estimate.components[0].dof)[0])
    assert to_dict(again) == content


def broken(change: dict[str, Any], drop: str = "") -> dict[str, Any]:
    """Content with some words, or some keys of its model, changed or dropped."""
    content = copy.deepcopy(to_dict(random_model(2, k=2, estimated=True)))
    model = content["models"][""]
    for key, value in change.items():
        (content if key in content else model)[key] = value
    content.pop(drop, None)
    model.pop(drop, None)
    return content


@pytest.mark.parametrize(
    ("content", "code", "text"),
    [
        (broken({"schema_version": 3}), "schema_version", "schema version 3 is not known"),
        (broken({}, "schema_version"), "schema_version", "schema version None is not known"),
        (broken({"format": "kalibr"}), "schema", "not a model"),
        (broken({"direction": "inverse"}), "schema", "direction reads 'inverse'"),
        (broken({"matrix_order": "row = axis that is turned"}), "schema", "matrix_order reads"),
        (broken({"unit": "deg/s"}), "schema", "unit 'deg/s' for a"),
        (broken({}, "terms"), "schema", "models.terms: Field required"),
        (broken({"terms": {"drift": [1.0]}}), "schema", "unknown term.*drift"),
        (broken({"terms": {}}), "schema", "KeyError"),
        (broken({"item": 5}), "schema", "models.item: should be"),
        (broken({"item": {"colour": "red"}}), "schema", "colour"),
        (broken({"estimate": []}), "schema", "models.estimate: should be"),
        (
            broken({"temperature_range": ["cold", "warm"]}),
            "schema",
            r"models.temperature_range.0: should be a valid number \(and 1 more\)",
        ),
        (broken({"provenance": []}), "schema", "models.provenance: should be"),
    ],
)
def test_refused(content: dict[str, Any], code: str, text: str) -> None:
    with pytest.raises(DataError, match=text) as caught:
        from_dict(content)
    assert caught.value.problems[0].code == code

from __future__ import annotations

import json
import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from inertialcal.core.errors import DataError, StoreError
from inertialcal.core.estimate import Component, Estimate
from inertialcal.core.schema.checksum import checksum
from inertialcal.files.models.model_json import dump_model, parse_models, read_model, write_model
from inertialcal.sensors.catalogue import flight_unit
from inertialcal.sensors.model.assemble import model_from
from inertialcal.sensors.model.sensor_model import Item, Provenance, SensorModel
from inertialcal.sensors.model.serial import from_dict, to_dict

NUMBERS = st.floats(-1e6, 1e6, allow_nan=False)


def model(bias: float = 0.1, scale: float = -0.005) -> SensorModel:
    names = ("bias_x", "scale_factor_error_x")
    covariance = np.array([[1e-6, 1e-9], [1e-9, 4e-6]])
    estimate = Estimate(names, np.array([bias, scale]), ("rad/s", "1"), (Component("scatter", "A", covariance, 7.5),))
    return model_from(
        estimate,
        "gyro",
        ("x",),
        28.6,
        "V",
        item=Item("Systron Donner", "QRS11", "Nº 7"),
        provenance={"bias_x": Provenance("thermal_1", ("t1", "t2"))},
    )


def code(action: Callable[[], object]) -> str:
    with pytest.raises(DataError) as caught:
        action()
    return caught.value.problems[0].code


@settings(max_examples=50, deadline=None)
@given(NUMBERS, st.floats(-0.5, 0.5, allow_nan=False))
def test_written_model_reads_back_to_the_bit(bias: float, scale: float) -> None:
    one = model(bias, scale)
    assert to_dict(parse_models(dump_model(one))) == to_dict(one)


def test_file_there_and_back(tmp_path: Path) -> None:
    for name, one in flight_unit().models.items():
        path = tmp_path / f"{name}.json"
        write_model(path, one)
        again = read_model(path)
        assert to_dict(again) == to_dict(one)
        assert again.matrix.tobytes() == one.matrix.tobytes()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["as_printed.json", "corrected.json"]


def test_same_model_gives_the_same_bytes(tmp_path: Path) -> None:
    write_model(tmp_path / "a.json", model())
    write_model(tmp_path / "b.json", read_model(tmp_path / "a.json"))
    assert (tmp_path / "a.json").read_bytes() == (tmp_path / "b.json").read_bytes()


def test_checksum_is_sha256_of_the_sorted_content() -> None:
    """By hand, for a content of two keys."""
    import hashlib

    assert checksum({"b": 1.5, "a": "ü"}) == "sha256:" + hashlib.sha256('{"a":"ü","b":1.5}'.encode()).hexdigest()


def test_number_changed_by_hand_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "model.json"
    write_model(path, model())
    text = path.read_text()
    assert text.count("-0.005") >= 1
    path.write_text(text.replace("-0.005", "-0.006"))
    with pytest.raises(DataError, match="checksum does not match the content") as caught:
        read_model(path)
    assert caught.value.problems[0].code == "checksum"
    assert caught.value.problems[0].where == str(path)


@pytest.mark.parametrize("key", ["serial", "judged", "matrix_order", "checksum"])
def test_any_key_changed_by_hand_is_refused(key: str) -> None:
    content = json.loads(dump_model(model()))
    changes = {"judged": True, "matrix_order": "row = axis that is turned", "checksum": "sha256:00"}
    if key == "serial":
        content["models"][""]["item"]["serial"] = "8"
    else:
        (content if key in content else content["models"][""])[key] = changes[key]
    assert code(lambda: parse_models(json.dumps(content))) == "checksum"


def test_missing_checksum_is_refused() -> None:
    content = json.loads(dump_model(model()))
    del content["checksum"]
    assert code(lambda: parse_models(json.dumps(content))) == "checksum"


def test_new_layout_is_not_a_change() -> None:
    content = json.loads(dump_model(model()))
    assert to_dict(parse_models(json.dumps(content, indent=8, sort_keys=True))) == to_dict(model())


def test_unknown_schema_version_is_refused_as_such() -> None:
    content = json.loads(dump_model(model()))
    content["schema_version"] = 99
    with pytest.raises(DataError, match="schema version 99 is not known"):
        parse_models(json.dumps(content), "m.json")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "not_json"),
        ("{", "not_json"),
        ('{"bias": NaN}', "not_json"),
        ("[1, 2]", "schema"),
        ("{}", "schema"),
        ("[" * 100_000, "not_json"),
    ],
)
def test_what_is_no_model_is_refused(text: str, expected: str) -> None:
    assert code(lambda: parse_models(text, "m.json")) == expected


def test_missing_or_binary_file_is_refused(tmp_path: Path) -> None:
    assert code(lambda: read_model(tmp_path / "none.json")) == "missing_file"
    (tmp_path / "binary.json").write_bytes(b"\xff\xfe\x00")
    assert code(lambda: read_model(tmp_path / "binary.json")) == "missing_file"


def test_folder_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(StoreError, match="cannot be written"):
        write_model(tmp_path / "no" / "model.json", model())


@settings(max_examples=300, deadline=None)
@given(st.data())
def test_mutated_files_never_raise_anything_else(data: st.DataObject) -> None:
    text = dump_model(model())
    at = data.draw(st.integers(0, len(text) - 1))
    until = data.draw(st.integers(at, min(len(text), at + 20)))
    insert = data.draw(st.text(max_size=5))
    changed = text[:at] + insert + text[until:]
    try:
        parsed = parse_models(changed)
    except DataError:
        return
    assert to_dict(parsed) == to_dict(model())


def test_write_leaves_nothing_beside(tmp_path: Path) -> None:
    write_model(tmp_path / "model.json", model())
    assert os.listdir(tmp_path) == ["model.json"]


def test_the_own_uncertainty_of_a_source_is_kept_and_older_files_lack_it() -> None:
    one = model()
    assert one.estimate is not None
    part = replace(one.estimate.components[0], kind="B", stated=(0.05, "%"))
    stated = replace(one, estimate=replace(one.estimate, components=(part,)))
    again = parse_models(dump_model(stated)).only()
    assert again.estimate is not None
    assert again.estimate.components[0].stated == (0.05, "%")
    older = to_dict(stated)
    del older["models"][""]["estimate"]["components"][0]["stated"]
    read = from_dict(older).only().estimate
    assert read is not None
    assert read.components[0].stated is None

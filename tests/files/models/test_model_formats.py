"""Registry of model formats: a format is one module and one line; the manual and the command name them all."""

from __future__ import annotations

import ast
import hashlib
from collections.abc import Mapping
from dataclasses import replace
from importlib.metadata import EntryPoint
from pathlib import Path

import numpy as np
import pytest

from inertialcal.core.errors import DataError, StoreError, UsageError
from inertialcal.core.key import Kind
from inertialcal.core.remarks import Remark
from inertialcal.files.models import formats
from inertialcal.files.models.formats import BUILT_IN, FORMATS
from inertialcal.files.models.model_file import export, load_model_file
from inertialcal.files.models.model_format import ImportedModels, ModelFormat, ModelText
from inertialcal.files.models.model_json import write_model
from inertialcal.sensors.model.sensor_model import SensorModel

DOCS = Path(__file__).parents[3] / "docs"
FOLDER = Path(formats.__file__).parent


def gyro() -> SensorModel:
    return SensorModel("gyro", ("x", "y", "z"), np.ones(3), "rad/s", np.eye(3), np.array([0.5, 0.0, 0.0]))


def toy() -> ModelFormat:
    """A format that holds the bias of x, after the word toy."""

    def read(given: ModelText) -> ImportedModels | None:
        if not given.text.startswith("toy "):
            return None
        bias = np.array([float(given.text.split()[1]), 0.0, 0.0])
        model = SensorModel("gyro", ("x", "y", "z"), np.ones(3), "rad/s", np.eye(3), bias)
        return ImportedModels({"gyro": model}, (Remark("toy", "info", "all but the bias of x is taken as ideal"),))

    return ModelFormat(
        name="toy",
        title="Toy",
        dump=lambda models: f"toy {models['gyro'].bias[0]!r}\n".replace("np.float64(", "").replace(")", ""),
        cannot_hold=lambda models: (Remark("not_held", "warning", "Toy cannot hold: nearly all"),),
        read=read,
    )


def test_a_format_is_read_and_written_once_it_stands_in_the_registry(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setitem(FORMATS, "toy", toy())
    write_model(tmp_path / "model.json", gyro())
    done = export(load_model_file(tmp_path / "model.json"), "toy", tmp_path / "m.toy", unjudged=True)
    assert [one.code for one in done.remarks] == ["not_held"]
    assert (tmp_path / "m.toy").read_text() == "toy 0.5\n"
    again = load_model_file(tmp_path / "m.toy")
    assert again.format == "Toy"
    assert [one.code for one in again.remarks] == ["toy"]
    np.testing.assert_array_equal(again.model.bias, gyro().bias)
    with pytest.raises(UsageError, match="flight-c, toy"):
        export(again, "other", tmp_path / "out", unjudged=True)


def test_a_format_of_several_files_writes_a_folder_or_nothing(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def folder(models: Mapping[Kind, SensorModel], arithmetic: str | None) -> dict[str, bytes]:
        return {"kinds": ",".join(models).encode(), "arithmetic": str(arithmetic).encode()}

    monkeypatch.setitem(FORMATS, "toy", replace(toy(), folder=folder))
    write_model(tmp_path / "model.json", gyro())
    source = load_model_file(tmp_path / "model.json")
    done = export(source, "toy", tmp_path / "out", unjudged=True, arithmetic="q7")
    assert {path.name: path.read_text() for path in (tmp_path / "out").iterdir()} == {
        "kinds": "gyro",
        "arithmetic": "q7",
    }
    lines = [f"{hashlib.sha256(text).hexdigest()}  {name}\n" for name, text in
             (("arithmetic", b"q7"), ("kinds", b"gyro"))]  # fmt: skip
    assert done.sha256 == hashlib.sha256("".join(lines).encode()).hexdigest()
    with pytest.raises(StoreError) as caught:  # never into a folder that holds something
        export(source, "toy", tmp_path / "out", unjudged=True)
    assert caught.value.problems[0].code == "not_writable"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["model.json", "out"]
    with pytest.raises(UsageError, match="no choice"):
        export(source, "c", tmp_path / "m.c", unjudged=True, arithmetic="q7")


def test_flight_c_needs_a_chain(tmp_path: Path) -> None:
    write_model(tmp_path / "model.json", gyro())
    with pytest.raises(DataError, match="the model has no chain"):
        export(load_model_file(tmp_path / "model.json"), "flight-c", tmp_path / "out", unjudged=True)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("name", FORMATS)
def test_every_format_is_whole_and_documented(name: str) -> None:
    assert isinstance(FORMATS[name], ModelFormat)
    assert f"`{name}`" in (DOCS / "commands" / "export.md").read_text()


def test_formats_import_nothing_of_each_other() -> None:
    for module in BUILT_IN.values():
        tree = ast.parse(((FOLDER / module.replace(".", "/")).with_suffix(".py")).read_text())
        named = {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and node.level}
        assert not named & set(BUILT_IN.values()), module


def test_a_broken_format_of_a_package_is_named_where_nothing_else_knows_the_text(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    point = EntryPoint("bad", "a_module_that_nobody_has:FORMAT", FORMATS.group)
    monkeypatch.setitem(FORMATS.installed, "bad", (point,))
    write_model(tmp_path / "model.json", gyro())
    assert load_model_file(tmp_path / "model.json").format == "inertialcal"
    (tmp_path / "other.txt").write_text("something else")
    with pytest.raises(DataError, match="'bad'") as caught:
        load_model_file(tmp_path / "other.txt")
    assert [one.code for one in caught.value.problems] == ["not_json", "broken_plugin"]

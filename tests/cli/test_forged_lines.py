"""Texts of files that would forge a line or steer a terminal: in every field, by every command that prints them."""

from __future__ import annotations

import csv
import io
import json
import shutil
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pytest
from pyarrow import parquet

import inertialcal as ic
from inertialcal.campaign.engine.run import run
from inertialcal.campaign.file.example import copy_example
from inertialcal.cli.__main__ import main
from inertialcal.core.campaign_text import toml_text
from inertialcal.files.models.model_json import write_model
from inertialcal.sensors.model.sensor_model import Item, Provenance, SensorModel
from written_rows import sealed_text

FORGED = "FORGED: PASS"
HOSTILE = f"a\n{FORGED}\r{FORGED}\r\n\x1b[31m\x9b1m\x07\u202eb\u2066\u2028{FORGED}\u0085{FORGED}\x0b<b>&"
Typed = Callable[..., int]
At = tuple[str | int, ...]


def assert_clean(text: str) -> None:
    for line in text.split("\n"):
        assert line.isprintable(), repr(line)
        assert not line.startswith(FORGED), line


@pytest.fixture
def typed(capsys: pytest.CaptureFixture[str]) -> Typed:
    """Return a call of the command line that checks all it prints."""

    def call(*words: Any) -> int:
        with pytest.raises(SystemExit) as left:
            main([str(word) for word in words])
        out, err = capsys.readouterr()
        assert_clean(out)
        assert_clean(err)
        assert left.value.code != 70, err
        return int(left.value.code or 0)

    return call


@pytest.fixture(scope="module")
def ran(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("forged") / "demo"
    copy_example("npsat2011", folder)
    run(folder)
    return folder


def texts(content: Any, at: At = ()) -> Iterator[At]:
    """Yield where texts stand: the first of each kind of place, whatever its number in a list."""
    if isinstance(content, str):
        yield at
    elif isinstance(content, dict):
        for name, part in content.items():
            yield from texts(part, (*at, name))
    elif isinstance(content, list):
        seen: set[At] = set()
        for number, part in enumerate(content):
            for inner in texts(part, (*at, number)):
                kind = tuple(step for step in inner[len(at) + 1 :] if isinstance(step, str))
                if kind not in seen:
                    seen.add(kind)
                    yield inner


def with_text(content: Any, at: At, text: str) -> Any:
    if not at:
        return text
    first, *rest = at
    new: Any = dict(content) if isinstance(content, dict) else list(content)
    new[first] = with_text(content[first], tuple(rest), text)
    return new


def model() -> SensorModel:
    one = np.ones(1)
    origin = Provenance("rate_x", ("a.csv",), "thesis")
    more: Any = {"bias_temperature": np.full((1, 1), 1e-4), "reference_temperature": 25.0 * one, "source": "thesis"}
    more |= {"provenance": {"bias_x": origin, "scale_factor_error_x": Provenance("", (), "thesis")}}
    more |= {"not_estimated": {"bias_x": "no runs"}}
    return SensorModel(
        "gyro", ("x",), one, "V", np.full((1, 1, 1), 1.1), 0.01 * one, Item("maker", "part", "7"), **more
    )


def test_texts_of_a_model(typed: Typed, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    write_model(tmp_path / "model.json", model())
    (tmp_path / "data.csv").write_text("t_s,x [V],temp_degC\n" + "".join(f"{i},{i % 3},25\n" for i in range(20)))
    content = json.loads((tmp_path / "model.json").read_text())
    places = [at for at in texts(content) if at != ("checksum",)]
    assert len(places) > 15
    shown = 0
    for at in places:
        Path("hostile.json").write_text(sealed_text(with_text(content, at, HOSTILE)))
        shown += typed("show", "hostile.json") == 0
        typed("compare", "model.json", "hostile.json")
        typed("compensate", "hostile.json", "data.csv", "--temperature", "temp_degC", "-o", "done.csv")
        typed("export", "hostile.json", "--to", "c", "--unjudged", "-o", "done.c")
        if Path("done.c").is_file():
            assert_clean(Path("done.c").read_text(encoding="utf-8"))
    assert shown >= 6
    hostile = ic.load_model(tmp_path / "model.json")
    assert_clean(str(hostile))


@pytest.mark.parametrize("every", [9, pytest.param(1, marks=pytest.mark.slow)])
def test_texts_of_results(typed: Typed, ran: Path, tmp_path: Path, every: int) -> None:
    content = json.loads((ran / "out/results.json").read_text())
    content["remarks"].append(
        {"code": "a", "severity": "info", "what": "w", "where": "h", "count": 2, "do": "d"}
    )  # fmt: skip
    path, shown = tmp_path / "results.json", 0
    for at in [*texts(content)][::every]:
        path.write_text(sealed_text(with_text(content, at, HOSTILE)))
        shown += typed("show", path) == 0
        if at[0] in ("results", "influences", "item", "budgets"):
            typed("compare", ran / "out/results.json", path)
    assert shown > 30 // every


@pytest.mark.slow
def test_texts_of_a_campaign(typed: Typed, tmp_path: Path) -> None:
    folder = tmp_path / "demo"
    copy_example("npsat2011", folder)
    document = tomllib.loads((folder / "campaign.toml").read_text(encoding="utf-8"))
    taken = document
    for at in [at for at in texts(document) if at[-1] != "file"]:
        (folder / "campaign.toml").write_text(toml_text(with_text(document, at, HOSTILE)), encoding="utf-8")
        if typed("check", folder) == 0:
            taken = with_text(taken, at, HOSTILE)
    for name in ("maker", "part", "serial"):
        taken = taken | {"item": taken.get("item", {}) | {name: HOSTILE}}
    (folder / "campaign.toml").write_text(toml_text(taken), encoding="utf-8")
    assert typed("run", folder) != 3
    for words in (("show", folder), ("show", folder / "out"), ("run", folder), ("show", folder / "out/report.html")):
        assert typed(*words) != 3
    page = (folder / "out/report.html").read_text(encoding="utf-8")
    assert "<b>&" not in page
    assert not set("\x1b\x9b\x07\u202e") & set(page)
    assert_clean(str(ic.run(folder, write=False)))
    assert "<b>&" not in ic.run(folder, write=False)._repr_html_()


@pytest.mark.parametrize("ending", ["csv", "parquet", "npz"])
def test_texts_of_a_recording(typed: Typed, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ending: str) -> None:
    monkeypatch.chdir(tmp_path)
    noise = np.random.default_rng(1).normal(size=300).round(3)
    names, file = ["t_s", f"gyro_x {HOSTILE}", f"gyro_y [{HOSTILE}]"], f"raw.{ending}"
    if ending == "csv":
        buffer = io.StringIO()
        csv.writer(buffer).writerows([names, *((i / 10, a, a / 2) for i, a in enumerate(noise.tolist()))])
        Path(file).write_text(buffer.getvalue(), encoding="utf-8", newline="")
    else:
        columns = dict(zip(names, (np.arange(300) / 10, noise, noise / 2), strict=True))
        if ending == "parquet":
            fields = [pa.field(name, pa.float64(), metadata={"unit": HOSTILE}) for name in names]
            parquet.write_table(pa.Table.from_arrays([*columns.values()], schema=pa.schema(fields)), file)
        else:
            arrays: Any = {name.replace("\x00", "").replace("/", ""): one for name, one in columns.items()}
            np.savez(file, **arrays)
    typed("info", file)
    assert typed("info", file, "--sample-rate", "10") == 0
    for noun in ("allan", "psd", "rate-table", "positions", "sine", "flip", "thermal"):
        typed(noun, file, "--unit", "gyro=deg/s", "--sample-rate", "10")
    for target in ("a.csv", "a.parquet", "a.npz"):
        typed("convert", file, target, "--sample-rate", "10")
    found = ic.info(file, sample_rate=10.0)
    assert_clean(str(found))
    assert "<b>&" not in found._repr_html_()
    assert_clean(str(ic.read(file, sample_rate=10.0)))


def test_names_of_files(typed: Typed, tmp_path: Path, ran: Path) -> None:
    folder = tmp_path / HOSTILE.replace("/", "")
    shutil.copytree(ran, folder)
    recording = folder / "x.csv"
    recording.write_text("t_s,gyro_x [deg/s]\n" + "".join(f"{i / 10},{i % 7}\n" for i in range(99)))
    for words in (
        ("show", folder), ("show", folder / "out"), ("show", folder / "out/report.html"), ("check", folder),
        ("compare", folder, ran), ("info", recording), ("allan", recording), ("show", folder / "none.json"),
        ("convert", recording, folder / "y.csv"), ("run", folder), ("score", folder),
    ):  # fmt: skip
        typed(*words)

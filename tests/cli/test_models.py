"""show, compensate, convert, export, compare as a user meets them; models that must be refused."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from inertialcal.cli.__main__ import main
from inertialcal.core.errors import UsageError
from inertialcal.core.estimate import Component, Estimate
from inertialcal.core.schema.checksum import checksum
from inertialcal.core.units import factor
from inertialcal.files import read
from inertialcal.files.models.formats import FORMATS
from inertialcal.files.models.model_json import write_model
from inertialcal.sensors.catalogue import flight_unit
from inertialcal.sensors.model.assemble import model_from
from inertialcal.sensors.model.sensor_model import Item, Provenance, SensorModel
from written_rows import results_text

ENVELOPE = {"command", "version", "inputs", "schema", "results", "remarks", "verdicts", "errors", "exit"}
ROW = {"quantity", "axis", "sensor", "power", "at", "test", "condition", "method", "member", "value", "u", "unit",
       "dof", "interval", "status", "reason", "shared", "curvature"}  # fmt: skip
HEAD = "t_s,gyro_x_dps,gyro_y_dps,gyro_z_dps,temp [degC],n\n"
ROWS = [f"{0.5 * i + 2.0 * (i > 5)},{(-1) ** i},{0.25 * i},{'' if i == 1 else 3},20,{i + 5}" for i in range(12)]
DATA = HEAD + "\n".join(ROWS) + "\n"  # a gap of 4 samples after the sixth, an empty cell in the second
Call = Callable[..., tuple[int, str, str]]


@pytest.fixture
def call(capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Call:
    """Type a command in an empty folder with models and a recording; return exit status, output, messages."""
    monkeypatch.chdir(tmp_path)
    write_model(tmp_path / "model.json", estimated())
    write_model(tmp_path / "judged.json", replace(estimated(), judged=True))
    write_model(tmp_path / "published.json", flight_unit().models["corrected"])
    (tmp_path / "data.csv").write_text(DATA)

    def run(*words: str) -> tuple[int, str, str]:
        with pytest.raises(SystemExit) as left:
            main(list(words))
        out, err = capsys.readouterr()
        assert "Traceback" not in out + err
        return int(left.value.code or 0), out, err

    return run


def as_json(call: Call, *words: str) -> dict[str, Any]:
    status, out, err = call(*words, "--json")
    content: dict[str, Any] = json.loads(out)
    assert set(content) >= ENVELOPE
    assert (content["exit"], content["command"], err) == (status, words[0], "")
    return content


def estimated(bias: float = 1e-3) -> SensorModel:
    names = tuple(f"bias_{a}" for a in "xyz") + tuple(f"scale_factor_error_{a}" for a in "xyz")
    values = np.array([bias, 2e-3, -1e-3, 0.01, -0.02, 0.005])
    units = ("rad/s",) * 3 + ("1",) * 3
    scatter = Component("scatter", "A", np.diag(np.array([1e-5] * 3 + [1e-4] * 3) ** 2), 7.0)
    return model_from(
        Estimate(names, values, units, (scatter,)), "gyro", ("x", "y", "z"), 0.5 / factor("deg/s", "rad/s"), "V",
        item=Item("Systron Donner", "QRS11", "7"), provenance={"bias_x": Provenance("rate_x", ("rt_x",))},
    )  # fmt: skip


# show


def test_show_prints_equation_matrix_in_words_and_all_digits(call: Call) -> None:
    status, out, err = call("show", "published.json")
    assert (status, err) == (0, "")
    assert "z sensor reads 1.298 % of x motion" in out  # the thesis prints it as m_xz
    assert "misalignment_zx" in out
    assert "u = M x" in out
    assert repr(1.298e-2 / (1.0 - 0.506e-2)) in out  # misalignment = M_zx / M_zz, every digit
    assert "not confirmed by held-out recordings" in out
    assert "temperatures -21 to 66 degC" in out
    _, out, _ = call("show", "judged.json")
    assert "judged on held-out recordings" in out
    assert "rate_x on rt_x" in out
    assert call("show", "model.json", "-q")[1] == ""


def test_show_as_json_is_rows_and_the_model(call: Call, tmp_path: Path) -> None:
    content = as_json(call, "show", "model.json")
    on_disk = json.loads((tmp_path / "model.json").read_text())
    assert content["model"] == {key: value for key, value in on_disk.items() if key != "checksum"}
    assert content["judged"] is False
    assert all(set(row) == ROW for row in content["results"])
    rows = {(row["quantity"], row["axis"]): row for row in content["results"]}
    assert rows["bias", "x"]["value"] == 1e-3
    assert rows["bias", "x"]["test"] == "rate_x"
    assert rows["bias", "x"]["interval"]["p"] == 0.95
    assert rows["misalignment", "xy"]["status"] == "not_estimated"
    assert rows["misalignment", "xy"]["reason"]
    assert len(content["words"]) == len(content["results"])


def test_show_of_a_campaign_folder(call: Call, tmp_path: Path) -> None:
    assert "No" not in call("show", ".")[1]
    assert call("show", ".")[0] == 0  # the folder has a model.json itself
    (tmp_path / "empty").mkdir()
    content = as_json(call, "show", "empty")
    assert content["exit"] == 3
    assert content["errors"][0]["code"] == "no_model"


# compensate


def test_compensate_keeps_time_gaps_and_other_columns(call: Call, tmp_path: Path) -> None:
    status, out, err = call("compensate", "model.json", "data.csv", "-o", "out.csv")
    assert (status, err) == (0, "")
    assert "columns: x = gyro_x_dps, y = gyro_y_dps, z = gyro_z_dps" in out
    assert "gap: 4 sample(s) missing" in out
    assert "Next: inertialcal info out.csv" in out
    raw, done = read(tmp_path / "data.csv"), read(tmp_path / "out.csv")
    assert done.names == raw.names
    np.testing.assert_array_equal(done.time_ns, raw.time_ns)
    np.testing.assert_array_equal(done.channel("n").data, np.arange(5, 17))
    # x = (r - bias) / M_xx by hand, in deg/s
    expected = (np.array([1.0, -1.0] * 6) - np.degrees(1e-3)) / 1.01
    np.testing.assert_allclose(done.channel("gyro_x_dps").data, expected, rtol=1e-14)
    assert np.isnan(done.channel("gyro_z_dps").data).tolist() == [i == 1 for i in range(12)]


@pytest.mark.parametrize("ending", ["csv", "parquet", "npz"])
def test_compensate_with_uncertainty_in_any_format(call: Call, tmp_path: Path, ending: str) -> None:
    content = as_json(call, "compensate", "model.json", "data.csv", "-o", f"out.{ending}", "--uncertainty")
    assert [one["path"] for one in content["inputs"]] == ["model.json", "data.csv"]
    assert content["written"] == f"out.{ending}"
    assert content["columns"] == {"x": "gyro_x_dps", "y": "gyro_y_dps", "z": "gyro_z_dps"}
    assert {"gaps", "unjudged_model", "counted_as_exact"} <= {one["code"] for one in content["remarks"]}
    done = read(tmp_path / f"out.{ending}")
    # u of (r - bias) / M: bias 1e-5 rad/s and scale factor 1e-4 of the input, r = 1 deg/s in the first row
    x = (1.0 - np.degrees(1e-3)) / 1.01
    expected = np.hypot(np.degrees(1e-5), 1e-4 * x) / 1.01
    name = next(name for name in done.names if name.startswith("u_gyro_x"))
    assert done.channel(name).data[0] == pytest.approx(expected, rel=1e-12)
    assert done.channel(name).unit == "deg/s"


def test_compensate_takes_units_columns_and_temperature(call: Call, tmp_path: Path) -> None:
    (tmp_path / "plain.csv").write_text("a,b,c,k\n1,2,3,20\n1,2,3,25\n")
    words = ["compensate", "published.json", "plain.csv", "-o", "out.csv"]
    words += [f"--column={axis}={name}" for axis, name in zip("xyz", "abc", strict=True)]
    assert [one["code"] for one in as_json(call, *words)["errors"]] == ["no_temperature", "no_unit"]
    words += [f"--unit={name}=deg/s" for name in "abc"]
    content = as_json(call, *words)
    assert content["errors"][0]["code"] == "no_temperature"
    assert "--temperature" in content["errors"][0]["do"]
    assert as_json(call, *words, "--temperature", "k")["errors"][0]["do"] == "Add --unit k=UNIT (UNIT: degC, K, degF)"
    fixed = as_json(call, *words, "--temperature", "20 degC")
    assert fixed["columns"]["temperature"] == "20 degC"
    first = read(tmp_path / "out.csv").array()[0, :3]
    assert as_json(call, *words, "--unit=k=degC", "--temperature", "k")["exit"] == 0
    np.testing.assert_array_equal(read(tmp_path / "out.csv").array()[0, :3], first)


BAD_MODELS = [
    ("edited", [], "checksum", "the checksum does not match the content"),
    ("model", ["--serial", "8"], "wrong_serial", "the model is for serial '7', the data are from serial '8'"),
    ("model", ["--unit", "x=g", "--column", "x=n"], "wrong_column", "no column"),
    ("model", ["--column", "x=acc"], "wrong_unit", "column 'acc [g]': the data are in 'g'"),
    ("model", ["--column", "x=n"], "no_unit", "unit of column 'n' not given"),
    ("singular", [], "not_invertible", "the matrix cannot be inverted"),
    ("turning", [], "not_unique", "slope falls to"),
    ("future", [], "schema_version", "schema version 99 is not known"),
    ("gone", [], "missing_file", "no such file"),
    ("text", [], "not_json", "no JSON"),
    ("data", [], "not_json", "no JSON"),
]


@pytest.mark.parametrize(("name", "more", "code", "words"), BAD_MODELS)
def test_models_that_cannot_be_applied(
    call: Call, tmp_path: Path, name: str, more: list[str], code: str, words: str
) -> None:
    (tmp_path / "data.csv").write_text("gyro_x_dps,gyro_y_dps,gyro_z_dps,acc [g],n\n1,2,3,1,5\n1,2,3,1,7\n")
    text = (tmp_path / "model.json").read_text()
    (tmp_path / "edited.json").write_text(text.replace("0.01,", "0.02,", 1))
    assert (tmp_path / "edited.json").read_text() != text
    later = {key: value for key, value in json.loads(text).items() if key != "checksum"} | {"schema_version": 99}
    (tmp_path / "future.json").write_text(json.dumps(later | {"checksum": checksum(later)}))
    (tmp_path / "text.json").write_text("{")
    plain = flight_unit().models["corrected"]
    fields: dict[str, Any] = {"kind": "gyro", "axes": ("x", "y", "z"), "scale_factor": plain.scale_factor,
                              "output_unit": "V", "bias": plain.bias}  # fmt: skip
    write_model(tmp_path / "singular.json", SensorModel(**fields, matrix=np.ones((3, 3))))
    curved: dict[str, Any] = {"second_order": np.full(3, 10.0), "input_range": np.array([[-1.0, 1.0]] * 3)}
    write_model(tmp_path / "turning.json", SensorModel(**fields, matrix=np.eye(3), **curved))
    path = "data.csv" if name == "data" else f"{name}.json"
    if code == "wrong_column":
        more = ["--column", "x=missing"]
    content = as_json(call, "compensate", path, "data.csv", "-o", "out.csv", *more)
    assert content["exit"] == 3
    assert content["errors"][0]["code"] == code
    assert words in content["errors"][0]["what"]
    assert not (tmp_path / "out.csv").exists()
    status, _, err = call("compensate", path, "data.csv", "-o", "out.csv", *more)
    assert status == 3
    assert err.startswith("error: ")


def test_wrong_usage_of_compensate(call: Call, tmp_path: Path) -> None:
    for more in (["-o", "out.xlsx"], ["-o", "out.csv", "--column", "x="], ["-o", "out.csv", "--unit", "gyro="], []):
        assert call("compensate", "model.json", "data.csv", *more)[0] == 2
    status, _, err = call("compensate", "model.json", "data.csv", "-o", "a.csv", "--column", "x=a", "--column", "x=b")
    assert status == 2
    assert "'x' stands twice" in err
    content = as_json(call, "compensate", "model.json", "data.csv", "-o", "data.csv")
    assert (content["exit"], content["errors"][0]["code"]) == (3, "overwrites_input")
    assert (tmp_path / "data.csv").read_text() == DATA


# convert


def test_convert_there_and_back(call: Call, tmp_path: Path) -> None:
    for source, target in (("data.csv", "a.parquet"), ("a.parquet", "b.npz"), ("b.npz", "c.csv")):
        content = as_json(call, "convert", source, target)
        assert content["written"] == target
        assert content["rows"] == 12
        assert {one["code"] for one in content["remarks"]} >= {"gaps", "missing_cells"}
    raw, done = read(tmp_path / "data.csv"), read(tmp_path / "c.csv")
    assert (done.names, [c.unit for c in done.channels]) == (raw.names, [c.unit for c in raw.channels])
    np.testing.assert_array_equal(done.time_ns, raw.time_ns)
    np.testing.assert_array_equal(done.array(), raw.array())


def test_convert_counts_what_is_lost(call: Call, tmp_path: Path) -> None:
    (tmp_path / "in.csv").write_text("t_s,a,label\n0,1,go\n1,,go\n2,3,stop\n")
    status, out, _ = call("convert", "in.csv", "out.parquet", "--unit", "a=V")
    assert status == 0
    assert "column 'label' is text" in out
    assert "empty cell in 'a'" in out
    assert read(tmp_path / "out.parquet").channel("a").unit == "V"
    assert call("convert", "in.csv", "out.xlsx")[0] == 2
    assert call("convert", "in.csv", "in.csv")[0] == 3
    assert call("convert", "in.csv", "other.csv", "--quiet")[1] == ""


def test_a_sample_rate_that_was_said_stays(call: Call, tmp_path: Path) -> None:
    (tmp_path / "in.csv").write_text("wx_dps,b\n1,2\n3,5\n")
    for ending in ("csv", "parquet", "npz"):
        assert call("convert", "in.csv", f"out.{ending}", "--sample-rate", "128")[0] == 0
        assert read(tmp_path / f"out.{ending}").sample_rate == 128.0


# export


def test_export_is_the_model_to_the_byte(call: Call, tmp_path: Path) -> None:
    content = as_json(call, "export", "judged.json", "--to", "json", "-o", "out.json")
    assert (content["exit"], content["written"], content["judged"]) == (0, "out.json", True)
    assert (tmp_path / "out.json").read_bytes() == (tmp_path / "judged.json").read_bytes()
    assert content["sha256"] == content["inputs"][0]["sha256"]
    assert "judged" in call("export", "judged.json", "--to", "json", "-o", "out.json")[1]


def test_a_model_that_was_not_judged_is_handed_out_by_word_only(call: Call, tmp_path: Path) -> None:
    content = as_json(call, "export", "model.json", "--to", "json", "-o", "out.json")
    assert (content["exit"], content["errors"][0]["code"]) == (3, "unjudged")
    assert "--unjudged" in content["errors"][0]["do"]
    assert not (tmp_path / "out.json").exists()
    status, out, _ = call("export", "model.json", "--to", "json", "-o", "out.json", "--unjudged")
    assert (status, out) == (0, "written: out.json (not judged)\n")


def test_export_refuses_other_formats_and_its_own_input(call: Call) -> None:
    content = as_json(call, "export", "judged.json", "--to", "excel", "-o", "out.xlsx")
    assert content["exit"] == UsageError.exit_status
    assert all(name in content["errors"][0]["do"] for name in FORMATS)
    assert as_json(call, "export", "judged.json", "--to", "json", "-o", "judged.json")["exit"] == 3
    assert as_json(call, "export", "judged.json", "--to", "json", "-o", "no/out.json")["exit"] == 3


# compare


def test_compare_two_models(call: Call, tmp_path: Path) -> None:
    write_model(tmp_path / "other.json", estimated(bias=2e-3))
    status, out, _ = call("compare", "model.json", "other.json")
    assert status == 0
    line = next(line for line in out.splitlines() if line.strip().startswith("bias") and " x " in line)
    assert line.rstrip().endswith("different")
    assert "not shown different" not in line
    assert "not compared: misalignment xy" in out
    assert "taken as independent" in out
    content = as_json(call, "compare", "model.json", "other.json")
    rows = {(row["quantity"], row["axis"]): row for row in content["results"]}
    assert set(rows["bias", "x"]) == ROW | {"first", "second", "p_value", "verdict", "ratio"}
    assert rows["bias", "x"]["value"] == pytest.approx(np.degrees(1e-3))
    assert rows["bias", "x"]["u"] == pytest.approx(np.degrees(1e-5) * 2**0.5)
    assert rows["bias", "x"]["dof"] == pytest.approx(14.0)
    assert (rows["bias", "x"]["verdict"], rows["bias", "y"]["verdict"]) == ("different", "not shown different")
    assert content["verdict"] is None


@pytest.mark.parametrize(("allowed", "status"), [("bias=1 deg/s", 0), ("bias=0.01 deg/s", 1), ("bias=1e-4 deg/s", 1)])
def test_compare_judges_an_allowed_change(call: Call, tmp_path: Path, allowed: str, status: int) -> None:
    write_model(tmp_path / "other.json", estimated(bias=2e-3))
    content = as_json(call, "compare", "model.json", "other.json", "--allowed", allowed)
    assert content["exit"] == status
    assert [one["quantity"] for one in content["verdicts"]] == ["bias"] * 3
    assert content["verdict"] in {"PASS", "FAIL"}
    _, out, _ = call("compare", "model.json", "other.json", "--allowed", allowed)
    assert out.rstrip().endswith(f"overall: {content['verdict']}")


def test_compare_ends_with_4_where_the_data_cannot_tell(call: Call, tmp_path: Path) -> None:
    write_model(tmp_path / "other.json", estimated(bias=2e-3))
    assert call("compare", "model.json", "other.json", "--allowed", "scale_factor_error=0.01 %", "-q")[0] == 4


def test_compare_without_uncertainties_shows_differences_and_why(call: Call, tmp_path: Path) -> None:
    write_model(tmp_path / "printed.json", flight_unit().models["as_printed"])
    status, out, _ = call("compare", "published.json", "printed.json")
    assert status == 0
    assert "not compared: scale_factor_error x" in out
    assert "published without covariance" in out


def test_compare_refuses(call: Call, tmp_path: Path) -> None:
    (tmp_path / "results.json").write_text(results_text())
    content = as_json(call, "compare", "model.json", "results.json")
    assert (content["exit"], content["errors"][0]["code"]) == (3, "different_kinds")
    assert call("compare", "model.json", "model.json", "--allowed", "a lot")[0] == 2
    assert as_json(call, "compare", "results.json", "results.json")["errors"][0]["code"] == "no_shared_quantity"


def _changed(value: Any) -> Any:
    """Return another value of the same kind."""
    if isinstance(value, bool):
        return not value
    if isinstance(value, int | float):
        return value + 1
    return "edited" if value is None or isinstance(value, str) else value


def _places(content: Any, at: tuple[str | int, ...] = ()) -> Iterator[tuple[str | int, ...]]:
    """Yield where each value of a model stands."""
    if isinstance(content, dict | list):
        for name, part in content.items() if isinstance(content, dict) else enumerate(content):
            yield from _places(part, (*at, name))
    else:
        yield at


def test_a_model_edited_in_any_field_is_refused_by_all(call: Call, tmp_path: Path) -> None:
    """Also one whose number was changed in its last digit, and one that got or lost a field."""
    original = (tmp_path / "model.json").read_text()
    places = list(_places(json.loads(original)))
    versions = [json.dumps(json.loads(original) | {"more": 1})]
    for at in [*places, *((name,) for name in json.loads(original))]:
        content = json.loads(original)
        inner = content
        for step in at[:-1]:
            inner = inner[step]
        if len(at) == 1 and isinstance(inner[at[0]], dict | list):
            del inner[at[0]]
        else:
            inner[at[-1]] = _changed(inner[at[-1]])
        versions.append(json.dumps(content))
    assert len(versions) > 60
    commands = (("show",), ("compare", "model.json"), ("compensate",), ("export",))
    more = {"compensate": ("data.csv", "-o", "out.csv"), "export": ("--to", "c", "--unjudged", "-o", "m.c")}
    for number, text in enumerate(versions):
        (tmp_path / "edited.json").write_text(text)
        word, *first = commands[number % len(commands)]
        content = as_json(call, word, *first, "edited.json", *more.get(word, ()))
        assert content["exit"] == 3, text
    assert not (tmp_path / "out.csv").exists()
    assert not (tmp_path / "m.c").exists()


def test_exported_code_says_of_which_model(call: Call, tmp_path: Path) -> None:
    checksum_there = json.loads((tmp_path / "model.json").read_text())["checksum"]
    for to in ("c", "python"):
        assert call("export", "model.json", "--to", to, "--unjudged", "-o", f"m.{to}")[0] == 0
        assert f"Checksum of model.json: {checksum_there}" in (tmp_path / f"m.{to}").read_text()

"""`positions` on the command line: output, models, figures, every form of input, one clear message for bad input."""

from __future__ import annotations

import contextlib
import io
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import inertialcal
from inertialcal import load_model
from inertialcal.campaign.compare.compare import compare
from inertialcal.campaign.twins.twin import csv_text
from inertialcal.cli.__main__ import main
from inertialcal.core.errors import DataError
from inertialcal.core.recording import Recording
from inertialcal.core.show.rows import case_name
from inertialcal.files import read
from inertialcal.rigs.hand_held.rig import FAULTS, Bench, build
from positions_truths import protocol
from typed_commands import call, call_json

SMALL = Bench(positions=14, dwell=2.5, first=4.0, records=1)
ONCE = Bench(variant="ferraris", rounds=1, records=1, dwell=2.0, first=2.0)
SI = ("--unit", "acc=m/s2", "--unit", "gyro=rad/s", "--gravity", "9.807 m/s2")
WAY = "as_published"
SCALE = 0.1  # of the accelerometers, and of the gyros five times that, by which a short record may be off [%]
MISTAKES = {"unit_slip", "axes_disagree", "sample_rate_suspect", "rotations_do_not_close", "duplicate_recording"}


def written(folder: Path, bench: Bench) -> list[str]:
    """Write the records of a bench; return their paths."""
    paths = []
    for number, recording in enumerate(build(bench, 1).recordings.values(), 1):
        paths.append(folder / f"hand{number}.csv")
        paths[-1].write_text(csv_text(recording), encoding="utf-8")
    return [str(path) for path in paths]


@pytest.fixture(scope="module")
def clean(tmp_path_factory: pytest.TempPathFactory) -> str:
    return written(tmp_path_factory.mktemp("positions"), SMALL)[0]


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory, clean: str) -> dict[str, Any]:
    """What one run prints as JSON, with models written."""
    folder, out = tmp_path_factory.mktemp("out"), io.StringIO()
    with contextlib.redirect_stdout(out), pytest.raises(SystemExit) as left:
        main(["positions", clean, *SI, "-o", str(folder / "m.json"), "--json"])
    assert not left.value.code
    content: dict[str, Any] = json.loads(out.getvalue())
    return content | {"folder": folder}


def by_sensor(content: dict[str, Any], method: str = "") -> dict[tuple[str, str, str], dict[str, Any]]:
    """Return rows by sensor, quantity and axis: the result, or those of a method."""
    wanted = [row for row in content["results"] if (row["method"] == method if method else row["method"] != WAY)]
    return {(row["sensor"], row["quantity"], row["axis"]): row for row in wanted}


def test_scale_factors_and_g_sensitivity_are_those_of_the_unit(found: dict[str, Any]) -> None:
    rows = by_sensor(found)
    for true in build(SMALL, 1).truth:
        row = rows[true.sensor, true.quantity, true.axis]
        if true.quantity == "scale_factor_error":
            tolerance = SCALE if true.sensor == "accelerometer" else 5.0 * SCALE
            assert row["unit"] == "%"
            assert row["value"] == pytest.approx(100.0 * true.value, abs=tolerance), true
        if true.quantity == "g_sensitivity" and abs(true.value) > 2e-4:
            assert row["unit"] == "rad/s/g"
            assert row["value"] == pytest.approx(9.80665 * true.value, rel=0.3), true
    assert found["columns"]["gyro_z"] == "gyro_z"
    assert MISTAKES.isdisjoint(one["code"] for one in found["remarks"])


def test_clean_record_raises_no_alarm(found: dict[str, Any]) -> None:
    assert {"disturbed_position", "outlier_rotation"}.isdisjoint(one["code"] for one in found["remarks"])


def test_a_file_held_out_is_judged_and_the_models_with_it(tmp_path: Path) -> None:
    first, second = written(tmp_path, replace(SMALL, records=2))
    found = inertialcal.positions(
        first, hold_out=[second], units={"acc": "m/s2", "gyro": "rad/s"}, gravity="9.807 m/s2"
    )
    loop = found.results["closed_loop"]
    assert {one["verdict"] for one in loop["axes"]} == {"PASS"}
    assert loop["axes"][0]["axis"] == "accelerometer"
    assert {name: model.judged for name, model in found.models.items()} == {"accelerometer": True, "gyro": True}
    assert [test["use"] for test in found.document["tests"]] == ["fit", "hold_out"]


def test_models_and_figure_are_written(capsys: pytest.CaptureFixture[str], clean: str, found: dict[str, Any]) -> None:
    folder = found["folder"]
    assert [Path(one).name for one in found["written"]] == ["m_acc.json", "m_gyro.json"]
    acc, gyro = load_model(folder / "m_acc.json"), load_model(folder / "m_gyro.json")
    assert (acc.kind, gyro.kind) == ("accelerometer", "gyro")
    assert gyro.g_sensitivity is not None
    with pytest.raises(DataError, match="one is a model of the accelerometer, the other of the gyro"):
        compare(folder / "m_acc.json", folder / "m_gyro.json")
    error = by_sensor(found)["accelerometer", "scale_factor_error", "x"]["value"]
    assert acc.matrix[0][0, 0] == pytest.approx(1.0 + 0.01 * error)
    words = ("-o", str(folder / "f.svg"), "--figure", "positions_sphere")
    assert call(capsys, "positions", clean, *SI, *words)[0] == 0
    assert "<svg" in (folder / "f.svg").read_text(encoding="utf-8")


@pytest.mark.parametrize("fault", FAULTS)
def test_mistake_is_named(capsys: pytest.CaptureFixture[str], tmp_path: Path, fault: str) -> None:
    bench = replace(SMALL, dwell=5.0) if fault == "knocked" else SMALL  # long enough that both halves are rests
    content = call_json(capsys, "positions", *written(tmp_path, FAULTS[fault].put_into(bench)), *SI)
    codes = {one["code"] for one in (*content["errors"], *content["remarks"])}
    assert FAULTS[fault].shows in codes
    disagrees = any(one["severity"] == "error" for one in content["remarks"])  # figures, and no model
    assert content["exit"] == (3 if content["errors"] else 4 if disagrees else 0)
    assert all(one["do"] for one in content["errors"])


def split(folder: Path, path: str) -> tuple[Recording, str, str]:
    """Write accelerometers and gyros into files without a header; return the recording and both paths."""
    recording = read(path)
    assert recording.seconds is not None
    for sensor in ("acc", "gyro"):
        values = recording.array([f"{sensor}_{axis}" for axis in "xyz"])
        np.savetxt(folder / f"{sensor}.mat", np.column_stack([recording.seconds, values]), fmt="%.7f")
    return recording, str(folder / "acc.mat"), str(folder / "gyro.mat")


def test_two_files_of_one_clock_are_one_recording(
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    clean: str,
    found: dict[str, Any],
) -> None:
    _, acc, gyro = split(tmp_path, clean)
    content = call_json(capsys, "positions", gyro, acc, *SI)
    assert "axes_in_order" in {one["code"] for one in content["remarks"]}
    one, other = by_sensor(content), by_sensor(found)
    for key in (("accelerometer", "bias", "x"), ("gyro", "scale_factor_error", "y"), ("gyro", "bias", "z")):
        assert one[key]["value"] == pytest.approx(other[key]["value"], rel=1e-3)
    lines = Path(gyro).read_text(encoding="utf-8").splitlines(keepends=True)
    (tmp_path / "late_gyro.mat").write_text("".join(lines[100:]), encoding="utf-8")
    late = call_json(capsys, "positions", acc, str(tmp_path / "late_gyro.mat"), *SI)
    assert "joined_by_stamps" in {one["code"] for one in late["remarks"]}
    afterwards = [f"{float(line.split()[0]) + 1e4:.7f} {line.split(maxsplit=1)[1]}" for line in lines]
    (tmp_path / "late_gyro.mat").write_text("".join(afterwards), encoding="utf-8")
    status, _, err = call(capsys, "positions", acc, str(tmp_path / "late_gyro.mat"), *SI)
    assert status == 3
    assert "not of one clock" in err
    assert "samples from 10000" in err


@pytest.fixture(scope="module")
def ferraris(tmp_path_factory: pytest.TempPathFactory) -> tuple[str, str, list[str]]:
    """Return a record of six faces and three turns, its protocol, and its labels in order."""
    folder = tmp_path_factory.mktemp("ferraris")
    path = written(folder, ONCE)[0]
    sections = protocol(ONCE)
    labels = [label for label in sections if not label.endswith("rot")]
    (folder / "sections.json").write_text(json.dumps(sections), encoding="utf-8")
    return path, str(folder / "sections.json"), labels


STATED = (
    "--standard", "turn.angle=0.002 rad", "--standard", "fixture.orientation=0.002 rad",
    "--standard", "fixture.mounting=0.002 rad", "--standard", "gravity.value=0.0003 m/s2",
    "--standard", "clock.rate=20 ppm",
)  # fmt: skip


def test_labelled_parts_of_faces_and_turns(
    capsys: pytest.CaptureFixture[str], ferraris: tuple[str, str, list[str]]
) -> None:
    path, sections, _ = ferraris
    content = call_json(capsys, "positions", path, *SI, "--sections", sections, *STATED)
    rows = by_sensor(content)
    for true in build(ONCE, 1).truth:
        row = rows[true.sensor, true.quantity, true.axis]
        if true.quantity == "scale_factor_error":
            assert row["value"] == pytest.approx(100.0 * true.value, abs=5.0 * row["u"]), true
    assert "relative_to_fixture" not in {one["code"] for one in content["remarks"]}
    beside = [row for row in content["results"] if case_name(row) == "as_published"]
    assert len(beside) == 15 + 15 + 9  # K, R and b of both sensors, K_ga
    assert {(row["u"], row["interval"]) for row in beside} == {(None, None)}
    form = {key: row["value"] for key, row in by_sensor(content, WAY).items()}
    for true in build(ONCE, 1).truth:
        if true.quantity == "scale_factor_error":
            assert form[true.sensor, "scale_factor", true.axis] == pytest.approx(1.0 + true.value, abs=3e-3), true
        if true.quantity == "misalignment" and true.sensor == "accelerometer" and abs(true.value) > 8e-3:
            assert form[true.sensor, "direction_cosine", true.axis] == pytest.approx(true.value, abs=6e-3), true
    turned = call_json(capsys, "positions", path, *SI, "--sections", sections, "--turn", "-360 deg")
    assert [one["severity"] for one in turned["remarks"] if one["code"] == "turn_sense"] == ["error"]


def test_a_sense_that_nobody_stated_is_a_warning(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, ferraris: tuple[str, str, list[str]]
) -> None:
    table = np.genfromtxt(ferraris[0], delimiter=",", names=True)
    for axis in "xyz":
        table[f"gyro_{axis}"] *= -1.0
    path = tmp_path / "clockwise.csv"
    np.savetxt(path, table, "%.12g", ",", header=",".join(table.dtype.names or ()), comments="")
    found = call_json(capsys, "positions", str(path), *SI, "--sections", ferraris[1])
    (remark,) = (one for one in found["remarks"] if one["code"] == "turn_sense")
    assert remark["severity"] == "warning"
    assert "--turn=-360deg" in remark["do"]
    mended = call_json(capsys, "positions", str(path), *SI, "--sections", ferraris[1], "--turn=-360deg")
    assert "turn_sense" not in {one["code"] for one in mended["remarks"]}


def test_a_file_a_position(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, ferraris: tuple[str, str, list[str]]
) -> None:
    path, sections, _ = ferraris
    lines = Path(path).read_text(encoding="utf-8").splitlines(keepends=True)
    named = []
    for label, ends in json.loads(Path(sections).read_text(encoding="utf-8")).items():
        part = tmp_path / f"{label}.csv"
        part.write_text("".join([lines[0], *lines[1 + ends["start"] : 1 + ends["end"]]]), encoding="utf-8")
        named.append(f"{label}={part}")
    whole = call_json(capsys, "positions", path, *SI, "--sections", sections, *STATED)
    parts = call_json(capsys, "positions", *named, *SI, *STATED)
    assert len(parts["inputs"]) == 9
    values = [[row["value"] for row in content["results"]] for content in (whole, parts)]
    for one, other in zip(*values, strict=True):
        assert (one is None) == (other is None)
        assert one is None or other == pytest.approx(one, rel=1e-3, abs=1e-6)


def test_table_a_row_a_position(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    rows = ["position,acc_x [g],acc_y [g],acc_z [g],acc_x_std,acc_y_std,acc_z_std,samples"]
    bias, scale, noise = np.array([0.01, -0.02, 0.03]), np.array([1.01, 0.99, 1.0]), np.random.default_rng(1)
    for sign, word in ((1.0, "+"), (-1.0, "-")):
        for k, axis in enumerate("xyz"):
            for _ in range(2):
                mean = scale * sign * np.eye(3)[k] + bias + noise.normal(0.0, 1e-5, 3)
                rows.append(",".join([f"{axis}{word}", *(f"{value:.7f}" for value in mean), *["1e-4"] * 3, "100"]))
    path = tmp_path / "table.csv"
    path.write_text("\n".join(rows), encoding="utf-8")
    content = call_json(capsys, "positions", str(path), "--gravity", "1 g")
    found = {(row["quantity"], row["axis"]): row for row in content["results"]}
    for k, axis in enumerate("xyz"):
        assert found["bias", axis]["unit"] == "g"
        assert found["bias", axis]["value"] == pytest.approx(bias[k], abs=3e-5)
        assert found["scale_factor_error", axis]["value"] == pytest.approx(100.0 * (scale[k] - 1.0), abs=3e-3)
    assert "table_of_positions" in {one["code"] for one in content["remarks"]}
    text = path.read_text(encoding="utf-8").replace("x+", "sideways", 1)
    path.write_text(text, encoding="utf-8")  # one word that is none: directions are not taken from the others
    unknown = call_json(capsys, "positions", str(path), "--gravity", "1 g")
    assert all(row["reason"] for row in unknown["results"] if row["status"] == "not_estimated")


@pytest.mark.parametrize(
    ("words", "status", "said"),
    [
        ((), 2, "no unit, or several"),
        (("--unit", "acc=deg/s", "--unit", "gyro=rad/s"), 2, "deg/s"),
        ((*SI, "--orientations", "x+,x-"), 3, "2 orientations for 14 positions"),
        ((*SI, "--orientations", "x+,up"), 2, "position 2: 'up'"),
        ((*SI, "--orientations", "faces"), 3, "deg away from any face"),
        ((*SI, "--acc-zero", "much"), 2, "'much' is not a number"),
        ((*SI, "--turn", "360"), 2, "turn"),
        ((*SI, "--standard", "turn.angle=1 m"), 2, "turn.angle"),
        ((*SI, "--standard", "turn=1 deg"), 2, "turn"),
        ((*SI, "--column", "ax=acc_x"), 2, "There are: acc_x, acc_y"),
        ((*SI, "--sections", "nowhere"), 3, "nowhere"),
        ((*SI, "--shortest", "60 s"), 3, "never lies still for 60 s"),
        ((*SI, "--figure", "positions_sphere"), 2, "-o"),
        ((*SI, "-o", "figure.gif"), 2, "End the name with one of"),
    ],
)
def test_wrong_word_is_told(
    capsys: pytest.CaptureFixture[str], clean: str, words: tuple[str, ...], status: int, said: str
) -> None:
    left, out, err = call(capsys, "positions", clean, *words)
    assert (left, out) == (status, "")
    assert said in " ".join(err.split())


def test_words_before_files(capsys: pytest.CaptureFixture[str], clean: str) -> None:
    assert "given twice" in call(capsys, "positions", clean, clean, *SI)[2]
    assert "is not a sensor, position or turn" in call(capsys, "positions", f"top={clean}", *SI)[2]
    assert "no recording of accelerometers" in call(capsys, "positions", f"gyro={clean}", *SI)[2]

"""The command line as a user meets it: output, exit status, one clear message for bad input."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
import pytest

from inertialcal.core.schema.results import Printed, Surveyed
from inertialcal.core.show.rows import case_name
from typed_commands import call

Write = Callable[..., Path]
EXAMPLE = Path(__file__).resolve().parents[2] / "src/inertialcal/examples/npsat2011"
ENVELOPE = {"command", "version", "inputs", "results", "remarks", "verdicts", "errors", "exit"}


def call_json(capsys: pytest.CaptureFixture[str], *words: str) -> dict[str, Any]:
    status, out, _ = call(capsys, *words, "--json")
    content: dict[str, Any] = json.loads(out)
    assert set(content) >= ENVELOPE
    assert content["exit"] == status
    return content


@pytest.fixture
def example(tmp_path: Path) -> Path:
    target = tmp_path / "npsat2011"
    shutil.copytree(EXAMPLE, target, ignore=shutil.ignore_patterns("out"))
    return target


def test_run_of_the_published_campaign(capsys: pytest.CaptureFixture[str], example: Path) -> None:
    content = call_json(capsys, "run", str(example))
    assert content["exit"] == 4  # at 0.1 deg/s the interval is wider than the limit
    on_disk = json.loads((example / "out/results.json").read_text())
    assert content["results"] == on_disk["results"]
    assert {one["path"] for one in content["inputs"]} >= {"campaign.toml", "table10_x.csv"}
    rows = {(r["test"], r["quantity"], r["axis"], case_name(r)): r for r in content["results"]}
    # Errata: the rates down to which every row is within 5 % are 0.2 deg/s directly; 0.06, 0.09, 0.08 with reference.
    for axis, rate in (("x", 0.06), ("y", 0.09), ("z", 0.08)):
        assert rows[f"rate_{axis}_minus_ref", "resolution", axis, "as_published"]["value"] == pytest.approx(rate)
        assert rows[f"rate_{axis}", "resolution", axis, "as_published"]["value"] == pytest.approx(0.2)
    missing = {
        (r["test"], r["axis"]) for r in content["results"]
        if r["quantity"] == "misalignment" and r["status"] == "not_estimated" and not case_name(r)
        and not r["test"].endswith(("_set1", "_set2")) and r["test"] != "model"
    }  # fmt: skip
    assert len(missing) == 12
    assert all(row["u"] is not None or row["status"] != "estimated" for row in content["results"])
    assert all(row["reason"] for row in content["results"] if row["status"] == "not_estimated")


def test_run_text_names_verdicts_and_remarks(capsys: pytest.CaptureFixture[str], example: Path) -> None:
    status, out, err = call(capsys, "run", str(example))
    assert status == 4
    assert "overall: INCONCLUSIVE" in out
    assert "87 times" in out  # Table 10, X, +2 deg/s, set 2
    assert "12/12 model and requirements" in err
    status, out, _ = call(capsys, "run", str(example), "--quiet")
    assert (status, out) == (4, "")


def test_rerun_shows_what_changed(capsys: pytest.CaptureFixture[str], campaign: Write) -> None:
    folder = campaign()
    assert call_json(capsys, "run", str(folder))["changed"] == []
    assert call_json(capsys, "run", str(folder))["changed"] == []
    campaign(('limit = "5 %"', 'limit = "1.2 %"'))
    changed = call_json(capsys, "run", str(folder))["changed"]
    assert any("R1" in line and "->" in line for line in changed)


def test_a_refused_run_leaves_the_old_results(capsys: pytest.CaptureFixture[str], campaign: Write) -> None:
    folder = campaign()
    call(capsys, "run", str(folder), "-q")
    before = {path.name: path.read_bytes() for path in (folder / "out").iterdir()}
    campaign(data="rate,x,std,set,run\n1,abc,0.1,1,1\n")
    assert call(capsys, "run", str(folder))[0] == 3
    assert {path.name: path.read_bytes() for path in (folder / "out").iterdir()} == before
    assert not [path for path in folder.iterdir() if path.name.startswith(".out")]


@pytest.mark.slow  # half a minute
def test_same_bytes_whatever_the_threads(example: Path) -> None:
    hashes = []
    for number in ("1", "2"):
        environment = dict(os.environ, OMP_NUM_THREADS=number, OPENBLAS_NUM_THREADS=number, NUMBA_NUM_THREADS=number)
        words = [sys.executable, "-m", "inertialcal.cli", "run", str(example), "-q"]
        subprocess.run(words, env=environment, check=False, timeout=60)
        hashes.append((example / "out/results.json").read_bytes())
    assert hashes[0] == hashes[1]


def test_check_says_what_comes_next(capsys: pytest.CaptureFixture[str], campaign: Write) -> None:
    status, out, _ = call(capsys, "check", str(campaign()))
    assert status == 0
    assert "Next: inertialcal run" in out


def table(reading: str = "1.0", rate: str = "1.0", std: str = "0.004") -> str:
    lines = ["rate,x,std,set,run", *(f"{r},{r},0.004,1,1" for r in (-2, -1, 1, 2))]
    return "\n".join([*lines, f"{rate},{reading},{std},1,1"]) + "\n"


BAD_DATA = [
    (table("abc"), "text_in_numbers", "one.csv:6", "abc"),
    (table("NaN"), "nan_in_required", "one.csv:6", "NaN"),
    (table(std="-1"), "", "one.csv:6", "negative"),
    ("", "empty_file", "one.csv", ""),
    ("rate,y\n1,2\n", "wrong_column", "one.csv", "no column 'run'"),
    ("rate,x,std,set,run\n", "", "one.csv", ""),
]


@pytest.mark.parametrize(("data", "code", "where", "words"), BAD_DATA)
def test_bad_tables(
    capsys: pytest.CaptureFixture[str], campaign: Write, data: str, code: str, where: str, words: str
) -> None:
    content = call_json(capsys, "run", str(campaign(data=data)))
    assert content["exit"] == 3
    problem = content["errors"][0]
    assert problem["where"].startswith(where), problem
    assert words in problem["what"]
    assert code in {"", problem["code"]}


def test_an_empty_cell_is_missing_counted_and_remarked(capsys: pytest.CaptureFixture[str], campaign: Write) -> None:
    content = call_json(capsys, "run", str(campaign(data=table(reading=""))))
    remark = next(one for one in content["remarks"] if one["code"] == "empty_cells")
    assert remark["count"] == 1
    assert "one.csv:6" in remark["where"]
    assert content["exit"] in {0, 1, 4}


def test_a_code_outside_the_converter_is_refused(capsys: pytest.CaptureFixture[str], campaign: Write) -> None:
    counts = 'run = "run", unit = "count", applied_unit = "deg/s" }'
    folder = campaign(
        ('run = "run", unit = "deg/s" }', counts),
        data="rate,x,std,set,run\n-1,1600,3,1,1\n1,5000,3,1,1\n2,2900,3,1,1\n",
    )
    problem = call_json(capsys, "run", str(folder))["errors"][0]
    assert problem["code"] == "code_outside"
    assert problem["where"] == "one.csv:3"
    assert "5000" in problem["what"]


def test_counts_go_through_the_chain(capsys: pytest.CaptureFixture[str], campaign: Write) -> None:
    lines = ["rate,x,std,set,run"]
    for run in range(6):
        for rate in (-4.0, -2.0, 2.0, 4.0):
            lines.append(f"{rate},{(2.5 + 0.5 * (1.01 * rate + 0.02)) * 4095 / 5:.3f},3.3,1,{run}")
    counts = 'run = "run", unit = "count", applied_unit = "deg/s" }'
    folder = campaign(('run = "run", unit = "deg/s" }', counts), data="\n".join(lines) + "\n")
    rows = {r["quantity"]: r for r in call_json(capsys, "run", str(folder))["results"] if not case_name(r)}
    assert rows["scale_factor_error"]["value"] == pytest.approx(1.0, abs=1e-3)  # %
    assert rows["bias"]["status"] == "not_estimated"  # the reading at rest was subtracted
    assert rows["residual_bias"]["value"] == pytest.approx(0.02, abs=1e-5)  # deg/s
    assert rows["scale_factor"]["value"] == pytest.approx(0.505, abs=1e-5)  # V/(deg/s)


@pytest.mark.parametrize(
    ("words", "status", "text"),
    [
        (("run", "nowhere"), 3, "No campaign here"),
        (("run",), 2, "Missing argument"),
        (("rum", "x"), 2, "No such command"),
        (("info", "nothing.csv"), 3, "nothing.csv"),
        (("run", ".", "--nonsense"), 2, "--nonsense"),
        (("info", "x", "--unit", "deg="), 2, "NAME=SOMETHING"),
        (("init", "nowhere"), 2, "No such folder"),
    ],
)
def test_wrong_calls(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...],
    status: int, text: str,
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    found, _, err = call(capsys, *words)
    assert found == status
    assert text in err
    content = call_json(capsys, *words)
    assert text in content["errors"][0]["what"] + content["errors"][0]["where"]


def test_no_campaign_points_to_the_demo(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    _, _, err = call(capsys, "check", str(tmp_path))
    assert "No campaign here" in err
    assert "Try: inertialcal demo" in err


def test_demo_ends_with_zero_and_uses_its_own_copy(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    status, out, _ = call(capsys, "demo")
    assert status == 0
    assert "overall: " in out
    assert "misalignment            zy" in out  # all of the matrix beside its truth
    assert "bias_temperature_3      z" in out
    assert "vacuum_offset           x" in out
    assert "stated 95 % intervals hold the truth" in out
    assert (tmp_path / "inertialcal-demo-npsat1/out/report.html").is_file()
    assert call(capsys, "demo", "npsat2011")[0] == 0
    assert (tmp_path / "inertialcal-demo/out/results.json").is_file()
    (tmp_path / "other").mkdir()
    (tmp_path / "other/file").write_text("mine")
    assert call(capsys, "demo", "npsat2011", "-o", "other")[0] == 2
    status, _, err = call(capsys, "demo", "npsat2011", "-o", "inertialcal-demo-npsat1")
    assert status == 2
    assert "holds another campaign" in err
    status, _, err = call(capsys, "demo", "other")
    assert status == 2
    assert "no example 'other'" in err
    assert "rate_table" in err


def test_demo_of_a_rig_alone_says_how_many_intervals_hold(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    content = call_json(capsys, "demo", "rate_table")
    assert content["example"] == "rate_table"
    assert 0 < content["score"]["inside"] <= content["score"]["estimated"]
    assert not (tmp_path / "inertialcal-demo").exists()


def test_init_writes_a_file_that_check_accepts_once_filled(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    folder = tmp_path / "my campaign"
    folder.mkdir()
    shutil.copy(EXAMPLE / "table10_x.csv", folder)
    (folder / "table.csv").write_text(
        "rate_dps,x_dps,y_dps,std_dps,run\n1,1.01,0.001,0.1,1\n-1,-1.01,0.001,0.1,2\n2,2,0,.1,3\n"
    )
    content = call_json(capsys, "init", str(folder))
    path = folder / "campaign.toml"
    lines = path.read_text().splitlines()
    assert content["to_fill"]
    assert all(lines[number - 1].endswith("# FILL IN") for number in content["to_fill"])
    refused = call_json(capsys, "check", str(folder))
    assert [one["where"] for one in refused["errors"]] == [f"campaign.toml:{n}" for n in content["to_fill"]]
    filled = [line.replace('axis = "?"', 'axis = "x"').replace('"?"', '"deg/s"') for line in lines]
    filled = [line.removesuffix("# FILL IN").rstrip() for line in filled]
    path.write_text("\n".join(filled) + "\n")
    status, _, err = call(capsys, "check", str(folder))
    assert (status, err) == (0, "")
    assert call(capsys, "init", str(folder))[0] == 3  # never written over


def test_init_takes_recordings_with_gyro_channels(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    noise = np.random.default_rng(1).integers(0, 7, 6000)
    rows = [f"{0.01 * i:.2f},{(i // 500) % 3 - 1},{(i // 500) % 3 - 1 + 0.01 * noise[i]:.2f},0,0" for i in range(6000)]
    (tmp_path / "log.csv").write_text(
        "t [s],table,gyro_x [deg/s],gyro_y [deg/s],gyro_z [deg/s]\n" + "\n".join(rows) + "\n"
    )
    assert call(capsys, "init", str(tmp_path))[0] == 0
    path = tmp_path / "campaign.toml"
    text = path.read_text()
    assert '[[tests]]\nid = "rate"' in text
    text = text.replace('applied = { column = "?", unit = "?" }', 'applied = { column = "table", unit = "deg/s" }')
    text = text.replace('axis = "?"', 'axis = "x"').replace('run = "?"', 'run = "1"').replace('"? s"', '"0.01 s"')
    path.write_text("\n".join(line.removesuffix("# FILL IN").rstrip() for line in text.splitlines()) + "\n")
    status, _, err = call(capsys, "check", str(tmp_path))
    assert (status, err) == (0, "")
    rows_found = call_json(capsys, "run", str(tmp_path))["results"]
    error = next(r for r in rows_found if r["quantity"] == "scale_factor_error" and r["test"] == "rate")
    assert error["value"] == pytest.approx(0.0, abs=0.2)  # [%]


def test_rate_table_of_a_file(capsys: pytest.CaptureFixture[str]) -> None:
    path = str(EXAMPLE / "table10_x.csv")
    content = call_json(
        capsys, "rate-table", path, "--reading", "reading_no_ref_dps", "--axis", "x", "--unit", "deg/s",
        "--scale-factor", "0.5 V/(deg/s)", "--range", "5 deg/s",
    )  # fmt: skip
    rows = {(r["quantity"], case_name(r)): r for r in content["results"]}
    assert rows["scale_factor", "as_published"]["value"] == pytest.approx(0.49979, abs=4e-5)  # Appendix H1
    status, _, err = call(capsys, "rate-table", path, "--axis", "x")
    assert status == 2
    assert "--reading COLUMN" in err


def refuse(monkeypatch: pytest.MonkeyPatch, error: BaseException) -> None:
    """Let reading a campaign end so."""

    def load(*words: object) -> NoReturn:
        raise error

    monkeypatch.setattr("inertialcal.campaign.file.load.load", load)


def test_interrupt_ends_with_130(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, campaign: Write
) -> None:
    refuse(monkeypatch, KeyboardInterrupt())
    assert call(capsys, "run", str(campaign()))[0] == 130


def test_our_own_fault_ends_with_70_and_a_log(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, campaign: Write
) -> None:
    refuse(monkeypatch, ZeroDivisionError("ours"))
    status, _, err = call(capsys, "run", str(campaign()))
    assert status == 70
    log = Path(err.split("report it with ")[1].strip().split("\n")[0])
    assert "ZeroDivisionError" in log.read_text()
    log.unlink()


def test_a_closed_pipe_does_not_change_the_verdict(example: Path) -> None:
    words = f"{sys.executable} -m inertialcal.cli run {example} --json | head -c 20 >/dev/null; echo ${{PIPESTATUS[0]}}"
    done = subprocess.run(["bash", "-c", words], capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout.strip() == "4"


def test_a_rate_without_a_reading_is_no_pass(capsys: pytest.CaptureFixture[str], campaign: Write) -> None:
    lines = ["rate,x,std,set,run"]
    for run in range(1, 7):
        for rate in (-4.0, -2.0, 2.0, 4.0):
            lines.append(f"{rate},{'' if rate == 4.0 else rate + 0.001 * run},0.004,1,{run}")
    content = call_json(capsys, "run", str(campaign(data="\n".join(lines) + "\n")))
    assert content["exit"] == 4
    missing = next(v for v in content["verdicts"] if v["at"] == 4.0)
    assert missing["verdict"] == "INCONCLUSIVE"
    assert "no reading at this rate" in missing["reason"]


def test_one_sense_of_rotation_is_no_pass_for_both(capsys: pytest.CaptureFixture[str], campaign: Write) -> None:
    lines = [
        "rate,x,std,set,run",
        *(f"{r},{r + 0.001 * n},0.004,1,{n}" for n in range(1, 7) for r in (0.0, 1.0, 2.0, 4.0)),
    ]
    content = call_json(capsys, "run", str(campaign(data="\n".join(lines) + "\n")))
    assert content["exit"] == 4
    assert any(one["reason"] == "negative rates were not turned" for one in content["verdicts"])
    assert any(one["code"] == "one_sense" for one in content["remarks"])


def test_info_prints_rows_of_the_published_schema(campaign: Write, capsys: pytest.CaptureFixture[str]) -> None:
    printed = Printed.model_validate_json(call(capsys, "info", str(campaign() / "one.csv"), "--json")[1])
    assert isinstance(printed.results[0], Surveyed)

"""-o of rate-table, info and show, as a user meets it; show of results."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from inertialcal.campaign.engine.run import run
from inertialcal.campaign.file.example import copy_example
from inertialcal.cli.__main__ import main
from inertialcal.report.figures import figures
from written_rows import sealed_text

Call = Callable[..., tuple[int, str, str]]
TABLE = "rate [deg/s],gyro_x [deg/s],run\n" + "".join(
    f"{rate},{1.01 * rate + 0.001 * ((3 * run + rate) % 5)},{run}\n" for run in range(1, 6) for rate in (-40, 10, 40)
)


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("figures") / "demo"
    copy_example("npsat2011", folder)
    run(folder)
    return folder


@pytest.fixture
def call(capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Call:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "x.csv").write_text(TABLE)
    (tmp_path / "timed.csv").write_text("t_s,gyro_x_dps\n" + "".join(f"{i / 10},{i % 7}\n" for i in range(50)))

    def typed(*words: Any) -> tuple[int, str, str]:
        with pytest.raises(SystemExit) as left:
            main([str(word) for word in words])
        out, err = capsys.readouterr()
        assert "Traceback" not in out + err
        assert "internal error" not in err
        return int(left.value.code or 0), out, err

    return typed


def test_rate_table_writes_a_figure_beside_its_table(call: Call) -> None:
    status, out, _ = call("rate-table", "x.csv", "-o", "x.png")
    assert status == 0
    assert "scale_factor_error" in out
    assert out.rstrip().endswith("written: x.png (input_output axis x)")
    assert Path("x.png").read_bytes().startswith(b"\x89PNG")
    status, out, _ = call("rate-table", "x.csv", "-o", "x.svg", "--figure", "rate_error", "--json")
    assert (json.loads(out)["written"], status) == (["x.svg"], 0)


def test_info_draws_the_channels_of_one_file(call: Call) -> None:
    status, out, _ = call("info", "timed.csv", "-o", "timed.pdf")
    assert status == 0
    assert out.rstrip().endswith("written: timed.pdf (recording)")
    assert Path("timed.pdf").read_bytes().startswith(b"%PDF")
    status, _, err = call("info", "timed.csv", "x.csv", "-o", "both.png")
    assert (status, Path("both.png").exists()) == (2, False)
    assert "a figure of one file, 2 were named" in err
    assert call("info", "absent.csv", "-o", "a.png")[0] == 3
    assert not Path("a.png").exists()


def test_show_draws_a_model_by_its_folder_and_results_by_theirs(call: Call, campaign: Path) -> None:
    status, out, _ = call("show", campaign, "-o", "m.png")
    assert (status, out) == (0, "written: m.png (matrix test model)\n")
    out_folder = campaign / "out"
    words = ("--figure", "rate_error", "--test", "rate_y", "--axis", "y", "-o", "e.svg")
    for place in (campaign, out_folder, out_folder / "results.json"):
        status, out, _ = call("show", place, *words)
        assert (status, out) == (0, "written: e.svg (rate_error test rate_y axis y)\n")
    assert "written: c.png (compensated" in call("show", out_folder, "-o", "c.png")[1]
    status, out, _ = call("show", out_folder, "--figure", "rate_error", "-o", "f.png")
    assert "11 more with --test or --axis: rate_error test" in out


def test_show_of_results_prints_what_run_prints(call: Call, campaign: Path) -> None:
    status, out, _ = call("show", campaign / "out" / "results.json")
    assert status == 0
    assert "rate_x_set1" in out
    assert "closed loop, on readings held out: PASS" in out
    assert "INCONCLUSIVE at" in out
    content = json.loads(call("show", campaign / "out", "--json")[1])
    on_disk = json.loads((campaign / "out" / "results.json").read_text())
    assert content["results"] == on_disk["results"]
    assert content["inputs"][0]["path"].endswith("results.json")
    assert call("show", campaign / "out", "-q")[1] == ""


@pytest.mark.parametrize("command", [("rate-table", "x.csv"), ("info", "timed.csv"), ("show", "out")])
def test_an_unknown_ending_is_wrong_usage(call: Call, command: tuple[str, ...]) -> None:
    status, _, err = call(*command, "-o", "a.gif")
    assert status == 2
    assert ".png, .svg, .pdf" in err


def test_an_unknown_figure_is_wrong_usage_and_absent_data_a_refusal(call: Call, campaign: Path) -> None:
    for words in (("rate-table", "x.csv"), ("show", campaign)):
        status, _, err = call(*words, "--figure", "pie", "-o", "a.png")
        assert status == 2
        assert f"There are: {', '.join(figures())}" in " ".join(err.split())
    status, _, err = call("show", campaign, "--figure", "dwells", "-o", "a.png")
    assert status == 3
    assert "no data for figure 'dwells'" in err
    for option in ("--figure", "--test", "--axis"):
        status, _, err = call("show", campaign, option, "x")
        assert status == 2
        assert "Say it: -o figure.png" in err
    assert not Path("a.png").exists()


def test_an_input_is_not_overwritten(call: Call, campaign: Path) -> None:
    Path("x.csv").rename("x.png")
    status, _, err = call("rate-table", "x.png", "-o", "x.png")
    assert status == 3
    assert "would overwrite the input" in err
    assert Path("x.png").read_text() == TABLE
    results = campaign / "out" / "results.json"
    Path("r.svg").symlink_to(results)
    before = results.read_bytes()
    assert call("show", results, "-o", "r.svg")[0] == 3
    assert results.read_bytes() == before


@pytest.mark.parametrize(
    "content",
    [
        '{"results": 1}', '{"results": [1]}', '{"results": [{"test": "a"}]}', '{"results": null}',
        '{"results": [], "curves": [{"name": "rate_error"}], "verdicts": 3}',
        '{"results": [], "curves": [{"name": "rate_error", "columns": {"rate": 1}}]}',
        '{"results": [], "curves": [{"name": "compensated", "columns": {"applied": {"values": ["a"]}}}]}',
        '{"results": [], "budgets": [{"share": "x", "test": "t"}]}',
    ],
)  # fmt: skip
def test_results_that_are_none_are_refused_not_a_fault(call: Call, content: str) -> None:
    Path("bad.json").write_text(sealed_text(json.loads(content) | {"schema": 2}))
    assert call("show", "bad.json", "-o", "a.png")[0] == 3
    assert call("show", "bad.json")[0] in (0, 3)
    assert not Path("a.png").exists()


def test_a_folder_takes_every_axis_of_a_figure_on_as_many_files_as_it_needs(call: Call) -> None:
    rows = (f"{k / 20},{k % 7 - 3},{k % 5 - 2},{k % 3 - 1}\n" for k in range(2000))
    Path("rack.csv").write_text("time [s],acc_x [ug],acc_y [ug],acc_z [ug]\n" + "".join(rows))
    status, out, _ = call("microgravity", "rack.csv", "--block", "10 s", "-o", "out", "--json")
    bands = sorted(Path(one).name for one in json.loads(out)["written"] if "bands" in one)
    assert (status, bands) == (0, ["microgravity_bands_microgravity.png", "microgravity_bands_microgravity_2.png"])
    assert all(Path("out", one).read_bytes().startswith(b"\x89PNG") for one in bands)  # three of four axes on the first

"""Models for several conditions in one file: which is applied, shown, handed out and compared, and what is refused."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import inertialcal as ic
from inertialcal.cli.__main__ import main
from inertialcal.core.errors import DataError, UsageError
from inertialcal.core.estimate import Component, Estimate
from inertialcal.core.units import factor
from inertialcal.files import read
from inertialcal.files.models.model_json import write_model
from inertialcal.sensors.model.assemble import model_from
from inertialcal.sensors.model.model_set import ModelSet
from inertialcal.sensors.model.sensitivity import Sensitivity
from inertialcal.sensors.model.sensor_model import Item, SensorModel

AIR, VACUUM = (90e3, 110e3), (0.0, 1e-2)  # [Pa]
BIAS = {"air": 0.03, "vacuum": -0.02}  # [deg/s]
PER_VOLT = 0.4  # [deg/s/V]


def of(condition: str, between: tuple[float, float], **more: Any) -> SensorModel:
    scatter = Component("scatter", "A", np.diag([1e-10] * 3), 7.0)
    values = np.full(3, BIAS[condition] * factor("deg/s", "rad/s"))
    estimate = Estimate(tuple(f"bias_{a}" for a in "xyz"), values, ("rad/s",) * 3, (scatter,))
    model = model_from(
        estimate, "gyro", ("x", "y", "z"), 0.5 / factor("deg/s", "rad/s"), "V", item=Item(serial="7"), judged=True
    )
    return replace(model, condition=condition, pressure_range=between, **more)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    write_model(tmp_path / "both.json", ModelSet((of("air", AIR), of("vacuum", VACUUM))))
    write_model(tmp_path / "air.json", of("air", AIR))
    for name, pressures in (("air", (1013, 1000)), ("vacuum", (1e-8, 2e-8)), ("mixed", (1013, 1e-8))):
        rows = "\n".join(f"{i},1,2,3,{p},5" for i, p in enumerate(pressures))
        Path(f"{name}.csv").write_text(f"t_s,gyro_x_dps,gyro_y_dps,gyro_z_dps,pressure [hPa],supply [V]\n{rows}\n")
    Path("unsaid.csv").write_text("t_s,gyro_x_dps,gyro_y_dps,gyro_z_dps\n0,1,2,3\n1,1,2,3\n")
    return tmp_path


def typed(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, dict[str, Any]]:
    with pytest.raises(SystemExit) as left:
        main([*words, "--json"])
    content: dict[str, Any] = json.loads(capsys.readouterr().out)
    return int(left.value.code or 0), content


@pytest.mark.parametrize("condition", ["air", "vacuum"])
def test_pressure_of_the_data_says_which_model(
    folder: Path, capsys: pytest.CaptureFixture[str], condition: str
) -> None:
    status, content = typed(capsys, "compensate", "both.json", f"{condition}.csv", "-o", "o.csv")
    assert (status, content["condition"]) == (0, condition)
    assert read("o.csv").channels[0].data == pytest.approx(1.0 - BIAS[condition])


@pytest.mark.parametrize(
    ("model", "data", "condition", "status", "code", "said"),
    [
        ("both.json", "unsaid.csv", "", 2, "condition_needed", "--condition air"),
        ("both.json", "mixed.csv", "", 3, "wrong_condition", "Cut out"),
        ("both.json", "vacuum.csv", "air", 3, "wrong_condition", "--condition vacuum"),
        ("both.json", "mixed.csv", "air", 3, "wrong_condition", "No condition"),
        ("air.json", "vacuum.csv", "", 3, "wrong_condition", "no other model"),
        ("both.json", "air.csv", "space", 2, "no_such_condition", "air, vacuum"),
    ],
)
def test_the_wrong_condition_is_refused(
    folder: Path,
    capsys: pytest.CaptureFixture[str],
    model: str,
    data: str,
    condition: str,
    status: int,
    code: str,
    said: str,
) -> None:
    words = ["--condition", condition] if condition else []
    got, content = typed(capsys, "compensate", model, data, "-o", "o.csv", *words)
    (error,) = content["errors"]
    assert (got, error["code"], said in error["do"]) == (status, code, True), error
    if code == "wrong_condition":
        counted = "1 of 2" if condition else "1 in air, 1 in vacuum"
        assert (counted if data == "mixed.csv" else "2 of 2 row(s)") in error["what"]


VACUUM_GAUGES = {
    "unit.csv": ("pressure", "1e-8"),
    "two.csv": ("gauge_1_pressure [hPa],gauge_2_pressure [Pa]", "1013,1e-6"),
    "named.csv": ("pressure [Pa],chamber_pressure [hPa]", "1e-6,1013"),
    "some.csv": ("pressure [Pa]", ""),
}


@pytest.mark.parametrize(
    ("data", "words", "status", "code"),
    [
        ("unit.csv", (), 3, "no_unit"),
        ("unit.csv", ("--unit", "pressure=Torr"), 3, "wrong_condition"),
        ("two.csv", (), 3, "wrong_column"),
        ("two.csv", ("--column", "pressure=gauge_2_pressure"), 3, "wrong_condition"),
        ("named.csv", (), 3, "wrong_condition"),
        ("some.csv", (), 0, "condition_not_checked"),
    ],
)
def test_a_pressure_is_never_overlooked(
    folder: Path, capsys: pytest.CaptureFixture[str], data: str, words: tuple[str, ...], status: int, code: str
) -> None:
    """The sensor is in vacuum, and the model of air is asked for."""
    head, cells = VACUUM_GAUGES[data]
    Path(data).write_text(f"t_s,gyro_x_dps,gyro_y_dps,gyro_z_dps,{head}\n0,1,2,3,{cells}\n1,1,2,3,{cells}\n")
    got, content = typed(capsys, "compensate", "both.json", data, "-o", "o.csv", "--condition", "air", *words)
    found = {one["code"] for one in (*content["errors"], *content["remarks"])}
    assert (got, code in found) == (status, True), content


def test_models_of_two_conditions_are_not_compared_in_silence(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_model("vacuum.json", of("vacuum", VACUUM))
    status, content = typed(capsys, "compare", "air.json", "vacuum.json")
    (said,) = [one["what"] for one in content["remarks"] if one["code"] == "conditions_differ"]
    assert (status, "in air" in said, "in vacuum" in said) == (0, True, True)
    for name in ("one", "other"):
        (out := Path(name, "out")).mkdir(parents=True)
        write_model(out / "model.json", ModelSet((of("air", AIR), of("vacuum", VACUUM))))
    status, content = typed(capsys, "compare", "one", "other", "--condition", "vacuum")
    assert (status, {row["condition"] for row in content["results"]}) == (0, {"vacuum"})


def test_what_the_data_do_not_say_may_be_said(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    status, content = typed(capsys, "compensate", "both.json", "unsaid.csv", "-o", "o.csv", "--condition", "vacuum")
    assert (status, content["condition"]) == (0, "vacuum")
    raw, models = read("unsaid.csv"), ic.load_models("both.json")
    assert ic.compensate(models, raw, condition="air").channels[0].data == pytest.approx(1.0 - BIAS["air"])
    with pytest.raises(UsageError, match="--condition air"):
        ic.compensate(models, raw)
    with pytest.raises(DataError, match="not made in condition 'air'"):
        ic.compensate(ic.load_model("both.json", "air"), read("vacuum.csv"))


def test_show_and_export_and_compare(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    status, content = typed(capsys, "show", "both.json")
    assert (status, [one["condition"] for one in content["conditions"]]) == (0, ["air", "vacuum"])
    assert {row["condition"] for row in content["results"]} == {"air", "vacuum"}
    status, content = typed(capsys, "show", "both.json", "--condition", "air")
    assert (status, content["condition"]) == (0, "air")
    with pytest.raises(SystemExit):
        main(["show", "both.json"])
    shown = capsys.readouterr().out
    assert (shown.count("condition air"), shown.count("condition vacuum")) == (1, 1)
    to_python = ("export", "both.json", "--to", "python", "-o", "m.py", "--nominal")
    assert typed(capsys, *to_python)[0] == 2
    assert typed(capsys, *to_python, "--condition", "air")[0] == 0
    assert typed(capsys, "export", "both.json", "--to", "json", "-o", "m.json")[0] == 0
    assert list(ic.load_models("m.json")) == ["air", "vacuum"]
    status, content = typed(capsys, "compare", "both.json", "both.json")
    assert (status, {row["condition"] for row in content["results"]}) == (0, {"air", "vacuum"})
    status, content = typed(capsys, "compare", "both.json", "air.json")
    assert {row["condition"] for row in content["results"]} == {"air"}
    assert "condition_not_in_both" in {remark["code"] for remark in content["remarks"]}
    status, content = typed(capsys, "compare", "both.json", "air.json", "--condition", "vacuum")
    assert (status, content["errors"][0]["code"]) == (2, "no_such_condition")


def test_a_channel_is_found_by_its_header_or_named_and_converted(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    slope = np.full(3, PER_VOLT * factor("deg/s", "rad/s"))
    supply = Sensitivity("supply", "V", 4.9, bias=slope, range=(4.5, 5.5))
    write_model("supply.json", of("air", AIR, sensitivities=(supply,), estimate=None))
    expected = 1.0 - BIAS["air"] - PER_VOLT * 0.1
    status, content = typed(capsys, "compensate", "supply.json", "air.csv", "-o", "o.csv")
    assert (status, content["columns"]["supply"]) == (0, "supply [V]")
    assert read("o.csv").channels[0].data == pytest.approx(expected)
    Path("other.csv").write_text("t_s,gyro_x_dps,gyro_y_dps,gyro_z_dps,rail [mV]\n0,1,2,3,5000\n1,1,2,3,\n")
    status, content = typed(capsys, "compensate", "supply.json", "other.csv", "-o", "o.csv")
    assert (status, content["errors"][0]["code"]) == (3, "missing_condition")
    assert "--column supply=NAME" in content["errors"][0]["do"]
    status, content = typed(capsys, "compensate", "supply.json", "other.csv", "-o", "o.csv", "--column", "supply=rail")
    assert status == 0
    assert read("o.csv").channels[0].data[0] == pytest.approx(expected)
    assert "condition_missing" in {remark["code"] for remark in content["remarks"]}


def test_orbit_of_each_condition(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    status, content = typed(capsys, "show", "both.json", "--orbit", "560 km", "--averaging", "10 s")
    assert (status, [one["condition"] for one in content["orbit"]]) == (0, ["air", "vacuum"])
    (air,) = typed(capsys, "show", "both.json", "--orbit", "560 km", "--condition", "air")[1]["orbit"]
    assert [one["zero_reference"] for one in air["axes"]] == [False, True] * 3
    assert air["axes"][0]["u"] == pytest.approx(1e-5, rel=1e-6)  # rad/s: that of the bias alone
    with pytest.raises(SystemExit):
        main(["show", "both.json", "--orbit", "560 km"])
    shown = capsys.readouterr().out
    assert shown.count("0.062690 ± 0.000084 deg/s") == 2
    assert max(map(len, shown.splitlines())) <= 110
    assert typed(capsys, "show", "both.json", "--tables")[0] == 2
    status, content = typed(capsys, "show", "both.json", "--orbit", "560")
    assert (status, content["errors"][0]["what"].startswith("--orbit '560': ")) == (3, True)
    assert typed(capsys, "show", "both.json", "--orbit", "560 s")[0] == 3
    assert typed(capsys, "show", "both.json", "--orbit", "-5 km")[0] == 3

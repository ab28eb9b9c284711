"""From a file as people have it to the right result in at most two commands, by the advice of the messages alone."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from newcomer_tables import DATA_SHEET, FILES, Made
from newcomer_texts import FORMS, Form
from newcomer_truths import BIASES, ERRORS, NOISE, SLOPES, chamber, rate_table
from obedience import next_command, obeyed, options_of

import inertialcal as ic
from inertialcal.core.errors import PlanError
from typed_commands import call

Estimates = dict[tuple[str, str], tuple[float, float]]
SHEET = DATA_SHEET | {"axis": "x"}
FEW = 5.0  # standard uncertainties that an estimate may be off
ROUND = 2e-3  # deg/s: of readings rounded to counts
TRUE_NOISE = {"units": NOISE, "volts": NOISE * 0.02, "counts": NOISE * 0.02 * 4095.0 / 5.0}


def estimates(content: Any) -> Estimates:
    """Return value and standard uncertainty of each estimate, by quantity with its power, and axis."""
    rows = [one for one in content["results"] if one["u"] is not None and one["method"] == "result"]
    return {(f"{one['quantity']}{one['power'] or ''}", one["axis"]): (one["value"], one["u"]) for one in rows}


def near(found: Estimates, quantity: str, axis: str, true: float, slack: float) -> None:
    """Check an estimate against the truth."""
    value, u = found[quantity, axis]
    assert abs(value - true) <= FEW * u + slack, (quantity, axis, value, u, true)


def check(made: Made, content: Any) -> None:
    """Check a result against what the file was made of."""
    found = estimates(content)
    if made.noun == "rate-table":
        near(found, "scale_factor_error", "x", 100.0 * ERRORS["x"], 0.0)
        near(found, "bias", "x", BIASES["x"], ROUND)
    elif made.noun == "thermal":
        for axis in "xyz":
            near(found, "bias", axis, (1.0 + ERRORS[axis]) * BIASES[axis], ROUND)
            near(found, "bias_temperature1", axis, (1.0 + ERRORS[axis]) * SLOPES[axis], 2e-5)
    else:
        sample_rate = 50.0
        kind = made.name.removesuffix(".csv").removeprefix("rest_")
        unit = next(one["unit"] for one in content["results"] if one["quantity"] == "angle_random_walk" or
                    one["quantity"] == "random_walk")  # fmt: skip
        white = next(one["value"] for one in content["results"] if one["quantity"].endswith("random_walk"))
        true = TRUE_NOISE[kind] / np.sqrt(sample_rate)
        if unit == "deg/sqrt(h)":
            true *= 60.0
        quantized = np.sqrt(1.0 + (1.0 / 12.0) / (TRUE_NOISE[kind]) ** 2) if kind == "counts" else 1.0
        assert white == pytest.approx(true * quantized, rel=0.1)


@pytest.mark.parametrize("made", FILES, ids=lambda made: made.name)
def test_what_info_says_to_type_gives_the_truth(made: Made, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / made.name
    path.write_bytes(made.write(made.log()))
    words = next_command(capsys, str(path), SHEET)
    if words[0] == "info":  # a file in counts that stand still: their unit is asked for once
        words = ["allan", *words[1:]]
    if words[0] == "init":
        words = [made.noun, str(path)]
    assert words[0] == made.noun
    content, commands = obeyed(capsys, words, SHEET)
    assert commands <= 2
    check(made, content)


@pytest.mark.parametrize("made", FILES, ids=lambda made: made.name)
def test_the_noun_by_its_own_advice_gives_the_truth(
    made: Made, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / made.name
    path.write_bytes(made.write(made.log()))
    content, commands = obeyed(capsys, [made.noun, str(path)], SHEET)
    assert commands <= 3 if made.noun == "rate-table" else commands <= 2
    check(made, content)


@pytest.mark.parametrize("form", FORMS, ids=lambda form: form.name)
def test_texts_of_excel_and_loggers(form: Form, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Every form gives the same as plain columns: rates, temperature, and a clock of 1 Hz."""
    log = chamber(hours=1.0)
    path = tmp_path / f"{form.name}{form.ending}"
    path.write_bytes(form.write(log))
    status, out, err = call(capsys, "info", str(path), *form.options, "--json")
    assert status == 0, err
    (found,) = json.loads(out)["results"]
    assert found["time"]["sample_interval"] == pytest.approx(1.0, abs=1e-9)
    assert found["next"].split()[1] == "thermal"
    status, out, err = call(capsys, "thermal", str(path), *form.options, "--json")
    assert status == 0, err
    result = estimates(json.loads(out))
    for axis in "xyz":
        near(result, "bias", axis, (1.0 + ERRORS[axis]) * BIASES[axis], 0.0)
        near(result, "bias_temperature1", axis, (1.0 + ERRORS[axis]) * SLOPES[axis], 0.0)


def test_dates_that_can_be_read_in_two_ways_are_asked_for(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    form = next(one for one in FORMS if one.name == "ambiguous_dates")
    path = tmp_path / "log.csv"
    path.write_bytes(form.write(chamber(hours=0.1)))
    status, _, err = call(capsys, "info", str(path))
    assert status == 3
    assert "--dates day-first, or --dates month-first" in err
    for order, start in (("month-first", "2024-03-12"), ("day-first", "2024-12-03")):
        _, out, _ = call(capsys, "info", str(path), "--dates", order, "--json")
        assert json.loads(out)["results"][0]["time"]["start"].startswith(start)


@pytest.mark.parametrize("name", ["Datum", "Date/Time", "Zeit"])
def test_days_of_a_spreadsheet_are_dates(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Read as such where the column is called a date; asked for where it could be seconds."""
    log = chamber(hours=0.5)
    path = tmp_path / "log.csv"
    rows = [[f"{45363.4 + t / 86400.0:.10f}", *(f"{log.readings[axis][i]:.5f}" for axis in "xyz"),
             f"{log.temperature[i]:.2f}"] for i, t in enumerate(log.time)]  # fmt: skip
    head = f"{name},gyro_x [deg/s],gyro_y [deg/s],gyro_z [deg/s],temperature [degC]"
    path.write_text("\n".join([head, *map(",".join, rows)]) + "\n")
    words = next_command(capsys, str(path), SHEET)
    options: list[str] = []
    if name == "Zeit":
        assert words == ["info", str(path), "--unit", "Zeit=UNIT"]
        _, out, _ = call(capsys, "info", str(path), "--json")
        said = next(one["do"] for one in json.loads(out)["results"][0]["remarks"] if one["code"] == "time_unit_unknown")
        options = options_of(said)[0].split()
        words = next_command(capsys, str(path), SHEET, *options)
    _, out, _ = call(capsys, "info", str(path), *options, "--json")
    time = json.loads(out)["results"][0]["time"]
    assert time["start"].startswith("2024-03-12T09:36:00")
    assert time["sample_interval"] == pytest.approx(1.0, abs=1e-5)
    assert words[0] == "thermal"
    content, commands = obeyed(capsys, words, SHEET)
    assert commands == 1
    found = estimates(content)
    for axis in "xyz":
        near(found, "bias_temperature1", axis, (1.0 + ERRORS[axis]) * SLOPES[axis], 0.0)


@pytest.mark.parametrize("kind", ["units", "volts", "counts"])
def test_compensate_reads_what_the_test_read(kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """With no option at all: the model knows the chain."""
    made = next(one for one in FILES if one.name == f"turned_{kind}.csv")
    path, model, out_path = tmp_path / made.name, tmp_path / "model.json", tmp_path / "true.csv"
    log = rate_table()
    path.write_bytes(made.write(log))
    words = next_command(capsys, str(path), SHEET)
    assert call(capsys, *words, "-o", str(model))[0] == 0
    status, _, err = call(capsys, "compensate", str(model), str(path), "-o", str(out_path), "--json")
    assert status == 0, err
    head, *rows = (line.split(",") for line in out_path.read_text().splitlines())
    column = next(i for i, name in enumerate(head) if name.split(" ")[0] in ("x", "gyro_x"))
    assert head[column].endswith("[deg/s]")
    compensated = np.array([float(row[column]) for row in rows])
    assert np.mean(compensated - log.applied) == pytest.approx(0.0, abs=5e-3)
    assert np.std(compensated - log.applied) < 2.0 * NOISE


def test_counts_headed_as_rates_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    made = next(one for one in FILES if one.name == "turned_counts.csv")
    path, model = tmp_path / made.name, tmp_path / "model.json"
    data = made.write(rate_table())
    path.write_bytes(data)
    assert call(capsys, *next_command(capsys, str(path), SHEET), "-o", str(model))[0] == 0
    wrong = tmp_path / "headed.csv"
    wrong.write_bytes(data.replace(b"gyro_x,gyro_y,gyro_z", b"gyro_x [deg/s],gyro_y [deg/s],gyro_z [deg/s]", 1))
    status, _, err = call(capsys, "compensate", str(model), str(wrong), "-o", str(tmp_path / "out.csv"))
    assert status == 3
    assert "counts rather than deg/s" in err


def test_volts_are_never_taken_for_rates(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Whatever is said of their unit, a header in volts does not become deg/s without a scale factor."""
    for name in ("turned_volts.csv", "dwells_volts.csv", "chamber_volts.csv"):
        made = next(one for one in FILES if one.name == name)
        path = tmp_path / name
        path.write_bytes(made.write(made.log()))
        words = [made.noun, str(path), *(("--axis", "x") if made.noun == "rate-table" else ())]
        status, _, err = call(capsys, *words)
        assert status == 2
        assert "--unit" not in err
        if made.noun == "rate-table":
            status, _, err = call(capsys, *words, "--unit", "deg/s")
            assert status == 2
        assert "--scale-factor" in err


def test_a_reference_that_has_no_effect_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    made = next(one for one in FILES if one.name == "turned_units.csv")
    path = tmp_path / made.name
    path.write_bytes(made.write(made.log()))
    words = ["rate-table", str(path), "--axis", "x", "--reference", "2.5 V", "--scale-factor", "0.02 V/(deg/s)"]
    status, _, err = call(capsys, *words)
    assert status == 2
    assert "reference is given, and the readings are in deg/s already" in err


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("turned_units.csv", ("rate-table", "--column", "applied=table_rate", "--column", "x=gyro_x")),
        ("chamber_units.csv", ("thermal", "--column", "x=gyro_x", "--column", "temperature=temperature")),
        ("rest_units.csv", ("allan", "--column", "gyro_x")),
        ("rest_units.csv", ("psd", "--column", "x=gyro_x")),
    ],
)
def test_columns_are_named_without_their_unit_too(
    name: str, words: tuple[str, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    made = next(one for one in FILES if one.name == name)
    path = tmp_path / name
    path.write_bytes(made.write(made.log()))
    full = {"applied=table_rate": "applied=table_rate [deg/s]", "x=gyro_x": "x=gyro_x [deg/s]",
            "temperature=temperature": "temperature=temperature [degC]", "gyro_x": "gyro_x [deg/s]"}  # fmt: skip
    found = []
    for named in (words, tuple(full.get(one, one) for one in words)):
        status, out, err = call(capsys, named[0], str(path), *named[1:], "--json")
        assert status == 0, err
        found.append(json.loads(out)["results"])
    assert found[0] == found[1]


def test_volts_of_a_fixed_reference_in_a_table_are_above_it(tmp_path: Path) -> None:
    """The reference of a campaign's chain is taken off readings in volts, once; beside ``none`` it is refused."""
    made = next(one for one in FILES if one.name == "dwells_volts.csv")
    (tmp_path / made.name).write_bytes(made.write(made.log()))
    text = """schema = 2
[campaign]
id = "volts"
[sensors.suite]
kind = "gyro"
axes = ["x"]
unit = "deg/s"
chain = { kind = "KIND", reference = "2.5 V", scale_factor = "0.02 V/(deg/s)" }
[recordings.table]
sensor = "suite"
file = "dwells_volts.csv"
rows = { applied = "rate", reading = "reading", scatter = "reading_std", samples = "n", unit = "V" }
[[tests]]
id = "rate"
procedure = "rate_table"
recordings = ["table"]
plan = { axis = "x" }
"""
    (tmp_path / "campaign.toml").write_text(text.replace("KIND", "output"))
    assert ic.run(tmp_path).exit_status == 0
    rows = json.loads((tmp_path / "out/results.json").read_text())["results"]
    near(estimates({"results": rows}), "bias", "x", BIASES["x"], 0.0)
    report = (tmp_path / "out/report.html").read_text()
    assert "recordings are the output of the sensor, minus the reference of" in " ".join(report.split())
    (tmp_path / "campaign.toml").write_text(text.replace("KIND", "none"))
    with pytest.raises(PlanError, match="does not use reference"):
        ic.check(tmp_path)

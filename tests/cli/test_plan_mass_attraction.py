"""`plan mass-attraction` on the command line: figures, files, exit status, one clear message for bad input."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

import inertialcal as ic
from inertialcal.core.errors import InertialcalError
from inertialcal.procedures.mass_attraction.schedule_csv import read_schedule
from typed_commands import call, call_json

PLAN = ("plan", "mass-attraction")
BODY = ("--cube", "5.08 cm", "--count", "900", "--stand-off", "7.6 cm")
SMALL = ("--cube", "10 cm", "--count", "50", "--stand-off", "7.6 cm")
DRIVE = ("--rig", "0 cm:60 cm", "--stroke", "12.7 cm:43.2 cm")
NOISE = ("--noise", "N=55 ng/sqrt(Hz) B=1 ng K=0.1 ng/sqrt(s)", "--target", "1 %")
DOUBTS = (
    "--u-density", "0.3 %", "--u-piece-density", "0.5 %", "--u-position", "0.5 mm", "--u-stop", "1 mm",
    "--u-piece-place", "0.5 mm", "--u-angle", "2 mrad",
)  # fmt: skip
DOCUMENT = ("--big-g", "6.67e-8 cm^3/s^2/gram", "--gravity", "981 cm/s^2", "--stated", "74.017 ng")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("plan")


def rows_of(content: dict[str, Any]) -> dict[tuple[str, str], dict[str, Any]]:
    return {(row["quantity"], row["condition"] or row["axis"]): row for row in content["results"]}


def test_the_whole_plan(capsys: pytest.CaptureFixture[str], folder: Path) -> None:
    """Reinel's mass: bound, amplitude, harmonics, budget and forecast as they were worked out by other means."""
    path = folder / "schedule.csv"
    content = call_json(capsys, *PLAN, *BODY, *DRIVE, *NOISE, *DOUBTS, *DOCUMENT, "--schedule", str(path))
    assert (content["exit"], content["command"]) == (0, "plan mass-attraction")
    rows = rows_of(content)
    assert rows["attraction_bound", "face at 7.6 cm"]["value"] == pytest.approx(72.977, abs=0.01)
    assert 0.2 < rows["attraction_gap", "face at 7.6 cm"]["value"] < 0.3
    assert rows["mass_needed", "for the stated attraction"]["value"] == pytest.approx(1382.0, abs=1.0)
    assert rows["amplitude", "sine"]["u"] == pytest.approx(0.1254, rel=0.02)  # ng; his body is at another stand-off
    assert rows["motion_harmonic", "2 of a sinusoidal motion"]["value"] == pytest.approx(4.3, abs=0.05)
    assert rows["motion_harmonic", "3 of a sinusoidal motion"]["value"] == pytest.approx(6.0, abs=0.05)
    linear, drawn = (rows["amplitude_uncertainty", way] for way in ("linear", "Monte Carlo"))
    share = linear["value"] / rows["amplitude", "sine"]["value"]  # in percent: the last row of that name counts
    assert drawn["value"] / rows["amplitude", "sine"]["u"] == pytest.approx(1.0, abs=0.02)
    assert share * rows["amplitude", "sine"]["value"] == pytest.approx(0.527, abs=0.01)
    sine, abab = (rows["time_to_target", f"{name}, 1 %"]["value"] for name in ("sine", "abab"))
    assert sine / abab > 1.99
    codes = {one["code"]: one for one in content["remarks"]}
    assert "1.4 % above the most" in codes["above_bound"]["what"]
    assert "document_constants" in codes
    assert {one["name"] for one in content["curves"]} == {
        "mass_body", "cube_as_point", "mass_growth", "mass_field", "mass_drive", "mass_forecast",
    }  # fmt: skip
    schedule = read_schedule(path)
    assert (len(schedule), schedule.drive) == (720, "sine")
    assert schedule.amplitude / 9.81e-9 == pytest.approx(rows["amplitude", "sine"]["value"])
    assert schedule.applied[1] > schedule.applied[0] > schedule.applied[3]
    assert schedule.u_applied == pytest.approx(0.00527, abs=1e-4)


def test_what_it_prints_and_its_figures(capsys: pytest.CaptureFixture[str], folder: Path) -> None:
    status, out, err = call(capsys, *PLAN, *SMALL, *DRIVE, *NOISE, "-o", str(folder / "body.png"))
    assert (status, err) == (0, "")
    for words in ("body\n", "drive\n", "budget of the amplitude\n", "forecast: standard uncertainty of the scale"):
        assert words in out
    assert "warning: not stated, and taken as exact: --u-density, --u-piece-density, --u-position" in out
    assert "written:" in out
    for name in ("field", "cube-as-point", "growth", "forecast"):
        target = folder / f"{name}.svg"
        assert call(capsys, *PLAN, *SMALL, *DRIVE, *NOISE, "-q", "-o", str(target), "--figure", name) == (0, "", "")
        assert target.stat().st_size > 5000


def test_the_body_alone_and_the_python_mirror(capsys: pytest.CaptureFixture[str]) -> None:
    content = call_json(capsys, *PLAN, *BODY, "--shape", "--grid", "20x20x10")
    assert {row["quantity"] for row in content["results"]} <= {
        "cells", "mass", "size", "attraction", "attraction_bound", "attraction_gap", "attraction_sphere",
    }  # fmt: skip
    plan = ic.plan_mass_attraction(cube="5.08 cm", mass="1338 kg", stand_off="7.6 cm", shape=True)
    assert [row.value for row in plan.rows] == pytest.approx([row["value"] for row in content["results"]])
    assert "attraction_bound" in str(plan)
    assert "<table" in plan._repr_html_()


def test_an_inventory_attracts_less_than_free_cells_by_what_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    rows = rows_of(
        call_json(capsys, *PLAN, "--inventory", "100x10.2 cm,100x5.1 cm", "--stand-off", "7.6 cm", "--shape")
    )
    assert rows["mass", ""]["value"] == pytest.approx(1353.8, abs=0.1)
    assert 0.0 < rows["inventory_gap", "at most"]["value"] < 0.5


def test_a_shape_for_the_change_beats_one_for_the_attraction(capsys: pytest.CaptureFixture[str]) -> None:
    amplitude = [
        rows_of(call_json(capsys, *PLAN, *BODY, *DRIVE, "--optimise", wanted))["amplitude", "sine"]["value"]
        for wanted in ("attraction", "change")
    ]
    assert amplitude[1] > 1.01 * amplitude[0]


def test_along_the_input_axis_it_falls_all_the_way(capsys: pytest.CaptureFixture[str]) -> None:
    rows = rows_of(
        call_json(
            capsys,
            *PLAN,
            *BODY,
            "--direction",
            "along",
            "--rig",
            "0 cm:60 cm",
            "--travel",
            "30.5 cm",
            "--drive",
            "abab",
        )
    )
    assert rows["best_window_start", "length 30.5 cm"]["value"] == pytest.approx(0.0, abs=1e-6)
    assert {key[1].partition(",")[0] for key in rows if key[0] == "drive_position"} == {"abab"}


def test_a_mass_in_orbit(capsys: pytest.CaptureFixture[str]) -> None:
    rows = rows_of(call_json(capsys, *PLAN, "--orbit", "--mass", "4 kg", "--stand-off", "10.2 cm"))
    assert rows["smallest_acceleration", "difference over the baseline"]["value"] == pytest.approx(0.102, abs=5e-4)
    far = rows["distance", "of its centre, at that gradient"]["value"] / 100.0
    assert 2.0 * 6.6743e-11 * 4.0 / far**3 == pytest.approx(0.5e-9)
    assert rows["attraction", "surface at 10.2 cm"]["value"] == pytest.approx(1.28, abs=0.005)
    same = rows_of(call_json(capsys, *PLAN, "--orbit", "--stand-off", "10.2 cm", "--threshold", "1e-10 g"))
    assert same["smallest_gradient", ""]["value"] == pytest.approx(0.5 * 1e-10 * 9.80665 / 1e-9)


def test_noise_from_what_allan_printed(capsys: pytest.CaptureFixture[str], folder: Path) -> None:
    row = {"quantity": "velocity_random_walk", "axis": "x", "value": 0.055, "unit": "ug/sqrt(Hz)", "condition": ""}
    file = folder / "noise.json"
    file.write_text(json.dumps({"results": [row | {"status": "estimated"}]}))
    found = call_json(capsys, *PLAN, *SMALL, *DRIVE, "--noise-from", str(file))
    told = call_json(capsys, *PLAN, *SMALL, *DRIVE, "--noise", "N=55 ng/sqrt(Hz)")
    key = ("scale_factor_uncertainty", "sine, after 24 h")
    assert rows_of(found)[key]["value"] == pytest.approx(rows_of(told)[key]["value"])
    assert [one["path"] for one in found["inputs"]] == [str(file)]
    both = [row | {"status": "estimated", "axis": axis} for axis in "xy"]
    for text, words, expected in (
        (json.dumps({"results": both}), "Say --noise-axis: x, y", 2),
        (json.dumps({"results": []}), "no estimated noise term of an accelerometer", 3),
        (json.dumps({"results": [row | {"status": "estimated", "unit": "deg/s"}]}), "no estimated noise term", 3),
        ("no json", "not what allan --json or run writes", 3),
    ):
        file.write_text(text)
        status, out, err = call(capsys, *PLAN, *BODY, *DRIVE, "--noise-from", str(file))
        assert (status, out) == (expected, "")
        assert words in err


BAD: list[tuple[tuple[str, ...], int, str]] = [
    (("--cube", "5.08 cm", "--count", "9"), 2, "--stand-off is not given"),
    (("--count", "9", "--stand-off", "5 cm"), 2, "--cube is not given"),
    (("--cube", "5.08 cm", "--stand-off", "5 cm"), 2, "neither --count nor --mass"),
    ((*BODY, "--mass", "1000 kg"), 3, "900 cubes weigh 1337.97 kg, more than the 1000 kg allowed"),
    ((*BODY, "--mass", "1500 ng"), 2, "mass: '1500 ng'"),
    (("--cube", "5.08 m", "--count", "900", "--stand-off", "7.6 cm"), 3, "5.08 m: more than 1 m"),
    (("--cube", "5.08 cm", "--count", "900", "--stand-off", "7.6 m"), 3, "7.6 m: more than 5 m"),
    (("--cube", "5.08 cm", "--count", "9", "--stand-off", "1.2 m"), 3, "cm, not m?"),
    (("--cube", "5.08", "--count", "900", "--stand-off", "7.6 cm"), 2, "cube: '5.08'"),
    (("--cube", "5.08 cm", "--count", "900", "--stand-off", "0 cm"), 2, "stand_off: '0 cm' is not above zero"),
    ((*BODY, "--density", "11.34 kg/m^3"), 3, "materials lie between"),
    ((*BODY, "--density", "113.4 g/cm^3"), 3, "materials lie between"),
    ((*BODY, "--density", "11.34 cm"), 2, "density: '11.34 cm'"),
    ((*BODY, "--grid", "5x5x5"), 3, "900 cells do not fit into a grid of 5 x 5 x 5 = 125"),
    ((*BODY, "--grid", "20x20"), 2, "grid: '20x20'"),
    ((*BODY, "--inventory", "100x10.2 cm"), 2, "--inventory with --cube, --count"),
    (("--inventory", "100x10.2 cm,100x6 cm", "--stand-off", "5 cm"), 3, "not a whole number of those of 0.06 m"),
    (("--inventory", "10 cm", "--stand-off", "5 cm"), 2, "inventory: '10 cm'"),
    (("--inventory", "100x10 cm", "--mass", "50 kg", "--stand-off", "5 cm"), 3, "more than the 50 kg allowed"),
    (("--inventory", "50x10 cm", "--grid", "4x4x2", "--stand-off", "5 cm"), 3, "50 cubes of 1 cells do not fit"),
    ((*BODY, "--stroke", "12.7 cm:43.2 cm", "--rig", "0 cm:30 cm"), 3, "outside the rig's travel"),
    ((*BODY, "--stroke", "12.7 m:43.2 m"), 3, "cm, not m?"),
    ((*BODY, "--stroke", "12.7 cm"), 2, "stroke: '12.7 cm'"),
    ((*BODY, "--travel", "70 cm", "--rig", "0 cm:60 cm"), 3, "does not fit the rig's travel"),
    ((*BODY, *DRIVE, "--travel", "30 cm"), 2, "--stroke with --travel"),
    ((*BODY, *DRIVE, "--drive", "triangle"), 2, "There are: sine, square, abab"),
    ((*BODY, *DRIVE, "--direction", "up"), 2, "There are: along, across"),
    ((*BODY, *DRIVE, "--instrument", "8 cm"), 3, "where the instrument takes 0.08 m"),
    ((*BODY, "--direction", "along", "--rig", "-10 cm:50 cm"), 3, "would overlap the instrument"),
    ((*BODY, "--optimise", "change"), 2, "--optimise change without --stroke"),
    ((*BODY, "--optimise", "beauty"), 2, "There are: attraction, change"),
    ((*BODY, *DRIVE, "--noise", "N=5"), 2, "noise: N: '5'"),
    ((*BODY, *DRIVE, "--noise", "N=5 deg/s"), 2, "noise: N: '5 deg/s'"),
    ((*BODY, *DRIVE, "--noise", "N=-5 ug/sqrt(Hz)"), 2, "not above zero"),
    ((*BODY, *DRIVE, "--noise", "N=1e300 ug/sqrt(Hz)"), 2, "is of no sensor"),
    ((*SMALL, *DRIVE, "--noise", "R=1 ng/h"), 3, "no noise is given but a ramp"),
    (("--cube", "1e-300 m", "--count", "9", "--stand-off", "5 cm"), 3, "nobody stacks any below"),
    ((*BODY, *DRIVE, "--noise", "Z=5 ug"), 2, "no term 'Z'"),
    ((*BODY, *DRIVE, "--noise", "5 ug"), 2, "Write terms with their units"),
    ((*BODY, *DRIVE, "--noise", "N=5 ug/sqrt(Hz)", "--noise-from", "x.json"), 2, "--noise with --noise-from"),
    ((*BODY, *DRIVE, "--noise-from", "nowhere.json"), 3, "nowhere.json"),
    ((*BODY, *DRIVE, "--hours", "0.1"), 2, "less than one cycle"),
    ((*BODY, *DRIVE, "--hours", "nan"), 2, "hours: nan"),
    ((*BODY, *DRIVE, "--dwell", "100"), 2, "dwell: '100'"),
    ((*BODY, *DRIVE, "--move", "-20 s"), 2, "is below zero"),
    ((*BODY, *DRIVE, "--target", "1 cm", *NOISE[:2]), 2, "target: '1 cm'"),
    ((*BODY, *DRIVE, "--u-position", "0.5"), 2, "u_position: '0.5'"),
    ((*BODY, *DRIVE, "--u-angle", "-1 mrad"), 2, "is below zero"),
    ((*BODY, "--big-g", "6.67e-8 m^3/s^2/kg"), 2, "not what it is said to be"),
    ((*BODY, "--gravity", "981 m/s^2"), 2, "not what it is said to be"),
    ((*BODY, "--stated", "74"), 2, "stated: '74'"),
    ((*BODY, "--shape", "--schedule", "s.csv"), 2, "there is no drive to write"),
    ((*BODY, "--figure", "body"), 2, "no file for the figure"),
    ((*BODY, "-o", "f.png", "--figure", "cat"), 2, "There are: body, field"),
    ((*BODY, "-o", "f.gif"), 2, "cannot be written as .gif"),
    ((*BODY, "-o", "f.png", "--figure", "field"), 3, "no data for figure 'mass_field'"),
    (("--orbit", *BODY), 2, "--orbit with --cube, --count"),
    (("--orbit", "--stand-off", "10 cm", "--threshold", "1 m"), 2, "threshold: '1 m'"),
    (("--orbit", "--stand-off", "10 cm", "--threshold", "1"), 2, "threshold: '1'"),
    (("--orbit", "--stand-off", "10 cm", "--threshold", "lots"), 2, "threshold: 'lots'"),
    (("--orbit", "--stand-off", "10 cm", "--baseline", "0 m"), 2, "not above zero"),
    (("--orbit", "--stand-off", "10 cm", "--density", "11.34 kg/m^3"), 3, "materials lie between"),
]


@pytest.mark.parametrize(("words", "expected", "said"), BAD, ids=[" ".join(one[0][-2:]) for one in BAD])
def test_bad_input_is_refused_in_one_message(
    capsys: pytest.CaptureFixture[str], folder: Path, monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...],
    expected: int, said: str,
) -> None:  # fmt: skip
    monkeypatch.chdir(folder)
    status, out, err = call(capsys, *PLAN, *words)
    assert (status, out) == (expected, "")
    assert said in " ".join(err.split())
    assert err.count("error:") == 1


def test_python_refuses_as_the_command_does() -> None:
    with pytest.raises(InertialcalError, match="--stand-off is not given"):
        ic.plan_mass_attraction(cube="5.08 cm", count=900)

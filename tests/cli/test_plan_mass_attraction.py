"""`plan mass-attraction` on the command line: figures, files, exit status, one clear message for bad input."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any

import pytest

import inertialcal as ic
from inertialcal.core.errors import InertialcalError
from inertialcal.core.key import Key
from inertialcal.core.results import Row
from inertialcal.core.settings import settings_table
from inertialcal.core.show.rows import case_name
from inertialcal.procedures.mass_attraction.planning.settings import STARTER, Settings
from inertialcal.procedures.mass_attraction.schedule_csv import read_schedule
from typed_commands import call, call_json

PLAN = ("plan", "mass-attraction")


def sets(*changes: str) -> tuple[str, ...]:
    return tuple(word for change in changes for word in ("--set", change))


BODY = sets("body.cube=5.08 cm", "body.count=900", "body.stand_off=7.6 cm")
SMALL = sets("body.cube=10 cm", "body.count=50", "body.stand_off=7.6 cm")
DRIVE = sets("motion.rig=0 cm, 60 cm", "motion.stroke=12.7 cm, 43.2 cm")
NOISE = sets(
    "noise.velocity_random_walk=55 ng/sqrt(Hz)", "noise.bias_instability=1 ng",
    "noise.acceleration_random_walk=0.1 ng/sqrt(s)", "timing.target=1 %",
)  # fmt: skip
UNCERTAINTY = sets(
    "uncertainty.density=0.3 %", "uncertainty.piece_density=0.5 %", "uncertainty.position=0.5 mm",
    "uncertainty.stop=1 mm", "uncertainty.piece_place=0.5 mm", "uncertainty.angle=2 mrad",
)  # fmt: skip
DOCUMENT = sets(
    "constants.gravitational_constant=6.67e-8 cm^3/s^2/gram", "constants.gravity=981 cm/s^2", "body.stated=74.017 ng"
)
CUBES = "body.cubes=[{ count = 100, edge = '10.2 cm' }, { count = 100, edge = '5.1 cm' }]"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("plan")


def rows_of(content: dict[str, Any]) -> dict[tuple[str, str], dict[str, Any]]:
    return {(row["quantity"], case_name(row) or row["axis"]): row for row in content["results"]}


def test_the_whole_plan(capsys: pytest.CaptureFixture[str], folder: Path) -> None:
    """Reinel's mass: bound, amplitude, harmonics, budget and forecast as they were worked out by other means."""
    path = folder / "schedule.csv"
    content = call_json(capsys, *PLAN, *BODY, *DRIVE, *NOISE, *UNCERTAINTY, *DOCUMENT, "--schedule", str(path))
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
    assert "1.4 % above the bound" in codes["above_bound"]["what"]
    assert "document_constants" in codes
    assert "curves" not in content
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
    assert "warning: not stated and taken as exact: uncertainty of density, piece_density, position" in " ".join(
        out.split()
    )
    assert "written:" in out
    for name in ("field", "cube-as-point", "growth", "forecast"):
        target = folder / f"{name}.svg"
        assert call(capsys, *PLAN, *SMALL, *DRIVE, *NOISE, "-q", "-o", str(target), "--figure", name) == (0, "", "")
        assert target.stat().st_size > 5000


def test_the_body_alone_and_the_python_mirror(capsys: pytest.CaptureFixture[str]) -> None:
    content = call_json(capsys, *PLAN, *BODY, *sets("body.grid=20,20,10"))
    assert {row["quantity"] for row in content["results"]} <= {
        "cells", "mass", "size", "attraction", "attraction_bound", "attraction_gap", "attraction_sphere",
    }  # fmt: skip
    plan = ic.plan_mass_attraction(body={"cube": "5.08 cm", "mass": "1338 kg", "stand_off": "7.6 cm"})
    assert [row.value for row in plan.rows] == pytest.approx([row["value"] for row in content["results"]])
    assert "attraction_bound" in str(plan)
    assert "<table" in plan._repr_html_()


def test_an_inventory_attracts_less_than_free_cells_by_at_most_the_gap(capsys: pytest.CaptureFixture[str]) -> None:
    rows = rows_of(call_json(capsys, *PLAN, *sets(CUBES, "body.stand_off=7.6 cm")))
    assert rows["mass", ""]["value"] == pytest.approx(1353.8, abs=0.1)
    assert 0.0 < rows["inventory_gap", "at most"]["value"] < 0.5


def test_a_shape_for_the_change_beats_one_for_the_attraction(capsys: pytest.CaptureFixture[str]) -> None:
    amplitude = [
        rows_of(call_json(capsys, *PLAN, *BODY, *DRIVE, *sets(f"body.optimise={wanted}")))["amplitude", "sine"]["value"]
        for wanted in ("attraction", "change")
    ]
    assert amplitude[1] > 1.01 * amplitude[0]


def test_along_the_input_axis_it_falls_all_the_way(capsys: pytest.CaptureFixture[str]) -> None:
    rows = rows_of(
        call_json(
            capsys,
            *PLAN,
            *BODY,
            *sets("motion.direction=along", "motion.rig=0 cm, 60 cm", "motion.travel=30.5 cm", "timing.drive=abab"),
        )
    )
    assert rows["best_window_start", "length 30.5 cm"]["value"] == pytest.approx(0.0, abs=1e-6)
    assert {key[1].partition(",")[0] for key in rows if key[0] == "drive_position"} == {"abab"}


def test_a_mass_in_orbit(capsys: pytest.CaptureFixture[str]) -> None:
    rows = rows_of(call_json(capsys, *PLAN, *sets("orbit.mass=4 kg", "orbit.stand_off=10.2 cm")))
    assert rows["smallest_acceleration", "difference over the baseline"]["value"] == pytest.approx(0.102, abs=5e-4)
    far = rows["distance", "of its centre, at that gradient"]["value"] / 100.0
    assert 2.0 * 6.6743e-11 * 4.0 / far**3 == pytest.approx(0.5e-9)
    assert rows["attraction", "surface at 10.2 cm"]["value"] == pytest.approx(1.28, abs=0.005)
    same = rows_of(call_json(capsys, *PLAN, *sets("orbit.stand_off=10.2 cm", "orbit.acceleration=1e-10 g")))
    assert same["smallest_gradient", ""]["value"] == pytest.approx(0.5 * 1e-10 * 9.80665 / 1e-9)


def test_noise_from_what_allan_printed(capsys: pytest.CaptureFixture[str], folder: Path) -> None:
    row = Row(Key("velocity_random_walk", "x"), 0.055, None, "ug/sqrt(Hz)").to_dict()
    file = folder / "noise.json"
    file.write_text(json.dumps({"results": [row | {"status": "estimated"}]}))
    found = call_json(capsys, *PLAN, *SMALL, *DRIVE, *sets(f"noise.file={file}"))
    given = call_json(capsys, *PLAN, *SMALL, *DRIVE, *sets("noise.velocity_random_walk=55 ng/sqrt(Hz)"))
    key = ("scale_factor_uncertainty", "sine, after 24 h")
    assert rows_of(found)[key]["value"] == pytest.approx(rows_of(given)[key]["value"])
    assert [one["path"] for one in found["inputs"]] == [str(file)]
    both = [row | {"status": "estimated", "axis": axis} for axis in "xy"]
    for text, words, expected in (
        (json.dumps({"results": both}), "Set noise.axis to one of: x, y", 3),
        (json.dumps({"results": []}), "no estimated noise term of an accelerometer", 3),
        (json.dumps({"results": [row | {"status": "estimated", "unit": "deg/s"}]}), "no estimated noise term", 3),
        ("no json", "not output of allan --json or run", 3),
    ):
        file.write_text(text)
        status, out, err = call(capsys, *PLAN, *BODY, *DRIVE, *sets(f"noise.file={file}"))
        assert (status, out) == (expected, "")
        assert words in err


BAD: list[tuple[tuple[str, ...], int, str]] = [
    ((), 2, "no settings Name a settings file. --write"),
    (("--set", "body.cube"), 2, "Write --set GROUP.KEY=VALUE"),
    (sets("body.cube=5.08 cm", "body.count=9"), 3, "body.stand_off is missing"),
    (sets("motion.travel=3 cm"), 3, "body is missing"),
    (sets("body.count=9", "body.stand_off=5 cm"), 3, "body.cube is missing"),
    (sets("body.cube=5.08 cm", "body.stand_off=5 cm"), 3, "body.count and body.mass are missing"),
    ((*BODY, *sets("body.color=blue")), 3, "unknown key body.color"),
    ((*BODY, *sets("bodi.cube=5 cm")), 3, "Did you mean body?"),
    ((*BODY, *sets("body.count=9.5")), 3, "should be a valid integer"),
    ((*BODY, *sets("body.mass=1000 kg")), 3, "900 cubes weigh 1337.97 kg, more than the 1000 kg allowed"),
    (sets("body.cube=5 cm", "body.mass=1 kg", "body.stand_off=5 cm"), 3, "1 kg is less than one c"),
    ((*BODY, *sets("body.mass=1500 ng")), 3, "body.mass:"),
    (sets("body.cube=5.08 m", "body.count=900", "body.stand_off=7.6 cm"), 3, "5.08 m: more than 1 m"),
    (sets("body.cube=5.08 cm", "body.count=900", "body.stand_off=7.6 m"), 3, "7.6 m: more than 5 m"),
    (sets("body.cube=5.08 cm", "body.count=9", "body.stand_off=1.2 m"), 3, "cm, not m?"),
    (sets("body.cube=5.08", "body.count=900", "body.stand_off=7.6 cm"), 3, "body.cube: 5.08 is not a quantity"),
    (sets("body.cube=5.08 cm", "body.count=900", "body.stand_off=0 cm"), 3, "should be greater than 0 m"),
    ((*BODY, *sets("body.density=11.34 kg/m^3")), 3, "materials lie between"),
    ((*BODY, *sets("body.density=113.4 g/cm^3")), 3, "materials lie between"),
    ((*BODY, *sets("body.density=11.34 cm")), 3, "body.density:"),
    ((*BODY, *sets("body.grid=5,5,5")), 3, "900 cells do not fit into a grid of 5 x 5 x 5 = 125"),
    ((*BODY, *sets("body.grid=20,20")), 3, "Give 3 different values"),
    ((*BODY, *sets("body.grid=20,20,0")), 3, "Give the cells across"),
    ((*BODY, *sets(CUBES)), 3, "body.cubes with body.cube"),
    (sets("body.cubes=[{count=9, edge='10.2 cm'}, {count=9, edge='6 cm'}]", "body.stand_off=5 cm"), 3, "a multiple of"),
    (sets("body.cubes=[{edge='10 cm'}]", "body.stand_off=5 cm"), 3, "body.cubes.0.count is missing"),
    (sets(CUBES, "body.mass=50 kg", "body.stand_off=5 cm"), 3, "more than the 50 kg allowed"),
    ((*BODY, *sets("motion.stroke=12.7 cm, 43.2 cm", "motion.rig=0 cm, 30 cm")), 3, "outside the rig's travel"),
    ((*BODY, *sets("motion.stroke=12.7 m, 43.2 m")), 3, "cm, not m?"),
    ((*BODY, *sets("motion.stroke=['12.7 cm']")), 3, "Give 2 different values"),
    ((*BODY, *sets("motion.stroke=12.7 cm")), 3, "should be a valid list"),
    ((*BODY, *sets("motion.travel=70 cm", "motion.rig=0 cm, 60 cm")), 3, "does not fit the rig's travel"),
    ((*BODY, *DRIVE, *sets("motion.travel=30 cm")), 3, "motion.stroke with motion.travel"),
    ((*BODY, *DRIVE, *sets("timing.drive=triangle")), 3, "should be 'sine', 'square' or 'abab'"),
    ((*BODY, *DRIVE, *sets("motion.direction=up")), 3, "should be 'along' or 'across'"),
    ((*BODY, *DRIVE, *sets("instrument.case=8 cm")), 3, "but the instrument needs 0.08 m"),
    ((*BODY, *sets("motion.direction=along", "motion.rig=-10 cm, 50 cm")), 3, "would overlap the instrument"),
    ((*BODY, *sets("body.optimise=change")), 3, "needs motion.stroke"),
    ((*BODY, *DRIVE, *sets("noise.velocity_random_walk=5 deg/s")), 3, "noise.velocity_random_walk:"),
    ((*BODY, *DRIVE, *sets("noise.bias_instability=-5 ug")), 3, "should be greater than"),
    ((*BODY, *DRIVE, *sets("noise.bias_instability=1e30 ug")), 3, "should be less than or equal to 1000 m/s^2"),
    ((*SMALL, *DRIVE, *sets("noise.acceleration_ramp=1 ng/h")), 3, "no noise is given but a ramp"),
    (sets("body.cube=1e-20 m", "body.count=9", "body.stand_off=5 cm"), 3, "the smallest is 0.0001 m"),
    ((*BODY, *DRIVE, *NOISE, *sets("noise.file=x.json")), 3, "noise.file with noise.velocity_random_walk"),
    ((*BODY, *DRIVE, *sets("noise.file=nowhere.json")), 3, "nowhere.json"),
    ((*BODY, *DRIVE, *sets("timing.length=0.1 h")), 3, "shorter than one cycle"),
    ((*BODY, *DRIVE, *sets("timing.dwell=100")), 3, "timing.dwell: 100 is not a quantity"),
    ((*BODY, *DRIVE, *sets("timing.move=-20 s")), 3, "should be greater than or equal to 0 s"),
    ((*BODY, *DRIVE, *sets("timing.target=1 cm")), 3, "timing.target:"),
    ((*BODY, *DRIVE, *sets("uncertainty.angle=-1 mrad")), 3, "should be greater than or equal to 0 rad"),
    ((*BODY, *sets("constants.gravitational_constant=6.67e-8 m^3/s^2/kg")), 3, "should be less than or equal"),
    ((*BODY, *sets("constants.gravity=981 m/s^2")), 3, "should be less than or equal to 9.9 m/s^2"),
    ((*BODY, "--schedule", "s.csv"), 2, "no drive to write"),
    ((*BODY, "--figure", "body"), 2, "no file for the figure"),
    ((*BODY, "-o", "f.png", "--figure", "cat"), 2, "There are: body, field"),
    ((*BODY, "-o", "f.gif"), 2, "cannot write a figure as .gif"),
    ((*BODY, "-o", "f.png", "--figure", "field"), 3, "no data for figure 'mass_field'"),
    ((*sets("orbit.stand_off=10 cm"), *BODY), 3, "orbit with body"),
    (sets("orbit.stand_off=10 cm", "orbit.gradient=1 m"), 3, "orbit.gradient:"),
    (sets("orbit.stand_off=10 cm", "orbit.gradient=1 Eotvos", "orbit.acceleration=1 ng"), 3, "contradict"),
    (sets("orbit.stand_off=10 cm", "orbit.baseline=0 m"), 3, "should be greater than 0 m"),
    (sets("orbit.stand_off=10 cm", "orbit.density=11.34 kg/m^3"), 3, "materials lie between"),
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


FILE = """\
[body]
cube = "5.08 cm"
count = 900

[motion]
stroke = ["12.7 cm", "12.7 cm"]
speed = "1 m/s"
"""


def test_a_file_is_refused_with_the_line_of_each_key(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    file = tmp_path / "plan.toml"
    file.write_text(FILE)
    refused = call_json(capsys, *PLAN, str(file))
    assert refused["exit"] == 3
    assert {(one["what"], one["where"]) for one in refused["errors"]} == {
        ("body.stand_off is missing", f"{file}:1"), ("unknown key motion.speed", f"{file}:7"),
    }  # fmt: skip
    file.write_text(FILE.replace("speed", "# speed"))
    with pytest.raises(InertialcalError, match=r"plan.toml:6: motion.stroke: .*Give 2 different values"):
        ic.plan_mass_attraction(file, body={"stand_off": "7.6 cm"})


def test_the_example_file_the_command_and_python_give_the_same_rows(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """From the file that --write-example writes, with one key changed, to the last bit."""
    file = tmp_path / "plan.toml"
    assert call(capsys, *PLAN, "--write-example", str(file)) == (0, f"written: {file}\n", "")
    assert call(capsys, *PLAN, "--write-example", str(file))[0] == 3
    given: dict[str, Any] = tomllib.loads(file.read_text())
    known = {f"{group}.{key}" for group, keys in given.items() for key in keys}
    assert known == set(STARTER)
    content = call_json(capsys, *PLAN, str(file), *sets("body.count=40", "body.cube=10 cm"))
    assert [one["path"] for one in content["inputs"]] == [str(file)]
    small = {"count": 40, "cube": "10 cm"}
    plans = [
        ic.plan_mass_attraction(file, body=small), ic.plan_mass_attraction(given, body=small),
        ic.plan_mass_attraction(**(given | {"body": given["body"] | small})),
    ]  # fmt: skip
    assert all([row.to_dict() for row in plan.rows] == content["results"] for plan in plans)
    assert {one.name for one in plans[0].curves} == {
        "mass_body", "cube_as_point", "mass_growth", "mass_field", "mass_drive", "mass_forecast",
    }  # fmt: skip
    every = file.read_text().replace("# [", "[")
    every = "\n".join(line.removeprefix("# ") if " = " in line else line for line in every.splitlines())
    keys = {f"{group}.{key}" for group, table in tomllib.loads(every).items() for key in table}
    assert keys == {key for key, *_ in settings_table(Settings)}


def test_a_noise_file_lies_next_to_the_settings_that_name_it(tmp_path: Path) -> None:
    row = Row(Key("velocity_random_walk", "x"), 0.055, None, "ug/sqrt(Hz)").to_dict()
    (tmp_path / "noise.json").write_text(json.dumps({"results": [row | {"status": "estimated"}]}))
    file = tmp_path / "plan.toml"
    file.write_text(FILE.replace('"12.7 cm", "12.7', '"10 cm", "40').replace("speed = \"1 m/s\"", "")
                    + '[noise]\nfile = "noise.json"\n')  # fmt: skip
    plan = ic.plan_mass_attraction(file, body={"stand_off": "7.6 cm", "count": 40})
    assert plan.forecast is not None
    assert set(plan.inputs) == {str(file), str(tmp_path / "noise.json")}


def test_python_refuses_as_the_command_does() -> None:
    with pytest.raises(InertialcalError, match=r"body.stand_off is missing"):
        ic.plan_mass_attraction(body={"cube": "5.08 cm", "count": 900})

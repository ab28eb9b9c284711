"""Flips in a campaign file: reduced means and recordings, what is refused, and the mistakes of the rig, end to end."""

from __future__ import annotations

import shutil
import tomllib
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from fitted_results import fit_results
from inertialcal.campaign.engine.run import run
from inertialcal.campaign.engine.whole import check
from inertialcal.campaign.file.example import copy_example
from inertialcal.campaign.file.load import load
from inertialcal.campaign.models.find import load_model
from inertialcal.campaign.twins.score import coverage, score
from inertialcal.campaign.twins.twin import simulate
from inertialcal.core.errors import DataError, InertialcalError, PlanError
from inertialcal.core.show.rows import case_name, reason_text
from inertialcal.core.units import convert
from inertialcal.rigs import RIGS
from inertialcal.rigs.protocol import Rig, on_bench
from inertialcal.rigs.sams_tsh.rig import FAULTS, Bench, build
from inertialcal.signals.screening.screen import screen

STAMPS = 1e-8  # UNIX seconds with a fraction are good to 0.1 us in a file
SMALL = replace(Bench(), rate=5.0)
Edit = Callable[..., Path]


SMALL_FLIP = Rig("small_flip", "", on_bench(build, SMALL), FAULTS)


@pytest.fixture(scope="module")
def rig() -> Iterator[str]:
    """Name of the rig with records of 5 samples a second."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(RIGS, "small_flip", SMALL_FLIP)
        yield "small_flip"


@pytest.fixture(scope="module")
def simulated(rig: str, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return simulate(rig, tmp_path_factory.mktemp("twin") / "flip", 4).folder


def edited(source: Path, target: Path, *replacements: tuple[str, str], file: str = "campaign.toml") -> Path:
    """Copy a campaign with some text of a file replaced."""
    if not target.exists():
        shutil.copytree(source, target, ignore=shutil.ignore_patterns("out"))
    path = target / file
    text = path.read_text(encoding="utf-8")
    for old, new in replacements:
        assert old in text, f"no {old!r} in {file}"
        text = text.replace(old, new)
    path.write_text(text, encoding="utf-8")
    return target


@pytest.fixture
def turned(simulated: Path, tmp_path: Path) -> Edit:
    """The simulated campaign with some text replaced."""
    return lambda *pairs, file="campaign.toml": edited(simulated, tmp_path / "flip", *pairs, file=file)


@pytest.fixture
def published(tmp_path: Path) -> Edit:
    """The published campaign with some text replaced."""
    source = copy_example("sams1996", tmp_path / "source")
    return lambda *pairs, file="campaign.toml": edited(source, tmp_path / "sams", *pairs, file=file)


def refused(folder: Path, act: Callable[[Path], Any] = load) -> list[str]:
    with pytest.raises(InertialcalError) as caught:
        act(folder)
    return [" ".join(filter(None, (one.what, one.why, one.do))) for one in caught.value.problems]


# What is right


def test_a_simulated_flip_finds_its_truth(simulated: Path) -> None:
    outcome = run(simulated)
    assert outcome.verdict == "PASS"
    assert outcome.results["closed_loop"]["reason"] == "no test is held out"
    model = load_model(simulated)
    assert {name for name in model.provenance if name.startswith("bias")} == {"bias_y", "bias_z"}
    assert "scale_factor_error_y" in model.not_estimated
    found = score(simulated)
    named = {(row["quantity"], row["axis"]): row for row in found.rows}
    assert named["bias", "x"]["inside"] is None
    assert found.estimated == 8  # two of them of the model
    assert all(abs(row["value"] - row["truth"]) < 4.0 * row["u"] for row in found.rows if row["u"] is not None)


def test_in_memory_and_from_files_the_figures_are_the_same(simulated: Path) -> None:
    (result,) = fit_results(SMALL_FLIP.twin(4))
    rows = {(row["quantity"], row["axis"]): row for row in run(simulated, write=False).results["results"]
            if case_name(row) == ""}  # fmt: skip
    assert result.estimate is not None
    for i, name in enumerate(result.estimate.names):
        quantity, _, axis = name.rpartition("_")
        row = rows[quantity, axis]
        value, u = (
            float(convert([x], "m/s^2", row["unit"])[0]) for x in (result.estimate.values[i], result.estimate.u[i])
        )
        assert row["value"] == pytest.approx(value, rel=STAMPS)
        assert row["u"] == pytest.approx(u, rel=STAMPS)


def test_coverage_is_counted_for_every_quantity_that_is_estimated() -> None:
    found = {(one.key.quantity, one.key.axis): one for one in coverage(SMALL_FLIP.twin, 3)}
    assert set(found) == {
        ("ambient_acceleration", "y"), ("ambient_acceleration", "z"), ("bias", "y"), ("bias", "z"),
        ("reading", "x"), ("control_error", "x"),
    }  # fmt: skip
    assert all((one.n, one.missing) == (3, 0) for one in found.values())


def test_results_are_the_same_bytes_without_the_truth_and_wherever_the_folder_lies(
    simulated: Path, tmp_path: Path
) -> None:
    outputs = []
    for name in ("here", "there/deeper"):
        copy = tmp_path / name
        shutil.copytree(simulated, copy, ignore=shutil.ignore_patterns("out", ".truth"))
        run(copy)
        outputs.append({p.name: p.read_bytes() for p in (copy / "out").iterdir() if p.suffix in {".json", ".csv"}})
        outputs[-1].pop("provenance.json")
    assert outputs[0] == outputs[1]


def test_groups_are_flips(published: Edit) -> None:
    folder = published(('recordings = ["semiprocessed"]\n', 'recordings = ["semiprocessed"]\ngroups = ["2", "3"]\n'))
    rows = [row for row in run(folder).results["results"] if row["test"] == "flips"]
    assert {case_name(row) for row in rows if row["quantity"] == "bias"} >= {"", "flip 2", "flip 3"}
    assert "flip 1" not in {case_name(row) for row in rows}
    missing = published(('groups = ["2", "3"]', 'groups = ["7"]'))
    assert "no row is in its groups (7)" in refused(missing, run)[0]


def test_two_flips_that_find_one_bias_are_refused(published: Edit) -> None:
    folder = published(('use = "report_only"\n', ""), ('recordings = ["filtered"]', 'recordings = ["unfiltered"]'))
    assert any("both give bias of one sensor" in one for one in refused(folder, run))


# What is refused in a campaign file


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('use = "report_only"', 'use = "hold_out"', "no model is made of a flip and none judged on it"),
        ('mean = "mean_ug"\nunit = "ug"', 'mean = "mean_ug"\nunit = "furlong"', "furlong"),
        ('mean = "mean_ug"\nunit = "ug"', 'mean = "mean_ug"\nunit = "deg/s"', "need a unit of acceleration"),
        ('kind = "accelerometer"', 'kind = "gyro"', "flip tests accelerometers, the sensor is of kind 'gyro'"),
        ('procedure = "flip"\nrecordings = ["semi', 'procedure = "rate_table"\nrecordings = ["semi',
         "has means, a rate_table needs rows or channels"),
        ('angles = { forward = "0 deg", reverse = "180 deg" }\nhalf', "half", "angles is missing"),
        ('reverse = "180 deg" }\nhalf', 'reverse = "180 ug" }\nhalf',
         "means.angles.reverse"),
        ('plan = { axis = "x" }', 'plan = { axis = "w" }', "axis"),
        ('"0.95" = ', '"95" = ', "'95' is no probability"),
    ],
)  # fmt: skip
def test_what_cannot_be_meant_is_refused(published: Edit, old: str, new: str, words: str) -> None:
    pairs = [(old, new)]
    if "gyro" in new:
        pairs.append(('unit = "ug"\n\n[recordings.semi', 'unit = "deg/s"\n\n[recordings.semi'))
    assert any(words in one for one in refused(published(*pairs)))


def test_a_model_cannot_take_a_term_from_a_flip(turned: Edit) -> None:
    folder = turned(("[[requirements]]", '[model]\nterms = { scale_factor = ["flip"] }\n\n[[requirements]]'))
    assert any("'flip' is no test with use = 'fit' that gives it" in one for one in refused(folder))


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("x,1,reverse", "x,1,sideways", "position 'sideways' has no angle means.angles has: forward, reverse"),
        ("x,1,reverse", "w,1,reverse", "axis 'w'"),
        ("x,1,reverse", "x,1,forward", "axis x stands twice at 0 deg of flip 1"),
        ("mean_ug", "average", "mean_ug"),
    ],
)
def test_a_row_that_cannot_be_meant_is_refused(published: Edit, old: str, new: str, words: str) -> None:
    folder = published((old, new), file="table03_semiprocessed.csv")
    assert any(words in one for one in refused(folder, run))


def test_means_and_recordings_are_not_mixed_in_a_test(turned: Edit, published: Edit) -> None:
    folder = turned(
        ('recordings = ["flip"]', 'recordings = ["flip", "means"]'),
        ("[[tests]]", '[recordings.means]\nsensor = "head"\nfile = "means.csv"\nmeans = { axis = "axis", '
         'position = "orientation", flip = "time", mean = "mean_ug", unit = "ug", '
         'angles = { forward = "0 deg", reverse = "180 deg" } }\n\n[[tests]]'),
    )  # fmt: skip
    shutil.copy(published() / "table07_unfiltered.csv", folder / "means.csv")
    assert refused(folder, run) == [
        "test 'flip': reduced means (means) and recordings in one test Make two tests of them"
    ]


# Positions on the clock of the record


def test_a_recording_without_positions_is_refused(turned: Edit) -> None:
    text = (turned() / "campaign.toml").read_text(encoding="utf-8")
    first = text.index("positions = [")
    whole = text[first : text.index("\n]\n", first) + 3]
    (problem,) = refused(turned((whole, "")))
    assert "positions of the head are not given" in problem
    assert "positions = [" in problem


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("T12:14:40.000Z", "T10:14:40.000Z", "overlap"),
        ("1996-02-20T12:14:40.000Z", "006/00:14:40", "elapsed time"),
        ("1996-02-20T12:14:40.000Z", "yesterday", "positions: 'yesterday'"),
        ("T12:20:05.000Z", "T12:30:05.000Z", "ends before it starts"),
    ],
)
def test_a_time_that_cannot_be_meant_is_refused(turned: Edit, old: str, new: str, words: str) -> None:
    folder = turned((old, new))
    if words == "overlap":
        folder = turned(('stop = "1996-02-20T12:20:00.000Z"', 'stop = "1996-02-20T12:21:00.000Z"'))
    assert any(words in one for one in refused(folder, run))


def by_table(turned: Edit, rows: list[str], more: str = "") -> Path:
    """Return the simulated campaign with the positions of its head in a table."""
    folder = turned()
    text = (folder / "campaign.toml").read_text(encoding="utf-8")
    first = text.index("positions = [")
    whole = text[first : text.index("\n]\n", first) + 3]
    (folder / "dwells.csv").write_text("\n".join(["start,stop,angle,dwell", *rows]) + "\n")
    return turned((whole, f'dwells = {{ file = "dwells.csv", dwell = "dwell" }}\n{more}'))


def dwell_rows(folder: Path) -> list[str]:
    positions = tomllib.loads((folder / "campaign.toml").read_text(encoding="utf-8"))["recordings"]["flip"]["positions"]
    return [f"{one['start']},{one['stop']},{one['angle'].removesuffix(' deg')},{k}" for k, one in enumerate(positions)]


def test_positions_of_a_table_are_those_of_a_list(turned: Edit, simulated: Path) -> None:
    """A row without a dwell is none: here one that lies across a turn."""
    rows = dwell_rows(simulated)
    across = f"{rows[0].split(',')[0]},{rows[-1].split(',')[1]},0,"
    found, listed = (run(one, write=False).results["results"] for one in (by_table(turned, [*rows, across]), simulated))
    assert found == listed


def test_a_table_of_positions_that_says_none_is_refused(turned: Edit, simulated: Path) -> None:
    rows = dwell_rows(simulated)
    assert any("no row is a dwell" in one for one in refused(by_table(turned, [f"{rows[0].rpartition(',')[0]},"]), run))


def test_positions_that_are_said_twice_are_refused(turned: Edit, simulated: Path) -> None:
    rows = dwell_rows(simulated)
    start, stop, *_ = rows[0].split(",")
    more = f'positions = [{{ start = "{start}", stop = "{stop}", angle = "0 deg" }}]\n'
    assert any("both say" in one for one in refused(by_table(turned, rows, more)))


def test_positions_outside_the_record_are_refused(turned: Edit) -> None:
    (problem,) = refused(turned(("1996-02-20T12:", "1996-02-21T12:")), run)
    assert "holds 0 sample(s)" in problem
    assert "The record runs from 0 to" in problem


def test_GMT_day_of_year_is_understood(turned: Edit, simulated: Path) -> None:
    folder = turned(
        ("1996-02-20T12:14:40.000Z", "1996/051/12:14:40"), ("1996-02-20T12:20:00.000Z", "1996:051:12:20:00")
    )
    assert run(folder, write=False).results["results"] == run(simulated, write=False).results["results"]


def test_mission_elapsed_time_is_understood_with_its_start(turned: Edit, simulated: Path) -> None:
    given = [("1996-02-20T12:14:40.000Z", "005/11:14:40"), ("1996-02-20T12:20:00.000Z", "005/11:20:00")]
    folder = turned(*given, ('stamp = "middle"', 'stamp = "middle", mission_start = "1996-02-15T01:00:00Z"'))
    assert run(folder, write=False).results["results"] == run(simulated, write=False).results["results"]
    (problem,) = refused(turned(("1996-02-15T01:00:00Z", "at noon")))
    assert "recordings.flip.clock.mission_start" in problem


def test_windows_of_a_flip_would_have_no_effect_and_are_refused(turned: Edit) -> None:
    window = 'windows = [["1996-02-20T12:00:00Z", "1996-02-20T12:30:00Z"]]'
    (problem,) = refused(turned(('procedure = "flip"', f'procedure = "flip"\n{window}')))
    assert "windows, but a flip takes the positions of its recordings" in problem
    (problem,) = refused(turned((window, 'groups = ["1"]')))
    assert "Choose by positions" in problem


def test_a_standard_that_nothing_could_have_is_refused(turned: Edit) -> None:
    (problem,) = refused(turned(('angle = { u = "0.2 deg"', 'angle = { u = "1e29 deg"')))
    assert "no larger than 1e+09 rad" in problem


def test_the_place_of_a_problem_is_its_test_in_the_campaign_file(turned: Edit) -> None:
    with pytest.raises(DataError) as caught:
        run(turned(("1996-02-20T12:14:40.000Z", "006/00:14:40")))
    assert caught.value.problems[0].where.startswith("campaign.toml:")


# Mistakes of the flip: each is named


@pytest.mark.parametrize("fault", [name for name in FAULTS if name != "too_short"])
def test_every_mistake_is_named(rig: str, fault: str, tmp_path: Path) -> None:
    folder = simulate(rig, tmp_path / fault, 2, fault).folder
    outcome = run(folder)
    told = [one for one in outcome.remarks if one.code == FAULTS[fault].shows]
    assert told
    assert told[0].severity in ("warning", "error")
    assert told[0].what[:20] in (folder / "out" / "report.html").read_text(encoding="utf-8")


def test_a_window_shorter_than_the_settling_is_refused(rig: str, tmp_path: Path) -> None:
    folder = simulate(rig, tmp_path / "short", 2, "too_short").folder
    with pytest.raises(DataError, match="is no longer than the 20 s of settling") as caught:
        run(folder)
    assert [problem.code for problem in caught.value.problems] == [FAULTS["too_short"].shows]
    assert not (folder / "out").exists()


def test_pushes_of_the_crew_are_no_glitches() -> None:
    for seed in range(1, 6):
        (held,) = SMALL_FLIP.twin(seed).recordings.values()
        assert not [found for axis in "xyz" for found in screen(held.channel(axis).data, at_rest=False).codes], seed


def test_without_a_mistake_no_mistake_is_named() -> None:
    named = {one.shows for one in FAULTS.values()} | {"control_axis_not_zero"}
    for seed in range(1, 6):
        (result,) = fit_results(SMALL_FLIP.twin(seed))
        assert not named & {one.code for one in result.remarks}


def test_an_axis_whose_gain_changes_is_not_read_and_the_others_are(rig: str, tmp_path: Path) -> None:
    rows = run(simulate(rig, tmp_path / "gain", 2, "gain_changed").folder).results["results"]
    status = {(row["quantity"], row["axis"]): row for row in rows if case_name(row) == ""}
    assert reason_text(status["bias", "y"]) == "the y axis was not read"
    assert status["bias", "z"]["status"] == "estimated"


def test_a_single_sided_flip_gives_what_it_can_and_is_marked(rig: str, tmp_path: Path) -> None:
    rows = run(simulate(rig, tmp_path / "lost", 2, "missing_position").folder).results["results"]
    found = {(row["quantity"], row["axis"]): row for row in rows if case_name(row) == ""}
    assert found["reading", "y"]["status"] == "estimated"
    assert reason_text(found["reading", "y"]).startswith("bias and ambient acceleration together")
    for quantity in ("bias", "ambient_acceleration"):
        assert found[quantity, "y"]["value"] is None
        assert "missing position: y was read at 0 deg only" in reason_text(found[quantity, "y"])


def test_an_axis_at_the_rails_takes_nothing_from_the_others(rig: str, tmp_path: Path) -> None:
    rows = run(simulate(rig, tmp_path / "rails", 2, "at_rails").folder).results["results"]
    found = {(row["quantity"], row["axis"]): row for row in rows if case_name(row) == ""}
    assert found["bias", "y"]["status"] == "estimated"
    assert "the x axis was not read" in reason_text(found["reading", "x"])


def test_check_judges_the_inputs_of_a_flip(simulated: Path) -> None:
    campaign, inputs, remarks = check(simulated)
    assert set(inputs) == {"campaign.toml", "recordings/flip.csv"}
    assert "settling" in {one.code for one in remarks}
    with pytest.raises(PlanError):
        load(campaign.folder / "nowhere")

"""A simulated campaign on disk: complete, sealed, and the same results without its truth."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from fitted_results import fit_results
from inertialcal.campaign.engine.run import run
from inertialcal.campaign.engine.whole import check
from inertialcal.campaign.file.load import load
from inertialcal.campaign.twins.twin import TRUTH, read_truth, simulate
from inertialcal.core.errors import DataError, StoreError, UsageError
from inertialcal.core.show.rows import case_name
from inertialcal.core.units import convert
from inertialcal.files import read
from inertialcal.rigs import RIGS
from inertialcal.rigs.protocol import Rig
from inertialcal.rigs.rate_table import rig as rate_table
from inertialcal.rigs.rate_table.setup import Bench

pytestmark = pytest.mark.usefixtures("undrawn")

SMALL = Bench(rates_deg_s=(0.0, 2.0, -2.0, 4.5, -4.5, 0.0), dwell=24.0, runs=5, fit_runs=3)


@pytest.fixture(scope="module")
def small() -> Iterator[str]:
    """Name of a rig with short recordings."""
    with pytest.MonkeyPatch.context() as patch:
        rig = Rig("small", "", lambda seed, changes: rate_table.build(SMALL, seed))
        patch.setitem(RIGS, "small", rig)
        yield "small"


@pytest.fixture(scope="module")
def folder(small: str, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return simulate(small, tmp_path_factory.mktemp("twin") / "campaign", 3).folder


def test_a_simulated_campaign_passes_its_check(folder: Path) -> None:
    campaign, inputs, _ = check(folder)
    assert len(inputs) == 1 + 15
    assert [test.use for test in campaign.file.tests] == ["fit", "hold_out"]
    assert campaign.file.campaign.id == "rate_table-3"
    assert "@" not in (folder / "campaign.toml").read_text()


def test_recordings_come_back_from_their_files_as_they_were(folder: Path) -> None:
    for file, recording in rate_table.build(SMALL, 3).recordings.items():
        found = read(folder / file, time_column="unix_s")
        assert found.time_ns is not None
        assert recording.time_ns is not None
        assert np.array_equal(found.time_ns, recording.time_ns)
        assert np.array_equal(found.array(recording.names), recording.array())


def test_run_gives_the_same_bytes_without_the_truth_and_reads_nothing_of_it(folder: Path, tmp_path: Path) -> None:
    copy = tmp_path / "campaign"
    shutil.copytree(folder, copy)
    outputs = []
    for _ in range(2):
        run(copy)
        changing = ("provenance.json", "SHA256SUMS")
        outputs.append({p.name: p.read_bytes() for p in (copy / "out").iterdir() if p.name not in changing})
        shutil.rmtree(copy / ".truth", ignore_errors=True)
    assert not (copy / ".truth").exists()
    assert outputs[0] == outputs[1]
    inputs = json.loads((copy / "out" / "provenance.json").read_text())["inputs"]
    assert not [one for one in inputs if ".truth" in one["path"]]


def test_in_memory_and_from_files_the_figures_are_the_same(folder: Path) -> None:
    """What `score --rig` counts is what `run` gives."""
    estimate = fit_results(rate_table.build(SMALL, 3))[0].estimate
    assert estimate is not None
    rows = run(folder, write=False).results["results"]
    compared = 0
    for row in rows:
        name = f"{row['quantity']}_{row['axis']}"
        if row["test"] == "fit" and case_name(row) == "" and name in estimate.names:
            i = estimate.index(name)
            value, u = (
                float(convert([x], estimate.units[i], row["unit"])[0]) for x in (estimate.values[i], estimate.u[i])
            )
            assert row["value"] == pytest.approx(value, rel=1e-12)
            assert row["u"] == pytest.approx(u, rel=1e-12)
            compared += 1
    assert compared == len(estimate.names)


def test_the_truth_is_told_in_the_words_of_the_results(folder: Path) -> None:
    truth = read_truth(folder)
    named = {(row["quantity"], row["axis"]) for row in run(folder, write=False).results["results"]}
    assert {(one.quantity, one.axis) for one in truth.values} <= named
    assert (truth.rig, truth.seed, truth.fault) == ("small", 3, "")
    drawn = json.loads((folder / TRUTH).read_text())["drawn"]
    assert {"table_rate_error", "converter_reference_error", "tilt_and_azimuth_of_table", "mounting_x_turned"} <= set(
        drawn
    )


def test_the_seal_stands_in_the_campaign_file_and_a_changed_truth_is_refused(folder: Path, tmp_path: Path) -> None:
    assert read_truth(folder).seal in load(folder).file.campaign.source
    copy = tmp_path / "campaign"
    shutil.copytree(folder, copy)
    path = copy / TRUTH
    path.write_text(path.read_text().replace('"seed": 3', '"seed": 4'))
    with pytest.raises(DataError, match=r"campaign.source names another"):
        read_truth(copy)


def test_a_campaign_that_was_not_simulated_has_no_truth(folder: Path, tmp_path: Path) -> None:
    copy = tmp_path / "campaign"
    shutil.copytree(folder, copy, ignore=shutil.ignore_patterns(".truth"))
    with pytest.raises(DataError, match=r"no truth: .*only a simulated campaign can be scored"):
        read_truth(copy)


def test_a_truth_that_cannot_be_read_is_told(folder: Path, tmp_path: Path) -> None:
    copy = tmp_path / "campaign"
    shutil.copytree(folder, copy)
    seal = read_truth(copy).seal
    (copy / TRUTH).write_text("{}")
    emptied = "44136fa355b3678a1146ad16f7e8649e94fb4fc21fe77e8310c060f61caaff8a"  # SHA-256 of {}
    toml = copy / "campaign.toml"
    toml.write_text(toml.read_text().replace(seal, emptied))
    with pytest.raises(DataError, match="not a truth"):
        read_truth(copy)


@pytest.mark.parametrize("fault", ["missing_reference", "bit_low"])
def test_a_campaign_with_a_mistake_is_refused_from_its_files_too(fault: str, tmp_path: Path) -> None:
    written = simulate("rate_table", tmp_path / "campaign", 1, fault)
    with pytest.raises(DataError) as caught:
        check(written.folder)
    assert {problem.code for problem in caught.value.problems} == {rate_table.FAULTS[fault].shows}


def test_a_folder_with_something_in_it_is_refused(small: str, tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(UsageError, match="exists and is not empty"):
        simulate(small, tmp_path, 1)
    with pytest.raises(UsageError, match="exists and is not empty"):
        simulate(small, tmp_path / "mine.txt", 1)
    assert simulate(small, tmp_path / "a" / "b", 1).folder.is_dir()


def test_an_unknown_rig_and_a_negative_seed_are_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"no rig 'rate_tabel'.*There are: rate_table"):
        simulate("rate_tabel", tmp_path / "new", 1)
    with pytest.raises(UsageError, match="seed -1: need 0 or more"):
        simulate("rate_table", tmp_path / "new", -1)
    assert not (tmp_path / "new").exists()


def test_a_folder_that_cannot_be_written_leaves_nothing_behind(small: str, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(StoreError, match="cannot write"):
        simulate(small, tmp_path / "file" / "new", 1)
    assert [path.name for path in tmp_path.iterdir()] == ["file"]

"""Files of a shaker lead to their commands and into a campaign; recordings of other rigs and of others do not."""

from __future__ import annotations

import os
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

import inertialcal as ic
from independent.case import csv_text
from independent.shaking.quadratic import Shaken, record
from independent.shaking.shaker import Mode, recorded
from independent.shaking.shaker import Run as Sweep
from independent.trial import called
from independent.vibration.random_run import G, Run, simulate
from inertialcal.campaign.start.starter import start
from inertialcal.core.errors import InertialcalError
from inertialcal.core.recording import Recording
from inertialcal.procedures.vibration.suggest import shaken
from inertialcal.rigs import BUILT_IN, RIGS
from sized import sized

PROFILE = "frequency [Hz],density [g2/Hz]\n20,0.01\n80,0.04\n500,0.04\n2000,0.01\n"
QUICK = ("rate_table", "sams_tsh", "npsat1", "hand_held", "six_faces", "mesa", "climate")
SHARED = Path(os.environ.get("INERTIALCAL_SHARED", "/nowhere")) / "data"


def write(path: Path, rate: float, **columns: np.ndarray) -> None:
    names = ",".join(["time [s]", *columns])
    table = np.column_stack([np.arange(len(next(iter(columns.values())))) / rate, *columns.values()])
    np.savetxt(path, table, fmt="%.6g", delimiter=",", header=names, comments="")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("shaker")
    control = simulate(Run(duration=6.0, channels=2, coherence=0.99), 1)[0] / G
    write(root / "run.csv", 5120.0, **{"control_1 [g]": control[:, 0], "control_2 [g]": control[:, 1]})
    write(root / "bare_names.csv", 5120.0, **{"ch1 [g]": control[:, 0], "ch2 [g]": np.roll(control[:, 1], 3)})
    sweep = Sweep(per_minute=30.0, sample_rate=4000.0)
    table, item = recorded((Mode(300.0, 20.0),), sweep, np.random.default_rng(1), noise=(0.02, 0.02))
    write(root / "sweep.csv", 4000.0, **{"control [g]": table / G, "acc_x [g]": item / G})
    (root / "ride.csv").write_text(csv_text(record(1, Shaken(seconds=8.0))))
    (root / "level.csv").write_text(PROFILE)
    return root


@pytest.mark.parametrize(
    ("file", "next_command"),
    [
        ("run.csv", "vibration {} --profile FILE.csv"),
        ("bare_names.csv", "vibration {} --profile FILE.csv --control ch1"),
        ("sweep.csv", "vibration survey {}"),
        ("ride.csv", "vibration effects {}"),
        ("level.csv", "vibration profile {}"),
    ],
)
def test_info_leads_to_the_command_and_that_runs(folder: Path, file: str, next_command: str) -> None:
    words = ["vibration", "vibration profile", "vibration survey", "vibration effects"]
    survey = ic.info(folder / file, commands=words)
    assert survey.next == f"inertialcal {next_command.format(folder / file)}"
    typed = survey.next.replace("FILE.csv", str(folder / "level.csv")).split()[1:]
    assert called(typed, folder).exit == 0


def test_info_starts_without_scipy(folder: Path) -> None:
    code = (
        "import sys; from inertialcal.cli.__main__ import main\n"
        f"try: main(['info', {str(folder / 'run.csv')!r}])\n"
        "except SystemExit: pass\n"
        "assert 'scipy' not in sys.modules, sorted(m for m in sys.modules if m.startswith('scipy'))[:5]"
    )
    subprocess.run([sys.executable, "-c", code], check=True, capture_output=True)


def test_a_folder_becomes_a_campaign_of_the_right_tests(folder: Path, tmp_path: Path) -> None:
    for file in ("run.csv", "sweep.csv", "ride.csv", "level.csv"):
        (tmp_path / file).write_bytes((folder / file).read_bytes())
    path, _, remarks = start(tmp_path)
    assert not [one for one in remarks if one.severity != "info"]
    text = path.read_text()
    document = tomllib.loads(text)
    assert {one["procedure"]: one["recordings"] for one in document["tests"]} == {
        "vibration": ["run1"], "sine_survey": ["survey1"], "vibration_effects": ["ride1"],
    }  # fmt: skip
    assert document["recordings"]["run1"]["profile"] == "level.csv"
    path.write_text("\n".join(line.split("  # FILL IN")[0] for line in text.splitlines()).replace('""', '"a"'))
    assert called(["run", str(tmp_path)], tmp_path).exit == 0


def claimed(recordings: dict[str, Recording]) -> list[tuple[str, str]]:
    return [(name, one.kind) for name, recording in recordings.items() if (one := shaken(recording)) is not None]


@pytest.mark.parametrize("rig", QUICK)
def test_recordings_of_other_rigs_are_not_claimed(rig: str) -> None:
    for seed in range(1, sized(20, 1) + 1):
        assert not claimed(dict(RIGS.named(rig).make(seed, {}).recordings))


@pytest.mark.slow
@pytest.mark.parametrize("rig", sorted(set(BUILT_IN) - {"shaker", *QUICK}))
def test_recordings_of_slower_rigs_are_not_claimed(rig: str) -> None:
    assert not claimed(dict(RIGS.named(rig).make(1, {}).recordings))


@pytest.mark.slow
def test_recordings_of_others_are_not_claimed() -> None:
    if not SHARED.is_dir():
        pytest.skip("no shared recordings here")
    found, n = [], 0
    for path in sorted(one for one in SHARED.rglob("*") if one.is_file()):
        try:
            recordings = [ic.read(path)]
        except InertialcalError as error:
            recordings = [ic.read(path, topics=[one]) for one in error.problems[0].choices]
        n += len(recordings)
        found += [(path.name, one.kind) for each in recordings if (one := shaken(each)) is not None]
    assert n > 20
    assert not found

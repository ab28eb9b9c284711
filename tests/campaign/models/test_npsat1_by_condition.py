"""The rate suite by commands: a model in air and one in vacuum, each on the power-ups held out in its condition."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from independent.trial import Outcome, called
from inertialcal.campaign.file.load import load
from inertialcal.campaign.inputs.channels import chain_of, in_body_axes
from inertialcal.campaign.twins.twin import write_twin
from inertialcal.core.estimate import Array
from inertialcal.files import read
from inertialcal.physics.earth import earth_rate, level_to_table
from inertialcal.rigs.npsat1.unit import SETTLED_AIR, SETTLED_VACUUM
from inertialcal.rigs.twin import Twin
from inertialcal.statistics.intervals import coverage_factor, covers
from npsat1_small import short_twin
from sized import sized

AXES = ("x", "y", "z")
HELD = {"air": ("ambient_6", "ambient_7"), "vacuum": ("vacuum_6", "vacuum_7")}
SETTLED = {"air": 2.0 * SETTLED_AIR, "vacuum": SETTLED_VACUUM}  # [s]
OTHER = {"air": "vacuum", "vacuum": "air"}
RUNS = 5  # behind each fit
COLUMNS = [word for axis in AXES for word in ("--column", f"temperature_{axis}=t{axis} [degC]")]
PARTS = ("thermal", "rate_table")


def made(seed: int, folder: Path) -> tuple[Twin, Path]:
    """Write a short campaign, run it, and return it with its folder."""
    twin = short_twin(seed, parts=PARTS)
    write_twin(twin, folder)
    outcome = called(["run", str(folder)], folder)
    assert outcome.exit in (0, 4), outcome.printed
    return twin, folder


def in_units(folder: Path, name: str, gauge: bool = True) -> Path:
    """Write a recording of the campaign as rates of the body, with temperatures and, of a gauge, the pressure."""
    campaign = load(folder)
    entry = campaign.file.recordings[name]
    sensor = campaign.file.sensors[entry.sensor]
    body = in_body_axes(read(folder / entry.file), name, entry, sensor, chain_of(entry, sensor))
    columns = {f"g{axis} [deg/s]": np.degrees(body.channel(axis).data) for axis in AXES}
    columns |= {f"t{axis} [degC]": body.channel(f"temperature_{axis}").data for axis in AXES}
    columns |= {"pressure [Pa]": body.channel("pressure").data} if gauge else {}
    assert body.time_ns is not None
    time = (body.time_ns - body.time_ns[0]) / 1e9 + 1.0
    rows = np.column_stack([time, *columns.values()])
    path = folder / f"{name}{'' if gauge else '_bare'}_units.csv"
    lines = [",".join("" if np.isnan(cell) else f"{cell:.9g}" for cell in row) for row in rows.tolist()]
    path.write_text("\n".join([",".join(["time_s", *columns]), *lines]) + "\n", encoding="utf-8")
    return path


def compensated(folder: Path, path: Path, condition: str) -> Outcome:
    """Compensate a recording by the model of a condition; what it makes is in ``out.csv``."""
    (folder / "out.csv").unlink(missing_ok=True)
    words = ["compensate", str(folder / "out/model.json"), str(path), "-o", str(folder / "out.csv"), "--uncertainty"]
    return called([*words, *COLUMNS, "--condition", condition], folder)


def left(twin: Twin, folder: Path, path: Path, condition: str, of: str) -> Array:
    """Return mean compensated rate less the earth's, once settled, and its u, by axis, shape (2, 3) [deg/s]."""
    outcome = compensated(folder, path, of)
    assert outcome.exit == 0, outcome.printed
    table = np.genfromtxt(folder / "out.csv", delimiter=",", names=True, deletechars="")
    settled = table["time_s"] > SETTLED[condition]
    names = [next(name for name in table.dtype.names or () if name.startswith(f"{stem}{axis}_"))
             for stem in ("g", "u_g") for axis in AXES]  # fmt: skip
    means = np.array([np.nanmean(table[name][settled]) for name in names]).reshape(2, 3)
    tilt, azimuth = np.asarray(twin.drawn["tilt_and_azimuth_of_chamber"])
    earth = level_to_table(float(tilt), float(azimuth)) @ earth_rate(float(np.asarray(twin.drawn["latitude"])))
    return np.array([means[0] - np.degrees(earth), means[1]])


def inside(seed: int, folder: Path) -> list[tuple[str, Array, Array]]:
    """Return what is left of each power-up held out, by condition: residuals and u."""
    twin, folder = made(seed, folder)
    found = []
    for condition, names in HELD.items():
        for name in names:
            rest, u = left(twin, folder, in_units(folder, name), condition, condition)
            found.append((condition, rest, u))
    return found


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> tuple[Twin, Path]:
    return made(4, tmp_path_factory.mktemp("conditions") / "campaign")


@pytest.mark.parametrize("condition", HELD)
def test_the_model_of_a_condition_leaves_what_it_states(campaign: tuple[Twin, Path], condition: str) -> None:
    twin, folder = campaign
    reach = coverage_factor(RUNS - 1.0)
    found = [left(twin, folder, in_units(folder, name), condition, condition) for name in HELD[condition]]
    assert sum(bool(abs(e) <= reach * s) for rest, u in found for e, s in zip(rest, u, strict=True)) >= 5
    assert np.all([u < 0.012 for _, u in found])


def test_the_model_of_air_leaves_more_in_vacuum(campaign: tuple[Twin, Path]) -> None:
    twin, folder = campaign
    bare = in_units(folder, "vacuum_6", gauge=False)
    (own, _), (other, _) = (left(twin, folder, bare, "vacuum", model) for model in ("vacuum", "air"))
    assert float(np.linalg.norm(other)) > 3.0 * float(np.linalg.norm(own))


@pytest.mark.parametrize("condition", HELD)
def test_the_wrong_condition_is_refused(campaign: tuple[Twin, Path], condition: str) -> None:
    _, folder = campaign
    path = in_units(folder, HELD[condition][0])
    refused = compensated(folder, path, OTHER[condition])
    assert refused.exit == 3
    assert refused.codes["wrong_condition"]
    assert condition in refused.printed
    assert not (folder / "out.csv").exists()


@pytest.mark.parametrize("words", [["export", "out/model.json", "--to", "python", "-o", "no.py"],
                                   ["compensate", "out/model.json", "bare.csv", "-o", "no.csv", *COLUMNS]])  # fmt: skip
def test_without_a_condition_it_is_asked_for(campaign: tuple[Twin, Path], words: list[str]) -> None:
    _, folder = campaign
    in_units(folder, "vacuum_6", gauge=False).rename(folder / "bare.csv")
    paths = [str(folder / word) if word.startswith(("out/", "bare", "no.")) else word for word in words]
    refused = called(paths, folder)
    assert refused.exit in (2, 3)
    assert refused.codes["condition_needed"]
    assert "--condition" in refused.printed


def test_a_test_in_vacuum_after_one_in_air_is_refused(campaign: tuple[Twin, Path], tmp_path: Path) -> None:
    _, folder = campaign
    text = (folder / "campaign.toml").read_text(encoding="utf-8")
    changed = text.replace('after = ["thermal_ambient"]', 'after = ["thermal_vacuum"]')
    assert changed != text
    (tmp_path / "campaign.toml").write_text(changed, encoding="utf-8")
    (tmp_path / "recordings").symlink_to(folder / "recordings")
    refused = called(["check", str(tmp_path)], tmp_path)
    assert refused.exit == 3
    assert refused.codes["condition_differs"]


@pytest.mark.slow
def test_power_ups_held_out_lie_where_the_models_say(tmp_path: Path) -> None:
    reach = coverage_factor(RUNS - 1.0)
    hits = {condition: [0, 0] for condition in HELD}
    for seed in range(1, sized(12, 4) + 1):
        for condition, rest, u in inside(seed, tmp_path / str(seed)):
            hits[condition][0] += int(np.count_nonzero(np.abs(rest) <= reach * u))
            hits[condition][1] += len(AXES)
    assert all(covers(*one) for one in hits.values()), hits

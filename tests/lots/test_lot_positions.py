"""Lots of positions: triads in rows of one file, and recordings whose sections lie in the folder of the unit."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from small_lot import rows as rows_of

import inertialcal as ic
from independent.case import START
from independent.positions import FACES, G, tumbled
from inertialcal.core.errors import InertialcalError
from inertialcal.core.results import flat

UNITS, POSITIONS = 12, 18
HEAD = """schema = 2
[campaign]
id = "triads"
[item]
part = "A1"
[site]
gravity = "9.81 m/s2"
[standards.gravity]
value = { u = "0.0001 m/s2" }
[standards.fixture]
orientation = { u = "0.05 deg" }
mounting = { u = "0.05 deg" }
[sensors.acc]
kind = "accelerometer"
axes = ["x", "y", "z"]
unit = "m/s2"
[[tests]]
id = "triad"
procedure = "positions"
recordings = ["acc"]
[recordings.acc]
sensor = "acc"
"""
RESTS = """file = "triads.parquet"
[recordings.acc.rests]
unit = "m/s2"
reading = { x = "acc_x", y = "acc_y", z = "acc_z" }
scatter = { x = "acc_x_std", y = "acc_y_std", z = "acc_z_std" }
samples = "samples"
"""
SECTIONS = """file = "hand.csv"
sections = "parts/hand.csv"
clock = { column = "unix_s" }
[recordings.acc.channels]
x = { column = "x", unit = "m/s2" }
y = { column = "y", unit = "m/s2" }
z = { column = "z", unit = "m/s2" }
"""


def rows(out: Path) -> list[dict[str, Any]]:
    return rows_of(out)


def figures(row: dict[str, Any]) -> dict[tuple[str, str], tuple[float, float]]:
    """Return value and standard uncertainty by quantity and axis, scale factor errors in %, angles in rad."""
    scale = {"deg": np.pi / 180.0}
    return {
        (one["quantity"], one["axis"]): tuple(one[name] * scale.get(one["unit"], 1.0) for name in ("value", "u"))
        for one in row["results"]
        if one["value"] is not None and one["u"] is not None and one["test"] == "triad"
    }


def test_triads_in_rows_of_one_file_hold_their_truth_and_bad_ones_are_named(tmp_path: Path) -> None:
    cases = [tumbled(seed, positions=POSITIONS, condition=(0.0, 40.0), cone=180.0) for seed in range(UNITS)]
    tables = [{name: np.array(values) for name, values in one.tables["rests.csv"].columns.items()} for one in cases]
    tables[1] = {name: values[:3] for name, values in tables[1].items()}
    tables[2]["acc_y"][4] = np.nan
    tables[3] = {name: values / G if name[:3] == "acc" else values for name, values in tables[3].items()}
    tables[4]["acc_z"][7] += 0.5
    serials = [f"T{seed}" for seed in range(UNITS) for _ in range(len(tables[seed]["acc_x"]))]
    columns = {name: np.concatenate([one[name] for one in tables]) for name in tables[0]}
    lot = tmp_path / "lot"
    lot.mkdir()
    pq.write_table(pa.table({"serial": serials, **columns}), lot / "triads.parquet")
    (lot / "campaign.toml").write_text(HEAD + RESTS, encoding="utf-8", newline="\n")
    names = "\n".join(dict.fromkeys(serials))
    (lot / "units.csv").write_text(f"serial\n{names}\n", encoding="utf-8", newline="\n")
    text = 'schema = 1\nid = "t"\nunits = "units.csv"\n[files]\nacc = { file = "triads.parquet", serial = "serial" }\n'
    (lot / "LOT.toml").write_text(text, encoding="utf-8", newline="\n")
    ic.lot(lot / "LOT.toml", tmp_path / "out", workers=0, report=False)
    found = rows(tmp_path / "out")
    assert [one["reason_code"] for one in found[:5]] == ["", "too_few_positions", "nan_in_required", "unit_slip", ""]
    (outlier,) = (one for one in found[4]["remarks"] if one["code"] == "outlier_position")
    assert outlier["where"] == "position 8 (triads.parquet:8)"
    within = []
    for case, row in zip(cases, found, strict=True):
        for (quantity, axis), (value, u) in figures(row).items() if row["status"] == "done" else ():
            truth = case.truth.get(f"{quantity} {axis} accelerometer")
            if truth is not None:
                within.append(abs(value - truth) < 4.0 * u)
    assert len(within) > 60
    assert np.mean(within) > 0.98


REFUSED = {4: "too_few_positions", 5: "too_few_positions", 7: "nan_in_required", 8: "unit_slip"}
MISNAMED = {1: "position_misnamed", 6: "position_misnamed"}  # where the orientations are known


def triads() -> list[dict[str, Any]]:
    """Return mean readings of a sound unit, and of units each with a fault, as columns."""
    found = []
    for number in range(9):
        rng = np.random.default_rng(number + 1)
        up = np.vstack([np.array(list(FACES.values()), dtype=float), rng.standard_normal((12, 3))])
        up /= np.linalg.norm(up, axis=1)[:, None]
        held = up + 1e-3 * rng.standard_normal(up.shape)
        read = G * held @ (np.eye(3) + 0.01 * rng.standard_normal((3, 3))).T + 0.05 * rng.standard_normal(3)
        read += 1e-3 * rng.standard_normal(read.shape)
        if number == 1:  # two positions are swapped
            read[[0, 7]] = read[[7, 0]]
        elif number == 2:  # one was moved while it was read
            read[5] += (0.0, 0.4, 0.0)
        elif number == 3:  # an outlier
            read[9] += 0.3
        elif number == 4:
            read, up = read[:3], up[:3]
        elif number == 5:  # a dead axis
            read[:, 2] = 0.0
        elif number == 6:  # of the wrong sign
            read[:, 0] *= -1.0
        elif number == 7:
            read[4, 1] = np.nan
        elif number == 8:  # in g
            read /= G
        found.append(
            {f"acc_{axis}": read[:, k] for k, axis in enumerate("xyz")}
            | {f"acc_{axis}_std": np.full(len(read), 0.01) for axis in "xyz"}
            | {"samples": np.full(len(read), 100.0)}
            | {f"up_{axis}": up[:, k] for k, axis in enumerate("xyz")}
        )
    return found


@pytest.mark.parametrize("chosen", [(0, 3, 6), pytest.param(tuple(range(9)), marks=pytest.mark.slow)])
def test_a_triad_of_a_lot_has_the_figures_and_remarks_of_its_own_campaign(
    tmp_path: Path, chosen: tuple[int, ...]
) -> None:
    units, lot = [triads()[number] for number in chosen], tmp_path / "lot"
    lot.mkdir()
    serials = [f"T{number}" for number, unit in enumerate(units) for _ in unit["acc_x"]]
    columns = {name: np.concatenate([one[name] for one in units]) for name in units[0]}
    pq.write_table(pa.table({"serial": serials, **columns}), lot / "triads.parquet")
    for known in (False, True):
        text = HEAD + RESTS + ('direction = { x = "up_x", y = "up_y", z = "up_z" }\n' if known else "")
        (lot / "campaign.toml").write_text(text, encoding="utf-8", newline="\n")
        names = "\n".join(dict.fromkeys(serials))
        (lot / "units.csv").write_text(f"serial\n{names}\n", encoding="utf-8", newline="\n")
        own = 'schema = 1\nid = "t"\nunits = "units.csv"\n'
        own += '[files]\nacc = { file = "triads.parquet", serial = "serial" }\n'
        (lot / "LOT.toml").write_text(own, encoding="utf-8", newline="\n")
        ic.lot(lot / "LOT.toml", tmp_path / f"out-{known}", workers=0, report=False)
        found = rows(tmp_path / f"out-{known}")
        codes = REFUSED | (MISNAMED if known else {})
        assert [one["reason_code"] for one in found] == [codes.get(number, "") for number in chosen]
        for number, (unit, row) in enumerate(zip(units, found, strict=True)):
            alone = tmp_path / f"{known}-{number}"
            alone.mkdir()
            pq.write_table(pa.table(unit), alone / "triads.parquet")
            (alone / "campaign.toml").write_text(text, encoding="utf-8", newline="\n")
            try:
                result = ic.run(alone, write=False)
            except InertialcalError as error:
                refused = error.problems[0].code
                assert row["reason_code"] == refused
                continue
            assert row["status"] == "done"
            said = {(one["code"], one["what"]) for one in result.results["remarks"]}
            assert {(one["code"], one["what"]) for one in row["remarks"]} == said
            for one, expected in zip(row["results"], map(flat, result.results["results"]), strict=True):
                for name, cell in expected.items():
                    close = isinstance(cell, float) and isinstance(one[name], float)
                    assert np.isclose(one[name], cell, rtol=1e-9, atol=0.0) if close else one[name] == cell


def recording(folder: Path, order: str, seed: int, rest: int) -> None:
    """Write a unit: a recording of six faces in an order, and its own table of sections."""
    rng, faces = np.random.default_rng(seed), order.split()
    up = np.repeat([FACES[face] for face in faces], rest, axis=0)
    values = G * up + 0.05 + 0.01 * rng.standard_normal(up.shape)
    stamps = [f"{START + 0.1 * k:.1f}" for k in range(len(up))]
    lines = [f"{t},{x:.6f},{y:.6f},{z:.6f}" for t, (x, y, z) in zip(stamps, values, strict=True)]
    parts = [f"{face},{k * rest},{(k + 1) * rest}" for k, face in enumerate(faces)]
    (folder / "parts").mkdir(parents=True)
    (folder / "hand.csv").write_text("\n".join(["unix_s,x,y,z", *lines]) + "\n", encoding="utf-8", newline="\n")
    text = "\n".join(["section,start,end", *parts]) + "\n"
    (folder / "parts" / "hand.csv").write_text(text, encoding="utf-8", newline="\n")


def test_sections_are_those_in_the_folder_of_the_unit(tmp_path: Path) -> None:
    lot, out = tmp_path / "lot", tmp_path / "out"
    recording(lot / "U1", "x+ x- y+ y- z+ z-", 1, 60)
    recording(lot / "U2", "z- y+ x- z+ x+ y-", 2, 45)
    (lot / "campaign.toml").write_text(HEAD + SECTIONS, encoding="utf-8", newline="\n")
    ic.lot(lot, out, workers=0, report=False)
    for row in rows(out):
        assert row["status"] == "done", row["reason"]
        assert [one["path"].partition("/")[2] for one in row["inputs"]] == ["hand.csv", "parts/hand.csv"]
        own = figures(row)
        for axis in "xyz":
            value, u = own["bias", axis]
            assert abs(value - 0.05) < 4.0 * u
    assert ic.lot(lot, out, workers=0, resume=True, report=False).kept == 2
    (lot / "U2" / "parts" / "hand.csv").write_text("section,start,end\nx+,0,45\n", encoding="utf-8", newline="\n")
    assert ic.lot(lot, out, workers=0, resume=True, report=False).redone == 1
    assert [one["reason_code"] for one in rows(out)] == ["", "too_few_positions"]

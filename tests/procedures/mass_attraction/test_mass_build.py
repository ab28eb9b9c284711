"""The list of cubes: it is the body of the plan by a sum that shares nothing with it, and can be built in its order."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import inertialcal as ic
from inertialcal.cli.__main__ import main
from inertialcal.core.errors import PlanError
from inertialcal.procedures.mass_attraction.planning.build import Build
from inertialcal.report.figures.mass_attraction.build_drawing import sheet_of, write_build

EQUAL = {"cube": "5.08 cm", "count": 900, "stand_off": "7.6 cm"}
LEAD = [{"count": 100, "edge": "10.2 cm"}, {"count": 100, "edge": "5.1 cm"}]
TWO = {"cubes": LEAD, "stand_off": "7.6 cm"}
BIG_G, GRAVITY = 6.67430e-11, 9.80665
NODES, WEIGHTS = np.polynomial.legendre.leggauss(6)
QUADRATURE = 1e-6  # relative, of cubes at 0.75 of their edge
MOTION = {"stroke": ["12.7 cm", "43.2 cm"], "direction": "across"}


def listed(text: str) -> list[dict[str, float]]:
    """Read the CSV as anybody would."""
    lines = [line for line in text.splitlines() if not line.startswith("#")]
    return [{name.split(" ")[0]: float(cell) for name, cell in row.items()} for row in csv.DictReader(lines)]


def attraction(rows: list[dict[str, float]], raised: float = 0.0) -> float:
    """Sum the pull along x of all cubes at the origin [ng], by Gauss and Legendre inside each, the body raised [cm]."""
    nodes = np.stack(np.meshgrid(NODES, NODES, NODES, indexing="ij"), axis=-1).reshape(-1, 3) / 2.0
    weights = np.einsum("i,j,k->ijk", WEIGHTS, WEIGHTS, WEIGHTS).ravel() / 8.0
    total = 0.0
    for row in rows:
        middle = np.array([row["x_centre"], row["y_centre"], row["z_centre"] + raised])
        at = 0.01 * (middle + row["edge"] * nodes)
        total += row["mass"] * float(np.sum(weights * at[:, 0] / np.sum(at**2, axis=1) ** 1.5))
    return 1e9 * BIG_G * total / GRAVITY


@pytest.mark.parametrize("body", [EQUAL, TWO], ids=["equal", "two sizes"])
def test_the_list_attracts_as_the_plan(body: dict[str, Any]) -> None:
    plan = ic.plan_mass_attraction(body=body, motion=MOTION)
    rows = listed(plan.build.csv())
    stated = {row.quantity: row.value for row in reversed(plan.rows)}
    assert attraction(rows) == pytest.approx(stated["attraction"], rel=1e-5)
    amplitude = 0.5 * abs(attraction(rows, -12.7) - attraction(rows, -43.2))
    assert amplitude == pytest.approx(stated["amplitude"], rel=1e-5)
    assert sum(row["mass"] for row in rows) == pytest.approx(stated["mass"], rel=1e-6)
    assert len(rows) == (900 if body is EQUAL else 200)


@pytest.mark.parametrize("body", [EQUAL, TWO], ids=["equal", "two sizes"])
def test_cubes_do_not_overlap_and_are_placed_from_below(body: dict[str, Any]) -> None:
    build = ic.plan_mass_attraction(body=body).build
    rows = listed(build.csv())
    low = np.array([[row["x_corner"], row["y_corner"], row["z_corner"]] for row in rows])
    edge = np.array([row["edge"] for row in rows])
    high = low + edge[:, None]
    overlap = np.minimum(high[:, None], high[None]) - np.maximum(low[:, None], low[None])
    pairs = np.argwhere((overlap > 1e-6).all(axis=2))
    assert (pairs[:, 0] == pairs[:, 1]).all()
    assert (np.diff(low[:, 2]) > -1e-6).all()
    assert [row["cube"] for row in rows] == list(range(1, len(rows) + 1))
    for at in np.flatnonzero(low[:, 2] > low[:, 2].min() + 1e-6)[:150]:
        below = np.abs(high[:at, 2] - low[at, 2]) < 1e-6  # placed before it
        shared = np.prod(np.clip(overlap[at, :at, :2], 0.0, None), axis=1)
        assert 100.0 * shared[below].sum() / edge[at] ** 2 == pytest.approx(rows[at]["rests_on"], abs=0.51)
    centre = np.array([[row["x_centre"], row["y_centre"], row["z_centre"]] for row in rows])
    np.testing.assert_allclose(centre, low + 0.5 * edge[:, None], atol=2e-6)


def test_the_command_writes_list_and_drawing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    words = ["plan", "mass-attraction", "--set", "body.stand_off=7.6 cm", "--set", "body.cube=5.08 cm",
             "--set", "body.count=100"]  # fmt: skip
    with pytest.raises(SystemExit) as left:
        main([*words, "--build", "mass", "--json"])
    found = json.loads(capsys.readouterr().out)
    assert (left.value.code, found["written"]) == (
        0, ["written: mass/cubes.csv (100 cubes)", "written: mass/cubes.pdf (100 cubes)"],
    )  # fmt: skip
    assert "packing" in {one["code"] for one in found["remarks"]}
    text = Path("mass/cubes.csv").read_text(encoding="utf-8")
    assert "# 100 cubes of 5.08 cm: 1.48663 kg each, 148.663 kg" in text
    assert len(ic.read_table("mass/cubes.csv").text("cube")) == 100
    assert Path("mass/cubes.pdf").read_bytes().startswith(b"%PDF")
    with pytest.raises(SystemExit) as left:
        main([*words, "--build", "mass.txt"])
    assert left.value.code == 2
    assert "End the name with one of" in capsys.readouterr().err


def test_every_cube_is_numbered_in_its_layers(tmp_path: Path) -> None:
    """A small cube once, a large one where it is placed and in the next layer; numbers that stand nowhere else."""
    sizes = [{"count": 12, "edge": "10.2 cm"}, {"count": 20, "edge": "5.1 cm"}]
    build = ic.plan_mass_attraction(body={"cubes": sizes, "stand_off": "7.6 cm"}).build
    write_build(tmp_path / "cubes.svg", build, "two sizes")
    text = (tmp_path / "cubes.svg").read_text(encoding="utf-8")
    numbers = [part.split(" -->")[0] for part in text.split("<!-- ")[1:]]
    for cube in (21, 22, 23, 24, 26, 27):
        assert numbers.count(str(cube)) == (2 if build.edge[cube - 1] > 0.06 else 1), cube


def test_what_cannot_be_drawn_is_refused() -> None:
    cells = np.stack(np.meshgrid(*[np.arange(n) for n in (10, 200, 10)], indexing="ij"), axis=-1).reshape(-1, 3)
    many = Build(
        np.full(len(cells), 0.01),
        np.multiply(0.01, cells, dtype=np.float64),
        1 + cells[:, 2],
        np.ones(len(cells)),
        11340.0,
        0.01,
    )
    with pytest.raises(PlanError, match="too small to read"):
        sheet_of(many)
    orbit = {"density": "19300 kg/m^3", "stand_off": "10 cm", "acceleration": "1e-9 m/s^2"}
    plan = ic.plan_mass_attraction(orbit=orbit)
    with pytest.raises(PlanError, match="not built of cubes"):
        plan.build  # noqa: B018

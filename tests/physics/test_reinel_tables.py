"""Reinel, NASA TM X-53857: what of Tables 2 and 3, Figure 3 and the text follows from his own masses (errata.csv)."""

from __future__ import annotations

import csv
import functools
import math
from pathlib import Path

import numpy as np
import pytest
from closed_bodies import Point
from scipy import interpolate

from inertialcal.core.constants import REINEL_GRAVITATIONAL_CONSTANT, REINEL_GRAVITY
from inertialcal.physics.attraction.bodies import Lattice, Prism
from inertialcal.physics.attraction.extended import ProofMass, mean_field
from inertialcal.physics.mass_shape.cells import Grid, best_cells

G = REINEL_GRAVITATIONAL_CONSTANT.value * 1e-3  # m^3/s^2/kg
NG = REINEL_GRAVITY.value * 1e-2 * 1e-9  # m/s^2
INCH = 0.0254
TABLE_2 = {2: 81.8, 4: 67.2, 5: 60.8, 10: 38.1, 15: 25.3, 20: 17.7, 25: 13.0, 30: 10.0}  # inches from the face; ng
PULL = (1.0, 0.0, 0.0)


@functools.cache
def body(stand_off: float, edge: float) -> Lattice:
    return best_cells(Grid(edge, (10, 20, 20), stand_off, 11340.0), 900)


def pull(mass: Lattice, x: float, z: float = 0.0) -> float:
    """Attraction of a mass shifted by x and -z. [ng]."""
    return G * float(mass.field(np.array([[-x, 0.0, z]]))[0, 0]) / NG


def test_table_2_has_the_shape_of_the_model_and_two_per_cent_too_much() -> None:
    """errata.csv: printed over model is 1.020 +- 0.002 in seven rows, in inches."""
    mass = body(4 * INCH, 2 * INCH)
    ratios = np.array([printed / pull(mass, (inches - 4) * INCH) for inches, printed in TABLE_2.items()])
    assert int(np.sum(np.abs(ratios - 1.020) <= 0.0025)) >= 7
    assert (np.abs(ratios - 1.020) < 0.012).all()


def test_table_2_in_centimetres() -> None:
    """errata.csv: 80.5 66.1 60.0 37.7 25.0 17.5 12.9 9.8 ng; the body made for 10.2 cm, moved."""
    faces = 0.01 * np.array([5.1, 10.2, 12.7, 25.4, 38.1, 50.8, 63.5, 76.2])
    model = [pull(body(0.102, 0.051), float(face) - 0.102) for face in faces]
    np.testing.assert_allclose(model, [80.5, 66.1, 60.0, 37.7, 25.0, 17.5, 12.9, 9.8], atol=0.06)
    assert TABLE_2[2] - TABLE_2[30] == pytest.approx(71.8)  # "70 ng by moving the mass about 76.2 cm"


def test_table_3_differs_from_the_model_by_four_per_cent_along_the_travel(shared: Path) -> None:
    """The stack as it stood is not in the text: only the shape can be compared."""
    with (shared / "reference/reinel1969/table3_lead_body_vertical.csv").open() as rows:
        table = np.array([[float(v) for v in row.values()] for row in csv.DictReader(rows)])
    model = [pull(body(0.076, 0.051), 0.0, cm * 0.01) for cm in table[:, 0]]
    ratios = table[:, 1] / np.array(model)
    assert 0.955 < ratios.min() < ratios[0] < ratios.max() < 1.045
    assert ratios[0] == pytest.approx(74.017 / 73.13, abs=0.002)  # 73.09 to 73.16 ng
    at = int(np.argmin(np.abs(table[:, 0] - 45.7)))
    near = [at - 3, at - 2, at - 1, at + 1, at + 2, at + 3]
    smooth = interpolate.BarycentricInterpolator(np.arange(22.0)[near], table[near, 1])(float(at))
    assert float(smooth) == pytest.approx(18.994, abs=0.003)  # 18.904 is printed
    assert table[at, 1] == 18.904


@pytest.mark.parametrize(
    ("way", "error"),
    [((1, 0, 0), 4.361e-3), ((1, 1, 0), -0.897e-3), ((1, 1, 1), -3.346e-3)],
    ids=["face", "edge", "vertex"],
)
def test_figure_3_the_cube_against_the_point_at_two_edges(way: tuple[int, int, int], error: float) -> None:
    """errata.csv; Reinel has 1e-3. One less cube over point."""
    assert apart(2.0, way) == pytest.approx(error, abs=5.1e-7)


def test_figure_3_one_thousandth_needs_almost_three_edges() -> None:
    assert apart(2.85, PULL) > 1e-3 > apart(2.95, PULL)


def apart(distance: float, way: tuple[float, float, float]) -> float:
    at = distance * np.array([way]) / math.hypot(*way)
    cube = float(np.linalg.norm(Prism((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5), 1.0).field(at)))
    return 1.0 - cube / float(np.linalg.norm(Point(1.0).field(at)))


def test_the_proof_mass_is_a_point_for_the_whole_body_only() -> None:
    """errata.csv: 1.47e-2 for a cube centre at 10.2 cm, 9.4e-3 at 12.75 cm, 4.0e-4 for the whole; shell of 2.915 cm."""
    shell = ProofMass(0.02915, 0.00634, 0.00634)
    assert gained(Point(1.0, (0.102, 0.0, 0.0)), shell) == pytest.approx(1.47e-2, abs=5e-5)
    assert gained(Point(1.0, (0.1275, 0.0, 0.0)), shell) == pytest.approx(9.4e-3, abs=5e-5)
    assert gained(body(0.102, 0.051), shell) == pytest.approx(4.0e-4, abs=5e-6)


def gained(source: Point | Lattice, shell: ProofMass) -> float:
    here = np.zeros((1, 3))
    return float(mean_field(source, shell, here)[0, 0] / source.field(here)[0, 0]) - 1.0


def test_the_satellites_mass() -> None:
    """errata.csv: 1 kg of lead gives 4.05e-10 g at 10.2 cm; 4 kg are proposed for 1e-9 g."""
    fields = []
    for mass in (1.0, 4.0):
        radius = (3.0 * mass / (4.0 * math.pi * 11340.0)) ** (1.0 / 3.0)
        fields.append(G * Point(mass, (radius + 0.102, 0.0, 0.0)).field(np.zeros((1, 3)))[0, 0] / NG * 1e-9)
    assert fields[0] == pytest.approx(4.05e-10, abs=0.005e-10)
    assert fields[1] > 1e-9

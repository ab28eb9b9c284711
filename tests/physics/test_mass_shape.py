"""The bound, the body of cells that nearly reaches it, and what an inventory costs."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import integrate, optimize

from inertialcal.core.constants import REINEL_GRAVITATIONAL_CONSTANT, REINEL_GRAVITY
from inertialcal.core.errors import DataError
from inertialcal.physics.attraction.extended import ProofMass
from inertialcal.physics.mass_shape.bound import checked, largest_field
from inertialcal.physics.mass_shape.cells import (
    Gain,
    Grid,
    Pieces,
    best_cells,
    best_stack,
    change,
    growth,
    most_in_weight,
)

G = REINEL_GRAVITATIONAL_CONSTANT.value * 1e-3  # m^3/s^2/kg
NG = REINEL_GRAVITY.value * 1e-2 * 1e-9  # m/s^2
LEAD = 11340.0
REINEL = Grid(0.051, (10, 20, 20), 0.102, LEAD)
CELLS = 900
MASS = CELLS * REINEL.cell_mass  # 1353.8 kg: errata.csv, "mass used"


@pytest.mark.parametrize("keep", ["plane", "sphere"])
@pytest.mark.parametrize("volume", [1e-9, 1e-3, 0.1, 1.0, 112.0, 1e6])
def test_the_bound_is_the_body_of_all_places_above_a_level(keep: str, volume: float) -> None:
    """Integrated slice by slice, or shell by shell, at the level whose volume it is; stand-off and density one."""
    bound = largest_field(volume, 1.0, 1.0, keep)  # type: ignore[arg-type]
    c = bound.reach**-2
    log_reach = math.log(bound.reach)

    def over(what: Callable[[float], float]) -> float:
        return float(
            integrate.quad(lambda s: what(math.exp(s)) * math.exp(s), 0.0, log_reach, epsabs=0.0, epsrel=1e-10)[0]
        )

    if keep == "plane":
        disc = over(lambda x: math.pi * ((x / c) ** (2.0 / 3.0) - x * x))
        field = over(lambda x: 2.0 * math.pi * (1.0 - (c * x * x) ** (1.0 / 3.0)))
    else:
        disc = over(lambda r: 2.0 * math.pi * r * r * (1.0 - c * r * r))
        field = over(lambda r: math.pi * (1.0 - (c * r * r) ** 2))
    assert disc == pytest.approx(volume, rel=1e-6)
    assert field == pytest.approx(bound.field, rel=1e-6)


@given(st.floats(1e-6, 1e6), st.floats(1.01, 10.0))
def test_more_mass_and_less_stand_off_attract_more(volume: float, factor: float) -> None:
    here = largest_field(volume, 1.0, 1.0)
    assert largest_field(volume * factor, 1.0, 1.0).field > here.field > largest_field(volume, 1.0, factor).field
    assert here.field / here.sphere > 1.0
    assert largest_field(volume, 1.0, 1.0, "sphere").field >= here.field * (1.0 - 1e-12)  # it has all of those places


def test_a_body_that_may_touch_beats_the_sphere_by_a_fortieth() -> None:
    """(27/25)^(1/3), from the touching sphere, 4 pi R / 3."""
    bound = largest_field(4.0 * math.pi / 3.0, 1.0, 0.0)
    assert bound.field / bound.sphere == pytest.approx(1.02599, abs=5e-6)
    assert bound.sphere == pytest.approx(4.0 * math.pi / 3.0, rel=1e-14)
    assert largest_field(1e9, 1.0, 1.0).field / largest_field(1e9, 1.0, 1.0).sphere == pytest.approx(1.02599, abs=2e-3)


@pytest.mark.parametrize(
    ("shape", "count", "share"),
    [((10, 20, 20), CELLS, 0.997), ((63, 126, 126), 225_000, 0.9999)],
    ids=["900", "225,000"],
)
def test_the_best_cells_nearly_reach_the_bound(shape: tuple[int, int, int], count: int, share: float) -> None:
    """One mass, cut coarsely out of 4,000 places and finely out of a million."""
    body = best_cells(Grid(0.051 * (CELLS / count) ** (1.0 / 3.0), shape, 0.0762, LEAD), count)
    reached = Gain().of(body) / largest_field(body.mass, LEAD, 0.0762).field
    assert share <= reached <= 1.0


def test_no_other_choice_of_cells_attracts_more() -> None:
    """All of them, on a small grid."""
    grid = Grid(0.05, (2, 3, 2), 0.03, LEAD)
    worth = Gain().worth_of_cells(grid.lattice()).ravel()
    best = max(sum(worth[list(chosen)]) for chosen in itertools.combinations(range(12), 5))
    assert Gain().of(best_cells(grid, 5)) == pytest.approx(LEAD * best, rel=1e-12)


# Reinel, Table 2, d = 10.2 cm: 67.2 ng; Table 3, position 0: 74.017 ng. errata.csv: both above the bound, with these.
@pytest.mark.parametrize(
    ("stated", "stand_off", "bound", "needed"), [(67.2, 0.102, 66.25, 1396.0), (74.017, 0.0762, 73.35, 1382.0)]
)
def test_reinels_tables_exceed_what_his_mass_can_do(
    stated: float, stand_off: float, bound: float, needed: float
) -> None:
    found = checked(stated * NG, MASS, LEAD, stand_off, G)
    assert found.bound / NG == pytest.approx(bound, abs=0.06)  # 7.6 against 7.62 cm
    assert found.mass_needed == pytest.approx(needed, abs=4.0)
    assert 0.005 < found.excess < 0.016


def test_the_model_of_reinels_body() -> None:
    """errata.csv, Table 2: 66.08 ng for the 900 best cells at 10.2 cm; 75 ng needs 1425 kg, 1500 kg give 76.68 ng."""
    assert G * Gain().of(best_cells(REINEL, CELLS)) / NG == pytest.approx(66.08, abs=0.005)
    assert G * largest_field(1500.0, LEAD, 0.076).field / NG == pytest.approx(76.68, abs=0.1)
    assert checked(75.0 * NG, 1500.0, LEAD, 0.076, G).mass_needed == pytest.approx(1425.0, abs=3.0)


# Table 1: mass [kg], attraction [g], radius [cm]; errata.csv: rows 4 and 6 follow rounded, row 3 as it stands.
@pytest.mark.parametrize(("mass", "field", "radius", "stand_off", "rounding"), [
    (68.0, 1e-8, 11.25, 0.102, 0.5),
    (4700.0, 1e-7, 46.3, 0.102, 50.0),
    (1.4e24, 1.0, 3.07e8, 0.102, 0.05e24),
])  # fmt: skip
def test_reinels_table_of_spheres(mass: float, field: float, radius: float, stand_off: float, rounding: float) -> None:
    """The mass whose touching sphere has the attraction rounds to the printed one."""
    wanted = field * REINEL_GRAVITY.value * 1e-2
    exact = optimize.brentq(lambda m: G * growth(m, LEAD, stand_off).sphere[0] - wanted, mass / 2.0, mass * 2.0)
    assert exact == pytest.approx(mass, abs=rounding)
    r = (3.0 * exact / LEAD / (4.0 * math.pi)) ** (1.0 / 3.0) * 100.0
    assert r == pytest.approx(radius, rel=0.009)  # errata.csv: row 6 is 0.8 % low


@pytest.mark.parametrize(("row", "mass"), [("1", 0.15), ("2", 4.0), ("5", 1.4e6)])
def test_the_other_rows_of_that_table_do_not_follow(row: str, mass: float) -> None:
    """errata.csv: 7.49e-11 g, 1.279e-9 g, and 8 to 21 % off the mass for the fifth."""
    field = G * growth(mass, LEAD, 0.102).sphere[0] / (NG * 1e9)
    stated = {"1": 1e-10, "2": 1e-9, "5": 1e-6}[row]
    expected = {"1": 7.49e-11, "2": 1.279e-9}.get(row)
    assert abs(field / stated - 1.0) > 0.05
    if expected is not None:
        assert field == pytest.approx(expected, rel=1e-3)


def test_the_inventory_of_large_and_small_cubes_costs_a_thousandth() -> None:
    """100 cubes of 10.2 cm and 100 of 5.1 cm are as much as 900 small ones (errata.csv)."""
    grid = Grid(0.051, (10, 20, 20), 0.0762, LEAD)
    stack = best_stack(grid, (Pieces(1, 100), Pieces(2, 100)))
    assert stack.body.mass == pytest.approx(MASS)
    assert [len(p) for p in stack.places] == [100, 100]
    assert 0.0 < stack.gap < 0.002
    assert stack.gain == pytest.approx(Gain().of(stack.body))


def test_a_body_made_for_the_change_changes_more() -> None:
    grid = Grid(0.0508, (10, 20, 20), 0.0762, LEAD)
    stroke = change((0.0, 0.305, 0.0), start=(0.0, 0.127, 0.0))
    plain, made = (stroke.of(best_cells(grid, CELLS, gain)) for gain in (Gain(), stroke))
    assert made > 1.01 * plain
    assert made * G / NG / 2.0 == pytest.approx(23.9, abs=0.1)


def test_the_gain_of_a_body_is_that_of_its_cells() -> None:
    """With a proof mass, an axis askew and two positions."""
    gain = Gain((1.0, 1.0, 0.0), ((1.0, (0.0, 0.0, 0.0)), (-0.5, (0.1, 0.0, 0.0))), ProofMass(0.029, 0.0064, 0.0064))
    grid = Grid(0.05, (2, 3, 3), 0.1, LEAD)
    body = best_cells(grid, 7, gain)
    assert gain.of(body) == pytest.approx(float(np.sum(body.density * gain.worth_of_cells(grid.lattice()))), rel=1e-11)


def test_growth_grows_from_a_point_to_the_touching_ratio() -> None:
    found = growth(np.geomspace(1e-3, 1e9, 40), LEAD, 0.102)
    assert (np.diff(found.sphere) > 0.0).all()
    assert (found.best > found.sphere).all()


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Grid(0.05, (2, 2, 2), 0.0, LEAD), "the mass would overlap the instrument"),
        (lambda: Grid(0.05, (2, 2, 2), 0.1, 11.34), "density 11.34 kg/m\\^3: materials lie between"),
        (lambda: Grid(0.05, (2, 2, 2), 0.1, 1.134e7), "materials lie between"),
        (lambda: Grid(-0.05, (2, 2, 2), 0.1, LEAD), "edge of a cell -0.05 is not above zero"),
        (lambda: best_cells(REINEL, 4001), "4001 cells do not fit into a grid of 10 x 20 x 20 = 4000"),
        (lambda: best_cells(REINEL, 0), "0 cells do not fit"),
        (lambda: most_in_weight(REINEL, 1.0), "1 kg is less than one cell, 1.504"),
        (lambda: best_stack(REINEL, (Pieces(4, 33),)), "33 cubes of 4 cells do not fit: the grid has 32 free places"),
        (lambda: largest_field(-1.0, 1.0, 1.0), "mass -1 is not above zero"),
        (lambda: largest_field(1.0, 1.0, -1.0), "stand-off -1 m is below zero"),
        (lambda: Gain((0.0, 0.0, 0.0)).of(best_cells(REINEL, 1)), "has no direction"),
        (
            lambda: Grid(5.1, (2, 2, 2), 0.1, LEAD),
            "edge of a cell 5.1 m: more than 1 m .*If 5.1 cm was meant, give 0.051 m",
        ),
        (lambda: Grid(51.0, (2, 2, 2), 0.1, LEAD), "If 51 cm was meant, give 0.51 m"),
        (lambda: Grid(0.051, (2, 2, 2), 10.2, LEAD), "stand-off 10.2 m: .*If 10.2 cm was meant, give 0.102 m"),
        (lambda: Grid(0.051, (2, 2, 2), -0.1, LEAD), "the mass would overlap the instrument"),
        (lambda: Grid(0.051, (2, 2, 2), math.nan, LEAD), "stand-off nan is not finite"),
        (lambda: Grid(math.inf, (2, 2, 2), 0.1, LEAD), "edge of a cell inf is not finite"),
        (lambda: Grid(0.051, (2, 0, 2), 0.1, LEAD), "a grid of 2 x 0 x 2 cells is empty"),
        (
            lambda: best_cells(REINEL, 1, Gain(proof_mass=ProofMass(0.3, 0.02))),
            r"overlap the instrument: the place \(0.1",
        ),
        (lambda: best_cells(REINEL, 1, change((-0.2, 0.0, 0.0))), r"the place \(0.2, 0, 0\) m of its proof mass"),
        (lambda: best_stack(REINEL, (Pieces(0, 3),)), "3 cubes of 0 cells: both numbers must be one or more"),
        (lambda: best_stack(REINEL, (Pieces(1, -3),)), "-3 cubes of 1 cells"),
        (lambda: best_stack(REINEL, ()), "the inventory has no pieces"),
        (lambda: largest_field(1.0, math.inf, 1.0), "density inf is not finite"),
        (lambda: largest_field(1.0, 1.0, math.nan), "stand-off nan is not finite"),
        (lambda: checked(67.2, MASS, LEAD, 0.102, G), r"67.2 m/s\^2 is 1.03e\+08 times the most .* 1 ng, a billionth"),
        (lambda: checked(-1.0, MASS, LEAD, 0.102, G), "stated attraction -1 is not above zero"),
    ],
)
def test_what_cannot_be_built_is_refused(make: object, words: str) -> None:
    with pytest.raises(DataError, match=words):
        make()  # type: ignore[operator]


def test_the_bound_has_its_limits_at_its_ends() -> None:
    """Next to no stand-off, and next to no volume."""
    near = largest_field(1.0, 1.0, 1e-200)
    assert near.field == largest_field(1.0, 1.0, 0.0).field
    assert largest_field(1.0, 1.0, 1e-9).field == pytest.approx(near.field, rel=1e-7)
    assert largest_field(1e-200, 1.0, 2.0).field == pytest.approx(2.5e-201, rel=1e-12)
    assert largest_field(1e-14, 1.0, 1.0).field == pytest.approx(1e-14, rel=1e-6)


def test_a_weight_allows_whole_cells() -> None:
    assert most_in_weight(REINEL, MASS) == CELLS
    assert most_in_weight(REINEL, MASS - 0.01) == CELLS - 1

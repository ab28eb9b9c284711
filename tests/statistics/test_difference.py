"""Difference of two figures that share a standard, against an independent Monte Carlo."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import inertialcal as ic
from inertialcal.campaign.compare.differences import differences
from inertialcal.core.results import Curvature, Row
from inertialcal.statistics.difference import Figure, Part, difference, taken_off
from inertialcal.statistics.intervals import coverage_factor

RATES = np.array([-4.0, -2.0, 2.0, 4.0] * 2)
TABLE, NOISE = 5e-4, 2e-3  # relative standard uncertainty of the rate; scatter of a dwell [deg/s]
DRAWS, ROUNDING = 40_000, 0.02  # relative error of a standard deviation of so many draws, four times over


def unit_file(folder: Path, name: str, scale: float, rng: np.random.Generator) -> Path:
    """Write the reduced table of a unit: rate, reading, scatter, run."""
    read = scale * RATES + NOISE * rng.standard_normal(RATES.size)
    rows = [f"{rate},{value:.9f},{NOISE},{1 + i // 4}" for i, (rate, value) in enumerate(zip(RATES, read, strict=True))]
    path = folder / f"{name}.csv"
    path.write_text("\n".join(["rate [deg/s],x [deg/s],std [deg/s],run", *rows, ""]), encoding="utf-8")
    return path


def scale_error(path: Path) -> Row:
    found = ic.rate_table(path, axis="x", standards={"rate_table.rate": "0.05 %"})
    return next(row for row in found.rows if row.quantity == "scale_factor_error" and row.case.plain)


class OneTable:
    """Two results of one table."""

    def identical(self, one: Row, other: Row) -> bool:
        return False

    def shared(self, one: Row, other: Row) -> list[str]:
        return ["rate_table.rate"]

    def figures(self, one: Row, other: Row) -> tuple[Figure, Figure]:
        found = [Figure(row.value or 0.0, row.u or 0.0, row.dof or math.inf, row.shared) for row in (one, other)]
        return found[0], found[1]


def drawn_differences(rng: np.random.Generator, shared: bool) -> np.ndarray:
    """Return slopes of two units on a table whose rate is wrong, fitted by numpy alone, second less first [%]."""
    first = TABLE * rng.standard_normal((DRAWS, 1))
    second = first if shared else TABLE * rng.standard_normal((DRAWS, 1))
    slopes = [
        (((1.0 + e) * scale * RATES + NOISE * rng.standard_normal((DRAWS, RATES.size))) @ RATES) / (RATES @ RATES)
        for e, scale in ((first, 1.01), (second, 1.013))
    ]
    return np.asarray(100.0 * (slopes[1] - slopes[0]))


def test_two_units_on_one_table_differ_by_what_a_monte_carlo_gives(tmp_path: Path) -> None:
    rng = np.random.default_rng(7)
    one, other = (scale_error(unit_file(tmp_path, name, s, rng)) for name, s in (("a", 1.01), ("b", 1.013)))
    assert one.shared.keys() == {"rate_table.rate"}
    assert one.shared["rate_table.rate"] == pytest.approx(-100.0 * TABLE * 1.01, rel=2e-3)
    apart = differences([(one, other)])[0].row
    together = differences([(one, other)], OneTable())[0].row
    assert apart.u is not None
    assert together.u is not None
    # What the fit knows of its own scatter is one draw; the exact scatter of a slope takes its place.
    own = 100.0 * NOISE / math.sqrt(RATES @ RATES)
    first, second = (
        Figure(row.value or 0.0, math.hypot(own, row.shared["rate_table.rate"]), changes=row.shared)
        for row in (one, other)
    )
    assert difference(first, second).u == pytest.approx(drawn_differences(rng, shared=True).std(), rel=ROUNDING)
    assert difference(first, second, ()).u == pytest.approx(drawn_differences(rng, shared=False).std(), rel=ROUNDING)
    assert together.u < 0.9 * apart.u
    left = (other.u or 0.0) ** 2 + (one.u or 0.0) ** 2 - together.u**2
    assert left == pytest.approx(2.0 * one.shared["rate_table.rate"] * other.shared["rate_table.rate"], rel=1e-9)


def test_signs_decide_whether_a_shared_error_cancels_or_adds() -> None:
    rng = np.random.default_rng(3)
    e, own = rng.standard_normal(DRAWS), 0.3 * rng.standard_normal((2, DRAWS))
    for change in (1.0, -1.0, 0.25):
        drawn = (change * e + own[1]) - (e + own[0])
        a, b = (Figure(0.0, math.hypot(c, 0.3), changes={"standard": c}) for c in (1.0, change))
        assert difference(a, b).u == pytest.approx(drawn.std(), rel=ROUNDING)


def test_nothing_shared_is_the_sum_of_squares_with_welchs_degrees_of_freedom() -> None:
    a, b = Figure(1.0, 0.3, 4.0, {"one": 0.2}), Figure(2.0, 0.4, 9.0, {"other": 0.1})
    found = difference(a, b)
    assert found.value == 1.0
    assert found.u == pytest.approx(0.5)
    welch = 0.5**4 / (0.3**4 / 4.0 + 0.4**4 / 9.0)
    assert found.dof == pytest.approx(welch)
    few = Figure(1.0, 0.3, 2.0)
    assert 2.0 < difference(few, b).dof < 0.5**4 / (0.3**4 / 2.0 + 0.4**4 / 9.0)
    assert difference(b, a).value == -1.0


def test_a_figure_less_itself_has_twice_its_own_variance_alone() -> None:
    one = Figure(1.0, 0.5, changes={"table": 0.4, "mass": -0.3})
    assert difference(one, one).u == pytest.approx(0.0, abs=1e-7)
    assert difference(one, one, ["table"]).u == pytest.approx(math.sqrt(2.0) * 0.3)


def test_what_is_left_has_the_degrees_of_freedom_of_its_scatter() -> None:
    """A large shared part hid that the scatter has 4 degrees of freedom; once it is gone they count."""
    scatter, table = 0.1, 1.0
    u = math.hypot(scatter, table)
    one = Figure(0.0, u, 1e5, {"table": table}, (Part("", scatter / u, 4.0),))
    assert difference(one, one).u == pytest.approx(math.sqrt(2.0) * scatter)
    assert difference(one, one).dof == pytest.approx(8.0)
    assert difference(one, one, ()).dof > 1e3
    assert taken_off(one, {"table": 2.0}).dof == pytest.approx(4.0, rel=1e-6)


def test_an_interval_of_what_is_left_holds() -> None:
    """Two runs of 5 on one table whose error is ten times their scatter: the interval of the difference holds 95 %."""
    rng = np.random.default_rng(11)
    hits, n = 0, 2000
    for e in rng.standard_normal(n):
        sides = []
        for _ in range(2):
            runs = 0.1 * rng.standard_normal(5) + e
            own = float(runs.std(ddof=1)) / math.sqrt(5.0)
            u = math.hypot(own, 1.0)
            sides.append(Figure(float(runs.mean()), u, 1e6, {"table": 1.0}, (Part("", own / u, 4.0),)))
        found = difference(sides[0], sides[1])
        hits += abs(found.value) <= coverage_factor(found.dof) * found.u
    assert 0.94 < hits / n < 0.985


def test_errors_that_are_known_are_taken_off_with_their_uncertainty() -> None:
    left = taken_off(Figure(1.0, 0.5, changes={"table": 0.4, "mass": -0.3}), {"table": 2.0})
    assert left.value == pytest.approx(0.2)
    assert left.u == pytest.approx(0.3)
    assert left.changes == {"mass": -0.3}


def bent_slopes(rng: np.random.Generator, rates: np.ndarray, k3: np.ndarray) -> np.ndarray:
    """Slopes of lines without a third-order term through readings that have one."""
    readings = rates + k3 * rates**3 + NOISE * rng.standard_normal((DRAWS, rates.size))
    return np.asarray(readings @ rates / (rates @ rates))


@pytest.mark.parametrize(("rates", "sizes"), [(RATES, (3e-4, 0.0)), (RATES, (0.0, 3e-4)), (0.7 * RATES, (3e-4, 0.0))])
def test_a_curvature_of_the_unit_cancels_as_far_as_the_rates_are_the_same(
    rates: np.ndarray, sizes: tuple[float, float]
) -> None:
    """Third-order terms drawn anew for each unit: two tests of it, of which one alone hints at a term."""
    rng = np.random.default_rng(5)
    k3 = 3e-4 * rng.standard_normal((DRAWS, 1))
    spread = np.std(bent_slopes(rng, rates, k3) - bent_slopes(rng, RATES, k3))
    both = []
    for one, size in zip((RATES, rates), sizes, strict=True):
        term = Curvature(float(one @ one**3 / (one @ one)), size)
        u = math.hypot(NOISE / np.linalg.norm(one), term.share)
        both.append(Figure(1.0, u, curvature={"third_order_x": term}))
    assert difference(both[0], both[1]).u == pytest.approx(spread, rel=ROUNDING)
    assert difference(both[0], both[1], shared=()).u == pytest.approx(math.hypot(both[0].u, both[1].u))


def test_a_curvature_that_one_line_has_counts_in_full_in_the_difference() -> None:
    """The slope at zero rate less the slope of the straight line: apart by what the term changes of the latter."""
    straight = Figure(1.0, 1e-4, curvature={"third_order_x": Curvature(5.0, 0.0)})
    bent = Figure(1.0, 3e-4, curvature={"third_order_x": Curvature(0.0, 2e-4)})
    assert difference(straight, bent).u == pytest.approx(math.sqrt(1e-4**2 + 3e-4**2 + 1e-3**2))

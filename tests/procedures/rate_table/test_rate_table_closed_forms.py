"""Rate table: scatters, and uncertainties of errors and deviations, against samples and closed forms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from inertialcal.procedures.rate_table.fit.linearity import largest_deviation
from inertialcal.procedures.rate_table.fit.rate_error import rate_errors
from inertialcal.procedures.rate_table.fit.regression import Level, Line, line
from inertialcal.procedures.rate_table.plan import Plan
from inertialcal.procedures.rate_table.readings import Readings


def of_x(applied: np.ndarray, reading: np.ndarray) -> Readings:
    """Dwells about x, read by the x sensor."""
    return Readings(applied, np.full(len(applied), "x"), {"x": reading}, sensors=("x", "y", "z"))


def level(one: Line, name: str) -> Level:
    return next(found for found in one.levels if found.name == name)


def test_the_scatter_of_samples_is_their_square_about_the_mean_of_their_own_dwell() -> None:
    """Dwells of different lengths: each spends one degree of freedom on its mean, and a long one counts for more."""
    rng = np.random.default_rng(1)
    applied = np.array([-2.0, -1.0, 1.0, 2.0])
    dwells = [rate + rng.normal(0.0, 1e-3, n) for rate, n in zip(applied, (2, 3, 5, 40), strict=True)]
    readings = replace(
        of_x(applied, np.array([dwell.mean() for dwell in dwells])),
        scatters={"x": np.array([dwell.std(ddof=1) for dwell in dwells])},
        samples=np.array([float(len(dwell)) for dwell in dwells]),
    )
    found = level(line(Plan(), readings, "x", asymmetry=False), "sample")
    dof = 50 - 4
    assert found.dof == dof
    assert found.std == pytest.approx(np.sqrt(sum(np.sum((one - one.mean()) ** 2) for one in dwells) / dof), rel=1e-12)


@pytest.mark.parametrize("asymmetry", [False, True])
def test_the_scatter_of_runs_is_that_of_their_offsets(asymmetry: bool) -> None:
    """Every run has the same rates and nothing but its offset: one degree of freedom fewer than there are runs."""
    offsets = np.array([3e-3, -1e-3, 4e-3, -2e-3])
    rates = np.array([-3.0, -1.0, 0.0, 1.0, 2.0])
    applied, offset = np.tile(rates, len(offsets)), np.repeat(offsets, len(rates))
    run = np.repeat(["a", "b", "c", "d"], len(rates))
    one = line(Plan(), replace(of_x(applied, 1.01 * applied + offset), run=run), "x", asymmetry)
    found = level(one, "run")
    assert found.dof == len(offsets) - 1
    assert found.std == pytest.approx(np.std(offsets, ddof=1), rel=1e-9)
    assert level(one, "dwell").std == pytest.approx(0.0, abs=1e-12)


def test_an_unknown_earth_rate_is_as_uncertain_as_the_error_moves_with_it() -> None:
    """Moved by one standard uncertainty, an error moves by that over its rate; what cancels in the mean is nothing."""
    applied = np.array([-4.0, -4.0, -0.5, -0.5, 0.5, 0.5, 4.0, 4.0])
    noise = 1e-5 * np.array([1.0, -2.0, 3.0, 1.0, -1.0, 2.0, -3.0, -1.0])
    alike, opposed = np.zeros((2, 8, 3))
    alike[:, 0] = 4e-5 * np.array([1.0, 1.0, -1.0, -1.0, 2.0, 2.0, 3.0, 3.0])
    opposed[:, 0] = 7e-5 * np.tile([1.0, -1.0], 4)
    opposed[:, 1] = 9e-5  # across the sensor's axis
    known = replace(of_x(applied, 1.001 * applied + noise), earth=np.zeros((8, 3)))
    unknown = replace(known, earth_sources={"both": np.stack([alike, opposed])})
    moved = [replace(known, earth=pattern) for pattern in (alike, opposed)]
    fitted = line(Plan(), known, "x", asymmetry=False)
    before, after, *others = (
        rate_errors(Plan(), readings, replace(fitted, readings=readings), "expected")
        for readings in (known, unknown, *moved)
    )
    for k, (one, two) in enumerate(zip(before, after, strict=True)):
        assert one.u is not None
        assert two.u is not None
        assert one.error is not None
        moves = [float(other[k].error or 0.0) - one.error for other in others]
        assert abs(moves[0]) > one.u / 2.0
        assert moves[1] == pytest.approx(0.0, abs=1e-12)
        assert two.u == pytest.approx(np.hypot(one.u, moves[0]), rel=1e-9)


@pytest.mark.parametrize("bent", [0, 2, 4, 8])
def test_the_deviation_at_a_rate_lacks_what_the_line_has_taken_up(bent: int) -> None:
    """Residuals are (1 - H) y: their mean over the dwells of a rate has the variance of a projection."""
    rates, dwells = np.array([-4.0, -3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0, 4.5]), 3
    applied = np.repeat(rates, dwells)
    reading = 0.99 * applied + 1e-3 * np.tile([1.0, -3.0, 2.0], len(rates))
    here = applied == rates[bent]
    reading[here] += 1e-2
    found = largest_deviation(line(Plan(), of_x(applied, reading), "x", asymmetry=False))
    assert found is not None
    design = np.column_stack([np.ones_like(applied), applied])
    left = np.eye(len(applied)) - design @ np.linalg.inv(design.T @ design) @ design.T
    mean, residual = here / dwells, left @ reading
    variance = residual @ residual / (len(applied) - 2)
    assert found.rate == rates[bent]
    assert found.size == pytest.approx(abs(mean @ residual), rel=1e-9)
    assert found.dof == len(applied) - 2
    assert found.u == pytest.approx(np.sqrt(variance * (mean @ left @ mean)), rel=1e-9)

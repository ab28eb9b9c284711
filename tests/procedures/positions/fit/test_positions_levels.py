"""Sources of a fit with two levels: degrees of freedom of what is judged, and what may be hidden where nothing is."""

from __future__ import annotations

import numpy as np
import pytest

from inertialcal.core.estimate import joined_dof
from inertialcal.core.influence import Influence
from inertialcal.procedures.positions.fit.linear_sensor import HIDDEN, Source, level_sources, summed
from inertialcal.statistics.intervals import coverage_factor, covers
from inertialcal.statistics.two_levels import fit_two_levels

STATED = {"pose": Influence(1.0, "rad")}
ONE = np.eye(1)


def joined(sources: list[Source]) -> tuple[float, float]:
    """Variance and degrees of freedom of the first number."""
    parts = [(one.covariance[:1, 0], np.broadcast_to(one.dof, len(one.covariance))[:1]) for one in sources]
    variances, dofs = [variance for variance, _ in parts], [dof for _, dof in parts]
    return float(np.sum(variances, axis=0)[0]), float(joined_dof(variances, dofs)[0])


@pytest.mark.parametrize("scatter", [0.3, 1.5])
def test_readings_alike_have_the_mean_square_with_its_degrees_of_freedom(scatter: float) -> None:
    """Whether a scatter is seen beyond the noise or none is: the variance of a mean of equal readings is s^2 / n."""
    y = scatter * np.array([1.0, -1.0, 0.5, -0.5, 0.0, 0.0])
    fit = fit_two_levels(np.ones((6, 1)), y, {"noise": np.full(6, 0.2)})
    share = fit.chi_square / fit.free if fit.between == 0.0 else 1.0
    assert (fit.between == 0.0) is (scatter == 0.3)
    variance, dof = joined(level_sources(fit, ONE, {}, "between", share))
    assert variance == pytest.approx(y.var(ddof=1) / 6.0, rel=1e-4)
    assert dof == pytest.approx(5.0, rel=1e-3)


def test_two_parts_judged_together_have_the_degrees_of_freedom_of_both() -> None:
    """Two readings left over: t is 4.3; by parts of one degree of freedom each it was above 12."""
    y = np.array([1.0, -1.0, 0.5])
    fit = fit_two_levels(np.ones((3, 1)), y, {"noise": np.full(3, 0.5)})
    assert joined(level_sources(fit, ONE, {}, "between"))[1] == pytest.approx(2.0, rel=1e-3)


def test_what_is_stated_is_not_judged() -> None:
    fit = fit_two_levels(
        np.ones((4, 1)), np.array([0.1, -0.1, 0.2, -0.2]), {"pose": np.ones(4), "noise": np.full(4, 1e-4)}
    )
    found = {one.name: one for one in level_sources(fit, ONE, STATED, "between")}
    assert set(found) == {"pose", "noise"}
    assert (found["pose"].kind, found["noise"].kind) == ("B", "A")
    assert np.isinf(found["pose"].dof)
    assert joined(list(found.values()))[1] > 1e6
    assert found["pose"].covariance[0, 0] == pytest.approx(0.25)


def test_a_number_that_one_reading_at_each_place_decides_carries_what_may_be_hidden() -> None:
    x = np.array([-1.0, 1.0, 0.0, 0.0, 0.0, 0.0])
    design = np.column_stack([np.ones(6), x, np.abs(x) < 0.5])
    known = {"noise": np.full(6, 1e-6), "pose": np.array([0.0, 0.0, 1.0, 1.0, 1.0, 1.0])}
    fit = fit_two_levels(design, np.array([0.0, 2.0, 0.5, -0.9, 1.4, 0.2]), known)
    (found,) = (one for one in level_sources(fit, np.eye(3), STATED, "between") if one.level == HIDDEN)
    hidden = np.diag(found.covariance)
    assert hidden[:2] == pytest.approx(0.5 * np.sqrt(2.0 / 3.0), rel=0.01)  # of a variance of one with 3 dof
    assert hidden[2] == 0.0


def test_covers_with_two_degrees_of_freedom() -> None:
    """Six readings, four unknowns, noise and scatter of one size: an exact t interval, seen or not."""
    rng, n, hits = np.random.default_rng(4), 2000, 0
    design = np.column_stack([np.ones(6), np.repeat(np.eye(3), 2, axis=0) * np.tile([1.0, -1.0], 3)[:, None]])
    for y in rng.normal(0.0, np.sqrt(2.0), (n, 6)):
        fit = fit_two_levels(design, y, {"noise": np.ones(6)})
        share = fit.chi_square / fit.free if fit.between == 0.0 else 1.0
        variance, dof = joined(level_sources(fit, np.eye(4)[:1], {}, "between", share))
        value = float(fit.coefficients[0])
        hits += abs(value) <= coverage_factor(dof) * np.sqrt(variance)
    assert covers(hits, n)


def test_sources_of_one_name_add_with_their_degrees_of_freedom() -> None:
    a = Source("scatter", "A", np.diag([4.0, 0.0]), np.array([2.0, 5.0]))
    b = Source("scatter", "A", np.diag([2.0, 0.0]), np.array([4.0, 5.0]))
    other = Source("pose", "B", np.eye(2))
    first, second = summed([[a, other], [b]])
    assert (first.name, second.name) == ("scatter", "pose")
    assert first.covariance[0, 0] == 6.0
    assert np.asarray(first.dof)[0] == pytest.approx(float(joined_dof([np.array(4.0), np.array(2.0)], [2.0, 4.0])))
    assert np.isinf(np.asarray(first.dof)[1])

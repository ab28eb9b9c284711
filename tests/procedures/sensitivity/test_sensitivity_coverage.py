"""Do 95 % intervals of sensitivities hold the truth? Simulated by code that shares nothing with the estimator."""

from __future__ import annotations

import pytest
from sensitivity_cases import SUPPLY, covered

from independent import climate
from independent.climate import Unit, Visits
from inertialcal.procedures.sensitivity.plan import Plan
from inertialcal.statistics.intervals import covers
from sized import sized

WALK = Unit(walk=2e-5, scatter=0.02, slope_scatter=1e-5)
SEVERAL = Plan(to=["supply", "temperature"])


def check(found: dict[str, tuple[int, int]]) -> None:
    assert found
    for name, (count, n) in found.items():
        assert covers(count, n), f"{name}: {count} of {n}"


def test_intervals_hold_in_a_few_power_ups_with_walk_and_scatter() -> None:
    visits = Visits(runs=5, dwell=100.0, axes="x")
    check(covered([climate.supplied(seed, WALK, visits) for seed in range(1, 13)]))


@pytest.mark.slow
@pytest.mark.parametrize("runs", [2, 3, 5])
def test_intervals_hold_whatever_the_number_of_power_ups(runs: int) -> None:
    check(covered([climate.supplied(seed, WALK, Visits(runs=runs)) for seed in range(1, sized(60, 25) + 1)]))


@pytest.mark.slow
def test_intervals_of_the_scale_factor_hold() -> None:
    unit = Unit(scale_scatter=1e-4, walk=2e-5)
    check(covered([climate.on_table(seed, unit) for seed in range(1, sized(60, 25) + 1)], SEVERAL))


@pytest.mark.slow
def test_limits_hold_where_nothing_is_there() -> None:
    unit = Unit(supply=0.0, supply_temperature=0.0, walk=2e-5)
    check(covered([climate.supplied(seed, unit) for seed in range(1, sized(60, 25) + 1)], SUPPLY))

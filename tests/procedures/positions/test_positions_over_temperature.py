"""Accelerometers over temperature against a simulator that shares no code: coverage, and ways in which it breaks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from independent.warm.warm_positions import REFERENCE, Bench, G, laid
from inertialcal.core.errors import DataError
from inertialcal.core.influence import Influence
from inertialcal.procedures.positions.reduction import Plan, Readings, Result, Triad, reduce
from inertialcal.statistics.intervals import covers
from sized import sized

STANDARDS = {
    "gravity.value": Influence(3e-4, "m/s^2", standard="gravity", quantity="value"),
    "fixture.mounting": Influence(1e-3, "rad", standard="fixture", quantity="mounting"),
    "fixture.orientation": Influence(1e-3, "rad", standard="fixture", quantity="orientation"),
    "thermometer.temperature": Influence(0.5, "degC", standard="thermometer", quantity="temperature"),
}
BENCH = Bench(u_offset=0.5)


def plan(order: int = 1, known: bool = True) -> Plan:
    standards = {name: one for name, one in STANDARDS.items() if known or name != "thermometer.temperature"}
    return Plan(gravity=G, temperature_order=order, reference_temperature=REFERENCE, standards=standards)


def laid_readings(bench: Bench, seed: int, counts: float = 0.0) -> tuple[Readings, dict[str, float]]:
    """Return the readings of a bench, in m/s^2 or as so many counts per m/s^2, and the truth."""
    made = laid(bench, seed)
    scatter = np.full(made.mean.shape, bench.noise)
    size, unit = (counts, "count") if counts else (1.0, "m/s^2")
    acc = Triad(size * made.mean, size * scatter, np.ones(made.mean.shape), unit)
    readings = Readings(acc, direction=made.direction, temperature=made.temperature, recordings=made.recording)
    return readings, made.truth


def result(bench: Bench, seed: int, order: int = 1, known: bool = True) -> tuple[Result, dict[str, float]]:
    readings, truth = laid_readings(bench, seed)
    return reduce(plan(order, known), readings), truth


def hits(bench: Bench, seeds: range, known: bool = True) -> dict[str, int]:
    """Return by name how often intervals held the truth."""
    found: dict[str, int] = {}
    for seed in seeds:
        reduced, truth = result(bench, seed, known=known)
        for row in reduced.rows():
            name = str(row.key._replace(sensor=""))
            if name in truth and row.case.plain and row.interval is not None:
                lo, hi = row.interval.lo, row.interval.hi
                inside = lo is not None and hi is not None and lo <= truth[name] <= hi
                found[name] = found.get(name, 0) + inside
    return found


SMALL = replace(BENCH, temperatures=(-20.0, 20.0, 60.0, 40.0, 0.0, 50.0), rounds=1)
SLOW = sized(200, 25)  # campaigns
FAR = 8.0  # standard uncertainties, of four degrees of freedom: once in 1,000 of a figure


def test_matrix_and_bias_are_told_over_temperature() -> None:
    reduced, truth = result(SMALL, 1)
    found = {str(row.key._replace(sensor="")): row for row in reduced.rows() if row.case.plain}
    assert set(truth) <= set(found)
    for name, value in truth.items():
        row = found[name]
        assert row.value is not None
        assert abs(row.value - value) < FAR * float(row.u or 0.0), name
    model = reduced.models["accelerometer"]
    assert np.shape(model.matrix) == (2, 3, 3)
    assert np.allclose(model.temperature_range or (), (-20.0, 60.0), atol=2.0)
    assert model.estimate is not None
    names = {str(key) for key in model.estimate.keys}
    assert {"scale_factor_error_temperature_1_x", "bias_temperature_1_z"} <= names


def test_without_an_order_the_temperature_is_left_aside() -> None:
    reduced, _ = result(replace(SMALL, temperatures=(20.0, 20.0)), 1, order=0)
    assert not [row for row in reduced.rows() if "temperature" in row.quantity]


def test_a_thermometer_that_nobody_states_is_named() -> None:
    reduced, _ = result(SMALL, 2, known=False)
    row = next(row for row in reduced.rows() if row.quantity == "bias_temperature_1")
    assert row.reason.code == "relative"


@pytest.mark.parametrize("stated", [True, False])
def test_scale_factors_in_counts_change_against_a_stated_one_or_none(stated: bool) -> None:
    """Counts of 1,670.7 per m/s^2: the two digits that the fit refers to, 1,700, would make each slope 1.7 % small."""
    readings, truth = laid_readings(SMALL, 1, counts=1670.7)
    own = replace(plan(), acc_scale_factor=dict.fromkeys("xyz", 1670.7)) if stated else plan()
    names = {"scale_factor_error", "scale_factor_error_temperature_1", "cross_axis_sensitivity_temperature_1"}
    rows = [one for one in reduce(own, readings).rows() if one.quantity in names]
    assert {one.quantity for one in rows} == names
    for row in rows:
        if stated:
            true = truth[str(row.key._replace(sensor=""))]
            assert row.value is not None
            assert abs(row.value - true) < FAR * float(row.u or 0.0), row
        else:
            assert (row.value, row.reason.code) == (None, "no_nominal")


def test_a_unit_that_has_not_settled_is_remarked() -> None:
    reduced, _ = result(replace(SMALL, drift=15.0), 1)
    assert "temperature_not_steady" in {one.code for one in reduced.remarks}


def test_a_bias_that_bends_is_remarked() -> None:
    wide = replace(SMALL, temperatures=(-20.0, 0.0, 20.0, 40.0, 60.0, 30.0, -10.0))
    assert "temperature_order_low" not in {one.code for one in result(wide, 1)[0].remarks}
    bent = result(replace(wide, curve=2e-5), 1)[0]
    remark = next(one for one in bent.remarks if one.code == "temperature_order_low")
    assert "bias_x" in remark.what


@pytest.mark.parametrize(
    ("bench", "order", "code"),
    [
        (replace(SMALL, temperatures=(20.0, 20.0, 20.0, 20.0)), 1, "too_few_temperatures"),
        (replace(SMALL, temperatures=(0.0, 40.0)), 1, "too_few_temperatures"),
        (SMALL, 0, ""),
    ],
)
def test_too_few_temperatures_are_refused(bench: Bench, order: int, code: str) -> None:
    if not code:
        assert result(bench, 1, order)[0].estimates
        return
    with pytest.raises(DataError) as refused:
        result(bench, 1, order)
    assert refused.value.problems[0].code == code


def test_a_recording_without_all_positions_is_refused() -> None:
    made = laid(SMALL, 1)
    kept = ~((np.array(made.recording) == 1) & (made.direction[:, 2] != 0.0))
    acc = Triad(made.mean[kept], np.full((int(kept.sum()), 3), 2e-4), np.ones((int(kept.sum()), 3)), "m/s^2")
    numbers = tuple(np.array(made.recording)[kept].tolist())
    readings = Readings(acc, direction=made.direction[kept], temperature=made.temperature[kept], recordings=numbers)
    with pytest.raises(DataError) as refused:
        reduce(plan(), readings)
    assert refused.value.problems[0].code == "recording_incomplete"
    with pytest.raises(DataError) as refused:
        reduce(plan(), replace(readings, temperature=None))
    assert refused.value.problems[0].code == "no_temperature"


@pytest.mark.slow
@pytest.mark.parametrize(
    "bench",
    [
        pytest.param(BENCH, id="as assumed"),
        pytest.param(replace(BENCH, remounted=True), id="mounted anew at each temperature"),
        pytest.param(replace(BENCH, lag=1.0), id="thermometer ahead of the sensors"),
    ],
)
def test_intervals_hold_the_truth(bench: Bench) -> None:
    for name, count in hits(bench, range(1, SLOW + 1)).items():
        assert covers(count, SLOW), (name, count)

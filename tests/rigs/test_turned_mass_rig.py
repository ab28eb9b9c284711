"""The turned-mass rig: what it counts is what the truth says, and each mistake is named by the reduction."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fitted_results import fit_results
from independent.orbit.turned_mass import Bench as Other
from independent.orbit.turned_mass import felt as other_felt
from inertialcal.campaign.engine.run import run
from inertialcal.campaign.twins.score import coverage
from inertialcal.campaign.twins.twin import simulate
from inertialcal.core.errors import InertialcalError
from inertialcal.core.show.rows import case_name
from inertialcal.rigs.turned_mass import rig as turned
from inertialcal.rigs.turned_mass.record import Drawn, felt
from inertialcal.rigs.turned_mass.rig import Bench, build
from inertialcal.rigs.turned_mass.setup import UG
from inertialcal.statistics.intervals import covers
from sized import sized


def found(fault: str, seed: int) -> set[str]:
    """Codes of the remarks, or of the refusal."""
    try:
        (result,) = fit_results(turned.RIG.twin(seed, fault))
    except InertialcalError as error:
        return {problem.code for problem in error.problems}
    return {one.code for one in result.remarks}


QUICK = ("wrong_sense", "one_speed", "wrong_mass", "wrong_units", "wrong_gate", "at_the_orbit")


@pytest.mark.parametrize(
    "fault", [pytest.param(one, marks=[] if one in QUICK else [pytest.mark.slow]) for one in turned.FAULTS]
)
def test_every_mistake_is_named(fault: str) -> None:
    assert turned.FAULTS[fault].shows in found(fault, 3)


def test_without_a_mistake_nothing_is_wrong() -> None:
    assert not found("", 3) & {fault.shows for fault in turned.FAULTS.values()}


def test_another_simulator_feels_the_same() -> None:
    """By the equations of Hill here, in an inertial frame there."""
    other = Other(offset=complex(3e-3, -2e-3), height=1e-3, zero=0.1, direction=0.05)
    drawn = Drawn(1.0, other.mass, other.radius, other.satellite, other.orbit, (3e-3, -2e-3, 1e-3), 0.1, 0.05)
    bench = Bench(periods=(-1.25,))
    seconds = np.linspace(0.0, 9000.0, 50)
    phi = 0.1 - 2.0 * np.pi / 4500.0 * seconds
    assert felt(bench, drawn, 0, seconds) == pytest.approx(other_felt(other, -4500.0, phi), abs=1e-14)


def test_pulses_are_whole_and_the_level_is_bias_and_gradient() -> None:
    twin = build(replace(Bench(), white=0.0, walk=0.0, cubic=0.0, lost=0.0, lines=()), 2)
    pulses = twin.recordings["recordings/run1.csv"].channel("pulses").data
    assert pulses.dtype == np.int64
    level = 17.0 * UG + 3.0 * (2.0 * np.pi / 5742.56) ** 2
    assert np.mean(pulses) / 100.0 == pytest.approx(twin.truth[0].value * level, rel=1e-4)


def test_the_same_seed_gives_the_same_record() -> None:
    one, other = (turned.RIG.twin(5).recordings["recordings/run2.csv"].channel("pulses").data for _ in range(2))
    assert np.array_equal(one, other)
    assert not np.array_equal(one, turned.RIG.twin(6).recordings["recordings/run2.csv"].channel("pulses").data)


def test_files_give_the_figures_of_what_is_in_memory(tmp_path: Path) -> None:
    folder = simulate("turned_mass", tmp_path / "turned", 4).folder
    (result,) = fit_results(turned.RIG.twin(4))
    (own,) = [row for row in result.rows() if (row.quantity, str(row.case)) == ("scale_factor", "")]
    (shown,) = [
        row for row in run(folder, write=False).results["results"]
        if (row["quantity"], case_name(row)) == ("scale_factor", "")
    ]  # fmt: skip
    assert shown["unit"] == "count/s/ug"
    assert shown["value"] == pytest.approx((own.value or 0.0) * UG, rel=1e-9)
    assert shown["u"] == pytest.approx((own.u or 0.0) * UG, rel=1e-9)


@pytest.mark.slow
def test_the_intervals_hold_the_truth() -> None:
    n = sized(1000, 100)
    for one in coverage(turned.RIG.twin, n):
        assert covers(one.hits, one.n), one
        assert one.missing == 0

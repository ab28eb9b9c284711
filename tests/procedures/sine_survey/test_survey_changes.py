"""An item that changes between two sweeps of a record, or within one; the same item, swept twice, does not.

The truth is a chain of masses in state space (``independent.shaking.masses``), which shares nothing with the fit.
"""

from __future__ import annotations

import numpy as np
import pytest

from independent.shaking.masses import FINE, Item, oscillators, read, sampled, swept
from inertialcal.procedures.sine_survey.plan import Plan
from inertialcal.procedures.sine_survey.readings import Readings, Shaken
from inertialcal.procedures.sine_survey.reduction import Result, reduce
from inertialcal.report.figures.sine_survey.transmissibility import finding
from inertialcal.statistics.intervals import covers
from sized import sized

RATE, SPEED = 2000.0, 30.0
UP, DOWN = (50.0, 450.0), (450.0, 50.0)


def item(frequency: float = 120.0, q: float = 25.0, second: float = 0.1) -> Item:
    """An item of two modes; ``second``: mass of the second."""
    return oscillators([frequency, 300.0], [q, 30.0], [1.0, second])


def surveyed(control: np.ndarray, response: np.ndarray, modes: int = 12) -> Result:
    """Return what one record gives."""
    shaken = Shaken("s", "s.csv", RATE, {"control": control}, {"x": response}, "m/s^2")
    return reduce(Plan(modes=modes), Readings((shaken,)))


def swept_twice(before: Item, after: Item, seed: int, ways: tuple[tuple[float, float], ...] = (UP, DOWN),
                noise: float = 0.002, colour: str = "white") -> Result:  # fmt: skip
    """Return the survey of a record of two sweeps, the item another one from the second on."""
    rng = np.random.default_rng(seed)
    tables = [swept(*way, SPEED, RATE, rng) for way in ways]
    table = np.concatenate(tables)
    response = read(before, table, RATE, (len(tables[0]), after))
    return surveyed(sampled(table, noise, rng, colour), sampled(response, noise, rng, colour))


def codes(result: Result) -> set[str]:
    """Codes of remarks."""
    return {one.code for one in result.remarks}


def figures(result: Result, label: str | None = None) -> dict[float, tuple[float, float]]:
    """Frequency of each mode, and its uncertainty, by number; of one sweep, or of all."""
    return {
        row.key.at.value: (row.value, row.u)
        for row in result.rows()
        if row.quantity == "resonance_frequency" and row.value is not None and row.u is not None
        and row.key.at is not None and (None if row.member is None else row.member.label) == label
    }  # fmt: skip


@pytest.mark.parametrize(("ways", "labels"), [((UP, DOWN), ("s, up", "s, down")), ((UP, UP), ("s, up 1", "s, up 2"))])
def test_an_item_that_changed_between_two_sweeps_is_told_by_each(
    ways: tuple[tuple[float, float], ...], labels: tuple[str, str]
) -> None:
    before, after = item(), item(114.0)
    found = swept_twice(before, after, 1, ways)
    assert "sweeps_differ" in codes(found)
    truths = [one.modes()[0, 0] for one in (before, after)]
    for label, truth in zip(labels, truths, strict=True):
        value, u = figures(found, label)[1.0]
        assert abs(value - truth) < 4.0 * u + 1e-4 * truth
    value, u = figures(found)[1.0]
    assert value == pytest.approx(np.mean(truths), rel=1e-4)
    assert u == pytest.approx(0.5 * abs(truths[1] - truths[0]), rel=0.01)  # of a mean of two
    (remark,) = [one for one in found.remarks if one.code == "sweeps_differ"]
    for truth in truths:
        assert f"{truth:.2f}" in remark.what


def test_the_picture_of_sweeps_that_differ_names_the_one_that_it_shows() -> None:
    found = swept_twice(item(), item(114.0), 1)
    rows = [{**row.to_dict(), "test": "s"} for row in found.rows()]
    assert finding({"results": rows}, "s", "x") == "x: the sweeps differ; s, up: 113.6, 317 Hz"
    same = [{**row.to_dict(), "test": "s"} for row in swept_twice(item(), item(), 1).rows()]
    assert finding({"results": same}, "s", "x") == "x: 2 resonances, at 113.6, 317 Hz"


def test_a_change_of_q_alone_is_told_and_the_frequency_keeps_its_uncertainty() -> None:
    found = swept_twice(item(), item(q=20.0), 1)
    assert "sweeps_differ" in codes(found)
    assert figures(found)[1.0][1] < 0.01
    assert any("Q 26.7" in one.what and "Q 21.4" in one.what for one in found.remarks)


def test_a_mode_that_is_gone_in_the_second_sweep_is_not_estimated() -> None:
    found = swept_twice(item(), item(second=1e-4), 1)
    reasons = [row.reason for row in found.rows() if row.reason.code == "sweeps_differ"]
    assert len(reasons) == 3  # frequency, Q, transmissibility
    assert "317" in reasons[0].text


@pytest.mark.parametrize("colour", ["white", pytest.param("pink", marks=pytest.mark.slow)])
def test_an_item_that_did_not_change_is_not_said_to(colour: str) -> None:
    seeds, silent = sized(300, 5), 0
    for seed in range(1, seeds + 1):
        rng = np.random.default_rng([seed, 1])
        same = oscillators([rng.uniform(90.0, 140.0), rng.uniform(260.0, 340.0)], [*rng.uniform(10.0, 60.0, 2)],
                           [1.0, 10.0 ** rng.uniform(-3.0, -0.7)])  # fmt: skip
        found = swept_twice(same, same, seed, noise=10.0 ** rng.uniform(-3.3, -2.3), colour=colour)
        silent += not codes(found)
    assert covers(silent, seeds, 0.99)


def test_a_joint_that_loosens_while_the_drive_passes_it_is_named() -> None:
    rng = np.random.default_rng(1)
    before, after = item(), item(116.4, 24.0)
    table = swept(*UP, 20.0, RATE, rng)
    passed = 0.5 + 60.0 / 20.0 * np.log2(before.modes()[0, 0] * 0.99 / 50.0)
    response = read(before, table, RATE, (int(passed * RATE) * FINE, after))
    found = surveyed(sampled(table, 0.002, rng), sampled(response, 0.002, rng), modes=2)
    (remark,) = [one for one in found.remarks if one.code == "changed_in_sweep"]
    assert "near 11" in remark.what
    assert "loose" in remark.do


@pytest.mark.parametrize("level", [0.02, 0.3])
def test_hum_is_no_change_of_the_item(level: float) -> None:
    rng = np.random.default_rng(1)
    table = swept(*UP, SPEED, RATE, rng)
    response = sampled(read(item(), table, RATE), 0.002, rng)
    loudest = level * float(np.abs(response).max())
    hum = loudest * np.sin(2.0 * np.pi * 99.98 * np.arange(len(response)) / RATE + 0.4)
    assert "changed_in_sweep" not in codes(surveyed(sampled(table, 0.002, rng), response + hum))

"""Sensitivities: recordings show what the truth says, each mistake is named, and intervals hold the truth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from fitted_results import fit_results
from inertialcal.campaign.twins.score import coverage
from inertialcal.core.errors import DataError
from inertialcal.rigs.climate.recordings import names_of, visits
from inertialcal.rigs.climate.rig import FAULTS, build
from inertialcal.rigs.climate.setup import Bench
from inertialcal.rigs.twin import Twin
from inertialcal.statistics.intervals import covers
from sized import sized

SUPPLY = Bench(parts=("supply",), conditions=("air",), runs=3, held_out=0, dwell=120.0)


def found(twin: Twin) -> set[str]:
    """Codes of the remarks and reasons, or of the refusal."""
    try:
        results = fit_results(twin)
    except DataError as error:
        return {problem.code for problem in error.problems}
    return {code for result in results for code in
            ({one.code for one in result.remarks} | {row.reason.code for row in result.rows()})}  # fmt: skip


@pytest.mark.parametrize("fault", FAULTS)
def test_every_mistake_is_named(fault: str) -> None:
    bench = replace(SUPPLY, conditions=("air", "vacuum")) if fault == "conditions_exchanged" else SUPPLY
    assert FAULTS[fault].shows in found(build(FAULTS[fault].put_into(bench), 3))


def test_without_a_mistake_nothing_is_wrong() -> None:
    assert not found(build(SUPPLY, 3)) & {fault.shows for fault in FAULTS.values()}


def test_a_recording_steps_as_its_power_up_does() -> None:
    twin = build(replace(SUPPLY, runs=2), 1)
    truth = {(one.quantity, one.axis): one.value for one in twin.truth if not one.test}
    recording = twin.recordings["recordings/supply_air_1.csv"]
    d, e = recording.channel("supply").data - 5.0, recording.channel("temperature").data - 20.0
    design = np.column_stack([d, d * e, *(e**k for k in range(3))])
    for axis in "xyz":
        coefficients, *_ = np.linalg.lstsq(design, np.radians(recording.channel(axis).data), rcond=None)
        assert coefficients[0] == pytest.approx(truth["bias_supply", axis], abs=np.radians(2e-3))
    assert visits(SUPPLY, "supply_air", 1) == visits(SUPPLY, "supply_air", 2)[::-1]


def test_parts_do_not_change_each_other() -> None:
    alone = build(replace(Bench(), parts=("warm_up",)), 2)
    whole = build(Bench(warm_up_time=Bench().warm_up_time), 2)
    (name, *_) = alone.recordings
    assert np.array_equal(alone.recordings[name].channel("x").data, whole.recordings[name].channel("x").data)
    assert len(names_of(Bench(), "warm_up")) == len(alone.recordings)


def covered(n: int, bench: Bench) -> dict[str, tuple[int, int]]:
    return {f"{one.test} {one.key}": (one.hits, one.n) for one in coverage(lambda seed: build(bench, seed), n)}


@pytest.mark.slow
def test_intervals_hold_the_truth() -> None:
    wanted = covered(sized(60, 25), replace(SUPPLY, runs=4))
    assert sum(n for _, n in wanted.values())
    assert not {name: one for name, one in wanted.items() if one[1] and not covers(*one)}

"""Samples that are no readings (NaN in the channels): positions and rotations survive them, and say what they lose."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from independent.positions import by_hand
from inertialcal.core.errors import DataError
from inertialcal.core.estimate import Array
from inertialcal.core.recording import Channel, Recording
from inertialcal.procedures.positions.recordings import ACC, GYRO
from inertialcal.procedures.positions.reduction import Plan, Readings, Result, readings_from, reduce

RATE = 100.0  # [samples/s]
PLAN = Plan(gravity=9.81, latitude=np.radians(48.0))
REST = 2.5  # [s]
SMALL = 0.6  # part of u, by which a figure may move
Spoil = Callable[[dict[str, Array]], None]


@pytest.fixture(scope="module")
def hand() -> dict[str, Array]:
    case = by_hand(3, positions=14, rest=REST, turn=1.0, rate=RATE, first_rest=4.0)
    table = case.tables["hand.csv"]
    return dict(zip(ACC + GYRO, (np.asarray(table.columns[name]) for name in table.signals), strict=True))


@pytest.fixture(scope="module")
def clean(hand: dict[str, Array]) -> Result:
    return reduce(PLAN, readings(hand))


def readings(hand: dict[str, Array], spoil: Spoil | None = None, saturated: bool = False) -> Readings:
    columns = {name: own.copy() for name, own in hand.items()}
    if spoil is not None:
        spoil(columns)
    units = dict.fromkeys(ACC, "m/s^2") | dict.fromkeys(GYRO, "rad/s")
    channels = tuple(Channel(name, own, units[name]) for name, own in columns.items())
    stamps = np.round(np.arange(len(columns[ACC[0]])) / RATE * 1e9).astype(np.int64)
    return readings_from(PLAN, [Recording(channels, stamps, 1.0 / RATE)], saturated=[saturated])


def shift(result: Result, clean: Result) -> float:
    """Largest change of a figure, in its standard uncertainties."""
    moved = [
        np.abs(one.values - clean.estimates[k].values) / clean.estimates[k].u for k, one in result.estimates.items()
    ]
    return float(np.max(np.concatenate(moved)))


def codes(readings: Readings) -> list[str]:
    return [one.code for one in readings.remarks if one.severity != "info"]


def middle(readings: Readings, k: int) -> int:
    """Sample in the middle of a position."""
    assert readings.start_ns is not None
    assert readings.stop_ns is not None
    return int((readings.start_ns[k] + readings.stop_ns[k]) / 2e9 * RATE)


def test_single_samples_part_no_position(hand: dict[str, Array], clean: Result) -> None:
    def spoil(columns: dict[str, Array]) -> None:
        rng = np.random.default_rng(1)
        for own in columns.values():
            own[rng.choice(len(own), len(own) // 500, replace=False)] = np.nan

    found = readings(hand, spoil)
    assert len(found) == len(clean.readings)
    assert len(found.rotations) == len(clean.readings.rotations)
    assert not codes(found)
    assert shift(reduce(PLAN, found), clean) < SMALL


def test_a_stuck_stretch_inside_a_rest_is_one_position(hand: dict[str, Array], clean: Result) -> None:
    at = middle(clean.readings, 5)

    def spoil(columns: dict[str, Array]) -> None:
        columns["acc_y"][at - 20 : at + 40] = np.nan

    found = readings(hand, spoil)
    assert len(found) == len(clean.readings)
    assert shift(reduce(PLAN, found), clean) < 2.0 * SMALL


def test_saturated_rotations_are_left_out_and_counted(hand: dict[str, Array], clean: Result) -> None:
    """Clipped at 80 % of its largest rate, the scale factor was 1 % off."""
    limit = 0.8 * float(np.abs(hand["gyro_x"]).max())
    fast = [k for k, one in enumerate(clean.readings.rotations) if np.abs(one.gyro[:, 0]).max() > limit]

    def spoil(columns: dict[str, Array]) -> None:
        columns["gyro_x"][np.abs(columns["gyro_x"]) > limit] = np.nan

    found = readings(hand, spoil, saturated=True)
    remark = next(one for one in found.remarks if one.code == "rotation_incomplete")
    assert remark.count == len(fast)
    assert len(found.rotations) == len(clean.readings.rotations) - len(fast)
    result = reduce(PLAN, found)
    for key in result.estimates["gyro"].keys:
        i = result.estimates["gyro"].index(key)
        own = result.estimates["gyro"]
        assert abs(own.values[i] - clean.estimates["gyro"].values[i]) < 4.0 * own.u[i]


def test_a_long_gap_leaves_a_rotation_out_and_a_short_one_does_not(hand: dict[str, Array], clean: Result) -> None:
    one = clean.readings.rotations[4]
    assert clean.readings.stop_ns is not None
    first = int(clean.readings.stop_ns[4] / 1e9 * RATE) + len(one.gyro) // 2

    def gap(length: int) -> Readings:
        def spoil(columns: dict[str, Array]) -> None:
            columns["gyro_z"][first : first + length] = np.nan

        return readings(hand, spoil)

    assert len(gap(1).rotations) == len(clean.readings.rotations)
    assert len(gap(40).rotations) == len(clean.readings.rotations) - 1
    assert "rotation_incomplete" in codes(gap(40))


def test_a_position_without_readings_is_left_out(hand: dict[str, Array], clean: Result) -> None:
    at, reach = middle(clean.readings, 6), int(0.8 * REST * RATE)

    def spoil(columns: dict[str, Array]) -> None:
        columns["gyro_y"][at - reach // 2 : at + reach // 2] = np.nan

    found = readings(hand, spoil)
    assert len(found) == len(clean.readings) - 1
    assert found.left_out == (6,)
    assert codes(found) == ["position_incomplete"]
    assert {one.before for one in found.rotations} == set(range(12)) - {5}  # 5 to 7 is not one rotation


def test_a_gyro_without_any_reading_is_refused(hand: dict[str, Array]) -> None:
    def spoil(columns: dict[str, Array]) -> None:
        columns["gyro_y"][:] = np.nan

    with pytest.raises(DataError) as error:
        readings(hand, spoil)
    assert error.value.problems[0].code == "no_values"

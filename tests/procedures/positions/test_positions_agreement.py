"""Positions and turns that disagree with gravity: sign, unit and axes of a recording, or of the rest of one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from independent.positions import by_hand
from inertialcal.core.estimate import Array
from inertialcal.core.recording import Channel, Recording, Source
from inertialcal.core.remarks import Remark
from inertialcal.procedures.positions.agreement import agreement
from inertialcal.procedures.positions.recordings import ACC, GYRO, readings_from
from inertialcal.procedures.positions.reduction import Plan, Readings

RATE = 50.0  # [samples/s]
PLAN = Plan(gravity=9.81)
CHANGED = 8  # position from which on everything is changed
Change = Callable[[Array], Array]


def hand(seed: int, positions: int = 14) -> Array:
    """Return six channels (n, 6): accelerometers, gyros."""
    case = by_hand(seed, positions=positions, condition=(0.0, np.inf), rest=3.0, turn=1.0, rate=RATE, first_rest=5.0)
    table = case.tables["hand.csv"]
    return np.column_stack([table.columns[name] for name in table.signals])


def recorded(columns: Array, name: str = "hand.csv", begin: float = 0.0) -> Recording:
    units = dict.fromkeys(ACC, "m/s^2") | dict.fromkeys(GYRO, "rad/s")
    channels = tuple(Channel(one, own.copy(), units[one]) for one, own in zip(ACC + GYRO, columns.T, strict=True))
    stamps = np.round((begin + np.arange(len(columns)) / RATE) * 1e9).astype(np.int64)
    return Recording(channels, stamps, 1.0 / RATE, source=Source(name))


def readings(columns: Array) -> Readings:
    return readings_from(PLAN, [recorded(columns)])


def changed(columns: Array, change: Change) -> Array:
    """Return channels that are changed from the middle of a turn on."""
    clean = readings(columns)
    assert clean.stop_ns is not None
    assert clean.start_ns is not None
    at = round((clean.stop_ns[CHANGED - 2] + clean.start_ns[CHANGED - 1]) / 2e9 * RATE)
    return np.vstack([columns[:at], change(columns[at:])])


def places(remarks: Sequence[Remark]) -> list[str]:
    return [one.code for one in remarks]


def scaled(*factors: float) -> Change:
    return lambda part: part * np.array(factors)


@pytest.mark.parametrize(
    ("change", "code", "words"),
    [
        (scaled(*[-1.0] * 6), "sign_changed", "sign of all axes"),
        (scaled(1, 1, 1, 1, -1, 1), "sign_changed", "sign of y"),
        (scaled(1, 1, -1, 1, 1, 1), "sign_changed", "sign of x and y"),
        (scaled(1, 1, 1, *[180.0 / np.pi] * 3), "unit_changed", "deg/s"),
        (scaled(*[1.0 / 9.80665] * 3, 1, 1, 1), "unit_changed", "taken for m/s^2"),
        (lambda part: part[:, [0, 1, 2, 4, 3, 5]], "axes_changed", "gyro x turns about y"),
        (lambda part: part[:, [1, 0, 2, 3, 4, 5]], "axes_changed", "turns about"),
        (lambda part: part[:, [1, 2, 3, 4, 5, 0]], "axes_changed", "other axes or sensors"),
    ],
)  # fmt: skip
def test_a_change_in_mid_record_is_named_where_it_is(change: Change, code: str, words: str) -> None:
    found = agreement(PLAN, readings(changed(hand(1), change)))
    assert places(found) == [code]
    assert found[0].severity == "error"
    assert words in found[0].what
    assert "hand.csv: " in found[0].where


@pytest.mark.parametrize(
    ("change", "code"),
    [
        (scaled(1, 1, 1, -1, 1, 1), "sign_disagrees"), (scaled(*[1.0 / 9.80665] * 3, 1, 1, 1), "unit_disagrees"),
        (scaled(1, 1, 1, 0.5, 0.5, 0.5), "sample_rate_disagrees"),
        (lambda part: part[:, [0, 1, 2, 4, 3, 5]], "axes_disagree"),
    ],
)  # fmt: skip
def test_one_of_three_recordings_that_disagrees_is_named_by_its_file(change: Change, code: str) -> None:
    parts = [hand(seed, 7) for seed in (1, 2, 3)]
    parts[1] = change(parts[1])
    three = [recorded(own, f"hand{k}.csv", 1000.0 * k) for k, own in enumerate(parts)]
    found = agreement(PLAN, readings_from(PLAN, three))
    assert places(found) == [code]
    assert found[0].where.startswith("hand1.csv")
    assert not agreement(PLAN, readings_from(PLAN, [three[0], three[2]]))


@pytest.mark.parametrize("seed", range(4, 10))
def test_sound_records_agree(seed: int) -> None:
    assert not agreement(PLAN, readings(hand(seed)))


def test_a_recording_of_an_xsens_agrees_and_half_of_it_turned_does_not(shared: Path) -> None:
    folder = shared / "data" / "imu_tk_xsens_mti"
    counts = np.hstack([np.loadtxt(folder / f"xsens_{kind}.mat")[::2, 1:] for kind in ("acc", "gyro")])
    zero, scale = [33123, 33276, 32360, 32768, 32466, 32485], [415, 413, 415, 4778, 4758, 4766]
    si = (counts - np.array(zero)) / np.array(scale)
    assert not agreement(PLAN, readings(si))
    si[len(si) // 2 :] *= -1.0
    assert places(agreement(PLAN, readings(si))) == ["sign_changed"]


def test_gyros_without_any_reading_are_not_judged() -> None:
    sound = readings(hand(3))
    assert sound.gyro is not None
    nothing = replace(sound.gyro, mean=np.full_like(sound.gyro.mean, np.nan))
    assert agreement(PLAN, replace(sound, gyro=nothing, rotations=())) == []


def test_counts_of_unknown_scale_are_not_judged() -> None:
    columns = hand(1)
    units = dict.fromkeys(ACC + GYRO, "count")
    channels = tuple(Channel(one, 1000.0 * own, units[one]) for one, own in zip(ACC + GYRO, columns.T, strict=True))
    stamps = np.round(np.arange(len(columns)) / RATE * 1e9).astype(np.int64)
    assert not agreement(PLAN, readings_from(PLAN, [Recording(channels, stamps, 1.0 / RATE)]))

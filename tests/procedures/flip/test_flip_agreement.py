"""Dwells of a flip that disagree: a sign, a unit or axes that change, a misnamed position, a flip turned backwards."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from inertialcal.core.estimate import Array
from inertialcal.core.recording import Channel, Recording, Source
from inertialcal.core.remarks import Remark
from inertialcal.procedures.flip.agreement import agreement
from inertialcal.procedures.flip.dwells.quiet import Window
from inertialcal.procedures.flip.dwells.recordings import FlipRecording, readings_from
from inertialcal.procedures.flip.plan import Plan
from inertialcal.procedures.flip.readings import Readings

UG = 9.80665e-6  # [m/s^2]
RATE, DWELL, TURN = 4.0, 400, 60  # [samples/s], [s]
PLACES = (0.0, 180.0, 0.0, 180.0)  # [deg]
LEVEL, AMBIENT, NOISE = (-120.0, 80.0, 250.0), (1.0, 3.0, -2.0), 8.0  # [ug]
Spoil = Callable[[Array], Array]


def head(seed: int, places: tuple[float, ...] = PLACES, drift: float = 0.0) -> Array:
    """Return readings (n, 3) [ug]: dwells, and turns that shake; ``drift`` [ug] over the record."""
    rng = np.random.default_rng(seed)
    parts = []
    for k, place in enumerate(places):
        c = np.cos(np.radians(place))
        level = np.array(LEVEL) + np.array([1.0, c, c]) * np.array(AMBIENT)
        parts.append(level + NOISE * rng.standard_normal((round(DWELL * RATE), 3)))
        if k < len(places) - 1:
            parts.append(level + 30.0 * rng.standard_normal((round(TURN * RATE), 3)))
    y = np.concatenate(parts)
    return np.asarray(y + drift * np.linspace(0.0, 1.0, len(y))[:, None])


def readings(y: Array, places: tuple[float, ...] = PLACES, flips: tuple[str, ...] = ()) -> Readings:
    stamps = np.round(np.arange(len(y)) / RATE * 1e9).astype(np.int64)
    channels = tuple(Channel(axis, UG * own, "m/s^2", axis=axis) for axis, own in zip("xyz", y.T, strict=True))
    recording = Recording(channels, stamps, 1.0 / RATE, source=Source("head.csv"))
    starts = [k * (DWELL + TURN) for k in range(len(places))]
    windows = tuple(
        Window(round((start + 5) * 1e9), round((start + DWELL - 5) * 1e9), np.radians(place), flip)
        for start, place, flip in zip(starts, places, flips or ("1",) * len(places), strict=True)
    )
    return readings_from(Plan(), [FlipRecording(recording, windows, "head")])


def from_dwell(k: float, change: Spoil) -> Spoil:
    at = round(k * (DWELL + TURN) * RATE)
    return lambda y: np.vstack([y[:at], change(y[at:])])


def found(readings_: Readings) -> list[Remark]:
    return agreement(Plan(), readings_)


@pytest.mark.parametrize(
    ("spoil", "code"),
    [
        (from_dwell(2.4, lambda y: -y), "sign_changed"), (from_dwell(1.95, lambda y: -y), "sign_changed"),
        (from_dwell(1.3, lambda y: y[:, [1, 2, 0]] + 400.0), "axes_changed"),
        (from_dwell(1.95, lambda y: y[:, [1, 2, 0]] + 400.0), "axes_changed"),
        (from_dwell(2.3, lambda y: 5.0 * y), "scale_changed"),
        (from_dwell(1.6, lambda y: y / 9.80665), "unit_changed"),
        (from_dwell(1.95, np.radians), "unit_changed"),
    ],
)  # fmt: skip
@pytest.mark.parametrize("seed", [1, 2])
def test_what_changes_in_the_record_is_named(spoil: Spoil, code: str, seed: int) -> None:
    remarks = found(readings(spoil(head(seed))))
    assert [one.code for one in remarks] == [code]
    assert remarks[0].severity == "error"
    assert remarks[0].where.startswith("head")


@pytest.mark.parametrize("wrong", range(4))
def test_a_misnamed_position_is_named(wrong: int) -> None:
    """The noise of the record was taken over the step between dwells that seemed to be at one position."""
    named = tuple(180.0 - place if k == wrong else place for k, place in enumerate(PLACES))
    remarks = found(readings(head(3), named))
    assert [one.code for one in remarks] == ["not_turned_by_angle"]
    assert f"window {wrong + 1}" in remarks[0].where
    assert f"{PLACES[wrong]:g} deg" in remarks[0].what


def test_a_flip_whose_positions_are_swapped_is_named() -> None:
    places, flips = (0.0, 180.0) * 3, ("1", "1", "2", "2", "3", "3")
    named = (0.0, 180.0, 180.0, 0.0, 0.0, 180.0)
    y = head(4, places)
    assert not found(readings(y, places, flips))
    remarks = found(readings(y, named, flips))
    assert [one.code for one in remarks] == ["not_turned_by_angle"]
    assert "flip 2" in remarks[0].what


@pytest.mark.parametrize("drift", [0.0, 20.0])
def test_sound_flips_agree(drift: float) -> None:
    """Of 500 simulated records of each of eight kinds none was accused: slow noise, drift, angles of the turns off."""
    assert not [one for seed in range(10, 13) for one in found(readings(head(seed, drift=drift)))]


def test_samples_that_are_no_readings_change_nothing() -> None:
    y = head(5)
    clean = readings(y)
    rng = np.random.default_rng(5)
    for axis in range(3):
        y[rng.choice(len(y), 10, replace=False), axis] = np.nan
    said = {one.code for one in readings(y).remarks}
    assert said <= {one.code for one in clean.remarks} | {"blocks_incomplete"}
    y[2000:2060] = np.nan  # stuck
    lossy = readings(y)
    assert not found(lossy)
    for name in "yz":
        assert np.max(np.abs(lossy.outputs[name] - clean.outputs[name])) < 0.6 * NOISE * UG / np.sqrt(DWELL * RATE)


def test_two_dwells_or_no_record_say_nothing() -> None:
    one = readings(head(6, PLACES[:2]), PLACES[:2])
    assert not found(one)
    assert not found(replace(one, quiet=()))

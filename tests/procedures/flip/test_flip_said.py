"""Turns that are said, by windows and positions, against those that the record shows; wrong positions by name."""

from __future__ import annotations

import numpy as np
import pytest

from inertialcal.core.errors import UsageError
from inertialcal.core.estimate import Array
from inertialcal.core.recording import SECOND, Channel, Recording, Source
from inertialcal.core.remarks import Remark
from inertialcal.procedures.flip.agreement import agreement
from inertialcal.procedures.flip.dwells.quiet import Window
from inertialcal.procedures.flip.dwells.recordings import FlipRecording, readings_from
from inertialcal.procedures.flip.given import found_windows
from inertialcal.procedures.flip.plan import Plan

UG = 9.80665e-6  # [m/s^2]
RATE, DWELL, TURN, NOISE = 4.0, 400, 60, 8.0  # [samples/s], [s], [s], [ug]
BIAS, AMBIENT = np.array([-120.0, 80.0, 250.0]), np.array([1.0, 3.0, -2.0])  # [ug]
HALVES, QUARTERS = (0, 180, 0, 180), (0, 90, 180, 270, 0)  # [deg]


def level(place: float, axis: int = 0) -> Array:
    """Return what the axes read at a position [ug]: C_k G + B, turned about an axis."""
    i, j = (axis + 1) % 3, (axis + 2) % 3
    c, s = np.cos(np.radians(place)), np.sin(np.radians(place))
    y = AMBIENT.copy()
    y[i], y[j] = c * AMBIENT[i] + s * AMBIENT[j], -s * AMBIENT[i] + c * AMBIENT[j]
    return np.asarray(y + BIAS)


def head(places: tuple[int, ...], seed: int = 1, axis: int = 0, sense: int = 1, shake: float = 3.0) -> Recording:
    rng = np.random.default_rng(seed)
    parts = []
    for k, place in enumerate(places):
        here = level(sense * place, axis)
        parts.append(here + NOISE * rng.standard_normal((round(DWELL * RATE), 3)))
        if k < len(places) - 1:
            m = round(TURN * RATE)
            part = ((np.arange(m) + 0.5) / m)[:, None]
            there = level(sense * places[k + 1], axis)
            parts.append(here + part * (there - here) + (1.0 + shake) * NOISE * rng.standard_normal((m, 3)))
    y = np.concatenate(parts)
    stamps = np.rint(np.arange(len(y)) / RATE * SECOND).astype(np.int64)
    channels = tuple(Channel(name, UG * own, "m/s^2", axis=name) for name, own in zip("xyz", y.T, strict=True))
    return Recording(channels, stamps, 1.0 / RATE, source=Source("head.csv"))


def said(named: tuple[int, ...], shift: float = 0.0, wide: bool = False) -> tuple[Window, ...]:
    """Return a window in each dwell, later by ``shift`` [s]; ``wide``: those that overlap turns."""
    found = []
    for k, place in enumerate(named):
        start = k * (DWELL + TURN) + shift
        stop = start + DWELL + (200.0 if wide and k == 0 else -5.0)
        start += 205.0 if wide and k == 1 else 5.0
        found.append(Window(round(start * SECOND), round(stop * SECOND), float(np.radians(place))))
    return tuple(found)


def judged(recording: Recording, windows: tuple[Window, ...]) -> tuple[list[Remark], dict[str, Remark]]:
    """Return the errors, and the other remarks by code."""
    readings = readings_from(Plan(), [FlipRecording(recording, windows, "head")])
    return agreement(Plan(), readings), {one.code: one for one in readings.remarks}


def test_a_turn_that_is_said_stands_beside_the_turn_that_is_seen() -> None:
    wrong, remarks = judged(head(HALVES), said(HALVES))
    assert not wrong
    what = remarks["turns_seen"].what
    assert "395 to 465 s, seen 400 to 4" in what
    assert what.count(" s, seen ") == 3


def test_turns_that_are_too_small_check_nothing() -> None:
    wrong, remarks = judged(head((0, 0, 0, 0), shake=0.0), said(HALVES))
    assert not wrong
    assert remarks["turn_not_seen"].severity == "info"
    assert remarks["turn_not_seen"].count == 3


def test_a_turn_inside_a_window_spoils_it() -> None:
    wrong, _ = judged(head(HALVES), said(HALVES, wide=True))
    assert [one.code for one in wrong] == ["turn_in_dwell"]
    assert wrong[0].severity == "error"
    assert "window 1" in wrong[0].where


@pytest.mark.parametrize("wrong_one", range(4))
def test_the_window_with_the_wrong_position_is_named(wrong_one: int) -> None:
    named = tuple(180 - place if k == wrong_one else place for k, place in enumerate(HALVES))
    (found,), _ = judged(head(HALVES), said(named))
    assert found.code == "not_turned_by_angle"
    assert f"window {wrong_one + 1}" in found.where


def test_positions_exchanged_throughout_cannot_be_told() -> None:
    wrong, _ = judged(head(HALVES), said((180, 0, 180, 0)))
    assert not wrong


def test_a_turn_outside_the_windows_is_remarked() -> None:
    wrong, remarks = judged(head(HALVES), said(HALVES)[:3])
    assert not wrong
    assert remarks["turn_not_said"].severity == "warning"


def test_a_bias_that_jumps_between_windows_is_an_error() -> None:
    recording = head(HALVES)
    data = recording.channel("y").data.copy()
    data[round(660.0 * RATE) :] += 9.0 * UG
    channels = tuple(
        Channel(one.name, data if one.name == "y" else one.data, "m/s^2", axis=one.name) for one in recording.channels
    )
    jumped = Recording(channels, recording.time_ns, 1.0 / RATE, source=Source("head.csv"))
    windows = said(HALVES)
    second = (
        Window(windows[1].start, round(600.0 * SECOND), np.pi),
        Window(round(720.0 * SECOND), windows[1].stop, np.pi),
    )
    wrong, _ = judged(jumped, (windows[0], *second, *windows[2:]))
    assert [one.code for one in wrong] == ["level_step"]
    wrong, _ = judged(jumped, windows)
    assert [one.code for one in wrong] == ["turn_in_dwell"]


@pytest.mark.parametrize("seed", range(3))
def test_quarter_turns_as_stated_are_not_accused(seed: int) -> None:
    wrong, remarks = judged(head(QUARTERS, seed), said(QUARTERS))
    assert not wrong
    assert "turns_seen" in remarks


@pytest.mark.parametrize(
    ("named", "axis", "sense", "code", "text"),
    [
        ((0, 180, 90, 270, 0), 0, 1, "not_turned_by_angle", "exchanged"),
        ((0, 90, 0, 270, 0), 0, 1, "not_turned_by_angle", "what they read at 180 deg"),
        (QUARTERS, 0, -1, "not_turned_by_angle", "other sense"),
        (QUARTERS, 2, 1, "turned_about_other_axis", "a turn about z, not about x"),
        (QUARTERS, 1, 1, "turned_about_other_axis", "a turn about y, not about x"),
    ],
)
def test_what_is_wrong_about_quarter_turns_is_named(
    named: tuple[int, ...], axis: int, sense: int, code: str, text: str
) -> None:
    wrong, _ = judged(head(QUARTERS, 2, axis, sense), said(named))
    assert wrong
    assert {(one.code, one.severity) for one in wrong} == {(code, "error")}
    assert text in wrong[0].what


def test_the_command_asks_for_windows_where_positions_are_more_than_two() -> None:
    with pytest.raises(UsageError, match="not to and fro between two levels: 4 turns found") as caught:
        found_windows(head(QUARTERS), np.pi)
    assert caught.value.problems[0].code == "unclear_turns"


def test_the_command_asks_for_windows_where_one_change_has_no_spike() -> None:
    with pytest.raises(UsageError, match="changes once, without a spike"):
        found_windows(head((0, 180), shake=0.0), np.pi)

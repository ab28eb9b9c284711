"""A guide and a hand that obeys it badly: what it says, when it ends, and that its end is that of the procedure."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import product

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from simulated_hand import CLEAN, NS, Habits, Hand, guided, only

import inertialcal as ic
from inertialcal.core.estimate import Array
from inertialcal.core.recording import Times
from inertialcal.core.results import Interval, Row
from inertialcal.lab.guide.engine import FREE, UNKNOWNS, WIDE, Guide, State
from inertialcal.lab.guide.rests import LONGEST_MOVE, LONGEST_REST, TAIL
from inertialcal.lab.guide.words import ROUND, turn
from inertialcal.procedures.positions.planning.design import Setup, course, cube, next_position
from inertialcal.statistics.intervals import covers
from sized import sized

WANTED = {"bias": "0.2 mg", "scale_factor_error": "200 ppm", "misalignment": "0.023 deg"}
LIST = 24  # positions of a fixed list
SLOW = pytest.mark.slow
HANDS = ((2, CLEAN), pytest.param(1, Habits(), marks=SLOW), pytest.param(4, Habits(), marks=SLOW))
RATE = 50.0  # [Hz]


@dataclass(frozen=True, eq=False)
class Made:
    """A calibration from the first batch to the last."""

    hand: Hand
    guide: Guide
    states: Sequence[State]
    recording: ic.Recording
    rows: Sequence[Row]


def recording_of(parts: Iterable[Sequence[Array]], gyros: bool) -> ic.Recording:
    t, f, w = (np.concatenate(one) for one in zip(*parts, strict=True))
    named = [("acc", "m/s^2", f), *([("gyro", "rad/s", w)] if gyros else [])]
    channels = [
        ic.Channel(f"{name}_{axis}", values[:, k], unit) for name, unit, values in named for k, axis in enumerate("xyz")
    ]
    return ic.Recording(tuple(channels), t, 1.0 / RATE)


@lru_cache(maxsize=2)
def made(seed: int, habits: Habits, gyros: bool = False) -> Made:
    """Return a calibration that goes on until the procedure, on what was recorded, says that it is enough."""
    hand = Hand(seed, habits, step=1.0, rate=RATE)
    guide = Guide(WANTED, RATE, gravity=9.807, gyros=gyros, labels={"z+": "label"}, sides={"x": "its long side"})
    states, parts = [], []
    for state, *samples in guided(guide, hand, gyros=gyros):
        states.append(state)
        parts.append(samples)
        if state.code == "enough":
            recording = recording_of(parts, gyros)
            rows = ic.positions(recording, **guide.settings).result.rows()
            if guide.judge(rows).code == "enough":
                return Made(hand, guide, states, recording, rows)
    pytest.fail(f"seed {seed}: {state.code} after {hand.t:.0f} s, {state.positions} positions: {state.text}")


def wanted_rows(rows: Sequence[Row], truth: dict[str, float]) -> dict[str, Row]:
    """Return the rows of what is known of the simulated IMU, by name."""
    own = {str(row.key._replace(sensor="")): row for row in rows
           if row.key.sensor == "accelerometer" and not row.case.beside and row.interval is not None}  # fmt: skip
    return {name: own[name] for name in truth}


def ends_of(one: Made) -> dict[str, tuple[float, float]]:
    """Return the intervals of what is known of the simulated IMU."""
    found = {}
    for name, row in wanted_rows(one.rows, one.hand.imu.truth()).items():
        ends = row.interval
        assert ends is not None
        assert ends.lo is not None
        assert ends.hi is not None
        found[name] = (ends.lo, ends.hi)
    return found


def hits(one: Made) -> dict[str, bool]:
    truth = one.hand.imu.truth()
    return {name: low <= truth[name] <= high for name, (low, high) in ends_of(one).items()}


@pytest.mark.parametrize(("seed", "habits"), HANDS)
def test_ends_with_what_was_asked_and_with_the_figures_of_the_procedure(seed: int, habits: Habits) -> None:
    one = made(seed, habits, gyros=True)
    limits = one.guide.wanted
    for name, (low, high) in ends_of(one).items():
        assert 0.5 * (high - low) <= WIDE * limits[name[:-2] if name[:-3] != "misalignment" else "misalignment"]
    live = one.guide.result
    final = ic.positions(one.recording, **one.guide.settings).result
    assert live is not None
    assert [row.value for row in final.rows()] == [row.value for row in one.rows]
    assert len(live.readings) == len(final.readings) == one.states[-1].positions < LIST
    assert len(live.readings.rotations) == len(final.readings.rotations)
    # The ends of a rest are judged with what comes after it, and with the noise of the whole
    off = np.abs(live.readings.acc.mean - final.readings.acc.mean) / np.maximum(final.readings.acc.u, 1e-9)
    assert np.median(off) < 0.5
    assert np.max(np.abs(live.acc.sensor.values - final.acc.sensor.values) / one_u(final.rows())) < 1.0


def one_u(rows: Sequence[Row]) -> float:
    return max(row.u for row in rows if row.key.sensor == "accelerometer" and row.key.quantity == "bias" and row.u)


MISTAKES = {
    "shakes": ("held_in_hand", "table", ""),
    "repeats": ("repeated", "already", ""),
    "unplugs": ("unplugged", "plug it in", "was_unplugged"),
    "drops": ("", "", "shock"),
    "early": ("", "", "too_short"),
    "wrong": ("hold_still", "not the position|Not the position", ""),
}


NEEDED = {"shakes", "repeats", "unplugs"}


@pytest.mark.parametrize("mistake", [one if one in NEEDED else pytest.param(one, marks=SLOW) for one in MISTAKES])
def test_says_what_to_do_after_a_mistake(mistake: str) -> None:
    code, words, notice = MISTAKES[mistake]
    hand = Hand(3, only(mistake, 0.5), step=1.0, rate=RATE)
    guide = Guide(WANTED, RATE, gravity=9.807, gyros=False)
    longest = 40.0 if mistake in NEEDED else 60.0
    states = [state for state, *_ in guided(guide, hand, longest=longest, gyros=False)]
    assert mistake in hand.did
    if code:
        assert any(state.code == code and re.search(words, state.text) for state in states)
    if notice:
        assert any(one.code == notice and one.text for state in states for one in state.notices)
    assert states[-1].positions >= 2  # and it goes on


def test_what_is_known_shrinks_and_a_hand_without_mistakes_hears_of_none() -> None:
    one = made(2, CLEAN, gyros=True)
    assert {state.code for state in one.states} <= {"lay_down", "hold_still", "turn", "enough"}
    assert not [notice for state in one.states for notice in state.notices]
    largest = [max(k.row.u or np.inf for k in state.known if k.wanted) for state in one.states if state.known]
    assert np.isfinite(largest[-1])
    assert largest[-1] < 0.5 * max(u for u in largest if np.isfinite(u))
    assert one.states[-1].to_go == 0
    assert one.states[-1].positions >= UNKNOWNS + FREE
    going = [state.to_go for state in one.states if state.to_go is not None]
    assert going[0] > 5
    # The procedure has the last word
    wider = [ic.Row(row.key, row.value, 9.0 * (row.u or 1.0), row.unit, None, Interval(-1e3, 1e3)) for row in one.rows]
    state = one.guide.judge(wider)
    assert state.code != "enough"
    assert state.to_go
    assert state.target


def test_size_of_the_batches_does_not_matter() -> None:
    f, w, t = still_then_turned()
    found = []
    for size in (23, len(t)):
        guide = Guide(WANTED, RATE, gravity=9.807)
        for first in range(0, len(t), size):
            part = slice(first, first + size)
            state = guide.add(t[part], f[part], w[part])
        found.append(state.positions)
    assert found == [4, 4]


def test_a_position_that_is_taken_back_is_forgotten_and_may_be_shown_again() -> None:
    f, w, t = still_then_turned()
    guide, seen = Guide(WANTED, RATE, gravity=9.807), list[State]()
    assert guide.undo() is None
    for first in range(0, len(t), 25):
        part = slice(first, first + 25)
        state = guide.add(t[part], f[part], w[part])
        if state.positions == 3 and not seen:
            found = guide.undo()
            assert found is not None
            began, after = found
            seen.append(after)
            assert after.positions == 2
            assert [one.code for one in after.notices] == ["taken_back"]
            at = np.searchsorted(t, began)
            assert np.linalg.norm(f[at : first + 25].mean(axis=0)) == pytest.approx(9.8, abs=0.5)  # it rested since
            assert float(w[at : first + 25].std(axis=0).max()) < 0.01
    assert state.positions == 3  # the fourth of those that were laid is the third that counts
    readings = guide._rests.readings
    assert readings is not None
    assert all(one.after < 2 for one in readings.rotations)  # what was turned to the place taken back is not known


def test_a_gyro_that_is_wanted_is_turned_about() -> None:
    """Once the accelerometers are enough, the next position is a long turn about the axis that is known worst."""
    one = made(2, CLEAN, gyros=True)
    guide = Guide({**WANTED, "gyro.scale_factor_error_y": "1 ppm"}, RATE, gravity=9.807)
    guide._rests = one.guide._rests
    guide._fit()
    guide._choose()
    state = guide._said([], np.zeros(0, dtype=np.bool_))
    assert state.code != "enough"
    assert state.to_go
    up, target = guide._directions()[-1], np.array(state.target)
    across = np.cross(target, up)
    if abs(up[1]) > np.sqrt(0.5):  # nothing turns about what points up
        assert abs(target[1]) < 1e-9
    else:
        assert abs(across[1]) / np.linalg.norm(across) > 0.7
        assert np.degrees(np.arccos(target @ up)) > 60.0
    assert one.guide.known(one.rows)[0].reached


def still_then_turned() -> tuple[Array, Array, Times]:
    hand = Hand(6, CLEAN, rate=RATE)
    hand.queue = []
    for target in np.vstack([np.eye(3), -np.eye(3)[:1]]):
        hand._lay(target)
        hand._stay(6.0)
    f, w = (np.vstack([one[k] for one in hand.queue]) for k in (0, 1))
    return f, w, np.round(np.arange(1, len(f) + 1) / RATE * NS).astype(np.int64)


@pytest.mark.parametrize("seconds", [600, pytest.param(3600, marks=SLOW)])
@pytest.mark.parametrize("kind", ["lies", "moves"])
def test_memory_stays_over_an_hour(kind: str, seconds: int) -> None:
    rng, guide = np.random.default_rng(1), Guide(WANTED, RATE, gravity=9.807)
    n = round(20.0 * RATE)
    most = 0
    for k in range(seconds // 20):
        t = np.round((k * n + np.arange(1, n + 1)) / RATE * NS).astype(np.int64)
        f = np.array([0.0, 0.0, 9.8]) + (0.02 if kind == "lies" else 2.0 * (k > 1)) * rng.standard_normal((n, 3))
        f = f + 0.02 * rng.standard_normal((n, 3))
        state = guide.add(t, f, 1e-3 * rng.standard_normal((n, 3)))
        most = max(most, guide.bytes_kept)
    window = (guide._rests.shortest + TAIL + LONGEST_MOVE + LONGEST_REST + 20.0) * RATE
    assert most <= window * 7 * 8 + 1e5
    assert state.positions == 1
    assert state.code == ("turn" if kind == "lies" else "held_in_hand")


def test_samples_that_come_late_or_twice_are_not_recorded() -> None:
    guide = Guide(WANTED, RATE, gyros=False)
    t = np.arange(1, 101) * 20_000_000
    f = np.tile([0.0, 0.0, 9.8], (100, 1))
    state = guide.add(np.concatenate([t[:50], t[40:50], t[50:]]), np.vstack([f, f[:10]]))
    assert state.accepted.sum() == 100
    assert not state.accepted[50:60].any()
    assert [one.code for one in state.notices] == ["late_samples"]
    assert guide.add(t, f).accepted.sum() == 0


def test_a_gap_inside_a_batch_and_silence_are_seen() -> None:
    guide = Guide(WANTED, RATE, gyros=False)
    t = np.arange(1, 101) * 20_000_000
    f = np.tile([0.0, 0.0, 9.8], (100, 1)) + 0.02 * np.random.default_rng(1).standard_normal((100, 3))
    state = guide.add(np.concatenate([t[:50], t[50:] + 3 * NS]), f)
    assert [one.code for one in state.notices] == ["was_unplugged"]
    assert guide.silent(int(t[-1]) + 3 * NS + NS // 10).code != "unplugged"
    assert guide.silent(int(t[-1]) + 4 * NS).code == "unplugged"


def test_readings_in_g_are_named() -> None:
    f, w, t = still_then_turned()
    state = Guide(WANTED, RATE, gravity=9.807).add(t, f / 9.80665, w)
    assert state.code == "refused"
    assert " g" in state.text


@pytest.mark.parametrize(
    ("wanted", "code"),
    [
        ({}, "wrong_value"), ({"bias": "1 parsec"}, "no_unit"), ({"colour": "1 mg"}, "unknown_name"),
        ({"gyro.bias": "1 deg/h"}, "wrong_value"), ({"bias": "1 mg", "gyro.bias": "1 mg"}, "no_unit"),
        ({"bias": "1 mg", "gyro.colour": "1 %"}, "unknown_name"),
        ({"bias": "1 mg", "gyro.bias": "0 deg/s"}, "wrong_value"),
    ],
)  # fmt: skip
def test_refuses_what_cannot_be_wanted(wanted: dict[str, str], code: str) -> None:
    with pytest.raises(ic.UsageError) as caught:
        Guide(wanted, RATE)
    assert caught.value.problems[0].code == code


def test_refuses_what_gravity_does_not_allow() -> None:
    with pytest.raises(ic.PlanError) as caught:
        Guide({"scale_factor_error": "10 ppm"}, RATE, gravity_u=1e-3)
    assert caught.value.problems[0].code == "target_not_reached"


def test_refuses_arrays_that_do_not_fit() -> None:
    guide = Guide(WANTED, RATE)
    for given in [(np.zeros((5, 3)),), (np.zeros((5, 3)), np.zeros((4, 3))), (np.zeros((5, 2)), np.zeros((5, 3)))]:
        with pytest.raises(ic.DataError) as caught:
            guide.add(np.arange(5), *given)
        assert caught.value.problems[0].code == "wrong_shape"


def test_turns_in_words_lead_where_they_say() -> None:
    """By the axis and angle that are said, in one of both senses, what should point up does, as near as is said."""
    about_axes = 0
    for a, b in product(cube(), repeat=2):
        said = turn(a, b, {}, {})
        angle = np.degrees(np.arccos(np.clip(a @ b, -1.0, 1.0)))
        if said.startswith("Turn it upside down"):
            assert angle > 150.0
            assert min(np.abs(a)) > 0.3
            continue
        found = re.match(r"Turn it (?:by (\d+) deg|over) about its ([xyz]) axis", said)
        tilt = re.match(r"Tilt it by (\d+) deg", said)
        assert bool(found) != bool(tilt)
        if tilt:
            assert abs(float(tilt[1]) - angle) <= max(ROUND / 2.0, ROUND - angle)
            continue
        assert found
        about_axes += 1
        size = np.radians(float(found[1] or 180.0))
        axis = np.eye(3)["xyz".index(found[2])]
        reached = [Rotation.from_rotvec(sense * size * axis).apply(a) for sense in (1.0, -1.0)]
        assert max(one @ b for one in reached) > np.cos(np.radians(46.0 if "over" in said else 35.0))
    assert about_axes > 100


def test_words_name_what_is_printed() -> None:
    labels, sides = {"z+": "label", "x+": "plug"}, {"x": "its long side"}
    assert turn(np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, -1.0]), labels, sides) == (
        "Turn it over about its long side, so that it lies flat: z down (label down)"
    )
    assert turn(np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0]), labels, sides) == (
        "Turn it by 90 deg about its y axis, so that it lies flat: x up (plug)"
    )


def test_next_position_by_what_is_wanted_is_that_of_the_course() -> None:
    setup, target = Setup(1e-3), {"bias": 1e-3, "misalignment": 1e-3}
    whole = course(setup, target).directions
    for k in range(1, len(whole)):
        assert np.array_equal(next_position(setup, whole[:k], goal=target), whole[k])


@pytest.mark.slow
def test_fewer_positions_than_a_list_on_the_median() -> None:
    counts = [made(seed, Habits()).states[-1].positions for seed in range(1, sized(50, 8) + 1)]
    assert np.median(counts) < LIST


@pytest.mark.slow
def test_intervals_at_the_end_hold_the_truth() -> None:
    """Stopping at what is small enough could prefer positions that happen to agree: it must not show."""
    held = [hits(made(seed, Habits())) for seed in range(1, sized(300, 20) + 1)]
    for name in held[0]:
        assert covers(sum(one[name] for one in held), len(held)), name

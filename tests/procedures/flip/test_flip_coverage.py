"""A thousand flips of the rig: intervals that hold the truth, false alarms, disturbances that are seen.

Seeds are 1 to n, and the records those of the rig: an hour of three axes at 25 samples/s, turned by half a turn and
back, or once. Everything from samples to remarks is run.
"""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from rig_flips import ONE_WAY, THERE_AND_BACK, Tally, Turning, flips, recording_of

from inertialcal.core.errors import UsageError
from inertialcal.core.recording import SECOND
from inertialcal.procedures.flip.dwells.recordings import FlipRecording, readings_from
from inertialcal.procedures.flip.given import found_windows
from inertialcal.procedures.flip.reduction import reduce
from inertialcal.rigs.sams_tsh.record import ARM_FADE
from inertialcal.statistics.intervals import covers
from sized import FULL, sized

CORNERS = (0.0, 0.01, 0.1)  # of the 1/f noise [Hz]; 0: white alone
LONG, FURTHER = range(1, sized(1000, 40) + 1), range(1, sized(1000, 60) + 1)
SHORT = range(1, 8)  # shows gross mistakes alone
MINUTES = 8.0  # for 3,000 flips on PROCESSES
PROCESSES = 2
# What is said of every flip, and of turns that slow noise hides
QUIET = {"relative_to_fixture", "settling", "turns_seen", "turn_not_seen"}
MOST = 0.03  # of undisturbed flips that carry a remark they should not, each kind
TESTED = {"control_axis_not_zero", "not_turned_by_angle"}  # at 1 %
ARM = 60.0  # [s] that the robot arm moves


def check(found: Tally, corner: float, standards: bool = False) -> None:
    """Check that intervals hold the truth, and how often what is right is called wrong."""
    n = found.n
    assert len(found.hits) == 6
    assert all(covers(hits, n, 0.93, 1.0) for hits in found.hits.values()), (corner, found.hits)
    assert covers(found.remarks["control_axis_not_zero"], n, 0.0, 0.02), (corner, found.remarks)
    assert covers(found.remarks["not_turned_by_angle"], n, 0.0, 0.02), (corner, found.remarks)  # a test at 1 %
    false = {code: k for code, k in found.remarks.items() if code not in {*QUIET, *TESTED}}
    assert all(covers(k, n, 0.0, MOST) for k in false.values()), (corner, false)
    assert found.remarks["relative_to_fixture"] == (0 if standards else n)


@pytest.mark.parametrize("corner", [CORNERS[0], CORNERS[-1]])  # the next test has all, and many more flips
def test_intervals_hold_the_truth_of_the_rig(corner: float) -> None:
    check(flips(THERE_AND_BACK, corner, SHORT), corner)


@pytest.mark.slow
def test_intervals_hold_the_truth_of_three_thousand_flips() -> None:
    found = {corner: flips(THERE_AND_BACK, corner, LONG, PROCESSES) for corner in CORNERS}
    for corner, one in found.items():
        check(one, corner)
    seconds = sum(one.seconds for one in found.values())
    assert seconds / PROCESSES < 60.0 * MINUTES or not FULL, f"{seconds:.0f} s of processor time"


@pytest.mark.slow
@pytest.mark.parametrize("corner", sized(CORNERS, CORNERS[1:2]))
def test_intervals_hold_the_truth_of_single_half_turns(corner: float) -> None:
    check(flips(ONE_WAY, corner, FURTHER, PROCESSES), corner)


@pytest.mark.slow
@pytest.mark.parametrize("corner", sized(CORNERS, CORNERS[1:2]))
def test_intervals_hold_the_truth_where_standards_are_off(corner: float) -> None:
    check(flips(replace(ONE_WAY, standards=True), corner, FURTHER, PROCESSES), corner, standards=True)


def remarked(turning: Turning, corner: float, n: int, processes: int = 0) -> float:
    """Part of the flips whose disturbance is remarked."""
    return flips(replace(turning, arm=ARM), corner, range(1, n + 1), processes).remarks["disturbed"] / n


@pytest.mark.parametrize("corner", CORNERS[:1])
def test_a_robot_arm_in_a_window_is_remarked(corner: float) -> None:
    assert remarked(ONE_WAY, corner, 10) >= 0.95


@pytest.mark.slow
@pytest.mark.parametrize("turning", [ONE_WAY, THERE_AND_BACK])
@pytest.mark.parametrize("corner", sized(CORNERS, CORNERS[1:2]))
def test_a_robot_arm_in_a_window_is_remarked_in_95_of_100(corner: float, turning: Turning) -> None:
    n = sized(200, 60)
    assert remarked(turning, corner, n, PROCESSES) >= 0.95


def kept_off(seed: int, corner: float) -> bool:
    """Whether windows that are found by themselves keep off the robot arm, or a remark says that they do not."""
    turning = replace(ONE_WAY, arm=ARM)
    moving = turning.moving(seed)
    assert moving is not None
    recording = recording_of(turning.record(seed, corner), turning.bench)
    try:
        found, said = found_windows(recording, math.pi)
    except UsageError:  # the turn is not seen in next to no acceleration: windows are asked for
        return True
    reach = max(min(one.stop / SECOND, moving[1]) - max(one.start / SECOND, moving[0]) for one in found)
    plan = turning.plan
    remarks = (*said, *reduce(plan, readings_from(plan, [FlipRecording(recording, tuple(found))])).remarks)
    return reach <= ARM_FADE or "disturbed" in {one.code for one in remarks}


@pytest.mark.parametrize("n", [4, pytest.param(sized(200, 30), marks=pytest.mark.slow)])
@pytest.mark.parametrize("corner", [0.01])
def test_windows_that_are_found_keep_off_a_robot_arm_or_say_so(corner: float, n: int) -> None:
    assert sum(kept_off(seed, corner) for seed in range(1, n + 1)) >= 0.95 * n

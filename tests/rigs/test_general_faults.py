"""General faults: every rig takes those that make sense for it, and each does what its entry says."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from inertialcal.core.errors import UsageError
from inertialcal.core.recording import Recording
from inertialcal.rigs import BUILT_IN, RIGS
from inertialcal.rigs.faults import FAULTS
from inertialcal.rigs.faults.scene import Scene, spoiled
from inertialcal.rigs.hand_held import rig as hand_held
from inertialcal.rigs.hand_held.setup import Bench as Laid
from inertialcal.rigs.mesa import rig as mesa
from inertialcal.rigs.rate_table import rig as rate_table
from inertialcal.rigs.rate_table.setup import Bench
from inertialcal.rigs.sams_tsh import rig as sams_tsh
from inertialcal.rigs.still_gyro import rig as still_gyro
from inertialcal.rigs.twin import Twin, parse_fault

TURNED = replace(
    rate_table.build(
        Bench(rates_deg_s=(0.0, 2.0, -2.0, 4.5, -4.5, 0.0), dwell=60.0, interval=1.0, runs=4, fit_runs=3), 1
    ),
    seed=1,
)
STILL = replace(still_gyro.build(still_gyro.Bench(samples=3000), 1), seed=1)
FACES = replace(hand_held.build(Laid(variant="ferraris"), 1), seed=1)
MOVED = replace(mesa.build(mesa.Bench(), 1), seed=1)
FLIP = replace(sams_tsh.build(sams_tsh.Bench(), 1), seed=1)
MADE = {"rate_table": TURNED, "still_gyro": STILL, "six_faces": FACES, "mesa": MOVED, "sams_tsh": FLIP}
CASES = [(rig, name) for rig in MADE for name in RIGS[rig].every_fault if name in FAULTS]
UNCHANGED = {"grouped_digits", "zero_uncertainty", "wrong_label"}  # recordings; their text, or the campaign's, differs


def with_fault(twin: Twin, name: str, size: float | None = None) -> Twin:
    fault = FAULTS[name]
    return spoiled(replace(twin, fault=name), fault, (fault.size or 0.0) if size is None else size)


def changed(one: Recording, other: Recording) -> bool:
    same = one.time_ns is not None and other.time_ns is not None and np.array_equal(one.time_ns, other.time_ns)
    return (
        not same
        or one.names != other.names
        or any(
            not np.array_equal(a.data, b.data, equal_nan=a.data.dtype.kind == "f")
            for a, b in zip(one.channels, other.channels, strict=True)
        )
    )


@pytest.mark.parametrize(("rig", "name"), CASES)
def test_each_fault_changes_the_recordings_that_it_names_and_no_others(rig: str, name: str) -> None:
    good, bad = MADE[rig], with_fault(MADE[rig], name)
    moved = {file for file in good.recordings if changed(good.recordings[file], bad.recordings[file])}
    assert bool(moved) == (name not in UNCHANGED)
    assert moved or bad.campaign != good.campaign or bad.texts
    scene = Scene(good, FAULTS[name].procedures)
    files = {place.file for place in scene.places if set(place.names) & set(bad.spoiled)}
    assert not bad.spoiled or moved <= files
    assert with_fault(good, name).spoiled == bad.spoiled  # by the seed


def test_a_fault_has_one_meaning_a_size_inside_its_limits_and_says_what_is_expected() -> None:
    for name, fault in FAULTS.items():
        assert fault.size is None or fault.least <= fault.size <= fault.most
        assert bool(fault.codes) == (fault.expects != "covered"), name
        assert not [rig for rig in BUILT_IN if name in RIGS[rig].faults], name
        assert [rig for rig in BUILT_IN if name in RIGS[rig].every_fault], name
    assert {rig: RIGS[rig].tests for rig in BUILT_IN if not RIGS[rig].tests} == {}


def test_a_size_is_read_with_its_unit() -> None:
    assert parse_fault("run_gain=5 %", FAULTS) == ("run_gain", 5.0)
    assert parse_fault("run_gain", FAULTS) == ("run_gain", 2.0)
    assert parse_fault("glitch=10", FAULTS) == parse_fault("glitch = 10 sigma", FAULTS) == ("glitch", 10.0)
    assert parse_fault("dwell_off=0.1 rad/s", FAULTS)[1] == pytest.approx(math.degrees(0.1))
    assert parse_fault("copies", FAULTS) == ("copies", None)


@pytest.mark.parametrize(
    ("typed", "what"),
    [
        ("glich", r"no fault 'glich'\. Did you mean glitch\? There are: glitch, spikes"),
        ("run_gain=5", r"fault run_gain: '5' is not a size \[%\]\. Say, for example: run_gain=2 %"),
        ("run_gain=5 deg", r"'5 deg' is not a size \[%\]"),
        ("glitch=much", r"'much' is not a size \[sigma\]"),
        ("glitch=nan", r"'nan' is not a size"),
        ("glitch=1", r"fault glitch: 1 sigma, need at least 5 sigma"),
        ("saturation=95 %", r"95 %, need at least 0 % and at most 90 %"),
        ("copies=3", r"fault copies has no size, but '3' is given\. Say: copies"),
    ],
)
def test_a_wrong_size_is_one_clear_error(typed: str, what: str) -> None:
    with pytest.raises(UsageError, match=what):
        parse_fault(typed, FAULTS)


def column(twin: Twin, file: str, name: str) -> np.ndarray:
    return np.asarray(twin.recordings[file].channel(name).data, dtype=float)


def test_a_run_of_the_wrong_sign_or_unit_is_that_of_the_sensors_about_their_reference() -> None:
    for name, factor in (("run_sign", -1.0), ("run_in_rad_s", np.pi / 180.0), ("run_gain", 1.02)):
        bad = with_fault(TURNED, name)
        assert len(bad.spoiled) == 3
        (file,) = {f"recordings/{one}.csv" for one in bad.spoiled if one.startswith("y")}
        good_x, bad_x = (column(twin, file, "x") - column(twin, file, "x_ref") for twin in (TURNED, bad))
        assert np.allclose(bad_x, factor * good_x, atol=1.0 / 200.0)


def test_saturation_holds_the_part_of_the_samples_that_is_said() -> None:
    bad = with_fault(STILL, "saturation", 10.0)
    (name,) = bad.spoiled
    file = f"recordings/{name}.csv"
    held = [
        np.mean((values == values.min()) | (values == values.max()))
        for values in (column(bad, file, axis) for axis in "xyz")
    ]
    assert max(held) == pytest.approx(0.08, abs=0.03)  # a tenth at either end of the record is not looked at


def test_face_errors_turn_gravity_and_keep_its_size() -> None:
    bad = with_fault(FACES, "face_error", 3.0)
    file = "recordings/hand1.csv"
    good_g, bad_g = (twin.recordings[file].array(["acc_x", "acc_y", "acc_z"]) for twin in (FACES, bad))
    truth = {(one.quantity, one.axis): one.value for one in FACES.truth if one.sensor == "accelerometer"}
    matrix = np.eye(3) + np.diag([truth["scale_factor_error", axis] for axis in "xyz"])
    for i, axis in enumerate("xyz"):
        for j, other in enumerate("xyz"):
            matrix[i, j] = matrix[i, j] if i == j else truth["misalignment", axis + other] * matrix[i, i]
    bias = [truth["bias", axis] for axis in "xyz"]
    good_g, bad_g = ((one - bias) @ np.linalg.inv(matrix).T for one in (good_g, bad_g))
    assert np.allclose(np.linalg.norm(good_g, axis=1), np.linalg.norm(bad_g, axis=1))
    cosine = np.sum(good_g * bad_g, axis=1) / np.sum(good_g**2, axis=1)
    angles = np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))
    assert 1.0 < np.max(angles) < 15.0


def test_drift_of_the_moved_mass_is_the_same_in_every_run() -> None:
    bad = with_fault(MOVED, "repeating_exponential")
    first = [
        column(bad, file, "pulses")[0] - column(MOVED, file, "pulses")[0]
        for file in ("recordings/run1.csv", "recordings/run4.csv")
    ]
    assert first[0] == first[1] > 1000.0


def test_zero_uncertainty_and_grouped_digits_are_in_the_text() -> None:
    assert 'rate = { u = "0 %", certificate' in with_fault(TURNED, "zero_uncertainty").campaign
    (text,) = with_fault(MOVED, "grouped_digits").texts.values()
    assert text("unix_s,pulses,tilt_rad\n1,17361,0.5\n") == 'unix_s;pulses;tilt_rad\n1;"17,361";0.5\n'


def test_a_rig_gives_a_fault_by_name_and_size() -> None:
    twin = still_gyro.RIG.twin(3, "stuck_codes=50")
    assert (twin.fault, twin.size, twin.seed) == ("stuck_codes", "50 samples", 3)
    (name,) = twin.spoiled
    runs = [np.diff(column(twin, f"recordings/{name}.csv", axis)) == 0.0 for axis in "xyz"]
    assert max(map(longest, runs)) in range(49, 53)


def longest(flags: np.ndarray) -> int:
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flags.astype(int), [0]])))
    return int(np.max(edges[1::2] - edges[::2], initial=0))

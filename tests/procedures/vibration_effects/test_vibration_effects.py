"""Rectification, response and noise under vibration: closed form of a quadratic sensor, coverage, what breaks it."""

from __future__ import annotations

import json
import math
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from independent.case import csv_text
from independent.coverage import keeps
from independent.shaking.quadratic import FAST, G, Shaken, record
from independent.trial import called
from inertialcal.core.estimate import Array
from inertialcal.core.results import Row
from inertialcal.procedures.vibration_effects.plan import Plan
from inertialcal.procedures.vibration_effects.readings import Readings, Vibrated
from inertialcal.procedures.vibration_effects.rectification import Point, rectified
from inertialcal.procedures.vibration_effects.reduction import Result, disagreements, reduce
from inertialcal.procedures.vibration_effects.segments import segments_of
from inertialcal.procedures.vibration_effects.spectra import summed

SHORT = Shaken(seconds=8.0)
REPEATED = replace(SHORT, levels=(0.0, 15.0, 0.0, 30.0, 0.0, 15.0, 0.0, 30.0, 0.0))
HARDER = (
    replace(SHORT, low_pass=40.0),
    replace(SHORT, hum=5e-5),
    replace(REPEATED, drift=3e-6),
    replace(REPEATED, bend=1e-4),
)
QUADRATIC, RESPONSE, RATIO = "vibration_rectification", "vibration_sensitivity", "vibration_noise_ratio"


def run_of(seed: int, truth: Shaken, rms: bool = False) -> Vibrated:
    table = record(seed, truth)
    reading, control = table.columns[table.signals[0]], table.columns["control [g]"] * G
    return Vibrated({"x": reading}, np.abs(control) if rms else control, 1.0 / truth.rate, rms, "z", "r", "r.csv")


def result_of(seed: int, truth: Shaken, plan: Plan | None = None) -> Result:
    return reduce(plan or Plan(), Readings((run_of(seed, truth),), "rad/s"))


def rows_of(result: Result, quantity: str) -> list[Row]:
    return [row for row in result.rows() if row.quantity == quantity]


def codes(result: Result) -> set[str]:
    return {one.code for one in result.remarks}


def holds(row: Row, true: float) -> bool:
    assert row.interval is not None
    return (row.interval.lo or -math.inf) <= true <= (math.inf if row.interval.hi is None else row.interval.hi)


def true_gain(truth: Shaken, middle: float) -> float:
    """Root mean square of k1 |H| over the part of a band that vibrates, by the impulse response of the simulator."""
    fast = FAST * truth.rate
    lag = np.exp(-np.arange(round(0.02 * fast)) * 2.0 * np.pi * 120.0 / fast)
    ends = max(middle / 2.0 ** (1.0 / 6.0), truth.band[0]), min(middle * 2.0 ** (1.0 / 6.0), truth.band[1])
    f = np.linspace(*ends, 200)
    H = np.exp(-2j * np.pi * np.outer(f, np.arange(len(lag))) / fast) @ (lag / lag.sum())
    if truth.low_pass:
        kernel = np.exp(-np.arange(round(3.0 / truth.low_pass * fast)) * 2.0 * np.pi * truth.low_pass / fast)
        H = H * (np.exp(-2j * np.pi * np.outer(f, np.arange(len(kernel))) / fast) @ (kernel / kernel.sum()))
    return truth.k1 * float(np.sqrt(np.mean(np.abs(H) ** 2)))


def covered(n: int, truth: Shaken) -> tuple[Counter[str], Counter[str]]:
    """Return hits and counts of intervals, by quantity."""
    hits: Counter[str] = Counter()
    counts: Counter[str] = Counter()
    for seed in range(1, n + 1):
        result = result_of(seed, truth)
        noise = math.hypot(truth.white, truth.growth * max(truth.levels)) / truth.white
        for row in result.rows():
            if row.quantity == QUADRATIC:
                true = truth.k2
            elif row.quantity == RESPONSE and row.status == "estimated" and row.key.at is not None:
                true = true_gain(truth, row.key.at.value)
            elif row.quantity == RATIO and not truth.k2:
                true = noise
            else:
                continue
            counts[row.quantity] += 1
            hits[row.quantity] += holds(row, true)
    return hits, counts


@pytest.mark.parametrize(
    "truth",
    [
        SHORT,
        replace(SHORT, wander=2e-5, levels=(0.0, 15.0, 0.0, 30.0, 0.0, 15.0, 0.0, 30.0, 0.0)),
        replace(SHORT, k2=0.0, growth=5e-6),
        *HARDER,
    ],
    ids=["quadratic", "wandering bias", "growing noise", "low pass", "hum", "drift", "bend"],
)
def test_intervals_hold_the_truth(truth: Shaken) -> None:
    hits, counts = covered(30, truth)
    assert counts[QUADRATIC] == 30
    assert counts[RESPONSE] > (60 if not truth.low_pass else 30)  # a low pass leaves less to be found
    assert all(keeps("holds", hits[name], counts[name]) for name in counts), (hits, counts)


@pytest.mark.slow
@pytest.mark.parametrize(
    "truth",
    [SHORT, replace(SHORT, k2=0.0, growth=5e-6), *HARDER],
    ids=["quadratic", "growing noise", "low pass", "hum", "drift", "bend"],
)
def test_intervals_hold_the_truth_in_300(truth: Shaken) -> None:
    hits, counts = covered(300, truth)
    assert all(keeps("holds", hits[name], counts[name]) for name in counts), (hits, counts)


def test_axes_whose_noise_is_shared_hold_their_own_truth() -> None:
    hits = 0
    for seed in range(1, 21):
        run, rng = run_of(seed, SHORT), np.random.default_rng([77, seed])
        shared = 1e-4 * rng.standard_normal(len(run.control))
        other = 0.5 * run.axes["x"] + shared + 5e-5 * rng.standard_normal(len(shared))
        both = reduce(Plan(), Readings((replace(run, axes={"x": run.axes["x"] + shared, "y": other}),), "rad/s"))
        one, two = rows_of(both, QUADRATIC)
        hits += holds(one, SHORT.k2) + holds(two, 0.5 * SHORT.k2)
    assert keeps("holds", hits, 40)


def test_a_quadratic_sensor_has_its_coefficient_whatever_the_level() -> None:
    """Closed form: the mean of k2 a^2 is k2 a_rms^2; here without noise, so that K is k2 to the accuracy of a block."""
    points = [Point(0, float(t), a**2, 1e-3 + 1e-6 * t + 2e-7 * a**2, 1e-18, int(a > 0.0))
              for t, a in enumerate((0.0, 10.0, 20.0, 30.0, 5.0, 0.0))]  # fmt: skip
    found = rectified(points, drift=True)
    assert found.value == pytest.approx(2e-7, rel=1e-6)
    assert found.dof == 3.0
    assert not found.curved


def test_a_mean_that_does_not_follow_the_square_is_said() -> None:
    rng = np.random.default_rng(1)
    levels = (0.0, 10.0, 20.0, 30.0, 40.0, 0.0, 30.0, 10.0, 0.0)
    points = [Point(0, float(t), a**2, 1e-9 * a**4 + 1e-6 * rng.standard_normal(), 1e-12, int(a / 10.0))
              for t, a in enumerate(levels)]  # fmt: skip
    found = rectified(points, drift=True)
    assert found.curved
    assert found.curvature is not None
    value, u, dof = found.curvature
    assert abs(value - 1e-9) < stats.t.ppf(0.9995, dof) * u


# ---- what breaks it ------------------------------------------------------------------------------------------------


def test_a_bias_that_drifts_between_levels_is_allowed_for() -> None:
    hits, counts = covered(15, replace(SHORT, drift=3e-6))
    assert keeps("holds", hits[QUADRATIC], counts[QUADRATIC])


def test_a_shift_at_the_first_vibration_is_covered_or_said() -> None:
    """The bias stays shifted: an even drift cannot take that up, so that segments scatter and the interval widens."""
    truth = replace(SHORT, shift=1e-4)
    found = [result_of(seed, truth) for seed in range(1, 11)]
    rows = [rows_of(one, QUADRATIC)[0] for one in found]
    plain = rows_of(result_of(1, SHORT), QUADRATIC)[0]
    assert all(holds(row, truth.k2) or "uneven_drift" in codes(one) for row, one in zip(rows, found, strict=True))
    assert all((row.u or 0.0) > 5.0 * (plain.u or 1.0) for row in rows)


def test_a_range_that_is_reached_gives_no_figure() -> None:
    result = result_of(1, replace(SHORT, bias=0.0, growth=5e-6, limit=2.5e-4))
    row = rows_of(result, QUADRATIC)[0]
    assert (row.status, row.reason.code) == ("not_estimated", "clipped")
    assert "clipped" in codes(result)
    assert not rows_of(result, RESPONSE)[0].interval


def test_vibration_up_to_half_the_sample_rate_is_said_to_fold() -> None:
    folded = replace(SHORT, band=(20.0, 700.0), filtered=False)
    assert "aliasing" in codes(result_of(1, folded))
    assert "aliasing" not in codes(result_of(1, SHORT))
    # Folding keeps the mean square of what was sampled, and the mean of the reading: K still holds
    assert holds(rows_of(result_of(1, folded), QUADRATIC)[0], folded.k2)


@pytest.mark.parametrize(
    ("levels", "code"),
    [((0.0, 10.0, 20.0), "no_rest"), ((10.0, 20.0, 0.0), "no_rest"), ((0.0, 20.0, 0.0), "few_segments")],
)
def test_what_cannot_be_told_says_why(levels: tuple[float, ...], code: str) -> None:
    row = rows_of(result_of(1, replace(SHORT, levels=levels)), QUADRATIC)[0]
    assert (row.status, row.reason.code, row.value) == ("not_estimated", code, None)


def test_one_level_alone_is_said() -> None:
    result = result_of(1, replace(SHORT, levels=(0.0, 20.0, 0.0, 20.0, 0.0)))
    assert "one_level" in codes(result)
    assert rows_of(result, QUADRATIC)[0].status == "estimated"


def test_a_logged_level_has_no_phase() -> None:
    run = run_of(1, SHORT)
    size = round(1.0 / run.interval)
    parts = run.control[: len(run.control) // size * size].reshape(-1, size)
    logged = np.repeat(np.sqrt(np.mean(parts**2, axis=1)), size)
    short = replace(run, axes={"x": run.axes["x"][: len(logged)]}, control=logged, rms=True)
    result = reduce(Plan(), Readings((short,), "rad/s"))
    assert rows_of(result, QUADRATIC)[0].value == pytest.approx(
        rows_of(result_of(1, SHORT), QUADRATIC)[0].value, rel=0.02
    )
    assert rows_of(result, RESPONSE)[0].reason.code == "no_waveform"


def test_bands_without_a_response_are_upper_limits_in_nearly_all_records() -> None:
    """95 % for all bands together: where there is no response, none stands out in 95 of 100 records."""
    none = replace(SHORT, k1=0.0, k2=0.0)
    false = sum(
        any(row.status == "estimated" for row in rows_of(result_of(seed, none), RESPONSE)) for seed in range(30)
    )
    assert stats.binom.sf(false - 1, 30, 0.05) > 0.001


def from_columns(**columns: Array) -> Readings:
    """One run of an accelerometer vibrated along x: its columns, and the control."""
    axes = {name: values for name, values in columns.items() if name != "control"}
    return Readings((Vibrated(axes, columns["control"], 1.0 / 400.0, False, "x", "r", "r.csv", unit="m/s^2"),), "m/s^2")


def test_control_and_gyro_that_have_changed_places_are_named() -> None:
    for seed in range(1, 11):
        sound, wrong = run_of(seed, SHORT), run_of(seed, SHORT)
        wrong = replace(wrong, axes={"x": sound.control}, control=sound.axes["x"])
        assert not disagreements(Plan(), Readings((sound,), "rad/s"))
        assert [one.code for one in disagreements(Plan(), Readings((wrong,), "rad/s"))] == ["swapped_channels"]
    logged = replace(run_of(1, SHORT), control=run_of(1, SHORT).axes["x"] - SHORT.bias, rms=True)
    assert [one.code for one in disagreements(Plan(), Readings((logged,), "rad/s"))] == ["swapped_channels"]


def test_axes_of_an_accelerometer_that_have_changed_places_are_named() -> None:
    table, rng = record(1, SHORT).columns["control [g]"] * G, np.random.default_rng(2)
    along, across, third = (part * table + 5e-3 * rng.standard_normal(len(table)) for part in (1.02, 0.03, -0.02))
    assert not disagreements(Plan(), from_columns(control=table, x=along, y=across, z=third))
    for columns, code in (
        ({"control": table, "x": across, "y": along, "z": third}, "axes_disagree"),
        ({"control": across, "x": along, "y": table, "z": third}, "swapped_channels"),
    ):
        assert [one.code for one in disagreements(Plan(), from_columns(**columns))] == [code]


def test_axes_that_change_places_within_a_test_are_named() -> None:
    one = replace(run_of(1, SHORT), name="first")
    axes = {axis: one.axes["x"] + off for axis, off in (("x", 0.0), ("y", 3e-3), ("z", -8e-3))}
    one = replace(one, axes=axes)
    again = replace(one, name="second", axes={axis: values + 2e-5 for axis, values in axes.items()})
    mixed = replace(again, axes={"x": again.axes["y"], "y": again.axes["x"], "z": again.axes["z"]})
    assert not disagreements(Plan(), Readings((one, again), "rad/s"))
    (said,) = disagreements(Plan(), Readings((one, mixed), "rad/s"))
    assert (said.code, said.recording) == ("axes_disagree", "second")
    assert "x where y was, y where x was" in said.what


# ---- parts ---------------------------------------------------------------------------------------------------------


def test_missing_samples_cost_their_blocks_alone() -> None:
    run = run_of(1, SHORT)
    whole = reduce(Plan(), Readings((run,), "rad/s"))
    x = run.axes["x"].copy()
    x[[len(x) // 3, len(x) // 2]] = np.nan
    found = reduce(Plan(), Readings((replace(run, axes={"x": x}),), "rad/s"))
    assert codes(found) - codes(whole) == {"gaps"}
    (one,), (other,) = (rows_of(result, QUADRATIC) for result in (found, whole))
    assert one.value == pytest.approx(other.value, abs=other.u or 0.0)
    assert len(rows_of(found, RESPONSE)) == len(rows_of(whole, RESPONSE))


@pytest.mark.parametrize("share", [0.0001, 0.03])
def test_missing_samples_of_the_control_are_counted_and_left_out(share: float) -> None:
    """The control is known from what is left; coverage of the coefficient of a simulator that never saw the loss."""
    hits = 0
    for seed in range(1, 11):
        run = run_of(seed, SHORT)
        lost = np.random.default_rng(seed).random(len(run.control)) < share
        lost[3000:3600] = True  # and a block and a half at once
        result = reduce(Plan(), Readings((replace(run, control=np.where(lost, np.nan, run.control)),), "rad/s"))
        (gaps,) = [one for one in result.remarks if one.code == "gaps"]
        assert (gaps.count, "of the control" in gaps.what) == (int(lost.sum()), True)
        hits += holds(rows_of(result, QUADRATIC)[0], SHORT.k2)
        reason = rows_of(result, RESPONSE)[0].reason.code
        assert (reason == "gaps") == (share == 0.03), reason
    assert keeps("holds", hits, 10)


def test_a_gap_of_time_is_worked_around(tmp_path: Path) -> None:
    table = record(1, SHORT)
    kept = np.ones(len(table.columns["control [g]"]), dtype=bool)
    kept[5000:5100] = kept[9001] = False
    table.columns = {name: values[kept] for name, values in table.columns.items()}
    (tmp_path / "lossy.csv").write_text(csv_text(table))
    found = called(["vibration", "effects", str(tmp_path / "lossy.csv"), "--axis", "z"], tmp_path)
    assert found.exit == 0
    assert any(code == "gaps" and "101 samples of the control" in text for code, text in found.said)
    (row,) = [one for one in found.rows if one["quantity"] == QUADRATIC]
    factor = math.degrees(1.0) * 3600.0 * G**2
    assert row["interval"]["lo"] < factor * SHORT.k2 < row["interval"]["hi"]


def test_a_control_of_which_most_is_missing_is_refused(tmp_path: Path) -> None:
    table = record(1, SHORT)
    table.columns["control [g]"][:12_000] = np.nan
    (tmp_path / "lossy.csv").write_text(csv_text(table))
    found = called(["vibration", "effects", str(tmp_path / "lossy.csv")], tmp_path)
    assert found.exit == 3
    assert "12000 of 16000 samples of the control are missing" in found.printed


def test_levels_are_found_and_blocks_at_changes_left_out() -> None:
    squares = np.concatenate([np.full(10, 1e-6), np.full(12, 100.0), np.full(8, 400.0), np.full(9, 1e-6)])
    found, lost = segments_of(squares, 0.1)
    assert [(one.first, one.stop, one.rest, one.level) for one in found] == [
        (0, 9, True, 0), (11, 21, False, 1), (23, 29, False, 2), (31, 39, True, 0),
    ]  # fmt: skip
    assert lost == 0
    wild = 10.0 ** np.resize([0.0, 3.0, 1.0, 4.0], 15)
    assert segments_of(wild, 0.1) == ([], 15)


def test_density_is_that_of_white_noise() -> None:
    """Parseval: white noise of variance 1 sampled at 100 Hz has a one-sided density of 2 / 100 per Hz."""
    x: Array = np.random.default_rng(1).standard_normal(60_000)
    found = summed([(x, x)], 0.01, 200)
    assert found is not None
    assert float(np.mean(found.yy)) == pytest.approx(0.02, rel=0.03)
    assert summed([(x[:300], x[:300])], 0.01, 200) is None


def test_the_command_finds_the_control_and_a_campaign_judges(tmp_path: Path) -> None:
    (tmp_path / "shaken.csv").write_text(csv_text(record(1, SHORT)))
    found = called(["vibration", "effects", str(tmp_path / "shaken.csv"), "--axis", "z"], tmp_path)
    rows = {row["quantity"]: row for row in found.rows if row["at"] is None}
    assert found.exit == 0
    assert (rows[QUADRATIC]["axis"], rows[QUADRATIC]["unit"]) == ("xz", "deg/h/g^2")
    factor = math.degrees(1.0) * 3600.0 * G**2
    assert rows[QUADRATIC]["interval"]["lo"] < factor * SHORT.k2 < rows[QUADRATIC]["interval"]["hi"]
    assert rows["control_rms"]["value"] == pytest.approx(30.0 / G, rel=0.05)  # the part that was kept has its own
    (tmp_path / "campaign.toml").write_text(
        'schema = 2\n[campaign]\nid = "shaken"\n[sensors.gyro]\nkind = "gyro"\naxes = ["x"]\nunit = "rad/s"\n'
        '[recordings.run]\nsensor = "gyro"\nfile = "shaken.csv"\naxis = "z"\nclock = { column = "time [s]" }\n'
        "[recordings.run.channels]\n"
        'x = { column = "gyro_x [rad/s]", unit = "rad/s" }\ncontrol = { column = "control [g]", unit = "g" }\n'
        '[[tests]]\nid = "z"\nprocedure = "vibration_effects"\nrecordings = ["run"]\n'
        '[[requirements]]\nid = "V"\nquantity = "vibration_rectification"\nlimit = "10 deg/h/g^2"\n'
    )
    assert called(["run", str(tmp_path)], tmp_path).exit == 0
    results = json.loads((tmp_path / "out/results.json").read_text())
    assert [one["verdict"] for one in results["verdicts"]] == ["PASS"]


def test_a_file_without_a_control_is_refused(tmp_path: Path) -> None:
    table = record(1, SHORT)
    del table.columns["control [g]"]
    (tmp_path / "shaken.csv").write_text(csv_text(table))
    found = called(["vibration", "effects", str(tmp_path / "shaken.csv")], tmp_path)
    assert found.exit == 2
    assert "cannot tell which column is the acceleration of the control" in found.printed + str(found.said)

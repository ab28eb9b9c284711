"""Acceleration environment: closed forms, coverage, peaks that stay, what breaks it."""

from __future__ import annotations

import math
import os
import shutil
from collections import Counter
from collections.abc import Sequence
from functools import cache
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import welch
from scipy.stats import t as student

import inertialcal as ic
from independent.coverage import keeps
from independent.orbit.environment import UG, Recorded, Station, recorded
from inertialcal.core.errors import DataError
from inertialcal.core.estimate import Component, Estimate
from inertialcal.core.key import Key, Origin
from inertialcal.core.recording import Channel, Recording
from inertialcal.procedures.corrections import BiasCorrection
from inertialcal.procedures.microgravity.bands import BANDS, Band, share, variance
from inertialcal.procedures.microgravity.curve_file import read_requirement
from inertialcal.procedures.microgravity.plan import Plan
from inertialcal.procedures.microgravity.readings import Readings, Track, readings_from
from inertialcal.procedures.microgravity.reduction import Result, reduce
from inertialcal.procedures.microgravity.rows import size_interval
from inertialcal.procedures.protocol import Facts

Array = NDArray[np.float64]
AXES = "xyz"
CURVE = "frequency [Hz],rms [ug]\n0.01,1.6\n0.1,1.6\n100,1600\n300,1600\n"


def track(values: Array, rate: float, cut_off: float | None = 8.0, gaps: tuple[int, ...] = ()) -> Track:
    """Return samples, shape (n, 3), as one record; a gap of 50 s before each sample that is named."""
    edges = [0, *gaps, len(values)]
    stretches = tuple(pairwise(edges))
    starts = tuple(first / rate + 50.0 * i for i, (first, _) in enumerate(stretches))
    return Track(tuple(values.T), tuple(AXES), stretches, starts, 1.0 / rate, "one", "one.csv", cut_off)


def reduced(values: Array, rate: float = 20.0, gaps: tuple[int, ...] = (), **settings: Any) -> Result:
    return reduce(Plan(**settings), Readings((track(values, rate, gaps=gaps),)))


def known_bias(made: Recorded) -> dict[str, Any]:
    said: dict[str, Any] = {f"bias_{axis}": value * UG for axis, value in zip(AXES, made.station.bias, strict=True)}
    return said | {"bias_u": made.station.bias_u * UG}


def codes(result: Result) -> set[str]:
    return {one.code for one in result.remarks} - {"relative_to_sensor"}


# ---- bands -------------------------------------------------------------------------------------------------------


def test_bands_are_those_of_base_ten() -> None:
    """IEC 61260-1: nominal frequencies of the octaves around 1 Hz, edges of the band at 1 Hz, neighbours touch."""
    assert [one.nominal for one in BANDS[17:27]] == [0.5, 0.63, 0.8, 1.0, 1.25, 1.6, 2.0, 2.5, 3.15, 4.0]
    assert (Band(0).low, Band(0).high) == pytest.approx((0.891251, 1.122018), abs=1e-6)
    assert [a.high for a in BANDS[:-1]] == pytest.approx([b.low for b in BANDS[1:]])
    assert (BANDS[0].nominal, BANDS[-1].nominal) == (0.01, 1000.0)


def test_a_sine_has_its_power_in_its_band_and_nowhere_else() -> None:
    time = np.arange(20_000) / 20.0
    x = np.zeros((20_000, 3))
    x[:, 0] = 30.0 * UG * np.sin(2.0 * math.pi * 2.0 * time)
    x[:, 1:] = np.random.default_rng(1).normal(0.0, 1e-3 * UG, (20_000, 2))
    found = reduced(x)
    levels = {one.nominal: found.power("x", one).rms for one in found.bands}
    assert levels[2.0] == pytest.approx(30.0 * UG / math.sqrt(2.0), rel=1e-6)
    assert max(level for f, level in levels.items() if f != 2.0) < 1e-4 * levels[2.0]


def test_powers_add_up_and_are_those_of_another_program() -> None:
    """Bands side by side add to the whole, and lines are those of scipy's averaged periodogram."""
    made = recorded(np.random.default_rng(2))
    found = reduced(made.values)
    whole = sum(found.power("y", one).power for one in found.bands)
    assert whole == pytest.approx(found.powers["y", "all"].power, rel=1e-12)
    f, density = welch(made.values[:, 1], 20.0, "hann", 2000, 1000, detrend="linear")
    assert found.found.lines[1:-1, 1] == pytest.approx(density[1:-1] * (f[1] - f[0]), rel=1e-9)
    weights = share(found.bands[0].low, found.bands[-1].high, len(f), f[1])
    assert float(weights @ found.found.lines[:, 1]) == pytest.approx(whole, rel=1e-9)
    cells = np.array(found.found.cells).mean(axis=0).sum(axis=0)
    top = share(-0.5 * f[1], found.cut.top, len(f), f[1]) @ found.found.lines
    assert cells == pytest.approx(top, rel=1e-9)


def test_scatter_of_white_noise_is_what_the_variance_says() -> None:
    rng, n = np.random.default_rng(3), 256
    drawn = []
    weights = share(4.2, 9.7, n // 2 + 1, 1.0)
    for _ in range(1500):
        lines = welch(rng.normal(size=4 * n), float(n), "hann", n, n // 2, detrend=False)[1]
        drawn.append(float(weights @ lines))
    stated = variance(weights, np.full(n // 2 + 1, (2.0 / n) ** 2), 7, 6) * (1.0 + 1.0 / 7.0)  # of true powers
    assert np.var(drawn) == pytest.approx(stated, rel=0.15)


def test_bands_that_cannot_be_told_are_left_out_with_the_reason() -> None:
    found = reduced(recorded(np.random.default_rng(4)).values)
    left = {one.nominal: why for one, why in found.left}
    assert left[0.063] == "narrower than the resolution"
    assert left[8.0] == "above the pass band"
    assert found.bands[0].nominal == 0.08
    assert found.bands[-1].nominal == 6.3


# ---- coverage ----------------------------------------------------------------------------------------------------


@cache
def _truths(axis: int) -> tuple[float, ...]:
    """Return powers of bands of the standard station, and of all of them, of an axis."""
    made = recorded(np.random.default_rng(1))
    bands = [one for one in BANDS if 0.08 <= one.nominal <= 6.3]
    own = [made.power(axis, one.low, one.high) for one in bands]
    return (*own, sum(own))


def _hits(seed: int, station: Station | None = None, gaps: tuple[int, ...] = ()) -> Counter[str]:
    """Return which 95 % intervals hold the truth, by what they are of."""
    made = recorded(np.random.default_rng(seed), station)
    found = reduced(made.values, gaps=gaps, **known_bias(made))
    hits: Counter[str] = Counter()
    for i, axis in enumerate((*AXES, "rss")):
        truths = np.sum([_truths(k) for k in range(3)], axis=0) if axis == "rss" else np.array(_truths(i))
        powers = [*(found.power(axis, one) for one in found.bands), found.powers[axis, "all"]]
        for name, at in (("low", 2), ("middle", 9), ("whole", -1)):
            ends = powers[at].interval(0.95)
            hits[f"{name} {axis}"] += int((ends.lo or 0.0) <= math.sqrt(truths[at]) <= (ends.hi or 0.0))
    estimate = found.estimate
    assert estimate is not None
    for i, axis in enumerate(AXES):
        off = abs(float(estimate.values[i]) - float(made.slow[i]))
        hits[f"slow {axis}"] += int(off <= student.ppf(0.975, estimate.dof[i]) * estimate.u[i])
    ends = size_interval(found, "quasi_steady_magnitude", 0.95)
    n = found.cut.block
    turns = made.slow_part[: len(made.time) // n * n].reshape(-1, n, 3).mean(axis=1)
    largest = float(np.max(np.linalg.norm(turns, axis=1)))
    hits["magnitude"] += int((ends.lo or 0.0) <= largest <= (ends.hi or 0.0))
    return hits


@pytest.mark.parametrize(("n", "gaps"), [(40, ()), pytest.param(300, (13_000,), marks=pytest.mark.slow)])
def test_intervals_hold_the_truth(n: int, gaps: tuple[int, ...]) -> None:
    hits: Counter[str] = Counter()
    for seed in range(1, n + 1):
        hits += _hits(seed, gaps=gaps)
    assert len(hits) == 16
    for name, count in hits.items():
        assert keeps("interval", count, n), f"{name}: {count} of {n}"


def _orbiting(seed: int, amplitudes: Sequence[float], noise: float, u_bias: float) -> tuple[Result, Array]:
    """Two orbits of slow acceleration, each axis with an amplitude and a phase of its own; and its slow part [ug]."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 12_000.0, 0.5)
    waves = [a * np.sin(2.0 * np.pi * t / 5556.0 + rng.uniform(0.0, 2.0 * np.pi)) for a in amplitudes]
    part = np.array([0.4, -0.3, 0.8]) + np.column_stack(waves)
    read = part + rng.normal(0.0, u_bias, 3) + rng.normal(0.0, noise, part.shape)
    plan = Plan(bias_x=0.0, bias_y=0.0, bias_z=0.0, bias_u=u_bias * UG, orbit=5556.0)
    return reduce(plan, Readings((track(read * UG, 2.0, cut_off=0.8),))), part


@pytest.mark.parametrize("n", [25, pytest.param(150, marks=pytest.mark.slow)])
@pytest.mark.parametrize(("amplitudes", "noise"), [((1.0, 0.0, 0.1), 10.0), ((1.5, 1.5, 0.3), 0.5)])
def test_amplitude_of_the_orbit_and_part_across_the_mean_hold_the_truth(
    amplitudes: tuple[float, ...], noise: float, n: int
) -> None:
    """Noise alone has an amplitude, and the bias turns the mean: 80 % held before both were counted."""
    hits: Counter[str] = Counter()
    for seed in range(1, n + 1):
        found, part = _orbiting(seed, amplitudes, noise, 0.2)
        rows = {(row.key.quantity, row.key.axis): row for row in found.rows()}
        for axis, true in zip(AXES, amplitudes, strict=True):
            ends = rows["orbital_amplitude", axis].interval
            assert ends is not None
            hits[axis] += int((ends.lo or 0.0) <= true * UG <= (ends.hi or 0.0))
        blocks, mean = part.reshape(-1, 200, 3).mean(axis=1), part.mean(axis=0)
        along = mean / np.linalg.norm(mean)
        true = float(np.max(np.linalg.norm(blocks - np.outer(blocks @ along, along), axis=1))) * UG
        across = rows["quasi_steady_perpendicular", ""]
        if across.interval is None:  # the mean points nowhere for certain
            assert across.reason.code == "no_direction"
            hits["across"] += 1
        else:
            hits["across"] += int((across.interval.lo or 0.0) <= true <= (across.interval.hi or 0.0))
    for name, count in hits.items():
        assert keeps("interval", count, n), f"{name}: {count} of {n}"


# ---- slow acceleration ---------------------------------------------------------------------------------------------


def test_the_orbit_is_found_and_its_part_told() -> None:
    made = recorded(np.random.default_rng(5), Station(seconds=20_000.0, rate=8.0, orbital=0.6, tones=()))
    found = reduced(made.values, rate=8.0, **known_bias(made))
    assert found.orbit is not None
    assert found.orbit.period == pytest.approx(5556.0, abs=4.0 * (found.orbit.u_period or 0.0))
    assert np.all(np.abs(found.orbit.amplitude - 0.6 * UG) < 4.0 * found.orbit.u)
    assert len(found.orbit.means) == 3


def test_turned_into_axes_of_the_station() -> None:
    made = recorded(np.random.default_rng(6))
    own = reduced(made.values, **known_bias(made)).estimate
    turned = reduced(made.values, yaw=math.radians(-90.0), **known_bias(made)).estimate
    assert own is not None
    assert turned is not None
    assert turned.values == pytest.approx([own.values[1], -own.values[0], own.values[2]])
    assert turned.u == pytest.approx([own.u[1], own.u[0], own.u[2]])


def test_without_a_bias_the_slow_acceleration_is_not_estimated() -> None:
    found = reduced(recorded(np.random.default_rng(7)).values)
    assert "bias_unknown" in codes(found)
    rows = {row.key.quantity: row for row in found.rows()}
    assert rows["quasi_steady_magnitude"].status == "not_estimated"
    assert rows["interval_mean"].status == "estimated"


def test_a_step_of_vibration_does_not_move_the_trimmed_mean() -> None:
    made = recorded(np.random.default_rng(8))
    hit = made.values.copy()
    hit[10_900:11_000] += 3000.0 * UG
    ends = [reduced(x, trim=trim, **known_bias(made)).trend for x in (made.values, hit) for trim in (0.0, 0.1)]
    plain, trimmed, moved, kept = (one.values[5, 0] for one in ends if one is not None)
    assert abs(moved - plain) > 100.0 * UG
    assert abs(kept - trimmed) < 6.0 * UG


# ---- the display -------------------------------------------------------------------------------------------------


def test_no_peak_is_lost_where_intervals_are_joined() -> None:
    x = np.random.default_rng(9).normal(0.0, 5.0 * UG, (200_000, 3))
    x[123_457, 1] = 900.0 * UG
    found = reduced(x, interval=1.0)
    curve = next(one for one in found.curves() if one.name == "microgravity_intervals" and one.axis == "y")
    assert len(curve.columns["time"].values) <= 600
    assert np.max(np.asarray(curve.columns["largest"].values)) == pytest.approx(900.0 * UG)
    assert "glitches" in codes(found)


def test_intervals_do_not_go_across_a_gap() -> None:
    x = np.random.default_rng(10).normal(0.0, 5.0 * UG, (6_000, 3))
    x[3_000:] += 200.0 * UG
    found = reduced(x, gaps=(3_000,))
    curve = next(one for one in found.curves() if one.name == "microgravity_intervals")
    means = np.asarray(curve.columns["mean"].values)
    assert len(means) == 30
    assert np.max(np.abs(means - np.where(np.arange(30) < 15, 0.0, 200.0 * UG))) < 5.0 * UG
    assert sum(curve.columns["after_gap"].values) == 1
    assert found.found.pairs == found.found.blocks - 2


# ---- what breaks it ----------------------------------------------------------------------------------------------


def refusal(values: Array, **settings: Any) -> str:
    with pytest.raises(DataError) as refused:
        reduced(values, **settings)
    return refused.value.problems[0].code


def test_wrong_units_and_records_on_the_ground_are_refused() -> None:
    made = recorded(np.random.default_rng(11)).values
    assert refusal(made / UG) == "wrong_unit"  # ug taken for m/s^2
    assert refusal(made * 1e-6) == "wrong_unit"
    assert refusal(made + np.array([0.0, 0.0, 9.81])) == "wrong_unit"
    assert refusal(made[:20]) == "too_short"


def test_samples_at_the_end_of_the_range_are_named() -> None:
    made = recorded(np.random.default_rng(12)).values
    assert "saturated" not in codes(reduced(made))
    assert "saturated" not in codes(reduced(np.round(made / UG) * UG))  # a coarse step is no end of a range
    made[:, 1] = np.minimum(made[:, 1], 10.0 * UG)
    assert "saturated" in codes(reduced(made))


def test_glitches_and_missing_samples_leave_blocks_out() -> None:
    clean = recorded(np.random.default_rng(13))
    x = clean.values.copy()
    x[[5_000, 21_111], 0] += 5_000.0 * UG
    x[30_000:30_003, 2] = np.nan
    found = reduced(x)
    assert {"glitches", "blocks_left_out"} <= codes(found)
    assert len(found.found.glitches) == 2
    assert found.powers["x", "all"].rms == pytest.approx(reduced(clean.values).powers["x", "all"].rms, rel=0.1)


def test_a_drift_is_named() -> None:
    x = recorded(np.random.default_rng(14), Station(orbital=0.0)).values
    assert "drifts" not in codes(reduced(x))
    x[:, 2] += np.linspace(0.0, 30.0 * UG, len(x))
    assert "drifts" in codes(reduced(x))


def test_a_level_that_changes_is_known_by_its_blocks() -> None:
    x = recorded(np.random.default_rng(15), Station(tones=())).values
    assert "not_steady" not in codes(reduced(x))
    x[12_000:20_000] *= 5.0
    found = reduced(x)
    assert "not_steady" in codes(found)
    assert found.powers["x", "all"].dof < 20.0


def test_exchanged_axes_change_nothing_of_all_together() -> None:
    x = recorded(np.random.default_rng(16)).values
    own, other = (reduced(one).powers["rss", "all"] for one in (x, x[:, [1, 2, 0]]))
    assert (own.power, own.dof) == pytest.approx((other.power, other.dof))


# ---- files -------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = recorded(np.random.default_rng(17))
    where = tmp_path_factory.mktemp("files")
    made.write(where / "record.csv")
    (where / "curve.csv").write_text(CURVE, encoding="utf-8")
    (where / "bare.csv").write_text("frequency,rms\n1,2\n2,3\n", encoding="utf-8")
    return where


def test_a_curve_is_straight_between_its_nodes(folder: Path) -> None:
    curve = read_requirement(folder / "curve.csv")
    assert curve.at(np.array([0.05, 1.0, 10.0, 200.0])) / UG == pytest.approx([1.6, 16.0, 160.0, 1600.0])
    assert np.isnan(curve.at(np.array([0.005, 400.0]))).all()
    with pytest.raises(DataError) as refused:
        read_requirement(folder / "bare.csv")
    assert refused.value.problems[0].code == "wrong_unit"


def test_verdicts_of_a_file(folder: Path) -> None:
    bias: dict[str, Any] = {f"bias_{axis}": f"{value} ug" for axis, value in zip(AXES, Station().bias, strict=True)}
    found = ic.microgravity(folder / "record.csv", curve=str(folder / "curve.csv"), cut_off="8 Hz", bias_u="0.2 ug",
                            slow_limit="20 ug", perpendicular_limit="0.01 ug", **bias)  # fmt: skip
    said = {one["requirement"]: one["verdict"] for one in found.verdicts}
    assert said == {"curve": "FAIL", "slow_limit": "PASS", "perpendicular_limit": "INCONCLUSIVE"}
    high = folder / "high.csv"
    high.write_text(CURVE.replace("1.6", "160").replace("1600", "160000"), encoding="utf-8")
    (passed,) = ic.microgravity(folder / "record.csv", curve=str(high), cut_off="8 Hz").verdicts
    assert passed["verdict"] == "PASS"


def test_records_that_overlap_or_differ_in_rate_are_refused(folder: Path) -> None:
    made = recorded(np.random.default_rng(18), Station(seconds=400.0))
    made.write(folder / "first.csv")
    other = Recorded(made.station, made.time + 300.0, made.values[::-1], made.slow)
    other.write(folder / "over.csv")
    slower = Recorded(made.station, 1000.0 + made.time * 1.25, 1.3 * made.values, made.slow)
    slower.write(folder / "slower.csv")
    for name, code in (("over.csv", "overlapping_files"), ("slower.csv", "several_clocks")):
        with pytest.raises(DataError) as refused:
            ic.microgravity([folder / "first.csv", folder / name], cut_off="8 Hz")
        assert refused.value.problems[0].code == code


def archived() -> Path:

    found = sorted(Path(os.environ.get("INERTIALCAL_SHARED", "/none")).glob("data/pims_pad/2014*121f03006"))
    if not found:
        pytest.skip("no archive records")
    return found[0]


def test_a_record_of_the_archive(tmp_path: Path) -> None:
    """59 s behind a low pass of 6 Hz: blocks of 10 s, no verdict for 100 s, bias in axes of the sensor only."""
    source = archived()
    for one in (source, source.with_name(source.name + ".header")):
        shutil.copy(one, tmp_path / one.name)
    (tmp_path / "curve.csv").write_text(CURVE, encoding="utf-8")
    found = ic.microgravity(tmp_path / source.name, curve=str(tmp_path / "curve.csv"))
    assert {"short_blocks", "bias_unknown", "bands_not_judged"} <= {one.code for one in found.remarks}
    assert [one["verdict"] for one in found.verdicts] == ["INCONCLUSIVE"]
    x = ic.read(tmp_path / source.name).array(["x", "y", "z"]) * 9.80665
    f, density = welch(x, 142.0, "hann", 1420, 710, detrend="linear", axis=0)
    level = {row.key.axis: row.value for row in found.result.rows() if row.key.quantity == "vibratory_rms"}
    bands = found.result.bands
    weights = share(bands[0].low, bands[-1].high, len(f), f[1])
    own = np.sqrt(weights @ density * f[1])
    assert [level[axis] for axis in AXES] == pytest.approx(own.tolist(), rel=1e-6)
    with pytest.raises(DataError) as refused:
        ic.microgravity(tmp_path / source.name, bias_x="1 ug", bias_y="1 ug", bias_z="1 ug", bias_u="1 ug")
    assert refused.value.problems[0].code == "wrong_frame"
    turned = ic.microgravity(tmp_path / source.name, frame="sensor", bias_x="1 ug", bias_y="1 ug", bias_z="1 ug",
                             bias_u="1 ug")  # fmt: skip
    assert turned.result.estimate is not None


def test_a_bias_that_an_earlier_test_found_is_taken_off_with_its_covariance() -> None:
    """The uncertainty of the bias enters once, though two records have it: it does not shrink with their number."""
    made = recorded(np.random.default_rng(19))
    u = 0.5 * UG
    keys = tuple(Key("bias", axis) for axis in AXES)
    covariance = np.diag([u**2, 4.0 * u**2, u**2])
    found = Estimate(keys, np.array(made.station.bias) * UG, ("m/s^2",) * 3,
                     (Component(Origin("scatter of flips", level="dwell"), "A", covariance, 12.0),))  # fmt: skip
    n, stamps = len(made.time) // 2, np.rint(made.time * 1e9).astype(np.int64)
    halves = []
    for rows in (slice(0, n), slice(n, None)):
        channels = tuple(Channel(axis, made.values[rows, i], "m/s^2", axis=axis) for i, axis in enumerate(AXES))
        halves.append(Recording(channels, stamps[rows], 0.05, None, "utc", "column", cut_off=8.0))
    sources: list[Any] = [
        SimpleNamespace(name=name, file=f"{name}.csv", facts=Facts("accelerometer", "ug", "m/s^2"),
                        entry=SimpleNamespace(curve=None), recordings=lambda one=one, name=name: [(name, one)])
        for name, one in zip(("first", "second"), halves, strict=True)
    ]  # fmt: skip
    readings = readings_from(Plan(), sources, (BiasCorrection("flip", found),))
    estimate = reduce(Plan(), readings).estimate
    assert estimate is not None
    stated = reduced(made.values, **(known_bias(made) | {"bias_u": u})).estimate
    assert stated is not None
    assert estimate.values == pytest.approx(stated.values, abs=1e-3 * UG)
    by_bias = [one for one in estimate.components if one.origin.test == "flip"]
    assert len(by_bias) == 1
    assert by_bias[0].u == pytest.approx([u, 2.0 * u, u])


def test_an_axis_that_the_flip_found_no_bias_of_has_no_slow_acceleration() -> None:
    """A flip about x has none of x: taken as known, x had been off by its whole bias with u of the noise."""
    made = recorded(np.random.default_rng(19))
    keys = (Key("bias", "y"), Key("bias", "z"))
    part = Component(Origin("scatter of flips", level="dwell"), "A", np.eye(2) * (0.5 * UG) ** 2, 12.0)
    found = Estimate(keys, np.array(made.station.bias[1:]) * UG, ("m/s^2",) * 2, (part,))
    channels = tuple(Channel(axis, made.values[:, i], "m/s^2", axis=axis) for i, axis in enumerate(AXES))
    stamps = np.rint(made.time * 1e9).astype(np.int64)
    one = Recording(channels, stamps, 0.05, None, "utc", "column", cut_off=8.0)
    source: Any = SimpleNamespace(name="one", file="one.csv", facts=Facts("accelerometer", "ug", "m/s^2"),
                                  entry=SimpleNamespace(curve=None), recordings=lambda: [("one", one)])  # fmt: skip
    readings = readings_from(Plan(), [source], (BiasCorrection("flip", found),))
    result = reduce(Plan(), readings)
    rows = {(row.key.quantity, row.key.axis): row for row in result.rows()}
    for axis, true in zip("yz", made.slow[1:], strict=True):
        row = rows["quasi_steady_acceleration", axis]
        assert row.value == pytest.approx(float(true), abs=3.0 * float(row.u or 0.0))
    for key in (("quasi_steady_acceleration", "x"), ("quasi_steady_magnitude", ""), ("quasi_steady_perpendicular", "")):
        assert rows[key].status == "not_estimated"
    assert rows["interval_mean", "x"].value is not None
    assert ("interval_mean", "y") not in rows
    assert "bias_unknown" in codes(result)

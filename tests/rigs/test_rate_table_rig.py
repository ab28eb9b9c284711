"""Rig of the rate table: motion and earth in closed form, every sign found again, every mistake named."""

from __future__ import annotations

import tomllib
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fitted_results import fit_results
from inertialcal.campaign.file.schema import CampaignFile
from inertialcal.core.constants import EARTH_ROTATION_RATE
from inertialcal.core.errors import DataError, UsageError
from inertialcal.core.influence import Influence
from inertialcal.physics.earth import level_to_table
from inertialcal.procedures.rate_table.fit.earth_input import earth_in_dwells
from inertialcal.procedures.rate_table.plan import Attitude
from inertialcal.procedures.rate_table.reduction import Plan
from inertialcal.rigs import RIGS
from inertialcal.rigs.parts.campaign import drawn_error
from inertialcal.rigs.parts.gyro_bench import (
    CODES,
    REFERENCE,
    Gyro,
    Motion,
    averaged_codes,
    body_rate,
    motion,
    mounted,
    powered_up,
)
from inertialcal.rigs.parts.noise import random_walk
from inertialcal.rigs.protocol import on_bench
from inertialcal.rigs.rate_table import rig as rate_table
from inertialcal.rigs.rate_table.rig import FAULTS
from inertialcal.rigs.rate_table.setup import Bench, chain, draw_gyro
from inertialcal.rigs.twin import Twin
from inertialcal.sensors.chain.conversion import convert
from inertialcal.sensors.model.sensor_model import SensorModel

EXACT = {name: Influence(0.0, unit) for name, unit in (
    ("rate_table.rate", "1"), ("rate_table.mounting", "rad"), ("converter.reference", "1"), ("site.latitude", "rad"),
)}  # fmt: skip
OMEGA = EARTH_ROTATION_RATE.value
RATES = (0.0, 1.0, -1.0, 4.5, -4.5, 0.0)  # [deg/s]
SHORT = Bench(rates_deg_s=RATES, dwell=30.0, runs=5, standards=EXACT, u_tilt_deg=0.0, u_azimuth_deg=0.0)


def steps(rates: tuple[float, ...] = RATES, ramp: float = 4.0) -> Motion:
    return motion(np.radians(rates), 30.0, np.full(len(rates) - 1, ramp), 2.0, 1.0)


# Motion


def test_a_window_inside_a_dwell_has_its_rate_and_the_angle_is_that_of_trapezia() -> None:
    found = steps((1.0, -3.0), ramp=5.0)
    # 30 s at 1, 5 s from 1 to -3, 30 s at -3: the last window begins at 64 s.
    assert found.start[-1] == 64.0
    assert np.degrees(found.rate[0]) == pytest.approx(1.0)
    assert np.degrees(found.angle[found.start == 30.0]) == pytest.approx(30.0)
    assert np.degrees(found.angle[found.start == 36.0]) == pytest.approx(30.0 + 5.0 * (1.0 - 3.0) / 2.0 - 3.0)
    # The mean from 30 s to 31 s of a rate that falls 4 deg/s in 5 s.
    assert np.degrees(found.rate[found.start == 30.0]) == pytest.approx(1.0 - 0.4)


@settings(max_examples=30, deadline=None)
@given(st.lists(st.floats(-5.0, 5.0), min_size=2, max_size=6), st.integers(1, 5), st.integers(0, 2**31))
def test_angle_and_mean_rate_are_the_integral_of_the_rate(rates: list[float], longest: int, seed: int) -> None:
    ramps = 2.0 * np.random.default_rng(seed).integers(1, longest + 1, len(rates) - 1)
    found = motion(rates, 20.0, ramps, 2.0, 1.0)
    begin = np.concatenate([[0.0], np.cumsum(20.0 + ramps)])
    fine = np.linspace(0.0, found.start[-1] + 1.0, 200_001)
    rate = np.interp(fine, np.column_stack([begin, begin + 20.0]).ravel(), np.repeat(rates, 2))
    angle = np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(fine))])
    tolerance = 1e-6 * (1.0 + np.abs(angle).max())
    assert found.angle == pytest.approx(np.interp(found.start, fine, angle), abs=tolerance)
    assert found.turned == pytest.approx(np.interp(found.start + 1.0, fine, angle) - found.angle, abs=2 * tolerance)
    assert found.rate == pytest.approx(found.turned)  # over one second


# Earth and mounting


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_at_rest_the_unit_senses_the_whole_earth_rate_and_its_component_along_the_axis(axis: int) -> None:
    latitude, tilt, azimuth = np.radians([36.6, -36.4, 10.0])
    found = body_rate(steps((0.0, 0.0)), 1.0, mounted(axis, (0.0, 0.0)), latitude, level_to_table(tilt, azimuth), 1.0)
    assert np.linalg.norm(found, axis=1) == pytest.approx(np.full(len(found), OMEGA))
    along = OMEGA * (np.sin(latitude) * np.cos(tilt) + np.cos(latitude) * np.sin(tilt) * np.cos(azimuth))
    assert found[:, axis] == pytest.approx(np.full(len(found), along))


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_earth_rate_is_of_the_form_that_the_reduction_takes_it_to_be(axis: str) -> None:
    i, latitude, tilt = "xyz".index(axis), 0.6, 0.3
    turning = steps((2.0,))
    rate = body_rate(turning, 1.0, mounted(i, (0.0, 0.0)), latitude, level_to_table(tilt, 0.5), 2.2)
    rate[:, i] -= turning.rate
    plan = Plan(attitude=Attitude(tilt, azimuth=0.5), latitude=latitude)
    known, sources = earth_in_dwells(plan, axis, turning.angle, turning.turned)
    patterns = sources[f"phase of the table, {axis} turned"] * np.sqrt(2.0)  # amplitude, not standard deviation
    left = (rate - known).ravel()
    phase, residual, *_ = np.linalg.lstsq(patterns.reshape(2, -1).T, left, rcond=None)
    assert np.hypot(*phase) == pytest.approx(1.0)
    assert residual[0] < (1e-9 * OMEGA) ** 2


def test_the_earth_turns_backwards_in_a_unit_that_turns_forwards() -> None:
    # Axis up at the pole's complement: north lies along the table's x at angle zero, and azimuth north.
    found = body_rate(steps((1.0,)), 1.0, mounted(2, (0.0, 0.0)), 0.0, level_to_table(0.0, 0.0), 0.0)
    middle = np.radians(np.arange(0.0, 30.0, 2.0) + 0.5)
    assert found[:, 0] == pytest.approx(OMEGA * np.cos(middle), rel=1e-4)
    assert found[:, 1] == pytest.approx(-OMEGA * np.sin(middle), rel=1e-4)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_mounting_angles_are_what_the_table_axis_has_of_the_other_body_axes(axis: int) -> None:
    C_body_table = mounted(axis, (0.01, -0.02))
    assert C_body_table @ C_body_table.T == pytest.approx(np.eye(3), abs=1e-12)
    assert np.linalg.det(C_body_table) == pytest.approx(1.0)
    turned = C_body_table @ [0.0, 0.0, 1.0]
    assert turned[(axis + 1) % 3] == pytest.approx(0.01, rel=1e-3)
    assert turned[(axis + 2) % 3] == pytest.approx(-0.02, rel=1e-3)


# Noise and codes


def test_mean_of_a_random_walk_over_a_window_has_the_variance_of_theory() -> None:
    coefficient, interval, averaging = 2.0, 2.0, 1.0
    found = random_walk(coefficient, 6, 40_000, interval, averaging, np.random.default_rng(1))
    begins = interval * np.arange(6)
    assert np.var(found, axis=1) == pytest.approx(coefficient**2 * (begins + averaging / 3.0), rel=0.05)
    steps_between = np.var(np.diff(found, axis=0), axis=1)  # interval less two thirds and twice a third of a window
    assert steps_between == pytest.approx(np.full(5, coefficient**2 * (interval - averaging / 3.0)), rel=0.05)


def test_codes_through_the_chain_are_the_readings_to_half_a_step_of_the_mean() -> None:
    rng = np.random.default_rng(2)
    values = rng.uniform(-0.08, 0.08, (500, 3))
    codes, reference = averaged_codes(chain(), values, REFERENCE + rng.normal(0.0, 0.005, (500, 3)), 200)
    assert codes * 200 == pytest.approx(np.rint(codes * 200), abs=1e-9)
    back = convert(chain(), codes, reference=reference, validity=np.full(500, 4000.0)).readings
    assert back is not None
    volts = np.abs(back - values) * rate_table_volts()
    assert volts.max() <= 0.5 * 5.0 / 4095.0 / 200.0 * (1.0 + 1e-9)
    assert volts.max() > 0.4 * 5.0 / 4095.0 / 200.0


def rate_table_volts() -> float:
    return float(0.5 * 180.0 / np.pi)


def test_beyond_the_converter_stands_its_end() -> None:
    codes, _ = averaged_codes(chain(), np.array([[0.2, -0.2, 0.0]]), np.full((1, 3), REFERENCE), 200)
    assert codes[0, :2].tolist() == [CODES[1], CODES[0]]


def test_errors_of_standards_have_the_stated_size_and_shape() -> None:
    rng = np.random.default_rng(3)
    flat = [drawn_error(Influence(1.0, distribution="rectangular"), rng) for _ in range(4000)]
    round_ = [drawn_error(Influence(1.0), rng) for _ in range(4000)]
    assert np.std(flat) == pytest.approx(1.0, rel=0.05)
    assert np.std(round_) == pytest.approx(1.0, rel=0.05)
    assert np.abs(flat).max() <= np.sqrt(3.0)
    assert np.abs(round_).max() > np.sqrt(3.0)
    assert drawn_error(None, rng) == 0.0


# The campaign as a whole


def quiet(inverted: tuple[int, ...], **terms: np.ndarray) -> Gyro:
    """A unit whose scatter can be neglected, with terms large enough to tell their signs."""
    unit = draw_gyro(inverted, np.random.default_rng(0))
    plain = {"bias": np.zeros(3), "matrix": np.eye(3), "scale_factor_asymmetry": np.zeros(3)}
    model = replace(unit.model, **(plain | terms))
    return replace(unit, model=model, run_bias_std=1e-7, run_scale_std=1e-7, dwell_std=1e-7, sample_std=1e-6)


def estimates(bench: Bench, gyro: Gyro, seed: int = 5) -> dict[str, float]:
    estimate = fit_results(rate_table.build(bench, seed, gyro))[0].estimate
    assert estimate is not None
    return dict(zip(estimate.names, estimate.values.tolist(), strict=True))


@pytest.mark.parametrize("inverted", [(-1, 1, -1), (1, 1, 1)])
def test_every_term_is_found_with_its_sign_and_at_its_place(inverted: tuple[int, ...]) -> None:
    matrix = np.array([[1.004, 0.011, -0.012], [0.013, 0.997, 0.014], [-0.015, 0.016, 1.002]])
    bias, asymmetry = np.radians([0.05, -0.03, 0.02]), np.array([0.02, -0.03, 0.04])
    gyro = quiet(inverted, matrix=matrix, bias=bias, scale_factor_asymmetry=asymmetry)
    twin = rate_table.build(SHORT, 5, gyro)
    said = np.diag(inverted)
    text = twin.campaign.replace("[-1, 0, 0], [0, 1, 0], [0, 0, -1]", str(said.tolist())[1:-1])
    estimate = fit_results(replace(twin, campaign=text))[0].estimate
    assert estimate is not None
    truth = {f"{one.quantity}_{one.axis}": one.value for one in twin.truth}
    phase = 4e-5  # what the unknown direction of earth rate can do to a bias [rad/s]; over 4.5 deg/s 5e-4
    near = {"bias": phase, "third_order": 2e-2}  # a third-order term of 2e-2 s^2 is 2e-4 of the largest rate
    for key, value in zip(estimate.keys, estimate.values, strict=True):
        assert value == pytest.approx(truth[str(key)], abs=near.get(key.quantity, 2e-3)), key
    for i, one in enumerate("xyz"):
        for j, other in enumerate("xyz"):
            wanted = matrix[i, j] - (i == j)
            name = "scale_factor_error" if i == j else "cross_axis_sensitivity"
            assert truth[f"{name}_{one if i == j else one + other}"] == pytest.approx(wanted)


@pytest.mark.parametrize(
    ("standard", "drawn"),
    [("rate_table.rate", "table_rate_error"), ("converter.reference", "converter_reference_error")],
)
def test_an_error_of_rate_or_reference_shifts_all_scale_factors_by_what_was_drawn(standard: str, drawn: str) -> None:
    bench = replace(SHORT, standards=EXACT | {standard: Influence(0.05)})
    twin = rate_table.build(bench, 5, quiet((-1, 1, -1)))
    error = twin.drawn[drawn]
    assert isinstance(error, float)
    assert abs(error) > 0.004  # seen above what the earth does
    found = estimates(bench, quiet((-1, 1, -1)))
    for axis in "xyz":
        assert found[f"scale_factor_error_{axis}"] == pytest.approx(error, abs=1e-3)


def test_angles_of_the_mounting_shift_the_cross_terms_by_what_was_drawn() -> None:
    bench = replace(SHORT, standards=EXACT | {"rate_table.mounting": Influence(0.02, "rad")})
    drawn = rate_table.build(bench, 5, quiet((-1, 1, -1))).drawn
    found = estimates(bench, quiet((-1, 1, -1)))
    for i, axis in enumerate("xyz"):
        angles = drawn[f"mounting_{axis}_turned"]
        assert isinstance(angles, list)
        for other, angle in zip(("xyz"[(i + 1) % 3], "xyz"[(i + 2) % 3]), angles, strict=True):
            assert found[f"cross_axis_sensitivity_{other}{axis}"] == pytest.approx(angle, abs=1e-3)


def test_each_run_has_a_bias_and_scale_factors_of_its_own() -> None:
    unit = draw_gyro((1, 1, 1), np.random.default_rng(1))
    rng = np.random.default_rng(2)
    models: list[SensorModel] = [powered_up(unit, rng).model for _ in range(2000)]
    assert np.std([m.bias for m in models], axis=0) == pytest.approx(np.full(3, unit.run_bias_std), rel=0.06)
    scales = np.array([m.matrix[0] / unit.model.matrix[0] for m in models])
    assert np.std(scales[:, :, 0], axis=0) == pytest.approx(np.full(3, unit.run_scale_std), rel=0.06)
    assert scales[:, :, 0] == pytest.approx(scales[:, :, 1])  # a sensor's whole row


def test_the_same_seed_gives_the_same_bytes_and_another_seed_others() -> None:
    one, same, other = (rate_table.RIG.twin(seed) for seed in (4, 4, 5))
    for file, recording in one.recordings.items():
        assert recording.array().tobytes() == same.recordings[file].array().tobytes()
        assert recording.array()[:50].tobytes() != other.recordings[file].array()[:50].tobytes()
    assert one.truth == same.truth
    assert one.truth != other.truth
    assert one.campaign == other.campaign


def test_the_campaign_file_is_valid_and_names_every_recording() -> None:
    twin = rate_table.RIG.twin(1)
    file = CampaignFile.model_validate(tomllib.loads(twin.campaign.replace("@SEED@", "1")))
    assert {entry.file for entry in file.recordings.values()} == set(twin.recordings)
    fit, held = (next(test for test in file.tests if test.use == use) for use in ("fit", "hold_out"))
    bench = Bench()
    assert len(fit.recordings) == len(bench.turned) * bench.fit_runs
    assert len(held.recordings) == len(bench.turned) * (bench.runs - bench.fit_runs)
    assert not set(fit.recordings) & set(held.recordings)
    assert len({file.recordings[name].run for name in fit.recordings}) == bench.fit_runs
    for name in ("bias", "scale_factor_error", "misalignment"):
        values = [f"{one.value:.6g}" for one in twin.truth if one.quantity == name]
        assert not [value for value in values if value in twin.campaign]


def test_some_saves_are_skipped_and_the_stamps_tell() -> None:
    stamps = [recording.time_ns for recording in rate_table.RIG.twin(2).recordings.values()]
    gaps = np.concatenate([np.diff(one) for one in stamps if one is not None]) / 1e9
    assert set(np.unique(gaps)) <= {2.0, 4.0, 6.0, 8.0}
    assert 0.002 < np.mean(gaps > 2.0) < 0.03


def named(twin: Twin) -> set[str]:
    """Codes of errors, remarks and reasons why something is not estimated."""
    try:
        result = fit_results(twin)[0]
    except DataError as error:
        return {problem.code for problem in error.problems}
    reasons = {row.reason.code for row in result.rows() if row.status == "not_estimated"}
    return reasons | {remark.code for remark in result.remarks}


# Mistakes show without power-ups held out
FIVE = replace(rate_table.RIG, make=on_bench(rate_table.build, Bench(runs=5)))


@pytest.fixture(scope="module")
def sound() -> Twin:
    return FIVE.twin(7)


@pytest.mark.parametrize("fault", FAULTS)
def test_each_mistake_is_named(fault: str, sound: Twin) -> None:
    shows = FAULTS[fault].shows
    twin = FIVE.twin(7, fault)
    assert twin.truth == sound.truth
    assert shows in named(twin)


def test_without_a_mistake_nothing_is_wrong(sound: Twin) -> None:
    result = fit_results(sound)[0]
    found = named(sound)
    assert not found & {fault.shows for fault in FAULTS.values()}
    assert all(row.status == "estimated" for row in result.rows() if row.quantity in {"bias", "misalignment"})


def test_a_mistake_that_is_not_known_is_refused() -> None:
    with pytest.raises(UsageError, match=r"no fault 'gremlin'.*There are: swapped_axis"):
        rate_table.RIG.twin(1, "gremlin")


@pytest.mark.parametrize("name", RIGS)
def test_every_rig_has_what_the_campaign_needs(name: str) -> None:
    rig = RIGS[name]
    assert rig.title
    assert all(fault.what and (fault.shows or fault.expects == "covered") for fault in rig.faults.values())
    twin = rig.twin(1)
    assert twin.rig == name
    assert twin.campaign.count("@SEAL@") == 1
    assert len({(one.key, one.test) for one in twin.truth}) == len(twin.truth)

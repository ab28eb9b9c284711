"""Rig of the rate suite: the published tables, closed forms of every part, every term found again, mistakes made."""

from __future__ import annotations

import csv
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.polynomial import Polynomial

from fitted_results import fit_results
from inertialcal.campaign.file.cross_checks import cross_checks
from inertialcal.campaign.file.schema import CampaignFile
from inertialcal.core.constants import EARTH_ROTATION_RATE
from inertialcal.core.errors import DataError, UsageError
from inertialcal.core.estimate import Array
from inertialcal.core.influence import Influence
from inertialcal.core.key import AXES
from inertialcal.core.recording import Recording
from inertialcal.rigs.npsat1 import rig as npsat1
from inertialcal.rigs.npsat1.campaign import AT_DEGC, degrees
from inertialcal.rigs.npsat1.recordings import WARMER_DEGC, column, save_starts
from inertialcal.rigs.npsat1.rig import FAULTS
from inertialcal.rigs.npsat1.setup import AIR, AVERAGING, LATE, VACUUM, Bench, Chamber, chain
from inertialcal.rigs.npsat1.unit import (
    AIR_TORR,
    AMBIENT_VOLTS,
    NOISE_DEG_S,
    NOMINAL_SCATTER_V,
    REGION_VOLTS,
    REGIONS_TORR,
    SLOPES,
    START_UP_AIR_DEG_S,
    START_UP_VACUUM_DEG_S,
    TURN_OVER,
    VACUUM_VOLTS,
    WALK_DEG_H_SQRT_H,
    Climate,
    Run,
    Unit,
    draw_unit,
    followed,
    knots,
    noise,
    polynomial_bias,
    powered_up,
    readings,
    settled_bias,
    side_of_path,
    vacuum_part,
)
from inertialcal.rigs.parts.gyro_bench import CODES, INVERTED, REFERENCE, STEP, VOLTS_PER_RAD_S
from inertialcal.rigs.twin import Twin
from inertialcal.sensors.catalogue import SLOPE, T_REFERENCE, V_NOMINAL
from inertialcal.sensors.chain.conversion import Converted, convert

DEG = np.pi / 180.0
EXACT = {name: Influence(0.0, influence.unit) for name, influence in Bench().standards.items()}
KNOWN = replace(
    Bench(), standards=EXACT, u_tilt_deg=0.0, u_azimuth_deg=0.0, u_chamber_tilt_deg=0.0, u_chamber_azimuth_deg=0.0,
    u_lab_degc=0.0, chamber_tilt_deg=10.0,
)  # fmt: skip
SMALL = replace(Bench(), chamber_runs=2, chamber_fit_runs=1, table_runs=2, table_fit_runs=1, static_hours=0.2)
QUICK = {AIR: Chamber(900.0, 1200.0, 400.0, (760.0, 760.0)), VACUUM: Chamber(5400.0, 1200.0, 400.0, (1e-5, 1e-6))}


def published() -> Unit:
    """The unit of the tables."""
    unit = draw_unit(np.random.default_rng(0))
    return replace(unit, bias_volts={AIR: AMBIENT_VOLTS, VACUUM: VACUUM_VOLTS})


def quiet(**terms: object) -> Unit:
    """The unit of the tables without noise, or anything of a power-up."""
    silent = {
        "run_bias_std": 0.0, "run_slope_std": 0.0, "run_scale_std": 0.0, "dwell_std": 0.0, "white": np.full(3, 1e-12),
        "walk": np.zeros(3), "temperature_std": 0.0, "reference_std": 0.0,
    }  # fmt: skip
    return replace(published(), **(silent | terms))  # type: ignore[arg-type]


# The published tables


def rows(shared: Path, name: str) -> list[dict[str, str]]:
    with (shared / "reference" / "npsat2011" / name).open(newline="") as file:
        return list(csv.DictReader(file))


def by_axis(table: list[dict[str, str]], value: str) -> Array:
    """Values of a table with a row an axis and term, shape (terms, 3)."""
    return np.array([[float(row[value]) for row in table if row["axis"] == axis.upper()] for axis in AXES]).T


@pytest.mark.parametrize(
    ("name", "typed"), [("table03_poly_ground_volt.csv", AMBIENT_VOLTS), ("table07_poly_vacuum_volt.csv", VACUUM_VOLTS)]
)
def test_polynomials_are_those_of_tables_3_and_7(shared: Path, name: str, typed: Array) -> None:
    assert typed.tolist() == by_axis(rows(shared, name), "value").tolist()


def test_pressures_and_bias_are_those_of_table_6(shared: Path) -> None:
    table = rows(shared, "table06_pressure_bias.csv")
    assert REGION_VOLTS.tolist() == by_axis(table, "mean_bias_volt").tolist()
    ends = [(float(row["pressure_low_torr"]), float(row["pressure_high_torr"])) for row in table[::3]]
    assert list(REGIONS_TORR) == ends


def test_slopes_are_those_of_appendices_e_to_j(shared: Path) -> None:
    fits = {row["appendix"]: row for row in rows(shared, "appendix_ej_fit_reports.csv")}
    for i, line in enumerate((("E1", "F2", "G2"), ("E2", "F1", "J3"), ("E3", "F3", "G1"))):
        for j, appendix in enumerate(line):
            assert (fits[appendix]["sensed_axis"], fits[appendix]["test_axis"]) == ("XYZ"[i], "XYZ"[j])
            assert SLOPES[i, j] == float(fits[appendix]["slope_volt_per_dps"])


def test_other_figures_are_those_of_the_thesis(shared: Path) -> None:
    left = {(row["stage"], row["axis"]): float(row["mean"]) for row in rows(shared, "residual_bias.csv")}
    walk = rows(shared, "table13_allan.csv")
    assert tuple(left["startup_change_ambient", axis.upper()] for axis in AXES) == START_UP_AIR_DEG_S
    assert tuple(left["transient_vacuum_compensated", axis.upper()] for axis in AXES) == START_UP_VACUUM_DEG_S
    assert WALK_DEG_H_SQRT_H[:2] == tuple(float(row["rate_ramp_deg_per_h_per_sqrt_h"]) for row in walk[:2])
    assert not walk[2]["rate_ramp_deg_per_h_per_sqrt_h"]
    scatters = [float(row["v_nominal_std_volt"]) for row in rows(shared, "table02_nominal_voltage.csv")]
    assert max(scatters) == NOMINAL_SCATTER_V
    for row in rows(shared, "table05_noise.csv"):
        assert float(row["std_rate_dps"]) == pytest.approx(NOISE_DEG_S, rel=0.07)


def test_bias_of_z_over_degrees_is_that_of_table_4(shared: Path) -> None:
    table = rows(shared, "table04_poly_ground_degc_dps.csv")
    printed = Polynomial([float(row["value"]) for row in table if row["axis"] == "Z"])
    at = np.linspace(-29.0, 66.0, 96)
    found = polynomial_bias(published(), AIR, at)[:, 2] / DEG
    assert found == pytest.approx(printed(at), abs=6e-5)  # the audit: 5e-5 deg/s, from rounded coefficients


def test_vacuum_shifts_the_bias_by_what_the_thesis_states() -> None:
    # Section IV.C: B shifts by 0.05, 0.01 and 0.03 deg/s; its B is the bias at 0 V of the temperature channel.
    at = np.array(T_REFERENCE) - np.array(V_NOMINAL) / SLOPE
    unit = published()
    shift = polynomial_bias(unit, VACUUM, at[None, :]) - polynomial_bias(unit, AIR, at[None, :])
    assert shift[0] / DEG == pytest.approx([0.05, 0.01, 0.03], abs=0.006)


def test_units_scatter_about_the_published_one() -> None:
    units = [draw_unit(np.random.default_rng(seed)) for seed in range(400)]
    air = np.mean([unit.bias_volts[AIR] for unit in units], axis=0)
    matrix = np.mean([unit.model.matrix[0] for unit in units], axis=0)
    vacuum = np.mean([unit.bias_volts[VACUUM] for unit in units], axis=0)
    assert air == pytest.approx(AMBIENT_VOLTS, abs=3e-3)
    assert vacuum - air == pytest.approx(VACUUM_VOLTS - AMBIENT_VOLTS, abs=1e-3)
    assert np.sign(air[1:]).tolist() == np.sign(AMBIENT_VOLTS[1:]).tolist()
    assert matrix == pytest.approx(2.0 * SLOPES, abs=1e-3)  # over 0.5 V/(deg/s)
    assert all(2.0 * unit.hysteresis.max() <= 0.004 * DEG for unit in units)
    assert np.mean([unit.white for unit in units]) / DEG == pytest.approx(NOISE_DEG_S, rel=0.01)


def test_power_ups_differ_in_bias_slope_and_scale() -> None:
    unit, rng = published(), np.random.default_rng(1)
    runs = [powered_up(unit, rng) for _ in range(3000)]
    assert np.std([run.bias for run in runs]) == pytest.approx(unit.run_bias_std, rel=0.05)
    assert np.std([run.slope for run in runs]) == pytest.approx(unit.run_slope_std, rel=0.05)
    assert np.std([run.scale for run in runs]) == pytest.approx(unit.run_scale_std, rel=0.05)
    assert unit.run_bias_std / DEG < 0.016 / 2.0  # Table 14: the largest difference seen is about 0.016 deg/s


# Temperature and pressure


def test_what_follows_the_chamber_solves_its_equation() -> None:
    times, points, tau = np.array([0.0, 600.0, 2600.0, 4000.0]), np.array([20.0, 20.0, -30.0, -30.0]), 400.0
    step = 0.5
    at = np.arange(0.0, 6000.0, step)
    chamber, unit = np.interp(at, times, points), np.full(len(at), 20.0)
    for i in range(1, len(at)):  # trapezoids
        a = 0.5 * step / tau
        unit[i] = ((1.0 - a) * unit[i - 1] + a * (chamber[i] + chamber[i - 1])) / (1.0 + a)
    assert followed(times, points, tau, at) == pytest.approx(unit, abs=1e-4)


def test_behind_a_long_ramp_it_is_its_slope_times_the_time_constant() -> None:
    found = followed(np.array([0.0, 1e5]), np.array([0.0, 2e3]), 300.0, np.array([-5.0, 9e4]))
    assert found == pytest.approx([0.0, 0.02 * (9e4 - 300.0)])


def test_the_chamber_holds_ramps_and_soaks() -> None:
    chamber = Chamber(100.0, 50.0, 400.0, (760.0, 760.0))
    times, points = knots(replace(Bench(), set_points=(20.0, -10.0, 30.0)), chamber, 2.0)
    assert times.tolist() == [0.0, 100.0, 1000.0, 1050.0, 2250.0, 2300.0]
    assert points.tolist() == [20.0, 20.0, -10.0, -10.0, 30.0, 30.0]


def test_the_side_of_a_path_starts_midway_and_turns_over_where_the_path_turns() -> None:
    path = np.concatenate([np.linspace(20.0, -30.0, 501), np.linspace(-30.0, 60.0, 901)[1:]])
    side = side_of_path(path)
    assert side[0] == 0.0
    assert side[100] == pytest.approx(np.exp(-10.0 / TURN_OVER) - 1.0)
    assert side[500] == pytest.approx(-1.0, abs=1e-6)
    assert side[500 + 30] == pytest.approx(1.0 - 2.0 * np.exp(-3.0 / TURN_OVER))
    assert side[-1] == pytest.approx(1.0, abs=1e-9)


@settings(max_examples=40, deadline=None)
@given(st.lists(st.floats(-40.0, 80.0), min_size=2, max_size=8))
def test_the_side_stays_within_one_is_continuous_and_changes_sign_with_the_path(turns: list[float]) -> None:
    path = np.interp(np.linspace(0.0, len(turns) - 1.0, 2000), np.arange(len(turns)), turns)
    side = side_of_path(path)
    assert np.abs(side).max() <= 1.0 + 1e-12
    assert np.all(np.abs(np.diff(side)) <= 2.0 * np.abs(np.diff(path)) / TURN_OVER + 1e-12)
    assert side_of_path(-path) == pytest.approx(-side)


def test_pressure_takes_the_bias_from_air_to_vacuum() -> None:
    air, vacuum = vacuum_part(np.array([AIR_TORR, 1e3])), vacuum_part(np.array([1e-7, 1e-5, 4e-4]))
    assert air == pytest.approx(np.zeros((2, 3)))
    assert vacuum == pytest.approx(np.ones((3, 3)))
    level = REGION_VOLTS[:4].mean(axis=0)  # the regions at and below 4e-4 Torr
    between = vacuum_part(np.sqrt(np.prod(REGIONS_TORR[4:], axis=1)))
    assert between * level == pytest.approx(REGION_VOLTS[4:])
    unit = published()
    still = np.full((2, 3), 10.0)
    ends = settled_bias(unit, Climate(still, still, np.zeros((2, 3)), np.array([AIR_TORR, 1e-6])))
    for row, where in enumerate((AIR, VACUUM)):
        assert ends[row] == pytest.approx(polynomial_bias(unit, where, [10.0])[0])


# Noise and the logger


def test_noise_of_uneven_saves_has_the_variance_of_theory() -> None:
    unit = replace(published(), white=np.full(3, 0.5), walk=np.array([2.0, 1.0, 3.0]))
    starts = np.array([0.0, 2.0, 5.0, 10.0, 16.0])
    rng = np.random.default_rng(3)
    drawn = [noise(unit, starts, np.array([1.0, 0.0, 0.0]), rng) for _ in range(12_000)]
    values = np.array([one.values for one in drawn])
    k2 = unit.walk**2
    # A mean of the walk over a window, from the end of the one before: dt - a + a / 3 each side of it.
    steps = np.diff(starts)[:, None] - AVERAGING / 3.0
    assert np.var(np.diff(values, axis=1), axis=0) == pytest.approx(k2 * steps + 2.0 * 0.5**2, rel=0.06)
    ends = starts[:, None] + AVERAGING / 3.0
    assert np.var(values, axis=0) == pytest.approx(k2 * ends + 0.5**2, rel=0.06)
    assert values.mean(axis=0)[0] == pytest.approx([1.0, 0.0, 0.0], abs=0.05)
    assert np.var([one.end for one in drawn], axis=0) == pytest.approx(k2 * (starts[-1] + AVERAGING), rel=0.06)


def test_saves_come_every_two_seconds_but_for_those_that_are_late() -> None:
    starts = save_starts(Bench(), 400_000.0, np.random.default_rng(4))
    steps, counts = np.unique(np.diff(starts), return_counts=True)
    assert steps.tolist() == [2.0, 3.0, 5.0, 6.0]
    for step, count in zip(steps[1:], counts[1:], strict=True):
        assert count / counts.sum() == pytest.approx(LATE[int(step)], rel=0.35)
    assert starts[0] == 0.0
    assert starts[-1] <= 400_000.0 - AVERAGING
    assert starts.tolist() == np.rint(starts).tolist()


def through_chain(bench: Bench, recording: Recording) -> Converted:
    """What the chain of the campaign makes of a recording; the reference of the temperature is taken off here."""
    codes = {what: recording.array([column(what, axis) for axis in AXES]) for what in ("rate", "temp", "ref", "bit")}
    other = recording.array([column("temp_ref", axis) for axis in AXES])
    warm = codes["temp"] - other + codes["ref"]
    return convert(chain(bench), codes["rate"], reference=codes["ref"], temperature=warm, validity=codes["bit"])


def one_ramp(unit: Unit, where: str = AIR, ramp: float = 1.5, bench: Bench = KNOWN, seed: int = 6) -> Recording:
    made = replace(bench, parts=("thermal",), chamber_runs=1, ramps=(ramp,), chambers={where: QUICK[where]})
    return npsat1.build(made, seed, unit).recordings[f"recordings/{where}_1.csv"]


def test_counts_lie_in_the_converter_and_are_means_of_200() -> None:
    for name, recording in npsat1.build(SMALL, 2).recordings.items():
        for channel in recording.channels:
            if channel.name in {"rate_dps", "pressure_torr"}:
                continue
            assert CODES[0] < channel.data.min(), name
            assert channel.data.max() < CODES[1], name
            assert np.abs(channel.data * 200.0 - np.rint(channel.data * 200.0)).max() < 1e-6


def test_the_logger_saves_five_columns_a_sensor_stamped_at_the_end_of_a_window() -> None:
    recording = one_ramp(published())
    assert set(recording.names) == {"pressure_torr"} | {
        f"{axis}{end}" for axis in AXES for end in ("", "_temp", "_bit", "_ref", "_temp_ref")
    }
    assert recording.time_ns is not None
    assert recording.time_ns[0] % 86_400_000_000_000 == 1_000_000_000  # power-up at midnight, mean over a second
    assert (recording.sample_interval, recording.averaging_time) == (2.0, 1.0)
    tested = recording.channel("x_bit").data * STEP
    assert tested[0] < 2.4  # it starts within a second
    assert tested[1:].min() > 2.4


def test_reference_voltages_drift_with_temperature_as_drawn() -> None:
    unit = quiet()
    recording = one_ramp(unit)
    warm = through_chain(KNOWN, recording).temperature
    assert warm is not None
    for which, what in enumerate(("ref", "temp_ref")):
        for i, axis in enumerate(AXES):
            drift = Polynomial(unit.reference_volts[which, :, i])(warm[:, i] - 25.0)
            assert np.abs(recording.channel(column(what, axis)).data * STEP - drift).max() < 2e-5
            assert np.abs(drift - REFERENCE).max() < 0.06


def test_sensors_mounted_inverted_read_against_the_body() -> None:
    made = through_chain(KNOWN, one_ramp(quiet()))
    assert made.readings is not None
    assert made.temperature is not None
    coldest = made.readings[np.argmin(made.temperature[:, 0])]
    bias = polynomial_bias(quiet(), AIR, [-29.0])[0]
    assert INVERTED == (-1, 1, -1)
    assert np.sign(coldest * np.array(INVERTED)).tolist() == np.sign(bias).tolist()


# Every term found again, by least squares on a ramp without noise


def along_body(recording: Recording, bench: Bench = KNOWN) -> tuple[Array, Array, Array]:
    """Time since power-up [s], readings along the body [rad/s], temperatures [degC]; the first save is not valid."""
    made = through_chain(bench, recording)
    assert made.readings is not None
    assert made.temperature is not None
    assert recording.time_ns is not None
    since = (recording.time_ns - recording.time_ns[0]) / 1e9 + 0.5 * AVERAGING
    return since[1:], made.readings[1:] * np.array(INVERTED), made.temperature[1:]


def earth_read(unit: Unit) -> Array:
    """What the sensors read of the earth in the chamber: body z up, tilted towards the azimuth, where x points."""
    latitude, tilt, azimuth = np.radians([KNOWN.latitude_deg, KNOWN.chamber_tilt_deg, KNOWN.chamber_azimuth_deg])
    north, up = np.cos(latitude), np.sin(latitude)
    rate = EARTH_ROTATION_RATE.value * np.array(
        [
            north * np.cos(azimuth) * np.cos(tilt) - up * np.sin(tilt),
            north * np.sin(azimuth),  # y is level, and west of x seen from above
            north * np.cos(azimuth) * np.sin(tilt) + up * np.cos(tilt),
        ]
    )
    sensed = unit.model.matrix[0] @ rate
    assert unit.model.scale_factor_asymmetry is not None
    return np.asarray(sensed + 0.5 * unit.model.scale_factor_asymmetry * np.abs(sensed))


@pytest.mark.parametrize("where", [AIR, VACUUM])
def test_the_polynomial_start_up_hysteresis_and_lag_are_found_by_least_squares(where: str) -> None:
    unit = quiet()
    since, read, warm = along_body(one_ramp(unit, where))
    for i in range(3):
        volts = (warm[:, i] - T_REFERENCE[i]) * SLOPE + V_NOMINAL[i]
        rate = np.gradient(warm[:, i], since) * SLOPE
        slope = Polynomial(unit.bias_volts[where][:, i]).deriv()(volts)
        columns = np.column_stack(
            [*(volts**j for j in range(4)), np.exp(-since / unit.start_up_time[where]), side_of_path(warm[:, i]),
             -rate * slope]
        )  # fmt: skip
        found, *_ = np.linalg.lstsq(columns, (read[:, i] - earth_read(unit)[i]) * VOLTS_PER_RAD_S, rcond=None)
        assert found[:4] == pytest.approx(unit.bias_volts[where][:, i], abs=2e-5)  # [V/V^j]
        assert found[4] == pytest.approx(unit.start_up[where][i] * VOLTS_PER_RAD_S, abs=2e-5)
        assert found[5] == pytest.approx(unit.hysteresis[i] * VOLTS_PER_RAD_S, abs=2e-5)
        assert found[6] == pytest.approx(unit.lag, abs=1.0)  # [s]


@pytest.mark.parametrize("ramp", [1.5, 0.75])
def test_warming_less_cooling_is_hysteresis_and_lag_and_midway_lies_the_truth(ramp: float) -> None:
    unit = quiet(start_up={AIR: np.zeros(3), VACUUM: np.zeros(3)})
    _, read, warm = along_body(one_ramp(unit, ramp=ramp))
    coldest = int(np.argmin(warm[:, 0]))
    hottest = int(np.argmax(warm[:, 0]))
    grid = np.linspace(-10.0, 10.0, 41)  # far from where the path turns
    for i in range(3):
        cooling = np.interp(grid, warm[coldest:0:-1, i], read[coldest:0:-1, i])
        warming = np.interp(grid, warm[coldest:hottest, i], read[coldest:hottest, i])
        truth = polynomial_bias(unit, AIR, grid)[:, i]
        midway = 0.5 * (warming + cooling) - earth_read(unit)[i]
        assert midway == pytest.approx(truth, abs=2e-4 * DEG)
        slope = np.gradient(truth, grid)
        expected = 2.0 * unit.hysteresis[i] - 2.0 * slope * unit.lag * ramp / 60.0
        assert warming - cooling == pytest.approx(expected, abs=3e-4 * DEG)
    assert np.abs(unit.hysteresis).max() > 3e-4 * DEG


def test_truth_is_what_the_polynomials_say() -> None:
    bench = replace(Bench(), chamber_runs=1, table_runs=1, static_hours=0.1, zero_reference=False)
    twin = npsat1.build(bench, 1, published())
    at_rest = npsat1.build(replace(bench, zero_reference=True), 1, published())
    assert set(twin.truth) - set(at_rest.truth) == {one for one in twin.truth if one.test == "rate"}  # taken off there
    truth = {(one.quantity, one.axis, one.test, str(one.at or "")): one for one in twin.truth if not one.power}
    assert len({(one.key, one.test) for one in twin.truth}) == len(twin.truth)
    for condition, at in [("", 20.0), *((degrees(one), one) for one in AT_DEGC)]:
        air, vacuum = (polynomial_bias(published(), where, [at])[0] for where in (AIR, VACUUM))
        for i, axis in enumerate(AXES):
            assert truth["bias", axis, "thermal_ambient", condition].value == air[i]
            assert truth["bias", axis, "thermal_vacuum", condition].value == vacuum[i]
            offset = truth["vacuum_offset", axis, "thermal_vacuum", condition].value
            assert offset == pytest.approx(vacuum[i] - air[i])
    unit = published()
    still = np.full((1, 3), 20.0)
    paths = [
        settled_bias(unit, Climate(still, still, np.full((1, 3), side), np.array([AIR_TORR])))[0]
        for side in (1.0, -1.0)
    ]
    for i, axis in enumerate(AXES):
        for test in ("thermal_ambient", "thermal_vacuum"):
            assert truth["hysteresis", axis, test, ""].value == pytest.approx(paths[0][i] - paths[1][i])
            assert truth["thermal_lag", axis, test, ""].value == unit.lag
            volts = Polynomial(unit.reference_volts[0, :, i])(20.0 - 25.0)
            assert truth["reference_voltage", axis, test, ""].value == pytest.approx(volts)
        assert truth["warm_up_change", axis, "thermal_vacuum", ""].value == unit.start_up[VACUUM][i]
        assert truth["warm_up_time_constant", axis, "thermal_ambient", ""].value == unit.start_up_time[AIR]
        assert truth["bias", axis, "rate", ""].value == unit.installation[i]
        assert truth["angle_random_walk", axis, "", ""].value == unit.white[i]  # of means over 1 s
        own = unit.model.matrix[0][i, i]
        assert truth["scale_factor", axis, "", ""].value == pytest.approx(VOLTS_PER_RAD_S * own)
        assert truth["scale_factor_error", axis, "", ""].value == pytest.approx(own - 1.0)
    assert truth["cross_axis_sensitivity", "zx", "", ""].value == pytest.approx(unit.model.matrix[0][2, 0])


def test_the_mean_over_power_ups_is_the_truth() -> None:
    unit, rng = quiet(run_bias_std=0.006 * DEG, run_slope_std=1.5e-4 * DEG), np.random.default_rng(8)
    still = np.full((1, 3), 60.0)
    climate = Climate(still, still, np.zeros((1, 3)), np.array([AIR_TORR]))
    late = np.array([1e6])
    runs = [readings(unit, powered_up(unit, rng), np.zeros((1, 3)), climate, late)[0] for _ in range(2000)]
    scatter = np.hypot(0.006, 1.5e-4 * 40.0) * DEG
    assert np.std(runs, axis=0) == pytest.approx(np.full(3, scatter), rel=0.05)
    assert np.mean(runs, axis=0) == pytest.approx(polynomial_bias(unit, AIR, [60.0])[0], abs=4.0 * scatter / 2000**0.5)


def test_the_start_up_dies_away_as_stated() -> None:
    unit = quiet()
    one = Run(np.zeros(3), np.zeros(3), np.ones(3))
    still = np.full((2, 3), 20.0)
    for where, torr, settled in ((AIR, 760.0, 300.0), (VACUUM, 1e-6, 4500.0)):
        climate = Climate(still, still, np.zeros((2, 3)), np.full(2, torr))
        found = readings(unit, one, np.zeros((1, 3)), climate, np.array([0.0, settled]))
        left = found - polynomial_bias(unit, where, [20.0])
        assert left[0] == pytest.approx(unit.start_up[where])
        assert np.all(left[1] < 0.08 * left[0])  # Table 14: settled by then


# What the engineer does not know


@pytest.mark.parametrize("size", [0.0, 2.0])
def test_the_temperature_channels_are_off_by_what_was_drawn(size: float) -> None:
    bench = replace(KNOWN, standards=EXACT | {"thermometer.temperature": Influence(size, "degC")})
    made = replace(bench, parts=("thermal",), chamber_runs=1, chambers={AIR: QUICK[AIR]})
    twin = npsat1.build(made, 6, quiet())
    _, _, warm = along_body(twin.recordings["recordings/ambient_1.csv"])
    error = twin.drawn["thermometer_error"]
    assert isinstance(error, float)
    assert (error == 0.0) == (size == 0.0)
    assert warm[:100].mean(axis=0) - np.array(WARMER_DEGC) == pytest.approx(np.full(3, 23.0 + error), abs=2e-3)


def table_twin(unit: Unit, bench: Bench = KNOWN, **change: object) -> Twin:
    made = replace(bench, parts=("rate_table",), **change)  # type: ignore[arg-type]
    return npsat1.build(made, 5, unit)


def test_the_rate_table_gives_matrix_and_bias_with_every_sign() -> None:
    drawn = quiet()
    unit = replace(drawn, model=replace(drawn.model, scale_factor_asymmetry=np.array([0.02, -0.03, 0.04])))
    twin = table_twin(unit, table_runs=5, table_fit_runs=5, zero_reference=False)
    estimate = fit_results(twin)[0].estimate
    assert estimate is not None
    found = dict(zip(estimate.names, estimate.values.tolist(), strict=True))
    phase = 4e-5  # what the unknown direction of the earth's rate can do to a bias [rad/s]; over 4.5 deg/s 5e-4
    here = polynomial_bias(unit, AIR, 22.0 + np.array([WARMER_DEGC]))[0] + unit.installation
    for i, axis in enumerate(AXES):
        assert found[f"bias_{axis}"] == pytest.approx(here[i], abs=phase)
    within = {"scale_factor_error": 5e-4, "cross_axis_sensitivity": 5e-4, "scale_factor_asymmetry": 2e-3}
    for one in twin.truth:
        if one.quantity in within:
            assert found[f"{one.quantity}_{one.axis}"] == pytest.approx(one.value, abs=within[one.quantity]), one


@pytest.mark.parametrize(
    ("standard", "drawn"),
    [("rate_table.rate", "table_rate_error"), ("converter.reference", "converter_reference_error")],
)
def test_an_error_of_rate_or_converter_shifts_all_scale_factors(standard: str, drawn: str) -> None:
    bench = replace(KNOWN, standards=EXACT | {standard: Influence(0.08)}, table_runs=2, table_fit_runs=2)
    unit = quiet()
    twin = table_twin(unit, bench)
    error = twin.drawn[drawn]
    assert isinstance(error, float)
    assert abs(error) > 5e-3  # seen above what the earth does
    estimate = fit_results(twin)[0].estimate
    assert estimate is not None
    for i, axis in enumerate(AXES):
        found = float(estimate.values[estimate.names.index(f"scale_factor_error_{axis}")])
        assert found == pytest.approx(unit.model.matrix[0][i, i] * (1.0 + error) - 1.0, abs=1e-3)


def test_angles_of_the_mounting_shift_the_cross_terms() -> None:
    bench = replace(KNOWN, standards=EXACT | {"rate_table.mounting": Influence(0.02, "rad")}, table_runs=2)
    unit = quiet()
    twin = table_twin(unit, bench, table_fit_runs=2)
    estimate = fit_results(twin)[0].estimate
    assert estimate is not None
    for i, axis in enumerate(AXES):
        angles = twin.drawn[f"mounting_{axis}_turned"]
        assert isinstance(angles, list)
        for j, angle in zip(((i + 1) % 3, (i + 2) % 3), angles, strict=True):
            found = float(estimate.values[estimate.names.index(f"cross_axis_sensitivity_{AXES[j]}{axis}")])
            assert found == pytest.approx(unit.model.matrix[0][j, i] + angle, abs=1e-3)


def test_the_walk_goes_on_between_the_axes_of_a_power_up() -> None:
    unit = quiet(walk=np.full(3, 1e-4))
    ends = []
    for seed in range(40):
        made = replace(KNOWN, parts=("rate_table",), rates_deg_s=(0.0, 0.5, 0.0), dwell=1150, table_runs=1)
        files = npsat1.build(made, seed, unit).recordings
        first, last = (through_chain(KNOWN, files[f"recordings/{axis}_run1.csv"]).readings for axis in "xz")
        assert first is not None
        assert last is not None
        ends.append(np.mean(last[:25, 1]) - np.mean(first[:25, 1]))  # y, not turned in either
    assert np.std(ends) == pytest.approx(1e-4 * np.sqrt(7200.0), rel=0.3)


def test_the_record_at_rest_has_the_noise_of_the_truth() -> None:
    unit = published()
    files = npsat1.build(replace(KNOWN, parts=("noise",)), 9, unit).recordings
    recording = files["recordings/static_1.csv"]
    read = through_chain(KNOWN, recording).readings
    assert read is not None
    assert recording.time_ns is not None
    steps = np.diff(recording.time_ns) / 1e9
    assert len(read) > 14_000
    assert (recording.sample_interval, recording.averaging_time) == (2.0, 1.0)  # half of the time is dead
    differences = np.diff(read, axis=0)[steps == 2.0]
    expected = 2.0 * unit.white**2 + unit.walk**2 * (2.0 - 1.0 / 3.0)
    assert np.var(differences, axis=0) == pytest.approx(expected, rel=0.05)
    blocks = read[: len(read) // 450 * 450].reshape(-1, 450, 3).mean(axis=1)  # a quarter of an hour each
    drift = np.var(np.diff(blocks, axis=0), axis=0) - 2.0 * unit.white**2 / 450.0
    assert np.all(drift > 0.2 * unit.walk**2 * 900.0 * 2.0 / 3.0)
    assert np.all(drift < 4.0 * unit.walk**2 * 900.0 * 2.0 / 3.0)


# The campaign


def test_the_same_seed_gives_the_same_bytes_whatever_other_parts_there_are() -> None:
    whole, same, other = npsat1.RIG.twin(4), npsat1.RIG.twin(4), npsat1.RIG.twin(5)
    table = npsat1.build(replace(Bench(), parts=("rate_table",)), 4)
    for name, recording in whole.recordings.items():
        content = recording.array().tobytes()
        assert content == same.recordings[name].array().tobytes()
        assert content[:4000] != other.recordings[name].array().tobytes()[:4000]
        if name in table.recordings:
            assert content == table.recordings[name].array().tobytes()
    assert whole.truth == same.truth
    assert whole.truth != other.truth
    assert whole.campaign == other.campaign
    assert len(table.recordings) == len(AXES) * Bench().table_runs


def test_the_campaign_names_every_recording_and_not_a_word_of_the_truth() -> None:
    twin = npsat1.RIG.twin(1)
    text = tomllib.loads(twin.campaign)
    assert {entry["file"] for entry in text["recordings"].values()} == set(twin.recordings)
    tests = {test["id"]: test for test in text["tests"]}
    for name in ("thermal_ambient", "thermal_vacuum", "rate"):
        fit, check = tests[name], tests["rate_check" if name == "rate" else f"{name}_check"]
        runs = {text["recordings"][one]["run"] for one in fit["recordings"]}
        assert len(runs) == (Bench().table_fit_runs if name == "rate" else Bench().chamber_fit_runs)
        assert not runs & {text["recordings"][one]["run"] for one in check["recordings"]}
        assert (fit["use"], check["use"]) == ("fit", "hold_out")
    values = {f"{one.value:.6g}" for one in twin.truth} | {f"{one.value / DEG:.6g}" for one in twin.truth}
    assert not [value for value in values if value in twin.campaign]
    ramps = [len(twin.recordings[f"recordings/ambient_{number}.csv"]) for number in (1, 2)]
    assert ramps[1] > 1.5 * ramps[0]  # two rates


def test_the_unit_goes_through_the_qualification_range_both_ways() -> None:
    files = small("", "thermal").recordings
    for where in (AIR, VACUUM):
        _, _, warm = along_body(files[f"recordings/{where}_1.csv"], Bench())
        low, high = Bench().required_degc  # the housing follows a chamber that goes 7 to 10 degC further
        assert warm.min(axis=0).max() < low - 5.0
        assert warm.max(axis=0).min() > high + 3.0


def test_a_mistake_that_is_not_known_is_refused() -> None:
    with pytest.raises(UsageError, match=r"no fault 'gremlin'.*There are: no_temperature_change"):
        npsat1.RIG.twin(1, "gremlin")


# Mistakes


def small(fault: str = "", *parts: str) -> Twin:
    bench = replace(SMALL, parts=parts) if parts else SMALL
    return npsat1.build(with_mistake(bench, fault), 7)


def with_mistake(bench: Bench, fault: str) -> Bench:
    return FAULTS[fault].put_into(bench) if fault else bench


def test_a_mistake_that_is_asked_for_is_in_the_twin() -> None:
    wrong = npsat1.RIG.twin(7, "missing_reference")
    assert (wrong.fault, wrong.rig) == ("missing_reference", "npsat1")
    assert not any(
        name.endswith("_ref") and "temp" not in name for name in wrong.recordings["recordings/x_run1.csv"].names
    )


@pytest.mark.parametrize("fault", FAULTS)
def test_a_mistake_changes_the_campaign_and_not_the_truth(fault: str) -> None:
    wrong, right = small(fault), small()
    if fault == "no_zero_reference":  # then the tests find a bias on the table too
        assert set(wrong.truth) > set(right.truth)
    else:
        assert wrong.truth == right.truth
    same = all(
        wrong.recordings[name].array().tobytes() == recording.array().tobytes()
        for name, recording in right.recordings.items()
    )
    assert not same or wrong.campaign != right.campaign


def named(bench: Bench) -> set[str]:
    """Codes of errors and remarks of the tests for the fit."""
    try:
        return {remark.code for result in fit_results(npsat1.build(bench, 7)) for remark in result.remarks}
    except DataError as error:
        return {problem.code for problem in error.problems}


IN_CHAMBER = ("no_temperature_change", "missing_reference", "saturated_end", "duplicate_recording", "only_cooling")
ON_TABLE = ("missing_reference", "swapped_axes", "inverted_sign", "no_zero_reference")


@pytest.mark.parametrize("fault", ["", *ON_TABLE])
def test_mistakes_on_the_rate_table_are_named(fault: str) -> None:
    found = named(with_mistake(replace(Bench(), parts=("rate_table",), table_runs=2, table_fit_runs=2), fault))
    assert {one for one in ON_TABLE if FAULTS[one].shows in found} == ({fault} if fault else set())


@pytest.mark.parametrize("fault", ["", *IN_CHAMBER])
def test_mistakes_in_the_chamber_are_named(fault: str) -> None:
    only_air = replace(Bench(), parts=("thermal",), chambers={AIR: QUICK[AIR]}, chamber_runs=3, chamber_fit_runs=3)
    found = named(with_mistake(only_air, fault))
    assert {one for one in IN_CHAMBER if FAULTS[one].shows in found} == ({fault} if fault else set())


@pytest.mark.parametrize("fault", ["", "overlapping_windows"])
def test_windows_that_overlap_are_found_in_the_campaign_file(fault: str, tmp_path: Path) -> None:
    text = small(fault, "thermal", "rate_table").campaign.replace("@SEED@", "7")
    file = CampaignFile.model_validate(tomllib.loads(text))
    codes = {problem.code for problem in cross_checks(tmp_path, file, lambda *key: "")}
    assert ("overlap" in codes) == bool(fault)


def test_the_cold_end_of_a_shifted_temperature_channel_is_the_end_of_the_converter() -> None:
    recording = small("saturated_end", "thermal").recordings["recordings/ambient_1.csv"]
    for axis in AXES:
        codes = recording.channel(column("temp", axis)).data
        assert codes.min() == CODES[0]
        assert 0.01 < np.mean(codes == CODES[0]) < 0.3


def test_without_power_the_chamber_stays_where_it_is() -> None:
    _, _, warm = along_body(small("no_temperature_change", "thermal").recordings["recordings/ambient_1.csv"], Bench())
    assert np.ptp(warm, axis=0).max() < 0.5


def test_a_ramp_that_only_cools_never_warms() -> None:
    _, _, warm = along_body(small("only_cooling", "thermal").recordings["recordings/ambient_1.csv"], Bench())
    means = warm[: len(warm) // 50 * 50].reshape(-1, 50, 3).mean(axis=1)
    assert np.diff(means, axis=0).max() < 0.05


def test_a_copied_recording_is_the_same_to_the_last_byte() -> None:
    files = small("duplicate_recording", "thermal").recordings
    one, other = (files[f"recordings/ambient_{number}.csv"] for number in (1, 2))
    assert one.array().tobytes() == other.array().tobytes()


def test_overlapping_windows_have_hours_in_common() -> None:
    tests = {test["id"]: test for test in tomllib.loads(small("overlapping_windows", "thermal").campaign)["tests"]}
    fit, held = tests["thermal_ambient"], tests["thermal_ambient_check"]
    assert set(fit["recordings"]) & set(held["recordings"]) == {"ambient_1"}
    (start, stop), (begin, end) = fit["windows"][0], held["windows"][0]
    assert start < begin < stop <= end

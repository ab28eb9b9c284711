"""Each simulator against closed forms: Allan variances of its noise, and its truth found by a few lines of numpy.

They import nothing of inertialcal, at any depth: a shared mistake would be invisible.
"""

from __future__ import annotations

import ast
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import welch

from . import climate, flip, moved_mass, positions, rate_table, static, thermal
from .case import START, csv_text, turned, write_pad

FOLDER = Path(__file__).parent
CALLERS = {"trial", "gate", "coverage", "screened", "studies"}  # of commands: no simulator imports them
SIMULATORS = {
    path.stem: path for path in sorted(FOLDER.rglob("*.py"))
    if path.stem not in CALLERS and not path.stem.startswith(("test_", "__"))
}  # fmt: skip
ALLOWED = {"numpy", "scipy", "pyarrow", "h5py", "ppigrf", "sgp4", *sys.stdlib_module_names}
RATE = 50.0
RELATIVE = 4.0  # times the standard deviation of an Allan deviation over m of n samples, sqrt(m / n)


@pytest.mark.parametrize(
    ("noise", "over"),
    [
        (static.Noise(white=4e-3), (1, 8, 64, 512)),
        (static.Noise(flicker=3e-3), (16, 64, 512)),
        (static.Noise(walk=1e-4), (1, 8, 64, 512)),
        (static.Noise(ramp=1e-4), (8, 512)),
        (static.Noise(white=2e-3, rounded_angle=1e-4), (1, 4, 16)),
        (static.Noise(white=4e-3, corner=5.0), (256, 1024)),
        (static.Noise(white=4e-3, corner=5.0, order=2), (256, 1024)),
    ],
)
def test_allan_deviation_is_that_of_the_terms(noise: static.Noise, over: tuple[int, ...]) -> None:
    n = 200_000
    values = static.drawn(np.random.default_rng(1), noise, n, 1.0 / RATE)
    level = replace(noise, white=noise.white * static.aliased(noise, 1.0 / RATE), corner=0.0)
    for m in over:
        expected = np.sqrt(float(static.allan_variance(level, np.array(m / RATE))))
        assert static.deviation(values, m) == pytest.approx(expected, rel=RELATIVE * np.sqrt(m / n) + 0.03)


@pytest.mark.parametrize("order", [1, 2])
def test_spectrum_of_a_low_pass_is_that_of_its_poles(order: int) -> None:
    noise = static.Noise(white=4e-3, corner=4.0, order=order)
    values = static.drawn(np.random.default_rng(2), noise, 400_000, 1.0 / 200.0)
    f, power = welch(values, 200.0, nperseg=4096)
    band = (f > 0.5) & (f < 12.0)
    assert np.mean(power[band] / static.spectrum(noise, f[band])) == pytest.approx(1.0, abs=0.02)
    assert static.covariance(noise, np.array([0.0]))[0] == pytest.approx(np.var(values), rel=0.03)


def test_first_order_aliasing_is_the_closed_form() -> None:
    noise = static.Noise(white=1.0, corner=5.0)
    x = np.pi * noise.corner / RATE
    assert static.aliased(noise, 1.0 / RATE) == pytest.approx(np.sqrt(x / np.tanh(x)), rel=1e-9)


def test_a_record_has_lines_rails_counts_and_gaps() -> None:
    noise = static.Noise(white=4e-3, lines=((0.1, 3.0),))
    case = static.still(1, {"x": noise}, 20_000, RATE, counts=0.01, limit=0.15, lost=((100, 50),), jitter=0.05)
    table = case.tables["still.csv"]
    codes = table.columns["gyro_x [count]"]
    assert codes.dtype == np.int64
    assert np.max(np.abs(codes)) == 15
    time = table.columns["unix_s"] - START
    assert len(codes) == 20_000 - 50
    assert np.max(np.diff(time)) == pytest.approx(51 / RATE, rel=0.01)
    power = np.abs(np.exp(-2j * np.pi * 3.0 * time) @ codes) / len(codes) * 2.0 * 0.01
    assert power == pytest.approx(0.1, rel=0.2)
    assert case.words[-1] == "gyro=100.0 count/(deg/s)"


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_rate_table_shows_its_scale_factors(seed: int) -> None:
    gyros = rate_table.Gyros(turn_on=0.05, dwell=0.002, asymmetry=(2e-3, 0.0, -1e-3))
    case = rate_table.reduced(seed, gyros)
    noise = 100.0 * case.noise / np.sqrt(np.sum(np.square(rate_table.Protocol().rates)) * 5)
    for axis, slope in rate_table.slopes(case).items():
        assert slope == pytest.approx(case.truth[f"scale_factor_error {axis}"], abs=4.0 * noise)
    for axis, found in rate_table.asymmetries(case).items():
        assert found == pytest.approx(case.truth[f"scale_factor_asymmetry {axis}"], abs=10.0 * noise)


def test_recordings_of_a_table_hold_the_same_unit() -> None:
    protocol = rate_table.Protocol(axes="x", runs=1)
    case = rate_table.recorded(1, rate_table.Gyros(), protocol)
    table = case.tables["x1.csv"]
    rate = table.columns["table [deg/s]"]
    dwells = [table.columns["gx [deg/s]"][rate == r].mean() for r in protocol.rates]
    slope, _ = np.polyfit(protocol.rates, dwells, 1)
    assert 100.0 * (slope - 1.0) == pytest.approx(case.truth["scale_factor_error x"], abs=0.06)
    assert case.truth == rate_table.reduced(1, rate_table.Gyros(), protocol).truth


def test_another_test_on_one_table_shares_unit_and_table_but_not_noise() -> None:
    gyros = rate_table.Gyros(turn_on=0.01, table_rate=5e-4, fixture=1e-3)
    first, second = rate_table.reduced(1, gyros), rate_table.reduced(1, gyros, again=1)
    assert first.truth == second.truth
    a, b = rate_table.slopes(first), rate_table.slopes(second)
    assert a != b
    assert a["x"] - first.truth["scale_factor_error x"] == pytest.approx(
        b["x"] - first.truth["scale_factor_error x"], abs=0.02
    )


def test_a_chamber_shows_hysteresis_and_lag() -> None:
    unit = thermal.Unit(hysteresis=2e-3, lag=60.0, sample=1e-5, turn_on=0.0, polynomial=(0.0, 1e-4))
    chamber = thermal.Chamber(runs=1, points=(20.0, -20.0, 60.0, -20.0), speeds=(0.02,) * 3, scatter=0.0)
    table = thermal.ramped(1, unit, chamber).tables["run1.csv"]
    t, y = table.columns["temperature [degC]"], table.columns["gyro_x [deg/s]"]
    way = np.sign(np.gradient(t))
    middle = (np.abs(t - 20.0) < 10.0) & (np.arange(len(t)) > 500)
    gap = y[middle & (way > 0)].mean() - y[middle & (way < 0)].mean()
    expected = unit.hysteresis - 2.0 * unit.lag * unit.polynomial[1] * 0.02
    assert gap == pytest.approx(expected, abs=5e-5)


def test_an_element_behind_a_ramp_is_behind_by_its_lag() -> None:
    t = np.concatenate([np.full(10, 20.0), 20.0 + 0.5 * np.arange(200)])
    behind = t - thermal.lagged(t, 60.0, 10.0)
    assert behind[-1] == pytest.approx(0.05 * 60.0, rel=1e-6)


def test_six_faces_give_back_matrix_and_bias() -> None:
    case = positions.six_faces(1, positions.Unit(position=1e-6, sample=1e-6), face_error=0.0)
    matrix, bias = positions.fitted(case)
    for i, axis in enumerate("xyz"):
        assert bias[i] == pytest.approx(case.truth[f"bias {axis} accelerometer"], abs=1e-5)
        assert 100.0 * (matrix[i, i] - 1.0) == pytest.approx(
            case.truth[f"scale_factor_error {axis} accelerometer"], abs=1e-4
        )


def test_a_face_error_repeats_and_its_cosine_is_second_order() -> None:
    quiet = positions.Unit(bias=0.0, scale=0.0, misalignment=0.0, position=1e-9, sample=1e-9)
    case = positions.six_faces(3, quiet, face_error=2.0, repeats=2)
    y = np.column_stack([case.tables["faces.csv"].columns[f"acc_{a}"] for a in "xyz"])
    assert y[:6] == pytest.approx(y[6:], abs=1e-6)
    along = y[0, 0] / positions.G
    across = np.hypot(y[0, 1], y[0, 2]) / positions.G
    assert 1.0 - along == pytest.approx(0.5 * across**2, rel=1e-2)


def test_turns_by_hand_carry_gravity_from_rest_to_rest() -> None:
    unit = positions.Unit(
        bias=0.0, scale=0.0, misalignment=0.0, gyro_bias=0.0, gyro_scale=0.0, gyro_misalignment=0.0, sample=1e-9,
        gyro_sample=1e-9, position=0.0,
    )  # fmt: skip
    case = positions.by_hand(1, unit, positions=10, rest=1.0, first_rest=1.0)
    table = case.tables["hand.csv"]
    f = np.column_stack([table.columns[f"acc_{a} [m/s^2]"] for a in "xyz"])
    w = np.column_stack([table.columns[f"gyro_{a} [rad/s]"] for a in "xyz"])
    assert np.linalg.norm(f, axis=1) == pytest.approx(positions.G, abs=1e-6)
    d = f[0]
    for rate in w:
        d = turned(-rate / case.rate) @ d
    assert d == pytest.approx(f[-1], abs=0.03)  # the earth turns on


@pytest.mark.parametrize("condition", [(50.0, 200.0), (200.0, 1300.0)])
def test_ill_determined_positions_have_the_condition_that_was_asked_for(condition: tuple[float, float]) -> None:
    case = positions.by_hand(2, positions=10, condition=condition, cone=100.0, rest=1.0, first_rest=1.0)
    assert condition[0] <= case.truth["condition"] <= condition[1]


def test_a_lock_in_finds_the_moved_mass() -> None:
    bench = moved_mass.Bench(noise=0.005, shape="exp3", size=10.0, u_applied=0.0)
    case = moved_mass.moved(1, bench)
    assert moved_mass.lock_in(case) == pytest.approx(bench.scale_factor * bench.applied, rel=0.02)


@pytest.mark.parametrize("name", moved_mass.SHAPES)
def test_drifts_have_unit_range(name: str) -> None:
    values = moved_mass.shape(name, 100, np.random.default_rng(1))
    assert np.ptp(values) == pytest.approx(0.0 if name == "none" else 1.0)


def test_half_sums_of_a_flip_are_bias_and_ambient_acceleration() -> None:
    head = flip.Head(white=1.0)
    case = flip.turned(1, head)
    windows = [
        (float(span.split("..")[0]), float(span.split("..")[1].split("=")[0]), int(span.split("=")[1].split()[0]))
        for span in case.words
        if ".." in span
    ]
    bias, ambient = flip.half_sums(case, windows)
    assert bias == pytest.approx(head.bias[1:], abs=0.05)
    assert ambient == pytest.approx(head.ambient[1:], abs=0.05)


def test_one_seed_gives_the_same_bytes_and_another_does_not() -> None:
    first, second, other = (csv_text(flip.turned(seed).tables["head.csv"]) for seed in (1, 1, 2))
    assert first == second
    assert first != other


def test_an_archive_pair_is_named_by_its_times(tmp_path: Path) -> None:
    case = static.still(1, static.Noise(white=1e-6), 1420, 142.0, sensor="acc", pad=True)
    path = write_pad(tmp_path, case.tables["still.csv"])
    assert path.name == "2023_11_14_22_13_20.000-2023_11_14_22_13_29.993.121f03"
    assert (tmp_path / f"{path.name}.header").exists()
    assert len(np.fromfile(path, dtype="<f4")) == 4 * 1420


# Imports


def imported(path: Path) -> tuple[set[str], set[str]]:
    """Return packages that a module imports, and modules of this folder, by their last names."""
    packages, here = set(), set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            packages |= {name.name.split(".")[0] for name in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            packages.add((node.module or "").split(".")[0])
        elif isinstance(node, ast.ImportFrom):
            assert node.level <= len(path.relative_to(FOLDER).parts), f"{path.name}: an import from above the folder"
            here |= {node.module.split(".")[-1]} if node.module else {name.name for name in node.names}
        elif isinstance(node, ast.Call) and getattr(node.func, "id", getattr(node.func, "attr", "")) in (
            "__import__", "import_module",
        ):  # fmt: skip
            pytest.fail(f"{path.name}:{node.lineno}: an import at run time cannot be checked")
    return packages, {name for name in here if name}


def test_each_simulator_is_checked() -> None:
    assert {
        "bases",
        "case",
        "clean",
        "variations",
        "faults",
        "flip",
        "moved_mass",
        "positions",
        "rate_table",
        "static",
        "thermal",
    } <= set(SIMULATORS)


@pytest.mark.parametrize("name", sorted(SIMULATORS))
def test_simulators_import_numpy_scipy_and_each_other_only(name: str) -> None:
    packages, here = imported(SIMULATORS[name])
    assert packages <= ALLOWED, f"{name} imports {packages - ALLOWED}"
    assert here <= set(SIMULATORS), f"{name} imports {here - set(SIMULATORS)}"


def test_a_stepped_supply_shows_both_sensitivities() -> None:
    case = climate.supplied(1, climate.Unit(sample=1e-5, meter=1e-6, thermometer=1e-4))
    for axis in "xy":
        found = climate.plane(case, axis)
        assert found["bias_supply"] == pytest.approx(case.truth[f"bias_supply {axis}"], rel=1e-3)
        assert found["bias_supply_temperature"] == pytest.approx(
            case.truth[f"bias_supply_temperature {axis}"], rel=1e-2
        )


def test_a_table_in_a_chamber_shows_its_scale_factor() -> None:
    case = climate.on_table(1, climate.Unit(sample=1e-6))
    table = case.tables["run1.csv"]
    e, d = table.columns["temperature [degC]"] - 20.0, table.columns["supply [V]"] - 5.0
    rate = table.columns["table [deg/s]"]
    design = np.column_stack([rate, rate * e, rate * d, *(e**k for k in range(3)), d, d * e])
    found, *_ = np.linalg.lstsq(design, table.columns["gyro_x [deg/s]"], rcond=None)
    assert 100.0 * found[1] == pytest.approx(case.truth["scale_factor_error_temperature_1 x"], rel=1e-2)
    assert 100.0 * found[2] == pytest.approx(case.truth["scale_factor_error_supply x"], rel=1e-2)


def test_a_unit_that_is_pumped_out_steps_and_one_switched_on_dies_away() -> None:
    unit = climate.Unit(vacuum=(0.04, 3e-4), sample=1e-6, polynomial=(0.02,) * 2, thermometer=0.0)
    table = climate.pumped(1, unit, runs=1).tables["run1.csv"]
    pressure, y = table.columns["pressure [Pa]"], table.columns["gyro_x [deg/s]"]
    at_20 = np.abs(table.columns["temperature [degC]"] - 20.0) < 1.0
    step = y[at_20 & (pressure < 1.0)].mean() - y[at_20 & (pressure > 1.0)].mean()
    assert step == pytest.approx(0.04, rel=1e-3)
    unit = climate.Unit(warm_up=((0.03, 0.0, 200.0),), sample=1e-7, turn_on=0.0, polynomial=(0.0, 0.0))
    table = climate.warming(1, unit, starts=(20.0,), runs=1).tables["run1.csv"]
    y = table.columns["gyro_x [deg/s]"]
    assert y[20] == pytest.approx(0.03 * np.exp(-1.0), rel=1e-3)

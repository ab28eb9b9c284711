"""Alignment at rest: published figures, truth recovered, coverage, what breaks it."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from aligned_units import Array, drawn, hits, plan, readings, reduced, standards, truths
from scipy.spatial.transform import Rotation

import inertialcal as ic
from independent.coverage import keeps
from independent.orbit.aligned import EARTH, HOUR, Bench, G, Made, made
from inertialcal.core.errors import DataError, UsageError
from inertialcal.core.estimate import Component, Estimate
from inertialcal.core.key import Key, Origin
from inertialcal.core.recording import Channel, Recording
from inertialcal.procedures.alignment.keys import HEADING, keys_of
from inertialcal.procedures.alignment.readings import readings_from
from inertialcal.procedures.alignment.reduction import Result, long_run, reduce
from inertialcal.procedures.alignment.solving import Inputs, attitude, changes, quaternion, solve
from inertialcal.procedures.corrections import BiasCorrection
from inertialcal.procedures.protocol import Facts
from sized import sized

SHORT = Bench(seconds=300.0, step=0.5)
ONE = replace(SHORT, turns=())
LATITUDE = math.radians(36.6)


def codes(result: Result) -> set[str]:
    return {one.code for one in result.remarks}


def row(result: Result, quantity: str, axis: str = "") -> Any:
    return next(one for one in result.rows() if one.key.quantity == quantity and one.axis == axis)


def perfect(bench: Bench) -> Inputs:
    """Return what a unit without noise reads in its positions."""
    one = made(replace(bench, gyro_noise=1e-9, acc_noise=1e-9), np.random.default_rng(1))
    means = [(one.acc[a:b].mean(axis=0), one.gyro[a:b].mean(axis=0)) for a, b in one.spans]
    turns = np.concatenate([[0.0], np.cumsum(np.radians(bench.turns))])
    return Inputs(np.array([a for a, _ in means]), np.array([g for _, g in means]), turns,
                  math.radians(bench.latitude), bench.gravity, bench.z_up)  # fmt: skip


# ---- published figures -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("bias", "printed"), [("0.01 deg/h", "0.047"), ("0.01 deg/s", "171")])
def test_uncertainty_by_the_bias_is_as_printed(bias: str, printed: str) -> None:
    """u(heading) = u(bias) / (earth rate x cos latitude)."""
    u = math.radians(0.01) / (3600.0 if bias.endswith("h") else 1.0)
    _, result = reduced(replace(ONE, gyro_noise=1e-6, pitch=0.0, roll=0.0), 1, gyro_bias_u=u)
    assert f"{math.degrees(result.forecast):.{3 if printed == '171' else 2}g}" == printed
    assert result.told == (printed != "171")
    if not result.told:
        assert row(result, HEADING).reason.code == "gyro_too_coarse"
        assert "171 deg" in row(result, HEADING).reason.text


def test_a_level_unit_has_the_closed_forms_of_the_books() -> None:
    """A bias east over the level rate; a tilt about north by the tangent of the latitude (Titterton and Weston)."""
    given = perfect(replace(ONE, heading=0.0, pitch=0.0, roll=0.0))
    gain = changes(given)
    heading, horizontal = 2, EARTH * math.cos(LATITUDE)
    assert gain["gyro"][heading] == pytest.approx([0.0, -1.0 / horizontal, 0.0], abs=1e-3 / horizontal)
    assert gain["acc"][heading] == pytest.approx([0.0, math.tan(LATITUDE) / given.gravity, 0.0], abs=1e-5)
    assert gain["acc"][0] == pytest.approx([0.0, -1.0 / given.gravity, 0.0], abs=1e-6)  # roll
    assert gain["acc"][1] == pytest.approx([1.0 / given.gravity, 0.0, 0.0], abs=1e-6)  # pitch


def test_covariance_of_the_attitude_is_that_of_triad() -> None:
    """Shuster and Oh, equation (53) by differences: gravity is taken as exact first, then the rate of the earth."""
    given = perfect(replace(ONE, heading=70.0, pitch=12.0, roll=-20.0))
    gain, sigma = changes(given), (1e-3, 1e-8)  # [m/s^2], [rad/s]
    rows = [(gain["acc"][:3], sigma[0]), (gain["gyro"][:3], sigma[1])]
    angles = sum(one @ one.T * s**2 for one, s in rows)
    found = solve(given)
    pitch, heading = float(found.pitch[0]), float(found.heading[0])
    c, s = math.cos(heading), math.sin(heading)
    turn = np.array([[math.cos(pitch) * c, -s, 0.0], [math.cos(pitch) * s, c, 0.0], [-math.sin(pitch), 0.0, 1.0]])
    own = turn @ angles @ turn.T  # of a small turn in north, east, down
    first, second = sigma[0] / given.gravity, sigma[1] / EARTH  # of unit vectors
    down, earth = np.array([0.0, 0.0, 1.0]), np.array([math.cos(LATITUDE), 0.0, -math.sin(LATITUDE)])
    cross = np.cross(down, earth)
    # P = s1^2 I + ((s2^2 - s1^2) d d' + s1^2 (d.e)(d e' + e d')) / |d x e|^2, d gravity and e the axis of the earth
    both = np.outer(down, earth)
    more = (second**2 - first**2) * np.outer(down, down) + first**2 * float(down @ earth) * (both + both.T)
    triad = first**2 * np.eye(3) + more / float(cross @ cross)
    assert own == pytest.approx(triad, rel=1e-4, abs=1e-4 * first**2)


def test_two_positions_cancel_a_constant_bias() -> None:
    """Its heading does not change with a bias that both have, however large; nor has roll to be small."""
    for bench in (SHORT, replace(SHORT, z_up=True, roll=5.0, pitch=-8.0, turns=(90.0, 90.0))):
        given = perfect(bench)
        moved = replace(given, gyro=given.gyro + np.array([30.0, -50.0, 20.0]) * HOUR)
        gain = changes(given)["gyro"].reshape(-1, len(given.acc), 3).sum(axis=1)
        headings = [at for at, key in enumerate(keys_of(len(given.acc))) if key.quantity == HEADING]
        assert np.max(np.abs(gain[headings])) * HOUR < 1e-6
        assert solve(moved).heading == pytest.approx(solve(given).heading, abs=1e-7)
        assert (solve(moved).bias - solve(given).bias) / HOUR == pytest.approx([30.0, -50.0, 20.0], abs=1e-5)


def test_half_a_turn_halves_what_the_noise_of_a_reading_does() -> None:
    """u = sigma / (sqrt(2) x level rate): two readings, each of twice the signal."""
    found = solve(perfect(SHORT))
    assert found.spread == pytest.approx([0.5, 0.5], rel=1e-3)
    assert found.dof == 2


# ---- truth recovered ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(1, 9))
def test_without_noise_the_truth_comes_out(seed: int) -> None:
    """Any attitude and number of positions, z up or down, north and south."""
    rng = np.random.default_rng(seed)
    turns = [(), (180.0,), (90.0, 90.0, 90.0), (-120.0, 240.0)][seed % 4]
    bench = replace(SHORT, heading=float(rng.uniform(0.0, 360.0)), pitch=float(rng.uniform(-40.0, 40.0)),
                    roll=float(rng.uniform(-40.0, 40.0)), z_up=bool(seed % 2), turns=turns,
                    latitude=float(rng.uniform(-75.0, 75.0)), gyro_noise=1e-6, acc_noise=1e-6)  # fmt: skip
    bias = rng.normal(0.0, 3.0, 3) if turns else np.zeros(3)
    one, result = reduced(replace(bench, gyro_bias=tuple(bias)), seed)
    true = truths(one, bias * HOUR if turns else None)
    for key, value in zip(result.estimate.names, result.estimate.values, strict=True):
        if key in true:
            assert math.remainder(value - true[key], 2.0 * math.pi) == pytest.approx(0.0, abs=1e-5), key
    for own, matrix in zip(result.attitudes, one.attitudes, strict=True):
        assert own.matrix == pytest.approx(matrix, abs=1e-5)
        assert Rotation.from_quat(np.roll(own.quaternion, -1)).as_matrix() == pytest.approx(own.matrix, abs=1e-12)


def test_quaternions_are_those_of_their_matrices() -> None:
    for one in Rotation.random(200, rng=5):
        found = quaternion(one.as_matrix())
        assert found[0] >= 0.0
        assert Rotation.from_quat(np.roll(found, -1)).as_matrix() == pytest.approx(one.as_matrix(), abs=1e-12)
    assert np.linalg.det(attitude(0.1, 0.2, 0.3, True)) == pytest.approx(1.0)


def test_a_file_and_arrays_give_the_same(tmp_path: Path) -> None:
    one = made(replace(SHORT, gyro_bias=(1.0, -2.0, 1.5)), np.random.default_rng(3))
    path = one.write(tmp_path / "imu.csv")
    found = ic.alignment(path, latitude="36.6 deg", gravity="9.799 m/s2", turns="180 deg")
    own = reduce(plan(one.bench), readings(one))
    for name in ("roll at 1", "heading at 2", "gyro_bias_x"):
        close = 0.2 * float(own.estimate.u[own.estimate.index(name)])  # ends of rests, digits written
        assert found.result.estimate.value(name) == pytest.approx(own.estimate.value(name), abs=close)
    content = found.tested[0].result.attitudes
    assert len(content) == 2
    assert np.all(np.linalg.eigvalsh(content[0].covariance) > 0.0)


def test_a_turn_is_measured_where_it_is_recorded(tmp_path: Path) -> None:
    bench = replace(SHORT, turns=(90.0, 123.0), step=0.1)
    path = made(bench, np.random.default_rng(4)).write(tmp_path / "imu.csv")
    found = ic.alignment(path, latitude="36.6 deg", gravity="9.799 m/s2",
                         standards={"sensor.scale_factor": "100 ppm"}).result  # fmt: skip
    assert np.degrees(found.given.turns) == pytest.approx([0.0, 90.0, 213.0], abs=0.02)
    assert found.measured
    shares = found.estimate.shared("heading at 3")
    assert abs(shares["sensor.scale_factor[gyro z]"]) > math.radians(0.003)


# ---- coverage ----------------------------------------------------------------------------------------------------

FOUR = (90.0, 90.0, 90.0)
CASES: dict[str, tuple[Bench, float, float, dict[str, Any]]] = {
    "two": (SHORT, 5.0, 0.0, {}),
    "two_that_drift": (replace(SHORT, redrawn=0.3), 5.0, 0.0, {}),
    "two_with_memory": (replace(SHORT, slow=0.2, memory=15.0), 5.0, 0.0, {}),
    "two_tilted_by_bias": (SHORT, 5.0, 0.5, {"accelerometer_bias_u": 0.5e-3 * G}),
    "two_near_the_limit": (replace(SHORT, redrawn=2.0, gyro_noise=1.0), 20.0, 0.0, {}),
    "four": (replace(SHORT, turns=FOUR, redrawn=0.3), 5.0, 0.0, {}),
    "four_near_the_limit": (replace(SHORT, turns=FOUR, redrawn=4.0), 20.0, 0.0, {}),
    "one": (ONE, 0.3, 0.0, {}),
    "one_stated": (ONE, 0.3, 0.0, {"gyro_bias_u": 0.3 * HOUR}),
    "one_near_the_limit": (ONE, 4.0, 0.0, {"gyro_bias_u": 4.0 * HOUR}),
    "z_up": (replace(SHORT, z_up=True), 5.0, 0.0, {}),
}  # fmt: skip


def coverage(name: str, n: int) -> tuple[dict[str, tuple[int, int]], Counter[str]]:
    """Return hits and intervals by figure, and remarks, over seeds 1 to n."""
    bench, gyro, acc, settings = CASES[name]
    count: Counter[str] = Counter()
    held: Counter[str] = Counter()
    said: Counter[str] = Counter()
    for seed in range(1, n + 1):
        rng = np.random.default_rng([7, seed])
        own = drawn(bench, rng, gyro, acc)
        one = made(own, rng)
        result = reduce(plan(own, **settings), readings(one))
        bias = np.array(own.gyro_bias) * HOUR if not bench.redrawn and bench.turns else None
        for key, hit in hits(one, result, bias).items():
            count[key] += 1
            held[key] += hit
        said.update(codes(result))
    return {key: (held[key], count[key]) for key in count}, said


SOUND = {"relative_to_fixture", "gyro_too_coarse", "bias_larger"}


@pytest.mark.parametrize("name", ["two", "one_near_the_limit"])
def test_intervals_hold(name: str) -> None:
    found, said = coverage(name, 15)
    assert all(keeps("holds", hit, n) for hit, n in found.values()), found
    assert set(said) <= SOUND


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_intervals_hold_over_many(name: str) -> None:
    n = sized(300, 100)
    found, said = coverage(name, n)
    assert all(keeps("holds", hit, of) for hit, of in found.values()), found
    assert sum(many for code, many in said.items() if code not in SOUND) <= 0.03 * n, said


@pytest.mark.slow
def test_coarse_gyros_tell_no_heading() -> None:
    """36 deg/h of bias in one position: a heading comes out in at most one of a hundred."""
    told = 0
    for seed in range(1, sized(301, 101)):
        rng = np.random.default_rng([11, seed])
        own = drawn(ONE, rng, 36.0)
        told += reduce(plan(own), readings(made(own, rng))).told
    assert told <= 3


# ---- standards, biases, corrections --------------------------------------------------------------------------------


def test_each_standard_has_the_size_of_its_closed_form() -> None:
    sizes = standards(turn__angle=(1e-3, "rad"), fixture__mounting=(2e-3, "rad"), site__latitude=(1e-3, "rad"),
                      gravity__value=(1e-4, "m/s^2"), sensor__misalignment=(1e-4, "rad"))  # fmt: skip
    _, result = reduced(replace(SHORT, pitch=0.0, roll=0.0, heading=0.0), 1, standards=sizes, deflection_u=1e-4)
    shares = {name: result.estimate.shared(name) for name in ("heading at 1", "heading at 2", "roll at 1")}
    assert abs(shares["heading at 1"]["turn.angle[2]"]) == pytest.approx(0.5e-3, rel=1e-2)  # half to each
    assert abs(shares["heading at 2"]["turn.angle[2]"]) == pytest.approx(0.5e-3, rel=1e-2)
    assert abs(shares["heading at 1"]["fixture.mounting[z]"]) == pytest.approx(2e-3, rel=1e-2)
    assert abs(shares["roll at 1"]["fixture.mounting[x]"]) == pytest.approx(2e-3, rel=1e-2)
    assert abs(shares["roll at 1"]["sensor.misalignment[accelerometer yz]"]) == pytest.approx(1e-4, rel=1e-2)
    vertical = abs(result.estimate.shared("gyro_bias_z")["site.latitude"])
    assert vertical == pytest.approx(1e-3 * EARTH * math.cos(LATITUDE), rel=1e-2)
    assert result.estimate.shared("gravity_excess")["gravity.value"] == pytest.approx(-1e-4)
    plumb = next(one for one in result.estimate.components if one.source == "deflection of the vertical")
    at = result.estimate.index("heading at 1")
    assert plumb.u[at] == pytest.approx(1e-4 * math.tan(LATITUDE), rel=1e-2)
    assert "relative_to_fixture" in codes(result)


def test_a_stated_bias_that_is_too_small_is_told_and_widened() -> None:
    _, sound = reduced(ONE, 1, gyro_bias_u=0.02 * HOUR)
    assert "bias_larger" not in codes(sound)
    _, result = reduced(replace(ONE, gyro_bias=(0.5, 0.5, -0.6)), 1, gyro_bias_u=0.02 * HOUR)
    assert "bias_larger" in codes(result)
    assert result.whole.u[2] > 5.0 * sound.whole.u[2]


@dataclass
class Given:
    """A recording as the procedure gets it."""

    name: str
    facts: Facts
    recording: Recording
    file: str = "imu.csv"
    remarks: tuple[Any, ...] = ()
    parts: list[tuple[str, Recording]] = field(default_factory=list)

    def recordings(self) -> list[tuple[str, Recording]]:
        return self.parts or [("", self.recording)]


def given(one: Made, first: int = 0, stop: int | None = None) -> list[Any]:
    """Return both triads of a record."""
    found = []
    for kind, unit, values in (("accelerometer", "m/s^2", one.acc), ("gyro", "rad/s", one.gyro)):
        channels = tuple(Channel(axis, values[first:stop, i], unit) for i, axis in enumerate("xyz"))
        recording = Recording(channels, None, one.bench.step)
        found.append(Given(f"{kind}_{first}", Facts(kind, unit, unit), recording))  # type: ignore[arg-type]
    return found


def correction(bias: Array, u: float) -> BiasCorrection:
    changes_of = np.eye(3) * u
    parts = (Component(Origin("thermal fit", test="chamber"), "A", changes_of @ changes_of, 20.0, changes=changes_of),)
    keys = tuple(Key("bias", axis) for axis in "xyz")
    return BiasCorrection("chamber", Estimate(keys, bias, ("rad/s",) * 3, parts))


def test_a_bias_that_was_taken_off_brings_its_uncertainty() -> None:
    """One position: as a stated bias does; two positions: the heading does not change, and the bias left is small."""
    bias, u = np.array([2.0, -1.0, 3.0]), 0.05 * HOUR
    one = made(replace(ONE, gyro_bias=tuple(bias)), np.random.default_rng(6))
    taken = correction(bias * HOUR, u)
    own = plan(one.bench)
    result = reduce(own, readings_from(own, given(one), [taken]))
    assert result.stated
    assert result.forecast == pytest.approx(u / (EARTH * math.cos(LATITUDE)), rel=0.1)
    assert hits(one, result)["heading"]
    two = made(replace(SHORT, gyro_bias=tuple(bias)), np.random.default_rng(6))
    own = plan(two.bench)
    before, after = (reduce(own, readings_from(own, given(two), each)) for each in ([], [taken]))
    assert after.solution.heading == pytest.approx(before.solution.heading, abs=1e-9)
    assert before.solution.bias - after.solution.bias == pytest.approx(bias * HOUR, abs=1e-12)
    at = after.whole.index("gyro_bias_x")
    assert after.whole.u[at] ** 2 == pytest.approx(before.whole.u[at] ** 2 + u**2, rel=1e-6)


# ---- what breaks it ------------------------------------------------------------------------------------------------


def refused(one: Made, **more: Any) -> set[str]:
    with pytest.raises(DataError) as error:
        reduce(plan(one.bench, **more), readings(one))
    return {problem.code for problem in error.value.problems}


BROKEN: dict[str, tuple[Bench, dict[str, Any], str]] = {
    "latitude": (SHORT, {"latitude": -LATITUDE}, "wrong_sense"),
    "latitude_of_one": (ONE, {"latitude": -LATITUDE}, "wrong_sense"),
    "gyros_reversed": (replace(SHORT, gyro_matrix=-np.eye(3)), {}, "wrong_sense"),
    "y_and_z_of_gyros": (replace(ONE, gyro_matrix=np.eye(3)[[0, 2, 1]]), {}, "axes_disagree"),
    "deg_for_rad": (replace(SHORT, gyro_matrix=np.eye(3) * 180.0 / math.pi), {}, "wrong_unit"),
    "deg_for_rad_of_one": (replace(ONE, gyro_noise=0.01, gyro_matrix=np.eye(3) * math.pi / 180.0), {}, "wrong_unit"),
    "g_for_si": (replace(ONE, acc_matrix=np.eye(3) / G), {}, "wrong_unit"),
    "stepped": (replace(ONE, step_at=0.2), {}, "base_moved"),
    "not_turned": (replace(SHORT, turns=(2.0,)), {}, "not_turned"),
}


@pytest.mark.parametrize("name", BROKEN)
def test_what_is_wrong_is_refused(name: str) -> None:
    bench, settings, code = BROKEN[name]
    assert refused(made(replace(bench, heading=200.0), np.random.default_rng(1)), **settings) == {code}


NAMED: dict[str, tuple[Bench, str]] = {
    "drift": (replace(SHORT, drift=(2.0, 0.0, 0.0)), "bias_drifts"),
    "base_tilts": (replace(ONE, tilting=0.02), "base_tilts"),
    "people": (replace(SHORT, sway=0.003, step=0.1), "base_sways"),
    "accelerometers": (replace(ONE, acc_bias=(0.0, 0.0, 5.0)), "gravity_differs"),
    "coarse": (replace(SHORT, redrawn=40.0, gyro_noise=30.0), "gyro_too_coarse"),
    "near_a_pole": (replace(SHORT, latitude=89.99), "gyro_too_coarse"),
}


@pytest.mark.parametrize("name", NAMED)
def test_what_is_doubtful_is_named(name: str) -> None:
    bench, code = NAMED[name]
    _, result = reduced(bench, 2)
    assert code in codes(result)


def test_a_pole_says_why() -> None:
    _, result = reduced(replace(SHORT, latitude=89.99), 2)
    assert "of the earth in level at 89.99 deg of latitude" in row(result, HEADING).reason.text


def test_x_that_stands_has_no_azimuth() -> None:
    _, result = reduced(replace(SHORT, pitch=85.0), 1)
    assert row(result, HEADING).reason.code == "x_vertical"
    assert row(result, "roll").status == "not_estimated"


def test_a_stated_turn_must_be_about_the_vertical() -> None:
    one, other = (made(replace(ONE, roll=roll), np.random.default_rng(3)) for roll in (0.0, 20.0))
    both = replace(readings(one), positions=(*readings(one).positions, *readings(other).positions))
    with pytest.raises(DataError, match="not by how much the heading grew"):
        reduce(replace(plan(one.bench), turns="180 deg"), both)
    with pytest.raises(DataError, match="is not said"):
        reduce(replace(plan(one.bench), turns=None), both)


@pytest.mark.parametrize(
    ("said", "code"), [("170 deg", "turn_differs"), ("-90 deg", "wrong_sense"), ("0.09 deg", "clock_unit")]
)
def test_a_stated_turn_must_be_that_of_the_gyros(said: str, code: str) -> None:
    one = made(replace(SHORT, turns=(90.0,), step=0.1), np.random.default_rng(3))
    own = replace(plan(one.bench), turns=said)
    with pytest.raises(DataError) as error:
        reduce(own, readings_from(own, given(one)))
    assert error.value.problems[0].code == code


def test_a_copied_position_is_refused() -> None:
    one = made(ONE, np.random.default_rng(3))
    with pytest.raises(DataError, match="hold the same readings"):
        readings_from(plan(one.bench), [*given(one), *given(one)])


def test_a_record_of_the_wrong_length_is_refused() -> None:
    one = made(replace(ONE, seconds=20.0, step=0.1), np.random.default_rng(3))
    with pytest.raises(DataError, match="the record lasts"):
        readings_from(plan(one.bench), given(one))


@pytest.mark.parametrize("text", ["half", "180", "90 deg, 90 deg, 90 deg"])
def test_turns_that_cannot_be_meant(text: str) -> None:
    one = made(SHORT, np.random.default_rng(1))
    with pytest.raises(UsageError):
        reduce(replace(plan(one.bench), turns=text), readings(one))


def test_without_a_latitude_there_is_no_heading(tmp_path: Path) -> None:
    path = made(ONE, np.random.default_rng(3)).write(tmp_path / "imu.csv")
    with pytest.raises(UsageError, match="needs the latitude"):
        ic.alignment(path)


def test_a_knock_is_left_out(tmp_path: Path) -> None:
    one = made(replace(ONE, step=0.1), np.random.default_rng(3))
    one.gyro[1500:1510] += np.radians(2.0) * np.sin(np.linspace(0.0, 2.0 * np.pi, 10))[:, None]
    result = ic.alignment(one.write(tmp_path / "imu.csv"), latitude="36.6 deg", gravity="9.799 m/s2").result
    assert len(result.readings) == 1
    assert hits(one, result)["heading"]


def test_means_of_noise_with_a_memory() -> None:
    """The lowest cosines tell the variance of a mean whose noise remembers for a twentieth of the record."""
    rng, n, keep = np.random.default_rng(4), 240, math.exp(-1.0 / 6.0)
    means, told = [], []
    for _ in range(300):
        noise = rng.normal(size=n + 100)
        for k in range(1, len(noise)):
            noise[k] += keep * noise[k - 1]
        part = noise[100:, None]
        means.append(float(part.mean()))
        told.append(float(long_run(part - part.mean())[0][0, 0]))
    assert np.mean(told) == pytest.approx(np.var(means), rel=0.25)


# ---- real records --------------------------------------------------------------------------------------------------


def test_a_real_coarse_gyro_tells_no_heading(shared: Path) -> None:
    folder = shared / "data/sunsided_mpu6050_static/set-1__unmoved-x-pointing-forward"
    found = []
    for name, group, unit in (("accelerometer", "acc", "g"), ("gyroscope", "gyro", "deg/s")):
        one = ic.read(folder / f"mpu6050_{name}.mat")
        channels = tuple(Channel(f"{group}_{axis} [{unit}]", channel.data, unit, axis=axis, quantity=group)
                         for axis, channel in zip("xyz", one.channels[-3:], strict=True))  # fmt: skip
        found.append(replace(one, channels=channels))
    result = ic.alignment(found, latitude="52.5 deg").result
    assert not result.told
    assert {"gyro_too_coarse", "gravity_differs"} <= codes(result)
    assert math.degrees(result.estimate.value("pitch")) == pytest.approx(1.16, abs=0.01)

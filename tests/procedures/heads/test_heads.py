"""Heads on one body: printed sizes, truth recovered, coverage, what breaks it."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation
from scipy.stats import t as student

import inertialcal as ic
from independent.coverage import keeps
from independent.orbit.heads import ORBIT, UG, Made, Placed, Scene, made, on_line
from inertialcal.physics.motion.body import Mounted, parse_body
from inertialcal.procedures.heads.contrasts import long_run, redundant, weights_for
from inertialcal.procedures.heads.found import off_line_covariance
from inertialcal.procedures.heads.plan import Plan
from inertialcal.procedures.heads.readings import Readings, Track
from inertialcal.procedures.heads.reduction import Result, reduce
from sized import sized

Array = NDArray[np.float64]
MOTION = """
[motion]
altitude = "400 km"
vertical = [1.0, 0.0, 0.0]
vertical_u = "0.5 deg"
"""
BOUNDED = (
    f'{MOTION}rate = ["0 rad/s", "{-ORBIT} rad/s", "0 rad/s"]\nrate_u = "1e-5 rad/s"\nacceleration_u = "2e-8 rad/s^2"'
)
OFF = (Placed("a", (0.0, 0.0, 0.0)), Placed("b", (0.0, 2.0, 0.0)), Placed("c", (0.7, 1.5, 0.4), False))
FOUR = (*OFF[:2], Placed("d", (1.5, 0.2, 0.0)), Placed("e", (0.0, 0.3, 1.2)), Placed("c", (0.5, 1.0, 0.3), False),
        Placed("f", (1.0, 1.2, -0.4), False, turned=(0.0, 0.0, 1.5707963267948966)))  # fmt: skip


def readings(one: Made, biases: bool = True, motion: str = "", gyro: bool = False) -> Readings:
    """Return what heads read as the procedure has it, without files."""
    body = parse_body(one.toml(biases, motion).encode(), "body.toml")
    step = one.scene.step
    tracks = tuple(Track(one.times, one.read[name], step, mounted, name) for name, mounted in body.heads.items())
    track = Track(one.times, one.gyro, step, Mounted("gyro", np.zeros(3), np.eye(3)), "gyro") if gyro else None
    return Readings(tracks, body.motion, track)


def reduced(scene: Scene, seed: int, plan: Plan | None = None, **said: object) -> tuple[Made, Result]:
    one = made(scene, np.random.default_rng(seed))
    return one, reduce(plan or Plan(), readings(one, **said))  # type: ignore[arg-type]


def codes(result: Result) -> set[str]:
    return {one.code for one in result.remarks}


# ---- printed sizes -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("s", "growth"), [(0.5, "0.707"), (2.0, "2.24"), (0.0, "1"), (1.0, "1")])
def test_uncertainty_grows_as_printed(s: float, growth: str) -> None:
    found = weights_for(np.array([[0.0, 0.0, 0.0], [0.0, 3.0, 0.0]]), np.array([0.0, 3.0 * s, 0.0]))
    assert found.weights == pytest.approx([1.0 - s, s])
    assert f"{found.growth:.3g}" == growth
    assert found.off == pytest.approx(np.zeros(3), abs=1e-12)


def test_a_metre_off_the_line_costs_what_is_printed() -> None:
    """0.2 ug, as half width of the 95 % interval, at 1e-6 rad/s2."""
    one = made(on_line(seconds=400.0), np.random.default_rng(1))
    own = readings(one, motion='[motion]\nrate_u = "0 rad/s"\nacceleration_u = "1e-6 rad/s^2"')
    covariance = off_line_covariance(reduce(Plan(), own), np.array([0.0, 0.0, 1.0]))[1]
    assert f"{1.96 * np.sqrt(covariance[0, 0]) / UG:.1f}" == "0.2"
    assert covariance[2, 2] == pytest.approx(0.0, abs=1e-30)


def test_gradient_of_gravity_is_that_of_a_point() -> None:
    """3.58e-6 m/s2 over a metre at 560 km."""
    text = '[heads.a]\nposition = ["0 m", "0 m", "0 m"]\n[motion]\naltitude = "560 km"\nvertical = [1, 0, 0]'
    body = parse_body(text.encode(), "body.toml")
    assert body.motion.orbit is not None
    assert 3.0 * body.motion.orbit**2 == pytest.approx(3.58e-6, rel=5e-3)  # by the mean radius


# ---- weights and means -------------------------------------------------------------------------------------------


def test_weights_tell_any_linear_field() -> None:
    rng = np.random.default_rng(2)
    places, wanted = rng.normal(size=(5, 3)), rng.normal(size=3)
    gamma, level = rng.normal(size=(3, 3)), rng.normal(size=3)
    found = weights_for(places, wanted)
    assert found.weights.sum() == pytest.approx(1.0)
    assert found.weights @ (places @ gamma.T + level) == pytest.approx(gamma @ wanted + level)
    for combination in redundant(places):
        assert combination @ (places @ gamma.T + level) == pytest.approx(np.zeros(3), abs=1e-12)


def test_off_a_line_the_nearest_place_is_told() -> None:
    found = weights_for(np.array([[0.0, 0.0, 0.0], [0.0, 2.0, 0.0]]), np.array([0.3, 0.5, -0.4]))
    assert found.weights == pytest.approx([0.75, 0.25])
    assert found.off == pytest.approx([0.3, 0.0, -0.4])


@pytest.mark.parametrize(("memory", "low", "high"), [(0.0, 1.12, 1.21), (0.05, 0.94, 1.06)])
def test_a_mean_is_known_as_well_as_noise_of_that_memory_makes_it(memory: float, low: float, high: float) -> None:
    """Over the variance of the mean: 1.17 in white noise, 1 where noise remembers for a twentieth of the record."""
    n, keep = 600, float(np.exp(-1.0 / (600 * memory))) if memory else 0.0
    drawn = np.random.default_rng(4).normal(0.0, np.sqrt(1.0 - keep**2), (3 * n, 6000))
    series = lfilter([1.0], [1.0, -keep], drawn, axis=0)[-n:]
    covariance = [long_run(one - one.mean(axis=0))[0] for one in np.split(series, 200, axis=1)]
    stated = float(np.mean([np.diag(one).mean() for one in covariance]))
    assert low < stated / float(np.var(series.mean(axis=0))) < high


# ---- truth recovered ---------------------------------------------------------------------------------------------


def test_without_noise_the_truth_comes_out() -> None:
    """On the line and off it, with the motion of a gyro; a head that is turned."""
    scene = Scene(FOUR, noise=1e-14, slow=0.0, orientation_u=0.0, bias_u=1e-12, vibration=1e-5)
    one, result = reduced(scene, 5, Plan(scale_factor="none"), motion=MOTION)
    for head in result.heads:
        place = {key: value for key, value in zip(result.estimate.keys, result.estimate.values, strict=True)  # type: ignore[union-attr]
                 if key.quantity == "bias" and key.at is not None and int(key.at.value) == head.number}  # fmt: skip
        assert np.max(np.abs(np.array(list(place.values())) - one.bias[head.name])) < 1e-10


def test_with_a_gyro_a_head_off_the_line_is_told() -> None:
    scene = Scene(OFF, noise=1e-13, slow=0.0, orientation_u=0.0, bias_u=1e-12)
    one, result = reduced(scene, 6, Plan(scale_factor="none"), motion=MOTION, gyro=True)
    assert result.estimate is not None
    assert np.max(np.abs(result.estimate.values[3:6] - one.bias["c"])) < 2e-9


def test_scale_factor_and_misalignment_are_found_where_motion_carries_them() -> None:
    gain = np.array([[2e-3, 0.0, 4e-3], [0.0, -3e-3, 0.0], [0.0, 1e-3, 0.0]])
    heads = (*on_line().heads[:2], replace(on_line().heads[2], gain=gain))
    _, result = reduced(Scene(heads, orientation_u=0.0, vibration=500.0 * UG), 7)
    assert result.estimate is not None
    for key, true in ((("scale_factor_error", "x"), 2e-3), (("scale_factor_error", "y"), -3e-3),
                      (("misalignment", "xz"), 4e-3)):  # fmt: skip
        name = "_".join(key)
        u = float(result.estimate.u[result.estimate.index(name)])
        assert abs(result.estimate.value(name) - true) < 5e-4
        assert u < 3e-4
    _, quiet = reduced(replace(on_line(), vibration=1.0 * UG), 7)
    rows = {(row.key.quantity, row.key.axis): row for row in quiet.rows()}
    assert rows["scale_factor_error", "x"].reason.code == "quiet"


def test_file_and_arrays_give_the_same(tmp_path: Path) -> None:
    one = made(on_line(), np.random.default_rng(8))
    body = tmp_path / "body.toml"
    body.write_text(one.toml(True), encoding="utf-8")
    found = ic.heads(one.write(tmp_path), body=str(body))
    own = reduce(Plan(), readings(one)).estimate
    assert own is not None
    assert found.result.estimate.values == pytest.approx(own.values, rel=1e-5, abs=1e-10)  # of digits written
    assert [row.key.quantity for row in found.rows][:6] == ["relative_bias"] * 3 + ["bias"] * 3


# ---- coverage ----------------------------------------------------------------------------------------------------

CASES: dict[str, tuple[Scene, dict[str, object]]] = {
    "on_line": (on_line(0.3), {}),
    "outside": (on_line(2.0), {}),
    "relative": (on_line(0.5), {"biases": False}),
    "off_line": (Scene(OFF), {"motion": BOUNDED}),
    "gyro": (Scene(OFF), {"motion": MOTION, "gyro": True}),
    "several": (Scene(FOUR), {"motion": MOTION, "gyro": True}),
    "slow_noise": (on_line(0.5, slow=2.0 * UG, memory=40.0), {}),
    "twentieth": (on_line(0.5, noise=0.3 * UG, slow=2.0 * UG, memory=60.0), {}),
    "late": (Scene((*OFF[:2], replace(on_line().heads[2], ahead=0.7))), {}),
}


def coverage(name: str, n: int) -> tuple[Counter[str], Counter[str], int]:
    """Return hits by quantity, remarks, and figures a campaign of each quantity."""
    hits: Counter[str] = Counter()
    count: Counter[str] = Counter()
    said: Counter[str] = Counter()
    scene, settings = CASES[name]
    for seed in range(1, n + 1):
        one, result = reduced(replace(scene, seconds=1200.0), seed, None, **settings)
        assert result.estimate is not None
        for key, value, u, dof in zip(result.estimate.keys, result.estimate.values, result.estimate.u,
                                      result.estimate.dof, strict=True):  # fmt: skip
            head = result.heads[0] if key.at is None else next(h for h in result.heads if h.number == key.at.value)
            true = truth(one, result, head.name, key.quantity, key.axis)
            if true is not None:
                count[f"{key.quantity}_{key.axis}_{head.name}"] += 1
                hits[f"{key.quantity}_{key.axis}_{head.name}"] += int(abs(value - true) <= student.ppf(0.975, dof) * u)
        said.update(codes(result))
    assert set(count.values()) == {n}
    return hits, said, n


def truth(one: Made, result: Result, head: str, quantity: str, axis: str) -> float | None:
    """Return what is true of a head; misalignment of both is not known here."""
    at = "xyz".index(axis[0])
    own = next(placed for placed in one.scene.heads if placed.name == head)
    if quantity == "bias":
        return float(one.bias[head][at])
    if quantity == "scale_factor_error":
        return float(own.gain[at, at])
    if quantity == "relative_bias":
        weights = next(h.weights.weights for h in result.heads if h.name == head)
        known = [placed for placed in one.scene.heads if placed.calibrated]
        turn = Rotation.from_rotvec(own.turned).as_matrix()
        rest = sum(w * one.bias[p.name] for w, p in zip(weights, known, strict=True))
        return float((one.bias[head] - turn @ rest)[at])
    return None


SOUND = {"not_redundant", "relative", "clock_estimated"}


@pytest.mark.parametrize("name", ["on_line", "off_line"])
def test_intervals_hold(name: str) -> None:
    hits, said, n = coverage(name, 10)
    assert all(keeps("holds", one, n) for one in hits.values()), hits
    assert set(said) <= SOUND


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_intervals_hold_over_many(name: str) -> None:
    hits, said, n = coverage(name, sized(300, 100))
    assert all(keeps("holds", one, n) for one in hits.values()), hits
    assert sum(count for code, count in said.items() if code not in SOUND) <= 0.03 * n, said


def test_noise_of_the_known_heads_makes_no_scale_factor_too_small() -> None:
    """It would by 0.6 % here, where the motion is hardly enough: the mean of 24 slopes is known to 0.2 %."""
    scene = on_line(0.5, vibration=7.0 * UG, slow=0.0, orientation_u=0.0, seconds=1200.0)
    found = []
    for seed in range(1, 9):
        estimate = reduced(scene, seed)[1].estimate
        assert estimate is not None
        found += [value for key, value in zip(estimate.keys, estimate.values, strict=True)
                  if key.quantity == "scale_factor_error"]  # fmt: skip
    assert len(found) >= 12
    assert abs(np.mean(found)) < 5e-3

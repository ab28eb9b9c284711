"""Corrections: what is taken off, what is not known of it, and how that enters figures: by gains, against differences.

The gains of positions and flips are tried against reductions of readings that are moved by each unknown.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest

from independent.warm.warm_positions import REFERENCE, Bench, laid
from inertialcal.core.errors import DataError, PlanError
from inertialcal.core.estimate import Array, Component, Estimate
from inertialcal.core.key import Key, Kind, Origin
from inertialcal.core.recording import Channel, Recording
from inertialcal.core.unknowns import Unknowns
from inertialcal.procedures.corrections import BiasCorrection, components, corrected, dof_of
from inertialcal.procedures.flip import reduction as flip
from inertialcal.procedures.flip.plan import Plan as FlipPlan
from inertialcal.procedures.flip.simulation import Truth as FlipTruth
from inertialcal.procedures.flip.simulation import simulate as simulate_flip
from inertialcal.procedures.flip.terms import bias_of, model_terms
from inertialcal.procedures.model_terms import ModelTerms, joined_terms
from inertialcal.procedures.positions import reduction as positions
from inertialcal.procedures.positions.inputs import readings_of
from inertialcal.procedures.protocol import Facts
from inertialcal.procedures.protocol import Tested as Done
from inertialcal.procedures.thermal import reduction as thermal
from inertialcal.procedures.thermal.correction import ThermalCorrection, sources_of
from inertialcal.sensors.model.sensor_model import Provenance
from inertialcal.statistics.intervals import contains, covers, t_interval

G = 9.80665
WEIGHTS = {"accelerometer": 0.03, "gyro": 0.15}  # of the largest change: weights follow the readings a little
DRAWN = 0.01  # of differences: a correction is small, and figures nearly linear in it
TRUTH = thermal.Truth(
    coefficients=np.array([[0.02, -0.01], [4e-4, -2e-4], [3e-6, 0.0]]),
    white=1e-4, walk=2e-6, run_std=1e-3, slope_std=2e-6, hysteresis=2e-4, start_up=2e-3, interval=60.0, axes=("x", "z"),
)  # fmt: skip
PLAN = thermal.Plan(order=2)


def thermal_of(seed: int) -> ThermalCorrection:
    """Thermal test of two accelerometers, z along gravity."""
    readings = thermal.simulate(PLAN, TRUTH, np.random.default_rng(seed))
    sweeps = tuple(replace(one, outputs={"x": one.outputs["x"], "z": one.outputs["z"] + G}) for one in readings.sweeps)
    return ThermalCorrection("thermal", thermal.reduce(PLAN, replace(readings, sweeps=sweeps, unit="m/s^2")))


def at(temperature: float, x: float = 0.0, z: float = 0.0, unit: str = "m/s^2") -> tuple[str, Recording]:
    n = 50
    named = {"x": (x, unit), "z": (z, unit), "temperature": (temperature, "degC")}
    channels = tuple(Channel(name, np.full(n, value), own) for name, (value, own) in named.items())
    return f"at {temperature:g}", Recording(channels, time_ns=np.arange(n) * 10**9, epoch="elapsed")


@pytest.fixture(scope="module")
def bias() -> ThermalCorrection:
    return thermal_of(1)


def test_accelerometers_keep_their_level_and_lose_the_change_from_the_reference(bias: ThermalCorrection) -> None:
    cold, usual, warm = bias.apply([at(-10.0), at(20.0), at(50.0)])[0]
    law = sources_of(bias)[0]
    assert law is not None
    assert {key.power for key in law.keys} == {1, 2}  # the level holds gravity
    for axis in "xz":
        one, two = (law.value(Key("bias_temperature", axis, power=j)) for j in (1, 2))
        assert usual.channel(axis).data.mean() == pytest.approx(0.0, abs=1e-12)
        assert warm.channel(axis).data.mean() == pytest.approx(-(30.0 * one + 900.0 * two), rel=1e-9)
        assert cold.channel(axis).data.mean() == pytest.approx(30.0 * one - 900.0 * two, rel=1e-9)
    assert {one.origin.what for one in bias.apply([at(20.0)])[1][0].values() if np.any(one.changes)} == set()


def test_unknowns_are_the_same_whatever_the_recordings(bias: ThermalCorrection) -> None:
    """Two calls together know the covariance of what was taken off at both temperatures, and of the coefficients."""
    (first,), (second,) = bias.apply([at(-10.0)])[1], bias.apply([at(50.0)])[1]
    origin = next(one for one in first if one.level == "run")
    law, plan = bias.result.sensors["z"].law, bias.result.plan
    level = law.basis([plan.reference_temperature])
    rows = np.vstack([law.basis([-10.0]) - level, law.basis([50.0]) - level])
    expected = law.contrasts(rows)[0]
    changes = np.vstack([first[origin].changes[:, 0, 2], second[origin].changes[:, 0, 2]])
    np.testing.assert_allclose(changes @ changes.T, expected, rtol=1e-9)
    one, other = (part[origin] for part in (first, second))
    np.testing.assert_array_equal(one.law, other.law)
    slope = one.law[:, one.keys.index(Key("bias_temperature", "z", power=1))]
    curve = one.law[:, one.keys.index(Key("bias_temperature", "z", power=2))]
    np.testing.assert_allclose(30.0 * slope + 900.0 * curve, changes[1], rtol=1e-9)


def off_by(bias: ThermalCorrection) -> dict[str, tuple[float, float, float]]:
    """Return what was taken off wrongly at 55 degC, its u and degrees of freedom, by axis."""
    (one,), (off,) = bias.apply([at(55.0)])
    found = {}
    for k, axis in ((0, "x"), (2, "z")):
        true = TRUTH.bias(55.0) - TRUTH.bias(20.0)
        gain = np.zeros((1, 1, 3))
        gain[0, 0, k] = 1.0
        estimate = Estimate((Key("left", axis),), np.zeros(1), ("m/s^2",),
                            tuple(components(off, [Key("left", axis)], gain)))  # fmt: skip
        left = float(one.channel(axis).data.mean() + true["xz".index(axis)])
        found[axis] = left, float(estimate.u[0]), float(estimate.dof[0])
    return found


def check_taken_off(n: int) -> None:
    for axis in "xz":
        hits = sum(contains(t_interval(*off_by(thermal_of(seed))[axis]), 0.0) for seed in range(1, n + 1))
        assert covers(hits, n), (axis, hits, n)


def test_what_was_taken_off_wrongly_is_within_its_uncertainty() -> None:
    check_taken_off(8)


@pytest.mark.slow
def test_what_was_taken_off_wrongly_is_within_its_uncertainty_in_95_percent() -> None:
    check_taken_off(60)


def test_a_correction_of_another_sensor_is_refused(bias: ThermalCorrection) -> None:
    with pytest.raises(DataError, match="readings are in rad/s") as caught:
        corrected([bias], [at(20.0, unit="rad/s")])
    assert caught.value.problems[0].code == "another_sensor"


def unknowns(patterns: Array, kind: str = "thermal") -> dict[Origin, Unknowns]:
    """Return unknowns of dwells, shape (s, n, 3), as a correction gives them."""
    origin = Origin("scatter between runs", test=kind, level="run")
    return {origin: Unknowns(origin, "A", patterns, (), np.zeros((len(patterns), 0)), np.array([3.0, 4.0, 5.0]))}


def carried(estimate: Estimate) -> Component:
    found = [one for one in estimate.components if one.origin.test]
    assert len(found) == 1
    assert found[0].changes is not None
    return found[0]


@pytest.mark.parametrize("known", [True, False])
def test_positions_follow_what_was_taken_off_them(known: bool) -> None:
    """Both by known orientations and by the length of gravity; the gyros' bias and g-sensitivity, too."""
    rng = np.random.default_rng(3)
    plan = positions.Plan(gravity=G, latitude=0.8, outlier_risk=1e-9)
    readings = positions.simulate(plan, positions.Truth(known=known), rng)
    m = len(readings)
    patterns: dict[Kind, Array] = {
        "accelerometer": rng.normal(0.0, 1e-3, (2, m, 3)), "gyro": rng.normal(0.0, 1e-4, (2, m, 3)),
    }  # fmt: skip
    off: Mapping[Kind, Mapping[Origin, Unknowns]] = {kind: unknowns(one, kind) for kind, one in patterns.items()}
    result = positions.reduce(plan, replace(readings, taken_off=off))
    triads: dict[Kind, str] = {"accelerometer": "acc", "gyro": "gyro"}
    for kind, triad in triads.items():
        part = carried(result.estimates[kind])
        changes = part.changes
        assert changes is not None
        for s in range(2):
            own = getattr(readings, triad)
            moved = replace(readings, **{triad: replace(own, mean=own.mean - DRAWN * patterns[kind][s])})
            other = positions.reduce(plan, moved).estimates[kind]
            rest = ("bias", "g_sensitivity")  # rotations of the gyros are not moved
            wanted = [i for i, key in enumerate(other.keys) if kind == "accelerometer" or key.quantity in rest]
            seen = (other.values - result.estimates[kind].values) / DRAWN
            np.testing.assert_allclose(
                changes[s][wanted], seen[wanted], atol=WEIGHTS[kind] * np.abs(seen[wanted]).max()
            )


def test_a_constant_changes_the_bias_alone() -> None:
    rng = np.random.default_rng(4)
    plan = positions.Plan(gravity=G, latitude=0.8)
    readings = positions.simulate(plan, positions.Truth(known=True), rng)
    level = np.array([1e-3, -2e-3, 3e-3])
    patterns = np.broadcast_to(level, (1, len(readings), 3))
    kinds: tuple[Kind, ...] = ("accelerometer", "gyro")
    off = {kind: unknowns(patterns, kind) for kind in kinds}
    result = positions.reduce(plan, replace(readings, taken_off=off))
    for found in result.estimates.values():
        changes = carried(found).changes
        assert changes is not None
        for key, change in zip(found.keys, changes[0], strict=True):
            expected = -level["xyz".index(key.axis)] if key.quantity == "bias" else 0.0
            assert change == pytest.approx(expected, abs=1e-7 if key.quantity != "g_sensitivity" else 1e-8)


def test_positions_at_several_temperatures_follow_it_too() -> None:
    """An error of the slope that was taken off is one of the slope that is left, and of nothing else."""
    made = laid(Bench(temperatures=(-20.0, 20.0, 60.0, 40.0, 0.0, 50.0), rounds=1), 1)
    acc = positions.Triad(made.mean, np.full(made.mean.shape, 2e-4), np.ones(made.mean.shape), "m/s^2")
    readings = positions.Readings(
        acc, direction=made.direction, temperature=made.temperature, recordings=made.recording
    )
    own = np.array([made.temperature[np.array(made.recording) == k].mean() for k in made.recording])
    patterns = 1e-5 * np.repeat((own - REFERENCE)[None, :, None], 3, axis=2)
    patterns[:, np.abs(own - REFERENCE) < 5.0] = 0.0
    plan = positions.Plan(gravity=G, temperature_order=1, reference_temperature=REFERENCE)
    result = positions.reduce(plan, replace(readings, taken_off={"accelerometer": unknowns(patterns)}))
    found = result.models["accelerometer"].estimate
    assert found is not None
    part = carried(found)
    assert part.changes is not None
    for key, change, dof in zip(found.keys, part.changes[0], np.broadcast_to(part.dof, len(found.keys)), strict=True):
        slope = key == Key("bias_temperature", key.axis, power=1)
        assert change == pytest.approx(-1e-5 if slope else 0.0, abs=2e-7 if key.quantity != "bias" else 2e-6), key
        assert dof == 3.0 + "xyz".index(key.axis[0]) or not slope


def test_positions_refer_to_the_temperature_at_which_a_correction_leaves_the_bias(bias: ThermalCorrection) -> None:
    """Slopes about two temperatures do not add; without an order, and of gyros, there are none to add."""
    reference = bias.result.plan.reference_temperature
    plan = positions.Plan(gravity=G, temperature_order=1, reference_temperature=reference + 5.0)
    with pytest.raises(PlanError, match="thermal is 20 degC") as refused:
        readings_of(plan, (), [bias])
    assert refused.value.problems[0].code == "plans_differ"
    gyros = replace(bias, result=replace(bias.result, readings=replace(bias.result.readings, unit="rad/s")))
    assert gyros.reference_temperature is None
    for own, one in ((replace(plan, temperature_order=0), bias), (plan, gyros)):
        with pytest.raises(IndexError):  # goes on to the sources, of which there are none
            readings_of(own, (), [one])


def test_flips_follow_what_was_taken_off_them() -> None:
    rng = np.random.default_rng(5)
    plan = FlipPlan(axis="x")
    readings = simulate_flip(plan, FlipTruth(bias=np.array([1e-4, -2e-4, 3e-4])), rng)
    patterns = rng.normal(0.0, 1e-6, (2, len(readings), 3))
    result = flip.reduce(plan, replace(readings, taken_off=unknowns(patterns)))
    assert result.estimate is not None
    part = carried(result.estimate)
    assert part.changes is not None
    for s in range(2):
        outputs = {axis: own - patterns[s, :, k] for k, (axis, own) in enumerate(readings.outputs.items())}
        other = flip.reduce(plan, replace(readings, outputs=outputs))
        assert other.estimate is not None
        np.testing.assert_allclose(part.changes[s], other.estimate.values - result.estimate.values, atol=1e-12)
    tested = Done("flip", "", "fit", plan, readings, result, ("head",), facts=Facts("accelerometer", "ug", "m/s^2"))
    terms = model_terms(result, [tested])
    assert terms is not None
    assert [str(key) for key in terms.parameters] == ["bias_y", "bias_z"]
    assert terms.axes == ("y", "z")


def test_what_a_flip_found_and_what_is_left_after_it_are_one_bias() -> None:
    """Readings of u after a flip leave what it missed: the sum is what they read, and known as well as they are."""
    plan, u = FlipPlan(axis="x"), 3e-6
    truth = FlipTruth(bias=np.array([1e-4, -2e-4, 3e-4]))
    readings = simulate_flip(plan, truth, np.random.default_rng(6))
    result = flip.reduce(plan, readings)
    facts = Facts("accelerometer", "ug", "m/s^2")
    first = model_terms(result, [Done("flip", "", "fit", plan, readings, result, ("head",), facts=facts)])
    bias = bias_of(result)
    assert first is not None
    assert first.estimate is not None
    assert bias is not None
    (made,), (off,) = BiasCorrection("flip", bias).apply([at(20.0, z=4e-4)])
    keys, gain = (Key("bias", "z"),), np.array([[[0.0, 0.0, 1.0]]])
    own = Component(Origin("noise", level="sample"), "A", np.array([[u**2]]), np.inf)
    left = float(made.channel("z").data.mean())
    estimate = Estimate(keys, np.array([left]), ("m/s^2",), (own, *components(off, keys, gain)))
    assert estimate.u[0] > u  # what the flip did not know is in what is left, too
    provenance = {keys[0]: Provenance("still", ("head",))}
    second = ModelTerms(estimate, keys, ("z",), provenance, tests=("still",), after=("flip",))
    joint = joined_terms([replace(first, tests=("flip",)), second]).estimate
    assert joint is not None
    z, y = joint.index(keys[0]), joint.index(Key("bias", "y"))
    assert joint.values[z] == pytest.approx(4e-4)
    assert joint.u[z] == pytest.approx(u)
    assert joint.u[y] == pytest.approx(first.estimate.u[first.estimate.index(Key("bias", "y"))])
    assert joint.covariance[y, z] == pytest.approx(0.0, abs=1e-9 * joint.u[y] * joint.u[z])


def constant() -> BiasCorrection:
    covariance = 1e-12 * np.array([[4.0, 1.0], [1.0, 9.0]])
    parts = (Component(Origin("noise", level="sample"), "A", covariance, np.array([7.0, 9.0]), "t"),)
    estimate = Estimate((Key("bias", "y"), Key("bias", "z")), np.array([1e-3, -2e-3]), ("m/s^2",) * 2, parts)
    return BiasCorrection("flip", estimate)


def test_a_static_bias_is_taken_off_the_axes_that_have_one() -> None:
    recording = replace(at(20.0, 1.0, 2.0)[1])
    (made,), (off,) = constant().apply([("head", recording)])
    assert made.channel("x").data.mean() == pytest.approx(1.0)
    assert made.channel("z").data.mean() == pytest.approx(2.002)
    assert [one.code for one in made.remarks] == ["no_bias"]
    (origin,) = off
    assert origin.test == "flip"
    own = off[origin].changes[:, 0]
    np.testing.assert_allclose(own.T @ own, 1e-12 * np.array([[0, 0, 0], [0, 4, 1], [0, 1, 9.0]]), atol=1e-20)
    gain = np.eye(3)[1:, None, :]
    np.testing.assert_array_equal(dof_of(off[origin], gain), [7.0, 9.0])

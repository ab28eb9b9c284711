"""Uncertainty of a flip: truth held by its intervals, the control axis' false alarms, what the checks find."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from inertialcal.core.estimate import Array
from inertialcal.core.influence import Influence
from inertialcal.core.key import Key
from inertialcal.procedures.flip.plan import Plan
from inertialcal.procedures.flip.readings import Quiet, Readings
from inertialcal.procedures.flip.reduction import Result, reduce
from inertialcal.procedures.flip.separation.equations import separate
from inertialcal.procedures.flip.separation.noise import noise_of
from inertialcal.procedures.flip.simulation import Truth, simulate
from inertialcal.statistics.intervals import contains, covers, t_interval
from inertialcal.statistics.slow_noise import FLICKER, WALK
from sized import sized

UG = 9.80665e-6
TRUTH = Truth(bias=np.array([1000.0, -900.0, 1200.0]) * UG, ambient=np.array([0.4, -5.0, 4.0]) * UG)
CORNERS = (0.0, 0.01, 0.1)  # Hz
STANDARDS = {
    "turn.angle": Influence(math.radians(1.0), "rad"),
    "turn.axis": Influence(math.radians(0.5), "rad"),
    "converter.zero": Influence(0.05 * UG, "m/s^2"),
    "sensor.scale_factor": Influence(1e-5),
}


def held(result: Result, truth: Truth) -> dict[str, bool]:
    """Whether the 95 % interval of each value holds the truth."""
    estimate = result.estimate
    assert estimate is not None
    found = {}
    for name, value, u, dof in zip(estimate.names, estimate.values, estimate.u, estimate.dof, strict=True):
        axis = "xyz".index(name[-1])
        bias, g = truth.bias[axis], truth.ambient[axis]
        true = {"bias": bias, "ambient_acceleration": g, "reading": bias + g, "control_error": 0.0}
        found[name] = contains(t_interval(value, u, dof), true[name[:-2]])
    return found


def coverage(corner: float, n: int, plan: Plan, along: float = 0.0) -> None:
    """Check intervals and alarms over n flips; ambient acceleration along the turn is drawn where it has a size."""
    truth = replace(TRUTH, corner=corner)
    hits: dict[str, int] = {}
    alarms = 0
    for seed in range(1, n + 1):
        rng = np.random.default_rng(seed)
        if along:
            truth = replace(truth, ambient=np.array([rng.normal(0.0, along), *TRUTH.ambient[1:]]))
        result = reduce(plan, simulate(plan, truth, rng))
        for name, hit in held(result, truth).items():
            hits[name] = hits.get(name, 0) + hit
        alarms += "control_axis_not_zero" in {one.code for one in result.remarks}
    assert len(hits) == 6
    assert all(covers(hit, n, 0.93, 1.0) for hit in hits.values()), (corner, hits)
    assert covers(alarms, n, 0.0, 0.02), (corner, alarms)


@pytest.mark.parametrize(
    "corner", [pytest.param(one, marks=pytest.mark.slow if i % 2 else []) for i, one in enumerate(CORNERS)]
)
def test_intervals_hold_the_truth_and_the_control_axis_alarms_in_1_percent(corner: float) -> None:
    coverage(corner, sized(300, 20), Plan())


@pytest.mark.slow
def test_intervals_hold_the_truth_with_standards_that_are_off() -> None:
    size = math.hypot(*TRUTH.ambient[1:])  # what standards.py takes it for
    coverage(0.01, sized(1000, 100), Plan(standards=STANDARDS), along=size)


@pytest.mark.slow
def test_intervals_of_pairs_hold_the_truth() -> None:
    """The record must be long against the dwells: the level at each position is taken off before."""
    plan, truth = Plan(noise="pairs"), replace(TRUTH, corner=0.01, record=7200.0, dwell=100.0)
    hits = {"ambient_acceleration_y": 0, "control_error_x": 0}
    n = sized(1000, 100)
    for seed in range(1, n + 1):
        found = held(reduce(plan, simulate(plan, truth, np.random.default_rng(seed))), truth)
        hits = {name: hits[name] + found[name] for name in hits}
    assert all(covers(hit, n) for hit in hits.values()), hits


def test_sub_means_inside_a_dwell_would_alarm_far_too_often() -> None:
    """What the procedure is for: with 1/f noise a t-test on white noise inside the dwells is no 5 % test."""
    plan, alarms = Plan(), 0
    for seed in range(1, 31):
        readings = simulate(plan, replace(TRUTH, corner=0.1), np.random.default_rng(seed))
        means, weights = readings.quiet[0].means["x"], readings.quiet[0].weights
        u = math.hypot(*(means[w > 0.0].std(ddof=1) / math.sqrt((w > 0.0).sum()) for w in weights)) / 2.0
        alarms += abs(reduce(plan, readings).whole.separated[0].value(Key("control_error", "x")) or 0.0) > 2.0 * u
    assert alarms > 4  # of 30


def test_general_positions_with_noise_hold_the_truth() -> None:
    truth = replace(TRUTH, angles=tuple(np.radians([0.0, 120.0, 240.0])), dwell=200.0)
    hits: dict[str, int] = {}
    for seed in range(1, 21):
        result = reduce(Plan(), simulate(Plan(), truth, np.random.default_rng(seed)))
        assert result.estimate is not None
        own = result.estimate.names.index("control_error_quadrature_x")
        kept = [name for i, name in enumerate(result.estimate.names) if i != own]
        whole = replace(result.whole, estimate=result.estimate.select(kept))
        for name, hit in held(replace(result, whole=whole), truth).items():
            hits[name] = hits.get(name, 0) + hit
    assert all(covers(hit, 20, 0.93, 1.0) for hit in hits.values()), hits


def test_pairs_and_model_agree_on_white_noise() -> None:
    truth = replace(TRUTH, record=14400.0, dwell=100.0)
    readings = simulate(Plan(), truth, np.random.default_rng(1))
    slow, pairs = (reduce(Plan(noise=noise), readings).estimate for noise in ("slow", "pairs"))
    assert slow is not None
    assert pairs is not None
    assert pairs.names == slow.names
    assert pairs.dof.min() >= 20.0
    assert pairs.u == pytest.approx(slow.u, rel=0.5)
    assert "quiet stretches as long" in pairs.components[0].source


def test_the_uncertainty_in_white_noise_is_that_of_two_means() -> None:
    """Half the difference of two means over a time T has the variance S / (4 T) in white noise of one-sided density."""
    variances = []
    for seed in range(1, 16):
        estimate = reduce(Plan(), simulate(Plan(), TRUTH, np.random.default_rng(seed))).estimate
        assert estimate is not None
        variances.append(estimate.u[estimate.names.index("control_error_x")] ** 2)
    assert np.mean(variances) * 4.0 * TRUTH.dwell / TRUTH.white == pytest.approx(1.0, rel=0.2)


def test_slow_ambient_noise_is_in_a_bias_as_that_of_the_head_is_in_an_ambient_acceleration() -> None:
    """After half a turn: g cos(angle) with the weights of a bias, which are those of g times cos(angle)."""
    readings = simulate(Plan(), TRUTH, np.random.default_rng(1))
    flip, record = separate(Plan(), readings, readings.flip[0]), readings.quiet[0].of("y")
    noise = noise_of(record, "y", True)
    bias, ambient = (
        flip.weights["y"][flip.keys.index(Key(name, "y"))] @ record.weights @ noise.pieces.membership.T
        for name in ("bias", "ambient_acceleration")
    )
    for slow in (FLICKER, WALK):
        in_bias = noise._of_slow((slow, "ambient"), bias, bias, False)
        assert in_bias > 0.0
        assert in_bias == pytest.approx(noise._less_record(slow, ambient, ambient), rel=1e-6)


FULL_RECORD = replace(TRUTH, angles=(0.0, math.pi) * 3, turn=10.0, record=1850.0)  # nothing but dwells and turns


def test_white_noise_is_in_the_bias_where_the_dwells_are_the_record() -> None:
    ratios = []
    for seed in range(1, 11):
        result = reduce(Plan(), simulate(Plan(), FULL_RECORD, np.random.default_rng(seed)))
        assert result.estimate is not None
        u = result.estimate.u[result.estimate.names.index("bias_y")]
        ratios.append(u / math.sqrt(TRUTH.white / (2.0 * 1800.0)))
        later = next(row for row in result.rows() if row.quantity == "bias_next_record")
        assert later.u is not None
        assert later.u == pytest.approx(u, rel=1e-6) or later.u > u
    assert np.median(ratios) == pytest.approx(1.0, rel=0.15)


def drifting(truth: Truth, rate: float, seed: int, plan: Plan) -> Readings:
    """Readings while the ambient acceleration of all axes changes [m/s^2 per s]; 0 in the middle of the record."""
    made = simulate(plan, truth, np.random.default_rng(seed))
    own = made.quiet[0]
    change = rate * (own.times - own.times.mean())
    turned = {axis: change * (1.0 if axis == "x" else np.cos(own.angle)) for axis in "xyz"}
    quiet = replace(own, means={axis: one + turned[axis] for axis, one in own.means.items()})
    outputs = {axis: one + own.weights @ turned[axis] for axis, one in made.outputs.items()}
    return replace(made, outputs=outputs, quiet=(quiet,))


def test_a_drift_of_the_ambient_acceleration_is_in_the_bias_and_fails_the_control_axis() -> None:
    plan, truth = Plan(block=40.0), replace(TRUTH, dwell=4000.0, turn=60.0, record=8060.0)
    for seed in range(1, 4):
        result = reduce(plan, drifting(truth, 3.0 * UG / 3600.0, seed, plan))
        assert all(hit for name, hit in held(result, truth).items() if name.startswith(("bias", "ambient")))
        assert result.estimate is not None
        u = result.estimate.u[result.estimate.names.index("bias_y")]
        assert u == pytest.approx(1.7 * UG, rel=0.2)  # half the change between the middles of the dwells
        assert "error" in {one.severity for one in result.remarks if one.code == "control_axis_not_zero"}


def test_a_drift_that_is_fitted_passes_the_control_axis() -> None:
    plan, truth = (
        Plan(block=20.0, drift="ambient"),
        replace(TRUTH, angles=(0.0, math.pi) * 2, dwell=1000.0, record=4240.0),
    )
    result = reduce(plan, drifting(truth, 3.0 * UG / 3600.0, 1, plan))
    assert "control_axis_not_zero" not in {one.code for one in result.remarks}


def test_a_record_that_shows_no_noise_gives_no_uncertainty() -> None:
    plan = Plan()
    truth = replace(TRUTH, record=700.0, dwell=300.0)
    short = simulate(Plan(block=100.0), truth, np.random.default_rng(1))
    result = reduce(plan, short)
    assert result.estimate is None
    row = next(one for one in result.rows() if one.quantity == "bias" and one.axis == "y")
    assert row.value is not None
    assert row.u is None
    assert row.status == "not_estimated"
    assert "block means" in row.reason.text
    assert "quiet places as long and as far apart as its dwells: need 3" in row.reason.text
    apart = replace(short, quiet=tuple(_alone(short, k) for k in (0, 1)))
    assert reduce(plan, apart).whole.reason.code == "apart"


def _alone(readings: Readings, dwell: int) -> Quiet:
    own = readings.quiet[0]
    spans = np.where(np.arange(len(readings))[:, None] == dwell, own.spans, np.nan)
    return replace(own, spans=spans)


def several(gs: Array, seed: int, corner: float = 0.0) -> Readings:
    """Flips of different ambient acceleration, each in a record of its own."""
    rng = np.random.default_rng(seed)
    parts = [simulate(Plan(), replace(TRUTH, ambient=g, corner=corner), rng) for g in gs]
    quiet = []
    for i, part in enumerate(parts):
        blank = np.zeros((2 * len(parts), len(part.quiet[0].times)))
        spans = np.full((2 * len(parts), 2), np.nan)
        blank[2 * i : 2 * i + 2], spans[2 * i : 2 * i + 2] = part.quiet[0].weights, part.quiet[0].spans
        quiet.append(replace(part.quiet[0], weights=blank, spans=spans))
    outputs = {axis: np.concatenate([part.outputs[axis] for part in parts]) for axis in "xyz"}
    labels = np.repeat([str(i + 1) for i in range(len(parts))], 2)
    return Readings(np.tile(parts[0].angle, len(parts)), labels, outputs, quiet=tuple(quiet))


def test_flips_that_differ_beyond_their_noise_are_remarked() -> None:
    alike = reduce(Plan(), several(np.tile(TRUTH.ambient, (3, 1)), 1))
    assert "flips_differ" not in {one.code for one in alike.remarks}
    differing = reduce(Plan(), several(TRUTH.ambient + np.arange(3)[:, None] * 2.0 * UG, 1))
    told = [one.what for one in differing.remarks if one.code == "flips_differ"]
    assert any(what.startswith("ambient_acceleration_y: chi-square") for what in told)
    assert {str(one.case) for one in differing.rows()} == {"", "flip 1", "flip 2", "flip 3"}
    assert differing.estimate is not None
    assert differing.estimate.dof == pytest.approx(2.0)


def rotated(vectors: Array, truth: Truth = TRUTH, seed: int = 1) -> Readings:
    """Readings where the head was really turned by rotation vectors, by scipy's rotations."""
    readings = simulate(Plan(), truth, np.random.default_rng(seed))
    stated = np.outer(readings.angle, [1.0, 0.0, 0.0])
    change = Rotation.from_rotvec(-vectors).apply(truth.ambient) - Rotation.from_rotvec(-stated).apply(truth.ambient)
    outputs = {axis: y + change[:, i] for i, (axis, y) in enumerate(readings.outputs.items())}
    return replace(readings, outputs=outputs)


def test_a_turn_about_another_axis_is_found() -> None:
    truth = replace(TRUTH, ambient=np.array([6.0, -5.0, 4.0]) * UG)
    result = reduce(Plan(), rotated(np.outer([0.0, math.pi], [0.0, 1.0, 0.0]), truth))
    found = {one.code: one for one in result.remarks}
    assert "turned about y" in found["turned_about_other_axis"].do
    assert "control_axis_not_zero" in found
    right = reduce(Plan(), rotated(np.outer([0.0, math.pi], [1.0, 0.0, 0.0]), truth))
    assert not {"turned_about_other_axis", "control_axis_not_zero"} & {one.code for one in right.remarks}


def test_a_turn_by_another_angle_is_found_where_dwells_are_left_over() -> None:
    truth = replace(TRUTH, angles=(0.0, math.pi, 0.0), dwell=200.0)
    wrong = reduce(Plan(), rotated(np.outer([0.0, math.pi, math.pi / 3], [1.0, 0.0, 0.0]), truth))
    found = {one.code: one for one in wrong.remarks}
    assert "y and z do not follow the stated angles" in found["not_turned_by_angle"].what
    alarms = 0
    for seed in range(1, 41):
        right = reduce(Plan(), simulate(Plan(), replace(truth, corner=0.01), np.random.default_rng(seed)))
        alarms += "not_turned_by_angle" in {one.code for one in right.remarks}
    assert alarms <= 4  # 1 % expected; more than 4 of 40 in 0.004 % of such runs


@pytest.mark.parametrize("angles", [(0.0, math.pi), (0.0, math.pi, 0.0)])
def test_a_short_record_of_white_noise_has_a_variance(angles: tuple[float, ...]) -> None:
    """The flicker part may be negative, but not so far that a result the design sees has a negative variance."""
    truth = replace(TRUTH, angles=angles, dwell=100.0, record=120.0 + 110.0 * len(angles), turn=10.0)
    plan = Plan(block=2.0)
    for seed in range(1, 16):
        estimate = reduce(plan, simulate(plan, truth, np.random.default_rng(seed))).estimate
        assert estimate is not None
        assert np.all(estimate.u > 0.0)


def in_one_record(seed: int, count: int, corner: float) -> Readings:
    """Flips one after the other in the middle of one record, the ambient acceleration that of TRUTH."""
    truth = replace(TRUTH, corner=corner, angles=(0.0, math.pi) * count, dwell=60.0, record=3600.0)
    made = simulate(Plan(), truth, np.random.default_rng(seed))
    return replace(made, flip=np.repeat([str(i + 1) for i in range(count)], 2))


@pytest.mark.slow
def test_flips_of_one_record_share_its_slow_noise() -> None:
    """Without it, two thirds of the intervals of a bias hold the truth."""
    hits: dict[str, int] = {}
    n = sized(60, 25)
    for seed in range(1, n + 1):
        result = reduce(Plan(), in_one_record(seed, 6, 0.1))
        for name, hit in held(result, replace(TRUTH, corner=0.1)).items():
            hits[name] = hits.get(name, 0) + hit
    assert all(covers(hit, n, 0.93, 1.0) for hit in hits.values()), hits
    assert result.estimate is not None
    assert "have in common" in result.estimate.components[1].source


def test_a_flip_that_lacks_an_axis_is_named_and_not_counted() -> None:
    readings = in_one_record(1, 3, 0.01)
    z = readings.outputs["z"].copy()
    z[:2] = np.nan
    result = reduce(Plan(), replace(readings, outputs={**readings.outputs, "z": z}))
    found = {one.code: one.what for one in result.remarks}
    assert found["flip_not_pooled"].startswith("not pooled: flip 1, ")
    assert found["few_flips"].startswith("2 flips")

"""In-orbit flip: the published tables, closed forms, invariants, and truth recovered."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from inertialcal.core.errors import DataError
from inertialcal.core.estimate import Array
from inertialcal.core.influence import Influence
from inertialcal.core.results import Row
from inertialcal.core.units import factor
from inertialcal.procedures import PROCEDURES
from inertialcal.procedures.flip.inputs import MeanOf, readings_of_means
from inertialcal.procedures.flip.plan import Plan
from inertialcal.procedures.flip.readings import Readings
from inertialcal.procedures.flip.reduction import Result, reduce
from inertialcal.procedures.flip.separation.equations import separate
from inertialcal.procedures.flip.separation.uncertainty import patterns

UG = factor("ug", "m/s^2")
ROUNDING = 0.005  # ug, half of the last printed digit of Table 3
POSITIONS = {"forward": 0.0, "reverse": math.pi}

# TM-106980, Table 3: mean acceleration, semiprocessed [ug], by axis, then time: (forward, reverse).
TABLE_3 = {
    "x": {"1": (-1271.61, -1269.34), "2": (-1264.74, -1264.98), "3": (-1263.65, -1263.83)},
    "y": {"1": (981.60, 981.48), "2": (973.77, 984.33), "3": (975.66, 984.42)},
    "z": {"1": (-1258.73, -1260.04), "2": (-1249.69, -1258.82), "3": (-1252.94, -1260.10)},
}
# Tables 4 (ambient acceleration), 5 (control axis), 6 (bias) [ug].
TABLE_4 = {"y": {"1": 0.057, "2": -5.282, "3": -4.379}, "z": {"1": 0.657, "2": 4.568, "3": 3.580}}
TABLE_5 = {"x": {"1": -1.136, "2": 0.116, "3": 0.090}}
TABLE_6 = {
    "y": {"1": 981.541, "2": 979.049, "3": 980.039},
    "z": {"1": -1259.382, "2": -1254.253, "3": -1256.515},
}

# Table 20: means with the older ground model [ug], (forward, reverse), by axis, filter, time. "Time 3" is headed
# "Time 2" again; Y time 3 forward stands exchanged between filtered and unfiltered, and its unfiltered reverse has
# 30.044 for 30.436 (errata): typed as printed.
TABLE_20 = {
    ("x", "filtered"): {"1": (3.203, 2.090), "2": (9.603, 9.267), "3": (10.444, 10.246)},
    ("x", "unfiltered"): {"1": (3.037, 1.959), "2": (9.192, 8.734), "3": (10.040, 9.681)},
    ("y", "filtered"): {"1": (51.164, 50.703), "2": (42.054, 31.652), "3": (40.408, 31.981)},
    ("y", "unfiltered"): {"1": (48.760, 47.925), "2": (39.642, 30.294), "3": (42.823, 30.044)},
    ("z", "filtered"): {"1": (7.227, 5.284), "2": (48.005, 39.615), "3": (47.546, 38.857)},
    ("z", "unfiltered"): {"1": (7.154, 5.067), "2": (44.786, 37.314), "3": (45.067, 36.721)},
}
# Tables 21 (bias error) and 22 (gravity), times 1, 2, 3 [ug].
TABLE_21 = {
    ("x", "filtered"): (2.647, 9.435, 10.345), ("x", "unfiltered"): (2.498, 8.963, 9.861),
    ("y", "filtered"): (50.934, 36.853, 37.402), ("y", "unfiltered"): (48.342, 34.968, 35.422),
    ("z", "filtered"): (6.256, 43.810, 43.202), ("z", "unfiltered"): (6.111, 41.050, 40.894),
}  # fmt: skip
TABLE_22 = {
    ("x", "filtered"): (0.556, 0.168, 0.099), ("x", "unfiltered"): (-0.539, 0.229, 0.179),
    ("y", "filtered"): (0.231, 5.201, 5.421), ("y", "unfiltered"): (0.418, 4.674, 4.986),
    ("z", "filtered"): (0.972, 4.195, 4.344), ("z", "unfiltered"): (1.044, 3.736, 4.173),
}  # fmt: skip
# What does not follow from Table 20 (errata.csv): exchanged or misprinted means of Y time 3, a sign in Table 22.
ERRATA = {
    ("bias", "y", "filtered", "3"), ("bias", "y", "unfiltered", "3"),
    ("gravity", "y", "filtered", "3"), ("gravity", "y", "unfiltered", "3"),
    ("gravity", "x", "unfiltered", "1"),
}  # fmt: skip
HALF_UNIT = 0.0011  # ug: Tables 20 to 22 have three decimals, half sums one more
T95, T99 = (0.2077, 0.1557), (0.3148, 0.2239)  # half widths of the text, forward and reverse [ug]


def table_3(half_widths: bool = False) -> Readings:
    return readings_of_means([
        MeanOf(axis, angle, mean * UG, time, ((0.95, T95[i] * UG), (0.99, T99[i] * UG)) if half_widths else ())
        for axis, times in TABLE_3.items()
        for time, means in times.items()
        for i, (angle, mean) in enumerate(zip(POSITIONS.values(), means, strict=True))
    ])  # fmt: skip


def row(result: Result, quantity: str, axis: str, condition: str = "") -> Row:
    found = [one for one in result.rows() if (one.quantity, one.axis, str(one.case)) == (quantity, axis, condition)]
    assert len(found) == 1, (quantity, axis, condition, [r for r in result.rows() if r.quantity == quantity])
    return found[0]


def of(result: Result, quantity: str, axis: str, condition: str = "") -> float:
    value = row(result, quantity, axis, condition).value
    assert value is not None
    return value / UG


def test_the_procedure_has_its_name() -> None:
    assert PROCEDURES["flip"].name == "flip"


@pytest.mark.parametrize(
    ("quantity", "table"), [("ambient_acceleration", TABLE_4), ("control_error", TABLE_5), ("bias", TABLE_6)]
)
def test_tables_4_to_6_follow_from_table_3(quantity: str, table: dict[str, dict[str, float]]) -> None:
    result = reduce(Plan(), table_3())
    for axis, times in table.items():
        for time, printed in times.items():
            assert of(result, quantity, axis, f"flip {time}") == pytest.approx(printed, abs=ROUNDING), (axis, time)


def table_20() -> Result:
    means = [
        MeanOf(axis, angle, one * UG, time, others={"low_pass": other * UG})
        for axis in ("x", "y", "z")
        for time in ("1", "2", "3")
        for angle, one, other in zip(
            POSITIONS.values(), TABLE_20[axis, "unfiltered"][time], TABLE_20[axis, "filtered"][time], strict=True
        )
    ]
    return reduce(Plan(corrected=True), readings_of_means(means))


def test_tables_21_and_22_follow_from_table_20_but_for_the_errata_named() -> None:
    result = table_20()
    differing = set()
    for (axis, kind), times in TABLE_20.items():
        readings = result.readings if kind == "unfiltered" else result.readings.by("low_pass")
        own = reduce(result.plan, readings)
        for i, time in enumerate(times):
            level, turn = ("reading", "control_error") if axis == "x" else ("model_bias_error", "ambient_acceleration")
            pairs = {"bias": (level, TABLE_21), "gravity": (turn, TABLE_22)}
            for name, (quantity, table) in pairs.items():
                found = of(own, quantity, axis, f"flip {time}")
                if abs(found - table[axis, kind][i]) > HALF_UNIT:
                    differing.add((name, axis, kind, time))
    assert differing == ERRATA


def test_y_time_3_of_table_20_stands_right_once_the_errata_are_undone() -> None:
    forward, reverse = 42.823, 31.981
    assert [(forward + reverse) / 2, (forward - reverse) / 2] == pytest.approx([37.402, 5.421], abs=HALF_UNIT)
    means = [MeanOf("y", 0.0, forward * UG), MeanOf("y", math.pi, reverse * UG)]
    result = reduce(Plan(), readings_of_means(means))
    assert of(result, "bias", "y") == pytest.approx(37.402, abs=HALF_UNIT)
    assert of(result, "ambient_acceleration", "y") == pytest.approx(5.421, abs=HALF_UNIT)


def test_the_other_statistic_stands_beside_the_mean() -> None:
    result = table_20()
    assert of(result, "model_bias_error", "z", "low_pass") == pytest.approx(np.mean([6.256, 43.810, 43.202]), abs=2e-3)
    assert of(result, "model_bias_error", "z") == pytest.approx(np.mean([6.111, 41.050, 40.894]), abs=2e-3)


def test_the_accuracy_as_published_is_the_sum_of_the_half_widths() -> None:
    result = reduce(Plan(), table_3(half_widths=True))
    condition = "as_published, flip 1"
    assert of(result, "accuracy_95", "x", condition) == pytest.approx(0.3634, abs=1e-9)
    assert of(result, "accuracy_99", "x", condition) == pytest.approx(0.5387, abs=1e-9)
    control = row(result, "control_error", "x", condition)
    assert control.interval is not None
    assert control.interval.hi is not None
    assert control.interval.hi < 0.0  # the document's own control axis is beyond its accuracy
    assert of(result, "bias", "x", condition) == pytest.approx(-1270.475, abs=ROUNDING)
    assert of(result, "control_error", "x", condition) == pytest.approx(TABLE_5["x"]["1"], abs=ROUNDING)
    second = "as_published, flip 2"
    assert of(result, "ambient_acceleration", "y", second) == pytest.approx(TABLE_4["y"]["2"], abs=ROUNDING)
    assert of(result, "bias", "z", second) == pytest.approx(TABLE_6["z"]["2"], abs=ROUNDING)
    assert control.interval.p == 0.95
    assert control.u is None


def test_one_flip_of_a_table_keeps_its_values_without_uncertainty() -> None:
    means = [MeanOf("y", 0.0, 3.0), MeanOf("y", math.pi, 1.0), MeanOf("x", 0.0, 5.0), MeanOf("x", math.pi, 5.0)]
    result = reduce(Plan(), readings_of_means(means))
    found = row(result, "ambient_acceleration", "y")
    assert found.value == pytest.approx(1.0)
    assert (found.u, found.status) == (None, "not_estimated")
    assert found.reason.code == "no_record"
    assert result.estimate is None
    assert row(result, "bias", "x").reason.code == "along_turn"
    assert row(result, "bias", "x").value is None
    assert row(result, "reading", "x").value == pytest.approx(5.0)
    assert "no_noise_model" in {one.code for one in result.remarks}


def test_several_flips_have_the_scatter_between_them() -> None:
    result = reduce(Plan(), table_3())
    values = np.array([TABLE_6["y"][time] for time in ("1", "2", "3")])
    found = row(result, "bias", "y")
    assert found.u is not None
    assert found.u / UG == pytest.approx(values.std(ddof=1) / math.sqrt(3), rel=2e-3)
    assert found.dof == pytest.approx(2.0)
    assert {"few_flips", "relative_to_fixture", "no_noise_model"} <= {one.code for one in result.remarks}


def test_known_standards_of_several_flips_do_not_shrink() -> None:
    standards = {"converter.zero": Influence(50.0 * UG, "m/s^2")}
    result = reduce(Plan(standards=standards), table_3())
    assert result.estimate is not None
    kind = {one.kind: one for one in result.estimate.components}
    assert kind["B"].u[result.estimate.index("bias_y")] == pytest.approx(50.0 * UG)
    assert kind["B"].u[result.estimate.index("ambient_acceleration_y")] == pytest.approx(0.0, abs=1e-12 * UG)
    assert kind["B"].stated == (50.0 * UG, "m/s^2")


# Closed forms

B, G = np.array([900.0, -700.0, 400.0]), np.array([3.0, -5.0, 2.0])


def turned(angles: Array, axis: str = "x", change: Array | None = None, labels: str = "xyz") -> Readings:
    """Readings without noise, made by the textbook's rotation of a frame, not by the module's."""
    i, j = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    outputs = {}
    y = np.tile(B + G, (len(angles), 1))
    y[:, i] = B[i] + np.cos(angles) * G[i] + np.sin(angles) * G[j]
    y[:, j] = B[j] - np.sin(angles) * G[i] + np.cos(angles) * G[j]
    y = y if change is None else y + change
    outputs = {name: y[:, "xyz".index(name)] for name in labels}
    return Readings(angles, np.full(len(angles), "1"), outputs, time=100.0 * np.arange(len(angles), dtype=np.float64))


@pytest.mark.parametrize("axis", ["x", "y", "z"])
@pytest.mark.parametrize("degrees", [(0, 180), (0, 90), (20, 200), (0, 120, 240), (0, 180, 0), (0, 45, 90, 180, 270)])
def test_general_angles_about_any_axis_give_the_truth(axis: str, degrees: tuple[float, ...]) -> None:
    result = reduce(Plan(axis=axis), turned(np.radians(degrees), axis))  # type: ignore[arg-type]
    for i, name in enumerate("xyz"):
        if name == axis:
            assert result.whole.values[result.whole.names.index(f"control_error_{name}")] == pytest.approx(0, abs=1e-9)
            assert result.whole.values[result.whole.names.index(f"reading_{name}")] == pytest.approx(B[i] + G[i])
        else:
            at = result.whole.names.index
            assert result.whole.values[at(f"bias_{name}")] == pytest.approx(B[i])
            assert result.whole.values[at(f"ambient_acceleration_{name}")] == pytest.approx(G[i])
    for curve in result.curves():
        assert np.abs(curve.columns["residual"].values).max() < 1e-9


def test_one_axis_alone_needs_what_its_unknowns_need() -> None:
    two = reduce(Plan(), turned(np.radians([0.0, 180.0]), labels="y"))
    assert two.whole.names == ("ambient_acceleration_y", "bias_y")
    half = reduce(Plan(), turned(np.radians([0.0, 90.0]), labels="y"))
    assert half.whole.names == ()
    assert row(half, "bias", "y").reason.code == "not_told_apart"
    three = reduce(Plan(), turned(np.radians([0.0, 90.0, 180.0]), labels="y"))
    assert dict(zip(three.whole.names, three.whole.values, strict=True)) == pytest.approx({
        "ambient_acceleration_y": G[1], "ambient_acceleration_z": G[2], "bias_y": B[1],
    })  # fmt: skip


def test_a_missing_position_gives_bias_and_ambient_together_and_says_so() -> None:
    result = reduce(Plan(), turned(np.zeros(1)))
    assert row(result, "reading", "y").value == pytest.approx(B[1] + G[1])
    assert row(result, "bias", "y").value is None
    assert row(result, "bias", "y").reason.text.startswith("missing position: y was read at 0 deg only")
    assert row(result, "ambient_acceleration", "z").status == "not_estimated"
    assert row(result, "control_error", "x").status == "not_estimated"
    assert "missing_position" in {one.code for one in result.remarks}


def test_combinations_that_should_be_zero_are_as_many_as_readings_beyond_what_is_told() -> None:
    """Four readings of y at 0 and 180 deg tell two unknowns, two of z at 0 deg the sum of two: 3 of 6 are left over."""
    whole = turned(np.radians([0.0, 180.0, 0.0, 180.0]), labels="yz")
    read = {"y": whole.outputs["y"], "z": np.where(np.cos(whole.angle) > 0.0, whole.outputs["z"], np.nan)}
    found = separate(Plan(), replace(whole, outputs=read), "1")
    lines = np.hstack([found.checks["y"], found.checks["z"]])
    assert lines @ lines.T == pytest.approx(np.eye(3), abs=1e-12)
    assert lines @ np.concatenate([read["y"], np.nan_to_num(read["z"])]) == pytest.approx(np.zeros(3), abs=1e-9)


def test_an_incomplete_flip_is_not_pooled() -> None:
    means = [MeanOf("y", angle, mean, time) for time in "12" for angle, mean in ((0.0, 3.0), (math.pi, 1.0))]
    result = reduce(Plan(), readings_of_means([*means, MeanOf("y", 0.0, 99.0, "3")]))
    assert row(result, "bias", "y").value == pytest.approx(2.0)
    assert row(result, "reading", "y", "flip 3").value == pytest.approx(99.0)


@pytest.mark.parametrize("drift", ["ambient", "bias", "temperature"])
def test_a_drift_is_fitted_where_three_dwells_carry_it(drift: str) -> None:
    angles = np.radians([0.0, 180.0, 0.0, 180.0])
    since: Array = np.array([-150.0, -50.0, 50.0, 150.0])
    sign = np.cos(angles)[:, None] if drift == "ambient" else np.ones((4, 1))
    slopes = np.array([0.0, 0.02, -0.01])
    readings = turned(angles, change=sign * since[:, None] * slopes)
    readings = replace(readings, temperature=dict.fromkeys("xyz", np.asarray(20.0 + since)))
    result = reduce(Plan(drift=drift), readings)  # type: ignore[arg-type]
    name = {"ambient": "ambient_acceleration_rate", "bias": "bias_rate"}.get(drift, "bias_temperature_coefficient")
    assert row(result, name, "y").value == pytest.approx(0.02)
    assert row(result, name, "z").value == pytest.approx(-0.01)
    assert row(result, name, "y").unit == ("m/s^2/degC" if drift == "temperature" else "m/s^3")
    assert row(result, "ambient_acceleration", "y").value == pytest.approx(G[1])
    assert row(result, "bias", "z").value == pytest.approx(B[2])


def test_a_drift_that_cannot_be_told_is_refused() -> None:
    with pytest.raises(DataError, match=r"2 dwells of a flip cannot determine a drift of bias .*bias_rate_y"):
        reduce(Plan(drift="bias"), turned(np.radians([0.0, 180.0])))
    three = turned(np.radians([0.0, 180.0, 0.0]))
    with pytest.raises(DataError, match="a dwell has no temperature"):
        reduce(Plan(drift="temperature"), three)
    with pytest.raises(DataError, match="a dwell has no time"):
        reduce(Plan(drift="ambient"), replace(three, time=None))


@pytest.mark.parametrize("name", ["turn.angle", "turn.axis", "sensor.scale_factor"])
def test_type_b_is_the_change_that_a_wrong_standard_makes(name: str) -> None:
    """Each sensitivity against readings made with that standard off by a small amount, by scipy's rotations."""
    small = 1e-6
    angles = np.radians([0.0, 180.0])
    plan = Plan(standards={name: Influence(small, "rad")}, raw_bias=1000.0)
    clean = turned(angles)
    found = reduce(plan, clean).whole.separated[0]
    expected = patterns(plan, clean, found)[name]
    g = np.array([0.0, G[1], G[2]])
    if name == "turn.angle":
        vectors = [np.outer(angles + small * (angles > 0.0), [1.0, 0.0, 0.0])]
    else:
        ends = [Rotation.from_rotvec(small * np.eye(3)[i]).apply([1.0, 0.0, 0.0]) for i in (1, 2)]
        vectors = [np.outer(angles, end) for end in ends]
    if name == "sensor.scale_factor":
        changes = [
            np.where(np.arange(3) == i, small * (clean.outputs["xyz"[i]][:, None] + 1000.0), 0.0) for i in range(3)
        ]
    else:
        alike = [[g], [g, np.array([np.hypot(*G[1:]), 0.0, 0.0])]][name == "turn.axis"]
        straight = Rotation.from_rotvec(-np.outer(angles, [1.0, 0.0, 0.0]))
        changes = [Rotation.from_rotvec(-v).apply(one) - straight.apply(one) for v in vectors for one in alike]
    made = [
        reduce(plan, turned(angles, change=change)).whole.values - reduce(plan, clean).whole.values
        for change in changes
    ]
    assert np.allclose(made, expected, atol=1e-9, rtol=1e-3)
    assert np.abs(expected).max() > 1e-7


def test_readings_of_the_wrong_size_are_named() -> None:
    good = table_3()
    assert "magnitude" not in {one.code for one in reduce(Plan(), good).remarks}
    for scale, severity in ((1e6, "error"), (1e-6, "warning")):  # ug read as g, and g read as ug
        slipped = replace(good, outputs={axis: y * scale for axis, y in good.outputs.items()})
        result = reduce(Plan(), slipped)
        assert {row.status for row in result.rows() if not str(row.case)} == {"not_estimated"}
        assert all(row.u is None and row.interval is None for row in result.rows())
        found = [one for one in result.remarks if one.code == "magnitude"]
        assert found
        assert found[0].severity == severity


def test_what_cannot_be_reduced_is_refused() -> None:
    with pytest.raises(DataError, match="no dwells"):
        readings_of_means([])
    with pytest.raises(DataError, match="no dwells"):
        reduce(Plan(), Readings(np.zeros(0), np.zeros(0, dtype=str), {}))
    with pytest.raises(DataError, match="no axis was read"):
        reduce(Plan(), Readings(np.zeros(1), np.array(["1"]), {"y": np.array([np.nan])}))
    with pytest.raises(DataError, match="axis y stands twice at 180 deg of flip 1"):
        readings_of_means([MeanOf("y", math.pi, 1.0), MeanOf("y", math.pi, 2.0)])
    with pytest.raises(DataError, match="axis 'w'"):
        readings_of_means([MeanOf("w", 0.0, 1.0)])
    with pytest.raises(DataError, match="position nan"):
        readings_of_means([MeanOf("y", math.nan, 1.0)])


# Invariants

numbers = st.floats(-1e3, 1e3)
positions = st.lists(st.floats(-170.0, 170.0), min_size=3, max_size=6, unique=True).filter(
    lambda found: np.diff(np.sort(found)).min() > 5.0
)


def values(result: Result) -> dict[str, float]:
    return dict(zip(result.whole.names, result.whole.values.tolist(), strict=True))


@given(positions, numbers, st.integers(0, 99))
def test_a_shift_is_bias_alone(degrees: list[float], shift: float, seed: int) -> None:
    angles = np.radians(degrees)
    noise = np.random.default_rng(seed).normal(size=(len(angles), 3))
    one, other = (values(reduce(Plan(), turned(angles, change=noise + by))) for by in (0.0, shift))
    for name, value in one.items():
        moved = shift if name.startswith(("bias", "reading")) else 0.0
        assert other[name] == pytest.approx(value + moved, abs=1e-6)


@given(positions, st.floats(-9.0, 9.0), st.integers(0, 99))
def test_a_scale_goes_through(degrees: list[float], scale: float, seed: int) -> None:
    angles = np.radians(degrees)
    noise = np.random.default_rng(seed).normal(size=(len(angles), 3))
    readings = turned(angles, change=noise)
    scaled = replace(readings, outputs={axis: scale * y for axis, y in readings.outputs.items()})
    one, other = values(reduce(Plan(), readings)), values(reduce(Plan(), scaled))
    assert other == pytest.approx({name: scale * value for name, value in one.items()}, abs=1e-6)


@given(positions, st.integers(0, 99))
def test_the_names_of_the_axes_may_go_round(degrees: list[float], seed: int) -> None:
    angles = np.radians(degrees)
    readings = turned(angles, change=np.random.default_rng(seed).normal(size=(len(angles), 3)))
    round_ = {"x": "y", "y": "z", "z": "x"}
    moved = replace(readings, outputs={round_[axis]: y for axis, y in readings.outputs.items()})
    one, other = values(reduce(Plan(), readings)), values(reduce(Plan(axis="y"), moved))
    assert other == pytest.approx({name[:-1] + round_[name[-1]]: value for name, value in one.items()}, abs=1e-6)


@given(positions, st.integers(0, 99))
def test_turning_the_other_way_is_a_mirror(degrees: list[float], seed: int) -> None:
    """With the angles' sign turned and one turned axis mirrored, all is as before but for that axis' sign."""
    angles = np.radians(degrees)
    readings = turned(angles, change=np.random.default_rng(seed).normal(size=(len(angles), 3)))
    mirrored = replace(readings, angle=-angles, outputs=dict(readings.outputs) | {"z": -readings.outputs["z"]})
    one, other = values(reduce(Plan(), readings)), values(reduce(Plan(), mirrored))
    signs = {name: -1.0 if name.endswith("_z") or "quadrature" in name else 1.0 for name in one}
    assert other == pytest.approx({name: signs[name] * value for name, value in one.items()}, abs=1e-6)


@given(st.permutations(range(5)))
def test_the_order_of_the_dwells_does_not_matter(order: list[int]) -> None:
    angles = np.radians([0.0, 60.0, 110.0, 180.0, 250.0])
    change = np.random.default_rng(3).normal(size=(5, 3))
    one = values(reduce(Plan(), turned(angles, change=change)))
    other = values(reduce(Plan(), turned(angles[order], change=change[order])))
    assert other == pytest.approx(one, abs=1e-9)

"""Gyros of which the rotations do not tell everything: no value where nothing is told, and true ones elsewhere."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from independent.positions import FACES, LATITUDE, Drawn, G, Unit, by_hand, six_faces, turned_block
from inertialcal.core.errors import DataError
from inertialcal.core.estimate import Array
from inertialcal.core.key import AXES, Key
from inertialcal.core.recording import Channel, Recording
from inertialcal.procedures.positions.recordings import ACC, GYRO, Section
from inertialcal.procedures.positions.reduction import Plan, Readings, Result, Triad, readings_from, reduce
from inertialcal.statistics.intervals import coverage_factor, covers

RATE = 50.0  # [samples/s]
PLAN = Plan(gravity=G, latitude=float(LATITUDE))
UNIT = Unit(g_sensitivity=2e-4)
SEEDS = range(1, 7)
XYZ = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
XZ = ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
DIAGONAL = ((1.0, 1.0, 0.0), (0.0, 0.0, 1.0))
FAR = 5.0  # standard uncertainties, beyond which no figure lies by chance
OF_Y = {"scale_factor_error_y", "misalignment_xy", "misalignment_zy", "misalignment_yx", "misalignment_yz"}
OF_XY = OF_Y | {"scale_factor_error_x", "misalignment_xz", "misalignment_zx"}
Spoil = Callable[[Array], None]


def recording(samples: Array, rate: float) -> Recording:
    stamps = np.round(np.arange(len(samples)) / rate * 1e9).astype(np.int64)
    names = [(name, "m/s^2") for name in ACC] + [(name, "rad/s") for name in GYRO]
    channels = tuple(Channel(name, samples[:, k].copy(), unit) for k, (name, unit) in enumerate(names))
    return Recording(channels, stamps, 1.0 / rate)


def reduced(samples: Array, sections: list[tuple[int, int, str, Array]]) -> Result:
    parts = []
    for first, stop, name, vector in sections:
        size = float(np.linalg.norm(vector))
        x, y, z = (float(one) for one in vector / size)
        if name == "turn":
            parts.append(Section(first, stop, axis=(x, y, z), angle=size, name=name))
        else:
            parts.append(Section(first, stop, direction=(x, y, z), name=name))
    return reduce(PLAN, readings_from(PLAN, [recording(samples, RATE)], [parts], saturated=[True]))


def truth_of(key: Key, truth: Drawn) -> float:
    i, j = (AXES.index(one) for one in (key.axis * 2)[:2])
    W = truth.W
    errors = {"scale_factor_error": W[i, i] - 1.0, "misalignment": W[i, j] / W[i, i]}
    return float((errors | {"bias": truth.c[i], "g_sensitivity": truth.G[i, j]})[key.quantity])


def at_the_end_of_the_range(samples: Array) -> None:
    samples[np.abs(samples[:, 4]) > 1.0, 4] = np.nan


def stuck(samples: Array) -> None:
    samples[:, 4] = 0.01


def dead(samples: Array) -> None:
    samples[:, 4] = 0.01 + 0.002 * np.random.default_rng(1).standard_normal(len(samples))


def wired_to_x(samples: Array) -> None:
    samples[:, 4] = samples[:, 3]


CASES: dict[str, tuple[Spoil | None, tuple[tuple[float, float, float], ...], set[str]]] = {
    "y saturated": (at_the_end_of_the_range, XYZ, OF_Y),
    "y not turned": (None, XZ, OF_Y),
    "x and y turned together": (None, DIAGONAL, OF_XY | {"misalignment_yz", "misalignment_zy"}),
}


@pytest.mark.parametrize("wobble", [0.02, 0.5])
@pytest.mark.parametrize("name", CASES)
def test_what_no_turn_tells_has_no_value_and_the_rest_holds_the_truth(name: str, wobble: float) -> None:
    """A block that leans by half a degree turns y a little, and that is no turn about y."""
    spoil, axes, lost = CASES[name]
    inside = []
    for seed in SEEDS:
        truth, samples, sections = turned_block(seed, UNIT, axes, wobble=wobble)
        if spoil is not None:
            spoil(samples)
        result = reduced(samples, sections)
        one, model = result.estimates["gyro"], result.models["gyro"]
        assert set(one.names) & lost == set()
        assert lost <= {str(row.key._replace(sensor="")) for row in result.rows() if row.reason.code == "not_told"}
        assert "not_observable" in {remark.code for remark in result.remarks}
        assert np.all(np.abs(model.matrix[0] - np.eye(3)) < 0.1)
        assert {"g_sensitivity_xy", "g_sensitivity_yy", "bias_y"} <= set(one.names)
        for key, value, u, dof in zip(one.keys, one.values, one.u, one.dof, strict=True):
            if key.quantity == "misalignment" and name == "x and y turned together":
                continue
            away = abs(value - truth_of(key, truth))
            inside.append(away <= coverage_factor(float(dof)) * u)
            assert away < FAR * u
    assert covers(sum(inside), len(inside))


@pytest.mark.parametrize("spoil", [stuck, dead, wired_to_x])
def test_a_gyro_that_reads_no_turn_is_named(spoil: Spoil) -> None:
    _, samples, sections = turned_block(1, UNIT)
    spoil(samples)
    with pytest.raises(DataError, match="a turn about y shows in no gyro") as error:
        reduced(samples, sections)
    assert error.value.problems[0].code == "turn_not_read"


@pytest.mark.parametrize("spoil", [dead, wired_to_x])
def test_by_hand_a_dead_gyro_gives_no_matrix(spoil: Spoil) -> None:
    table = by_hand(3, positions=14, rest=2.5, turn=1.0, first_rest=4.0).tables["hand.csv"]
    samples = np.column_stack([table.columns[name] for name in table.signals])
    spoil(samples)
    result = reduce(PLAN, readings_from(PLAN, [recording(samples, 100.0)]))
    assert not [key for key in result.estimates["gyro"].keys if key.quantity in {"scale_factor_error", "misalignment"}]
    codes = {one.code for one in result.remarks if one.severity != "info"}
    assert {"not_observable", "rotations_do_not_close"} <= codes


@pytest.mark.parametrize("noise", [0.0, 5e-4])
@pytest.mark.parametrize("unit", ["m/s^2", "count"])
def test_an_accelerometer_that_does_not_follow_its_faces_is_named(unit: str, noise: float) -> None:
    case = six_faces(1)
    table = case.tables["faces.csv"]
    table.columns["acc_y"] = 0.1 + noise * np.random.default_rng(2).standard_normal(len(table))
    mean = np.column_stack([table.columns[f"acc_{axis}"] for axis in AXES])
    mean[:, 1] += 1e-9 * np.arange(len(table))
    direction = np.array([FACES[word] for word in table.columns["position"]], dtype=float)
    triad = Triad(mean, np.full(mean.shape, 1e-4), np.full(mean.shape, 1e-2), unit)
    with pytest.raises(DataError, match="accelerometer y does not follow the positions") as error:
        reduce(PLAN, Readings(triad, direction=direction))
    assert error.value.problems[0].code == "axis_not_read"

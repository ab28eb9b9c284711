"""Many triads at once: against scipy's least squares, known truth, and what no positions can tell."""

from __future__ import annotations

import time
from statistics import median
from typing import Any

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.stats import t as student

from inertialcal.core.errors import DataError, UsageError
from inertialcal.core.estimate import Array
from inertialcal.core.show.tables import Table
from inertialcal.procedures.positions import batch as module
from inertialcal.procedures.positions.batch import (
    FEW,
    ILL_POSED,
    NO_SCATTER,
    OK,
    OTHER_UNIT,
    STATUS,
    Form,
    PositionsBatch,
    positions_batch,
)
from inertialcal.statistics.intervals import covers

GRAVITY = 9.7994  # m/s2
NOISE = 2e-3  # m/s2
AGREE = 1e-8
FORMS: tuple[Form, ...] = ("lower", "upper")
FACES = np.vstack([np.eye(3), -np.eye(3)])
EDGES = np.array([(a, b, 0) for a in (1, -1) for b in (1, -1)], float)
CUBE = np.vstack([FACES, *(np.roll(EDGES, k, axis=1) for k in range(3))])  # 18 directions


def triads(n: int, positions: int, seed: int = 1, form: str = "lower", noise: float = NOISE) -> dict[str, Array]:
    """Triads that differ, each turned by hand into positions of its own."""
    rng = np.random.default_rng(seed)
    f = rng.normal(size=(n, positions, 3))
    f *= GRAVITY / np.linalg.norm(f, axis=2, keepdims=True)
    full = np.eye(3) + rng.normal(0.0, 0.02, (n, 3, 3))
    matrix = {"lower": np.tril(full), "upper": np.triu(full), "full": full}[form]
    bias = rng.normal(0.0, 0.2, (n, 3))
    readings = np.einsum("nij,npj->npi", matrix, f) + bias[:, None] + rng.normal(0.0, noise, f.shape)
    return {"readings": readings, "matrix": matrix, "bias": bias, "f": f}


def matrices(found: PositionsBatch) -> Array:
    """M of each unit out of its parameters, entry by entry as the model words them."""
    m = np.zeros((len(found), 3, 3))
    for name, value in zip(found.names, found.values.T, strict=True):
        *_, axes = name.split("_")
        if name.startswith("scale"):
            m[:, "xyz".index(axes), "xyz".index(axes)] = 1.0 + value
    for name, value in zip(found.names, found.values.T, strict=True):
        if name.startswith("misalignment"):
            i, j = ("xyz".index(a) for a in name[-2:])
            m[:, i, j] = value * m[:, i, i]
    return m


def scipy_fit(readings: Array, form: str = "lower") -> Array:
    """One unit by Levenberg-Marquardt: entries of M in the triangle, then b, as nobody here words them."""
    rows, columns = np.tril_indices(3) if form == "lower" else np.triu_indices(3)

    def residual(p: Array) -> Array:
        m = np.zeros((3, 3))
        m[rows, columns] = p[:6]
        return np.asarray(np.linalg.norm(np.linalg.solve(m, (readings - p[6:]).T), axis=0) - GRAVITY)

    def slope(p: Array) -> Array:
        m = np.zeros((3, 3))
        m[rows, columns] = p[:6]
        y = np.linalg.solve(m, (readings - p[6:]).T)
        w = np.linalg.solve(m.T, y / np.linalg.norm(y, axis=0))
        return np.vstack([-w[rows] * y[columns], -w]).T

    start = np.concatenate([np.eye(3)[rows, columns], np.zeros(3)])
    tight: dict[str, Any] = {"xtol": 1e-15, "ftol": 1e-15, "gtol": 1e-15}
    return np.asarray(least_squares(residual, start, slope, method="lm", **tight).x)


@pytest.mark.parametrize("form", ["lower", "upper"])
def test_agrees_with_a_search_of_each_unit_alone(form: Any) -> None:
    made = triads(20, 24, form=form)
    found = positions_batch(made["readings"], GRAVITY, form=form)
    assert np.all(found.status == OK)
    rows, columns = np.tril_indices(3) if form == "lower" else np.triu_indices(3)
    own = np.column_stack([matrices(found)[:, rows, columns], found.values[:, 6:]])
    assert np.max(np.abs(own - [scipy_fit(r, form) for r in made["readings"]])) < AGREE


@pytest.mark.parametrize("form", ["lower", "upper"])
def test_without_noise_the_truth_comes_back(form: Any) -> None:
    made = triads(30, 12, seed=2, form=form, noise=0.0)
    found = positions_batch(made["readings"], GRAVITY, form=form)
    np.testing.assert_allclose(matrices(found), made["matrix"], atol=1e-10)
    np.testing.assert_allclose(found.values[:, 6:], made["bias"], atol=1e-9)


def test_forms_differ_by_a_rotation_alone() -> None:
    readings = triads(20, 24, form="full")["readings"]
    lower, upper = (positions_batch(readings, GRAVITY, form=form) for form in FORMS)
    below, above = matrices(lower), matrices(upper)
    np.testing.assert_allclose(below @ below.transpose(0, 2, 1), above @ above.transpose(0, 2, 1), atol=AGREE)
    np.testing.assert_allclose(lower.values[:, 6:], upper.values[:, 6:], atol=AGREE)
    np.testing.assert_allclose(lower.squares, upper.squares, rtol=1e-6)
    np.testing.assert_allclose(lower.u[:, 6:], upper.u[:, 6:], rtol=1e-5)


@pytest.mark.parametrize("known", [False, True])
def test_a_missing_position_counts_for_nothing(known: bool) -> None:
    made = triads(6, 24, noise=NOISE)
    f = made["f"][0] / GRAVITY
    readings = np.einsum("nij,pj->npi", made["matrix"], f * GRAVITY) + NOISE * np.sin(np.arange(24 * 3).reshape(24, 3))
    determined = {"directions": f} if known else {}
    whole = positions_batch(
        np.delete(readings, 4, axis=1), GRAVITY, **({"directions": np.delete(f, 4, 0)} if known else {})
    )
    holed = readings.copy()
    holed[2:, 4, 1] = np.nan
    found = positions_batch(holed, GRAVITY, **determined)
    np.testing.assert_allclose(found.values[2:], whole.values[2:], atol=1e-11)
    np.testing.assert_allclose(found.covariance[2:], whole.covariance[2:], rtol=1e-7, atol=1e-18)
    assert found.positions.tolist() == [24, 24, 23, 23, 23, 23]
    assert not np.array_equal(found.values[0], whole.values[0])


def test_no_figure_depends_on_threads_or_neighbours(monkeypatch: pytest.MonkeyPatch) -> None:
    readings = triads(700, 24)["readings"]
    bits = []
    for workers in (1, 3):
        monkeypatch.setattr(module, "WORKERS", workers)
        found = positions_batch(readings, GRAVITY)
        bits.append((found.values.tobytes(), found.covariance.tobytes()))
    assert bits[0] == bits[1]
    assert positions_batch(readings[417], GRAVITY).values.tobytes() == found.values[417].tobytes()


def hits(n: int, known: bool) -> tuple[dict[str, int], int]:
    """How often the 95 % interval of each parameter holds the truth."""
    made = triads(n, 24, seed=5)
    directions = made["f"][0] / GRAVITY
    if known:
        noise = np.random.default_rng(6).normal(0.0, NOISE, made["f"].shape)
        inputs = np.einsum("nij,pj->npi", made["matrix"], GRAVITY * directions)
        found = positions_batch(inputs + made["bias"][:, None] + noise, GRAVITY, directions=directions)
        dof = 20.0
    else:
        found, dof = positions_batch(made["readings"], GRAVITY), 15.0
    own = np.diagonal(made["matrix"], axis1=1, axis2=2)
    truth = {f"scale_factor_error_{a}": own[:, i] - 1.0 for i, a in enumerate("xyz")}
    truth |= {f"bias_{a}": made["bias"][:, i] for i, a in enumerate("xyz")}
    truth |= {
        f"misalignment_{a}{b}": made["matrix"][:, i, j] / own[:, i]
        for i, a in enumerate("xyz") for j, b in enumerate("xyz") if i != j
    }  # fmt: skip
    off = np.abs(found.values - np.column_stack([truth[name] for name in found.names]))
    held = np.sum(off <= student.ppf(0.975, dof) * found.u, axis=0)
    return dict(zip(found.names, held.tolist(), strict=True)), n


@pytest.mark.parametrize("known", [False, True])
def test_intervals_hold_the_truth(known: bool) -> None:
    held, n = hits(5000, known)
    assert all(covers(one, n) for one in held.values()), held


def test_given_scatter_sets_the_uncertainty_and_chi_square() -> None:
    found = positions_batch(triads(2000, 24)["readings"], GRAVITY, scatter=NOISE)
    assert np.mean(found.chi_square) == pytest.approx(15.0, abs=0.5)
    free = positions_batch(triads(2000, 24)["readings"], GRAVITY)
    np.testing.assert_allclose(free.u / found.u, np.sqrt(found.chi_square / 15.0)[:, None] * np.ones(9), rtol=1e-6)
    assert np.isinf(found.estimate(3).dof).all()
    assert free.estimate(3).dof == pytest.approx([15.0] * 9)
    assert np.isnan(free.chi_square).all()


def six_faces(off: float = 0.0) -> Array:
    """Six faces of one unit with noise; ``off``: how far each face is off [rad]."""
    rng = np.random.default_rng(3)
    f = FACES + rng.normal(0.0, off, FACES.shape)
    return np.asarray(GRAVITY * f / np.linalg.norm(f, axis=1, keepdims=True)) + rng.normal(0.0, 1e-4, FACES.shape)


def test_six_faces_twice_do_not_tell_misalignment() -> None:
    found = positions_batch(np.vstack([six_faces(), six_faces()]), GRAVITY)
    assert found.status.tolist() == [ILL_POSED]
    assert np.isnan(found.values).all()
    assert np.isnan(found.u).all()
    assert [remark.code for remark in found.remarks] == ["ill_posed"]
    known = positions_batch(np.vstack([six_faces(), six_faces()]), GRAVITY, directions=np.vstack([FACES, FACES]))
    assert known.status.tolist() == [OK]


def test_units_without_an_estimate_are_told_and_leave_the_others_alone() -> None:
    readings = triads(6, 12, noise=NOISE)["readings"]
    readings[1, 2:6] = np.nan  # eight positions
    readings[2, :3] = np.nan  # nine
    readings[3] /= GRAVITY  # in g
    readings[4] = readings[4, :1]  # one position, twelve times
    found = positions_batch(readings, GRAVITY)
    assert found.status.tolist() == [OK, FEW, NO_SCATTER, OTHER_UNIT, ILL_POSED, OK]
    assert np.isfinite(found.values[2]).all()
    assert np.isnan(found.u[2]).all()
    assert np.isnan(found.values[[1, 3, 4]]).all()
    assert {remark.code: remark.count for remark in found.remarks} == dict.fromkeys(
        ("too_few_positions", "no_scatter", "ill_posed", "unit_slip"), 1
    )
    assert found.words[3] == STATUS[OTHER_UNIT]
    with pytest.raises(DataError, match="unit 2: as many positions as parameters") as caught:
        found.estimate(2)
    assert caught.value.problems[0].code == "no_scatter"
    np.testing.assert_allclose(found.values[5], positions_batch(readings[5], GRAVITY).values[0], rtol=0.0)


def test_gravity_may_differ_from_unit_to_unit() -> None:
    made = triads(4, 24, noise=0.0)
    own = np.array([9.78, 9.80, 9.81, 9.83])
    readings = (made["readings"] - made["bias"][:, None]) * (own / GRAVITY)[:, None, None] + made["bias"][:, None]
    found = positions_batch(readings, own)
    np.testing.assert_allclose(matrices(found), made["matrix"], atol=1e-10)
    np.testing.assert_allclose(found.values[:, 6:], made["bias"], atol=1e-9)


def test_known_positions_are_the_least_squares_line_of_each_sensor() -> None:
    made = triads(5, 18, form="full")
    noise = np.random.default_rng(8).normal(0.0, NOISE, (5, 18, 3))
    f = GRAVITY * CUBE / np.linalg.norm(CUBE, axis=1, keepdims=True)
    readings = np.einsum("nij,pj->npi", made["matrix"], f) + made["bias"][:, None] + noise
    found = positions_batch(readings, GRAVITY, directions=2.0 * CUBE)
    design = np.column_stack([np.ones(18), f])
    line = np.array([np.linalg.lstsq(design, r, rcond=None)[0] for r in readings])
    np.testing.assert_allclose(matrices(found), line[:, 1:].transpose(0, 2, 1), atol=1e-12)
    np.testing.assert_allclose(found.values[:, 9:], line[:, 0], atol=1e-11)
    assert found.dof.tolist() == [42] * 5
    assert found.estimate(0).dof == pytest.approx([14.0] * 12)


def test_directions_along_one_line_are_refused() -> None:
    readings = triads(3, 6)["readings"]
    with pytest.raises(DataError, match="6 directions cannot tell") as caught:
        positions_batch(readings, GRAVITY, directions=[[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]] * 3)
    assert caught.value.problems[0].code == "ill_posed"


@pytest.mark.parametrize(
    ("words", "match"),
    [
        ({"readings": np.ones((4, 3, 2))}, "need \\(units, positions, 3\\)"),
        ({"gravity": -9.8}, "one positive value"),
        ({"gravity": [9.8, 9.8]}, "or one a unit"),
        ({"scatter": 0.0}, "scatter 0.0"),
        ({"form": "full"}, "form 'full'"),
        ({"directions": np.zeros((12, 3))}, "none of length zero"),
        ({"directions": np.ones((11, 3))}, "need \\(12, 3\\)"),
    ],
)
def test_what_cannot_be_meant_is_refused(words: dict[str, Any], match: str) -> None:
    given: dict[str, Any] = {"readings": triads(3, 12)["readings"], "gravity": GRAVITY} | words
    with pytest.raises(UsageError, match=match):
        positions_batch(**given)


@pytest.mark.bench
def test_ten_thousand_triads_take_less_than_a_sixth_of_a_second() -> None:
    """The loop of scipy is measured on 200 of the 10,000 units, and scaled."""
    readings = triads(10_000, 24)["readings"]
    positions_batch(readings, GRAVITY)  # compiled
    spent = []
    for _ in range(5):
        started = time.perf_counter()
        found = positions_batch(readings, GRAVITY)
        spent.append(time.perf_counter() - started)
    started = time.perf_counter()
    peers = np.array([scipy_fit(r) for r in readings[:200]])
    peer = (time.perf_counter() - started) * len(readings) / len(peers)
    own = np.column_stack([matrices(found)[:200][:, *np.tril_indices(3)], found.values[:200, 6:]])
    own_time = median(spent)
    print(f"\n10,000 triads x 24: {own_time:.3f} s; scipy, scaled from 200: {peer:.1f} s, {peer / own_time:.0f} x")
    assert np.max(np.abs(own - peers)) < AGREE
    assert own_time <= 0.15
    assert peer >= 50.0 * own_time


def test_what_is_shown_of_many() -> None:
    readings = triads(40, 24)["readings"]
    readings[3, 5:] = np.nan
    found = positions_batch(readings, GRAVITY)
    grid = found.parts()[0]
    assert isinstance(grid, Table)
    assert grid.caption == "39 of 40 units estimated"
    bias = next(row for row in grid.rows if row[0] == "bias_x")
    good = np.delete(found.values[:, found.names.index("bias_x")], 3)
    assert float(bias[1]) == pytest.approx(np.median(good), rel=5e-3)
    assert float(bias[2]) == pytest.approx(good.std(ddof=1), abs=0.005)  # two digits, as every uncertainty
    assert "remarks: 1 warning" in str(found)
    none = positions_batch(readings[3], GRAVITY)
    assert "0 of 1 units estimated" in str(none)


def test_many_as_a_data_frame() -> None:
    pytest.importorskip("pandas")
    found = positions_batch(triads(3, 24)["readings"], GRAVITY)
    table = found.to_frame()
    assert table.shape == (3, 19)
    assert list(table["u_bias_z"]) == pytest.approx(list(found.u[:, found.names.index("bias_z")]))
    assert set(table["status"]) == {"estimated"}


def test_condition_is_that_of_the_jacobian_from_one_to_three_times() -> None:
    found = positions_batch(triads(30, 12)["readings"], GRAVITY, scatter=NOISE)
    size = np.array([NOISE / GRAVITY] * 6 + [NOISE] * 3)  # of the parameters, in units of gravity
    inverse = found.covariance / (size[:, None] * size)
    ratio = found.condition / np.sqrt(np.linalg.cond(inverse))
    assert np.all((ratio >= 1.0 - 1e-9) & (ratio <= 3.0))

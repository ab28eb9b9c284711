from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from inertialcal.core.errors import DataError
from inertialcal.core.estimate import Array
from inertialcal.sensors import _kernels
from inertialcal.sensors.catalogue import flight_unit
from inertialcal.sensors.model import compensate as module
from inertialcal.sensors.model.compensate import compensate, felt_range, first_order, outside
from inertialcal.sensors.model.equation import Conditions, condition_columns, curve, offset, predict
from inertialcal.sensors.model.nonlinearity import rising_branch
from inertialcal.sensors.model.sensitivity import Sensitivity
from inertialcal.sensors.model.sensor_model import SensorModel
from inertialcal.sensors.model.terms import SHAPES
from random_models import at_row, conditions, inputs, random_model

IDENTITY = 1e-12  # of full scale
SEEDS = st.integers(0, 2**32 - 1)


def plain(**terms: object) -> SensorModel:
    """Two gyros without errors, but for the terms given."""
    base = SensorModel("gyro", ("x", "y"), np.ones(2), "rad/s", np.eye(2), np.zeros(2))
    return replace(base, **terms)  # type: ignore[arg-type]


@settings(max_examples=200, deadline=None)
@given(SEEDS)
def test_forward_then_inverse_is_identity_over_the_validity_range(seed: int) -> None:
    model = random_model(seed)
    x, given_ = inputs(model, seed), conditions(model, seed)
    assert model.input_range is not None
    full_scale = float(np.max(model.input_range))
    back = compensate(model, predict(model, x, **given_), **given_)
    assert np.max(np.abs(back - x)) <= IDENTITY * full_scale


@settings(max_examples=50, deadline=None)
@given(SEEDS)
def test_inverse_then_forward_is_identity_on_readings(seed: int) -> None:
    model = random_model(seed)
    given_ = conditions(model, seed)
    assert model.input_range is not None
    noise = np.random.default_rng(seed).normal(0.0, 0.01 * model.input_range.max(), (50, len(model.axes)))
    r = predict(model, 0.9 * inputs(model, seed), **given_) + noise
    again = predict(model, compensate(model, r, **given_), **given_)
    np.testing.assert_allclose(again, r, atol=1e-12 * np.max(np.abs(r)))


@settings(max_examples=50, deadline=None)
@given(SEEDS)
def test_rows_do_not_depend_on_their_neighbours(seed: int) -> None:
    """One row at a time gives the same bits as all at once, whatever the chunks."""
    model = random_model(seed)
    x, given_ = inputs(model, seed, 7), conditions(model, seed, 7)
    r = predict(model, x, **given_)
    whole = compensate(model, r, **given_)
    for i in range(len(r)):
        np.testing.assert_array_equal(compensate(model, r[i : i + 1], **at_row(given_, i))[0], whole[i])


@settings(max_examples=30, deadline=None)
@given(SEEDS)
def test_order_of_the_axes_does_not_matter(seed: int) -> None:
    model = random_model(seed, k=3)
    given_ = conditions(model, seed)
    turn = [2, 0, 1]
    picked = {
        name: array[..., turn] if array.ndim == 1 or name in {"bias_temperature", "bias_warm_up"} else array[turn]
        for name, array in model.terms.items()
        if name in SHAPES and name not in {"matrix", "warm_up_time"}
    }
    sensitivities = tuple(
        one.with_terms({name: array[turn] for name, array in one.terms.items()}) for one in model.sensitivities
    )
    matrix = model.matrix[:, turn][:, :, turn]
    other = replace(model, axes=("z", "x", "y"), matrix=matrix, sensitivities=sensitivities, **picked)  # type: ignore[arg-type]
    r = predict(model, inputs(model, seed), **given_)
    turned: Conditions = {**given_, "temperature": np.asarray(given_["temperature"])[:, turn]}
    expected = compensate(model, r, **given_)[:, turn]
    np.testing.assert_allclose(
        compensate(other, r[:, turn], **turned),
        expected,
        rtol=1e-11,
        atol=1e-12 * float(np.max(np.abs(expected))),
    )


def test_scale_factors_over_a_channel_take_the_plain_path_at_any_length() -> None:
    supply = Sensitivity("supply", "V", 5.0, scale_factor=np.array([0.1, -0.05, 0.02]))
    model = replace(random_model(5, k=3), sensitivities=(supply,))
    given_ = conditions(model, 5)
    r = predict(model, inputs(model, 5), **given_)
    expected = compensate(model, r, **given_)
    with compiled_from(1):
        np.testing.assert_array_equal(compensate(model, r, **given_), expected)


STILL: Conditions = {
    "temperature": 21.0,
    "pressure": 9e4,
    "time": 60.0,
    "temperature_rate": 0.01,
    "specific_force": np.array([0.1, 9.8, -0.3]),
    "channels": {"supply": 5.1, "reference": 2.4, "board_temperature": 31.0},
}


def forms(seed: int) -> list[tuple[SensorModel, Conditions]]:
    """One random model of three sensors in the forms that the compiled loops tell apart."""
    rng = np.random.default_rng(seed)
    whole = random_model(seed, k=3)
    drawn = conditions(whole, seed)
    scaled, whole = whole, replace(whole, sensitivities=without_scale(whole.sensitivities))
    straight = replace(whole, scale_factor_asymmetry=None, second_order=None, third_order=None)
    alone = dict.fromkeys(("bias_pressure", "bias_warm_up", "warm_up_time", "bias_temperature_rate"))
    alone |= dict.fromkeys(("bias_hysteresis", "g_sensitivity")) | {"sensitivities": ()}
    halves = rng.normal(0.0, 0.1, 3) * (rng.random(3) < 0.7)
    asymmetric = replace(straight, scale_factor_asymmetry=halves, matrix=whole.matrix[0], **alone)  # type: ignore[arg-type]
    shared: Conditions = {**drawn, "temperature": np.asarray(drawn["temperature"])[:, 0]}
    uncoupled = replace(asymmetric, matrix=np.diag(rng.uniform(0.9, 1.1, 3)))
    some = None if whole.second_order is None else whole.second_order * [1.0, 0.0, 1.0]
    return [
        (whole, drawn),
        (whole, shared),
        (whole, STILL),
        (scaled, STILL),
        (straight, shared),
        (asymmetric, drawn),
        (asymmetric, shared),
        (uncoupled, shared),
        (replace(whole, second_order=some, third_order=None, **alone), drawn),  # type: ignore[arg-type]
        (flight_unit().models["corrected"], shared),
    ]


def without_scale(sensitivities: tuple[Sensitivity, ...]) -> tuple[Sensitivity, ...]:
    """The same without the changes of scale factors, which the compiled loops do not know."""
    return tuple(
        replace(one, scale_factor=None) for one in sensitivities if len(one.parts) > ("scale_factor" in one.parts)
    )


def awkward_readings(model: SensorModel, seed: int, given_: Conditions) -> Array:
    """Readings over the range and far beyond it, missing ones, zeros, and the ends of the rising branch."""
    rng = np.random.default_rng(seed)
    full_scale = 1.0 if model.input_range is None else float(model.input_range.max())
    r = rng.uniform(-1.5, 1.5, (50, 3)) * full_scale
    r[10:20] *= 10.0 ** rng.uniform(-12, 6, (10, 3))
    bent = curve(model)
    turns = rising_branch(bent)
    at_turns = bent.reading(np.where(np.isfinite(turns), turns, full_scale).T)
    columns = condition_columns(model, 50, given_)
    shift = np.broadcast_to(offset(model, columns), (50, 3))
    r[20:22] = at_turns + shift[20:22]
    r[22:24] = at_turns * (1.0 + 1e-12) + shift[22:24]
    r[24:26] = at_turns * (1.0 - 1e-12) + shift[24:26]
    r[26], r[27] = shift[26], 0.0
    r[28:40][rng.random((12, 3)) < 0.3] = np.nan
    return r


@contextmanager
def compiled_from(rows: int) -> Iterator[None]:
    """The compiled loops from so many rows on, and chunks that leave one row over."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "KERNEL_ROWS", rows)
        patch.setattr(module, "CHUNK", 7)
        patch.setattr(module, "KERNEL_CHUNK", 7)
        yield


def assert_compiled_gives_the_bits_of_the_plain_path(seed: int) -> None:
    for model, given_ in forms(seed):
        r = awkward_readings(model, seed, given_)
        with compiled_from(1000):
            expected = compensate(model, r, **given_)
        with compiled_from(1), pytest.MonkeyPatch.context() as patch:
            patch.setattr(module, "_inverse", None)  # the plain path is not taken
            np.testing.assert_array_equal(compensate(model, r, **given_), expected)


@settings(max_examples=30, deadline=None)
@given(SEEDS)
def test_compiled_loops_give_the_bits_of_the_plain_path(seed: int) -> None:
    assert_compiled_gives_the_bits_of_the_plain_path(seed)


@pytest.mark.parametrize("seed", range(3))
def test_loops_without_the_compiler_give_the_same_bits(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    loops = {name: loop for name, loop in vars(_kernels).items() if hasattr(loop, "py_func")}
    assert len(loops) == 10
    for name, loop in loops.items():
        monkeypatch.setattr(_kernels, name, loop.py_func)
    assert_compiled_gives_the_bits_of_the_plain_path(seed)


def test_compiled_loops_give_the_same_bits_with_any_number_of_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    model, given_ = forms(4)[0]
    r = awkward_readings(model, 4, given_)
    found = []
    for workers in (1, 2, 5):
        monkeypatch.setattr(module, "WORKERS", workers)
        with compiled_from(1):
            found.append(compensate(model, r, **given_).tobytes())
    assert found[0] == found[1] == found[2]


def test_missing_reading_does_not_spread_where_the_cross_term_is_zero_at_that_temperature() -> None:
    """M = I + 1e-3 (T - 20) off the diagonal: at 20 degC each axis stands alone, one degree off it does not."""
    k = 3
    matrix = np.array([np.eye(k), 1e-3 * (1.0 - np.eye(k))])
    model = SensorModel(
        "gyro", ("x", "y", "z"), np.ones(k), "rad/s", matrix, np.zeros(k), reference_temperature=np.full(k, 20.0)
    )
    temperature = np.where(np.arange(40) % 3 == 0, 20.0, 21.0)
    r = np.tile([1.0, np.nan, 2.0], (40, 1))
    expected = np.where((temperature == 20.0)[:, np.newaxis], r, np.nan)
    for rows_ in (1, 1000):
        with compiled_from(rows_):
            np.testing.assert_array_equal(compensate(model, r, temperature=temperature), expected)
    for i in range(4):
        np.testing.assert_array_equal(compensate(model, r[i : i + 1], temperature=temperature[i])[0], expected[i])


@pytest.mark.parametrize("chunk", [1, 511, 512, 513, 5000])
def test_compiled_loops_give_the_same_bits_whatever_the_blocks(chunk: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Rows of more than one block of the loops, and blocks that are not full."""
    model = random_model(4, k=3)
    x, given_ = inputs(model, 4, 1500), conditions(model, 4, 1500)
    r = predict(model, x, **given_)
    expected = compensate(model, r, **given_)
    monkeypatch.setattr(module, "KERNEL_ROWS", 1)
    monkeypatch.setattr(module, "KERNEL_CHUNK", chunk)
    np.testing.assert_array_equal(compensate(model, r, **given_), expected)


@settings(max_examples=30, deadline=None)
@given(SEEDS)
def test_readings_that_cannot_be_do_not_come_out_of_a_curve_by_either_path(seed: int) -> None:
    """Infinite and enormous readings of a sensor with K2 or K3 are empty, and end."""
    span = 2.0
    model = replace(
        random_model(seed, k=3, linear=True),
        second_order=np.array([0.03, -0.02, 0.0]) / span,
        third_order=np.array([0.01, 0.02, 0.03]) / span**2,
        input_range=np.array([[-span, span]] * 3),
    )
    given_ = conditions(model, seed, 4)
    r = np.tile([[np.inf], [-np.inf], [np.nan], [1e300]], 3)
    with compiled_from(1000):
        expected = compensate(model, r, **given_)
    assert np.isnan(expected).all()
    with compiled_from(1):
        np.testing.assert_array_equal(compensate(model, r, **given_), expected)


def test_temperatures_that_are_missing_do_not_count_for_the_range_of_a_matrix() -> None:
    matrix = np.array([np.eye(3), 1e-3 * np.eye(3)])
    model = SensorModel(
        "gyro", ("x", "y", "z"), np.ones(3), "rad/s", matrix, np.zeros(3), reference_temperature=np.full(3, 20.0)
    )
    x = compensate(model, np.ones((3, 3)), temperature=np.array([np.nan, 20.0, 120.0]))
    np.testing.assert_allclose(x, [[np.nan] * 3, [1.0] * 3, [1.0 / 1.1] * 3], rtol=1e-15)
    with pytest.raises(DataError, match="matrix cannot be inverted"):  # M is zero at -980 degC
        compensate(model, np.ones((3, 3)), temperature=np.array([np.nan, 20.0, -980.0]))


def test_compiled_loops_undo_the_equation() -> None:
    """The truth itself, not the plain path."""
    for seed in range(20):
        model = random_model(seed, k=3)
        x, given_ = inputs(model, seed), conditions(model, seed)
        assert model.input_range is not None
        with compiled_from(1):
            back = compensate(model, predict(model, x, **given_), **given_)
        assert np.max(np.abs(back - x)) <= IDENTITY * model.input_range.max()


def test_matrix_that_is_singular_at_a_temperature_beyond_the_range_is_refused_by_both_paths() -> None:
    """M = I (1 - (T - 20) / 100) vanishes at 120 degC."""
    matrix = np.array([np.eye(3), np.eye(3) * -0.01])
    model = SensorModel(
        "gyro",
        ("x", "y", "z"),
        np.ones(3),
        "rad/s",
        matrix,
        np.zeros(3),
        reference_temperature=np.full(3, 20.0),
        temperature_range=(0.0, 40.0),
    )
    for rows_ in (1, 1000):
        with compiled_from(rows_), pytest.raises(DataError, match="singular at a temperature of the data"):
            compensate(model, np.ones((40, 3)), temperature=np.linspace(20.0, 120.0, 40))


def test_other_than_three_sensors_take_the_plain_path_at_any_length() -> None:
    for k in (1, 2, 4):
        model = random_model(k, k=k)
        given_ = conditions(model, k)
        r = predict(model, inputs(model, k), **given_)
        expected = compensate(model, r, **given_)
        with compiled_from(1):
            np.testing.assert_array_equal(compensate(model, r, **given_), expected)


def test_one_sensor_by_hand() -> None:
    """r = 0.1 + 2 x + 0.5 * 0.2 * |2 x|: x = 3 reads 0.1 + 6 + 0.6, x = -3 reads 0.1 - 6 + 0.6."""
    model = SensorModel(
        "accelerometer",
        ("x",),
        np.ones(1),
        "m/s^2",
        np.array([[2.0]]),
        np.array([0.1]),
        scale_factor_asymmetry=np.array([0.2]),
    )
    np.testing.assert_allclose(predict(model, np.array([3.0, -3.0])), [[6.7], [-5.3]], rtol=1e-15)
    np.testing.assert_allclose(compensate(model, np.array([6.7, -5.3])), [[3.0], [-3.0]], rtol=1e-15)


def test_first_order_differs_from_the_inverse_by_the_square_of_the_errors() -> None:
    for size in (1e-2, 1e-3):
        errors = size * np.array([[1.0, -2.0], [3.0, 1.5]])
        model = plain(matrix=np.eye(2) + errors, bias=np.array([0.1, -0.2]))
        x = np.array([[1.0, 0.5]])
        r = predict(model, x)
        # r = b + (I + E) x, so r - b - E r = x - E b - E E x
        left = -errors @ model.bias - errors @ errors @ x[0]
        np.testing.assert_allclose(first_order(model, r)[0] - x[0], left, atol=1e-15)
        np.testing.assert_allclose(compensate(model, r), x, atol=1e-15)


def test_each_term_by_hand() -> None:
    model = SensorModel(
        "gyro",
        ("x",),
        np.ones(1),
        "rad/s",
        np.array([[[1.0]], [[0.01]]]),
        np.array([1.0]),
        bias_temperature=np.array([[0.1], [0.02]]),
        bias_pressure=np.array([1e-5]),
        bias_warm_up=np.array([[0.5]]),
        warm_up_time=np.array([100.0]),
        bias_temperature_rate=np.array([3.0]),
        bias_hysteresis=np.array([0.07]),
        second_order=np.array([0.02]),
        third_order=np.array([0.003]),
        g_sensitivity=np.array([[0.1, 0.2, 0.3]]),
        reference_temperature=np.array([20.0]),
        reference_pressure=1e5,
        input_range=np.array([[-2.0, 2.0]]),
        temperature_range=(0.0, 40.0),
    )
    u = (1.0 + 0.01 * 10.0) * 1.5
    offset = 1.0 + 0.1 * 10 + 0.02 * 100 - 1e-5 * 4e4 + 0.5 * np.exp(-0.5) - 3.0 * 0.01 - 0.07
    by_hand = offset + u + 0.02 * u**2 + 0.003 * u**3 + (0.1 * 1 + 0.2 * 2 + 0.3 * 3)
    r = predict(
        model,
        np.array([[1.5]]),
        temperature=30.0,
        pressure=6e4,
        time=50.0,
        temperature_rate=-0.01,
        specific_force=np.array([1.0, 2.0, 3.0]),
    )
    assert r[0, 0] == pytest.approx(by_hand, rel=1e-14)


def test_scale_error_and_misalignment_have_the_signs_of_the_words() -> None:
    """The x sensor reads 1 % too much of x and 2 % of y motion: compensation takes both away."""
    model = plain(matrix=np.array([[1.01, 0.02], [0.0, 1.0]]))
    np.testing.assert_allclose(predict(model, np.array([[1.0, 0.0], [0.0, 1.0]])), [[1.01, 0.0], [0.02, 1.0]])
    np.testing.assert_allclose(compensate(model, np.array([[1.01, 0.0]])), [[1.0, 0.0]], atol=1e-15)


def test_missing_condition_is_refused() -> None:
    model = plain(bias_temperature=np.ones((1, 2)), reference_temperature=20.0)
    with pytest.raises(DataError, match=r"no temperature given.*bias_temperature"):
        compensate(model, np.zeros((3, 2)))


@pytest.mark.parametrize("shape", [(3,), (3, 3), (3, 2, 1)])
def test_wrong_shape_is_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(DataError, match=r"readings: shape .* need \(n, 2\)"):
        compensate(plain(), np.zeros(shape))


def test_condition_of_another_length_is_refused() -> None:
    model = plain(bias_pressure=np.ones(2), reference_pressure=1e5)
    with pytest.raises(DataError, match=r"pressure: shape \(2,\) does not fit 3 reading"):
        compensate(model, np.zeros((3, 2)), pressure=np.ones(2))


def test_singular_matrix_is_refused() -> None:
    with pytest.raises(DataError, match="matrix cannot be inverted") as caught:
        compensate(plain(matrix=np.ones((2, 2))), np.zeros((1, 2)))
    assert caught.value.problems[0].code == "not_invertible"


def test_matrix_that_turns_over_inside_the_temperature_range_is_refused() -> None:
    matrix = np.array([np.eye(2), [[-0.02, 0.0], [0.0, 0.0]]])
    model = plain(matrix=matrix, reference_temperature=20.0, temperature_range=(-20.0, 90.0))
    with pytest.raises(DataError, match="matrix cannot be inverted"):
        compensate(model, np.zeros((1, 2)), temperature=20.0)


def test_curve_that_turns_inside_the_range_is_refused_and_beyond_it_is_not() -> None:
    """r = u - 0.1 u^2 turns at u = 5."""
    model = plain(second_order=np.array([0.0, -0.1]), input_range=np.array([[-6.0, 6.0]] * 2))
    with pytest.raises(DataError, match=r"y sensor's slope falls to -0.2") as caught:
        compensate(model, np.zeros((1, 2)))
    assert caught.value.problems[0].code == "not_unique"
    narrow = replace(model, input_range=np.array([[-4.0, 4.0]] * 2))
    np.testing.assert_allclose(compensate(narrow, np.array([[4.0, 2.4]])), [[4.0, 4.0]], rtol=1e-14)


def test_cross_axis_input_counts_towards_the_range() -> None:
    """u_y = y + x reaches 6 where each axis alone reaches 3."""
    matrix = np.array([[1.0, 0.0], [1.0, 1.0]])
    model = plain(matrix=matrix, second_order=np.array([0.0, -0.1]), input_range=np.array([[-3.0, 3.0]] * 2))
    np.testing.assert_allclose(felt_range(model.matrix, model.input_range), [[-3, 3], [-6, 6]])  # type: ignore[arg-type]
    with pytest.raises(DataError, match="slope falls"):
        compensate(model, np.zeros((1, 2)))


def test_curve_that_turns_needs_an_input_range() -> None:
    with pytest.raises(DataError, match="y sensor's curve turns, and the model has no input range") as caught:
        compensate(plain(second_order=np.array([0.0, -0.1])), np.zeros((1, 2)))
    assert caught.value.problems[0].code == "no_validity_range"


def test_curve_that_rises_everywhere_needs_none() -> None:
    """Slope 1 + 0.2 u + 0.03 u^2 has no zero: 0.04 < 0.12."""
    model = plain(second_order=np.array([0.1, 0.1]), third_order=np.array([0.01, 0.01]))
    x = np.array([[-1e4, 1e4], [0.0, 3.0]])
    np.testing.assert_allclose(compensate(model, predict(model, x)), x, rtol=1e-13)


def test_reading_that_no_input_gives_is_empty_and_counted() -> None:
    """r = u - 0.1 u^2 never exceeds 2.5."""
    model = plain(second_order=np.array([0.0, -0.1]), input_range=np.array([[-4.0, 4.0]] * 2))
    r = np.array([[1.0, 2.4], [1.0, 2.6], [1.0, np.nan], [5.0, 0.0]])
    x = compensate(model, r)
    assert np.isnan(x[1, 1])
    assert np.isnan(x[2, 1])
    assert np.isfinite(x[[0, 3]]).all()
    remarks = {remark.code: remark for remark in outside(model, x, r)}
    assert set(remarks) == {"no_inverse", "outside_input_range"}
    assert (remarks["no_inverse"].count, remarks["no_inverse"].where) == (1, "row 1")
    assert remarks["outside_input_range"].where == "row 3"


def test_conditions_outside_their_range_are_counted() -> None:
    model = plain(
        bias_temperature=np.ones((1, 2)),
        bias_pressure=np.ones(2),
        reference_temperature=20.0,
        reference_pressure=1e5,
        temperature_range=(0.0, 40.0),
        pressure_range=(1.0, 2e5),
    )
    temperature, pressure = np.array([20.0, 50.0, -1.0]), np.array([0.5, 1e5, 1e5])
    r = np.zeros((3, 2))
    x = compensate(model, r, temperature=temperature, pressure=pressure)
    remarks = {one.code: one.count for one in outside(model, x, r, temperature=temperature, pressure=pressure)}
    assert remarks == {"outside_temperature_range": 2, "outside_pressure_range": 1}


def test_channels_outside_their_range_are_counted() -> None:
    one = Sensitivity("supply", "V", 5.0, bias=np.ones(2), range=(4.9, 5.1))
    model = plain(sensitivities=(one, Sensitivity("reference", "V", 2.5, bias=np.ones(2), range=(2.0, 3.0))))
    r = np.zeros((3, 2))
    given_: dict[str, Array | float] = {"supply": np.array([4.8, 5.0, 5.2]), "reference": 2.5}
    (remark,) = outside(model, compensate(model, r, channels=given_), r, channels=given_)
    assert (remark.code, remark.count, remark.where) == ("outside_channel_range", 2, "row 0")
    assert "beyond the supply range (4.9 to 5.1 V)" in remark.what


def test_a_channel_that_is_missing_is_named() -> None:
    model = plain(sensitivities=(Sensitivity("supply", "V", 5.0, bias=np.ones(2)),))
    with pytest.raises(DataError, match=r"no supply given \(the model has the term bias_supply\)") as caught:
        compensate(model, np.zeros((1, 2)), channels={"reference": 2.5})
    assert caught.value.problems[0].code == "missing_condition"


def test_supply_by_hand() -> None:
    """K0 = 0.1 + 0.2 d + 0.01 d (T - 20), M = 1 + 0.5 d, at d = 0.4 V and 30 degC."""
    supply = Sensitivity("supply", "V", 5.0, np.array([0.2]), np.array([0.01]), np.array([0.5]))
    bare = SensorModel("gyro", ("x",), np.ones(1), "rad/s", np.eye(1), np.array([0.1]))
    model = replace(bare, reference_temperature=np.array([20.0]), sensitivities=(supply,))
    r = predict(model, np.array([3.0]), channels={"supply": 5.4}, temperature=30.0)
    assert r[0, 0] == pytest.approx(0.1 + 0.08 + 0.04 + 3.0 * 1.2, rel=1e-15)
    assert compensate(model, r, channels={"supply": 5.4}, temperature=30.0)[0, 0] == pytest.approx(3.0, rel=1e-15)


def test_a_scale_factor_that_vanishes_inside_the_range_of_a_channel_is_refused() -> None:
    one = Sensitivity("supply", "V", 5.0, scale_factor=np.array([2.0, 0.0]), range=(4.4, 5.6))
    with pytest.raises(DataError, match="cannot be inverted"):
        compensate(plain(sensitivities=(one,)), np.zeros((1, 2)), channels={"supply": 5.0})


def test_missing_readings_and_temperatures_stay_missing() -> None:
    model = random_model(11, linear=True, k=3)
    given_ = conditions(model, 1, 5)
    r = predict(model, inputs(model, 1, 5), **given_)
    r[1, 0] = np.nan
    x = compensate(model, r, **given_)
    assert np.isnan(x[1]).any()
    assert np.isfinite(x[[0, 2, 3, 4]]).all()


def test_no_readings_give_no_inputs() -> None:
    assert compensate(random_model(3, k=2), np.empty((0, 2)), **conditions(random_model(3, k=2), 1, 0)).shape == (0, 2)

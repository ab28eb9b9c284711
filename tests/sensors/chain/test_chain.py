from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from inertialcal.core.errors import DataError, PlanError
from inertialcal.sensors.catalogue import flight_unit, mesa, sams_head
from inertialcal.sensors.chain.conversion import convert, to_counts, to_temperature_counts
from inertialcal.sensors.chain.converter import Chain, Thermometer, pulse_counter

CODES = st.lists(st.tuples(*[st.integers(1, 4094)] * 3), min_size=1, max_size=30)
REFERENCES = st.integers(1900, 2200)


def adc(**fields: object) -> Chain:
    """A 12-bit converter of 5 V on one axis."""
    return Chain(**({"axes": ("x",), "step": 5.0 / 4095, "codes": (0, 4095)} | fields))  # type: ignore[arg-type]


def column(*codes: float) -> np.ndarray:
    return np.array(codes, dtype=float)[:, np.newaxis]


def test_volts_by_hand() -> None:
    """(code - reference code) 5/4095 V; the zero stands before the gain, the scale factor comes last."""
    chain = adc(reference="channel", zero=0.05, gain=4.0, scale_factor=0.5)
    got = convert(chain, column(3000), reference=column(2048))
    volts = (952 * 5.0 / 4095 - 0.05) / 4.0
    assert got.output[0, 0] == pytest.approx(volts, rel=1e-14)
    assert got.readings is not None
    assert got.readings[0, 0] == pytest.approx(volts / 0.5, rel=1e-14)


def test_reference_is_subtracted_sample_by_sample() -> None:
    got = convert(adc(reference="channel"), column(2100, 2101, 2099), reference=column(2048, 2049, 2047))
    np.testing.assert_allclose(got.output, 52 * 5.0 / 4095, rtol=1e-13)


def test_fixed_reference() -> None:
    assert convert(adc(reference=2.5), column(4000)).output[0, 0] == pytest.approx(4000 * 5 / 4095 - 2.5)


def test_zero_in_temperature() -> None:
    """Z = 0.01 + 0.002 T; the thermometer gives T from its own volts above the reference."""
    chain = adc(
        axes=("x", "y"),
        reference="channel",
        zero=np.array([[0.01, 0.0], [0.002, 0.0]]),
        thermometer=Thermometer(0.0264, np.array([-0.5, -0.4]), np.array([25.7, 25.4])),
    )
    got = convert(chain, np.array([[3000, 3000]]), reference=np.array([2048]), temperature=np.array([[1700, 1710]]))
    t_x = ((1700 - 2048) * 5.0 / 4095 + 0.5) / 0.0264 + 25.7
    assert got.temperature is not None
    assert got.temperature[0, 0] == pytest.approx(t_x, rel=1e-13)
    assert got.output[0, 0] == pytest.approx(952 * 5.0 / 4095 - 0.01 - 0.002 * t_x, rel=1e-12)
    assert got.output[0, 1] == pytest.approx(952 * 5.0 / 4095, rel=1e-13)


def test_thermometer_gives_its_reference_point_and_slope() -> None:
    """Table 2 of the thesis: V_n at T_ref; a degree more is 26.4 mV more."""
    thermometer = flight_unit().chains["flight"].thermometer
    assert thermometer is not None
    v_n, t_ref = np.array([-0.5042, -0.4909, -0.5071]), np.array([25.7, 25.4, 25.3])
    np.testing.assert_allclose(thermometer.degrees(v_n), t_ref)
    np.testing.assert_allclose(thermometer.degrees(v_n + 0.0264), t_ref + 1.0)
    np.testing.assert_allclose(thermometer.volts(t_ref - 1.0), v_n - 0.0264)


def test_zero_of_one_row_is_constant() -> None:
    assert convert(adc(zero=np.array([[0.25]])), column(2000)).output[0, 0] == pytest.approx(2000 * 5 / 4095 - 0.25)


def test_gain_over_time() -> None:
    """The head at gains of 100 and 10: ten times the volts at the same input."""
    chain = adc(codes=(-32768, 32767), step=10.0 / 65536)
    got = convert(chain, column(1000, 100), gain=np.array([100.0, 10.0]))
    np.testing.assert_allclose(got.output, 1000 * 10 / 65536 / 100, rtol=1e-14)


def test_gains_of_the_head() -> None:
    got = convert(sams_head().chains["flight"], np.array([[16384, -16384, 16384]]))
    np.testing.assert_allclose(got.output, [[0.025, -0.025, 0.25]], rtol=1e-15)
    assert got.readings is None


def test_pulses_of_a_gate() -> None:
    """17 ug for 100 s at 10.21 counts/s/ug are 17357 pulses."""
    chain = mesa().chains["low"]
    got = convert(chain, column(17357))
    assert got.output[0, 0] == pytest.approx(173.57)
    assert got.readings is not None
    assert got.readings[0, 0] == pytest.approx(17e-6 * 9.81, rel=1e-12)
    assert to_counts(chain, column(17e-6 * 9.81))[0, 0] == 17357
    assert to_counts(chain, column(-17e-6 * 9.81))[0, 0] == -17357


def test_means_of_codes_are_codes() -> None:
    assert convert(adc(), column(2047.25)).output[0, 0] == pytest.approx(2047.25 * 5 / 4095)


@settings(max_examples=50, deadline=None)
@given(CODES, REFERENCES, st.floats(-30.0, 70.0))
def test_codes_come_back(codes: list[tuple[int, int, int]], reference: int, temperature: float) -> None:
    unit = flight_unit().chains["flight"]
    zero = np.array([[0.01, -0.02, 0.03], [1e-4, 2e-4, -1e-4]])
    chain = Chain(
        unit.axes,
        unit.step,
        unit.codes,
        "rad/s",
        scale_factor=unit.scale_factor,
        reference="channel",
        zero=zero,
        gain=np.array([2.0, -3.0, 1.0]),
        thermometer=unit.thermometer,
    )
    counts = np.array(codes)
    beside = np.full(len(counts), reference)
    warm = to_temperature_counts(chain, np.full((len(counts), 3), temperature), reference=beside)
    got = convert(chain, counts, reference=beside, temperature=warm)
    assert got.readings is not None
    assert got.temperature is not None
    np.testing.assert_allclose(got.temperature, temperature, atol=0.5 * 5.0 / 4095 / 0.0264)
    back = to_counts(chain, got.readings, reference=beside, temperature=got.temperature)
    np.testing.assert_array_equal(back, counts)


def test_nearest_code_and_the_ends() -> None:
    chain = adc(reference=2.5, scale_factor=0.5)
    step = 5.0 / 4095 / 0.5
    near = 1000 * 5.0 / 4095 / 0.5 - 5.0
    assert to_counts(chain, column(near + 0.4 * step, near + 0.6 * step)).ravel().tolist() == [1000, 1001]
    assert to_counts(chain, column(-99.0, 99.0)).ravel().tolist() == [0, 4095]


def test_rails_are_left_out_and_counted() -> None:
    chain = adc(axes=("x", "y"), scale_factor=1.0)
    counts = np.array([[2000, 2000], [4095, 2000], [4095, 0], [2001, 2001]])
    got = convert(chain, counts)
    np.testing.assert_array_equal(got.valid, [[True, True], [False, True], [False, False], [True, True]])
    assert got.readings is not None
    np.testing.assert_array_equal(np.isnan(got.readings), ~got.valid)
    by_axis = [(one.code, one.count, one.where, one.what[:1]) for one in got.remarks]
    assert by_axis == [("rail", 2, "sample 1", "x"), ("rail", 1, "sample 2", "y")]


def test_rail_of_the_reference_counts_too() -> None:
    got = convert(adc(reference="channel"), column(2000, 2000), reference=column(2048, 4095))
    assert got.valid.ravel().tolist() == [True, False]
    assert "reference of x" in got.remarks[0].what


def test_rail_of_the_temperature_channel_empties_the_temperature_alone() -> None:
    chain = adc(thermometer=Thermometer(0.03, 0.0, 25.0))
    got = convert(chain, column(2000, 2000), temperature=column(10, 0))
    assert got.temperature is not None
    assert np.isnan(got.temperature).ravel().tolist() == [False, True]
    assert got.valid.all()


def test_missing_codes_are_left_out_and_counted() -> None:
    got = convert(adc(), column(2000, np.nan, 2000))
    assert got.valid.ravel().tolist() == [True, False, True]
    assert (got.remarks[0].code, got.remarks[0].count) == ("missing", 1)


def test_low_built_in_test_is_left_out_and_counted() -> None:
    """2.4 V is code 1965.6: 1966 is good, 1965 is not; a rail of this channel is good."""
    chain = adc(axes=("x", "y"), validity_minimum=2.4)
    counts = np.full((4, 2), 2000)
    got = convert(chain, counts, validity=np.array([4095, 1966, 1965, np.nan]))
    np.testing.assert_array_equal(got.valid, np.array([[True, True, False, False]] * 2).T)
    assert [(one.code, one.count) for one in got.remarks] == [("test_low", 2), ("test_low", 2)]


def test_built_in_test_per_axis() -> None:
    chain = adc(axes=("x", "y"), validity_minimum=2.4)
    got = convert(chain, np.full((2, 2), 2000), validity=np.array([[3000, 3000], [3000, 10]]))
    np.testing.assert_array_equal(got.valid, [[True, True], [True, False]])


def test_run_at_a_rail_is_a_rail() -> None:
    codes = np.random.default_rng(4).integers(1900, 2100, (500, 1)).astype(float)
    codes[100:160] = 4095
    assert [one.code for one in convert(adc(), codes).remarks] == ["rail"]


@pytest.mark.parametrize("code", [-1, 4096, np.inf])
def test_code_outside_is_refused(code: float) -> None:
    with pytest.raises(DataError, match=r"x: code .* is outside the converter \(0 to 4095\), and 1 more") as caught:
        convert(adc(), column(2000, code, code), place=lambda i: f"rt_x.csv:{i + 2}")
    assert caught.value.problems[0].code == "code_outside"
    assert caught.value.problems[0].where == "rt_x.csv:3"


def test_code_outside_beside_the_signal_is_refused() -> None:
    with pytest.raises(DataError, match="reference of x: code 5000"):
        convert(adc(reference="channel"), column(2000), reference=column(5000))


@pytest.mark.parametrize(
    ("fields", "code"),
    [
        ({"reference": "channel"}, "missing_reference"),
        ({"zero": np.array([[0.0], [1.0]])}, "missing_temperature"),
        ({"validity_minimum": 2.4}, "missing_validity"),
    ],
)
def test_missing_channel_is_refused(fields: dict[str, object], code: str) -> None:
    with pytest.raises(DataError, match=f"no {code.removeprefix('missing_')} channel for x") as caught:
        convert(adc(**fields), column(2000))
    assert caught.value.problems[0].code == code


def test_missing_channel_is_refused_on_the_way_back() -> None:
    with pytest.raises(DataError, match="no reference channel"):
        to_counts(adc(reference="channel"), column(0.0))
    with pytest.raises(DataError, match="no temperature channel"):
        to_counts(adc(zero=np.array([[0.0], [1.0]])), column(0.0))
    with pytest.raises(DataError, match="no thermometer"):
        to_temperature_counts(adc(), column(20.0))


def test_built_in_test_low_throughout_is_refused() -> None:
    with pytest.raises(DataError, match=r"x: the built-in test is below 2.4 V throughout") as caught:
        convert(adc(validity_minimum=2.4), column(2000, 2000), validity=column(100, 200))
    assert caught.value.problems[0].code == "never_valid"


def test_built_in_test_without_its_limit_is_refused() -> None:
    with pytest.raises(PlanError, match="no validity_minimum"):
        convert(adc(), column(2000), validity=column(3000))


def test_wrong_shape_is_refused() -> None:
    with pytest.raises(DataError, match=r"counts: shape \(2, 2\), need \(n, 1\)"):
        convert(adc(), np.zeros((2, 2)))
    with pytest.raises(DataError, match=r"reference: shape \(3,\), need \(2, 1\)"):
        convert(adc(reference="channel"), column(1, 1), reference=np.ones(3))


def test_gain_of_zero_is_refused() -> None:
    with pytest.raises(PlanError, match=r"gain .* other than 0"):
        convert(adc(), column(1, 1), gain=np.array([1.0, 0.0]))


@pytest.mark.parametrize(
    ("fields", "text"),
    [
        ({"step": 0.0}, "step 0: need a positive number"),
        ({"codes": (5, 5)}, "the first must be the smaller"),
        ({"gain": 0.0}, "gain 0.0: need finite numbers other than 0"),
        ({"scale_factor": np.array([1.0, 2.0])}, "scale_factor .* one for all or one of 1"),
        ({"zero": np.zeros(2)}, r"zero: shape \(2,\)"),
    ],
)
def test_impossible_chain_is_refused(fields: dict[str, object], text: str) -> None:
    with pytest.raises(PlanError, match=text):
        adc(**fields)


def test_impossible_parts_are_refused() -> None:
    with pytest.raises(PlanError, match="thermometer slope"):
        Thermometer(0.0, 0.0, 25.0)
    with pytest.raises(PlanError, match="gate 0 s"):
        pulse_counter(("x",), 0.0)


def test_no_readings() -> None:
    got = convert(adc(validity_minimum=2.4), np.empty((0, 1)), validity=np.empty(0))
    assert got.output.shape == (0, 1)
    assert got.remarks == ()


def test_the_zero_of_the_electronics_is_that_of_the_gain_at_the_time() -> None:
    chain = Chain(
        ("x",), 1e-3, unit="V", scale_factor=1.0, zero=0.5, zero_at={1.0: np.array([0.1]), 10.0: np.array([0.2])}
    )
    gain = np.array([1.0, 10.0])
    codes = to_counts(chain, np.array([[0.3], [0.3]]), gain=gain)
    assert codes.ravel().tolist() == [400, 3200]
    assert convert(chain, codes, gain=gain).readings == pytest.approx(np.array([[0.3], [0.3]]))
    assert convert(chain, codes).readings == pytest.approx(np.array([[-0.1], [2.7]]))
    with pytest.raises(DataError, match="no zero of the electronics of x at gain 100"):
        convert(chain, codes, gain=np.array([1.0, 100.0]))

"""Compensation that starts from counts or volts by the chain of the model, against the chain worked out by hand."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from inertialcal.campaign.models.compensation import compensate
from inertialcal.core.errors import DataError
from inertialcal.core.recording import Channel, Recording, Source
from inertialcal.core.units import factor
from inertialcal.sensors.chain.converter import Chain, Thermometer
from inertialcal.sensors.model.sensor_model import SensorModel
from inertialcal.sensors.model.serial import from_dict, to_dict

DEG = factor("deg/s", "rad/s")
LSB, S0, GAIN = 5.0 / 4095, 0.5, 2.0  # V; V/(deg/s)
BIAS, SLOPE = np.array([0.02, -0.01]), np.array([1e-3, -2e-3])  # deg/s, deg/s/degC
MATRIX = np.array([[1.01, 0.002], [-0.003, 0.98]])
CODES = {
    "x": [2412, 1897, 2000],
    "y": [2100, 2050, 1900],
    "reference": [2047, 2049, 2046],
    "temperature": [1702, 1695, 1688],
}


def model(**chain: Any) -> SensorModel:
    """Two gyros behind a 12-bit converter with a measured reference and a temperature channel."""
    made = Chain(
        ("x", "y"), LSB, (0, 4095), "rad/s", scale_factor=np.full(2, S0 / DEG), reference="channel", gain=GAIN,
        thermometer=Thermometer(0.0264, -0.5, 25.0),
    )  # fmt: skip
    return SensorModel(
        "gyro", ("x", "y"), np.full(2, S0 / DEG), "V", MATRIX, BIAS * DEG, bias_temperature=(SLOPE * DEG)[np.newaxis],
        reference_temperature=np.full(2, 25.0), chain=replace(made, **chain),
    )  # fmt: skip


def by_hand() -> np.ndarray:
    """True rates [deg/s] of the codes."""
    x, y, ref, warm = (np.array(CODES[name], dtype=float) for name in ("x", "y", "reference", "temperature"))
    t = ((warm - ref) * LSB + 0.5) / 0.0264 + 25.0
    read = np.column_stack([(c - ref) * LSB / GAIN / S0 for c in (x, y)])
    return np.linalg.solve(MATRIX, (read - BIAS - np.outer(t - 25.0, SLOPE)).T).T


def recorded(unit: str | None = "count", scale: float = 1.0, names: dict[str, str] | None = None) -> Recording:
    channels = []
    for word, codes in CODES.items():
        data = np.array(codes) if scale == 1.0 else np.array(codes) * scale
        channels.append(Channel((names or {}).get(word, word), data, unit, "header"))
    return Recording(tuple(channels), np.arange(3) * 10**9, source=Source("in.csv"), first_row=2)


def rates(done: Recording) -> np.ndarray:
    assert {done.channel(axis).unit for axis in "xy"} == {"deg/s"}
    return done.array(["x", "y"])


def test_counts_become_true_rates() -> None:
    np.testing.assert_allclose(rates(compensate(model(), recorded())), by_hand(), rtol=1e-12)


def test_volts_at_the_converter_become_the_same_rates() -> None:
    done = compensate(model(), recorded("V", LSB))
    np.testing.assert_allclose(rates(done), by_hand(), rtol=1e-10)
    np.testing.assert_allclose(rates(compensate(model(), recorded("mV", 1e3 * LSB))), by_hand(), rtol=1e-10)


def test_columns_may_be_named() -> None:
    names = {word: f"adc {word}" for word in CODES}
    done = compensate(model(), recorded(names=names), names)
    np.testing.assert_allclose(rates(done), by_hand(), rtol=1e-12)


def test_a_temperature_that_is_in_degrees_already() -> None:
    ref, warm = (np.array(CODES[name], dtype=float) for name in ("reference", "temperature"))
    degrees = Channel("warm", ((warm - ref) * LSB + 0.5) / 0.0264 + 25.0, "degC", "header", "", "temperature")
    counts = without(recorded(), "temperature")
    mixed = replace(counts, channels=(*counts.channels, degrees))
    np.testing.assert_allclose(rates(compensate(model(), mixed, temperature="warm")), by_hand(), rtol=1e-12)


def without(recording: Recording, name: str) -> Recording:
    return replace(recording, channels=tuple(one for one in recording.channels if one.name != name))


def test_counts_without_a_unit_are_taken_for_counts_and_it_is_said() -> None:
    done = compensate(model(), recorded(None))
    np.testing.assert_allclose(rates(done), by_hand(), rtol=1e-12)
    (said,) = [one for one in done.remarks if one.code == "taken_for_counts"]
    assert said.count == 2
    compensate(model(), recorded(None, 1.0 + 1e-9))  # means, beside the reference that is subtracted
    with pytest.raises(DataError) as caught:  # rates of which nobody said the unit
        compensate(model(), without(recorded(None, 0.01), "reference"))
    assert caught.value.problems[0].code in {"wrong_column", "no_unit"}


def test_the_reference_that_the_chain_subtracts_is_not_forgotten() -> None:
    bare = without(recorded("V", LSB), "reference")
    with pytest.raises(DataError) as caught:
        compensate(model(), bare)
    assert caught.value.problems[0].code == "missing_reference"
    fixed = compensate(model(reference=2047 * LSB), bare, temperature="25 degC")
    read = np.array([(np.array(CODES[axis]) - 2047) * LSB / GAIN / S0 for axis in "xy"]).T
    np.testing.assert_allclose(
        rates(fixed)[:, 0], np.linalg.solve(MATRIX, (read - BIAS).T)[0], atol=0.2
    )  # temperature of the channel, not of 25 degC


def test_readings_in_units_pass_by_the_chain() -> None:
    x = Channel("gyro_x", np.array([1.0, 2.0]), "deg/s", "header", "x", "gyro")
    y = Channel("gyro_y", np.array([0.0, 1.0]), "deg/s", "header", "y", "gyro")
    made = Recording((x, y), np.arange(2) * 10**9, source=Source("in.csv"), first_row=2)
    done = compensate(model(), made, temperature="25 degC")
    expected = np.linalg.solve(MATRIX, (np.array([[1.0, 0.0], [2.0, 1.0]]) - BIAS).T).T
    np.testing.assert_allclose(done.array(["gyro_x", "gyro_y"]), expected, rtol=1e-12)


@given(st.sampled_from(["channel", 0.0, 2.5]), st.one_of(st.none(), st.just((-32768, 32767))), st.booleans())
def test_the_chain_survives_the_model_file(reference: Any, codes: Any, warm: bool) -> None:
    change = {} if warm else {"thermometer": None}
    one = model(reference=reference, codes=codes, gain=np.array([1.0, 10.0]), zero=np.array([[0.1, 0.2], [1e-3, 0.0]]),
                validity_minimum=2.4, **change)  # fmt: skip
    content = to_dict(one)
    again = from_dict(content).only()
    assert to_dict(again) == content
    assert again.chain is not None
    assert (again.chain.reference, again.chain.codes, again.chain.validity_minimum) == (reference, codes, 2.4)


def test_a_chain_of_another_scale_is_refused() -> None:
    with pytest.raises(DataError) as caught:
        model(scale_factor=np.full(2, 0.4 / DEG))
    assert caught.value.problems[0].code == "wrong_chain"
    with pytest.raises(DataError) as caught:
        model(axes=("x", "z"))
    assert caught.value.problems[0].code == "wrong_chain"

"""Compensation that starts from counts or volts by the chain of the model, against the chain worked out by hand."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from inertialcal.campaign.models.compensation import compensate
from inertialcal.core.errors import DataError, InertialcalError
from inertialcal.core.recording import Channel, Recording, Source
from inertialcal.core.units import factor
from inertialcal.files import read
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


@pytest.mark.parametrize("word", ["reference", "temperature", "x"])
def test_volts_beside_counts_are_refused(word: str) -> None:
    """Neither may be taken for the other: a code of 2047 is no 2047 V."""
    volts, counts = recorded("V", LSB), recorded()
    for one, other in ((volts, counts), (counts, volts)):
        mixed = replace(without(one, word), channels=(*without(one, word).channels, other.channel(word)))
        with pytest.raises(DataError) as caught:
            compensate(model(), mixed)
        assert caught.value.problems[0].code in {"wrong_unit", "wrong_column"}
    unsaid = replace(volts.channel(word), unit=None)
    with pytest.raises(DataError):
        compensate(model(), replace(volts, channels=(*without(volts, word).channels, unsaid)))


@pytest.mark.parametrize(("unit", "scale"), [("V", 1.0), ("mV", 1e3)])
def test_a_built_in_test_in_volts_is_looked_at(unit: str, scale: float, tmp_path: Path) -> None:
    """From a file, whose header names a status: its unit is kept."""
    columns = {word: np.array(codes) * LSB for word, codes in CODES.items()} | {
        "validity": np.array([3.0, 2.3988, 3.0])
    }
    head = ",".join(["time [s]", *(f"{word} [V]" for word in CODES), f"validity [{unit}]"])
    columns["validity"] = columns["validity"] * scale
    table = np.column_stack([np.arange(3) * 0.1, *columns.values()])
    np.savetxt(tmp_path / "in.csv", table, "%.17g", ",", header=head, comments="")
    done = compensate(model(validity_minimum=2.4), read(tmp_path / "in.csv"))
    assert np.isnan(rates(done)).any(axis=1).tolist() == [False, True, False]
    np.testing.assert_allclose(rates(done)[[0, 2]], by_hand()[[0, 2]], rtol=1e-9)


def test_counts_for_a_model_without_a_chain_and_counts_of_one_axis() -> None:
    with pytest.raises(DataError) as caught:
        compensate(replace(model(), chain=None), recorded())
    assert caught.value.problems[0].code == "no_chain"
    with pytest.raises(DataError, match="y: none"):
        compensate(model(), without(recorded(), "y"))


def test_a_reference_of_the_temperature_alone_is_not_forgotten() -> None:
    """Where the signal has a fixed one: the model says that it was there, and asks for it."""
    own = replace(model().chain.thermometer, own_reference=True)  # type: ignore[union-attr, type-var]
    one = model(reference=2047 * LSB, thermometer=own)
    assert from_dict(to_dict(one)).only().chain.thermometer.own_reference  # type: ignore[union-attr]
    bare = without(recorded(), "reference")
    with pytest.raises(DataError) as caught:
        compensate(one, bare)
    assert caught.value.problems[0].code == "missing_temperature_reference"
    whole = replace(
        bare, channels=(*bare.channels, replace(recorded().channel("reference"), name="temperature_reference"))
    )
    ref, warm = (np.array(CODES[name], dtype=float) for name in ("reference", "temperature"))
    t = ((warm - ref) * LSB + 0.5) / 0.0264 + 25.0
    done = np.column_stack([(np.array(CODES[axis]) - 2047) * LSB / GAIN / S0 for axis in "xy"])
    expected = np.linalg.solve(MATRIX, (done - BIAS - np.outer(t - 25.0, SLOPE)).T).T
    np.testing.assert_allclose(rates(compensate(one, whole)), expected, rtol=1e-9)


def test_a_thermometer_of_another_number_of_sensors_is_refused() -> None:
    content = to_dict(model())
    (held,) = content["models"].values()
    held["chain"]["thermometer"]["slope"] = [0.02, 0.02, 0.02]
    with pytest.raises(InertialcalError, match="thermometer slope"):
        from_dict(content)


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

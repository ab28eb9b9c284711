"""Counts to compensated rates of the flight unit, step by step in plain arithmetic.

The same example stands in the manual. Every step below uses printed figures only (Badescu, NPS thesis, 2011,
Tables 2 and 15, equations (4) to (12) with the errata mended); nothing of the package takes part in it.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from inertialcal.core.recording import Channel, Recording
from inertialcal.sensors.catalogue import flight_unit
from inertialcal.sensors.chain.conversion import convert
from inertialcal.sensors.model.compensate import compensate
from inertialcal.sensors.model.on_recordings import apply_chain, compensate_recording

TOLERANCE = 1e-7  # [deg/s]

SIGNAL = {"x": 2412, "y": 1897, "z": 2190}
REFERENCE = {"x": 2047, "y": 2049, "z": 2046}
TEMPERATURE = {"x": 1702, "y": 1695, "z": 1688}
BUILT_IN_TEST = {"x": 3276, "y": 3270, "z": 3281}


def step_by_step() -> tuple[dict[str, float], dict[str, float]]:
    """Temperatures [degC] and compensated rates [deg/s], by hand."""
    volt_a_count = 5.0 / 4095.0
    # Volts above the reference, of the rate and of the temperature channel.
    rate_volts = {a: (SIGNAL[a] - REFERENCE[a]) * volt_a_count for a in "xyz"}
    temperature_volts = {a: (TEMPERATURE[a] - REFERENCE[a]) * volt_a_count for a in "xyz"}
    # Temperatures, equations (9) to (12).
    t_x = (temperature_volts["x"] + 0.5042) / 0.0264 + 25.7
    t_y = (temperature_volts["y"] + 0.4909) / 0.0264 + 25.4
    t_z = (temperature_volts["z"] + 0.5071) / 0.0264 + 25.3
    # Indicated rates: volts over 0.5 V/(deg/s).
    i_x, i_y, i_z = (rate_volts[a] / 0.5 for a in "xyz")
    # In-run bias: the cubic gives volts over temperature volts; divided by 0.5 V/(deg/s). Then the constant bias.
    v = temperature_volts
    b_x = (-0.00809 - 0.05675 * v["x"] - 0.0107 * v["x"] ** 2 - 0.00503 * v["x"] ** 3) / 0.5 + 0.00718
    b_y = (0.0038 - 0.01519 * v["y"] - 0.0037 * v["y"] ** 2 - 0.00402 * v["y"] ** 3) / 0.5 - 0.00812
    b_z = (0.03219 - 0.01581 * v["z"] - 0.01039 * v["z"] ** 2 - 0.00796 * v["z"] ** 3) / 0.5 + 0.00700
    # What is left is M w; Cramer's rule.
    m = [[0.99958, -0.00156, -0.00200], [0.00102, 1.00400, -0.00139], [0.01298, 0.00128, 0.99494]]
    left = [i_x - b_x, i_y - b_y, i_z - b_z]
    whole = determinant(m)
    rates = {}
    for column, axis in enumerate("xyz"):
        replaced = [[left[r] if c == column else m[r][c] for c in range(3)] for r in range(3)]
        rates[axis] = determinant(replaced) / whole
    return {"x": t_x, "y": t_y, "z": t_z}, rates


def determinant(m: list[list[float]]) -> float:
    (a, b, c), (d, e, f), (g, h, i) = m
    return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)


def codes(of: dict[str, int]) -> list[list[int]]:
    return [[of[a] for a in "xyz"]]


def test_counts_to_rates_equal_the_calculation_by_hand() -> None:
    temperatures, rates = step_by_step()
    unit = flight_unit()
    converted = convert(
        unit.chains["flight"],
        codes(SIGNAL),
        reference=codes(REFERENCE),
        temperature=codes(TEMPERATURE),
        validity=codes(BUILT_IN_TEST),
    )
    assert converted.readings is not None
    assert converted.temperature is not None
    assert converted.valid.all()
    x = compensate(unit.models["corrected"], converted.readings, temperature=converted.temperature)
    for i, axis in enumerate("xyz"):
        assert converted.temperature[0, i] == pytest.approx(temperatures[axis], abs=1e-9)
        assert math.degrees(x[0, i]) == pytest.approx(rates[axis], abs=TOLERANCE)


def test_recording_gives_the_same_and_keeps_what_it_does_not_use() -> None:
    _, rates = step_by_step()
    kinds = {"": SIGNAL, "reference_": REFERENCE, "temperature_": TEMPERATURE, "validity_": BUILT_IN_TEST}
    columns = {f"{kind}{a}": f"{kind}{a}_raw" for kind in kinds for a in "xyz"}
    channels = [Channel(f"{kind}{a}_raw", np.array([of[a]]), "count") for kind, of in kinds.items() for a in "xyz"]
    raw = Recording((*channels, Channel("acs_id", np.array([17]))), np.array([2_000_000_000]), 2.0, 1.0)
    unit = flight_unit()
    read = apply_chain(unit.chains["flight"], raw, columns)
    names = {a: a for a in "xyz"} | {f"temperature_{a}": f"temperature_{a}" for a in "xyz"}
    done = compensate_recording(unit.models["corrected"], read, names)
    assert done.names == ("x", "y", "z", "temperature_x", "temperature_y", "temperature_z", "acs_id")
    assert done.time_ns is raw.time_ns
    assert (done.sample_interval, done.averaging_time) == (2.0, 1.0)
    for axis in "xyz":
        assert math.degrees(done.channel(axis).data[0]) == pytest.approx(rates[axis], abs=TOLERANCE)


def test_example_is_not_trivial() -> None:
    """Every step matters at the tolerance: the compensated rates differ from the indicated ones by far more."""
    _, rates = step_by_step()
    for axis in "xyz":
        indicated = (SIGNAL[axis] - REFERENCE[axis]) * 5.0 / 4095.0 / 0.5
        assert abs(indicated - rates[axis]) > 1e4 * TOLERANCE

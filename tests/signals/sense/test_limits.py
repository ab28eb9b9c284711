"""Limits of what sensors can read: each kind of unit, stated ranges, archive records."""

from typing import Any

import numpy as np
import pytest

from inertialcal.core.units import convert, kind
from inertialcal.signals.sense.limits import HEAD_RMS, LIMITS, Impossible, impossible, limits_table


def judged(values: object, unit: str | None, **more: Any) -> Impossible:
    return impossible(np.asarray(values), unit, "t", lambda index: f"file.csv:{index + 2}", **more)


@pytest.mark.parametrize("known", LIMITS.values(), ids=LIMITS)
def test_each_kind_has_both_ends(known: Any) -> None:
    assert kind(known.unit) == known.kind
    inside = np.linspace(known.low, known.high, 50)
    assert not judged(inside, known.unit).flags.any()
    for beyond in (known.low - 1.0, 1.01 * known.high):
        values = inside.copy()
        values[20] = beyond
        found = judged(values, known.unit)
        assert np.flatnonzero(found.flags).tolist() == [20]
        (remark,) = found.remarks
        assert (remark.code, remark.where, remark.severity) == (f"impossible_{known.kind}", "file.csv:22", "warning")


@pytest.mark.parametrize("wrong", [-400.0, 50_000.0])
def test_temperature_in_some_samples_and_throughout(wrong: float) -> None:
    values = np.full(200, 21.0)
    values[[17, 18]] = wrong
    (remark,) = judged(values, "degC").remarks
    assert (remark.code, remark.count, remark.where) == ("impossible_temperature", 2, "file.csv:19")
    assert f"{wrong:g} degC" in remark.what
    (remark,) = judged(np.full(200, wrong), "degC").remarks
    assert (remark.severity, remark.count) == ("error", 200)


@pytest.mark.parametrize(
    ("values", "cause"),
    [
        (np.linspace(290.0, 310.0, 50), "kelvin"),
        (np.linspace(20_000.5, 30_000.0, 50), "thousandths"),
        (np.full(50, -9999.0), "missing value"),
        (np.arange(200_000, 200_050), "raw codes"),
    ],
)
def test_likely_cause(values: Any, cause: str) -> None:
    (remark,) = judged(values, "degC").remarks
    assert cause in remark.what
    assert remark.severity == "error"


def test_limits_are_those_of_the_unit() -> None:
    assert not judged(np.array([77.0, 293.0]), "K").flags.any()
    assert judged(np.array([-1.0, 293.0]), "K").flags.tolist() == [True, False]
    assert not judged(np.array([1e6]), None).flags.any()
    assert not judged(np.array([1e6]), "count").flags.any()


def test_missing_samples_are_possible() -> None:
    assert not judged(np.array([np.nan, 20.0]), "degC").flags.any()


def test_beyond_the_stated_range() -> None:
    ends = (-0.1, 0.1)
    assert not judged(np.array([0.19, -0.19]), "rad/s", input_range=ends).remarks
    found = judged(np.array([0.05, 5.7, 0.05]), "rad/s", input_range=ends, shown="deg/s")
    assert found.flags.tolist() == [False, True, False]
    (remark,) = found.remarks
    assert remark.code == "beyond_range"
    assert "deg/s" in remark.what


@pytest.mark.parametrize(
    ("scale", "codes"), [(1.0, []), (1e3, ["implausible_acceleration"]), (1e6, ["impossible_acceleration"])]
)
def test_archive_data_that_are_scaled(scale: float, codes: Any) -> None:
    values = scale * 1.2e-5 * np.random.default_rng(1).standard_normal(2000)
    assert [one.code for one in judged(values.astype(np.float32), "g", archived=True).remarks] == codes
    assert not judged(values, "g").remarks  # any other record may read so much


def test_limit_of_the_station_is_a_root_sum_square() -> None:
    """SSP 41000: 18 ug a Hz in each third of an octave up to 100 Hz, 1.8 mg above, to 300 Hz."""
    bands = 10.0 ** (np.arange(-20, 26) / 10.0)
    bands = bands[bands < 320.0]
    total = np.sqrt(np.sum(np.minimum(18e-6 * bands, 1.8e-3) ** 2))
    assert float(convert(HEAD_RMS, "m/s^2", "g")) == pytest.approx(total, rel=0.1)


def test_table_of_the_manual_has_every_limit() -> None:
    assert len(limits_table()) == len(LIMITS)
    assert ("temperature", "-273.15 degC", "250 degC") in [row[:3] for row in limits_table()]

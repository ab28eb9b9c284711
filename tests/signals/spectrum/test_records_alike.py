"""Deviations, spectra and lines of many records side by side: those of each by itself, to the last bit."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from inertialcal.core.errors import DataError, PlanError
from inertialcal.core.estimate import Array
from inertialcal.signals.allan import allan, allan_alike
from inertialcal.signals.names import Method
from inertialcal.signals.spectrum.allan_check import compare_allan
from inertialcal.signals.spectrum.lines import find_lines, lines_apart
from inertialcal.signals.spectrum.psd import psd, psd_alike

N, INTERVAL, UNIT = 5_000, 0.01, "rad/s"


def records() -> list[Array]:
    rng, t = np.random.default_rng(3), np.arange(N)
    found = [rng.normal(size=N) + walk * np.cumsum(rng.normal(size=N)) for walk in (0.0, 1e-3, 0.1, 1.0)]
    return [*found, found[0] + 0.5 * np.sin(0.7 * t), np.diff(found[0], prepend=0.0), 1e6 + found[0]]


def assert_same(found: object, own: object) -> None:
    assert type(found) is type(own)
    for name, value in vars(own).items():
        assert (
            np.array_equal(getattr(found, name), value, equal_nan=True)
            if isinstance(value, np.ndarray)
            else (getattr(found, name) == value)
        ), name


@pytest.mark.parametrize("averaging", [None, 0.004])
def test_deviations(averaging: float | None) -> None:
    series = [*records(), np.full(N, 2.0), np.where(np.arange(N) == 7, np.nan, records()[0])]
    names = [str(i) for i in range(len(series))]
    found, taken = allan_alike(series, INTERVAL, averaging=averaging, p=0.95, names=names, unit=UNIT)
    assert found is not None
    assert taken == [0, 1, 2, 3, 4, 5, 6]  # neither the constant one nor that with a gap
    for i, one in zip(taken, found.apart(), strict=True):
        own = allan(series[i], INTERVAL, quantity="rate", averaging=averaging, p=0.95, names=(names[i],), unit=UNIT)
        assert_same(one, own)
        assert one.remarks == own.remarks
        assert (one.remarks == ()) is (averaging is None)


@pytest.mark.parametrize("series", [[np.ones(N)], [np.arange(100.0)], [np.full(N, np.nan)]])
def test_records_that_are_not_taken(series: Sequence[Array]) -> None:
    assert allan_alike(series, INTERVAL, names=["x"]) == (None, [])


def test_refusals() -> None:
    with pytest.raises(DataError, match="averaging time"):
        allan_alike(records(), INTERVAL, averaging=1.0, names="abcdefg")
    with pytest.raises(PlanError, match="segments of 3 samples"):
        psd_alike(records(), INTERVAL, segment=3)
    with pytest.raises(DataError, match="sample interval"):
        psd_alike(records(), 0.0)
    with pytest.raises(PlanError, match="false_alarm"):
        lines_apart(psd(records()[0], INTERVAL), 1.0)


@pytest.mark.parametrize(("method", "segment"), [("welch", None), ("multitaper", None), ("welch", 300), ("welch", 40)])
def test_spectra(method: Method, segment: int | None) -> None:
    series = [*records(), np.full(N, 2.0)]
    found = psd_alike(series, INTERVAL, method, segment=segment)
    assert [one.what for one in found.remarks] == ["axis 7 is constant: no spectrum"]
    curve, _ = allan_alike(series[:-1], INTERVAL, names="abcdefg")
    assert curve is not None
    for x, one, lines in zip(series, found.apart(), lines_apart(found), strict=True):
        own = psd(x, INTERVAL, method, segment=segment)
        assert np.array_equal(one.density, own.density)
        assert np.array_equal(one.frequency, own.frequency)
        assert_same(lines, find_lines(own))
    assert len(find_lines(found)) == sum(len(one) for one in lines_apart(found))
    agreements = compare_allan(psd_alike(series[:-1], INTERVAL), curve).apart()
    for agreement, deviation, x in zip(agreements, curve.apart(), series[:-1], strict=True):
        assert_same(agreement, compare_allan(psd(x, INTERVAL), deviation))

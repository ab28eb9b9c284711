"""Records over temperature give the same cells, lag, start-up and cubic whatever the size of a batch."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from thermal_sweeps import plan

from inertialcal.core import batches as b
from inertialcal.core.recording import Channel, Recording
from inertialcal.procedures.thermal.fit.cells import cells_of, lagging, series_of
from inertialcal.procedures.thermal.fit.law import Law, law_of
from inertialcal.procedures.thermal.fit.start_up import start_up_of
from inertialcal.procedures.thermal.recordings import Readings, ThermalRecording, readings_from
from inertialcal.procedures.thermal.reduction import reduce
from inertialcal.procedures.thermal.rows import published_fit
from inertialcal.procedures.thermal.thermometer import thermometer_rows

ROUNDING = 1e-12


def kept(x: NDArray[Any], stored: bool) -> NDArray[Any]:
    out = b.empty(len(x), x.dtype, stored)
    out[:] = x
    return out


def made(seed: int, stored: bool) -> Readings:
    """Return up to three recordings of two power-ups with some of the faults that there are."""
    rng = np.random.default_rng(seed)
    without_time, disordered, found = rng.random() < 0.2, rng.random() < 0.3, []
    for number in range(int(rng.integers(1, 4))):
        n = int(rng.integers(600, 1500))
        stay = n // int(rng.integers(4, 20))
        nodes, levels = [0, stay, (n + stay) // 2, n], [20.0, 20.0, rng.uniform(40.0, 60.0), rng.uniform(-20.0, 20.0)]
        T = np.interp(np.arange(n), nodes, levels) + rng.normal(0.0, 0.02, n)
        y = 1e-3 * T + 1e-5 * T**2 + 0.02 * np.exp(-np.arange(n) / (stay / 3)) + rng.normal(0.0, 1e-3, n)
        y[rng.random(n) < rng.choice([0.0, 0.01])] = np.nan
        T[rng.random(n) < rng.choice([0.0, 0.01])] = np.nan
        time = (5_000_000_000 * (np.arange(n) + 2000 * number)).astype(np.int64)
        if disordered:
            time[n // 3 : n // 3 + 9] = time[n // 3 : n // 3 + 9][::-1]
        data = {"x": y, "temperature": T, "reference_temperature": T + 0.1 + 1e-3 * T}
        channels = tuple(Channel(name, kept(x, stored), "rad/s" if name == "x" else "degC") for name, x in data.items())
        recording = Recording(channels, None if without_time else kept(time, stored), epoch="utc")
        found.append(ThermalRecording(recording, f"run {min(number, 1)}", f"record {number}"))
    return readings_from(found)


def worked_out(seed: int, stored: bool, law: Law | None = None) -> tuple[Law, list[Any]]:
    """Return what is made of the samples of a sensor in one pass after the other; the law is not to be fitted anew."""
    asked, readings = plan(warm_up=None), made(seed, stored)
    series = series_of(asked, readings, "x")
    cells = cells_of(asked, series, 100.0)
    law = law_of(cells, 2) if law is None else law
    start_up = start_up_of(asked, series, cells, lambda: law)  # the means that its fit gets
    behind = lagging(asked, series, cells, 200.0, 100.0)
    cubic = published_fit(asked, series, 50.0)
    assert cubic is not None
    assert cubic.polynomial.covariance is not None
    known = list(thermometer_rows(asked, readings, "x"))
    return law, [
        *(getattr(one, field.name) for one in (cells, behind) for field in fields(one) if field.name != "once"),
        start_up.time, start_up.residual, start_up.run,
        cubic.polynomial.coefficients, cubic.polynomial.covariance, cubic.polynomial.dof, cubic.samples,
        cubic.residual_sum_of_squares, cubic.adjusted_r_square,
        *([np.nan if row.value is None else row.value for row in known]),
    ]  # fmt: skip


@settings(max_examples=12, deadline=None)
@given(seed=st.integers(0, 10**6), size=st.integers(1, 2000), stored=st.booleans())
@example(seed=1337, size=1, stored=False)  # two blocks of one mean time, since a stretch runs backwards
def test_what_is_made_of_the_samples_does_not_hang_on_the_size_of_a_batch(seed: int, size: int, stored: bool) -> None:
    law, whole = worked_out(seed, stored=False)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(b, "SIZE", max(size, 30))
        patch.setattr(b, "HELD", 0 if stored else b.HELD)
        _, found = worked_out(seed, stored, law)
    for one, other in zip(found, whole, strict=True):
        if isinstance(other, dict):
            assert one == other
        elif other is not None:
            scale = np.max(np.abs(np.nan_to_num(np.asarray(other, dtype=float))), initial=0.0)
            np.testing.assert_allclose(one, other, rtol=ROUNDING, atol=ROUNDING * scale)


@pytest.mark.parametrize("fault", ["none", "missing readings", "missing temperature", "a sensor in one recording"])
def test_sensors_that_share_a_thermometer_are_what_each_is_alone(fault: str) -> None:
    rng, swept = np.random.default_rng(5), []
    for number in range(3):
        n = 900
        T = 25.0 + 30.0 * np.sin(np.linspace(0.0, 4.0 * np.pi, n) + number)
        late = T - (20.0 + 10.0 * number) * np.gradient(T, 5.0)
        if fault == "missing temperature":
            T[rng.random(n) < 0.05] = np.nan
        data = {axis: 1e-3 * k * late + 1e-5 * late**2 + rng.normal(0.0, 1e-3, n) for k, axis in enumerate("xyz", 1)}
        if fault == "missing readings":
            data["y"][rng.random(n) < 0.05] = np.nan
        if fault == "a sensor in one recording" and number:
            del data["z"]
        channels = [Channel(name, x, "rad/s") for name, x in data.items()] + [Channel("temperature", T, "degC")]
        time = (5_000_000_000 * (np.arange(n) + 2000 * number)).astype(np.int64)
        swept.append(ThermalRecording(Recording(tuple(channels), time, epoch="utc"), f"run {number}"))
    together = reduce(plan(), readings_from(swept))
    for axis in "xyz":
        own = [
            replace(one, recording=replace(one.recording, channels=tuple(kept)))
            for one in swept
            if axis in one.recording.names
            for kept in [[c for c in one.recording.channels if c.name in (axis, "temperature")]]
        ]
        alone = [row for row in reduce(plan(), readings_from(own)).rows() if row.axis == axis]
        found = [row for row in together.rows() if row.axis == axis]
        assert [(row.key, row.status) for row in found] == [(row.key, row.status) for row in alone]
        for one, other in zip(found, alone, strict=True):
            for a, c, size in ((one.value, other.value, other.u), (one.u, other.u, None), (one.dof, other.dof, None)):
                assert a == (None if c is None else pytest.approx(c, rel=1e-9, abs=1e-9 * (size or 0.0)))

"""Sensors with a low pass: headline, exports and a stated cut-off."""

from __future__ import annotations

import json

import numpy as np
import pytest
from scipy.signal import lfilter

import inertialcal as ic
from inertialcal.core.recording import Channel, Recording
from inertialcal.core.units import factor
from inertialcal.procedures.static_noise.filters import filter_block
from inertialcal.sensors.noise.fitting.filtered import Search, search
from inertialcal.sensors.noise.simulate import simulate
from inertialcal.sensors.noise.terms import GaussMarkov, RandomWalk
from inertialcal.signals.spectrum.psd import psd

INTERVAL, N = 0.02, 20_000
WALK = 0.24  # deg/sqrt(h)


def record(corner: float | None, cut_off: float | None = None) -> Recording:
    x = WALK * factor("deg/sqrt(h)", "deg/s*sqrt(s)") / np.sqrt(INTERVAL) * np.random.default_rng(5).standard_normal(N)
    if corner is not None:
        kept = np.exp(-2.0 * np.pi * corner * INTERVAL)
        x = lfilter([1.0 - kept], [1.0, -kept], x)
    channel = Channel("gyro_x", x, "deg/s", "header", "x", "gyro")
    return Recording((channel,), sample_interval=INTERVAL, interval_from="header", cut_off=cut_off)


def test_exports_take_the_level_of_the_headline() -> None:
    found = ic.allan(record(5.0))
    row = next(row for row in found.rows if row.quantity == "angle_random_walk")
    assert row.value == pytest.approx(WALK, rel=0.06)
    assert row.interval is not None
    assert row.interval.lo is not None
    assert row.interval.hi is not None
    assert row.interval.lo < WALK < row.interval.hi
    assert row.reason.code == "in_band"
    assert [remark.code for remark in found.remarks if remark.code == "low_pass"]
    assert row.value is not None
    density = row.value * factor("deg/sqrt(h)", "rad/sqrt(s)")
    for target in ("kalibr", "px4", "gtsam", "kf-gins"):
        block = str(filter_block(found, target))
        number = {
            "kalibr": f"{density:.6g}", "px4": f"{density / 0.1:.6g}", "gtsam": f"{density**2:.6g}",
            "kf-gins": f"{row.value:.6g}",
        }[target]  # fmt: skip
        assert number in block, (target, block)
        assert "random_walk: 0" not in block
    assert json.dumps([row.to_dict() for row in found.rows])


def test_a_stated_cut_off_is_compared_with_the_spectrum() -> None:
    found = ic.allan(record(None, cut_off=5.0))
    assert [remark.code for remark in found.remarks if remark.code == "cut_off_disagrees"]
    found = ic.allan(record(5.0), cut_off="12 Hz")
    assert [remark.code for remark in found.remarks if remark.code == "cut_off_disagrees"]
    found = ic.allan(record(5.0), cut_off="5 Hz")
    assert not [remark.code for remark in found.remarks if remark.code == "cut_off_disagrees"]


def test_strong_gauss_markov_noise_is_no_filter() -> None:
    """26 of 30 records of a correlation time of 100 samples were taken for filtered ones, 0 of 20 are."""
    x = simulate((RandomWalk(0.14), GaussMarkov(3.0, 2.0)), 200_000, INTERVAL, np.random.default_rng(4321))
    found = search(psd(x, INTERVAL, "welch"))
    assert found is not None
    assert not Search.together([found])


def test_a_mild_filter_that_no_spectrum_shows_is_part_of_u() -> None:
    plain, mild = (
        next(row for row in ic.allan(record(corner)).rows if row.quantity == "angle_random_walk")
        for corner in (None, 44.0)
    )
    assert plain.interval is not None
    assert mild.interval is not None
    assert plain.u is not None
    assert plain.u / WALK > 0.006  # by the noise alone 0.005
    assert mild.interval.hi is not None
    assert mild.interval.hi > WALK

"""Figures stand with and without the samples that screening left out."""

from __future__ import annotations

import numpy as np
import pytest

import inertialcal as ic
from inertialcal.core.key import Method

RATE, PERIOD, AMPLITUDE = 10.0, 20.0, 1e-3


def driven(glitch: float = 0.0) -> np.ndarray:
    t = np.arange(20_000) / RATE
    x = AMPLITUDE * np.sin(2 * np.pi * t / PERIOD) + np.random.default_rng(1).normal(scale=1e-3, size=len(t))
    x[5005] += glitch
    return x


def noise(found: ic.Reduced, method: Method) -> float | None:
    rows = [row for row in found.rows if row.quantity == "noise_density" and row.method is method]
    return rows[0].value if rows else None


def sine(x: np.ndarray) -> ic.Reduced:
    return ic.sine(x, period=f"{PERIOD} s", sample_rate=RATE, units="m/s^2")


def test_a_clean_record_has_no_such_figures() -> None:
    assert noise(sine(driven()), Method.UNSCREENED) is None


def test_a_glitch_is_left_out_and_figures_with_it_stand_in_a_column() -> None:
    clean, found = sine(driven()), sine(driven(30.0))
    plain, opened = (noise(found, method) for method in (Method.RESULT, Method.UNSCREENED))
    assert plain == pytest.approx(noise(clean, Method.RESULT), rel=2e-3)
    assert plain is not None
    assert opened is not None
    assert opened > 10 * plain
    (out,) = (one for one in found.results["exclusions"] if one["rule"] == "screened")
    assert out["count"] == 1
    assert {"glitch", "unscreened"} <= {one.code for one in found.remarks}

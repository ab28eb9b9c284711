"""Loops of the noise fit in numpy against the compiled ones: equal to the last bit."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from inertialcal.sensors.noise import _kernels as kernels
from inertialcal.sensors.noise import loops


@given(st.integers(0, 2**32 - 1), st.integers(1, 14), st.booleans())
def test_fisher_scoring(seed: int, k: int, warm: bool) -> None:
    rng = np.random.default_rng(seed)
    p = int(rng.integers(1, min(k, 6) + 1))
    D, w = rng.uniform(size=(k, p)) * 10.0 ** rng.uniform(-6.0, 6.0, p), rng.uniform(1.0, 50.0, k)
    s = D @ rng.uniform(size=p) * rng.gamma(w) / w + 1e-9
    held, value, start = int(rng.integers(-1, p)), float(rng.uniform(0.0, 2.0)), rng.uniform(size=p)
    powers = [start.copy(), start.copy()]
    costs = [one.scored(D, s, w, held, value, v, warm) for one, v in zip((kernels, loops), powers, strict=True)]
    assert costs[0] == costs[1]
    np.testing.assert_array_equal(powers[0], powers[1])


@settings(max_examples=40)
@given(st.integers(0, 2**32 - 1), st.integers(1, 12), st.integers(0, 2), st.sampled_from([2.0, 50.0, 3e3]))
def test_covariance_of_variances(seed: int, k: int, exponentials: int, reach: float) -> None:
    rng = np.random.default_rng(seed)
    m = np.exp2(np.arange(float(k)))
    n, raised = 4.0 * 2.0**k - 2.0 * m + 1.0, rng.uniform(1.0, 1.2, k)
    sizes = np.array([rng.uniform(), 1.0, rng.uniform(0.0, 1e-3), rng.choice([0.0, 0.2])])
    decays = np.array([[0.09, 10.0 ** rng.uniform(-3.0, 0.0), 100.0, 1e-3] for _ in range(exponentials)]).reshape(-1, 4)
    out = np.zeros((2, k, k))
    for module, one in zip((kernels, loops), out, strict=True):
        module.fill_covariance(m, n, raised, reach, sizes, 0.1, decays, one)
    np.testing.assert_array_equal(out[0], out[1])


def test_the_kernels_take_over_after_many_calls(monkeypatch: pytest.MonkeyPatch) -> None:

    monkeypatch.setattr(loops, "_calls", itertools.count(loops.FEW - 1))
    assert [loops.loops(), loops.loops()] == [loops, kernels]

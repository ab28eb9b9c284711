"""Deviations summed part by part equal those of the whole record, wherever its parts end."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from inertialcal.signals.allan.deviations import KINDS, variances
from inertialcal.signals.allan.edf import believed_powers, identified_powers
from inertialcal.signals.allan.prefix import phase_of
from inertialcal.signals.allan.streamed import streamed_variances
from inertialcal.signals.allan.taus import factors_of

ROUNDING = 1e-12  # relative


def record(n: int, seed: int, whole: bool) -> np.ndarray:
    rng = np.random.default_rng(seed)
    x = rng.normal(size=n) + 1e-2 * np.cumsum(rng.normal(size=n)) + 5.0
    return np.rint(100.0 * x).astype(np.int32) if whole else x


@settings(deadline=None, max_examples=40)
@given(
    n=st.integers(20, 5000),
    seed=st.integers(0, 2**16),
    whole=st.booleans(),
    name=st.sampled_from(["overlapping", "overlapping_hadamard"]),
    taus=st.sampled_from(["octave", "decade"]),
    block=st.integers(1, 6000),
    near=st.integers(1, 2000),
)
def test_parts_give_the_figures_of_the_whole(
    n: int, seed: int, whole: bool, name: str, taus: str, block: int, near: int
) -> None:
    x, kind = record(n, seed, whole), KINDS[name]
    m, _ = factors_of(kind, n + 1, 0.01, taus)
    block = max(block, n // 50)  # a Python step a block
    found = streamed_variances(x, kind, m, block, near)
    assert found is not None
    phase = phase_of(x, "rate")
    powers, expected = identified_powers(phase, kind, m), variances(phase, kind, m)
    np.testing.assert_allclose(found[0].variance, expected.variance, rtol=ROUNDING)
    np.testing.assert_array_equal(found[0].terms, expected.terms)
    np.testing.assert_array_equal(found[0].ends, expected.ends)
    np.testing.assert_array_equal(believed_powers(found[1], kind), powers)


def test_definition_term_by_term() -> None:
    """Against the sum of the definition itself, over every starting point."""
    x, kind, m = record(400, 3, whole=False), KINDS["overlapping"], np.array([1, 3, 8, 40, 130])
    found = streamed_variances(x, kind, m, block=37, near=8)
    assert found is not None
    for k, size in enumerate(m.tolist()):
        means = np.array([x[j : j + size].mean() for j in range(len(x) - size + 1)])
        d = means[size:] - means[:-size]
        assert found[0].variance[k] == pytest.approx(0.5 * np.mean(d**2), rel=ROUNDING)


def test_missing_samples_are_left_to_the_other_way() -> None:
    x = record(1000, 1, whole=False)
    x[500] = np.nan
    assert streamed_variances(x, KINDS["overlapping"], np.array([1, 2])) is None

"""A long record is looked through in shares, on all cores: what is found does not depend on where they end."""

from __future__ import annotations

import numpy as np
import pytest

from inertialcal.signals import threads
from inertialcal.signals.segmentation.segments import Segmentation, detect

N = 150_000


def found(signal: np.ndarray) -> Segmentation:
    return detect(signal)


@pytest.mark.parametrize("share", [8, 1_000 * 8, 2**16])
@pytest.mark.parametrize("channels", [1, 2])
def test_shares_of_any_length_find_the_same(monkeypatch: pytest.MonkeyPatch, share: int, channels: int) -> None:
    n = 4_000 if share == 8 else N
    rng = np.random.default_rng(3)
    x = np.round(rng.normal(size=(n, channels)), 3)
    x[n // 3 : n // 2] += 8.0
    x[n // 5 : n // 5 + 300] *= 5.0
    x[::997, 0] += 30.0
    whole = found(x)
    monkeypatch.setattr(threads, "SHARE", share)
    monkeypatch.setattr(threads, "LARGE", 1)
    parts = found(x)
    assert len(whole) > 4
    assert whole.start.tolist() == parts.start.tolist()
    assert whole.still.tolist() == parts.still.tolist()
    assert np.array_equal(whole.samples.outlier, parts.samples.outlier)
    assert whole.noise.step.tolist() == parts.noise.step.tolist()
    np.testing.assert_allclose(whole.scatter, parts.scatter, rtol=1e-13)
    np.testing.assert_allclose(whole.noise.scale, parts.noise.scale, rtol=1e-13)
    np.testing.assert_allclose(whole.widening, parts.widening, rtol=1e-13)

"""Loops of short records in numpy against the compiled ones and the sums written out; a first record compiles none."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from inertialcal.signals.allan import _kernels as kernels
from inertialcal.signals.allan import loops

ROUNDING = 1e-12

FIRST = """
import sys
import numpy as np
import inertialcal as ic
from inertialcal.core.show.compiling import compiling
x = np.random.default_rng(1).normal(size=(4_000, 3))
ic.allan(x, sample_rate=100.0, units="deg/s")
print(compiling.names, "numba" in sys.modules)
"""


@given(st.integers(0, 2**32 - 1), st.integers(4, 300), st.sampled_from([2, 3]), st.booleans())
def test_sums_of_squares(seed: int, n: int, order: int, whole: bool) -> None:
    rng = np.random.default_rng(seed)
    x = rng.integers(-9, 9, n) if whole else rng.normal(size=n)
    p = np.concatenate([[0], np.cumsum(x)])
    factors = np.arange(1, n // order + 1, dtype=np.int64)
    for name, strides in (("sum_overlapping", False), ("sum_strides", True)):
        every = []
        for m in factors.tolist():
            starts = np.arange(0, n + 1 - order * m, m if strides else 1)
            weights = (1, -2, 1) if order == 2 else (-1, 3, -3, 1)
            every.append(float(sum(sum(w * p[j + i * m] for i, w in enumerate(weights)) ** 2 for j in starts.tolist())))
        for module in (loops, kernels):
            found = np.empty(len(factors))
            getattr(module, name)(p, factors, order, found)
            np.testing.assert_allclose(found, every, rtol=ROUNDING, atol=ROUNDING)


@given(st.integers(0, 2**32 - 1), st.integers(1, 300), st.booleans())
def test_integrated_signals(seed: int, n: int, whole: bool) -> None:
    rng = np.random.default_rng(seed)
    kind: Any = np.int64 if whole else np.float64
    x = rng.integers(-9, 9, n) if whole else rng.normal(size=n)
    present, level = rng.random(n) > 0.3, kind(1)
    for module in (loops, kernels):
        phase, count = np.empty(n + 1, dtype=kind), np.empty(n + 1, dtype=np.int32)
        module.integrate(x, level, phase)
        np.testing.assert_allclose(np.diff(phase), x - level, atol=ROUNDING * n)
        module.integrate_present(x, present, level, phase, count)
        np.testing.assert_allclose(np.diff(phase), np.where(present, x - level, 0), atol=ROUNDING * n)
        np.testing.assert_array_equal(np.diff(count), present)


def test_the_length_alone_tells_which_loops_run() -> None:
    assert loops.loops_for(loops.SHORT) is loops
    assert loops.loops_for(loops.SHORT + 1) is kernels


@pytest.mark.filterwarnings("ignore")
def test_a_first_short_record_compiles_no_loop(tmp_path: Path) -> None:
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
    done = subprocess.run([sys.executable, "-c", FIRST], capture_output=True, text=True, env=environment, check=False)
    assert done.stdout.strip() == "[] False", done.stdout + done.stderr
    assert not list(tmp_path.rglob("*.nbc"))

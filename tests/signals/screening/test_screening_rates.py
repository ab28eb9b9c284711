"""How often the screening is wrong on good records, and right on bad ones; records come from numpy alone."""

from __future__ import annotations

import glob
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import screening_records as records
from numpy.typing import NDArray

import inertialcal as ic
from inertialcal.signals.screening.resolution import resolution_of
from inertialcal.signals.screening.screen import screen
from inertialcal.signals.spectrum.lines import find_lines
from inertialcal.signals.spectrum.psd import psd

MOST = 9  # false alarms in 900 records (issue 20)
LEAST = 57  # of 60 faults
WITHIN = 3e-3  # of the angle random walk of the record without its glitches, relative


def false_alarms(n: int, seeds: int) -> list[tuple[str, int, tuple[str, ...]]]:
    found = (
        (kind, seed, screen(records.record(kind, seed, n)).codes)
        for kind in records.CLEAN
        for seed in range(1, seeds + 1)
    )
    return [one for one in found if one[2]]


@pytest.mark.parametrize("n", [1000, 5000])
def test_few_false_alarms(n: int) -> None:
    assert len(false_alarms(n, 5)) <= 2  # of 90


@pytest.mark.slow
@pytest.mark.parametrize(("n", "seeds"), [(1000, 50), (10_000, 50), (100_000, 50), (1_000_000, 4)])
def test_false_alarms_of_900_records(n: int, seeds: int) -> None:
    wrong = false_alarms(n, seeds)
    print(f"\n{n} samples: {len(wrong)} false alarms of {seeds * len(records.CLEAN)}: {wrong}")
    assert len(wrong) <= MOST


def named(fault: str, seeds: int) -> int:
    record, code, at_rest = records.FAULTS[fault]
    return sum(code in screen(record(np.random.default_rng([seed, 20])), at_rest) for seed in range(1, seeds + 1))


@pytest.mark.parametrize("fault", records.FAULTS)
def test_faults_are_named(fault: str) -> None:
    assert named(fault, 3) == 3


@pytest.mark.slow
@pytest.mark.parametrize("fault", records.FAULTS)
def test_sixty_faults_are_named(fault: str) -> None:
    found = named(fault, 60)
    print(f"\n{fault}: {found} of 60")
    assert found >= LEAST


# What stays when the samples are left out


def random_walk(x: NDArray[Any], leave_out: NDArray[np.bool_] | None = None) -> float:
    """Return the white noise of a record by ``ic.allan``, which leaves nothing out itself."""
    y = x.astype(np.float64)
    if leave_out is not None:
        y[leave_out] = np.nan
    rows = ic.allan(y, sample_rate=50.0, quantity="rate", disturbed="keep").rows
    return next(float(row.value) for row in rows if row.key.quantity == "random_walk" and row.value is not None)


def glitched(x: NDArray[Any], rng: np.random.Generator) -> NDArray[Any]:
    y = x.copy()
    y[rng.integers(len(y))] = -32768
    return y


@pytest.fixture(scope="module")
def l3g(shared: Path) -> NDArray[np.int32]:
    """The real gyro, 238,256 samples in counts."""
    return np.rint(np.loadtxt(shared / "data/noise/l3g_gyro_x/gyro2_x.txt").ravel() / 0.00875).astype(np.int32)


def test_a_glitch_in_a_real_record_is_named_and_leaves_the_random_walk(l3g: NDArray[np.int32]) -> None:
    assert screen(l3g).codes == ()
    clean = random_walk(l3g)
    y = glitched(l3g, np.random.default_rng(1))
    found = screen(y)
    assert found.codes == ("glitch",)
    assert found["glitch"].count == 1
    assert random_walk(y, found.screened(y)) == pytest.approx(clean, rel=WITHIN)


@pytest.mark.slow
def test_sixty_glitches_in_a_real_record(l3g: NDArray[np.int32]) -> None:
    assert sum(screen(glitched(l3g, np.random.default_rng(seed))).codes == ("glitch",) for seed in range(60)) >= LEAST


@pytest.mark.parametrize("fault", ["spikes", "bursts"])
def test_glitches_leave_the_random_walk(fault: str) -> None:
    x = records.FAULTS[fault][0](np.random.default_rng([1, 20]))
    good = records.gyro(np.random.default_rng([1, 20]), len(x))  # the same draws come first
    assert random_walk(x, screen(x).screened(x)) == pytest.approx(random_walk(good), rel=WITHIN)


# Real records


@pytest.mark.slow
def test_pieces_of_real_records_at_rest(shared: Path, l3g: NDArray[np.int32]) -> None:
    """Of 1,000 samples: the gyro of ST, and an MTi before it is picked up."""
    channels = [l3g]
    for name in ("acc", "gyro"):
        table = np.loadtxt(shared / f"data/imu_tk_xsens_mti/xsens_{name}.mat")
        channels += [np.ascontiguousarray(table[:4900, k]) for k in (1, 2, 3)]
    pieces = [x[first : first + 1000] for x in channels for first in range(0, len(x) - 999, 1000)]
    assert len(pieces) > 250
    assert sum(bool(screen(piece).codes) for piece in pieces) <= 2


def test_lines_in_the_stop_band_of_the_archive_mean_nothing(shared: Path) -> None:
    """A head that is filtered at 6 Hz, 142 samples a second: dozens of lines of some 1e-11 g above 20 Hz."""
    (path,) = glob.glob(str(shared / "data/pims_pad/*121f03006"))
    channels = np.fromfile(path, "<f4").reshape(-1, 4)[:, 1:].T.copy()
    all_lines = meaning = 0
    for x in channels:
        spectrum = psd(x.astype(np.float64), 1.0 / 142.0)
        lines = find_lines(spectrum).found
        around = [
            spectrum.density[np.argmin(np.abs(spectrum.frequency - one.frequency)), 0] / one.ratio for one in lines
        ]
        size = np.array([one.amplitude for one in lines])
        hidden = resolution_of(x).hides(size, around, 1.0 / 142.0)
        assert not hidden[size > 1e-9].any()
        assert hidden[size < 1e-10].all()
        all_lines += len(lines)
        meaning += int(np.count_nonzero(~hidden))
    assert all_lines > 50
    assert meaning < 0.3 * all_lines

"""Deviations and intervals against what others published: NBS14, NIST SP 1065, Stable32."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from inertialcal.core.estimate import Array
from inertialcal.signals.allan import Allan, Deviation, allan

# NBS Monograph 140, annex 8.E (NBS14): 9 frequencies; values as quoted in NIST SP 1065, table of the 10-point suite
NBS14 = np.array([892, 809, 823, 798, 671, 644, 883, 903, 677])
NBS14_PRINTED: dict[Deviation, tuple[str, str]] = {
    "non_overlapping": ("91.22945", "115.8082"),
    "overlapping": ("91.22945", "85.95287"),
    "modified": ("91.22945", "74.78849"),
    "hadamard": ("70.80608", "116.7980"),
    "overlapping_hadamard": ("70.80607", "85.61487"),
}
# NIST SP 1065 (2008), 1000-point suite, tau = 1, 10, 100
SP1065_PRINTED: dict[Deviation, tuple[str, str, str]] = {
    "non_overlapping": ("2.922319e-1", "9.965736e-2", "3.897804e-2"),
    "overlapping": ("2.922319e-1", "9.159953e-2", "3.241343e-2"),
    "modified": ("2.922319e-1", "6.172376e-2", "2.170921e-2"),
    "hadamard": ("2.943883e-1", "1.052754e-1", "3.910860e-2"),
    "overlapping_hadamard": ("2.943883e-1", "9.581083e-2", "3.237638e-2"),
}
STABLE32 = 1e-4  # relative: five digits are printed
STABLE32_INTERVAL = 4e-3  # relative: its edf are of the continuous process, and by tables for long windows


def digits_off(printed: str, value: float) -> float:
    """Units of the last printed digit that a value lies off."""
    mantissa, _, exponent = printed.partition("e")
    last = 10.0 ** (int(exponent or 0) - len(mantissa.split(".")[1]))
    return abs(value - float(printed)) / last


def lehmer(n: int) -> Array:
    """Return the 1000-point suite of SP 1065: n_0 = 1234567890, n -> 16807 n mod 2147483647, over the modulus."""
    state, found = 1234567890, []
    for _ in range(n):
        found.append(state / 2147483647)
        state = 16807 * state % 2147483647
    return np.array(found)


@pytest.mark.parametrize("deviation", NBS14_PRINTED)
@pytest.mark.parametrize("kind", [np.int16, np.int64, np.float32, np.float64])
def test_nbs14_to_the_printed_digits(deviation: Deviation, kind: type[np.generic]) -> None:
    found = allan(NBS14.astype(kind), 1.0, quantity="rate", deviation=deviation, factors=[1, 2])
    for printed, value in zip(NBS14_PRINTED[deviation], found.deviation[:, 0], strict=True):
        off = digits_off(printed, value)
        if printed == "70.80608":  # by one in the last digit: at one sample it is the overlapping one, printed 70.80607
            assert 0.5 < off < 1.0
        else:
            assert off <= 0.51


@pytest.mark.parametrize("deviation", SP1065_PRINTED)
def test_sp1065_to_the_printed_digits(deviation: Deviation) -> None:
    y = lehmer(1000)
    assert y.mean() == pytest.approx(0.48977446, abs=1e-8)
    found = allan(y, 1.0, quantity="rate", deviation=deviation, factors=[1, 10, 100])
    for printed, value in zip(SP1065_PRINTED[deviation], found.deviation[:, 0], strict=True):
        off = digits_off(printed, value)
        if printed == "3.910860e-2":  # differs by one in the last digit: 3.910861e-2
            assert 0.5 < off < 1.5
        else:
            assert off <= 0.51


def test_rate_increment_and_angle_are_one_signal() -> None:
    y = lehmer(1000)
    rate = allan(y, 0.01, quantity="rate")
    increment = allan(y * 0.01, 0.01, quantity="increment", factors=rate.m.tolist())
    angle = allan(np.concatenate([[0.0], np.cumsum(y * 0.01)]), 0.01, quantity="angle", factors=rate.m.tolist())
    assert increment.deviation == pytest.approx(rate.deviation, rel=1e-12)
    assert angle.deviation == pytest.approx(rate.deviation, rel=1e-10)
    assert angle.edf == pytest.approx(rate.edf)


def test_published_values_are_those_handed_out(shared: Path) -> None:
    table = json.loads((folder(shared) / "nist_sp1065_1000pt.json").read_text())
    short = {"non_overlapping": "ADEV", "overlapping": "OADEV", "modified": "MDEV", "hadamard": "HDEV"}
    short |= {"overlapping_hadamard": "OHDEV"}
    for deviation, name in short.items():
        assert table[name] == [float(v) for v in SP1065_PRINTED[deviation]]  # type: ignore[index]
        assert table["ten_point_NBS14"][name] == [float(v) for v in NBS14_PRINTED[deviation]]  # type: ignore[index]


# Stable32


def folder(shared: Path) -> Path:
    found = shared / "data" / "noise"
    if not found.is_dir():
        pytest.skip(f"{found} is absent")
    return found


def rows(path: Path) -> Array:
    """Return averaging factor, tau, number, alpha, least, sigma and greatest sigma of a Stable32 table."""
    lines = [line.split() for line in path.read_text(encoding="latin-1").splitlines() if line and line[0] != "#"]
    return np.array([[float(cell) for cell in line] for line in lines if len(line) == 7])


def phase_dat(path: Path) -> Any:
    return np.loadtxt(path), "angle"


def ocxo(path: Path) -> Any:
    return np.loadtxt(path) / 1e7, "rate"  # relative frequency beside an offset of 1: scatter 1e-10


def frequency(path: Path) -> Any:
    return np.loadtxt(path), "rate"


S32: list[tuple[str, Any, str, dict[Deviation, str]]] = [
    (
        "phasedat/PHASE.DAT",
        phase_dat,
        "phasedat/phase_dat_{}.txt",
        {
            "non_overlapping": "adev adev_octave",
            "overlapping": "oadev oadev_octave",
            "modified": "mdev mdev_octave",
            "hadamard": "hdev hdev_octave",
            "overlapping_hadamard": "ohdev ohdev_octave",
        },
    ),
    (
        "ocxo/ocxo_frequency.txt",
        ocxo,
        "ocxo/{}.txt",
        {
            "non_overlapping": "stable32_adev_alltau",
            "overlapping": "stable32_oadev_alltau",
            "modified": "stable32_mdev_alltau",
            "hadamard": "stable32_hdev_alltau",
            "overlapping_hadamard": "stable32_ohdev_alltau",
        },
    ),
    (
        "gps/gps_1pps_phase_data.txt.gz",
        phase_dat,
        "gps/stable32_{}.txt",
        {
            "non_overlapping": "ADEV_decade",
            "overlapping": "OADEV_octave",
            "modified": "MDEV_octave",
            "hadamard": "HDEV_octave",
            "overlapping_hadamard": "OHDEV_octave",
        },
    ),
    (
        "Cs5071A/5071A_phase.txt.gz",
        phase_dat,
        "Cs5071A/{}.txt",
        {
            "non_overlapping": "adev_decade",
            "overlapping": "oadev_decade",
            "modified": "mdev_decade",
            "hadamard": "hdev_decade",
            "overlapping_hadamard": "ohdev_decade",
        },
    ),
    (
        "pink_frequency/pink_frequency.txt",
        frequency,
        "pink_frequency/{}.txt",
        {
            "non_overlapping": "adev",
            "overlapping": "oadev s32_oadev_octave",
            "modified": "mdev",
            "hadamard": "hdev",
            "overlapping_hadamard": "ohdev",
        },
    ),
]


@pytest.mark.parametrize(("data", "read", "tables", "names"), S32, ids=[one[0].split("/")[0] for one in S32])
def test_stable32(shared: Path, data: str, read: Any, tables: str, names: dict[Deviation, str]) -> None:
    base = folder(shared) / "allantools_reference"
    x, quantity = read(base / data)
    for deviation, files in names.items():
        for name in files.split():
            table = rows(base / tables.format(name))
            found: Allan = allan(
                x, 1.0, quantity=quantity, deviation=deviation, factors=table[:, 0].astype(int).tolist()
            )
            assert found.deviation[:, 0] == pytest.approx(table[:, 5], rel=STABLE32, abs=0.0), name
            assert np.abs(found.n[:, 0] - table[:, 2]).max() <= (1 if "overlapping" not in deviation else 0), name


def test_stable32_loses_digits_beside_an_offset_of_one(shared: Path) -> None:
    """Its octave tables of the oscillator are of frequencies about 1 (their head says so), the others about 0."""
    base = folder(shared) / "allantools_reference" / "ocxo"
    table = rows(base / "oadev_octave.txt")
    x = np.loadtxt(base / "ocxo_frequency.txt") / 1e7
    factors = table[:, 0].astype(int).tolist()
    about_one, about_zero = (allan(y, 1.0, quantity="rate", factors=factors).deviation[:, 0] for y in (x, x - x.mean()))
    assert about_one == pytest.approx(about_zero, rel=1e-6, abs=0.0)
    assert STABLE32 < np.abs(table[:, 5] / about_zero - 1.0).max() < 2e-3


@pytest.mark.parametrize("name", ["adev", "oadev", "mdev", "hdev", "ohdev"])
def test_stable32_intervals_of_white_noise(shared: Path, name: str) -> None:
    deviations: dict[str, Deviation] = {
        "adev": "non_overlapping",
        "oadev": "overlapping",
        "mdev": "modified",
        "hdev": "hadamard",
        "ohdev": "overlapping_hadamard",
    }
    base = folder(shared) / "allantools_reference" / "phasedat"
    table = rows(base / f"phase_dat_{name}_octave.txt")
    table = table[(table[:, 3] == 0) & (table[:, 0] >= 8)]  # at 1 to 4 samples ours are those of sampled noise
    found = allan(
        np.loadtxt(base / "PHASE.DAT"),
        1.0,
        quantity="angle",
        deviation=deviations[name],
        factors=table[:, 0].astype(int).tolist(),
        p=0.683,
        noise=0,
    )
    assert len(table) >= 3
    assert found.lo[:, 0] == pytest.approx(table[:, 4], rel=STABLE32_INTERVAL)
    assert found.hi[:, 0] == pytest.approx(table[:, 6], rel=STABLE32_INTERVAL)

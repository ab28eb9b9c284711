"""Each remark of a survey on a record that deserves it, made here; none of them on good records."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import inertialcal as ic
from independent.shaking.masses import FINE, oscillators, read, sampled, swept
from inertialcal.statistics.intervals import covers
from sized import sized

RATE = 2000.0
BAND = (50.0, 450.0, 30.0)
ITEM = oscillators([120.0, 300.0], [25.0, 30.0], [1.0, 0.1])


def made(seed: int = 1, band: tuple[float, float, float] = BAND, **settings: float) -> tuple[np.ndarray, np.ndarray]:
    """Table and response of a survey, without noise, at the fine rate."""
    table = swept(*band, RATE, np.random.default_rng(seed), **settings)
    return table, read(ITEM, table, RATE)


def codes(path: Path, table: np.ndarray, response: np.ndarray, seed: int = 1, *, rate: float = RATE) -> set[str]:
    """Codes of the remarks on a record, written as a file of g."""
    rng = np.random.default_rng([seed, 3])
    channels = [sampled(one, 0.002, rng) for one in (table, response)]
    return saved_codes(path, *channels, rate=rate)


def saved_codes(path: Path, control: np.ndarray, response: np.ndarray, *, rate: float = RATE) -> set[str]:
    """Codes of the remarks on channels as they are saved."""
    time = np.arange(len(control)) / rate
    np.savetxt(path / "s.csv", np.column_stack([time, control, response]), "%.6f", ",",
               header="time [s],control [g],acc_x [g]", comments="")  # fmt: skip
    return {one.code for one in ic.vibration_survey(str(path / "s.csv"), modes=3).remarks} - {"standard_missing"}


def test_a_sweep_beyond_what_the_samples_carry_is_named(tmp_path: Path) -> None:
    table, response = made(band=(50.0, 900.0, 40.0))
    assert codes(tmp_path, table, response) == {"aliasing"}


def test_a_response_that_reaches_the_end_of_its_range_is_named(tmp_path: Path) -> None:
    table, response = made()
    rng = np.random.default_rng(1)
    control, seen = sampled(table, 0.002, rng), sampled(response, 0.002, rng)
    assert "saturated" in saved_codes(tmp_path, control, np.clip(seen, -2.0, 2.0))


def test_a_control_that_loses_its_level_is_named(tmp_path: Path) -> None:
    table, _ = made()
    t = np.arange(len(table)) / (FINE * RATE)
    held = table * (1.0 - 0.8 * np.exp(-0.5 * ((t - 3.0) / 0.15) ** 2))
    assert codes(tmp_path, held, read(ITEM, held, RATE)) == {"control_lost"}


def test_a_drive_full_of_harmonics_is_named(tmp_path: Path) -> None:
    table, response = made(harmonic=0.2)  # the second: a clipped wave has the third
    assert codes(tmp_path, table, response) == {"distortion"}


def test_a_response_that_something_else_moves_is_named(tmp_path: Path) -> None:
    table, response = made()
    rng = np.random.default_rng(5)
    size = float(np.std(response))
    other = np.repeat(rng.standard_normal(len(response) // FINE + 1), FINE)[: len(response)]
    assert "unexplained" in codes(tmp_path, table, response + 0.5 * size * other)


def test_a_good_record_has_none_of_them(tmp_path: Path) -> None:
    seeds, silent = sized(60, 6), 0
    for seed in range(1, seeds + 1):
        rng = np.random.default_rng([seed, 2])
        band = BAND if seed % 2 else (450.0, 50.0, float(rng.uniform(20.0, 40.0)))
        table, response = made(seed, band, level=float(rng.uniform(0.1, 1.0)), ripple=float(rng.uniform(0.0, 0.15)))
        silent += not codes(tmp_path, table, response, seed)
    assert covers(silent, seeds, 0.99)

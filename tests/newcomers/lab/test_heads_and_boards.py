"""`info` suggests and `init` drafts the same test: accelerometers alone, a head in orbit, a rate table."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from inertialcal.campaign.start.info import info
from inertialcal.campaign.start.starter import Told, first_question, start

RATE, N = 10.0, 6_000
COMMANDS = ("info", "init", "allan", "psd", "flip", "microgravity", "positions", "rate-table")
RNG = np.random.default_rng(26)
NOISE = RNG.normal(size=(N, 3))
SHAKE = np.outer(np.sin(2.0 * np.pi * 3.0 * np.arange(N) / RATE) * np.linspace(0.5, 2.0, N), [0.0, 40.0, 0.0])
FLIP = np.repeat([[1.0, 1.0, 1.0], [-1.0, 1.0, -1.0]], N // 2, axis=0)


def written(path: Path, columns: Mapping[str, NDArray[np.float64]]) -> Path:
    """Write a text with a clock."""
    named = {"time [s]": np.arange(N) / RATE} | dict(columns)
    np.savetxt(path, np.column_stack(list(named.values())), "%.9g", ",", header=",".join(named), comments="")
    return path


def head(path: Path, table: NDArray[np.float64]) -> Path:
    """Write accelerometers alone."""
    return written(path, {f"acc_{axis} [m/s^2]": table[:, i] for i, axis in enumerate("xyz")})


@pytest.mark.parametrize(
    ("table", "noun", "procedure"),
    [
        (0.01 * NOISE + [0.0, 0.0, 9.8], "allan", "static_noise"),
        (1e-4 * NOISE, "microgravity", "microgravity"),
        (1e-6 * NOISE + 1e-3 * FLIP, "flip", "flip"),
    ],
)
def test_accelerometers_alone(table: NDArray[np.float64], noun: str, procedure: str, tmp_path: Path) -> None:
    path = head(tmp_path / "log.csv", table)
    assert (info(path, commands=COMMANDS).next or "").split()[1] == noun
    start(tmp_path)
    (test,) = tomllib.loads((tmp_path / "campaign.toml").read_text(encoding="utf-8"))["tests"]
    assert test["procedure"] == procedure


def test_a_shaken_triad_was_not_laid_into_positions(tmp_path: Path) -> None:
    path = head(tmp_path / "log.csv", 0.05 * NOISE + [0.0, 9.8, 0.0] + SHAKE)
    assert (info(path, commands=COMMANDS).next or "").split()[1] != "positions"


def test_the_unit_of_an_applied_rate_is_asked_for(tmp_path: Path) -> None:
    applied = np.repeat([0.0, 20.0, 40.0, 0.0, -20.0, -40.0], N // 6)
    gyro = {f"gyro_{axis} [deg/s]": slope * applied + NOISE[:, i] for i, (axis, slope) in
            enumerate({"x": 0.003, "y": 0.003, "z": 1.012}.items())}  # fmt: skip
    written(tmp_path / "log.csv", {"table_rate": applied} | gyro)
    told = Told(axis="z")
    question = first_question(tmp_path, told)
    assert question is not None
    assert (question.name, question.group) == ("units", "table_rate")
    assert "acceleration" in question.wrong("g")
    assert question.wrong("deg/s") == ""
    told = told.answered(question, "deg/s")
    following = first_question(tmp_path, told)
    assert following is not None
    assert following.name == "maker"
    path, _, _ = start(tmp_path, "", told)
    channels = tomllib.loads(path.read_text(encoding="utf-8"))["recordings"]["rec1"]["channels"]
    assert channels["applied"] == {"column": "table_rate", "unit": "deg/s"}

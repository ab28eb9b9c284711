"""Mutated campaign files and tables, 2,000 in the slow suite: refused with a message or reduced, never a traceback."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from inertialcal.campaign.engine.run import run
from inertialcal.core.errors import InertialcalError
from inertialcal.core.schema.json_text import json_text

Write = Callable[..., Path]
CHECKS = [HealthCheck.function_scoped_fixture]
FEW = settings(max_examples=150, deadline=None, suppress_health_check=CHECKS)
MANY = settings(max_examples=1000, deadline=None, suppress_health_check=CHECKS)
PIECES = st.one_of(
    st.text(max_size=6),
    st.sampled_from(
        ["nan", "1e999", "-1", '""', "[]", "{}", "true", "\n", ",", ";", '"', "\x00", "9" * 400, "=", "[[tests]]\n",
         '"1 deg/s"', "1979-05-27", "null", "\ufeff", "../", "%s", "0x7fffffffffffffffffff", "inf"]
    ),
)  # fmt: skip
EDITS = st.lists(st.tuples(st.floats(0, 1), st.integers(0, 25), PIECES), min_size=1, max_size=4)


def mutated(text: str, edits: list[tuple[float, int, str]]) -> str:
    """Cut ``length`` characters at some place and put a piece there instead, several times."""
    for place, length, piece in edits:
        at = int(place * len(text))
        text = text[:at] + piece + text[at + length :]
    return text


def survives(folder: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            json_text(run(folder, write=False).results)
        except InertialcalError as error:
            assert all(problem.what for problem in error.problems)  # noqa: PT017


@pytest.fixture
def folder(campaign: Write) -> Path:
    return campaign()


@pytest.mark.parametrize("file", ["campaign.toml", "one.csv"])
@pytest.mark.parametrize("often", [FEW, pytest.param(MANY, marks=pytest.mark.slow)], ids=["few", "many"])
def test_mutated_files(folder: Path, file: str, often: settings) -> None:
    text = (folder / file).read_text(encoding="utf-8")

    @often
    @given(edits=EDITS)
    def survive(edits: list[tuple[float, int, str]]) -> None:
        (folder / file).write_text(mutated(text, edits), encoding="utf-8", errors="surrogatepass")
        survives(folder)

    survive()

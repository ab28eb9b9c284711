"""2,000 mutated campaign files and tables: refused with a message or reduced, never a traceback."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from inertialcal.campaign.engine.run import run
from inertialcal.campaign.outcome.publish import json_text
from inertialcal.core.errors import InertialcalError

Write = Callable[..., Path]
FUZZ = settings(max_examples=1000, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
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
def folder(campaign: Write) -> tuple[Path, str, str]:
    made = campaign()
    return made, (made / "campaign.toml").read_text(), (made / "one.csv").read_text()


@FUZZ
@given(edits=EDITS)
def test_mutated_campaign_files(folder: tuple[Path, str, str], edits: list[tuple[float, int, str]]) -> None:
    made, text, _ = folder
    (made / "campaign.toml").write_text(mutated(text, edits), encoding="utf-8", errors="surrogatepass")
    survives(made)


@FUZZ
@given(edits=EDITS)
def test_mutated_tables(folder: tuple[Path, str, str], edits: list[tuple[float, int, str]]) -> None:
    made, _, data = folder
    (made / "one.csv").write_text(mutated(data, edits), encoding="utf-8", errors="surrogatepass")
    survives(made)

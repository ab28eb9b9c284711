"""Texts of a campaign and names of its files do nothing on the report, whatever stands in them."""

from __future__ import annotations

import copy
import csv
import json
from collections.abc import Callable, Iterator
from io import StringIO
from itertools import cycle
from pathlib import Path

import pytest
from browsing import Visit, visit
from hostile_campaign import FILES, INSTEAD, NOT_FREE, document, filled, leaves, put, toml, write
from hostile_page import bidi_leaks, elements, letters, reactions
from injections import INJECTIONS, batches, rotated
from playwright.sync_api import Browser

from inertialcal.campaign.engine.run import run
from inertialcal.campaign.file.load import load
from inertialcal.core.errors import InertialcalError
from inertialcal.core.schema.quantities import Text
from inertialcal.report.page import LARGEST

LONGEST = 1700  # characters: a text may have 2000, and its number follows
GROUPS = batches(LONGEST)
RUNS = 6
WHOLE = 20 * LARGEST  # bytes of a page, with which nothing is left out whatever the length of its texts


def numbered(group: tuple[str, ...]) -> Callable[[str], str]:
    """Return what gives each field all texts of the group, another one first, and its number last."""
    given: list[str] = []

    def give(name: str) -> str:
        given.append(name)
        return " ".join([*rotated(group, len(given)), str(len(given))])

    return give


def report(folder: Path, group: tuple[str, ...], largest: int = WHOLE) -> Path:
    """Run a campaign with the texts everywhere, in a folder named by them; return its report, of that size at most."""
    name = letters(" ".join(group)).replace("/", "_")[:60]
    runs = tuple(" ".join([*group[i::RUNS], f"run {i}"]) for i in range(RUNS))
    made = write(folder / name, filled(numbered(group)), runs)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("inertialcal.report.page.LARGEST", largest)
        run(made)
    return made / "out" / "report.html"


@pytest.fixture(scope="module")
def harmless(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return report(tmp_path_factory.mktemp("harmless"), ("harmless",))


@pytest.fixture(scope="module")
def page(browser: Browser, harmless: Path) -> Iterator[Visit]:
    """The policy of the page is off: it must hold without it."""
    with visit(browser, harmless, bypass_csp=True) as seen:
        yield seen


def test_there_are_200_injections() -> None:
    assert len(set(INJECTIONS)) >= 200


def test_every_text_of_the_schema_is_filled() -> None:
    """A table that is added to the schema has to be added to the document of the test."""
    free = {name for name, _, kind in leaves() if kind == Text}
    assert {name for name, _, kind in leaves(value=document()) if kind == Text} == free
    made = filled(lambda name: f"text of {name}")
    given = json.dumps(made)
    assert {name for name in free - NOT_FREE - INSTEAD - FILES.keys() if f"text of {name}" not in given} == set()


@pytest.mark.parametrize(
    "group", [pytest.param(one, id=str(i), marks=pytest.mark.slow if i % 4 else []) for i, one in enumerate(GROUPS)]
)
def test_no_text_runs_loads_or_breaks_the_page(
    page: Visit, harmless: Path, tmp_path: Path, group: tuple[str, ...]
) -> None:
    page.open(harmless)
    wanted = elements(page.page)
    made = report(tmp_path, group)
    page.open(made)
    assert elements(page.page) == wanted
    assert reactions(page) == []
    assert bidi_leaks(page.page) == []
    shown = page.page.evaluate("document.body.textContent")
    assert "<bdi>" not in shown + page.page.title()
    shown = letters(shown)
    assert [text for text in group if letters(text) not in shown] == []
    tables = [path.read_text(encoding="utf-8") for path in made.parent.glob("*.csv")]
    tables += page.page.locator("pre.csv").all_text_contents()
    assert len(tables) > 5
    assert [cell for table in tables for row in csv.reader(StringIO(table)) for cell in row if is_formula(cell)] == []
    for path in made.parent.glob("*.json"):
        json.loads(path.read_text(encoding="utf-8"))


def test_a_page_that_leaves_out_what_has_no_room_is_harmless_too(page: Visit, harmless: Path, tmp_path: Path) -> None:
    page.open(harmless)
    known = set(elements(page.page))
    made = report(tmp_path, GROUPS[0], LARGEST)
    assert made.stat().st_size <= LARGEST
    page.open(made)
    assert set(elements(page.page)) <= known
    assert reactions(page) == []
    assert bidi_leaks(page.page) == []
    assert "results.csv" in page.page.evaluate("document.body.textContent")


def test_texts_that_are_read_as_something_are_refused(tmp_path: Path) -> None:
    """Names, units, quantities, words of a list, conditions: each takes what it can read, and none of these."""
    made = filled(lambda name: name)
    write(tmp_path / "campaign", made, ("1", "2"))
    read = [(name, keys) for name, keys, kind in leaves(value=made) if kind != Text or name in NOT_FREE]
    assert len(read) > 20
    for (name, keys), text in zip(cycle(read), INJECTIONS, strict=False):
        broken = copy.deepcopy(made)
        put(broken, keys, text)
        (tmp_path / "campaign" / "campaign.toml").write_text(toml(broken), encoding="utf-8")
        assert refused(tmp_path / "campaign"), f"{name} = {text!r} is taken"


def refused(folder: Path) -> bool:
    try:
        load(folder)
    except InertialcalError:
        return True
    return False


def is_formula(cell: str) -> bool:
    """Tell whether a spreadsheet would run a cell."""
    try:
        float(cell)
    except ValueError:
        return cell.startswith(("=", "+", "-", "@", "\t", "\r"))
    return False

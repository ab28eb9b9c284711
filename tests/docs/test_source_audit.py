"""The source audit: the page is what the tables give, verdicts follow their rules, and agree with the errata."""

from __future__ import annotations

import csv
import importlib
import math
import sys
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(ROOT / "docs" / "audit"))

figures: Any = importlib.import_module("source_audit.figures")
lead_body: Any = importlib.import_module("source_audit.lead_body")
table_files: Any = importlib.import_module("source_audit.table_files")
printing: Any = importlib.import_module("source_audit.printed")
verdicts: Any = importlib.import_module("source_audit.verdicts")

AGREES = {  # words of the errata, and those of the audit that say the same
    "ok": {"follows", "rounding", "too coarse"},
    "rounding": {"follows", "rounding", "too coarse"},
    "misprint": {"misprint", "unit"},
    "sign": {"sign"},
    "unexplained": {"does not follow", "cannot be told"},
}


@pytest.fixture(scope="module")
def documents() -> Any:
    return [document() for document in importlib.import_module("source_audit.documents").DOCUMENTS]


@pytest.fixture(scope="module")
def judged(documents: Any) -> dict[tuple[str, str], str]:
    """Verdict of every figure by document and ``section/figure``."""
    return {
        (document.key, f"{section.key}/{one.key}"): verdicts.judge(one).word
        for document in documents
        for section in document.sections
        for one in section.figures
    }


def test_the_page_is_what_the_tables_give(documents: Any) -> None:
    page = importlib.import_module("source_audit.page").page(documents)
    committed = (ROOT / "docs" / "source_audit.md").read_text(encoding="utf-8")
    assert page == committed, "the page is out of date: python docs/audit/audit.py"


def test_every_figure_has_its_own_name(documents: Any) -> None:
    keys = [(d.key, s.key, one.key) for d in documents for s in d.sections for one in s.figures]
    assert len(keys) == len(set(keys))


# Against the errata


def errata(shared: Path) -> list[dict[str, str]]:
    path = shared / "reference" / "errata.csv"
    if not path.is_file():
        pytest.skip(f"no errata to compare with: {path.name} is absent")
    return table_files.read(path)  # type: ignore[no-any-return]


def matching(patterns: str, document: str, judged: dict[tuple[str, str], str]) -> set[str]:
    words: set[str] = set()
    for pattern in patterns.split("; "):
        found = {word for (key, name), word in judged.items() if key == document and fnmatchcase(name, pattern)}
        assert found, f"{document}: no figure {pattern!r}"
        words |= found
    return words


def agrees(verdict: str, words: set[str]) -> bool:
    """A figure that is said to hold must hold wherever it is looked at; of a finding one trace is enough."""
    return words <= AGREES[verdict] if verdict in ("ok", "rounding") else bool(words & AGREES[verdict])


def test_the_errata_are_found_and_every_disagreement_has_its_reason(
    shared: Path, judged: dict[tuple[str, str], str]
) -> None:
    with (HERE / "errata_figures.csv").open(encoding="utf-8", newline="") as lines:
        known = {(row["document"], row["place"]): row for row in csv.DictReader(lines)}
    rows = errata(shared)
    assert {(row["document"], row["place"]) for row in rows} == set(known)
    wrong = []
    for row in rows:
        entry = known[row["document"], row["place"]]
        if not entry["figures"]:
            assert entry["reason"], f"{row['place']}: neither figures nor a reason"
            continue
        words = matching(entry["figures"], row["document"], judged)
        if agrees(row["verdict"], words) == bool(entry["reason"]):
            wrong.append(f"{row['document']}, {row['place']}: {row['verdict']} against {sorted(words)}")
    assert not wrong, "\n".join(wrong)


def test_the_tables_are_those_of_the_reference(shared: Path) -> None:
    reference = shared / "reference"
    if not reference.is_dir():
        pytest.skip("the reference tables are absent")
    checked = 0
    for path in sorted(table_files.TABLES.glob("*/*.csv")):
        source = reference / path.parent.name / path.name
        if path.name == "stated.csv":
            continue
        ours, theirs = table_files.read(path), table_files.read(source)
        for one, other in zip(ours, theirs, strict=True):
            assert {key: other[key] for key in one} == one, path.name
        checked += 1
    assert checked > 40


# Rules


@pytest.mark.parametrize(
    ("text", "low", "high"),
    [
        ("3.07e8", 3.065e8, 3.075e8),
        ("4700", 4650.0, 4750.0),
        ("-0.50", -0.505, -0.495),
        ("1e-3", 0.95e-3, 1.5e-3),
        ("0.1", 0.05, 0.15),
        ("2.80E-4", 2.795e-4, 2.805e-4),
    ],
)
def test_a_printed_figure_stands_for_what_rounds_to_it(text: str, low: float, high: float) -> None:
    one = printing.printed(text)
    ends = (one.value - one.below, one.value + one.above)
    assert ends == pytest.approx((low, high), rel=1e-12)


def test_a_count_has_no_idle_zeros_and_words_are_no_figures() -> None:
    assert printing.printed("900", count=True).half == 0.5
    with pytest.raises(ValueError, match="no printed figure"):
        printing.printed("about 3")


def test_rounding_is_carried_by_the_sum_or_by_chance_whichever_is_less() -> None:
    few = printing.recompute(lambda a, b: a - b, printing.printed("28.07"), printing.printed("4.70"))
    assert few.tolerance == pytest.approx(0.01)
    many = printing.recompute(lambda *x: sum(x), *[printing.printed("1.0")] * 300)
    assert many.tolerance == pytest.approx(3.0 * 0.05 / math.sqrt(3.0) * math.sqrt(300.0))


@pytest.mark.parametrize(
    ("text", "value", "tolerance", "word"),
    [
        ("23.27", 23.274, 0.0, "follows"),
        ("23.27", 23.28, 0.0, "rounding"),
        ("23.27", 23.37, 0.01, "misprint"),
        ("23.27", 32.27, 0.0, "misprint"),
        ("23.27", -23.27, 0.0, "sign"),
        ("23.27", 0.02327, 0.0, "unit"),
        ("23.27", 29.91, 0.0, "does not follow"),
        ("23.27", 23.30, 0.09, "follows"),
        ("23.27", 23.30, 0.10, "too coarse"),  # 21 half units
        ("23.27", 23.37, 0.3, "too coarse"),
        ("232.7", 282.4, 3.0, "does not follow"),  # too blunt to tell a digit
        ("-1.2", -0.12, 0.01, "misprint"),
        ("1.2", 1.9, 0.0, "does not follow"),  # two digits: too few to tell one
    ],
)
def test_verdicts_follow_their_rules(text: str, value: float, tolerance: float, word: str) -> None:
    one = figures.figure("a", "a", text, printing.Recomputed(value, tolerance))
    assert verdicts.judge(one).word == word


def test_one_reason_in_one_table_is_one_cause_and_identities_are_counted_apart(documents: Any) -> None:
    page = importlib.import_module("source_audit.page")
    wrong = [figures.figure(str(k), "a", "1.2", printing.Recomputed(1.9, 0.0), why="other data") for k in range(3)]
    other = figures.figure("4", "a", "1.2", printing.Recomputed(1.9, 0.0), why="a slip")
    held, blunt = (figures.figure("5", "a", "23.27", printing.Recomputed(23.27, t)) for t in (0.0, 1.0))
    section = figures.Section("s", "S", "how", (*wrong, other, held, blunt))
    assert page.causes([section]) == 2
    assert page.counts([section]) == {"does not follow": 4, "follows": 1, "too coarse": 1}
    apart = [s for d in documents for s in d.sections if s.identity]
    assert sum(len(s.figures) for s in apart) == 284  # rate times dwell, sums of each report, repeats, order of stamps


def test_without_data_nothing_can_be_told() -> None:
    assert verdicts.judge(figures.figure("a", "a", "1.0", None)).word == "cannot be told"


def test_limits_hold_or_do_not() -> None:
    limit = printing.Recomputed(73.35, 0.03)
    assert verdicts.judge(figures.figure("a", "a", "74.017", limit, relation="at most")).word == "does not follow"
    assert verdicts.judge(figures.figure("a", "a", "73.1", limit, relation="at most")).word == "follows"
    assert verdicts.judge(figures.figure("a", "a", "74.017", limit, relation="at least")).word == "follows"


def test_another_reading_is_tried_only_where_the_first_fails() -> None:
    other = figures.Variant("the intercept", printing.Recomputed(0.244), "misprint")
    failed = figures.figure("a", "a", "0.244", printing.Recomputed(-0.2), variants=(other,))
    assert (verdicts.judge(failed).word, verdicts.judge(failed).reason) == ("misprint", "it is the intercept")
    held = figures.figure("a", "a", "0.244", printing.Recomputed(0.244), variants=(other,))
    assert verdicts.judge(held).word == "follows"


def test_units_are_compared_by_dimension() -> None:
    assert verdicts.judge(figures.Text("a", "a", "deg/h/sqrt(h)", "deg/h/h", is_unit=True)).word == "unit"
    assert verdicts.judge(figures.Text("a", "a", "deg/s/sqrt(Hz)", "deg/sqrt(h)", is_unit=True)).word == "follows"


# Published figures


@pytest.mark.parametrize(
    ("document", "name", "word"),
    [
        ("reinel1969", "table 4/GO 1", "misprint"),
        ("reinel1969", "table 3/45.7 cm", "misprint"),
        ("reinel1969", "frequencies/input", "does not follow"),
        ("sams1996", "tables 4-6/bias Y time 2", "follows"),
        ("sams1996", "conclusions/accuracy", "unit"),
        ("npsat2011", "fits/G1 slope", "follows"),
        ("npsat2011", "flight matrix/m_zz", "sign"),
        ("npsat2011", "matrix/m_zx minus_ref", "misprint"),
        ("npsat2011", "missing/m_yx no_ref", "cannot be told"),
    ],
)
def test_known_figures(judged: dict[tuple[str, str], str], document: str, name: str, word: str) -> None:
    assert judged[document, name] == word


def test_a_sphere_of_68_kg_gives_1e_8_g() -> None:
    radius = lead_body.sphere_radius(1e-8, 10.2)
    assert radius == pytest.approx(11.25, abs=0.005)  # Reinel, Table 1
    assert lead_body.sphere_mass(radius) == pytest.approx(68.0, abs=0.5)
    assert lead_body.point_attraction(lead_body.sphere_mass(radius), radius + 10.2) == pytest.approx(1e-8, rel=1e-9)


def test_no_body_of_cubes_beats_the_largest_attraction() -> None:
    cells = lead_body.best_cells(10.2, 5.1)
    mass = len(cells) * 5.1**3 * lead_body.DENSITY / 1e3
    found, bound = lead_body.cells_attraction(cells, 5.1), lead_body.largest_attraction(mass, 10.2)
    assert 0.99 * bound < found < bound


def test_the_largest_attraction_is_that_of_its_own_body() -> None:
    """Integrate the discs of the body x / r^3 >= c by themselves."""
    face, u = 10.2, 0.3
    c = u**3 / face**2
    x = np.linspace(face, c**-0.5, 200_001)
    r2 = (x / c) ** (2.0 / 3.0)
    step = x[1] - x[0]
    mass = lead_body.DENSITY * np.pi * np.sum(r2 - x**2) * step / 1e3
    pull = 2.0 * np.pi * lead_body.GAMMA * lead_body.DENSITY * np.sum(1.0 - x / np.sqrt(r2)) * step * lead_body.IN_NG
    assert lead_body.largest_attraction(float(mass), face) == pytest.approx(float(pull), rel=1e-4)


def test_a_far_cube_is_a_point() -> None:
    assert abs(lead_body.cube_error(20.0)) < 1e-6
    assert lead_body.cube_error(2.0) == pytest.approx(4.361e-3, abs=1e-6)


def test_effects_say_the_worst_of_the_flight_equation(documents: Any) -> None:
    effect = documents[2].effects[0].effect
    assert "-1.010 %" in effect
    assert "1.491 %" in effect

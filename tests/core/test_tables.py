from __future__ import annotations

import re
from html.parser import HTMLParser

import pytest
from hypothesis import given
from hypothesis import strategies as st

from inertialcal.core.key import Key, Reason
from inertialcal.core.remarks import Remark
from inertialcal.core.results import Interval, Row, not_estimated
from inertialcal.core.show.result_tables import estimate_table, folded, remarks_line
from inertialcal.core.show.rounding import dof
from inertialcal.core.show.tables import (
    WIDTH,
    Block,
    Details,
    Table,
    aligned,
    clean,
    ending,
    html,
    short,
    terminal_width,
    text,
    wrapped,
)

HOSTILE = (
    "<script>alert(1)</script>",
    '"><img src=x onerror=alert(1)>',
    "</table></div><b>",
    "&lt;b&gt; & 'quoted'",
    "line\nend\r\x00\x1b[31m",
    "right\u202eleft\u2028",
    "$x^2$ {0} %s",
    "long " * 100,
    "W" * 500,
)
ALLOWED = {"div", "table", "caption", "thead", "tbody", "tr", "th", "td", "details", "summary", "ul", "li"}


class Reader(HTMLParser):
    """Tags as they open and close, their attributes, the text of cells."""

    def __init__(self) -> None:
        super().__init__(convert_charrefs=True)
        self.open: list[str] = []
        self.cells: list[str] = []
        self.words: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        assert tag in ALLOWED
        assert {name for name, _ in attrs} <= {"style", "scope"}
        style = dict(attrs).get("style") or ""
        assert "color" not in style
        assert "background" not in style
        assert "url" not in style
        self.open.append(tag)
        if tag in {"td", "th"}:
            self.cells.append("")

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.words.append(data)
        if self.open and self.open[-1] in {"td", "th"}:
            self.cells[-1] += data


def parsed(source: str) -> Reader:
    reader = Reader()
    reader.feed(source)
    reader.close()
    assert not reader.open
    return reader


def test_html_and_text_have_the_same_cells() -> None:
    grid = Table(("name", "value ± u"), [("a", "1.0 ± 0.1"), ("b", "22 ± 3")], "two", (1,))
    assert parsed(html([grid])).cells == ["name", "value ± u", "a", "1.0 ± 0.1", "b", "22 ± 3"]
    assert text([grid]) == "two\n  name  value ± u\n  a     1.0 ± 0.1\n  b        22 ± 3"


@pytest.mark.parametrize("name", HOSTILE)
def test_names_are_text_and_nothing_else(name: str) -> None:
    parts: list[Block] = [Table((name, "b"), [(name, "1")], name, (1,)), Details(name, (name, name)), name]
    found = parsed(html(parts))
    shown = clean(name).replace("\n", "\N{REPLACEMENT CHARACTER}")
    assert found.cells == [shown, "b", shown, "1"]
    plain = text(parts)
    assert all(c.isprintable() or c == "\n" for c in plain)
    assert max(len(line) for line in plain.split("\n")) <= WIDTH


def test_columns_of_figures_are_never_cut() -> None:
    wide = "1.23456789 ± 0.00000012"
    grid = Table(("name", "a", "b", "c"), [("n" * 200, wide, wide, wide)], right=(1, 2, 3))
    shown = text([grid])
    assert shown.count(wide) == 3
    assert "n…" in shown


def test_what_cannot_fit_is_left_wide() -> None:
    figure = "9" * 60
    assert figure in text([Table(("a", "b"), [(figure, figure)], right=(0, 1))])


def test_rows_without_heads_and_no_rows() -> None:
    assert aligned([["a", "b"], ["cc", "d"]]) == "a   b\ncc  d"
    assert aligned([]) == ""
    assert aligned([], ["only", "heads"]) == "only  heads"


def test_long_names_and_paths_keep_their_telling_end() -> None:
    assert short("abcdef", 4) == "abc…"
    assert ending("/far/away/x.csv", 7) == "…/x.csv"[-7:]
    assert ending("x.csv", 7) == "x.csv"


def test_remarks_are_counted_by_severity_the_serious_first() -> None:
    remarks = [Remark("a", "info", "one"), Remark("b", "warning", "two"), Remark("c", "warning", "three <b>")]
    (part,) = remarks_line(remarks)
    assert isinstance(part, Details)
    assert part.summary == "remarks: 2 warnings, 1 info (see .remarks)"
    assert part.lines == ("warning: two", "warning: three <b>", "info: one")
    assert remarks_line([]) == ()


def test_figures_are_rounded_to_their_uncertainty_and_reasons_told_once() -> None:
    rows = [
        Row(Key("bias", "x"), 0.00748231, 0.00029, "deg/s", 93.74, Interval(0.0068988, 0.0080657)),
        Row(Key("linearity_error", "x"), 0.265, 0.043, "%", None, status="upper_limit"),
        not_estimated(Key("misalignment", "yx"), "rad", Reason("not_read", "no readings")),
        not_estimated(Key("misalignment", "zx"), "rad", Reason("not_read", "no readings")),
    ]
    grid, reason = estimate_table([row.to_dict() for row in rows], "test")
    assert isinstance(grid, Table)
    assert list(grid.rows) == [
        ("bias", "x", "0.00748 ± 0.00029", "deg/s", "0.00690 .. 0.00807", "93.7"),
        ("linearity_error", "x", "< 0.265 ± 0.043", "%", "", "inf"),
    ]
    assert reason == "not estimated: misalignment yx, misalignment zx: no readings"
    assert estimate_table([rows[2].to_dict()], "test")[0] == "test"


def test_degrees_of_freedom() -> None:
    assert [dof(None), dof(float("inf")), dof(1e6), dof(4.2849)] == ["inf", "inf", "inf", "4.28"]


def test_folded_lines_are_counted() -> None:
    assert folded("{n} {x}", ["a", "b"]) == (Details("2 {x}", ("a", "b")),)
    assert folded("{n}", []) == ()


def test_columns_beyond_a_narrow_terminal_go_below_after_the_first(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("inertialcal.core.show.tables.terminal_width", lambda: 24)
    heads, rows = ("channel", "axis", "mean", "std", "unit"), [("gyro", "x", "1.25", "0.5", "deg/s")] * 2
    assert aligned(rows, heads, (2, 3)) == (
        "channel  axis  mean  std\ngyro     x     1.25  0.5\ngyro     x     1.25  0.5\n\n"
        "channel  axis  unit\ngyro     x     deg/s\ngyro     x     deg/s"
    )
    assert all(len(line) <= 24 for line in text(("word " * 20, Table(heads, rows, "caption " * 9))).split("\n"))


@pytest.mark.parametrize(("said", "columns"), [("60", 60), ("7", 20), ("0", 80), ("-3", 80), ("wide", 80), (None, 80)])
def test_columns_are_what_is_said_else_eighty(said: str | None, columns: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("COLUMNS", raising=False)
    monkeypatch.setattr("os.get_terminal_size", lambda *of: (_ for _ in ()).throw(OSError))
    if said is not None:
        monkeypatch.setenv("COLUMNS", said)
    assert terminal_width() == columns


WORDS = st.lists(st.text("abc_", min_size=1, max_size=9), min_size=1, max_size=9).map(" ".join)
FIGURES = st.sampled_from(["1.25 ± 0.12", "(-3.2 ± 0.4)e-07 deg/s", "0.1 .. 0.4", "95 % here", ""])


@given(st.lists(st.tuples(WORDS, WORDS, FIGURES, FIGURES), min_size=1, max_size=5), st.integers(40, 120))
def test_tables_fit_and_lose_nothing(rows: list[tuple[str, ...]], columns: int) -> None:
    heads = ("words", "more", "figure", "right")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("COLUMNS", str(columns))
        shown = aligned(rows, heads, (3,))
        assert wrapped(" ".join(rows[0])).split() == " ".join(rows[0]).split()
    assert max(map(len, shown.split("\n"))) <= columns
    letters = re.sub(r"[ \n]", "", shown)
    for cell in (cell for row in rows for cell in row):
        assert all(letters.count(word) for word in cell.split())
    for figure in (row[3] for row in rows):
        assert figure in shown


def test_a_figure_is_never_parted_from_its_uncertainty_or_unit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "30")
    assert (
        wrapped("bias of the x sensor 1.25 ± 0.12 deg/s in air") == "bias of the x sensor\n  1.25 ± 0.12 deg/s in air"
    )


def test_long_names_break_after_an_underscore_where_nothing_else_helps(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "40")
    assert aligned([["temperature_reference_voltage", "1.25 ± 0.12"]], ["quantity", "value ± u"]) == (
        "quantity                     value ± u\ntemperature_reference_       1.25 ± 0.12\n  voltage"
    )

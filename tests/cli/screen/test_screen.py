"""What a terminal shows: a screen of a result, verdicts in colour; a pipe gets all of it, plain."""

from __future__ import annotations

import io
import re
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from inertialcal.cli import figures, opening
from inertialcal.cli.__main__ import main
from inertialcal.cli.shown import screen
from inertialcal.cli.shown.screen import ROWS, coloured, folded, say, shown_whole
from inertialcal.cli.shown.summary import results_parts, results_text
from inertialcal.core.show.rows import missing_of
from ran_campaigns import Ran

MORE = re.compile(r"  \.\.\. (\d+) more rows: --all")


class Terminal(io.TextIOWrapper):
    """Standard output that is a terminal."""

    def __init__(self, encoding: str = "utf-8") -> None:
        self.bytes = io.BytesIO()
        super().__init__(self.bytes, encoding=encoding, errors="replace")

    def isatty(self) -> bool:
        return True

    def text(self) -> str:
        self.flush()
        return self.bytes.getvalue().decode(self.encoding)


def on_terminal(patch: pytest.MonkeyPatch, encoding: str = "utf-8") -> Terminal:
    """Make standard output a terminal with colours; in the test itself, for each phase has a capture of its own."""
    patch.setenv("TERM", "xterm")
    patch.delenv("NO_COLOR", raising=False)
    found = Terminal(encoding)
    patch.setattr(sys, "stdout", found)
    return found


@given(st.integers(1, 200), st.integers(2, 60))
def test_rows_shown_and_rows_counted_are_all_rows(n: int, rows: int) -> None:
    text = "\n".join(map(str, range(n)))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(screen, "folds", lambda: True)
        shown = folded(text, rows).split("\n")
    more = MORE.fullmatch(shown[-1])
    assert len(shown) <= rows
    assert len(shown) - bool(more) + int(more[1] if more else 0) == n
    assert "\n".join(shown[: len(shown) - bool(more)]) == "\n".join(map(str, range(len(shown) - bool(more))))


@given(st.lists(st.integers(0, 300), min_size=1, max_size=9))
def test_parts_share_a_screen(sizes: list[int]) -> None:
    parts = ["\n".join(["row"] * size) for size in sizes]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(screen, "folds", lambda: True)
        shown = screen.screen(parts)
    assert shown.count("\n") + 1 <= ROWS
    if sum(sizes) + len(sizes) <= ROWS:
        assert shown == "\n\n".join(part for part in parts if part)


def test_a_pipe_gets_all_of_a_result(campaign_ran: Ran) -> None:
    whole = results_text(campaign_ran.results)
    assert not MORE.search(whole)
    assert len(whole.split("\n")) > ROWS
    for reason in missing_of(campaign_ran.results["results"]):
        assert reason.split()[0] in whole


def test_a_terminal_gets_a_screen_and_the_reasons_counted(campaign_ran: Ran, monkeypatch: pytest.MonkeyPatch) -> None:
    on_terminal(monkeypatch)
    rows = campaign_ran.results["results"]
    shown = results_text(campaign_ran.results)
    assert shown.count("\n") < ROWS
    assert MORE.search(shown)
    tables, counted = results_parts(campaign_ran.results)
    assert "not estimated: " not in tables
    counts = [int(n) for n in re.findall(r"not estimated: (\d+) figure", counted)]
    assert counts == sorted((len(found) for found in missing_of(rows).values()), reverse=True)[: len(counts)]
    with shown_whole(True):
        assert results_text(campaign_ran.results).count("\n") > ROWS


def test_colours_where_the_terminal_has_them(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = on_terminal(monkeypatch)
    say("overall: FAIL\nR1  PASS  PASSAGE")
    assert terminal.text() == "overall: \N{BALLOT X} \x1b[31mFAIL\x1b[0m\nR1  \x1b[32mPASS\x1b[0m  PASSAGE\n"
    on_terminal(monkeypatch, "ascii")
    assert coloured("overall: PASS") == "overall: \x1b[32mPASS\x1b[0m"


@pytest.mark.parametrize(("name", "value"), [("NO_COLOR", "1"), ("TERM", "dumb"), ("TERM", "")])
def test_no_colours_where_they_are_not_wanted(name: str, value: str, monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = on_terminal(monkeypatch)
    monkeypatch.setenv(name, value)
    say("overall: PASS")
    assert terminal.text() == "overall: PASS\n"


def test_no_colours_in_a_pipe(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TERM", "xterm")
    say("overall: PASS")
    assert capsys.readouterr().out == "overall: PASS\n"


@pytest.fixture
def record(tmp_path: Path) -> str:
    rng, t = np.random.default_rng(8), np.arange(400.0)
    x = 3.0 * np.sin(2.0 * np.pi * t / 20.0) + rng.standard_normal(400)
    np.savetxt(tmp_path / "a.csv", np.column_stack([t, x]), "%.6f", ",", header="time [s],acc_x [ug]", comments="")
    return str(tmp_path / "a.csv")


def test_a_plot_in_text_and_in_a_viewer(
    record: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    opened: list[Path] = []
    monkeypatch.setattr(opening, "open_file", opened.append)
    monkeypatch.setattr(figures, "encodes_braille", lambda: False)
    with pytest.raises(SystemExit) as left:
        main(["sine", record, "--period", "20 s", "-q", "--plot", "--show"])
    shown = capsys.readouterr().out
    assert left.value.code == 0
    assert "amplitude" in shown
    assert shown.isascii() or "*" in shown
    assert [path.name for path in opened] == ["figure.png"]
    assert opened[0].read_bytes()[:4] == b"\x89PNG"


def test_a_plot_and_json_are_refused(record: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        main(["sine", record, "--period", "20 s", "--plot", "--json"])
    assert left.value.code == 2
    assert "stands alone" in capsys.readouterr().out

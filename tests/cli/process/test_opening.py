"""A page is opened in a browser where there is a screen; elsewhere a line says which file to open."""

from __future__ import annotations

import webbrowser
from pathlib import Path

import pytest

from inertialcal.cli import opening


def test_a_browser_gets_the_address_of_the_file(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    asked: list[str] = []
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr(webbrowser, "open", lambda address: not asked.append(address))  # type: ignore[func-returns-value]
    assert opening.open_file(tmp_path / "a b.html")
    assert asked == [(tmp_path / "a b.html").as_uri()]


def test_without_a_screen_a_line_names_the_file(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in opening.SCREENS:
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr("sys.platform", "linux")
    assert not opening.open_file(Path("out/report.html"))
    assert capsys.readouterr().err == "nothing here can show it: open out/report.html yourself\n"


def test_a_browser_that_fails_is_no_error(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def refuse(address: str) -> bool:
        raise webbrowser.Error(address)

    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr(webbrowser, "open", refuse)
    assert not opening.open_file(Path("report.html"))
    assert "open report.html yourself" in capsys.readouterr().err

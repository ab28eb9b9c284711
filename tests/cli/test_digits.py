"""``--digits``: the figures of tables with as many digits as asked for; JSON, remarks and defaults stay as they are."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import inertialcal as ic
from inertialcal.cli.__main__ import main
from inertialcal.cli.commands import NO_FIGURES, OF_ARCHIVE, OfArchive, Planners, Root
from inertialcal.core.show.rounding import digits_shown, near, settled, settled_number


def typed(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[Any, str, str]:
    with pytest.raises(SystemExit) as left:
        main(list(words))
    return left.value.code, *capsys.readouterr()


@pytest.fixture
def record(tmp_path: Path) -> str:
    rng, t = np.random.default_rng(8), np.arange(400.0)
    x = 3.0 * np.sin(2.0 * np.pi * t / 20.0) + rng.standard_normal(400)
    np.savetxt(tmp_path / "a.csv", np.column_stack([t, x]), "%.6f", ",", header="time [s],acc_x [ug]", comments="")
    return str(tmp_path / "a.csv")


def test_figures() -> None:
    usual = settled(1.0012471234, 0.000418), settled_number(2.5, 3), near(979.0512, 0.724)
    assert usual == ("1.00125 ± 0.00042", "2.5", "979.051")
    with digits_shown("4"):
        assert (settled(1.0012471234, 0.000418), settled_number(2.0 / 3.0, 2)) == ("1.001 ± 0.000418", "0.6667")
    with digits_shown("full"):
        assert settled(2.0 / 3.0, None) == repr(2.0 / 3.0)
        assert (settled_number(3.0), settled(None, None)) == ("3", "-")
    assert (settled(1.0012471234, 0.000418), settled_number(2.5, 3), near(979.0512, 0.724)) == usual


def test_full_is_what_json_holds(record: str, capsys: pytest.CaptureFixture[str]) -> None:
    words = ("sine", record, "--period", "20 s", "--phase", "0 deg")
    plain, full = typed(capsys, *words)[1], typed(capsys, *words, "--digits", "full")[1]
    row = ic.sine(record, period="20 s", phase="0 deg").rows[0]
    assert row.interval
    for value in (row.value, row.u, row.interval.lo, row.interval.hi):
        assert repr(value) in full
        assert repr(value) not in plain
    assert plain.splitlines()[-2:] == full.splitlines()[-2:]  # remarks
    one, other = (json.loads(typed(capsys, *words, "--json", *more)[1]) for more in ((), ("--digits", "full")))
    assert one == other
    assert typed(capsys, *words)[1] == plain


def test_plan(capsys: pytest.CaptureFixture[str]) -> None:
    body = ("plan", "mass-attraction", "--set", "body.stand_off=7.6 cm", "--set", "body.cube=5.08 cm", "--set",
            "body.count=20")  # fmt: skip
    found = re.search(r"attraction +face at 7.6 cm +(\S+) +ng", typed(capsys, *body, "--digits", "12")[1])
    assert found
    assert len(found[1].replace(".", "")) == 12


@pytest.mark.usefixtures("undrawn")
def test_show(record: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = ic.sine(record, period="20 s", phase="0 deg")
    found.write_campaign(tmp_path / "c")
    assert typed(capsys, "run", str(tmp_path / "c"), "-q")[0] == 0
    status, shown, _ = typed(capsys, "show", str(tmp_path / "c" / "out"), "--digits", "full")
    assert (status, repr(found.rows[0].value) in shown) == (0, True)


@pytest.mark.parametrize("said", ["0", "18", "-3", "many", "2.5"])
def test_refused(record: str, capsys: pytest.CaptureFixture[str], said: str) -> None:
    status, _, error = typed(capsys, "sine", record, "--period", "20 s", "--digits", said)
    assert (status, "Give 1 to 17 significant digits, or full" in error) == (2, True)


def test_every_command_with_figures_has_the_option() -> None:
    root, plans = Root(), Planners()
    commands = {word: root.get_command(None, word) for word in root.names() if word not in ("plan", "archive")}
    commands |= {f"archive {word}": OfArchive(name="archive").get_command(None, word) for word in OF_ARCHIVE}
    commands |= {f"plan {word}": plans.get_command(None, word) for word in plans.names()}
    without = [
        word for word, one in commands.items()
        if one is not None and not any("--digits" in parameter.opts for parameter in one.params)
    ]  # fmt: skip
    assert set(without) == set(NO_FIGURES)

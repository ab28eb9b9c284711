"""The table of faults: each acts, on each procedure that it names; the runner counts what the commands say."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import inertialcal

from .case import Case
from .faults import spoiled
from .gate import ALL, BASES, Result, failures, lines, main, tried_lines
from .records.bases import SHARED
from .records.clean import CODES, KINDS
from .trial import tried

PAIRS = [(fault.name, on) for fault, on in lines()]


@pytest.fixture(scope="module")
def clean() -> dict[str, Case]:
    """One clean case of each procedure, made when it is needed."""

    class Made(dict[str, Case]):
        def __missing__(self, on: str) -> Case:
            return self.setdefault(on, BASES[on](1))

    return Made()


def written(case: Case) -> dict[str, object]:
    """Return what a case would write: its columns to the last bit, and how they are written."""
    found: dict[str, object] = dict(case.texts) | {"words": case.words}
    for name, table in case.tables.items():
        columns = [
            (one, values.tobytes() if values.dtype != object else list(values)) for one, values in table.columns.items()
        ]
        found[name] = (columns, table.separator, table.rows is None, table.pad)
    return found


@pytest.mark.parametrize(("name", "on"), PAIRS)
def test_a_fault_spoils_a_copy_and_says_which_file(name: str, on: str, clean: dict[str, Case]) -> None:
    before = written(clean[on])
    bad = spoiled(clean[on], ALL[name])
    assert written(bad) != before, "nothing was spoiled"
    assert written(clean[on]) == before, "the clean case was spoiled too"
    assert written(spoiled(clean[on], ALL[name])) == written(bad), "the same seed, another fault"
    if name not in ("zero_u", "v_stated_zero"):
        assert bad.spoiled


def test_codes_of_the_issue_exist_in_the_product() -> None:
    source = "\n".join(path.read_text(encoding="utf-8") for path in Path(inertialcal.__file__).parent.rglob("*.py"))
    quoted = set(re.findall(r'"([a-z_]+)"', source))
    named = {code for fault in ALL.values() if fault.expects == "named" for code in fault.codes}
    of_kind = {code for code in CODES if code.startswith("impossible_")}  # made of the kind of unit
    assert named - of_kind <= quoted
    assert CODES - of_kind <= quoted
    assert {code for fault in ALL.values() if fault.issue and fault.expects == "named" for code in fault.codes} <= CODES


def test_an_unknown_procedure_is_refused(clean: dict[str, Case]) -> None:
    with pytest.raises(ValueError, match="is for thermal"):
        spoiled(clean["flip"], "temperature_hot")


def test_the_runner_counts_a_fault_that_is_noticed_today() -> None:
    (found,) = tried_lines("mass_attraction", 1, [ALL["slip"]])
    assert (found.verdict, found.exit, found.model, found.codes) == ("named", 3, False, ["schedule_slip"])


def test_a_run_that_was_stopped_goes_on(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["--line", "slip", "--jobs", "1", "--keep", str(tmp_path / "cases.jsonl")]
    assert main([*words, "--n", "1"]) == 0
    assert "1 cases, 1 jobs" in capsys.readouterr().out
    assert main([*words, "--n", "2", "--resume"]) == 0
    out = capsys.readouterr().out
    assert "2 cases, 1 jobs" in out
    assert "|  | slip | mass_attraction | - | 2 | 0 | 0 | 0 |  | 3x2 |" in out


def test_a_line_fails_below_57_of_60_and_clean_records_above_9_of_900() -> None:
    cases = [Result("glitch", "flip", n, "named" if n > 2 else "silent", 0, False) for n in range(60)]
    clean = [Result("white", "", n, "alarm" if n < 9 else "clean", 0, False) for n in range(900)]
    assert failures([*cases, *clean]) == []
    cases[10:11] = [Result("glitch", "flip", 10, "other", 3, False)]
    clean[10:11] = [Result("white", "", 10, "refused", 3, False)]
    assert failures([*cases, *clean]) == [
        "glitch on flip: 56 of 60", "clean records: 10 false alarms and refusals of 900",
    ]  # fmt: skip


def test_clean_records_are_900() -> None:
    real = sum(kind.number for kind in KINDS if kind.name.startswith("real"))
    assert sum(kind.number for kind in KINDS) - real == 780
    assert real == (120 if SHARED.is_dir() else 0)


def test_a_clean_case_gives_what_it_gave(clean: dict[str, Case]) -> None:
    assert tried(clean["mass_attraction"]).rows == tried(clean["mass_attraction"]).rows

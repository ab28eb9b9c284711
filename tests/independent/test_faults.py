"""The table of faults: each acts, on each procedure that it names, and its codes exist or are marked as proposed."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import inertialcal

from .case import Case
from .faults import FAULTS, PROPOSED, spoiled
from .trial import BASES, measured, shown, tried

PAIRS = [(name, on) for name, fault in FAULTS.items() for on in fault.on]


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
    bad = spoiled(clean[on], name)
    assert written(bad) != before, "nothing was spoiled"
    assert written(clean[on]) == before, "the clean case was spoiled too"
    assert written(spoiled(clean[on], name)) == written(bad), "the same seed, another fault"
    if name != "zero_u":
        assert bad.spoiled


def test_codes_exist_in_the_product_or_are_proposed() -> None:
    """Once a proposed code is built, take it out of PROPOSED."""
    source = "\n".join(path.read_text(encoding="utf-8") for path in Path(inertialcal.__file__).parent.rglob("*.py"))
    quoted = set(re.findall(r'"([a-z_]+)"', source))
    used = {code for fault in FAULTS.values() if fault.expects == "named" for code in fault.codes}
    assert used - PROPOSED <= quoted, "marked as built, and not there"
    assert used >= PROPOSED, "proposed for no fault"
    assert not PROPOSED & quoted, "built: no proposal any more"


def test_an_unknown_procedure_is_refused(clean: dict[str, Case]) -> None:
    with pytest.raises(ValueError, match="is for thermal"):
        spoiled(clean["flip"], "temperature_hot")


def test_the_runner_counts_a_fault_that_is_noticed_today() -> None:
    line = measured(FAULTS["slip"], "mass_attraction", 2, {})
    assert line.verdicts["named"] == 2
    assert line.exits == {3: 2}
    assert "| slip | mass_attraction | schedule_slip | 2 | 0 | 0 | 0 | 3x2 |" in shown([line])


def test_a_clean_case_gives_what_it_gave(clean: dict[str, Case]) -> None:
    assert tried(clean["mass_attraction"]).rows == tried(clean["mass_attraction"]).rows

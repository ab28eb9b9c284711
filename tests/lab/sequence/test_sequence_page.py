"""The page of the command: every key of ``[sequence]`` with its default, and the file that it shows."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from inertialcal.core.schema.quantities import Strict
from inertialcal.core.schema.toml import parse_toml
from inertialcal.lab.acquisition.lab_file import LabFile
from inertialcal.lab.sequence.entries import RecordEntry, ScheduleEntry, SequenceEntry, SequenceStepEntry, StableEntry

PAGE = (Path(__file__).resolve().parents[3] / "docs" / "commands" / "sequence.md").read_text(encoding="utf-8")
TABLES: dict[str, type[Strict]] = {
    "### `[sequence]`": SequenceEntry, "### `[[sequence.steps]]`": SequenceStepEntry, "### `stable`": StableEntry,
    "### `record`": RecordEntry, "### `[sequence.schedule]`": ScheduleEntry,
}  # fmt: skip


@pytest.mark.parametrize("mark", TABLES)
def test_every_key_is_documented_with_its_default(mark: str) -> None:
    below = PAGE.partition(f"\n{mark}\n")[2]
    lines = [line for line in re.split(r"\n#+ ", below)[0].splitlines() if line.startswith("| `")]
    table = {key: line for line in lines for key in re.findall(r"`([^`]+)`", line.split("|")[1])}
    fields = {one.alias or name: one for name, one in TABLES[mark].model_fields.items()}
    assert set(table) == set(fields)
    for key, one in fields.items():
        if isinstance(one.default, int | float):
            assert f"`{one.default}`" in table[key]


def test_the_file_that_it_shows_is_read() -> None:
    (text,) = re.findall(r"```\{code-block\} toml\n:caption: LAB.toml\n\n(.*?)```", PAGE, re.DOTALL)
    file = LabFile.model_validate(parse_toml(text.encode(), "LAB.toml")[1])
    assert file.sequence is not None
    assert [step.set for step in file.sequence.steps] == [{"table.rate": "0 deg/s"}, {"table.rate": "10 deg/s"}]
    assert file.sequence.steps[0].record is not None
    assert file.sequence.steps[0].record.u == "0.0005 deg/s"

"""The page on LAB.toml: every key, its default and its words, and the files that it shows."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Literal, get_args, get_origin

import pytest

from inertialcal.core.schema.quantities import Strict
from inertialcal.lab.acquisition.lab_file import InstrumentEntry, LabEntry, StepEntry, load_lab
from inertialcal.lab.instruments.dialect import CommandsEntry, Dialect, FieldEntry, FrameEntry, SettingEntry, built_in
from inertialcal.lab.instruments.links import LINKS

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "lab.md").read_text(encoding="utf-8")
TABLES: dict[str, type[Strict]] = {
    "## `[lab]`": LabEntry, "## `[instruments.NAME]`": InstrumentEntry, "## `[[steps]]`": StepEntry,
    "## Dialect": Dialect, "### Frame": FrameEntry, "### Fields": FieldEntry,
}  # fmt: skip


def rows(mark: str) -> dict[str, list[str]]:
    """Return the cells of the table under a heading, by key."""
    _, _, below = PAGE.partition(f"\n{mark}\n")
    found: dict[str, list[str]] = {}
    for line in re.split(r"\n#+ ", below)[0].splitlines():
        if line.startswith("| `"):
            cells = [cell.strip() for cell in line.split("|")[1:-1]]
            found |= dict.fromkeys(re.findall(r"`([^`]+)`", cells[0]), cells)
    return found


def words(annotation: Any) -> Iterator[str]:
    if get_origin(annotation) is Literal:
        yield from (str(one) for one in get_args(annotation))
    for part in get_args(annotation):
        yield from words(part) if get_origin(annotation) is not Literal else ()


@pytest.mark.parametrize("mark", TABLES)
def test_every_key_is_documented_with_its_default_and_its_words(mark: str) -> None:
    table, fields = rows(mark), TABLES[mark].model_fields
    assert set(table) == set(fields)
    for key, field in fields.items():
        said = " ".join(table[key])
        for word in words(field.annotation):
            assert f"`{word}`" in said or word == "", f"{key}: {word}"
        plain = not isinstance(field.default, str) or field.default.isprintable()
        if isinstance(field.default, int | float | str) and plain and key not in ("answer", "error", "name"):
            value = f'"{field.default}"' if isinstance(field.default, str) else f"{field.default}"
            assert value in said or (key in ("scale", "offset") and "1, 0" in said), f"{key}: {value}"


def test_every_link_and_every_dialect_is_named() -> None:
    said = " ".join(rows("## `[instruments.NAME]`")["link"])
    assert set(re.findall(r"`(\w+)`", said)) - {"link"} == set(LINKS.built_in)
    assert {*rows("## What moves")} >= set(built_in())
    for model in (CommandsEntry, SettingEntry):
        assert all(f"`{key}`" in PAGE for key in model.model_fields)


def test_the_files_that_it_shows_are_read(tmp_path: Path) -> None:
    shown = re.findall(r"```\{code-block\} toml\n:caption: (\S+)\n\n(.*?)```", PAGE, re.DOTALL)
    assert [name for name, _ in shown] == ["LAB.toml", "imu.toml"]
    for name, text in shown:
        (tmp_path / name).write_text(text)
    lab = load_lab(tmp_path / "LAB.toml")
    assert sorted(lab.dialects) == ["imu", "table"]
    assert [step.hold for step in lab.steps] == [600.0, 120.0]
    layout = lab.dialects["imu"].layout
    assert layout is not None
    assert layout.dtype.itemsize == 14
    assert "20 bytes" in lab.dialects["imu"].title  # 2 of sync, 14, 2 of a pad, 2 of a checksum

"""Lines of keys: every path of the parsed document is found, on the line where it stands."""

from __future__ import annotations

import tomllib
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from inertialcal.core.schema.toml import key_lines, nearest_line

TEXT = '''\
schema = 1  # a comment with = and [brackets]
[campaign]
id = "a # b"
"quoted key" = 'it is'

[sensors.suite]
axes = [
  "x",  # first
  "y",
]
chain = { kind = "adc", lsb = "5 V / 4095", counts = [0, 4095] }
a.b.c = 1
[[tests]]
id = "one"
text = """
[not a table]
id = "not a key"
"""
[tests.plan]
axis = "x"
[[tests]]
id = "two"
when = 2010-04-28T15:10:00Z
windows = [["a", "b"],
  ["c", "d"]]
'''


def test_lines_of_a_document_with_everything() -> None:
    lines = key_lines(TEXT)
    assert lines[("schema",)] == 1
    assert lines[("campaign", "id")] == 3
    assert lines[("sensors", "suite")] == 6
    assert lines[("sensors", "suite", "axes", 1)] == 9
    assert lines[("sensors", "suite", "chain", "counts", 1)] == 11
    assert lines[("sensors", "suite", "a", "b", "c")] == 12
    assert lines[("tests", 0, "text")] == 15
    assert lines[("tests", 0, "plan", "axis")] == 20
    assert lines[("tests", 1)] == 21
    assert lines[("tests", 1, "windows", 1, 0)] == 25


def test_nearest_line_goes_up_to_what_stands_there() -> None:
    lines = key_lines(TEXT)
    assert nearest_line(lines, ("tests", 1, "plan", "axis")) == 21
    assert nearest_line(lines, ("nowhere",)) is None


def paths(value: Any, path: tuple[str | int, ...] = ()) -> list[tuple[str | int, ...]]:
    found = [path] if path else []
    if isinstance(value, dict):
        return found + [p for name, inner in value.items() for p in paths(inner, (*path, name))]
    if isinstance(value, list):
        return found + [p for i, inner in enumerate(value) for p in paths(inner, (*path, i))]
    return found


KEYS = st.text("abcdefgh_-", min_size=1, max_size=4)
SCALARS = st.one_of(
    st.integers(0, 999).map(str), st.text("ab#=[]{},' ", max_size=8).map(lambda s: f'"{s}"'), st.just("true")
)
VALUES = st.recursive(
    SCALARS,
    lambda inner: st.one_of(
        st.lists(inner, max_size=3).map(lambda parts: "[\n" + ",\n".join(parts) + "]"),
        st.dictionaries(KEYS, inner, max_size=3).map(
            lambda pairs: "{" + ", ".join(f"{k} = {v}" for k, v in pairs.items()).replace("\n", " ") + "}"
        ),
    ),
    max_leaves=6,
)


@given(
    st.dictionaries(KEYS, VALUES, min_size=1, max_size=5),
    st.lists(st.dictionaries(KEYS, VALUES, max_size=3), max_size=3),
)
def test_every_path_of_any_document_has_a_line(top: dict[str, str], tables: list[dict[str, str]]) -> None:
    lines = [f"{key} = {value}" for key, value in top.items()]
    for table in tables:
        lines += ["[[zz_table]]", *(f"{key} = {value}" for key, value in table.items())]
    text = "\n".join(lines) + "\n"
    document = tomllib.loads(text)
    found = key_lines(text)
    missing = [path for path in paths(document) if path not in found]
    assert not missing
    rows = text.splitlines()
    for key in top:
        assert rows[found[(key,)] - 1].startswith(f"{key} =")


@given(st.text(max_size=200))
def test_no_text_stops_the_scanner(text: str) -> None:
    try:
        tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError):
        return
    key_lines(text)

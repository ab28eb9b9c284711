"""TOML that people read: any document comes back from the parser, and lines fit the page."""

import tomllib
from collections.abc import Mapping

from hypothesis import given
from hypothesis import strategies as st

from inertialcal.core.campaign_text import WIDTH, Noted, toml_text

TEXTS = st.text(st.characters(exclude_categories=["Cs"]), max_size=20)
PLAIN = TEXTS | st.integers(-(2**53), 2**53) | st.floats(allow_nan=False) | st.booleans()
VALUES = st.recursive(
    PLAIN, lambda inner: st.lists(inner, max_size=5) | st.dictionaries(TEXTS.filter(bool), inner, max_size=4)
)
TABLE = st.dictionaries(TEXTS.filter(bool), VALUES, max_size=5)
DOCUMENT = st.fixed_dictionaries(
    {"schema": st.just(1), "site": TABLE, "sensors": st.dictionaries(TEXTS.filter(bool), TABLE, max_size=3)},
    optional={"tests": st.lists(TABLE, min_size=1, max_size=3)},
)


def without_empty_tables(document: Mapping[str, object]) -> dict[str, object]:
    return {key: value for key, value in document.items() if value != {}}


@given(DOCUMENT)
def test_a_document_comes_back(document: dict[str, object]) -> None:
    found = tomllib.loads(toml_text(document))
    assert without_empty_tables(found) == without_empty_tables(document)


def test_comments_examples_and_long_values() -> None:
    channels = {axis: {"column": f"a long name of a column {axis}", "unit": "deg/s"} for axis in "xyz"}
    document = {
        "schema": Noted(1, above="Head"),
        "standards": Noted({"table": Noted({"rate": {"u": "1 %"}}, example=True)}, above="Standards"),
        "sensors": {"suite": {"unit": Noted("?", "FILL IN"), "range": Noted(["1", "2"], example=True)}},
        "recordings": {"a": {"file": "a.csv", "channels": channels}},
        "tests": [Noted({"names": [f"recording_{i}" for i in range(12)], "plan": {"axis": Noted("x", "?")}}, "why")],
        "requirements": [Noted({"id": "R1"}, example=True)],
    }
    text = toml_text(document)
    assert all(len(line) <= WIDTH for line in text.splitlines())
    assert text.startswith(
        "# Head\nschema = 1\n\n# Standards\n# [standards.table]\n# rate = { u = \"1 %\" }\n\n"
        '[sensors.suite]\nunit = "?"  # FILL IN\n# range = ["1", "2"]\n\n[recordings.a]\nfile = "a.csv"\n\n'
        "[recordings.a.channels]\nx = "
    )  # fmt: skip
    assert '[[tests]]  # why\nnames = [\n  "recording_0", ' in text
    assert text.endswith('\n]\n\n[tests.plan]\naxis = "x"  # ?\n\n# [[requirements]]\n# id = "R1"\n')
    assert tomllib.loads(text)["tests"][0]["plan"] == {"axis": "x"}

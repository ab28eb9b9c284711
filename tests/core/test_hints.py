"""Hints are obeyed: none names a quantity that was not computed from what was given."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import inertialcal

SOURCE = Path(inertialcal.__file__).parent
QUANTITY = re.compile(r"""["'= ][+-]?\d[\d.e+-]* ?(deg|deg/s|s|min|h|m|cm|%|g|ug|V|Hz|degC|m/s2|cm3)\b["' }]""")
FORMS = ("Write", "Like", "Name a column")  # how something is written, not what it is
SAID = {
    ' s" for means, --averaging "0 s" for points',  # means over no time
    "Give the schedule, or the phase: 90 deg if samples fall on the extremes",  # of two samples a period
}


def hints(path: Path) -> Iterator[str]:
    """Yield the fixed parts of all texts that say what to do."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.keyword) and node.arg == "do":
            value: ast.expr | None = node.value
        elif isinstance(node, ast.Assign) and any(isinstance(one, ast.Name) and one.id == "do" for one in node.targets):
            value = node.value
        else:
            continue
        if value is None:
            continue
        texts = [one.value for one in ast.walk(value) if isinstance(one, ast.Constant) and isinstance(one.value, str)]
        if not any(text.startswith(FORMS) or " like " in text for text in texts):
            yield from texts


def test_no_hint_has_a_fixed_quantity() -> None:
    fixed = [
        f"{path.name}: {text}"
        for path in sorted(SOURCE.rglob("*.py"))
        for text in hints(path)
        if QUANTITY.search(text) and text not in SAID
    ]
    assert not fixed

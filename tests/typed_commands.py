"""Commands as they are typed: exit status, what was printed, and the object of ``--json``."""

from __future__ import annotations

import json
from typing import Any

import pytest

from inertialcal.cli.__main__ import main
from inertialcal.core.schema.results import Printed


def call(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, str, str]:
    """Return exit status, output and messages of a command; never a traceback."""
    with pytest.raises(SystemExit) as left:
        main(list(words))
    out, err = capsys.readouterr()
    assert "Traceback" not in out + err
    return int(left.value.code or 0), out, err


def call_json(capsys: pytest.CaptureFixture[str], *words: str) -> dict[str, Any]:
    """Return the object that a command prints; it says the exit status too, and keeps the published schema."""
    status, out, _ = call(capsys, *words, "--json")
    Printed.model_validate_json(out)
    content: dict[str, Any] = json.loads(out)
    assert content["exit"] == status
    return content

"""Commands as they are typed: exit status, output, ``--json``; the same rows from Python and from a campaign."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pytest

import inertialcal
from inertialcal.campaign.calls.call import Reduced
from inertialcal.campaign.engine.run import run
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


def option_text(settings: Mapping[str, Any]) -> list[str]:
    """Return settings as options."""
    names = {"start": "from", "stop": "to", "columns": "column", "units": "unit", "standards": "standard"}
    names |= {"positions": "position", "windows": "window"}
    words: list[str] = []
    for name, value in settings.items():
        option = f"--{names.get(name, name).replace('_', '-')}"
        if isinstance(value, bool):
            words.append(option if value else f"--no-{option[2:]}")
        elif isinstance(value, Mapping):
            for key, one in value.items():
                words += [option, f"{key}={one}" if key else str(one)]
        else:
            for one in value if isinstance(value, list | tuple) else [value]:
                words += [option, str(one)]
    return words


def same_rows(
    capsys: pytest.CaptureFixture[str], word: str, files: Sequence[Path], folder: Path, **settings: Any
) -> Reduced:
    """Assert that the three ways in agree; return what Python found."""
    found: Reduced = getattr(inertialcal, word.replace("-", "_"))(list(files), **settings)
    status, out, err = call(capsys, word, *map(str, files), *option_text(settings), "--json", "--campaign", str(folder))
    assert status == 0, err
    rows = [json.loads(json.dumps(row.to_dict())) for row in found.rows]
    assert rows
    assert json.loads(out)["results"] == rows
    tests = {test["id"] for test in found.document["tests"]}
    outcome = run(folder)
    in_campaign = [row for row in json.loads(json.dumps(outcome.results["results"])) if row["test"] in tests]
    assert in_campaign == rows
    return found

"""Whether a command, Python and a campaign give the same rows of the same files, to the last bit."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pytest

import inertialcal
from inertialcal.campaign.calls.call import Reduced
from inertialcal.campaign.engine.run import run
from typed_commands import call


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

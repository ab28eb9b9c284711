"""The published schema of results: fresh, and kept by every example, every rig and every refusal of a wrong form."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from pydantic import ValidationError

from inertialcal.campaign.engine.run import run
from inertialcal.campaign.twins.twin import simulate
from inertialcal.core.schema.json_text import json_text
from inertialcal.core.schema.results import DRAFT, FILE, Results, schema_text
from inertialcal.rigs import RIGS

pytestmark = pytest.mark.usefixtures("undrawn")

EXAMPLES = Path(__file__).resolve().parents[2] / "src/inertialcal/examples"
LONG = [name for name in RIGS if name != "rate_table"]


def written(results: dict[str, Any]) -> str:
    return json_text({name: part for name, part in results.items() if name != "curves"})


def test_the_file_is_what_the_models_say() -> None:
    """Write it again with ``python -m inertialcal.core.schema.results``."""
    assert FILE.read_text(encoding="utf-8") == schema_text()
    schema = json.loads(schema_text())
    assert schema["$schema"] == DRAFT
    assert schema["properties"]["schema"]["const"] == 2
    assert set(schema["required"]) == set(schema["properties"])


@pytest.mark.parametrize("name", ["npsat2011", "reinel1969", "sams1996"])
def test_examples_keep_it(name: str) -> None:
    Results.model_validate_json(written(run(EXAMPLES / name, write=False).results))


@pytest.mark.parametrize("rig", ["rate_table", *(pytest.param(name, marks=pytest.mark.slow) for name in LONG)])
def test_rigs_keep_it(rig: str, tmp_path: Path) -> None:
    simulate(rig, tmp_path / rig, 1)
    run(tmp_path / rig)
    Results.model_validate_json((tmp_path / rig / "out/results.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize(
    "change",
    [{"condition": None}, {"method": "by_eye"}, {"quantity": 3}, {"more": 1}, {"at": "-20 degC"}, {"reason": "why"}],
)
def test_another_form_is_refused(change: dict[str, Any]) -> None:
    content = json.loads(written(run(EXAMPLES / "sams1996", write=False).results))
    content["results"][0] |= change
    with pytest.raises(ValidationError):
        Results.model_validate_json(json.dumps(content))

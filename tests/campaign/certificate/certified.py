"""Campaigns that were run and state what a certificate needs; the schemas of certificates, which may be absent."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from inertialcal.campaign.engine.run import run
from inertialcal.campaign.file.example import copy_example
from inertialcal.core.campaign_text import toml_text
from ran_campaigns import lossy_twin

NAMESPACES = {"dcc": "https://ptb.de/dcc", "si": "https://ptb.de/si", "ds": "http://www.w3.org/2000/09/xmldsig#",
              "svrl": "http://purl.oclc.org/dsdl/svrl"}  # fmt: skip
STATED: dict[str, Any] = {
    "number": "2026-014",
    "issued": "2026-11-28",
    "received": "2026-11-02",
    "performed": ["2026-11-03", "2026-11-20"],
    "laboratory": {"name": "Inertial Laboratory", "city": "Monterey", "country": "US"},
    "customer": {"name": "Small Satellite Office", "city": "Monterey", "country": "US"},
    "item_condition": "no visible damage, not adjusted",
    "methods": ["IEEE Std 1431-2004, 12.9"],
    "environment": "(23 +- 1) degC",
    "deviations": "none",
    "signatures": [{"name": "A. Person", "function": "head of laboratory"}],
}
EXAMPLES = ("npsat2011", "sams1996", "reinel1969")
CAMPAIGNS = (*EXAMPLES, "simulated", "small")
Stated = dict[str, Any]


def state(folder: Path, changes: Stated | None = None) -> Path:
    """Write [certificate] at the end of a campaign, in place of what stands there, and what [item] lacks."""
    path = folder / "campaign.toml"
    text = path.read_text(encoding="utf-8").partition("\n[certificate]")[0]
    text += toml_text({"certificate": STATED | (changes or {})})
    path.write_text(text, encoding="utf-8")
    return folder


def with_item(folder: Path) -> None:
    """Name the item in full, before a run."""
    path = folder / "campaign.toml"
    text = path.read_text(encoding="utf-8")
    known = dict(re.findall(r'^(maker|part|serial) = "(.*)"$', text, re.MULTILINE))
    lacking = [f'{name} = "of a test"' for name in ("maker", "part", "serial") if not known.get(name)]
    text = re.sub(r'^(maker|part|serial) = ""\n', "", text, flags=re.MULTILINE)
    if "[item]" not in text:
        text = text.replace("\n[sensors", "\n[item]\n[sensors", 1)
    path.write_text(text.replace("[item]\n", "\n".join(["[item]", *lacking, ""]), 1), encoding="utf-8")


def made(name: str, folder: Path, small: Callable[..., Path] | None = None) -> Path:
    """Return the folder of a campaign that was run, with its certificate stated."""
    if name == "simulated":
        folder.mkdir()
        lossy_twin(folder)
    elif name == "small":
        assert small is not None
        folder = small()
    else:
        folder = copy_example(name, folder)
    shutil.rmtree(folder / "out", ignore_errors=True)
    with_item(folder)
    run(folder)
    return state(folder)


@dataclass(frozen=True)
class Schemas:
    """Schema and Schematron of the DCC, compiled once."""

    schema: Any
    rules: Any

    def problems(self, xml: bytes) -> list[str]:
        """What the schema refuses."""
        from lxml import etree

        self.schema.validate(etree.fromstring(xml))
        return [str(one) for one in self.schema.error_log]

    def errors(self, path: Path, role: str = "error") -> list[str]:
        """What the Schematron calls an error, or a warning."""
        from lxml import etree

        found = etree.fromstring(self.rules(str(path)).encode())
        said = found.xpath("//svrl:failed-assert|//svrl:successful-report", namespaces=NAMESPACES)
        return [" ".join("".join(one.itertext()).split()) for one in said if one.get("role") == role]


def compiled(shared: Path, folder: Path) -> Schemas:
    """Return the schemas of a folder of others; the test is skipped, and says so, where they are absent."""
    source = shared / "schemas" / "dcc"
    if not (source / "dcc.xsd").is_file():
        pytest.skip(f"no schemas of the DCC: {source} is absent")
    etree = pytest.importorskip("lxml.etree")
    saxon = pytest.importorskip("saxonche")
    places = {"../dsi/v2.2.1.xsd": "SI_Format.xsd", "../qudt/v2.2.1.xsd": "qudt.xsd", "../xmldsig": "xmldsig"}
    for file in source.glob("*.xsd"):
        text = file.read_text(encoding="utf-8")
        for old, new in places.items():
            text = text.replace(f'schemaLocation="{old}', f'schemaLocation="{new}')
        (folder / file.name).write_text(text, encoding="utf-8")
    processor = saxon.PySaxonProcessor(license=False)
    sheet = processor.new_xslt30_processor().compile_stylesheet(stylesheet_file=str(source / "dcc.svrl"))
    return Schemas(
        etree.XMLSchema(etree.parse(str(folder / "dcc.xsd"))),
        lambda path: sheet.transform_to_string(source_file=path),
    )

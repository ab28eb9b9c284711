"""README as an index shows it: its links are relative to the repository, and an index page has no repository around it.

With ``INERTIALCAL_HOME`` (the address of the public repository) they lead to the files of this version there, and the
package states its addresses. Without it a link is its text alone, and a picture is left out: nothing leads nowhere.
"""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any

from hatchling.metadata.plugin.interface import MetadataHookInterface

LINK = re.compile(r"(!?)\[([^\]]*)\]\((?!https?://|#)([^)\s]+)\)")


class Readme(MetadataHookInterface):
    """Fills in ``readme`` and ``urls``, which pyproject.toml declares dynamic."""

    def update(self, metadata: dict[str, Any]) -> None:
        """Write both into the metadata of the package."""
        home = os.environ.get("INERTIALCAL_HOME", "").rstrip("/")
        text = (Path(self.root) / "README.md").read_text(encoding="utf-8")
        metadata["readme"] = {"content-type": "text/markdown", "text": for_an_index(text, home, metadata["version"])}
        changes = f"{home}/blob/v{metadata['version']}/CHANGELOG.md"
        metadata["urls"] = {"Source": home, "Changelog": changes, "Issues": f"{home}/issues"} if home else {}


def for_an_index(text: str, home: str, version: str) -> str:
    """Return the text with links that lead somewhere wherever it stands."""

    def absolute(link: re.Match[str]) -> str:
        picture, words, target = link.groups()
        if not home:
            return "" if picture else words
        return f"{picture}[{words}]({home}/{'raw' if picture else 'blob'}/v{version}/{target})"

    return LINK.sub(absolute, text)

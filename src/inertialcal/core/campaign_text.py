"""Words of campaign.toml that its writers and its reader share."""

from __future__ import annotations

import json

FILE = "campaign.toml"
MARK = "# FILL IN"  # at the end of a line that `init` could not fill in


def quoted(text: str) -> str:
    """Return a TOML string: JSON's escapes are TOML's."""
    return json.dumps(text, ensure_ascii=False)

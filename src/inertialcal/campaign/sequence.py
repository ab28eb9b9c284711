"""Sequence: the tests in the order in which they were run, with what each of them drew on."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..core.times import instant_text
from .engine import Prepared
from .exclusions import RULES, UNREAD
from .origins import Origin


def sequence_rows(prepared: Sequence[Prepared], exclusions: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return one row a test, in the order run.

    Parameters
    ----------
    prepared : sequence of Prepared
        Every test.
    exclusions : sequence of dict
        Of ``exclusion_rows``; a dwell that several sensors leave out counts once.
    """
    return [_row(one, exclusions) for one in prepared]


def _row(one: Prepared, exclusions: Sequence[dict[str, Any]]) -> dict[str, Any]:
    test = one.test
    out = {row["place"] for row in exclusions if row["test"] == test.id and row["rule"] in (*RULES, *UNREAD)}
    windows = [[instant_text(start), instant_text(stop)] for start, stop in test.windows or []]
    return {
        "test": test.id, "procedure": test.procedure, "use": test.use, "condition": test.condition,
        "source": test.source, "against": test.against, "after": list(test.after),
        "groups": test.groups, "windows": windows or None,
        "recordings": [_recording(origin) for origin in one.origins],
        "dwells": None if test.procedure == "thermal" else len(one.readings),
        "runs": getattr(one.readings, "runs", None), "left_out": len(out),
    }  # fmt: skip


def _recording(origin: Origin) -> dict[str, Any]:
    return {
        "name": origin.name, "file": origin.file, "sha256": origin.sha256, "kind": origin.kind, "rows": origin.rows,
    }  # fmt: skip

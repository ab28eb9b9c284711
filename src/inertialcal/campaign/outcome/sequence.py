"""Sequence: the tests in the order in which they were run, with what each of them drew on."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ...core.times import instant_text
from ...procedures import procedure_of
from ..engine.engine import Prepared
from ..inputs.sources import Origin
from .exclusions import LeftOut


def sequence_rows(prepared: Sequence[Prepared], exclusions: Sequence[LeftOut]) -> list[dict[str, Any]]:
    """Return one row a test, in the order run.

    Parameters
    ----------
    prepared : sequence of Prepared
        Every test.
    exclusions : sequence of LeftOut
        Of all tests; a dwell that several sensors leave out counts once.
    """
    return [_row(one, exclusions) for one in prepared]


def _row(one: Prepared, exclusions: Sequence[LeftOut]) -> dict[str, Any]:
    test = one.test
    out = {left.what.place for left in exclusions if left.test == test.id and left.what.dwell}
    windows = [[instant_text(start), instant_text(stop)] for start, stop in test.windows or []]
    return {
        "test": test.id, "procedure": test.procedure, "use": test.use, "condition": test.condition,
        "source": test.source, "against": test.against, "after": list(test.after),
        "groups": test.groups, "windows": windows or None,
        "recordings": [_recording(origin) for origin in one.origins],
        "dwells": len(one.readings) if procedure_of(test.procedure).counts_dwells else None,
        "runs": getattr(one.readings, "runs", None), "left_out": len(out),
    }  # fmt: skip


def _recording(origin: Origin) -> dict[str, Any]:
    return {
        "name": origin.name, "file": origin.file, "sha256": origin.sha256, "kind": origin.kind, "rows": origin.rows,
    }  # fmt: skip

"""Names of rigs and of their mistakes, as the shell completes them."""

from __future__ import annotations

import typer

from ..rigs import RIGS, titles


def rigs_beginning(incomplete: str) -> list[tuple[str, str]]:
    """Return the rigs whose name begins so, each with a line on it; none is loaded."""
    return [(name, title) for name, title in titles().items() if name.startswith(incomplete)]


def faults_beginning(ctx: typer.Context, incomplete: str) -> list[tuple[str, str]]:
    """Return the mistakes of the rig that was typed whose name begins so, each with what is wrong in it."""
    rig = str(ctx.params.get("rig", ""))
    faults = RIGS[rig].faults if rig in RIGS else {}
    return [(name, fault.what) for name, fault in faults.items() if name.startswith(incomplete)]

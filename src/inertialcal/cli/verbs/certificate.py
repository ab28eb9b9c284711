"""certificate: what a laboratory signs, of a campaign that was run."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ..options import Folder, Json, Quiet
from ..shown.output import json_out, wrapped


def certificate(
    folder: Folder,
    output: Annotated[Path, typer.Option("--output", "-o", help="File to write: .pdf or .xml.", show_default=False)],
    sign_key: Annotated[
        Path | None, typer.Option("--sign-key", help="Private key (PEM) that signs the XML.", show_default=False)
    ] = None,
    sign_certificate: Annotated[
        Path | None,
        typer.Option("--sign-certificate", help="Certificate (PEM) that belongs to the key.", show_default=False),
    ] = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Write the calibration certificate of a campaign: PDF to print and sign, or XML (DCC 3.3.0)."""
    from ...campaign.certificate.issue import certificate as issue

    made = issue(folder, output, sign_key, sign_certificate)
    if as_json:
        content = {
            "written": made.path,
            "sha256": made.sha256,
            "number": made.number,
            "traceable": made.traceable,
            "signed": made.signed,
            "warnings": list(made.warnings),
        }
        json_out("certificate", content)
    elif not quiet:
        head, *below = str(made).splitlines()
        print(wrapped(head))
        for line in below:
            print(wrapped(f"  {line.strip()}", "    "))
    return 0

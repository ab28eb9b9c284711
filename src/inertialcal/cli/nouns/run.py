"""What a noun does once its options are read: reduce, write, print."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...core.settings import Setting
from ...procedures.protocol import Command, Procedure
from .. import figures
from ..pairs import pairs
from ..shown.output import json_out


def run_noun(
    procedure: Procedure[Any, Any, Any], declared: Command, settings: Mapping[str, Setting], given: dict[str, Any]
) -> int:
    """Reduce files by a procedure, write what was asked for, print the figures; return the exit status."""
    from ...campaign.calls.call import call
    from ..shown.summary import closed_loop_text, print_reduced

    output, figure, axis, campaign, as_json, quiet = (
        given.pop(name) for name in ("output", "figure", "figure_axis", "campaign", "as_json", "quiet")
    )
    files, held_out = given.pop("files"), given.pop("hold_out", None) or []
    writes = output is not None and procedure.writes(output)
    if not writes:
        figures.check_figure(output, {"--figure": figure, "--figure-axis": axis})
    found = call(procedure.name, files, pairs_of(settings, given), held_out=held_out, options=True)
    written: dict[str, str] = {}
    if writes:
        written |= {path: f"written: {path}" for path in procedure.write(found, output)}
    elif output is not None:
        written[str(output)] = figures.write(output, found, files, {"figure": figure, "axis": axis}, most=3)
    if campaign is not None:
        path = str(found.write_campaign(campaign))
        written[path] = f"written: {path}"
    if as_json:
        content = {
            "inputs": [{"path": path, "sha256": digest} for path, digest in found.inputs.items()],
            "results": [row.to_dict() for row in found.rows],
            "remarks": [one.to_dict() for one in found.remarks],
            "columns": dict(found.columns),
            **procedure.content(found),
        }
        json_out(
            declared.word,
            content | ({"written": list(written)} if written else {}),
        )
    elif not quiet:
        own = procedure.report(found)
        if own is None:
            rows, remarks = ([one.to_dict() for one in every] for every in (found.rows, found.remarks))
            print_reduced(found.columns, rows, remarks)
            if held_out:
                print(closed_loop_text(found.results))
        else:
            print(own)
        for line in written.values():
            print(line)
    return 0


def pairs_of(settings: Mapping[str, Setting], given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the options that were given, NAME=VALUE by name; a value without a name stands under itself."""
    found = {name: value for name, value in given.items() if value is not None}
    for name, texts in found.items():
        one = settings[name]
        if one.pairs:
            named = [text for text in texts if "=" in text]
            bare = {text: text for text in texts if "=" not in text}
            found[name] = bare | pairs(named, f"--{one.option}", one.example)
    return found

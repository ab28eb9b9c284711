"""What a noun does once its options are read: reduce, write, print."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ...core.errors import StoreError, UsageError
from ...core.settings import Setting
from ...procedures.protocol import Command, Procedure, Reduced
from .. import figures
from ..options import pairs
from ..shown.output import clean, json_out

MOST = 3  # pictures of a noun, one below the other


def run_noun(
    procedure: Procedure[Any, Any, Any], declared: Command, settings: Mapping[str, Setting], given: dict[str, Any]
) -> int:
    """Reduce files by a procedure, write what was asked for, print the figures; return the exit status."""
    from ...campaign.calls.call import call
    from ..shown.screen import folded, say
    from ..shown.summary import closed_loop_text, print_reduced, remarks_text

    output, figure, axis, campaign, show, plot, as_json, quiet = (
        given.pop(name) for name in ("output", "figure", "figure_axis", "campaign", "show", "plot", "as_json", "quiet")
    )
    files, held_out = given.pop("files"), given.pop("hold_out", None) or []
    to = given.pop("for_format", None)
    form = _form(procedure, output, to)
    _check_output(form, output, {"--figure": figure, "--figure-axis": axis}, to, show or plot)
    figures.check_figure(None, {}, plot, plot and as_json)
    found = call(procedure.name, files, pairs_of(settings, given), held_out=held_out, options=True, word=declared.word)
    chosen = {"figure": figure or declared.figure or None, "axis": axis}
    exported, gone = found.exported(to) if to else ("", ())
    written = {} if output is None else _write(form, output, found, procedure, chosen, exported)
    if campaign is not None:
        path = str(found.write_campaign(campaign))
        written[path] = clean(f"written: {path}")
    if as_json:
        content = {
            "inputs": [{"path": path, "sha256": digest} for path, digest in found.inputs.items()],
            "results": [row.to_dict() for row in found.rows],
            "remarks": [one.to_dict() for one in (*found.remarks, *gone)],
            "columns": dict(found.columns),
            "verdicts": found.verdicts,
            **procedure.content(found),
        } | ({"models": {to: exported}} if to else {})
        json_out(declared.word, content | ({"written": list(written)} if written else {}), found.exit_status)
    elif not quiet:
        own = procedure.report(found)
        rows, remarks = ([one.to_dict() for one in every] for every in (found.rows, (*found.remarks, *gone)))
        if own is None:
            print_reduced(found.columns, rows, remarks, found=procedure.summary(found))
            if held_out:
                say(closed_loop_text(found.results))
        else:
            say("\n".join([folded(own), "", *remarks_text(remarks)]).rstrip())
        _say_verdicts(found)
        if exported and output is None:
            print(f"\n{exported.rstrip()}")
        for line in written.values():
            print(line)
    if plot:
        figures.print_plot(found, chosen, MOST)
    if show:
        figures.show_figure(output if form == "figure" else None, found, chosen, MOST)
    return found.exit_status


def _say_verdicts(found: Reduced) -> None:
    """Print what was asked of the figures, and the verdicts on it; nothing where nothing was."""
    from ..shown.screen import say
    from ..shown.summary import requirement_table, verdicts_part

    if found.verdicts:
        say("\n".join(["", verdicts_part(found.results), requirement_table(found.results)]))


def _form(procedure: Procedure[Any, Any, Any], output: Path | None, to: str | None) -> str:
    """Return what ``-o`` asks for: the models in a format; by its ending a figure, the models, or all into a folder."""
    if to:
        return "format"
    if output is not None and not output.suffix:
        return "folder"
    return "models" if output is not None and output.suffix.lower() == ".json" and procedure.makes_model else "figure"


def _check_output(form: str, output: Path | None, chosen: dict[str, str | None], to: str | None, drawn: bool) -> None:
    """Refuse what cannot be written, before anything is computed.

    Raises
    ------
    UsageError
        ``unsupported_format``; as `check_folder` and ``figures.check_figure``.
    """
    if form == "format":
        from ...files.models.formats import FORMATS

        if to not in FORMATS:
            do = f"Formats: {', '.join(FORMATS)}"
            raise UsageError(f"--for {to!r}: no such format", do=do, code="unsupported_format")
    elif form == "folder" and output is not None:
        check_folder(output, chosen["--figure"])
    elif form == "figure":
        figures.check_figure(output, chosen, drawn)


def _write(
    form: str, output: Path, found: Reduced, procedure: Procedure[Any, Any, Any], chosen: dict[str, str | None],
    exported: str = "",
) -> dict[str, str]:  # fmt: skip
    """Write what ``-o`` asks for; return a line a path."""
    if form == "format":
        from ...files.write.atomic import atomic_write

        with atomic_write(output, list(found.inputs)) as aside:
            aside.write_text(exported, encoding="utf-8", newline="\n")
        judged = all(one.judged for one in found.models.values())
        return {str(output): clean(f"written: {output} ({'judged' if judged else 'not judged'})")}
    if form == "figure":
        return {str(output): figures.write(output, found, list(found.inputs), chosen, MOST)}
    if form == "models":
        paths = [str(path) for path in found.write_models(output)]
    else:
        paths = write_folder(output, found, procedure.files(found), chosen["figure"] or "")
    return {path: clean(f"written: {path}") for path in paths}


def check_folder(folder: Path, figure: str | None) -> None:
    """Refuse a folder that cannot be one, before anything is computed.

    Raises
    ------
    UsageError
        If a figure is chosen, or the name is that of a file.
    """
    if figure is not None:
        raise UsageError(f"--figure {figure}: a folder takes all figures", do="Name a file: -o figure.png")
    if folder.exists() and not folder.is_dir():
        do = "Name a folder, or end the name with .png, .svg or .pdf for a single figure"
        raise UsageError(f"not a folder: {folder}", do=do, code="wrong_value")


def write_folder(folder: Path, found: Reduced, texts: Mapping[str, str], only: str) -> list[str]:
    """Write all figures, or all of one name, each test's axes side by side, and texts; return their paths.

    What does not fit on one file stands on a second.

    Raises
    ------
    StoreError
        If the folder cannot be written.
    """
    from ...files.write.atomic import atomic_write
    from ...report.figure_file import MOST as ON_A_FILE
    from ...report.figure_file import write_figure
    from ...report.figures import figures as all_figures

    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise StoreError(f"cannot make {folder}: {error.strerror}", code="not_writable") from None
    written = []
    for name, kind in all_figures().items():
        by_test: dict[str, list[Any]] = {}
        for picture in kind.pictures(found.results) if only in ("", name) else []:
            by_test.setdefault(picture.test, []).append(picture)
        for test, drawn in by_test.items():
            label = "".join(c if c.isalnum() and c.isascii() else "_" for c in test)
            for first in range(0, len(drawn), ON_A_FILE):
                part = f"_{first // ON_A_FILE + 1}" if first else ""
                written.append(folder / f"{name}_{label}{part}.png")
                write_figure(written[-1], drawn[first : first + ON_A_FILE], found.inputs)
    for name, content in texts.items():
        written.append(folder / name)
        with atomic_write(written[-1], found.inputs) as new:
            new.write_text(content, encoding="utf-8", newline="\n")
    return [clean(str(path)) for path in written]


def pairs_of(settings: Mapping[str, Setting], given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the options that were given, NAME=VALUE by name; a value without a name stands under itself.

    A table as a campaign has it, ``{ x = 32768 }``, is taken apart.
    """
    found = {name: value for name, value in given.items() if value is not None}
    for name, texts in found.items():
        one = settings[name]
        if one.pairs:
            every = [part for text in texts for part in _of_table(text)]
            named = [text for text in every if "=" in text]
            bare = {text: text for text in every if "=" not in text}
            found[name] = bare | pairs(named, f"--{one.option}", one.example)
    return found


def _of_table(text: str) -> list[str]:
    """Return the pairs of an inline table, or the text as it is."""
    if not text.strip().startswith("{"):
        return [text]
    try:
        return [f"{name}={value}" for name, value in tomllib.loads(f"table = {text}")["table"].items()]
    except tomllib.TOMLDecodeError:
        return [text]

"""show, compensate, export, convert, compare: commands that work on models and on what they are applied to."""

from __future__ import annotations

import inspect
import shlex
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ...core.errors import UsageError
from ...core.remarks import Remark
from ...files.models.formats import BUILT_IN
from .. import figures
from ..nouns.factory import said_of, said_options
from ..options import Json, Quiet, with_options
from ..shown.output import clean, followed, json_out, wrapped
from ..shown.screen import folded, say

if TYPE_CHECKING:
    from ...campaign.compare.compare import Comparison

Model = Annotated[
    Path,
    typer.Argument(help="model.json, the folder of a campaign, or a published one: flight_unit.", show_default=False),
]
Data = Annotated[Path, typer.Argument(help="Recording.", show_default=False)]
Output = Annotated[Path, typer.Option("--output", "-o", help="File to write.", show_default=False)]
Condition = Annotated[
    str | None,
    typer.Option("--condition", help="Condition of the model, where there are several: air.", show_default=False),
]


def show(
    model: Annotated[
        Path,
        typer.Argument(help="model.json, results.json, report.html, or the folder of a campaign.", show_default=False),
    ],
    output: figures.FigureFile = None,
    figure: figures.FigureName = None,
    open_figure: figures.Show = False,
    plot: figures.Plot = False,
    test: Annotated[str | None, typer.Option(help="Figure of results: of which test.")] = None,
    axis: Annotated[str | None, typer.Option(help="Figure of results: of which axis.")] = None,
    condition: Condition = None,
    tables: Annotated[
        bool, typer.Option("--tables", help="Summary and output of a campaign's suite, a table for each condition.")
    ] = False,
    orbit: Annotated[
        str | None, typer.Option(help='Whether the suite sees the rate of an orbit: "560 km".', show_default=False)
    ] = None,
    averaging: Annotated[str, typer.Option(help="Time over which --orbit averages a reading.")] = "100 s",
    latitude: Annotated[
        str | None,
        typer.Option(help='For --orbit: where an axis stands upright: "36.6 deg"; that of the campaign if not given.'),
    ] = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Show a model in words, results as a table, what a report is; with -o, a figure of a model or results."""
    from ...campaign.models.find import find_model
    from ...campaign.outcome.results_file import edited_since, find_results
    from ...report.page_file import find_page
    from ..opening import open_file
    from ..shown.summary import show_results

    figures.check_figure(
        output, {"--figure": figure, "--test": test, "--axis": axis}, open_figure or plot, plot and as_json
    )
    chosen = {"figure": figure, "test": test, "axis": axis}
    if tables or orbit:
        return _show_suite(model, condition, tables, orbit, (averaging, latitude), as_json, quiet)
    if (page := find_page(model)) is not None:
        if output is not None or plot:
            said = "--plot" if output is None else f"-o {output}"
            raise UsageError(f"{said}: a report gives no figure", do="Name results.json, or the folder")
        if open_figure:
            open_file(Path(page.path))
        return _show_page(page, as_json, quiet)
    edited = edited_since(model) if model.is_dir() else ()
    results = find_results(model, of_campaign=any(chosen.values()))
    if results is not None:
        status = show_results(results, edited, output, chosen, as_json, quiet)
        drawn: Any = results.content
    else:
        status = _show_model(model, condition, edited, output, chosen, as_json, quiet)
        drawn = find_model(model, condition).model if open_figure or plot else None
    if plot:
        figures.print_plot(drawn, chosen)
    if open_figure:
        figures.show_figure(output, drawn, chosen)
    return status


def _of_option(option: str, said: str, unit: str) -> float:
    """Return what an option says, in a unit; the refusal names the option."""
    from ...core.errors import DataError
    from ...core.units import parse_quantity

    try:
        return parse_quantity(said).to(unit)
    except DataError as error:
        (problem,) = error.problems
        what = f"{option} {said!r}: {problem.what}"
        raise DataError(what, why=problem.why, do=problem.do, code=problem.code) from None


def _show_suite(
    path: Path,
    condition: str | None,
    tables: bool,
    orbit: str | None,
    of_orbit: tuple[str, str | None],
    as_json: bool,
    quiet: bool,
) -> int:
    """Show the tables of a suite, and what it sees of an orbit."""
    from ...campaign.models.find import find_model
    from ...campaign.outcome.orbit_dwells import dwells_near, site_latitude
    from ...campaign.outcome.results_file import find_results
    from ...core.show.output_tables import output_tables
    from ...sensors.orbit_check import orbit_check
    from ..shown.model_text import orbit_dict, orbit_text
    from ..shown.summary import tables_text

    inputs: list[dict[str, str]] = []
    content: dict[str, Any] = {}
    blocks: list[str] = []
    averaging, latitude = of_orbit
    results = find_results(path, of_campaign=True)
    if tables:
        if results is None:
            raise UsageError(f"--tables: {path} holds no results", do="Name the folder of a campaign, or results.json")
        parts = (results.content[name] for name in ("sensors", "sequence", "results"))
        made = [one for one in output_tables(*parts) if condition in (None, one.condition)]
        inputs.append({"path": results.path, "sha256": results.sha256})
        content["tables"] = [one.to_dict() for one in made]
        blocks.append(tables_text(made) or "no gyro in this campaign")
    if orbit is not None:
        altitude, time = _of_option("--orbit", orbit, "m"), _of_option("--averaging", averaging, "s")
        found = find_model(path, condition)
        models = found.models.values() if condition is None else [found.model]
        run = None if results is None else results.content
        place = site_latitude(run, latitude)
        checks = [(one.condition, orbit_check(one, altitude, time, *place)) for one in models]
        recorded = [dwells_near(run, check, name) for name, check in checks]
        inputs.append(_input(found))
        content["orbit"] = [orbit_dict(check, name, near) for (name, check), near in zip(checks, recorded, strict=True)]
        blocks += [orbit_text(check, name, near) for (name, check), near in zip(checks, recorded, strict=True)]
    if as_json:
        json_out("show", {"inputs": inputs} | content)
    elif not quiet:
        say(folded("\n\n".join(blocks)))
    return 0


def _show_page(page: Any, as_json: bool, quiet: bool) -> int:
    if as_json:
        remarks = [remark.to_dict() for remark in page.remarks]
        json_out("show", {"inputs": [_input(page)], "remarks": remarks, "report": page.to_dict(), "unchanged": True})
    elif not quiet:
        _print_remarks(page.remarks)
        print(wrapped(f"{page.path}: report of campaign {page.campaign}, unchanged since it was written"))
        say(f"verdict: {clean(page.verdict or 'no requirement stated')}")
        print(wrapped(f"shows results.json, checksum {page.results or 'not given'}"))
        print(wrapped(f"shows model.json, checksum {page.model}") if page.model else "no model delivered")
    return 0


def _show_model(
    path: Path,
    condition: str | None,
    edited: Sequence[Remark],
    output: Path | None,
    chosen: dict[str, str | None],
    as_json: bool,
    quiet: bool,
) -> int:
    from ...campaign.models.compensation import model_rows
    from ...campaign.models.find import find_model
    from ...sensors.model.sensor_model import equation, lines
    from ...sensors.model.serial import to_dict
    from ..shown.model_text import model_text

    found = find_model(path, condition)
    remarks = (*edited, *found.remarks)
    shown = list(found.models.values()) if condition is None else [found.model]
    rows = [[row.to_dict() for row in model_rows(one)] for one in shown]
    line = "" if output is None else figures.write(output, found.model, [found.path], chosen)
    if as_json:
        each = [
            {
                "condition": one.condition,
                "equation": equation(one),
                "words": [{"name": line.name, "words": line.words, "origin": line.origin} for line in lines(one)],
                "judged": one.judged,
            }
            for one in shown
        ]
        content = {
            "inputs": [_input(found)],
            "remarks": [remark.to_dict() for remark in remarks],
            "results": [row for of_one in rows for row in of_one],
            "judged": all(one.judged for one in shown),
            "model": to_dict(found.models if condition is None else found.model),
        } | ({} if output is None else {"written": str(output)})
        content |= each[0] if len(each) == 1 else {"conditions": each}
        json_out("show", content)
    elif not quiet:
        _print_remarks(remarks)
        say(line or folded("\n\n".join(model_text(one, of_one) for one, of_one in zip(shown, rows, strict=True))))
    return 0


def _compensate(**given: Any) -> int:
    """Apply a model to a recording: true inputs in place of readings; time, gaps and other channels stay."""
    from ...campaign.calls.given import read_as_said
    from ...campaign.models.compensation import compensate as apply
    from ...campaign.models.compensation import settled_model
    from ...campaign.models.find import find_model, published
    from ...campaign.models.inputs import chain_columns, from_chain, taken
    from ...campaign.models.published import reading_steps
    from ...files.write.recording import write
    from ...sensors.catalogue import CATALOGUE

    said = said_of(given)
    model, output, temperature, steps, row, as_printed, as_json, quiet = (
        given[name] for name in ("model", "output", "temperature", "steps", "row", "as_printed", "as_json", "quiet")
    )
    _check_output(output, steps)
    columns: dict[str, str] = dict(said.columns)
    found, sensor = find_model(model, as_printed=as_printed), published(model)
    if steps and sensor is None:
        do = f"Name one of the catalogue: {', '.join(name for name, make in CATALOGUE.items() if make().equations)}"
        raise UsageError(f"--steps: {model} is no published model", do=do, code="no_steps")
    raw = read_as_said(given["data"], said, whole=True)
    inputs = [_input(found), {"path": raw.source.path, "sha256": raw.source.sha256}]
    listed: dict[str, Any] = {}
    if sensor is not None and steps:
        worked = reading_steps(sensor, raw, columns, row, as_printed)
        listed = {"row": row, "steps": [one.to_dict(found.model.axes) for one in worked]}
        _print_steps(found.model, raw, worked, row, quiet=as_json or quiet)
    if output is None:
        if as_json:
            json_out("compensate", {"inputs": inputs} | listed)
        return 0
    whose = settled_model(found.models, raw, columns, temperature, given["condition"])
    started = {} if whose.chain is None else chain_columns(whose.chain, raw, columns)
    raw, columns = from_chain(whose, raw, columns)
    about = {name: given[name] for name in ("serial", "uncertainty")}
    done = apply(whose, raw, columns, temperature=temperature, **about)
    chosen = taken(whose, raw, columns, temperature)
    remarks = [*done.remarks, *write(output, done)]
    used = (
        dict(chosen.columns)
        | started
        | ({} if chosen.temperature is None else {"temperature": f"{chosen.temperature:g} degC"})
    )
    more = {"columns": used, "condition": whose.condition, "compensated_by": done.compensated_by} | listed
    if as_json:
        _written("compensate", inputs, output, len(done), remarks, more)
    elif not quiet:
        print(wrapped("columns: " + ", ".join(f"{what} = {clean(name)}" for what, name in used.items())))
        print(wrapped(f"model of condition: {whose.condition}") + "\n" if whose.condition else "", end="")
        _print_written(output, len(done), remarks)
    return 0


def _check_output(output: Path | None, steps: bool) -> None:
    from ...files.write.recording import writer_for

    if output is not None:
        writer_for(output)
    elif not steps:
        raise UsageError("no file to write", do="Add -o FILE; or --steps, for a published model", code="missing_option")


def _print_steps(model: Any, raw: Any, worked: Any, row: int, quiet: bool) -> None:
    from ..shown.model_text import steps_text

    if not quiet:
        print(wrapped(f"{model.source}: row {row} of {len(raw)} of {raw.source.path}"))
        print(steps_text(worked, model.axes))


def _convert(**given: Any) -> int:
    """Write a recording in another format; numbers, units, time and gaps stay."""
    from ...campaign.calls.given import read_as_said, renamed
    from ...files.write.recording import write, writer_for

    said, target = said_of(given), given["target"]
    writer_for(target)
    recording = renamed(read_as_said(given["source"], said), said.columns)
    remarks = [*recording.remarks, *write(target, recording)]
    if given["as_json"]:
        inputs = [{"path": recording.source.path, "sha256": recording.source.sha256}]
        _written("convert", inputs, target, len(recording), remarks)
    elif not given["quiet"]:
        _print_written(target, len(recording), remarks)
    return 0


def export(
    model: Model,
    output: Annotated[
        Path, typer.Option("--output", "-o", help="File to write; of flight-c a folder.", show_default=False)
    ],
    to: Annotated[
        str,
        typer.Option("--to", help=f"Format: {', '.join(BUILT_IN)}.", show_default=False),
    ],
    condition: Condition = None,
    other: Annotated[
        Path | None, typer.Option("--with", help="Model of the other sensor, for formats that hold both.")
    ] = None,
    unjudged: Annotated[
        bool, typer.Option("--unjudged", help="Hand it out although no recording held out has judged it.")
    ] = False,
    nominal: Annotated[
        bool, typer.Option("--nominal", help="Write the nominal scale factor of axes whose own is not known.")
    ] = False,
    arithmetic: Annotated[
        str | None,
        typer.Option(help="Of flight-c: q27 (fixed point, 27 fraction bits), float32, float64.", show_default="q27"),
    ] = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Hand out a model in a format for others; one that was not judged only with --unjudged."""
    from ...campaign.models.find import find_model
    from ...files.models.model_file import export as export_model

    found = find_model(model, condition)
    sources = [found] if other is None else [found, find_model(other)]
    if other is not None and condition in sources[1].models:
        sources[1] = find_model(other, condition)
    exported = export_model(found, to, output, unjudged, sources[1:], nominal, arithmetic)
    judged = all(one.judged for one in (found.models.values() if condition is None else [found.model]))
    if as_json:
        content = {
            "inputs": [_input(one) for one in sources],
            "remarks": [remark.to_dict() for remark in exported.remarks],
            "written": str(output),
            "sha256": exported.sha256,
            "judged": judged,
        }
        json_out("export", content)
    elif not quiet:
        _print_remarks(exported.remarks)
        print(wrapped(f"written: {output} ({'judged' if judged else 'not judged'})"))
    return 0


def compare(
    first: Annotated[Path, typer.Argument(help="Model, results.json, or folder of a campaign.", show_default=False)],
    second: Annotated[Path, typer.Argument(help="The same, to compare with it.", show_default=False)],
    allowed: Annotated[
        list[str],
        typer.Option("--allowed", help='Change that does not matter: "0.1 %", or bias="0.01 deg/s". May be repeated.'),
    ] = [],  # noqa: B006 - typer copies it
    decision: Annotated[
        str,
        typer.Option(
            "--decision", help='Rule for allowed changes: simple_acceptance, guard_factor=1, "false_accept_risk=2 %".'
        ),
    ] = "",
    shared: Annotated[
        list[str],
        typer.Option("--shared", help="Standard whose error is the same in both: rate_table.rate. May be repeated."),
    ] = [],  # noqa: B006 - typer copies it
    condition: Condition = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Compare two models or two results, figure by figure, with the uncertainty of each difference."""
    from ...campaign.compare.compare import compare as compare_both

    found = compare_both(first, second, allowed, decision, shared, condition)
    print_comparison("compare", found, as_json, quiet)
    return found.exit_status


def print_comparison(command: str, found: Comparison, as_json: bool, quiet: bool) -> None:
    """Print a comparison, for the command that made it."""
    from ..shown.model_text import comparison_text

    if as_json:
        content = {
            "inputs": [{"path": path, "sha256": digest} for path, digest in found.inputs.items()],
            "results": [one.to_dict() for one in found.differences],
            "remarks": [remark.to_dict() for remark in found.remarks],
            "verdicts": found.verdicts,
            "verdict": found.verdict or None,
        }
        json_out(command, content, found.exit_status)
    elif not quiet:
        say(folded(comparison_text(found)))


def _input(source: Any) -> dict[str, str]:
    return {"path": source.path, "sha256": source.sha256}


def _written(
    command: str, inputs: list[dict[str, str]], path: Path, rows: int, remarks: list[Any], more: Any = None
) -> None:
    content = {"inputs": inputs, "remarks": [remark.to_dict() for remark in remarks], "written": str(path)}
    json_out(command, content | {"rows": rows} | (more or {}))


def _print_remarks(remarks: Iterable[Any]) -> None:
    from ..shown.summary import remarks_text

    for text in remarks_text([remark.to_dict() for remark in remarks]):
        print(text)


def _print_written(path: Path, rows: int, remarks: list[Any]) -> None:
    _print_remarks(remarks)
    print(followed(f"written: {path}, {rows} rows", f"inertialcal info {shlex.quote(str(path))}"))


compensate = with_options(
    _compensate,
    {
        "model": (Model, inspect.Parameter.empty),
        "data": (Data, inspect.Parameter.empty),
        "output": (
            Annotated[
                Path | None,
                typer.Option("--output", "-o", help="File to write; needed without --steps.", show_default=False),
            ],
            None,
        ),
        **said_options(),
        "temperature": (
            Annotated[
                str | None,
                typer.Option(help='Column with the temperature of the sensor, or one for all: "25 degC".'),
            ],
            None,
        ),
        "serial": (
            Annotated[
                str | None,
                typer.Option(help="Serial number of the sensor that gave the data: checked against the model."),
            ],
            None,
        ),
        "condition": (Condition, None),
        "uncertainty": (
            Annotated[
                bool, typer.Option("--uncertainty", help="Add a column with the standard uncertainty of each axis.")
            ],
            False,
        ),
        "steps": (
            Annotated[
                bool,
                typer.Option("--steps", help="Show every step for one reading, from counts; of a published model."),
            ],
            False,
        ),
        "row": (Annotated[int, typer.Option(help="Which reading --steps shows, from 1.")], 1),
        "as_printed": (
            Annotated[bool, typer.Option("--as-printed", help="A published model with the mistakes of its document.")],
            False,
        ),
        "as_json": (Json, False),
        "quiet": (Quiet, False),
    },
)
convert = with_options(
    _convert,
    {
        "source": (Data, inspect.Parameter.empty),
        "target": (
            Annotated[
                Path,
                typer.Argument(help="File to write: .csv, .parquet, .npz, .h5, .mat or .mcap.", show_default=False),
            ],
            inspect.Parameter.empty,
        ),
        **said_options(), "as_json": (Json, False), "quiet": (Quiet, False),
    },
)  # fmt: skip

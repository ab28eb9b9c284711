"""plan mass-attraction: figures, schedule and forecast of a moved mass, before it is made."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from .. import figures
from ..options import Json, Quiet
from ..shown.output import clean, json_out

if TYPE_CHECKING:
    from ...procedures.mass_attraction.planning.planner import MassPlan

FIGURES = {
    "body": "mass_body",
    "field": "mass_field",
    "cube-as-point": "cube_as_point",
    "growth": "mass_growth",
    "forecast": "mass_forecast",
    "proof-mass": "proof_mass",
}


def plan(
    settings: Annotated[Path | None, typer.Argument(help="TOML file of settings.", show_default=False)] = None,
    changes: Annotated[
        list[str],
        typer.Option("--set", metavar="KEY=VALUE", help='Change a setting: body.cube="5.08 cm". May be repeated.'),
    ] = [],  # noqa: B006 - typer copies it
    example: Annotated[
        Path | None, typer.Option("--write-example", help="Write a settings file to begin with.", show_default=False)
    ] = None,
    schedule: Annotated[
        Path | None,
        typer.Option(
            help="Write the dwells to this CSV file; to one for each phase, if runs start at several.",
            show_default=False,
        ),
    ] = None,
    build: Annotated[
        Path | None,
        typer.Option(
            help="Write where each cube goes: a list (.csv), a drawing (.pdf, .png, .svg), or both into a folder.",
            show_default=False,
        ),
    ] = None,
    output: figures.FigureFile = None,
    figure: Annotated[str | None, typer.Option(help=f"Figure to write: {', '.join(FIGURES)}.")] = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Run the command; its help stands in the declaration of the procedure."""
    from ...core.errors import UsageError
    from ...procedures.mass_attraction.planning.planner import plan_mass_attraction
    from ...procedures.settings_file import changes_of, write_starter

    if example is not None:
        from ...procedures.mass_attraction.planning.settings import STARTER, Settings

        write_starter(example, Settings, STARTER, "Settings of inertialcal plan mass-attraction")
        return _done([clean(f"written: {example}")], as_json, quiet)
    figures.check_figure(output, {"--figure": figure})
    if figure is not None and figure not in FIGURES:
        raise UsageError(f"no figure {figure!r}", do=f"There are: {', '.join(FIGURES)}", code="unknown_name")
    if settings is None and not changes:
        do = "Name a settings file. --write-example FILE writes one to begin with"
        raise UsageError("no settings", do=do, code="missing")
    found = plan_mass_attraction(settings, **changes_of(changes))
    written = [] if build is None else _build(build, found)
    if schedule is not None:
        from ...procedures.mass_attraction.schedule_csv import write_schedule

        if found.schedule is None:
            do = "Set motion.rig, motion.stroke or motion.travel"
            raise UsageError("--schedule: no drive to write", do=do, code="missing")
        for ahead, one in found.schedules.items():
            path = schedule.with_stem(f"{schedule.stem}_{ahead}") if ahead else schedule
            write_schedule(path, one, list(found.inputs), found.constants.notes)
            runs = [str(k) for k, other in enumerate(found.starts, 1) if other == ahead]
            which = f", run{'s' if len(runs) > 1 else ''} {', '.join(runs)}" if len(found.schedules) > 1 else ""
            written.append(clean(f"written: {path} ({len(one)} dwells{which})"))
    if output is not None:
        chosen = None if figure is None else FIGURES[figure]
        written.append(figures.write(output, found, list(found.inputs), {"figure": chosen}))
    content: dict[str, Any] = {
        "inputs": [{"path": path, "sha256": digest} for path, digest in found.inputs.items()],
        "remarks": [remark.to_dict() for remark in (*found.remarks, *(found.build.remarks() if build else ()))],
        **found.results,
    }
    if not as_json and not quiet:
        from ...core.show.tables import text
        from ...procedures.mass_attraction.planning.rows import mass_parts
        from ..shown.summary import remarks_text

        print(text(mass_parts(found.rows)))
        for line in remarks_text(content["remarks"]):
            print(line)
    return _done(written, as_json, quiet, content)


def _build(path: Path, found: MassPlan) -> list[str]:
    """Write the list of cubes, the drawing, or both; return a line for each."""
    from ...core.errors import StoreError
    from ...core.show.rounding import items
    from ...files.write.atomic import atomic_write
    from ...report.figures.mass_attraction.build_drawing import write_build

    folder = not path.suffix
    if folder:
        try:
            path.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise StoreError(f"cannot make {path}: {error.strerror}", code="not_writable") from None
    cubes, inputs, written = found.build, list(found.inputs), []
    notes = [f"{name}: {what}" for name, what in found.constants.notes.items()]
    for one in [path / "cubes.csv", path / "cubes.pdf"] if folder else [path]:
        if one.suffix.lower() == ".csv":
            with atomic_write(one, inputs) as aside:
                aside.write_text(cubes.csv(notes), encoding="utf-8", newline="\n")
        else:
            write_build(one, cubes, "Source mass of a mass-attraction test", inputs)
        written.append(clean(f"written: {one} ({items(len(cubes), 'cube')})"))
    return written


def _done(written: list[str], as_json: bool, quiet: bool, content: dict[str, Any] | None = None) -> int:
    if as_json:
        json_out("plan mass-attraction", (content or {}) | ({"written": written} if written else {}))
    elif not quiet:
        for line in written:
            print(line)
    return 0

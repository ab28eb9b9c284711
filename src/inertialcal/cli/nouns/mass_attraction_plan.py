"""plan mass-attraction: what a moved mass will give, before it is made."""

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

Text = str | None


def plan(
    cube: Annotated[Text, typer.Option(help='Edge of the cubes: "5.08 cm".')] = None,
    count: Annotated[int | None, typer.Option(help="How many cubes.")] = None,
    mass: Annotated[Text, typer.Option(help='What they may weigh: "1338 kg".')] = None,
    inventory: Annotated[
        Text, typer.Option(help='Cubes of several sizes, in place of --cube: "100x10.2 cm,100x5.1 cm".')
    ] = None,
    density: Annotated[str, typer.Option(help="Of the material; lead if not said.")] = "11.34 g/cm^3",
    stand_off: Annotated[
        Text, typer.Option("--stand-off", help='From the proof mass to the nearest face: "10.2 cm".')
    ] = None,
    grid: Annotated[Text, typer.Option(help="Cells across, across and along the input axis: 20x20x10.")] = None,
    optimise: Annotated[
        str, typer.Option(help="What the shape is best for: attraction, or change over the stroke.")
    ] = "attraction",
    stated: Annotated[Text, typer.Option(help='Attraction of a document, to be checked: "74 ng".')] = None,
    direction: Annotated[
        str, typer.Option(help="How the mass is moved: across the input axis, or along it.")
    ] = "across",
    rig: Annotated[Text, typer.Option(help='Positions that the stage has: "0 cm:60 cm".')] = None,
    stroke: Annotated[Text, typer.Option(help='Ends of the drive: "12.7 cm:43.2 cm".')] = None,
    travel: Annotated[Text, typer.Option(help='In place of --stroke, length of the best window: "30.5 cm".')] = None,
    proof_mass: Annotated[
        Text,
        typer.Option(
            "--proof-mass",
            help='A cylinder along the input axis: "length 2.9 cm, inner radius 1.3 cm, radius 1.4 cm".',
        ),
    ] = None,
    instrument: Annotated[str, typer.Option(help="How far the case reaches from the proof mass.")] = "0 cm",
    pools: Annotated[
        Text,
        typer.Option(help='Both surfaces of a tilt meter of mercury: "0 cm,-50 cm,-10 cm; 0 cm,50 cm,-10 cm".'),
    ] = None,
    drive: Annotated[str, typer.Option(help="Order of the dwells: sine, square or abab.")] = "sine",
    dwell: Annotated[str, typer.Option(help="Length of a dwell.")] = "100 s",
    move: Annotated[str, typer.Option(help="Pause between two dwells, in which the mass is moved.")] = "20 s",
    hours: Annotated[float, typer.Option(help="Length of the test.")] = 24.0,
    noise: Annotated[Text, typer.Option(help='Of the sensor: "N=55 ng/sqrt(Hz) B=1 ng K=0.1 ng/sqrt(s)".')] = None,
    noise_from: Annotated[
        Path | None, typer.Option("--noise-from", help="What allan --json or run wrote, in place of --noise.")
    ] = None,
    noise_axis: Annotated[Text, typer.Option("--noise-axis", help="Which axis of that file.")] = None,
    target: Annotated[Text, typer.Option(help='Standard uncertainty of the scale factor wanted: "1 %".')] = None,
    u_density: Annotated[Text, typer.Option("--u-density", help="Of the density, common to all cubes.")] = None,
    u_piece_density: Annotated[Text, typer.Option("--u-piece-density", help="Of the density of each cube.")] = None,
    u_position: Annotated[
        Text, typer.Option("--u-position", help="Of the place of the body against the proof mass, each way.")
    ] = None,
    u_stop: Annotated[Text, typer.Option("--u-stop", help="Of each stop along the travel.")] = None,
    u_piece_place: Annotated[
        Text, typer.Option("--u-piece-place", help="Of the place of each cube in the body, each way.")
    ] = None,
    u_angle: Annotated[Text, typer.Option("--u-angle", help="Of each angle of the body.")] = None,
    big_g: Annotated[
        Text, typer.Option("--big-g", help='Gravitational constant of a document: "6.67e-8 cm^3/s^2/gram".')
    ] = None,
    gravity: Annotated[Text, typer.Option(help='What a g of a document is: "981 cm/s^2".')] = None,
    shape: Annotated[bool, typer.Option("--shape", help="The body alone.")] = False,
    orbit: Annotated[bool, typer.Option("--orbit", help="A small mass and a gradiometer instead.")] = False,
    threshold: Annotated[
        str, typer.Option(help='With --orbit: what it sees, as a gradient, or an acceleration ("1e-10 g").')
    ] = "0.5 Eotvos",
    baseline: Annotated[str, typer.Option(help="With --orbit: distance of its accelerometers.")] = "2 m",
    schedule: Annotated[Path | None, typer.Option(help="Write the dwells to this CSV.", show_default=False)] = None,
    output: figures.FigureFile = None,
    figure: Annotated[Text, typer.Option(help=f"Which figure: {', '.join(FIGURES)}.")] = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Run the command; its help stands in the declaration of the procedure."""
    from ...procedures.mass_attraction.planning.planner import plan_mass_attraction

    figures.check_figure(output, {"--figure": figure})
    chosen = _figure(figure)
    found = plan_mass_attraction(
        cube=cube, count=count, mass=mass, inventory=inventory, density=density, stand_off=stand_off, grid=grid,
        optimise=optimise, stated=stated, direction=direction, rig=rig, stroke=stroke, travel=travel,
        instrument=instrument, proof_mass=proof_mass, pools=pools, drive=drive,
        dwell=dwell, move=move, hours=hours, noise=noise, noise_file=noise_from,
        noise_axis=noise_axis, target=target, u_density=u_density, u_piece_density=u_piece_density,
        u_position=u_position, u_stop=u_stop, u_piece_place=u_piece_place, u_angle=u_angle, big_g=big_g,
        gravity=gravity, shape=shape, orbit=orbit, threshold=threshold, baseline=baseline,
    )  # fmt: skip
    written = _write(found, schedule, output, chosen, noise_from)
    if as_json:
        _json(found, written)
    elif not quiet:
        _print(found, written)
    return 0


def _figure(name: str | None) -> str | None:
    """Return the figure's name inside."""
    from ...core.errors import UsageError

    if name is not None and name not in FIGURES:
        raise UsageError(f"no figure {name!r}", do=f"There are: {', '.join(FIGURES)}", code="unknown_name")
    return None if name is None else FIGURES[name]


def _write(
    found: MassPlan, schedule: Path | None, output: Path | None, figure: str | None, noise: Path | None
) -> list[str]:
    """Write schedule and figure; return a line a file."""
    inputs = [] if noise is None else [noise]
    lines = []
    if schedule is not None:
        from ...core.errors import UsageError
        from ...procedures.mass_attraction.schedule_csv import write_schedule

        if found.schedule is None:
            do = 'Say between which positions: --stroke "12.7 cm:43.2 cm", without --shape'
            raise UsageError("--schedule: there is no drive to write", do=do, code="missing")
        write_schedule(schedule, found.schedule, inputs, found.constants.told)
        lines.append(clean(f"written: {schedule} ({len(found.schedule)} dwells)"))
    if output is not None:
        lines.append(figures.write(output, found, inputs, {"figure": figure}))
    return lines


def _json(found: MassPlan, written: list[str]) -> None:
    content: dict[str, Any] = {
        "inputs": [{"path": path, "sha256": digest} for path, digest in (found.inputs or {}).items()],
        "remarks": [remark.to_dict() for remark in found.remarks],
        **found.results,
    }
    json_out("plan mass-attraction", content | ({"written": written} if written else {}))


def _print(found: MassPlan, written: list[str]) -> None:
    from ...core.show.tables import text
    from ...procedures.mass_attraction.planning.shown import mass_parts
    from ..shown.summary import remarks_text

    print(text(mass_parts(found.rows)))
    for line in remarks_text([remark.to_dict() for remark in found.remarks]):
        print(line)
    for line in written:
        print(line)

"""Noise of a sensor as text for a terminal: terms, what the record cannot tell, how long to record; spectra."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ...core.show.result_tables import figure, interval, not_estimated
from ...core.show.rounding import number
from ...core.show.tables import ending, short
from .output import clean, table, wrapped

if TYPE_CHECKING:
    from ...core.results import Row
    from ...procedures.static_noise.files.allan import NoiseFile, SensorNoise
    from ...procedures.static_noise.files.psd import SpectrumFile
    from ...procedures.static_noise.reduction import Reach
    from ...sensors.noise.to_filters import FilterBlock

HEADS = ("  term", "axis", "value ± u", "unit", "95 % interval", "SI", "what the record tells")
OTHERS = ("  alone", "term", "axis", "value ± u", "unit", "95 % interval")
SIZE, TIME = "gauss_markov_sigma", "gauss_markov_correlation_time"  # a limit of one says all of the other


def noise_text(found: NoiseFile) -> str:
    """Return what ``allan`` prints.

    Parameters
    ----------
    found : NoiseFile
        What was found.
    """
    blocks = [_sensor(one) for one in found.sensors]
    return "\n\n".join(["\n\n".join(blocks), "\n".join(_remarks(found.remarks))]).rstrip()


def _sensor(one: SensorNoise) -> str:
    from ...procedures.static_noise.reduction import reaches
    from ...sensors.noise.fitting.noise_fit import duration

    readings = one.result.readings
    rate = number(1.0 / readings.records[0].interval)
    several = f" in {len(readings)} records" if len(readings) > 1 else ""
    head = f"{one.name}: {duration(readings.length)} at {rate} Hz{several}"
    rows = [row for row in one.rows() if row.case.plain]
    inside = {(row.quantity, row.axis): row for row in one.result.rows() if row.case.plain}
    found = {(axis.axis, reach.quantity): reach for axis in one.result.axes for reach in reaches(one.result.plan, axis)}
    lengths = {key: _told(reach, one.result.plan.relative_error) for key, reach in found.items()}
    cells = [_cells(row, inside, lengths, one.group.kind is not None) for row in rows if row.status == "estimated"]
    lines = [head, table(cells, HEADS), *_not_found(rows, found), *_nothing(one, rows), _lines(one), _alone(one)]
    return "\n".join(line for line in lines if line)


def _not_found(rows: Sequence[Row], found: Mapping[tuple[str, str], Reach]) -> Iterator[str]:
    """Yield the terms that were not found: a line an axis and reason, each with its limit and how long to record."""
    from ...sensors.noise.fitting.noise_fit import duration

    groups: dict[tuple[str, str], list[str]] = {}
    for row in rows:
        reach = found.get((row.axis, row.quantity))
        if row.status != "upper_limit" or reach is None:
            continue
        longer = reach.needed is not None and reach.needed > reach.record
        length = f" ({duration(reach.needed)})" if longer and reach.needed is not None else ""
        told = f"{row.quantity} {figure(row.to_dict())} {row.unit}{length}"
        groups.setdefault((short(row.axis), reach.reason), []).append(told)
    if groups:
        yield "  not found: below a 95 % limit (in brackets: the record that would show a term at its limit)"
    for (axis, reason), said in groups.items():
        yield wrapped(f"    {axis}: {reason}: {', '.join(said)}", "       ")


def _nothing(one: SensorNoise, rows: Sequence[Row]) -> Iterator[str]:
    """Yield why axes have no terms at all, and why single terms have no limit either."""
    without = {axis.axis: axis.reason for axis in one.result.axes if axis.fit is None}
    for reason in dict.fromkeys(without.values()):
        yield wrapped(
            f"  no terms of {', '.join(short(axis) for axis in without if without[axis] == reason)}: {reason}"
        )
    limited = {row.axis for row in rows if (row.quantity, row.status) == (SIZE, "upper_limit")}
    missing = [
        row.to_dict()
        for row in rows
        if row.status == "not_estimated"
        and row.axis not in without
        and not (row.quantity == TIME and row.axis in limited)
    ]
    yield from (f"  {line}" for line in not_estimated(missing))


def _cells(
    row: Row, inside: Mapping[tuple[str, str], Row], lengths: Mapping[tuple[str, str], str], known: bool
) -> list[str]:  # fmt: skip
    shown = row.to_dict()
    told = lengths.get((row.axis, row.quantity), "")
    si = _inside(inside[row.quantity, row.axis]) if known else ""
    return [f"  {row.quantity}", short(row.axis), figure(shown), row.unit, interval(shown), si, told]


def _inside(row: Row) -> str:
    """Return a figure in SI, white noise as a density."""
    unit = {"rad/sqrt(s)": "rad/s/sqrt(Hz)", "m/s/sqrt(s)": "m/s^2/sqrt(Hz)"}.get(row.unit, row.unit)
    return f"{number(row.value, 4)} {unit}"


def _told(reach: Reach, wanted: float) -> str:
    """Return what the record tells of a term, without its name."""
    from ...procedures.static_noise.reduction import sentence

    return sentence(reach, wanted).partition(": ")[2]


def _lines(one: SensorNoise) -> str:
    """Return the lines of the spectrum, one a line."""
    rows = [row for row in one.rows() if row.quantity == "line_amplitude"]
    if not rows:
        return ""
    cells = [[f"  {row.case}", short(row.axis), figure(row.to_dict()), row.unit] for row in rows]
    return table(cells, ["  line of the spectrum", "axis", "amplitude ± u", "unit"])


def _alone(one: SensorNoise) -> str:
    """Return the terms of single records, where there are several."""
    cells = [
        [f"  {ending(row.member.label)}", row.quantity, short(row.axis),
         figure(row.to_dict()), row.unit, interval(row.to_dict())]
        for row in one.rows()
        if row.member is not None and row.key.at is None
    ]  # fmt: skip
    return table(cells, OTHERS) if cells else ""


def spectrum_text(found: SpectrumFile) -> str:
    """Return what ``psd`` prints.

    Parameters
    ----------
    found : SpectrumFile
        What was found.
    """
    blocks = []
    for sensor in found.sensors:
        parts: list[str] = []
        for grid in found.tables(sensor):
            parts += [wrapped(grid.caption), table([[f"  {row[0]}", *row[1:]] for row in grid.rows],
                      [f"  {grid.heads[0]}", *grid.heads[1:]], tuple(grid.right))]  # fmt: skip
        rows = [row for row in sensor.rows() if row.case.plain and row.status == "estimated"]
        cells = [
            [f"  {row.quantity}", short(row.axis), figure(row.to_dict()), row.unit, row.reason.text] for row in rows
        ]
        parts += ["terms", table(cells, ["  term", "axis", "value ± u", "unit", ""])]
        blocks.append("\n".join([*parts, *found.agreement(sensor)]))
    return "\n\n".join(["\n\n".join(blocks), "\n".join(_remarks(found.remarks))]).rstrip()


def blocks_text(blocks: Mapping[str, FilterBlock]) -> Iterator[str]:
    """Yield the settings of each filter.

    Parameters
    ----------
    blocks : mapping of str to FilterBlock
        By the word of the filter.
    """
    for target, block in blocks.items():
        yield clean(f"# {target}\n{block}")


def _remarks(found: Any) -> Iterator[str]:
    from .summary import remarks_text

    yield from remarks_text([remark.to_dict() for remark in found])

"""Noise of a sensor as text for a terminal: terms, what the record cannot tell, how long to record; spectra."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from ..core.result_tables import figure, interval, not_estimated
from ..core.rounding import number
from ..core.tables import ending, short
from .output import clean, table, wrapped

if TYPE_CHECKING:
    from ..campaign.single_noise import NoiseFile, SensorNoise
    from ..campaign.single_spectrum import SpectrumFile
    from ..core.results import Row
    from ..sensors.noise.filter_block import FilterBlock

HEADS = ("  term", "axis", "value ± u", "unit", "95 % interval", "SI", "what the record tells")
OTHERS = ("  alone", "term", "axis", "value ± u", "unit", "95 % interval")
ALONE = "run "
SIZE, TIME = "gauss_markov_sigma", "gauss_markov_correlation_time"  # a limit of one says all of the other


def noise_text(found: NoiseFile) -> str:
    """Return what ``allan`` prints."""
    blocks = [_sensor(one) for one in found.sensors]
    return "\n\n".join(["\n\n".join(blocks), "\n".join(_remarks(found.remarks))]).rstrip()


def _sensor(one: SensorNoise) -> str:
    from ..sensors.noise.noise_fit import duration

    readings = one.result.readings
    rate = number(1.0 / readings.records[0].interval)
    several = f" in {len(readings)} records" if len(readings) > 1 else ""
    head = f"{one.name}: {duration(readings.length)} at {rate} Hz{several}"
    rows = [row for row in one.rows() if not row.condition and row.status != "not_estimated"]
    inside = {(row.quantity, row.axis): row for row in one.result.rows() if not row.condition}
    lengths = dict(_lengths(one))
    cells = [_cells(row, inside, lengths, one.group.kind is not None) for row in rows]
    lines = [head, table(cells, HEADS)]
    limited = {row.axis for row in rows if (row.quantity, row.status) == (SIZE, "upper_limit")}
    missing = [
        row.to_dict()
        for row in one.rows()
        if row.status == "not_estimated" and not (row.quantity == TIME and row.axis in limited)
    ]
    lines += [f"  {line}" for line in not_estimated(missing)]
    lines += [_lines(one), _alone(one)]
    return "\n".join(line for line in lines if line)


def _cells(
    row: Row, inside: Mapping[tuple[str, str], Row], lengths: Mapping[tuple[str, str], str], known: bool
) -> list[str]:  # fmt: skip
    shown = row.to_dict()
    told = lengths.get((row.axis, row.quantity), "")
    si = _inside(inside[row.quantity, row.axis]) if known else ""
    ends = "" if row.status == "upper_limit" else interval(shown)
    return [f"  {row.quantity}", short(row.axis), figure(shown), row.unit, ends, si, told]


def _inside(row: Row) -> str:
    """Return a figure in SI, white noise as a density."""
    unit = {"rad/sqrt(s)": "rad/s/sqrt(Hz)", "m/s/sqrt(s)": "m/s^2/sqrt(Hz)"}.get(row.unit, row.unit)
    return f"{number(row.value, 4)} {unit}"


def _lengths(one: SensorNoise) -> Iterator[tuple[tuple[str, str], str]]:
    from ..procedures.static_noise import reaches, sentence

    for axis in one.result.axes:
        for reach in reaches(one.result.plan, axis):
            said = sentence(reach, one.result.plan.relative_error)
            yield (axis.axis, reach.quantity), said.partition(": ")[2]


def _lines(one: SensorNoise) -> str:
    """Return the lines of the spectrum, one a line."""
    rows = [row for row in one.rows() if row.quantity == "line_amplitude"]
    if not rows:
        return ""
    cells = [[f"  {row.condition}", short(row.axis), figure(row.to_dict()), row.unit] for row in rows]
    return table(cells, ["  line of the spectrum", "axis", "amplitude ± u", "unit"])


def _alone(one: SensorNoise) -> str:
    """Return the terms of single records, where there are several."""
    rows = [row for row in one.rows() if row.condition.startswith(ALONE)]
    if not rows:
        return ""
    cells = [
        [f"  {ending(row.condition.removeprefix(ALONE).removesuffix(' alone'))}", row.quantity, short(row.axis),
         figure(row.to_dict()), row.unit, interval(row.to_dict())]
        for row in rows
    ]  # fmt: skip
    return table(cells, OTHERS)


def spectrum_text(found: SpectrumFile) -> str:
    """Return what ``psd`` prints."""
    blocks = []
    for sensor in found.sensors:
        parts: list[str] = []
        for grid in found.tables(sensor):
            parts += [wrapped(grid.caption), table([[f"  {row[0]}", *row[1:]] for row in grid.rows],
                      [f"  {grid.heads[0]}", *grid.heads[1:]], tuple(grid.right))]  # fmt: skip
        rows = [row for row in sensor.rows() if not row.condition and row.status == "estimated"]
        cells = [[f"  {row.quantity}", short(row.axis), figure(row.to_dict()), row.unit] for row in rows]
        parts += ["terms", table(cells, ["  term", "axis", "value ± u", "unit"])]
        blocks.append("\n".join([*parts, *found.agreement(sensor)]))
    return "\n\n".join(["\n\n".join(blocks), "\n".join(_remarks(found.remarks))]).rstrip()


def blocks_text(blocks: Mapping[str, FilterBlock]) -> Iterator[str]:
    """Yield the settings of each filter."""
    for target, block in blocks.items():
        yield clean(f"# {target}\n{block}")


def _remarks(found: Any) -> Iterator[str]:
    from .summary import remarks_text

    yield from remarks_text([remark.to_dict() for remark in found])

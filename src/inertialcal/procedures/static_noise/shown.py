"""What ``allan`` and ``psd`` print and write: terms, what the record cannot show, how long to record; spectra."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ...core.results import Row, finite
from ...core.schema.json_text import json_text
from ...core.show.result_tables import figure, interval, not_estimated
from ...core.show.rounding import freedom, near, number, settled_ends, with_uncertainty
from ...core.show.tables import aligned, csv_cell, ending, short, wrapped
from ...core.units import FILE_UNIT, factor
from ...sensors.noise.fitting.noise_fit import duration
from ...sensors.noise.terms import sample_unit
from ..protocol import Tested
from .curves import density_unit
from .filters import filter_block
from .planning.record_length import reaches, sentence

if TYPE_CHECKING:
    from ...sensors.noise.to_filters import FilterBlock
    from ..protocol import Reduced

Test = Tested[Any, Any, Any]
PER_DECADE = 3  # rows of a spectrum
TERMS = ("  term", "axis", "value ± u", "unit", "95 % interval", "SI", "how well known")
SI = TERMS.index("SI")
ALONE = ("  alone", "term", "axis", "value ± u", "unit", "95 % interval")
CURVE = ("  axis", "tau [s]", "deviation", "unit", "95 % interval")
LINES = ("  axis", "line", "frequency", "unit", "amplitude", "unit", "over noise", "kind")
SIZE, TIME = "gauss_markov_sigma", "gauss_markov_correlation_time"  # a limit of one says all of the other
ENDINGS = {"kalibr": "imu.yaml", "px4": "px4.params", "gtsam": "gtsam_params.py", "kf-gins": "kf-gins.yaml"}


def report(found: Reduced) -> str:
    """Return what a command prints: each sensor, then the settings of filters."""
    show = _spectrum if found.word == "psd" else _terms
    sensors = ["\n".join(line for line in show(found, one) if line) for one in found.tested]
    return "\n\n".join([*sensors, *(f"# {target}\n{block}" for target, block in blocks(found).items())])


def content(found: Reduced) -> dict[str, object]:
    """Return what ``--json`` has besides rows: settings of filters."""
    filters = {
        target: {"text": block.text, "cannot_hold": list(block.cannot_hold), "missing": list(block.missing)}
        for target, block in blocks(found).items()
    }
    return {"filters": filters} if filters else {}


def files(found: Reduced) -> dict[str, str]:
    """Return what a folder takes besides figures: curves as CSV, terms as JSON, settings of filters."""
    texts = {"curves.csv": _curves_text(found), "terms.json": _terms_text(found)}
    return texts | {ENDINGS[target]: f"{block}\n" for target, block in blocks(found).items()}


def blocks(found: Reduced) -> dict[str, FilterBlock]:
    """Return the settings of the filters that are wanted."""
    wanted = found.shown.for_filter or ()
    return {one: filter_block(found, one, found.shown.horizon, found.shown.take or ()) for one in wanted}


def _heading(test: Test) -> str:
    """Return the sensor of a test; "noise" for one whose kind nothing states."""
    return "noise" if test.id == "static_noise" else test.id


def _rows(found: Reduced, test: Test) -> list[Row]:
    return [row for row in found.rows if row.test == test.id]


def _terms(found: Reduced, test: Test) -> Iterator[str]:
    """Yield what there is to say of the terms of a sensor."""
    readings, result = test.readings, test.result
    several = f" in {len(readings)} records" if len(readings) > 1 else ""
    yield f"{_heading(test)}: {duration(readings.length)} at {number(1.0 / readings.records[0].interval)} Hz{several}"
    every = _rows(found, test)
    rows = [row for row in every if row.case.plain]
    inside = {row.key: row for row in result.rows() if row.case.plain}
    known = {(one.axis, reach.quantity): reach for one in result.axes for reach in reaches(test.plan, one)}
    cells = []
    for row in (one for one in rows if one.status == "estimated"):
        reach, shown = known.get((row.axis, row.quantity)), row.to_dict()
        known_to = "" if reach is None else sentence(reach, test.plan.relative_error).partition(": ")[2]
        si = _density(inside[row.key]) if test.facts.kind else ""
        cells.append([f"  {row.quantity}", short(row.axis), figure(shown), row.unit, interval(shown), si, known_to])
    if test.facts.kind:
        yield aligned(cells, TERMS) if cells else ""
    else:  # in the unit of the file, nothing in SI
        bare = [[*cell[:SI], *cell[SI + 1 :]] for cell in cells]
        yield aligned(bare, (*TERMS[:SI], *TERMS[SI + 1 :])) if cells else ""
    groups: dict[tuple[str, str], list[str]] = {}
    for row in rows:
        reach = known.get((row.axis, row.quantity))
        if row.status == "upper_limit" and reach is not None:
            longer = f" ({duration(reach.needed)})" if reach.needed is not None and reach.needed > reach.record else ""
            limit = f"{row.quantity} {figure(row.to_dict())} {row.unit}{longer}"
            groups.setdefault((short(row.axis), reach.reason), []).append(limit)
    if groups:
        yield wrapped(
            "  not found: upper 95 % limits (in brackets: record that would show a term of that size)", "    "
        )
    for (axis, reason), limits in groups.items():
        yield wrapped(f"    {axis}: {reason}: {', '.join(limits)}", "       ")
    yield from _nothing(test, rows)
    lines = [row for row in every if row.quantity == "line_amplitude"]
    cells = [[f"  {row.case}", short(row.axis), figure(row.to_dict()), row.unit] for row in lines]
    yield aligned(cells, ("  line of the spectrum", "axis", "amplitude ± u", "unit")) if cells else ""
    cells = [
        [f"  {ending(row.member.label)}", row.quantity, short(row.axis),
         figure(row.to_dict()), row.unit, interval(row.to_dict())]
        for row in every
        if row.member is not None and row.key.at is None
    ]  # fmt: skip
    yield aligned(cells, ALONE) if cells else ""


def _nothing(test: Test, rows: Sequence[Row]) -> Iterator[str]:
    """Yield why axes have no terms at all, and why single terms have no limit either."""
    without = {axis.axis: axis.reason for axis in test.result.axes if axis.fit is None}
    for reason in dict.fromkeys(without.values()):
        axes = ", ".join(short(axis) for axis in without if without[axis] == reason)
        yield wrapped(f"  no terms of {axes}: {reason}")
    unit = test.facts.unit or FILE_UNIT
    scale = factor(sample_unit(test.facts.kind), unit) if test.facts.kind else 1.0
    cells = [
        (
            f"  {short(axis.axis)}",
            number(tau, 4),
            near(value, 0.25 * (hi - lo)),
            unit,
            settled_ends(value, None, lo, hi),
        )
        for axis in test.result.axes
        if axis.curve_alone
        for record in axis.records
        for tau, value, lo, hi in zip(
            record.shown.tau.tolist(),
            *((scale * one[:, 0]).tolist() for one in (record.shown.deviation, record.shown.lo, record.shown.hi)),
            strict=True,
        )
    ]
    yield aligned(cells, CURVE, (1, 2)) if cells else ""
    limited = {row.axis for row in rows if (row.quantity, row.status) == (SIZE, "upper_limit")}
    missing = [
        row.to_dict()
        for row in rows
        if row.status == "not_estimated"
        and row.axis not in without
        and not (row.quantity == TIME and row.axis in limited)
    ]
    yield from (wrapped(f"  {line}", "    ") for line in not_estimated(missing))


def _density(row: Row) -> str:
    """Return a figure in SI, white noise as a density."""
    unit = {"rad/sqrt(s)": "rad/s/sqrt(Hz)", "m/s/sqrt(s)": "m/s^2/sqrt(Hz)"}.get(row.unit, row.unit)
    return f"{number(row.value, 4)} {unit}"


def _spectrum(found: Reduced, test: Test) -> Iterator[str]:
    """Yield the bands of a sensor's spectrum, its lines, its terms, and the check against the Allan deviation."""
    unit = test.facts.unit or FILE_UNIT
    scale = factor(sample_unit(test.facts.kind), unit) if test.facts.kind else 1.0
    records = [(one.axis, record.spectral) for one in test.result.axes for record in one.records]
    spectra = [(axis, one.spectrum) for axis, one in records if one.spectrum is not None]
    if not spectra:
        yield f"{_heading(test)}: no spectrum"
    else:
        first = spectra[0][1]
        yield wrapped(
            f"{_heading(test)}: spectrum ({first.method}), {first.segments} segment(s) of "
            f"{number(first.segment * first.interval, 4)} s, {freedom(first.edf, 3)} a value; "
            f"means over bands [{density_unit(unit)}]"
        )
        bands: dict[float, dict[str, float]] = {}
        for axis, one in spectra:
            frequency, density, _ = one.smoothed(PER_DECADE)
            for f, value in zip(frequency.tolist(), (density[:, 0] * scale**2).tolist(), strict=True):
                bands.setdefault(f, {})[axis] = value
        axes = list(dict.fromkeys(axis for axis, _ in spectra))
        rows = [[f"  {number(f, 4)}", *(number(own.get(axis), 4) for axis in axes)] for f, own in sorted(bands.items())]
        yield aligned(rows, ("  f [Hz]", *axes), range(len(axes) + 1))
    lines = [
        (f"  {axis}", line.name, with_uncertainty(line.frequency, line.u_frequency), "Hz",
         with_uncertainty(line.amplitude * scale, line.u_amplitude * scale), unit, number(line.ratio, 3), line.kind)
        for axis, one in records
        for line in (one.lines.found if one.lines is not None else ())
    ]  # fmt: skip
    if lines:
        yield "lines"
        yield aligned(lines, LINES, (2, 4, 6))
    terms = [row for row in _rows(found, test) if row.case.plain and row.status == "estimated"]
    yield "terms"
    cells = [[f"  {row.quantity}", short(row.axis), figure(row.to_dict()), row.unit, row.reason.text] for row in terms]
    yield aligned(cells, ("  term", "axis", "value ± u", "unit", ""))
    for axis, one in records:
        agreement = one.agreement
        if agreement is None or not agreement.compared:
            yield wrapped(f"{axis}: Allan deviation and spectrum could not be compared")
        else:
            word = "agree" if agreement.agree.all() else "DISAGREE"
            yield wrapped(f"{axis}: Allan deviation and spectrum {word} at {agreement.compared} averaging times")


def _curves_text(found: Reduced) -> str:
    """Return the curves as CSV: one line a point, with its sensor, axis, record, curve and unit."""
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(["curve", "sensor", "axis", "record", "of", "at", "at_unit", "column", "value", "unit"])
    names = ("spectrum",) if found.word == "psd" else ("allan", "allan_terms", "spectrum")
    for curve in found.results["curves"]:
        if curve["name"] in names:
            writer.writerows(_points(curve))
    return buffer.getvalue()


def _points(curve: Mapping[str, Any]) -> Iterator[Sequence[Any]]:
    (name, at), *others = curve["columns"].items()
    said = (curve["name"], curve["test"], curve["axis"], curve.get("recording", ""), curve.get("of", ""))
    head = [csv_cell(text) for text in said]
    for column, values in others:
        for place, value in zip(at["values"], values["values"], strict=True):
            shown = "" if value is None else value if isinstance(value, str) else repr(value)
            yield [*head, repr(place), at["unit"] or name, column, shown, values["unit"]]


def _terms_text(found: Reduced) -> str:
    """Return the terms as JSON: rows in the units of data sheets, and each term's parameters, SI."""
    sensors = [
        {
            "sensor": one.id, "kind": one.facts.kind, "unit": one.facts.unit,
            "sample_interval": one.readings.records[0].interval, "averaging": one.readings.records[0].averaging,
            "axes": [
                {
                    "axis": axis.axis,
                    "terms": [{"term": term.name} | {name: finite(getattr(term, name)) for name in term.parameters}
                              for term in axis.terms],
                }
                for axis in one.result.axes
            ],
        }
        for one in found.tested
    ]  # fmt: skip
    whole = {
        "inputs": [{"path": path, "sha256": digest} for path, digest in found.inputs.items()],
        "sensors": sensors,
        "results": [row.to_dict() for row in found.rows],
    }
    return json_text(whole)

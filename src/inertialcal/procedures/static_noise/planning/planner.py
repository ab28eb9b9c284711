"""A record at rest planned: hours and sample rate, and how well each noise term will be known.

What ``plan allan`` and ``inertialcal.plan_allan`` do. The forecast is the covariance of the fit of all terms to the
overlapping Allan deviation (``sensors.noise.planner``), as the test makes it. A record long enough for what is wanted
is made longer where the term would not yet be named among all terms in 95 % of records.

Two things that no length helps against: a temperature that wanders moves the bias as instability does, and is read as
noise; and what lies above half of the sample rate folds down into white noise, unless samples are means over their
interval, or a low pass comes before them.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ....core.errors import DataError, UsageError
from ....core.estimate import Array
from ....core.key import Key, Kind
from ....core.remarks import Remark
from ....core.results import Row
from ....core.show.rounding import number, uncertainty
from ....core.show.tables import Table
from ....core.units import factor, parse_quantity
from ....files.source import load
from ....sensors.noise.expected import variance_of_phase
from ....sensors.noise.fitting.allan_covariance import covariance_of_allan, model_edf
from ....sensors.noise.planner import NOISE_EDF, SHOWN, octaves, relative_errors, separation
from ....sensors.noise.terms import (
    BiasInstability,
    Quantization,
    RandomWalk,
    RateRandomWalk,
    Term,
    parameter_unit,
    quantity_name,
    total_phase,
)
from ... import planned as shared
from ...planned import HOUR, Design, Figure, Part, TestPlan
from ..plan import Plan, PlannedRecord
from ..readings import Truth, simulate
from ..reduction import reduce

WORD = "allan"
KINDS: Mapping[str, type[RandomWalk | BiasInstability | RateRandomWalk | Quantization]] = {
    "noise": RandomWalk, "instability": BiasInstability, "walk": RateRandomWalk, "quantization": Quantization,
}  # fmt: skip
SIZES: Mapping[Kind, Mapping[str, str]] = {
    "gyro": {"noise": "0.2 deg/sqrt(h)", "instability": "5 deg/h", "walk": "5 deg/h/sqrt(h)",
             "quantization": "0.5 arcsec"},
    "accelerometer": {"noise": "100 ug/sqrt(Hz)", "instability": "10 ug", "walk": "1 ug/sqrt(s)",
                      "quantization": "1 mm/s"},
}  # fmt: skip
UNITS: Mapping[Kind, str] = {"gyro": "rad/s", "accelerometer": "m/s^2"}
SHORTEST, LONGEST, FINER = 60.0, 2000.0 * HOUR, 2.0**0.25  # records that are looked at
MOST = 2**14  # samples of a simulated record
ALIKE = 0.1  # relative: forecasts at two sample rates that are one
SECOND_ORDER = 0.5  # relative change of a deviation for that of its square
LONGER = "a longer record"
UNSEEN = "a mild low pass, a rounded angle or a slow term that such a record does not exclude"
MAKE = "Give what allan prints as JSON"


@dataclass(frozen=True, eq=False)
class Known:
    """Settings, SI."""

    said: PlannedRecord
    kind: Kind
    terms: Mapping[str, Term]  # By the word of its setting
    coefficient: float

    @property
    def all_terms(self) -> tuple[Term, ...]:
        """Terms in their order."""
        return tuple(self.terms.values())

    @property
    def interval(self) -> float:
        """From sample to sample [s]."""
        return 1.0 / self.said.sample_rate


def plan_allan(**settings: Any) -> TestPlan:
    """Plan a record of a sensor at rest.

    Parameters
    ----------
    **settings
        Those of ``plan allan``, quantities as text with a unit: ``wanted`` (a mapping), ``noise``, ``instability``, ...

    Returns
    -------
    TestPlan
        Printable; ``.figures``, ``.time``, ``.rows``, ``.remarks``.

    Raises
    ------
    UsageError
        If a setting is wrong.
    """
    return planned(settings, options=False)


def planned(given: Mapping[str, Any], options: bool = True) -> TestPlan:
    """Return the plan that settings give, as text with units; messages speak of options, or of arguments of Python."""
    said, words = shared.settings_said(PlannedRecord, given, options)
    try:
        known = known_of(said, words)
        there = dict.fromkeys(known.terms, ("1", "10 %"))
        return _planned(known, shared.targets(words["wanted"], said.wanted, there))
    except DataError as error:
        raise shared.refused(error) from error


def known_of(said: PlannedRecord, words: Mapping[str, str]) -> Known:
    texts = {name: text for name in KINDS if (text := getattr(said, name)) is not None}
    terms: dict[str, Term] = {}
    kind: Kind = "gyro"
    if said.noise_file is not None:
        if texts:
            what = f"{words['noise_file']} and {words[next(iter(texts))]} both say the noise"
            raise UsageError(what, do="Give one of them", code="wrong_value")
        kind, terms = _from_file(said.noise_file, said.axis, words["axis"])
    elif not texts:
        raise UsageError("no noise", do="Give the white noise, and what else is known", code="missing_key")
    else:
        first, text = next(iter(texts.items()))
        kind = "gyro"
        try:
            parse_quantity(text).to(parameter_unit(KINDS[first].name, "coefficient", "m/s^2"))
            kind = "accelerometer"
        except DataError:
            pass
        for name, text in texts.items():
            unit = parameter_unit(KINDS[name].name, "coefficient", UNITS[kind])
            terms[name] = KINDS[name](shared.quantity(words[name], text, unit, SIZES[kind][name]))
    unit, example = f"{UNITS[kind]}/degC", {"gyro": "3e-3 deg/s/degC", "accelerometer": "50 ug/degC"}[kind]
    coefficient = 0.0
    if said.coefficient is not None:
        coefficient = shared.quantity(words["coefficient"], said.coefficient, unit, example)
    elif said.room:
        what = f"{words['room']} acts on a temperature coefficient that is not given"
        raise UsageError(what, do=f'Give {words["coefficient"]} "{example}"', code="missing_key")
    return Known(said, kind, terms, coefficient)


def _from_file(path: Path, axis: str | None, word: str) -> tuple[Kind, dict[str, Term]]:
    """Return kind of sensor and terms of one axis of a file."""
    loaded, where = load(path, document=True), str(path)
    try:
        rows = [Row.from_dict(row) for row in json.loads(loaded.data)["results"]]
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        raise DataError("not output of allan --json or run", where, do=MAKE, code="schema") from None
    found: dict[tuple[Kind, str], dict[str, Term]] = {}
    for row in rows:
        for kind, unit in UNITS.items():
            for name, term in KINDS.items():
                if row.key.quantity != quantity_name(term.name, "coefficient", kind) or row.status != "estimated":
                    continue
                try:
                    size = abs(row.value or 0.0) * factor(row.unit, parameter_unit(term.name, "coefficient", unit))
                except DataError:
                    continue  # of the other kind of sensor
                if row.case.plain and size > 0.0:
                    found.setdefault((kind, row.axis), {}).setdefault(name, term(size))
    if not found:
        raise DataError("no estimated noise term", where, do=MAKE, code="no_noise")
    axes = sorted({one for _, one in found})
    if (len(axes) > 1) if axis is None else (axis not in axes):
        what = f"no noise of axis {axis!r}" if axis else f"noise of {len(axes)} axes"
        raise DataError(what, where, do=f"Give {word} one of: {', '.join(axes)}", code="axis")
    kind, chosen = next((kind, one) for (kind, at), one in found.items() if at == (axis or axes[0]))
    return kind, chosen


def _planned(known: Known, wanted: Mapping[str, tuple[float, str]]) -> TestPlan:
    said = known.said
    count = math.floor(math.log(LONGEST / SHORTEST, FINER)) + 1
    designs = [one for k in range(count) if (one := _design(known, wanted, SHORTEST * FINER**k)) is not None]
    if said.available is not None:
        inside = _design(known, wanted, said.available)
        designs += [] if inside is None else [inside]
    if not designs:
        raise UsageError("no record that can be looked at has enough samples", do="Sample faster", code="too_short")
    chosen, front, remarks = shared.choose(designs, said.available)
    named = _named(known, wanted, chosen.time)
    if named > chosen.time:
        longer = [one for one in front if one.time >= named * (1.0 - 1e-9)]
        if longer and (said.available is None or longer[0].time <= said.available):
            chosen = longer[0]
        else:
            what = (
                f"in {shared.hours(chosen.time)} a term that is wanted is not named among all terms in 95 % of records"
            )
            do = f"Record {shared.hours(named)}" if math.isfinite(named) else "Name the terms to fit"
            remarks.append(Remark("not_named", "warning", what, do=do))
    after, found = _checked(known, chosen)
    remarks += [*found, *_remarks(known)]
    if said.schedule is not None:
        notes = ("allan: one record at rest, temperature held",)
        row = ("at rest", "still", "1", "0", f"{chosen.time:.1f}", f"{chosen.time:.1f}", f"{said.sample_rate:.9g}",
               "Set the unit down on something heavy, let it warm up, and leave the room")  # fmt: skip
        shared.write_schedule(said.schedule, HEADS, [row], notes)
    return TestPlan(WORD, after, shared.adopted(front, chosen, after), _steps(known, chosen), said.schedule or "",
                    tuple(remarks))  # fmt: skip


HEADS = ("name", "recording", "power_up", "start [s]", "stop [s]", "duration [s]", "sample_rate [Hz]", "prompt")


def _design(known: Known, wanted: Mapping[str, tuple[float, str]], time: float) -> Design | None:
    """Return a record of a length; None where it is too short for so many terms."""
    errors = _errors(known, time, known.interval)
    if errors is None:
        return None
    figures = []
    for name, (error, hidden) in errors.items():
        u, shown = wanted.get(name, (None, "%"))
        parts = [Part("length of the record", error, LONGER)]
        parts += [Part("terms not yet seen", hidden, LONGER)] if hidden else []
        if known.said.room:
            deviation, _ = _read_at(known, name, time)
            parts.append(Part("temperature of the room",
                              SECOND_ORDER * (known.coefficient * known.said.room / deviation) ** 2))  # fmt: skip
        if known.said.u_scale:
            parts.append(Part("scale factor", known.said.u_scale))
        figures.append(Figure(Key(name), "1", shown, tuple(parts), u))
    return Design(time, {"record": shared.hours(time), "samples": f"{number(known.said.sample_rate, 4)} Hz"},
                  tuple(figures))  # fmt: skip


def _errors(known: Known, time: float, interval: float) -> dict[str, tuple[float, float]] | None:
    """Return for each term its relative error, and what terms do to it that the record does not show yet.

    The test leaves a term out that it cannot tell: the others then hold part of it.
    """
    try:
        whole = relative_errors(known.all_terms, time, interval, None)
    except DataError:
        return None
    found = {name: (float(error), 0.0) for name, error in zip(known.terms, whole, strict=True)}
    kept = {name: term for name, term in known.terms.items() if found[name][0] <= SHOWN}
    if kept and len(kept) < len(known.terms):
        n = int(time / interval + 1e-9)
        m, phase = octaves(n), total_phase(known.all_terms, interval)
        mean = variance_of_phase(phase, m)
        edf = np.minimum(model_edf(mean, covariance_of_allan(phase, m, n - 2.0 * m + 1.0)), NOISE_EDF * n / m)
        root = np.sqrt(0.5 * edf) / mean
        slopes = np.stack([2.0 * variance_of_phase(total_phase((one,), interval), m) for one in kept.values()], axis=1)
        lost = tuple(one for name, one in known.terms.items() if name not in kept)
        change = np.linalg.lstsq(slopes * root[:, None], variance_of_phase(total_phase(lost, interval), m) * root,
                                 rcond=None)[0]  # fmt: skip
        errors = relative_errors(tuple(kept.values()), time, interval, None)
        found |= {name: (float(u), abs(float(c))) for name, u, c in zip(kept, errors, change, strict=True)}
    return found


def _named(known: Known, wanted: Mapping[str, tuple[float, str]], time: float) -> float:
    """Return the record in which all wanted terms are named in 95 % of cases, that length or longer [s]."""
    longest = time
    for name in wanted:
        own = time
        while separation(known.all_terms, known.terms[name].name, own, known.interval, None) < 0.0:
            own *= FINER**2
            if own > LONGEST:
                return math.inf
        longest = max(longest, own)
    return longest


def _read_at(known: Known, name: str, time: float) -> tuple[float, float]:
    """Return the Allan deviation where a record shows a term best, and the averaging time there [s]."""
    m = octaves(int(time * known.said.sample_rate))
    whole = variance_of_phase(total_phase(known.all_terms, known.interval), m)
    own = variance_of_phase(total_phase((known.terms[name],), known.interval), m)
    at = int(np.argmax(own / whole * (1.0 - 1e-6 * np.arange(len(m)))))
    return float(np.sqrt(own[at])), float(m[at] * known.interval)


def _checked(known: Known, design: Design) -> tuple[Design, list[Remark]]:
    """Return a record beside simulated ones, of fewer samples where it has more than can be drawn."""
    n = int(design.time * known.said.sample_rate)
    interval = known.interval if n <= MOST else design.time / MOST
    coarse = _errors(known, design.time, interval) or {}
    alike = [
        figure
        for figure in design.figures
        if figure.u <= SHOWN and abs(coarse[figure.key.quantity][0] / figure.parts[0].u - 1.0) < ALIKE
    ]

    def test(rng: np.random.Generator) -> dict[Key, tuple[Array, Array]]:
        plan = Plan(kind=known.kind, unit=UNITS[known.kind])
        truth = Truth({"x": known.all_terms}, min(n, MOST), interval)
        found = reduce(plan, simulate(plan, truth, rng)).estimate
        made: dict[Key, tuple[Array, Array]] = {}
        for figure in alike:
            term = known.terms[figure.key.quantity]
            key = Key(quantity_name(term.name, "coefficient", known.kind), "x")
            if found is not None and key in found.keys:
                at, size = found.keys.index(key), term.coefficient  # type: ignore[union-attr]
                made[figure.key] = (found.values[[at]] / size - 1.0, found.u[[at]] / size)
        return made

    of_length = Design(design.time, design.choice, tuple(
        replace(one, parts=tuple(part for part in one.parts if part.remedy)) for one in design.figures
    ))  # fmt: skip
    made, remarks = shared.checked(of_length, known.said.simulate, test, UNSEEN)
    simulated = {one.key: one.simulated for one in made.figures if one.simulated is not None}
    if interval > known.interval and simulated:
        what = f"simulated records have {number(1.0 / interval, 3)} Hz:"
        what += " terms that this leaves less well known are not shown"
        remarks.append(Remark("simulated_slower", "info", what))
    return shared.with_simulated(design, simulated), remarks


def _steps(known: Known, design: Design) -> Table:
    """Return where each term is read, how often that is in the record, and how steady the temperature must be."""
    rows = []
    for figure in design.figures:
        deviation, tau = _read_at(known, figure.key.quantity, design.time)
        goal = figure.wanted or figure.u
        steady = "-"
        if known.coefficient:
            steady = f"{uncertainty(deviation * math.sqrt(goal) / known.coefficient)} K"
        rows.append((figure.name, f"{number(tau, 3)} s", number(design.time / tau, 3), steady))
    heads = ("term", "read at", "of them in the record", "temperature steady to")
    return Table(heads, rows, "where each term is seen best; temperature: Allan deviation there", (1, 2, 3))


def _remarks(known: Known) -> Iterator[Remark]:
    said = known.said
    if said.cut_off is not None and said.sample_rate < 2.0 * said.cut_off:
        much = math.sqrt(2.0 * said.cut_off / said.sample_rate)
        what = (
            f"noise up to {number(said.cut_off, 4)} Hz folds into {number(0.5 * said.sample_rate, 4)} Hz: white noise"
        )
        what += f" is read {number(much, 3)} times too large, however long the record is"
        do = f"Sample at {number(2.5 * said.cut_off, 3)} Hz or faster, or record means"
        yield Remark("aliased", "error", what, do=do)
    if not known.coefficient and {"instability", "walk"} & set(known.terms):
        what = "temperature that wanders is read as slow noise; how steady it has to be is not known"
        do = "Give the temperature coefficient of the bias"
        yield Remark("no_coefficient", "info", what, do=do)
    yield from shared.exact({"scale factor": said.u_scale})


__all__ = ["plan_allan", "planned"]

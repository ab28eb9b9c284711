"""A simulated campaign reduced without files: the campaign file read from its text, the recordings from memory.

Everything after reading is done by the functions that do it for files. A test holds both ways to the same figures.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

from ..core.influence import Standards
from ..core.recording import Recording
from ..core.results import Row
from ..procedures.flip import reduction as flip
from ..procedures.flip.recordings import readings_from as flip_readings
from ..procedures.mass_attraction import reduction as mass_attraction
from ..procedures.positions import reduction as positions
from ..procedures.rate_table import reduction as rate_table
from ..procedures.rate_table.recordings import Turned
from ..procedures.rate_table.recordings import readings_from as rate_table_readings
from ..procedures.static_noise import reduction as static_noise
from ..procedures.thermal import reduction as thermal
from ..procedures.thermal.against import offset_rows, quantity_of
from ..procedures.thermal.recordings import readings_from as thermal_readings
from ..rigs.protocol import SEED, Twin
from ..sensors.chain.converter import Chain
from .after import Bias, without_bias
from .channels import chain_of, in_body_axes
from .flip_inputs import flip_plan, turned_head
from .ground import ChainModel, chain_model
from .ground_checks import WITH_MODEL
from .mass_inputs import mass_plan, moved_mass
from .noise_inputs import noise_plan, records_at_rest
from .positions_inputs import Part, positions_plan, readings_of
from .positions_result import OfSensor
from .positions_words import Section
from .rate_table_inputs import rate_table_plan
from .schema import CampaignFile, Test
from .schema_recordings import RecordingEntry
from .schema_sensors import Sensor
from .schema_standards import STANDARDS
from .thermal_inputs import felt_in_body, thermal_plan, warmed_recording

Result = rate_table.Result | flip.Result | thermal.Result | static_noise.Result | mass_attraction.Result | OfSensor
Plan = rate_table.Plan | flip.Plan | thermal.Plan | static_noise.Plan | mass_attraction.Plan | positions.Plan
Placed = Sequence[tuple[str, RecordingEntry, Recording]]


@dataclass(frozen=True, eq=False)
class _Fit:
    """A test with ``use = "fit"``, ready for recordings."""

    procedure: str
    plan: Plan
    sensor: Sensor
    entries: tuple[tuple[str, RecordingEntry, Chain | None], ...]
    model: ChainModel | None = None
    test: str = ""
    against: str = ""
    after: str = ""
    condition: str = ""
    sensors: tuple[Sensor, ...] = ()


@dataclass(frozen=True, eq=False)
class Fitted:
    """A test with ``use = "fit"`` that was reduced.

    Parameters
    ----------
    test : str
        Its name.
    result : Result
        SI.
    rows : tuple of Row or None
        Of a thermal test, those against another with them; None where the estimate says all.
    """

    test: str
    result: Result
    rows: tuple[Row, ...] | None = None


def fitted_tests(twin: Twin) -> list[Fitted]:
    """Return the tests of a twin with ``use = "fit"``, reduced.

    Raises
    ------
    DataError
        As the chain and the procedure say, where the twin has a fault.
    """
    fits = _fits(twin.campaign)
    results = _results(twin, fits)
    return [Fitted(fit.test, results[fit.test], _rows(fit, results)) for fit in fits]


def _results(twin: Twin, fits: Sequence[_Fit]) -> dict[str, Result]:
    """Return the results by test, in the order of the tests; what a test comes after is reduced first."""
    found: dict[str, Result] = {}
    for fit in sorted(fits, key=lambda one: bool(one.after)):
        found[fit.test] = _result(twin, fit, found)
    return {fit.test: found[fit.test] for fit in fits}


def _rows(fit: _Fit, results: Mapping[str, Result]) -> tuple[Row, ...] | None:
    result, other = results[fit.test], results.get(fit.against)
    if not isinstance(result, thermal.Result):
        return None
    more = []
    if isinstance(other, thermal.Result):
        more = offset_rows(result, other, fit.against, quantity_of(fit.condition))
    return (*result.rows(), *more)


def fit_results(twin: Twin) -> list[Result]:
    """Return the results of the tests of a twin with ``use = "fit"``.

    Raises
    ------
    DataError
        As the chain and the procedure say, where the twin has a fault.
    """
    return list(_results(twin, _fits(twin.campaign)).values())


@lru_cache(4)
def _fits(text: str) -> tuple[_Fit, ...]:
    """Read the campaign file, which all seeds of a rig may share."""
    file = CampaignFile.model_validate(tomllib.loads(text.replace(SEED, "0")))
    standards = {
        f"{standard}.{name}": entry.influence(STANDARDS[standard][name])
        for standard, quantities in file.standards.items()
        for name, entry in quantities.items()
    }
    tests = [test for test in file.tests if test.use == "fit"]
    return tuple(
        replace(
            _fit(file, standards, test),
            test=test.id,
            against=test.against or "",
            after="".join(test.after),
            condition=test.condition,
        )
        for test in tests
    )


def _fit(file: CampaignFile, standards: Standards, test: Test) -> _Fit:
    named = {name: file.recordings[name] for name in test.recordings}
    sensor = file.sensors[named[test.recordings[0]].sensor]
    entries = tuple((name, entry, chain_of(entry, sensor)) for name, entry in named.items())
    if test.procedure == "flip":
        return _Fit(test.procedure, flip_plan(test, standards), sensor, entries, chain_model(sensor))
    if test.procedure == "thermal":
        return _Fit(test.procedure, thermal_plan(file, standards, test, sensor), sensor, entries)
    if test.procedure == "mass_attraction":
        return _Fit(test.procedure, mass_plan(test, sensor, standards), sensor, entries)
    if test.procedure == "positions":
        own = tuple(file.sensors[entry.sensor] for entry in named.values())
        chains = tuple((n, e, chain_of(e, one)) for (n, e), one in zip(named.items(), own, strict=True))
        return _Fit(test.procedure, positions_plan(file, standards, test), sensor, chains, sensors=own)
    if test.procedure == "static_noise":
        return _Fit(test.procedure, noise_plan(test, sensor, standards), sensor, entries, chain_model(sensor))
    return _Fit(test.procedure, rate_table_plan(file, standards, test, sensor), sensor, entries)


def _result(twin: Twin, fit: _Fit, found: Mapping[str, Result]) -> Result:
    if isinstance(fit.plan, thermal.Plan):
        return _thermal(twin, fit.plan, fit)
    if isinstance(fit.plan, mass_attraction.Plan):
        return _mass_attraction(twin, fit.plan, fit)
    if isinstance(fit.plan, positions.Plan):
        return _positions(twin, fit.plan, fit)
    corrected = isinstance(fit.plan, flip.Plan) and fit.plan.corrected
    keep_bias = fit.procedure in WITH_MODEL and not corrected
    placed = [
        (name, entry, in_body_axes(twin.recordings[entry.file], name, entry, fit.sensor, chain, fit.model, keep_bias))
        for name, entry, chain in fit.entries
    ]
    before = found.get(fit.after)
    if isinstance(fit.plan, rate_table.Plan) and isinstance(before, thermal.Result):
        felt = [(name, entry, felt_in_body(body, entry, fit.sensor)) for name, entry, body in placed]
        return _rate_table(fit.plan, felt, Bias(fit.after, before))
    return REDUCED[fit.procedure](fit.plan, placed)


def _rate_table(plan: rate_table.Plan, placed: Placed, bias: Bias | None = None) -> rate_table.Result:
    turned = [Turned(body, entry.axis or "", entry.run or "", name=name) for name, entry, body in placed]
    if bias is not None:
        turned = without_bias(turned, bias)
    return rate_table.reduce(plan, rate_table_readings(plan, turned))


def _flip(plan: flip.Plan, placed: Placed) -> flip.Result:
    return flip.reduce(plan, flip_readings(plan, [turned_head(body, name, entry) for name, entry, body in placed]))


def _thermal(twin: Twin, plan: thermal.Plan, fit: _Fit) -> thermal.Result:
    raw = {name: twin.recordings[entry.file] for name, entry, _ in fit.entries}
    warmed = [warmed_recording(raw[name], name, entry, fit.sensor, chain) for name, entry, chain in fit.entries]
    return thermal.reduce(plan, thermal_readings(warmed))


def _mass_attraction(twin: Twin, plan: mass_attraction.Plan, fit: _Fit) -> mass_attraction.Result:
    schedules = {file: mass_attraction.Schedule(**vars(one)) for file, one in twin.schedules.items()}
    moved = [
        moved_mass(twin.recordings[entry.file], name, entry, fit.sensor, chain, schedules[entry.mass.schedule])
        for name, entry, chain in fit.entries
        if entry.mass is not None
    ]
    return mass_attraction.reduce(plan, mass_attraction.readings_from(plan, moved))


def _positions(twin: Twin, plan: positions.Plan, fit: _Fit) -> OfSensor:
    parts = []
    for (name, entry, chain), sensor in zip(fit.entries, fit.sensors, strict=True):
        body = in_body_axes(twin.recordings[entry.file], name, entry, sensor, chain)
        parts.append(Part(name, entry, body, len(body), sensor.kind))
    said = {file: [Section(**vars(one)) for one in named] for file, named in twin.protocols.items()}
    readings = readings_of(plan, parts, fit.test, Path(), said)
    return OfSensor(positions.reduce(plan, readings), fit.sensor.kind)


def _static_noise(plan: static_noise.Plan, placed: Placed) -> static_noise.Result:
    found = [records_at_rest(body, name, "")[0] for name, _, body in placed]
    return static_noise.reduce(plan, static_noise.readings_from(plan, found))


REDUCED: dict[str, Callable[..., Result]] = {
    "rate_table": _rate_table,
    "flip": _flip,
    "static_noise": _static_noise,
}

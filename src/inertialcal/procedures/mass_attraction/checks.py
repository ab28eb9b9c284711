"""What is judged before anything is reduced: whether a mass can attract so much, whether runs have whole cycles."""

from __future__ import annotations

from collections.abc import Iterator

from ...core.constants import GRAVITATIONAL_CONSTANT
from ...core.errors import DataError
from ...core.remarks import Remark
from ...physics.mass_shape.bound import largest_field
from .plan import Plan, SourceMass
from .readings import Readings, Run
from .response.of_run import tilt_used

LIGHTEST, DENSEST = 10.0, 23_000.0  # of materials [kg/m^3]


def check_source(source: SourceMass, run: Run) -> None:
    """Refuse a schedule that applies more than a mass can, or a mass that cannot be.

    Raises
    ------
    DataError
        ``overlap`` if the mass would stand where the instrument is, ``absurd_density``, ``too_attractive``.
    """
    if not source.stand_off > 0.0:
        what = f"stand-off {source.stand_off:g} m: the mass would overlap the instrument"
        do = "Give the distance from the proof mass to the nearest face of the mass"
        raise DataError(what, "plan.source.stand_off", do=do, code="overlap")
    if not LIGHTEST <= source.density <= DENSEST:
        what = f"density {source.density:g} kg/m^3: materials lie between {LIGHTEST:g} and {DENSEST:g} kg/m^3"
        raise DataError(what, "plan.source.density", do="Lead is 11340 kg/m^3", code="absurd_density")
    most = GRAVITATIONAL_CONSTANT.value * largest_field(source.mass, source.density, source.stand_off).field
    change = 2.0 * run.schedule.amplitude
    if change > most:
        what = (
            f"{run.name}: the schedule changes the attraction by {change:.4g} m/s^2, {source.mass:.4g} kg at"
            f" {source.stand_off:g} m cannot attract more than {most:.4g} m/s^2 in any shape"
        )
        do = "Look at the units of position and applied (cm for m?), and at plan.source"
        raise DataError(what, run.where, "nothing moved attracts more than it does where it is nearest", do,
                        "too_attractive")  # fmt: skip


def series_remarks(plan: Plan, readings: Readings) -> Iterator[Remark]:
    """Yield what is to be said of runs before they are reduced."""
    for run in readings.series:
        per_cycle = run.schedule.samples_per_cycle
        if len(run.schedule) % per_cycle:
            what = f"runs of {len(run.schedule)} dwells are no whole number of cycles of {per_cycle}"
            do = "The regression allows for it; the published way of reduction does not, and is left out"
            yield Remark("not_whole_cycles", "warning", what, run.where, do=do)
        lost = len(run.schedule) - run.there
        if lost:
            what = f"{run.name}: {lost} dwell(s) of the schedule have no reading; they stay gaps"
            yield Remark("missing_dwells", "info", what, run.where)
        if plan.tilt != "ignored":
            yield from _tilt(plan, run)


def _tilt(plan: Plan, run: Run) -> Iterator[Remark]:
    if tilt_used(plan, run) != "ignored":
        return
    if plan.tilt == "known" and not plan.nominal and run.tilt is not None:
        what = f'{run.name}: tilt = "known" needs the nominal scale factor of the chain; tilt was not taken off'
        yield Remark("missing_tilt", "warning", what, run.where, do='Say it, or tilt = "regressed"')
        return
    what = f"{run.name}: no tilt of the pad was read, and none is taken off"
    do = 'State [standards.pad] tilt for what it may do, or say tilt = "ignored"'
    yield Remark("missing_tilt", "warning", what, run.where, do=do)

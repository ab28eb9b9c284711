"""inertialcal: from raw counts to a calibration that can be trusted.

>>> import inertialcal as ic
>>> recording = ic.read("imu.csv")  # doctest: +SKIP
>>> ic.rate_table("table10.csv", axis="x").rows  # doctest: +SKIP
>>> ic.run("campaign/").verdict  # doctest: +SKIP

Names are loaded when first used, so that importing the package costs nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from .core.figure import draw_with as _draw_with

if TYPE_CHECKING:
    __version__: str
    from .archive import open_archive
    from .campaign.calls.call import Reduced
    from .campaign.calls.nouns import (
        alignment,
        allan,
        flip,
        heads,
        magnetometer_bias,
        mass_attraction,
        microgravity,
        positions,
        psd,
        rate_table,
        sensitivity,
        shifted_model,
        sine,
        thermal,
        turned_mass,
        vibration,
        vibration_effects,
        vibration_survey,
    )
    from .campaign.certificate.issue import certificate
    from .campaign.certificate.reading import read_certificate
    from .campaign.compare.compare import compare
    from .campaign.engine.run import Outcome, run
    from .campaign.engine.whole import check
    from .campaign.models.compensation import compensate
    from .campaign.models.find import load_model, load_models
    from .campaign.outcome.budget import budget
    from .campaign.start.info import info
    from .campaign.twins.twin import simulate
    from .core.errors import DataError, InertialcalError, PlanError, Problem, StoreError, UsageError
    from .core.estimate import Component, Estimate
    from .core.recording import Channel, Recording
    from .core.remarks import Remark
    from .core.results import Interval, Row
    from .core.units import Quantity
    from .files import read
    from .files.budget import max_memory
    from .files.info.survey import Survey
    from .files.text.table import Table, read_table
    from .files.write.recording import write
    from .lab.guide.engine import Guide
    from .lots.lot import lot
    from .lots.score import score
    from .procedures.flip.planning import plan_flip
    from .procedures.magnetometer_bias.planning import plan_magnetometer_bias
    from .procedures.mass_attraction.planning.planner import plan_mass_attraction
    from .procedures.mass_attraction.recorded_series import programme_1969
    from .procedures.positions.batch import positions_batch
    from .procedures.positions.planning.planner import plan_positions
    from .procedures.rate_table.planning import plan_rate_table
    from .procedures.sine_survey.planning import plan_vibration_survey
    from .procedures.static_noise.planning.planner import plan_allan
    from .procedures.thermal.planning import plan_thermal
    from .procedures.turned_mass.planning import plan_turned_mass
    from .procedures.vibration.planning import plan_vibration
    from .procedures.vibration.profile_table import vibration_profile
    from .report.plot import plot
    from .sensors.model.model_set import ModelSet
    from .sensors.model.sensor_model import SensorModel

__all__ = [
    "Channel",
    "Component",
    "DataError",
    "Estimate",
    "Guide",
    "InertialcalError",
    "Interval",
    "ModelSet",
    "Outcome",
    "PlanError",
    "Problem",
    "Quantity",
    "Recording",
    "Reduced",
    "Remark",
    "Row",
    "SensorModel",
    "StoreError",
    "Survey",
    "Table",
    "UsageError",
    "alignment",
    "allan",
    "budget",
    "certificate",
    "check",
    "compare",
    "compensate",
    "flip",
    "heads",
    "info",
    "load_model",
    "load_models",
    "lot",
    "magnetometer_bias",
    "mass_attraction",
    "max_memory",
    "microgravity",
    "open_archive",
    "plan_allan",
    "plan_flip",
    "plan_magnetometer_bias",
    "plan_mass_attraction",
    "plan_positions",
    "plan_rate_table",
    "plan_thermal",
    "plan_turned_mass",
    "plan_vibration",
    "plan_vibration_survey",
    "plot",
    "positions",
    "positions_batch",
    "programme_1969",
    "psd",
    "rate_table",
    "read",
    "read_certificate",
    "read_table",
    "run",
    "score",
    "sensitivity",
    "shifted_model",
    "simulate",
    "sine",
    "thermal",
    "turned_mass",
    "vibration",
    "vibration_effects",
    "vibration_profile",
    "vibration_survey",
    "write",
]

_HOMES = {  # nouns of procedures apart, which are found by their commands
    name: module
    for module, words in {
        "archive": "open_archive",
        "campaign.calls.call": "Reduced",
        "campaign.certificate.issue": "certificate",
        "campaign.certificate.reading": "read_certificate",
        "campaign.compare.compare": "compare",
        "campaign.engine.run": "Outcome run",
        "campaign.engine.whole": "check",
        "campaign.models.compensation": "compensate",
        "campaign.models.find": "load_model load_models",
        "campaign.outcome.budget": "budget",
        "campaign.start.info": "info",
        "campaign.twins.twin": "simulate",
        "core.errors": "DataError InertialcalError PlanError Problem StoreError UsageError",
        "core.estimate": "Component Estimate",
        "core.recording": "Channel Recording",
        "core.remarks": "Remark",
        "core.results": "Interval Row",
        "core.units": "Quantity",
        "files": "read",
        "files.budget": "max_memory",
        "files.info.survey": "Survey",
        "files.text.table": "Table read_table",
        "files.write.recording": "write",
        "lab.guide.engine": "Guide",
        "lots.lot": "lot",
        "lots.score": "score",
        "procedures.mass_attraction.planning.planner": "plan_mass_attraction",
        "procedures.mass_attraction.recorded_series": "programme_1969",
        "procedures.positions.batch": "positions_batch",
        "procedures.positions.planning.planner": "plan_positions",
        "procedures.sine_survey.planning": "plan_vibration_survey",
        "procedures.static_noise.planning.planner": "plan_allan",
        "procedures.flip.planning": "plan_flip",
        "procedures.rate_table.planning": "plan_rate_table",
        "procedures.magnetometer_bias.planning": "plan_magnetometer_bias",
        "procedures.thermal.planning": "plan_thermal",
        "procedures.turned_mass.planning": "plan_turned_mass",
        "procedures.vibration.planning": "plan_vibration",
        "procedures.vibration.profile_table": "vibration_profile",
        "report.plot": "plot",
        "sensors.model.model_set": "ModelSet",
        "sensors.model.sensor_model": "SensorModel",
    }.items()
    for name in words.split()
}


def _markup(result: object) -> str:
    """Draw a result for a notebook: what lies above the report in the house cannot."""
    from .report.plot import markup  # noqa: PLC0415 - draws, which starts slowly

    return markup(result)


_draw_with(_markup)


if not TYPE_CHECKING:  # names that are not there are told by a type checker

    def __getattr__(name: str) -> object:
        """Load a public name on first use (PEP 562)."""
        if name == "__version__":
            from importlib.metadata import version  # noqa: PLC0415 - starts slowly

            return version("inertialcal")
        if name not in _HOMES and name not in _nouns():
            raise AttributeError(f"module 'inertialcal' has no attribute {name!r}")
        return getattr(import_module(f".{_HOMES.get(name, 'campaign.calls.nouns')}", __name__), name)


def _nouns() -> set[str]:
    """Return the nouns of all procedures, those of other packages too, as functions are called."""
    from .procedures import procedure_names, procedure_of  # noqa: PLC0415

    return {one.function for name in procedure_names() for one in procedure_of(name).commands}


def __dir__() -> list[str]:
    return sorted([*__all__, "__all__", "__doc__", "__file__", "__name__", "__path__", "__version__"])

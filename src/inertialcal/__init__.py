"""inertialcal: from raw counts to a calibration that can be trusted.

>>> import inertialcal as ic
>>> recording = ic.read("imu.csv")  # doctest: +SKIP
>>> ic.rate_table("table10.csv", axis="x").rows  # doctest: +SKIP
>>> ic.run("campaign/").verdict  # doctest: +SKIP

Names are loaded when first used, so that importing the package costs nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .campaign.calls.nouns import allan, flip, mass_attraction, positions, psd, rate_table, sine, thermal
    from .campaign.certificate.issue import certificate
    from .campaign.certificate.reading import read_certificate
    from .campaign.compare.compare import compare
    from .campaign.engine.run import run
    from .campaign.engine.whole import check
    from .campaign.models.compensation import compensate
    from .campaign.models.find import load_model, load_models
    from .campaign.outcome.budget import budget
    from .campaign.start.info import info
    from .campaign.twins.score import score
    from .campaign.twins.twin import simulate
    from .files import read
    from .files.budget import max_memory
    from .files.text.table import read_table
    from .files.write.recording import write
    from .procedures.mass_attraction.planning.planner import plan_mass_attraction
    from .procedures.mass_attraction.recorded_series import programme_1969
    from .procedures.positions.batch import positions_batch
    from .procedures.positions.planning.planner import plan_positions
    from .report.plot import plot

__all__ = [
    "allan",
    "budget",
    "certificate",
    "check",
    "compare",
    "compensate",
    "flip",
    "info",
    "load_model",
    "load_models",
    "mass_attraction",
    "max_memory",
    "plan_mass_attraction",
    "plan_positions",
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
    "simulate",
    "sine",
    "thermal",
    "write",
]

_HOMES = {
    "allan": ("campaign.calls.nouns", "allan"),
    "psd": ("campaign.calls.nouns", "psd"),
    "budget": ("campaign.outcome.budget", "budget"),
    "certificate": ("campaign.certificate.issue", "certificate"),
    "read_certificate": ("campaign.certificate.reading", "read_certificate"),
    "check": ("campaign.engine.whole", "check"),
    "compare": ("campaign.compare.compare", "compare"),
    "compensate": ("campaign.models.compensation", "compensate"),
    "load_model": ("campaign.models.find", "load_model"),
    "load_models": ("campaign.models.find", "load_models"),
    "plan_mass_attraction": ("procedures.mass_attraction.planning.planner", "plan_mass_attraction"),
    "plan_positions": ("procedures.positions.planning.planner", "plan_positions"),
    "plot": ("report.plot", "plot"),
    "programme_1969": ("procedures.mass_attraction.recorded_series", "programme_1969"),
    "positions": ("campaign.calls.nouns", "positions"),
    "positions_batch": ("procedures.positions.batch", "positions_batch"),
    "score": ("campaign.twins.score", "score"),
    "simulate": ("campaign.twins.twin", "simulate"),
    "write": ("files.write.recording", "write"),
    "info": ("campaign.start.info", "info"),
    "read": ("files", "read"),
    "max_memory": ("files.budget", "max_memory"),
    "read_table": ("files.text.table", "read_table"),
    "run": ("campaign.engine.run", "run"),
}


def __getattr__(name: str) -> Any:
    """Load a public name on first use (PEP 562)."""
    if name == "__version__":
        from importlib.metadata import version  # noqa: PLC0415 - starts slowly

        return version("inertialcal")
    if name not in _HOMES and name not in _nouns():
        raise AttributeError(f"module 'inertialcal' has no attribute {name!r}")
    module, attribute = _HOMES.get(name, ("campaign.calls.nouns", name))
    return getattr(import_module(f".{module}", __name__), attribute)


def _nouns() -> set[str]:
    """Return the nouns of all procedures, those of other packages too, as functions are called."""
    from .procedures import procedure_names, procedure_of  # noqa: PLC0415

    words = (one.word for name in procedure_names() for one in procedure_of(name).commands)
    return {word.replace("-", "_") for word in words}


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])

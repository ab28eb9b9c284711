"""Plan of a test: the ``plan`` table of the campaign file, read into the dataclass of its procedure.

The settings of the procedure's ``Plan`` are the schema: their types, units and limits say what may stand there.
Fields that come from the sensor or the standards cannot be set in ``plan``.
"""

from __future__ import annotations

from typing import Any

from ...core.errors import Problem
from ...core.schema.settings import settings_values
from ...procedures import procedure_of


def plan_values(procedure: str, given: dict[str, Any], where: str) -> tuple[dict[str, Any], list[Problem]]:
    """Return the values of a plan table, SI, and what is wrong with it.

    Parameters
    ----------
    procedure : str
        Name in the dict of procedures.
    given : dict
        The table as parsed.
    where : str
        Place of the table, for messages.
    """
    return settings_values(procedure_of(procedure).plan_type, given, lambda *_: where, "plan")

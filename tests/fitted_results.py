"""Results of the tests of a twin with ``use = "fit"``, by name or in order."""

from __future__ import annotations

from typing import Any

from inertialcal.campaign.twins.fitted import fitted_tests
from inertialcal.rigs.twin import Twin


def fit_results(twin: Twin) -> list[Any]:
    """Return the results of the tests of a twin for a fit."""
    return [one.result for one in fitted_tests(twin)]
